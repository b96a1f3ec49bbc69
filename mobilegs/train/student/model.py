"""The parameters of the student, and the three phases they go through on the way to the file."""

import copy
import math
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Literal, get_args

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.func import functional_call
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.encode import Quantizer
from mobilegs.mgs.positions import PositionGrid
from mobilegs.render import Footprint, Weighting
from mobilegs.render.lobes import constant_lobes, evaluate_lobes
from mobilegs.render.project import CLASSIC
from mobilegs.render.view_network import ViewNetwork
from mobilegs.representation.appearance import (
    ColorDecoder,
    ColorShape,
    color_decoder,
    fit_appearance,
)
from mobilegs.representation.codebooks import (
    Attribute,
    CodebookSizes,
    SubVectorCodebooks,
    canonical_quats,
)
from mobilegs.representation.float16 import round_float16
from mobilegs.representation.lobes import LobeDecoder
from mobilegs.representation.rotations import canonical_pairs
from mobilegs.representation.uniform_quantizer import StepSizeQuantizer, StepSizes
from mobilegs.train.autograd_ops import take_rows
from mobilegs.train.optim import NamedAdam
from mobilegs.train.sampling import limit_scales
from mobilegs.train.student import quantization
from mobilegs.train.student.view_dependence import LOGIT_MAX, ViewDependence, constant_decoder

Phase = Literal["explicit", "latents", "quantized"]


class StudentModel:
    """Gaussians whose opacity and weight depend on the viewing direction.

    | phase | parameters |
    |---|---|
    | `explicit` | the tensors of 3DGS, with harmonics of a low degree |
    | `latents` | latents and a `ColorDecoder` in place of harmonics; rounded means |
    | `quantized` | quantised values and float16 networks: renders what the file holds |

    Attributes:
        rows: tensors with a row per Gaussian, with their Adam.
        shared: parameters of networks, decoders and quantisers, with their Adam.
        view: the view dependence.
        network: gives lobes per view; None without a network.
        lobe_decoder: gives lobes from latents; None with a network or constant opacities.
        decoder: gives harmonics from latents; None while explicit.
        grid: rounds the means; None while explicit.
    """

    def __init__(
        self,
        teacher: Gaussians,
        view: ViewDependence,
        lrs: Mapping[str, float],
        generator: torch.Generator,
        *,
        blend: str = "sortfree",
        weighting: Weighting = Weighting(),  # noqa: B008 - frozen
        footprint: Footprint = CLASSIC,
        level_sigma: float = 0.0,
        color: ColorShape = ColorShape(),  # noqa: B008 - a tuple
        round_means: bool = True,
        step_sizes: StepSizes | None = None,
    ) -> None:
        """Start from the teacher, with its harmonics cut to the degree of `color`.

        Args:
            teacher: its opacities become the base opacities.
            view: the view dependence.
            lrs: learning rates, see `set_lrs`.
            generator: initialises networks.
            blend, weighting, footprint, color: of the scene.
            level_sigma: of the renderer, as in `render_sortfree`.
            round_means: render and decode with means as the file rounds them.
            step_sizes: initial ones of uniform quantisers, for which each rotation starts as the
                smallest of the 24 equivalent ones; None quantises by codebooks.
        """
        device = teacher.means.device
        coefficients = (color.degree + 1) ** 2
        sh = torch.zeros(len(teacher), coefficients, 3, device=device)
        kept = min(coefficients, teacher.sh.shape[1])
        sh[:, :kept] = teacher.sh[:, :kept]
        logits = teacher.logit_opacities.clamp(-LOGIT_MAX, LOGIT_MAX)
        quats, log_scales = teacher.quats, teacher.log_scales
        if step_sizes is not None:
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
        self.round_means = round_means
        self.step_sizes = step_sizes
        self.blend = blend
        self.footprint = footprint
        self.level_sigma = level_sigma
        self.weighting = weighting
        self.network: ViewNetwork | None = None
        self.lobe_decoder: LobeDecoder | None = None
        self.decoder: ColorDecoder | None = None
        self._quantizers: dict[Attribute, Quantizer] = {}
        self._outdated = False  # the codes of uniform quantisers, since values changed
        self.grid: PositionGrid | None = None
        self.lrs = dict(lrs)
        self.shared = NamedAdam({}, {})
        if view.kind == "network":
            self.network = ViewNetwork(generator).to(device)
            self._optimize("network", self.network)
        if view.shape is not None:
            self.lobe_decoder, logits = constant_decoder(view.shape, logits, generator)
            self._optimize("lobe_decoder", self.lobe_decoder)
        tensors["logit_opacities"] = logits
        if view.shape is not None and view.shape.latents:
            tensors["lobe_latents"] = logits.new_zeros(len(teacher), view.shape.latents)
        self.rows = NamedAdam(tensors, lrs)

    def __len__(self) -> int:
        return len(self.rows.tensors["means"])

    def gaussians(
        self, rows: Int[Tensor, "m"] | None = None
    ) -> tuple[Gaussians, Float[Tensor, "m ..."]]:
        """Return the Gaussians of distinct `rows` (None: all), and their inputs for `lobes`.

        These inputs are latents. All is differentiable.
        """
        picked = partial(self._picked, rows=rows)
        means = picked("means")
        empty = means.new_zeros(len(means), 0)
        if self.phase == "quantized":
            values = {
                name: quantization.quantized(quantizer, picked(name), rows)
                for name, quantizer in self.quantizers.items()
            }
            quats, log_scales = values["rotation"], values["scale"]
            logits = values["opacity"][:, 0]
            lobe_inputs = values.get("lobes", empty)
            latents = values["appearance"]
        else:
            tensors = self.rows.tensors
            quats, log_scales = canonical_quats(picked("quats")), picked("log_scales")
            logits = picked("logit_opacities")
            lobe_inputs = picked("lobe_latents") if "lobe_latents" in tensors else empty
            latents = None
            if self.phase == "latents":
                latents = torch.cat([picked("static"), picked("view")], dim=1)
        if latents is None:
            sh = torch.cat([picked("sh0"), picked("sh_rest")], dim=1)
        else:
            assert self.decoder is not None and self.grid is not None
            positions = self.grid.normalised(self.grid.store(means))
            if self.round_means:
                means = self.grid.round(means)
            else:
                positions = (means.detach() - self.grid.center.to(means)) / self.grid.radius
            decode = self.decoder.decode if rows is None else self.decoder
            sh = decode(positions, latents[:, :3], latents[:, 3:])
        return Gaussians(means, quats, log_scales, logits, sh), lobe_inputs

    def _picked(self, name: str, *, rows: Int[Tensor, "m"] | None) -> Tensor:
        """Return the rows of a trained tensor, or all of them."""
        tensor = self.rows.tensors[name]
        return tensor if rows is None else take_rows(tensor, rows)

    def lobes(
        self, gaussians: Gaussians, lobe_inputs: Float[Tensor, "m ..."], camera: Camera | None
    ) -> Float[Tensor, "m k 2"]:
        """Return the lobes of the Gaussians and inputs that `gaussians` returned, `[m, k, 2]`.

        A network needs a camera, and its lobes are valid for this camera only.
        """
        if self.network is not None:
            assert camera is not None
            directions = normalize(gaussians.means - camera.position, dim=1)
            if self.phase != "quantized":
                return self.network(gaussians, directions)
            weights = {
                name: round_float16(value) for name, value in self.network.named_parameters()
            }
            return functional_call(self.network, weights, (gaussians, directions))
        if self.lobe_decoder is None:
            return constant_lobes(gaussians.logit_opacities)
        return self.lobe_decoder(lobe_inputs, gaussians, base=True)

    @torch.no_grad()
    def opacities_and_scales(
        self, camera: Camera
    ) -> tuple[Float[Tensor, "n"], Float[Tensor, "n 3"]]:
        """Return the opacities, as `camera` sees them, and scales of all Gaussians."""
        gaussians, lobe_inputs = self.gaussians()
        directions = normalize(gaussians.means - camera.position, dim=1)
        opacities, _ = evaluate_lobes(self.lobes(gaussians, lobe_inputs, camera), directions)
        return opacities, gaussians.scales

    @torch.no_grad()
    def shapes(self) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n 4"], Float[Tensor, "n 3"]]:
        """Return the rendered means, quats and log-scales of all Gaussians, without gradients."""
        tensors = self.rows.tensors
        means = tensors["means"].detach()
        if self.grid is not None:
            means = self.grid.round(means)
        if self.phase == "quantized":
            return means, self.quantizers["rotation"](), self.quantizers["scale"]()
        return means, tensors["quats"].detach(), tensors["log_scales"].detach()

    def use_latents(
        self, grid: PositionGrid, *, regression_steps: int, generator: torch.Generator
    ) -> None:
        """Go from `explicit` to `latents`: fit latents and a decoder to the harmonics."""
        assert self.phase == "explicit"
        means, self.grid = self.rows.tensors["means"].detach(), grid
        sh = torch.cat([self.rows.drop("sh0"), self.rows.drop("sh_rest")], dim=1)
        self.decoder = color_decoder(self.color, generator).to(means.device)
        static, view = fit_appearance(
            self.decoder,
            self.grid.normalised(self.grid.store(means)),
            sh,
            generator=generator,
            steps=regression_steps,
        )
        self.rows.add("static", static, self.lrs["static"])
        self.rows.add("view", view, self.lrs["view"])
        self._optimize("decoder", self.decoder)
        self.phase = "latents"

    def quantize(self, sizes: CodebookSizes, *, generator: torch.Generator) -> None:
        """Go from `latents` to `quantized`: quantise all values but the means.

        `sizes` are those of codebooks, if there are no step sizes.
        """
        assert self.phase == "latents"
        take = self.rows.drop
        values: dict[Attribute, Tensor] = {
            "scale": take("log_scales"),
            "rotation": canonical_quats(take("quats")),
            "appearance": torch.cat([take("static"), take("view")], dim=1),
            "opacity": take("logit_opacities")[:, None],
        }
        if self.view.cut is not None:
            values["lobes"] = take("lobe_latents")
        if self.step_sizes is None:
            self._quantizers = quantization.fit_codebooks(values, sizes, generator)
        else:
            assert self.decoder is not None and self.grid is not None
            positions = self.grid.normalised(self.grid.store(self.rows.tensors["means"]))
            decoders = (self.decoder, self.lobe_decoder)
            values = quantization.decorrelate(values, positions, *decoders)
            self.shared.reset_all_moments()
            self._quantizers = quantization.fit_uniform_quantizers(values, self.step_sizes)
        for name, quantizer in self.quantizers.items():
            self._optimize(name, quantizer)
            self.rows.add(name, values[name], self.lrs[f"{name}_values"])
        self.phase = "quantized"

    def set_step_sizes(self, step_sizes: StepSizes | None) -> None:
        """Change the initial step sizes, also those of quantisers; what these learned stays."""
        self.step_sizes = step_sizes
        self._outdated = bool(self._quantizers)
        if step_sizes is not None:
            for name in self._quantizers:
                self.uniform(name).initial_step_size = getattr(step_sizes, name)

    def quantized_copy(self) -> "StudentModel":
        """Return what `quantize` would make now with `step_sizes`; the model itself stays."""
        assert self.step_sizes is not None
        copied = copy.copy(self)
        copied.rows = NamedAdam(self.rows.tensors, self.lrs)  # without moments
        copied.shared = NamedAdam({}, {})
        copied.decoder, copied.lobe_decoder = copy.deepcopy((self.decoder, self.lobe_decoder))
        copied.quantize(CodebookSizes(), generator=torch.Generator())
        return copied

    @torch.no_grad()
    def add_rate_gradients(self, bit_weight: float) -> None:
        """Add the gradients of the rate term; `bit_weight` is the weight of a bit per Gaussian."""
        quantization.add_rate_gradients(self._quantizers, self.rows.tensors, bit_weight)
        quantization.add_early_rate_gradients(self.rows.tensors, bit_weight)

    def reassign(self, *, codebooks: bool) -> None:
        """Assign the codes nearest to the unquantised values.

        Without `codebooks` only uniform quantisers do so, when the codes are next used.
        """
        self._outdated = True
        for name, quantizer in self._quantizers.items():
            if codebooks and isinstance(quantizer, SubVectorCodebooks):
                quantizer.reassign(self.rows.tensors[name].detach())

    @property
    def quantizers(self) -> dict[Attribute, Quantizer]:
        """The quantisers, with the codes of the present values."""
        if self._outdated:
            self._outdated = False
            for name, quantizer in self._quantizers.items():
                if not isinstance(quantizer, SubVectorCodebooks):
                    quantizer.reassign(self.rows.tensors[name].detach())
        return self._quantizers

    def uniform(self, name: Attribute) -> StepSizeQuantizer:
        """Return the quantiser of an attribute that has a step size; its codes may be outdated."""
        quantizer = self._quantizers[name]
        assert not isinstance(quantizer, SubVectorCodebooks)
        return quantizer

    def set_lrs(self, lrs: Mapping[str, float]) -> None:
        """Set learning rates.

        Keys are the names of `rows`; `network`, `decoder` and `lobe_decoder`; the attributes, for
        quantisers; and `ATTRIBUTE_values`, for the values behind them.
        """
        self.lrs = dict(lrs)
        for name in self.rows.tensors:
            self.rows.set_lr(name, lrs[f"{name}_values" if name in self._quantizers else name])
        for name in self.shared.tensors:
            self.shared.set_lr(name, lrs[name.split(".")[0]])

    def step(self) -> None:
        """Take an Adam step with the current gradients."""
        self.rows.step()
        self.shared.step()

    def keep_rows(self, rows: Bool[Tensor, "n"]) -> None:
        """Remove the Gaussians, with their moments and codes, where the mask is false."""
        self.rows.keep_rows(rows)
        for quantizer in self._quantizers.values():
            quantizer.select(rows)

    @torch.no_grad()
    def limit_scales(self, cameras: list[Camera], variance: float) -> None:
        """Raise scales that are finer than the cameras sample; see `sampling.limit_scales`."""
        tensors = self.rows.tensors
        values = tensors["scale" if "scale" in self._quantizers else "log_scales"]
        limit_scales(values.detach(), tensors["means"].detach(), cameras, variance)

    def state(self) -> dict:
        """Return the parameters, moments and codes."""
        return {
            "phase": self.phase,
            "rows": self.rows.state(),
            "shared": self.shared.state(),
            "grid": None if self.grid is None else asdict(self.grid),
            "indices": {name: quantizer.indices for name, quantizer in self.quantizers.items()},
        }

    def restore(self, state: dict) -> None:
        """Continue from the result of `state()`, in a model that is still explicit."""
        assert self.phase == "explicit"
        device = self.rows.tensors["means"].device
        self.phase = state["phase"]
        if self.phase not in get_args(Phase):
            raise ValueError(f"there is no phase {self.phase}")
        if state["grid"] is not None:
            self.grid = PositionGrid(**state["grid"])
            if not (0 < self.grid.radius < math.inf and self.grid.exponent in range(15)):
                raise ValueError("its grid of positions is none")
            self.decoder = color_decoder(self.color, torch.Generator())
            self.decoder.to(device)
            self._optimize("decoder", self.decoder)
        elif self.phase != "explicit":
            raise ValueError("it has no grid of positions")
        for name in state["indices"]:
            quantizer = quantization.restore_quantizer(
                name, state, self.step_sizes, self._quantizers
            )
            self._quantizers[name] = quantizer.to(device)
            self._optimize(name, quantizer)
        if self.phase == "quantized" and self.step_sizes is not None:
            quantization.shorten_weights(self.decoder, self.lobe_decoder)
        self.rows.restore(state["rows"])
        self.rows.validate_rows(*(quantizer.indices for quantizer in self.quantizers.values()))
        self.shared.restore(state["shared"])

    def _optimize(self, prefix: str, module: nn.Module) -> None:
        """Add the parameters of a module to `shared`."""
        for name, parameter in module.named_parameters():
            self.shared.add(f"{prefix}.{name}", parameter, self.lrs[prefix])
