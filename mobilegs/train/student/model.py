"""What the student is made of, in the three forms it takes on its way into the file."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Literal

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.func import functional_call
from torch.nn.functional import normalize, pad

from mobilegs.camera import Camera
from mobilegs.compress.appearance import ColorDecoder, ColorShape, color_decoder, fit_appearance
from mobilegs.compress.codebooks import (
    Attribute,
    CodebookSizes,
    SubVectorCodebooks,
    canonical_quats,
)
from mobilegs.compress.float16 import rounded_parameters
from mobilegs.compress.lobes import LobeDecoder
from mobilegs.compress.rotations import canonical_pairs
from mobilegs.compress.uniform_quantizer import ScalarSteps
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.encode import Codes
from mobilegs.mgs.positions import Frame
from mobilegs.render import Weighting
from mobilegs.render.lobes import constant_lobes, seen_along
from mobilegs.render.view_network import ViewNetwork
from mobilegs.spherical_harmonics import C0
from mobilegs.train.autograd_ops import take_rows
from mobilegs.train.optim import NamedAdam
from mobilegs.train.student import quantization
from mobilegs.train.student.view_dependence import LOGIT_MAX, ViewDependence, settled

Phase = Literal["explicit", "networks", "codes"]
OF_LOBES = ("explicit_lobes", "logit_opacities", "lobe_latents")


class StudentModel:
    """Gaussians whose opacity and weight depend on the direction they are seen from.

    It begins `explicit`: the tensors of 3DGS with harmonics of a low degree. With `networks` the
    harmonics become a few latent numbers that a `ColorDecoder` turns back into harmonics,
    and positions are seen rounded as the file stores them. With `codes` all but the positions
    become multiples of steps, or indices into codebooks, which go on learning, and the networks
    compute with halves: what is drawn is now what the file will hold.

    Apart from this, lobes that begin free are `settled` at some time before the codes: from
    then on a `LobeDecoder` makes them from the latents that will be coded.

    Attributes:
        rows: what is free and has a row per Gaussian, with its Adam.
        view: how the lobes come about.
        network: gives lobes for each view; None if nothing depends on it (any more).
        lobe_decoder: latents to lobes; None while they are free, or where there is a network.
        decoder: latents to harmonics; None while explicit.
        codebooks: by attribute; empty until `codes`.
        shared: the Adam of networks and codebooks.
        frame: where the stored positions lie; None while explicit.
    """

    def __init__(
        self,
        teacher: Gaussians,
        view: ViewDependence,
        rates: Mapping[str, float],
        generator: torch.Generator,
        *,
        blend: str = "sortfree",
        weighting: Weighting = Weighting(),  # noqa: B008 - frozen
        color: ColorShape = ColorShape(),  # noqa: B008 - a tuple
        rounded: bool = True,
        steps: ScalarSteps | None = None,
        canonical: bool = False,
    ) -> None:
        """Start as the teacher cut to the harmonics of `color`, its opacities as the base.

        Of `sort_free_gs` the weighting's sigma, and its background weight if that is not 0, are
        only where learning begins. Without `rounded`, training draws and decodes positions as they
        are, not as the file will hold them. With `steps` codes are multiples of them, not indices
        into codebooks; with `canonical`, too, Gaussians are turned as little as possible.
        """
        device = teacher.means.device
        coefficients = (color.degree + 1) ** 2
        sh = torch.zeros(len(teacher), coefficients, 3, device=device)
        kept = min(coefficients, teacher.sh.shape[1])
        sh[:, :kept] = teacher.sh[:, :kept]
        logits = teacher.logit_opacities.clamp(-LOGIT_MAX, LOGIT_MAX)
        quats, log_scales = teacher.quats, teacher.log_scales
        if canonical or steps is not None:
            quats, log_scales = canonical_pairs(quats, log_scales)
        tensors = {
            "means": teacher.means,
            "quats": quats,
            "log_scales": log_scales,
            "sh0": sh[:, :1],
            "sh_rest": sh[:, 1:],
        }
        self.phase: Phase = "explicit"
        self.view = view
        self.color = color
        self.rounded = rounded
        self.steps = steps
        self.blend = blend
        self._weighting = weighting
        self.network: ViewNetwork | None = None
        self.lobe_decoder: LobeDecoder | None = None
        self.decoder: ColorDecoder | None = None
        self.codebooks: dict[Attribute, Codes] = {}
        self.frame: Frame | None = None
        self.rates = dict(rates)
        self.shared = NamedAdam({}, {})
        if weighting.name == "sort_free_gs" and blend == "sortfree":
            for name in ("sigma", "background_weight"):
                if (start := getattr(weighting, name)) > 0:
                    log = torch.tensor(start, device=device).log()
                    self.shared.add(f"weighting.{name}", log, rates["weighting"])
        if view.kind in ("network", "fitted"):
            self.network = ViewNetwork(generator).to(device)
            self._share("network", self.network)
        if view.kind == "decoded":
            assert view.shape is not None
            self.lobe_decoder = LobeDecoder(view.shape, generator).to(device)
            self._share("lobe_decoder", self.lobe_decoder)
        if self.network is None and not self.settled:
            more = (view.degree + 1) ** 2 - 1
            tensors["explicit_lobes"] = pad(constant_lobes(logits), (0, 0, 0, more))
        else:
            tensors["logit_opacities"] = logits
        self.rows = NamedAdam(tensors, rates)

    def __len__(self) -> int:
        return len(self.rows.tensors["means"])

    @property
    def settled(self) -> bool:
        """Whether the lobes have the form that the file will have them in."""
        return self.view.kind in ("constant", "network") or self.lobe_decoder is not None

    @property
    def weighting(self) -> Weighting:
        """The weights as they stand."""
        logs = self.learned_weighting()
        learned = {name: float(log.detach().exp()) for name, log in logs.items()}
        return replace(self._weighting, **learned)

    def gaussians(
        self, rows: Int[Tensor, "m"] | None = None
    ) -> tuple[Gaussians, Float[Tensor, "m ..."]]:
        """The Gaussians that `rows` picks, each at most once, differentiable; None means all.

        Beside them, what `lobes` makes their lobes from: free lobes, or latents.
        """

        def free(name: str) -> Tensor:
            tensor = self.rows.tensors[name]
            return tensor if rows is None else take_rows(tensor, rows)

        means = free("means")
        nothing = means.new_zeros(len(means), 0)
        if self.phase == "codes":
            coded = {
                name: quantization.learning(codes, free(name), rows)
                for name, codes in self.codebooks.items()
            }
            quats, log_scales = coded["rotation"], coded["scale"]
            logits = coded["opacity"][:, 0] if "opacity" in coded else None
            for_lobes = coded.get("lobes", nothing)
            latents = coded["appearance"]
        else:
            tensors = self.rows.tensors
            quats, log_scales = canonical_quats(free("quats")), free("log_scales")
            logits = free("logit_opacities") if "logit_opacities" in tensors else None
            for_lobes = free("lobe_latents") if "lobe_latents" in tensors else nothing
            if "explicit_lobes" in tensors:
                for_lobes = free("explicit_lobes")
                logits = C0 * for_lobes[:, 0, 0]
            latents = None
            if self.phase == "networks":
                latents = torch.cat([free("static"), free("view")], dim=1)
        if logits is None:  # the lobe decoder knows them
            logits = torch.zeros_like(means[:, 0])
        if latents is None:
            sh = torch.cat([free("sh0"), free("sh_rest")], dim=1)
        else:
            assert self.decoder is not None and self.frame is not None
            stored = self.frame.normalised(self.frame.store(means))
            if self.rounded:
                means = self.frame.round(means)
            else:
                stored = (means.detach() - self.frame.center.to(means)) / self.frame.radius
            decode = self.decoder.decode if rows is None else self.decoder
            sh = decode(stored, latents[:, :3], latents[:, 3:])
        return Gaussians(means, quats, log_scales, logits, sh), for_lobes

    def lobes(
        self, gaussians: Gaussians, for_lobes: Float[Tensor, "m ..."], camera: Camera | None
    ) -> Float[Tensor, "m k 2"]:
        """Lobes of what `gaussians` returned, `[m, k, 2]`.

        A network needs a camera, and what it says holds for that one alone.
        """
        if self.network is not None:
            assert camera is not None
            directions = normalize(gaussians.means - camera.position, dim=1)
            if self.phase != "codes":
                return self.network(gaussians, directions)
            weights = rounded_parameters(self.network)
            return functional_call(self.network, weights, (gaussians, directions))
        if self.view.kind == "constant":
            return constant_lobes(gaussians.logit_opacities)
        if self.lobe_decoder is None:
            return for_lobes
        return self.lobe_decoder(for_lobes, gaussians, base=self.view.base)

    @torch.no_grad()
    def seen_from(self, camera: Camera) -> tuple[Float[Tensor, "n"], Float[Tensor, "n 3"]]:
        """Opacity, as `camera` sees it, and scales of all Gaussians."""
        gaussians, for_lobes = self.gaussians()
        directions = normalize(gaussians.means - camera.position, dim=1)
        opacities, _ = seen_along(self.lobes(gaussians, for_lobes, camera), directions)
        return opacities, gaussians.scales

    @torch.no_grad()
    def shapes(self) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n 4"], Float[Tensor, "n 3"]]:
        """Means, quats and log-scales of all Gaussians as they are drawn, without gradients."""
        of = self.rows.tensors
        means = of["means"].detach()
        if self.frame is not None:
            means = self.frame.round(means)
        if self.phase == "codes":
            return means, self.codebooks["rotation"](), self.codebooks["scale"]()
        return means, of["quats"].detach(), of["log_scales"].detach()

    def use_networks(
        self, frame: Frame, *, regression_steps: int, generator: torch.Generator
    ) -> None:
        """From `explicit` to `networks`: latents and decoder that reproduce the harmonics."""
        assert self.phase == "explicit"
        means, self.frame = self.rows.tensors["means"].detach(), frame
        sh = torch.cat([self.rows.drop("sh0"), self.rows.drop("sh_rest")], dim=1)
        self.decoder = color_decoder(self.color, generator).to(means.device)
        static, view = fit_appearance(
            self.decoder,
            self.frame.normalised(self.frame.store(means)),
            sh,
            generator=generator,
            steps=regression_steps,
        )
        self.rows.add("static", static, self.rates["static"])
        self.rows.add("view", view, self.rates["view"])
        self._share("decoder", self.decoder)
        self.phase = "networks"

    def settle(
        self, cameras: list[Camera], *, regression_steps: int, generator: torch.Generator
    ) -> None:
        """Lobes, free so far or a network's, become latents and a decoder.

        `cameras` are those of training: directions that none of them looks along count little.
        """
        assert not self.settled and self.phase != "codes"
        with torch.no_grad():
            everything, lobes = self.gaussians()
        found = settled(
            self.view,
            everything.detached(),
            self.network or lobes.detach(),
            cameras,
            regression_steps=regression_steps,
            generator=generator,
        )
        if self.network is not None:
            for name, _ in self.network.named_parameters():
                self.shared.drop(f"network.{name}")
            self.network = None
        for name in OF_LOBES:
            if name in self.rows.tensors:
                self.rows.drop(name)
        if self.view.base:
            self.rows.add("logit_opacities", found.logits, self.rates["logit_opacities"])
        if found.decoder.shape.latents:
            self.rows.add("lobe_latents", found.latents, self.rates["lobe_latents"])
        self.lobe_decoder = found.decoder
        self._share("lobe_decoder", self.lobe_decoder)

    def use_codes(self, sizes: CodebookSizes, *, generator: torch.Generator) -> None:
        """From `networks` to `codes`: whatever codes there are, of all but the positions."""
        assert self.phase == "networks" and self.settled
        take = self.rows.drop
        values: dict[Attribute, Tensor] = {
            "scale": take("log_scales"),
            "rotation": canonical_quats(take("quats")),
            "appearance": torch.cat([take("static"), take("view")], dim=1),
        }
        if self.view.base:
            values["opacity"] = take("logit_opacities")[:, None]
        if self.view.cut is not None:
            values["lobes"] = take("lobe_latents")
        if self.steps is None:
            self.codebooks = quantization.vector_codes(values, self.view, sizes, generator)
        else:
            assert self.decoder is not None and self.frame is not None
            places = self.frame.normalised(self.frame.store(self.rows.tensors["means"]))
            decoders = (self.decoder, self.lobe_decoder)
            values = quantization.decorrelated(values, places, *decoders, self.view)
            self.shared.forget_all()
            self.codebooks = quantization.scalar_codes(values, self.steps)
        for name, codes in self.codebooks.items():
            self._share(name, codes)
            self.rows.add(name, values[name], self.rates[f"free_{name}"])
        self.phase = "codes"

    @torch.no_grad()
    def pay(self, price: float) -> None:
        """Add to the gradients what a bit per Gaussian costs, coded already or not yet."""
        for name, codes in self.codebooks.items():
            quantization.pay(codes, self.rows.tensors[name], price)
        quantization.pay_ahead(self.rows.tensors, price)

    def reassign(self, *, all_codes: bool) -> None:
        """Give every Gaussian the codes nearest to what it has learned to want.

        Without `all_codes` only multiples of steps, which are found at once.
        """
        for name, codes in self.codebooks.items():
            if all_codes or not isinstance(codes, SubVectorCodebooks):
                codes.reassign(self.rows.tensors[name].detach())

    def set_rates(self, rates: Mapping[str, float]) -> None:
        """Rates by what they move: a tensor of `rows`, `network`, `decoder`, or an attribute."""
        self.rates = dict(rates)
        for name in self.rows.tensors:
            self.rows.set_rate(name, rates[f"free_{name}" if name in self.codebooks else name])
        for name in self.shared.tensors:
            self.shared.set_rate(name, rates[name.split(".")[0]])

    def step(self) -> None:
        """Move everything by the gradients at hand."""
        self.rows.step()
        self.shared.step()

    def keep_rows(self, rows: Bool[Tensor, "n"]) -> None:
        """Remove the Gaussians where the mask is false, and what Adam knows of them."""
        self.rows.keep_rows(rows)
        for books in self.codebooks.values():
            books.select(rows)

    @torch.no_grad()
    def forget_directions(self, share: float) -> None:
        """Shrink by `share` what depends on the direction in free lobes: photos bring it back."""
        if "explicit_lobes" in self.rows.tensors:
            self.rows.tensors["explicit_lobes"][:, 1:] *= 1 - share

    def state(self) -> dict:
        """Everything that training goes on from."""
        return {
            "phase": self.phase,
            "settled": self.settled,
            "rows": self.rows.state(),
            "shared": self.shared.state(),
            "frame": None if self.frame is None else asdict(self.frame),
            "indices": {name: books.indices for name, books in self.codebooks.items()},
        }

    def restore(self, state: dict) -> None:
        """Take back what `state()` gave, into a model that is still explicit."""
        assert self.phase == "explicit"
        device = self.rows.tensors["means"].device
        self.phase = state["phase"]
        if state["settled"] and not self.settled:
            assert self.view.shape is not None
            self.network = None
            self.lobe_decoder = LobeDecoder(self.view.shape, torch.Generator()).to(device)
            self._share("lobe_decoder", self.lobe_decoder)
        if state["frame"] is not None:
            self.frame = Frame(**state["frame"])
            self.decoder = color_decoder(self.color, torch.Generator())
            self.decoder.to(device)
            self._share("decoder", self.decoder)
        for name in state["indices"]:
            codes = quantization.restored_codes(name, state, self.steps, self.codebooks)
            self.codebooks[name] = codes.to(device)
            self._share(name, self.codebooks[name])
        if self.phase == "codes" and self.steps is not None:
            quantization.shorten_weights(self.decoder, self.lobe_decoder)
        self.rows.restore(state["rows"])
        self.shared.restore(state["shared"])

    def learned_weighting(self) -> dict[str, Float[Tensor, ""]]:
        """Logarithms of what the weighting learns; empty where it is given."""
        tensors, prefix = self.shared.tensors, "weighting."
        return {k.removeprefix(prefix): log for k, log in tensors.items() if k.startswith(prefix)}

    def _share(self, prefix: str, module: nn.Module) -> None:
        for name, parameter in module.named_parameters():
            self.shared.add(f"{prefix}.{name}", parameter, self.rates[prefix])
