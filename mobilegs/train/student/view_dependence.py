"""How a student learns what depends on the view: seven ways to the same lobes."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.compress.codebooks import SIZE_MAX, Cut
from mobilegs.compress.lobes import HIDDEN_MAX, LATENTS_MAX, LobeDecoder, LobeShape, fit_lobes
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render.view_network import ViewNetwork
from mobilegs.spherical_harmonics import C0
from mobilegs.train.student.view_dirs import fit_to_network, seen_metric

KINDS = ("constant", "network", "fitted", "decoded", "latent", "projected", "free")
DECODED = (256, 128)  # the paper's layers; its linear 64-wide one adds nothing before the output
LOGIT_MAX = 8.0  # surer opacities of a teacher would stretch the codebook for nothing


@dataclass(frozen=True)
class ViewDependence:
    """Where opacity and phi come from, and what the file stores of them.

    `constant`: an opacity per Gaussian, and phi = 1. `network`: the paper's network, asked for
    every view. `fitted`: the same until `fraction`, then lobes fitted to it, which go on as
    `projected`. `decoded`: a network of the same size and information, without the direction,
    gives lobes once. `free`, `projected` and `latent`: each Gaussian learns numbers that will be
    quantised. They are its lobes' coefficients themselves; or coordinates along directions that
    all lobes share and that learn, too; or the same with a small network that corrects them by
    the other attributes. Until `fraction` of the run lobes
    are free, and the directions begin as their principal ones; with 0 they begin random.
    """

    kind: str = "latent"
    """One of `KINDS`."""
    degree: int = 2
    """Degree of the lobes, 0 to 3."""
    latents: int = 13
    """Numbers stored per Gaussian, a base opacity among them, for `latent`, `projected` and
    `fitted`: at most as many as lobes have, and all but the base rounded up to a multiple of
    `length`. 0 stores not even that: then only `latent` can tell opacities apart."""
    hidden: int = 16
    """Width of the network of `latent`."""
    fraction: float = 0.0
    """When free lobes become latents, as a fraction of the run."""
    length: int = 2
    """With `nvq`, latents (the base aside) that share a codebook entry."""
    size: int = 64
    """Entries of each of those codebooks, with `nvq`."""
    decay: float = 0.0
    """Share of what depends on the direction that free lobes forget in a step."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(
                f"unknown view dependence '{self.kind}': use one of {', '.join(KINDS)}"
            )
        if not 0 <= self.degree <= 3:
            raise InputError(f"lobes have degree 0 to 3, not {self.degree}")
        if not 0 <= self.latents <= LATENTS_MAX:
            raise InputError(f"0 to {LATENTS_MAX} latents can be stored, not {self.latents}")
        if not 1 <= self.hidden <= HIDDEN_MAX:
            raise InputError(f"a hidden layer is 1 to {HIDDEN_MAX} wide, not {self.hidden}")
        if not (1 <= self.length <= 4 and 1 <= self.size <= SIZE_MAX):
            raise InputError(
                f"codebooks of {self.size} entries for {self.length} latents at a time: choose "
                f"up to {SIZE_MAX} entries and 1 to 4 latents"
            )
        if not (0 <= self.fraction <= 1 and 0 <= self.decay < 1):
            raise InputError(
                f"fraction and decay must lie within 0 to 1, not {self.fraction} and {self.decay}"
            )
        if self.kind == "fitted" and self.fraction == 0:
            raise InputError(
                "nothing can be fitted to a network that has not learned: set the fraction first"
            )
        if self.decay and (self.fraction == 0 or self.kind not in ("free", "projected", "latent")):
            raise InputError(
                "decay is for lobes that are free at first: set kind and fraction so before"
            )
        _ = self.shape  # refuses what cannot be stored

    @property
    def base(self) -> bool:
        """Whether a base opacity is stored."""
        return self.kind in ("constant", "network", "decoded", "free") or self.latents > 0

    @property
    def shape(self) -> LobeShape | None:
        """Of the decoder; None for constants and the network, which have none."""
        if self.kind in ("constant", "network"):
            return None
        if self.kind == "decoded":
            return LobeShape(self.degree, 0, DECODED)
        count = 2 * (self.degree + 1) ** 2 - 1
        if self.kind != "free":
            count = min(max(0, self.latents - 1), count)
        count = -(-count // self.length) * self.length
        if count > LATENTS_MAX:
            raise InputError(
                f"{count} latents, a multiple of length {self.length}, are more than the "
                f"{LATENTS_MAX} that can be stored"
            )
        return LobeShape(self.degree, count, (self.hidden,) if self.kind == "latent" else ())

    @property
    def cut(self) -> Cut | None:
        """Of the latents' codebooks; None where there are no latents."""
        count = self.shape.latents if self.shape else 0
        return Cut(count // self.length, self.length) if count else None


class Settled(NamedTuple):
    """What lobes have become: `decoder` makes them from `latents` and the opacity `logits`."""

    decoder: LobeDecoder
    logits: Float[Tensor, "n"]
    latents: Float[Tensor, "n l"]


def settled(
    view: ViewDependence,
    gaussians: Gaussians,
    source: ViewNetwork | Float[Tensor, "n m 2"],
    cameras: list[Camera],
    *,
    regression_steps: int,
    generator: torch.Generator,
) -> Settled:
    """The form that a file will hold of lobes which `source` gives, as cameras see them."""
    assert view.shape is not None
    lobes = source
    if isinstance(lobes, ViewNetwork):
        lobes = fit_to_network(lobes, gaussians, cameras, view.degree)
    lobes = lobes.clone()
    lobes[:, 0, 0] = lobes[:, 0, 0].clamp(-LOGIT_MAX / C0, LOGIT_MAX / C0)
    logits = C0 * lobes[:, 0, 0]
    decoder = LobeDecoder(view.shape, generator).to(lobes.device)
    latents = fit_lobes(
        decoder,
        lobes,
        replace(gaussians, logit_opacities=logits),
        metric=seen_metric(gaussians, cameras, view.degree),
        base=view.base,
        rotated=view.kind != "free",
        generator=generator,
        steps=regression_steps,
    )
    return Settled(decoder, logits, latents)
