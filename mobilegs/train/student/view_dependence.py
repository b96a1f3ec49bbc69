"""View dependence: opacity and weight of a Gaussian as functions of the viewing direction."""

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
from mobilegs.train.student.view_dirs import basis_gram, fit_lobes_to_network
from mobilegs.validation import DEGREE, FRACTION, Range, check

KINDS = ("constant", "network", "fitted", "decoded", "latent", "projected", "free")
DECODED = (
    256,
    128,
)  # the paper's layers; its last one, 64 wide, is linear and folds into the output
LOGIT_MAX = 8.0  # larger logits of a teacher would only stretch the codebook


@dataclass(frozen=True)
class ViewDependence:
    """Representation of opacity and phi, which are functions of the viewing direction.

    | kind | opacity and phi |
    |---|---|
    | `constant` | one opacity per Gaussian, phi = 1 |
    | `network` | the paper's network, evaluated for every view |
    | `fitted` | `network` until `decoder_from`, then lobes fitted to it, as in `projected` |
    | `decoded` | lobes, decoded once by a network of the same size without the direction |
    | `free` | lobes, whose coefficients are stored |
    | `projected` | lobes, decoded by a learned linear basis from latents |
    | `latent` | as `projected`, corrected by a small network of the other attributes |

    Lobes are spherical harmonics of the direction. With `free`, `projected` and `latent` they are
    free until `decoder_from`, and the basis begins with their principal directions; if that is 0,
    the basis begins at random. With `blend=sorted` phi is not used and learns nothing.
    """

    kind: str = "latent"
    """`constant`, `network`, `fitted`, `decoded`, `latent`, `projected` or `free`."""
    degree: int = 2
    """Degree of the lobes, 0 to 3."""
    latents: int = 13
    """Values stored per Gaussian, 0 to 32, with `latent`, `projected` and `fitted`. One is the base
    opacity. The others are at most as many as a lobe has, rounded up to a multiple of
    `subvector_length`. 0 stores no base opacity: only `latent` can then tell opacities apart."""
    hidden: int = 16
    """Width of the network of `latent`, 1 to 256."""
    decoder_from: float = 0.0
    """Time at which a decoder of latents replaces lobes that are free at first, 0 to 1."""
    subvector_length: int = 2
    """Latents that share a codebook entry, 1 to 4, with `nvq`."""
    codebook_size: int = 64
    """Entries of each of these codebooks, 1 to 4096, with `nvq`."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"unknown kind '{self.kind}': use one of {', '.join(KINDS)}")
        check(
            self,
            degree=DEGREE,
            latents=Range(high=LATENTS_MAX),
            hidden=Range(1, HIDDEN_MAX),
            decoder_from=FRACTION,
            subvector_length=Range(1, 4),
            codebook_size=Range(1, SIZE_MAX),
        )
        if self.kind == "fitted" and self.decoder_from == 0:
            raise InputError("kind=fitted needs time for its network: set decoder_from above 0")
        _ = self.shape  # raises InputError if a file cannot hold it

    @property
    def base(self) -> bool:
        """True if the file stores a base opacity per Gaussian."""
        return self.kind in ("constant", "network", "decoded", "free") or self.latents > 0

    @property
    def shape(self) -> LobeShape | None:
        """Shape of the lobe decoder; None for `constant` and `network`, which have none."""
        if self.kind in ("constant", "network"):
            return None
        if self.kind == "decoded":
            return LobeShape(self.degree, 0, DECODED)
        count = 2 * (self.degree + 1) ** 2 - 1
        if self.kind != "free":
            count = min(max(0, self.latents - 1), count)
        count = -(-count // self.subvector_length) * self.subvector_length
        if count > LATENTS_MAX:
            raise InputError(
                f"{count} latents, a multiple of subvector_length {self.subvector_length}, are "
                f"more than the {LATENTS_MAX} of a file"
            )
        return LobeShape(self.degree, count, (self.hidden,) if self.kind == "latent" else ())

    @property
    def cut(self) -> Cut | None:
        """Sub-vectors of the latents' codebooks; None without latents."""
        count = self.shape.latents if self.shape else 0
        return Cut(count // self.subvector_length, self.subvector_length) if count else None


class FittedLobes(NamedTuple):
    """A lobe decoder, with the latents and base opacity logits that it decodes to given lobes."""

    decoder: LobeDecoder
    logits: Float[Tensor, "n"]
    latents: Float[Tensor, "n l"]


def fit_lobe_decoder(
    view: ViewDependence,
    gaussians: Gaussians,
    source: ViewNetwork | Float[Tensor, "n m 2"],
    cameras: list[Camera],
    *,
    regression_steps: int,
    generator: torch.Generator,
) -> FittedLobes:
    """Fit a decoder and latents to lobes, or to a network, along the directions of `cameras`."""
    assert view.shape is not None
    lobes = source
    if isinstance(lobes, ViewNetwork):
        lobes = fit_lobes_to_network(lobes, gaussians, cameras, view.degree)
    lobes = lobes.clone()
    lobes[:, 0, 0] = lobes[:, 0, 0].clamp(-LOGIT_MAX / C0, LOGIT_MAX / C0)
    logits = C0 * lobes[:, 0, 0]
    decoder = LobeDecoder(view.shape, generator).to(lobes.device)
    latents = fit_lobes(
        decoder,
        lobes,
        replace(gaussians, logit_opacities=logits),
        metric=basis_gram(gaussians, cameras, view.degree),
        base=view.base,
        rotated=view.kind != "free",
        generator=generator,
        steps=regression_steps,
    )
    return FittedLobes(decoder, logits, latents)
