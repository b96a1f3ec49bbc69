"""What the student is made of, in the three forms it takes on its way into the file."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Literal

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.autograd.function import FunctionCtx
from torch.func import functional_call
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.compress.appearance import AppearanceDecoder, fit_appearance
from mobilegs.compress.codebooks import (
    CUTS,
    Attribute,
    CodebookSizes,
    SubVectorCodebooks,
    canonical_quats,
)
from mobilegs.compress.halves import rounded_parameters
from mobilegs.compress.positions import Frame
from mobilegs.gaussians import Gaussians
from mobilegs.render import Rendered, Weighting, render_sortfree, visible_rows
from mobilegs.render.view_network import ViewNetwork
from mobilegs.train.optim import NamedAdam

Phase = Literal["explicit", "networks", "codes"]
LOGIT_MAX = 8.0  # surer opacities of a teacher would stretch the codebook for nothing
COEFFICIENTS = 4  # spherical harmonics of degree 1


class StudentModel:
    """Gaussians that a network gives opacity and weight, seen from a direction.

    It begins `explicit`: the tensors of 3DGS with harmonics of degree 1. With `networks` the
    harmonics become six latent numbers that an `AppearanceDecoder` turns back into harmonics,
    and positions are seen rounded as the file stores them. With `codes` all but the positions
    become indices into codebooks whose entries go on learning, and the view network computes
    with halves: what is drawn is now what the file will hold.

    Attributes:
        rows: what is free and has a row per Gaussian, with its Adam.
        network: gives phi and a change of the base opacity's logit, per direction.
        decoder: latents to harmonics; None while explicit.
        codebooks: by attribute; empty until `codes`.
        shared: the Adam of networks and codebooks.
        frame: where the stored positions lie; None while explicit.
    """

    def __init__(
        self, teacher: Gaussians, rates: Mapping[str, float], generator: torch.Generator
    ) -> None:
        """Start as the teacher cut to harmonics of degree 1, its opacities as the base."""
        sh = torch.zeros(len(teacher), COEFFICIENTS, 3, device=teacher.means.device)
        kept = min(COEFFICIENTS, teacher.sh.shape[1])
        sh[:, :kept] = teacher.sh[:, :kept]
        tensors = {
            "means": teacher.means,
            "quats": teacher.quats,
            "log_scales": teacher.log_scales,
            "logit_opacities": teacher.logit_opacities.clamp(-LOGIT_MAX, LOGIT_MAX),
            "sh0": sh[:, :1],
            "sh_rest": sh[:, 1:],
        }
        self.phase: Phase = "explicit"
        self.rates = dict(rates)
        self.rows = NamedAdam(tensors, rates)
        self.network = ViewNetwork(generator).to(teacher.means.device)
        self.decoder: AppearanceDecoder | None = None
        self.codebooks: dict[Attribute, SubVectorCodebooks] = {}
        self.frame: Frame | None = None
        weights = {f"network.{name}": p for name, p in self.network.named_parameters()}
        self.shared = NamedAdam(weights, dict.fromkeys(weights, rates["network"]))

    def __len__(self) -> int:
        return len(self.rows.tensors["means"])

    def gaussians(self, rows: Int[Tensor, "m"] | None = None) -> Gaussians:
        """The Gaussians that `rows` picks, each at most once, differentiable; None means all."""

        def free(name: str) -> Tensor:
            tensor = self.rows.tensors[name]
            return tensor if rows is None else _TakeRows.apply(tensor, rows)  # pyright: ignore[reportReturnType]

        means = free("means")
        if self.phase == "explicit":
            sh = torch.cat([free("sh0"), free("sh_rest")], dim=1)
            quats = canonical_quats(free("quats"))
            return Gaussians(means, quats, free("log_scales"), free("logit_opacities"), sh)
        assert self.decoder is not None and self.frame is not None
        stored = self.frame.normalised(self.frame.store(means))
        if self.phase == "networks":
            quats, log_scales = canonical_quats(free("quats")), free("log_scales")
            logits, latents = free("logit_opacities"), torch.cat([free("static"), free("view")], 1)
        else:
            coded = {
                name: book(rows) + pass_through(free(name)) for name, book in self.codebooks.items()
            }
            quats, log_scales = coded["rotation"], coded["scale"]
            logits, latents = coded["opacity"][:, 0], coded["appearance"]
        decode = self.decoder.decode if rows is None else self.decoder
        sh = decode(stored, latents[:, :3], latents[:, 3:])
        return Gaussians(self.frame.round(means), quats, log_scales, logits, sh)

    def seen(self, gaussians: Gaussians, camera: Camera) -> tuple[Tensor, Tensor]:
        """phi and opacity of each of some Gaussians, as `camera` sees them, `[n]` both."""
        directions = normalize(gaussians.means - camera.position, dim=1)
        inputs = (gaussians.sh, directions, gaussians.scales, gaussians.quats)
        if self.phase == "codes":
            phi, change = functional_call(self.network, rounded_parameters(self.network), inputs)
        else:
            phi, change = self.network(*inputs)
        return phi, (gaussians.logit_opacities + change).sigmoid()

    def draw(
        self,
        camera: Camera,
        *,
        background: Float[Tensor, "3"],
        weighting: Weighting,
        depth: bool = False,
    ) -> Rendered:
        """The picture from `camera`, differentiable; only what it can show is computed.

        `radii` are those of the Gaussians drawn, not of all.
        """
        rows = self.visible(camera)
        some = self.gaussians(rows)
        phi, opacities = self.seen(some, camera)
        return render_sortfree(
            some.means,
            some.quats,
            some.scales,
            opacities,
            some.sh,
            phi,
            camera=camera,
            background=background,
            weighting=weighting,
            depth=depth,
        )

    @torch.no_grad()
    def visible(self, camera: Camera) -> Int[Tensor, "m"]:
        """Indices of the Gaussians that could touch the picture."""
        quats, log_scales = (
            (self.codebooks["rotation"](), self.codebooks["scale"]())
            if self.phase == "codes"
            else (self.rows.tensors["quats"], self.rows.tensors["log_scales"])
        )
        means = self.rows.tensors["means"]
        if self.frame is not None:
            means = self.frame.round(means)
        return visible_rows(means.detach(), quats, log_scales.exp(), camera=camera)

    def use_networks(self, *, regression_steps: int, generator: torch.Generator) -> None:
        """From `explicit` to `networks`: latents and decoder that reproduce the harmonics."""
        assert self.phase == "explicit"
        means = self.rows.tensors["means"].detach()
        self.frame = Frame.around(means)
        sh = torch.cat([self.rows.drop("sh0"), self.rows.drop("sh_rest")], dim=1)
        self.decoder = AppearanceDecoder(generator).to(means.device)
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

    def use_codes(self, sizes: CodebookSizes, *, generator: torch.Generator) -> None:
        """From `networks` to `codes`: k-means of every attribute but the positions."""
        assert self.phase == "networks"
        take = self.rows.drop
        values: dict[Attribute, Tensor] = {
            "scale": take("log_scales"),
            "rotation": canonical_quats(take("quats")),
            "appearance": torch.cat([take("static"), take("view")], dim=1),
            "opacity": take("logit_opacities")[:, None],
        }
        for name, value in values.items():
            size = min(getattr(sizes, name), len(self))
            self.codebooks[name] = SubVectorCodebooks.fit(
                value,
                length=CUTS[name].length,
                size=size,
                generator=generator,
                weights=apparent_size(values["scale"]) if name == "scale" else None,
            )
            self._share(name, self.codebooks[name])
            self.rows.add(name, value, self.rates[f"free_{name}"])
        self.phase = "codes"

    def reassign(self) -> None:
        """Give every Gaussian the codebook entries nearest to what it has learned to want."""
        for name, book in self.codebooks.items():
            book.reassign(self.rows.tensors[name].detach())

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

    def state(self) -> dict:
        """Everything that training goes on from."""
        return {
            "phase": self.phase,
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
        if state["frame"] is not None:
            self.frame = Frame(**state["frame"])
            self.decoder = AppearanceDecoder(torch.Generator()).to(device)
            self._share("decoder", self.decoder)
        for name, indices in state["indices"].items():
            centers = state["shared"][f"{name}.centers"]["value"]
            self.codebooks[name] = SubVectorCodebooks(centers, indices).to(device)
            self._share(name, self.codebooks[name])
        self.rows.restore(state["rows"])
        self.shared.restore(state["shared"])

    def _share(self, prefix: str, module: nn.Module) -> None:
        for name, parameter in module.named_parameters():
            self.shared.add(f"{prefix}.{name}", parameter, self.rates[prefix])


def apparent_size(log_scales: Float[Tensor, "n 3"]) -> Float[Tensor, "n"]:
    """Fourth root of each Gaussian's largest cross-section, relative to the largest of all.

    Large Gaussians are few, and an error of theirs covers the picture (docs/negative_results.md).
    """
    area = log_scales.sum(1) - log_scales.amin(1)
    return (0.25 * (area - area.max())).exp()


def pass_through(values: Tensor) -> Tensor:
    """Zeros whose gradient is that of `values`: added to codes, it trains what they stand for."""
    return values - values.detach()


class _TakeRows(torch.autograd.Function):
    """`tensor[rows]` for rows that are all different: the adjoint copies instead of adding."""

    @staticmethod
    def forward(ctx: FunctionCtx, tensor: Tensor, rows: Tensor) -> Tensor:
        ctx.shape = tensor.shape  # pyright: ignore[reportAttributeAccessIssue]
        ctx.save_for_backward(rows)
        return tensor.index_select(0, rows)

    @staticmethod
    def backward(ctx: FunctionCtx, grad: Tensor) -> tuple[Tensor, None]:  # pyright: ignore[reportIncompatibleMethodOverride]
        [rows] = ctx.saved_tensors  # pyright: ignore[reportAttributeAccessIssue]
        full = grad.new_zeros(ctx.shape)  # pyright: ignore[reportAttributeAccessIssue]
        return full.index_copy_(0, rows, grad), None
