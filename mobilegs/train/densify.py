"""Where the teacher grows: Gaussians whose position the pictures pull at are cloned or split."""

from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.project import rotation_matrices
from mobilegs.train.optim import NamedAdam


@dataclass(frozen=True)
class DensifyConfig:
    """When and where Gaussians are added and removed (3DGS, section 5.2)."""

    strategy: Literal["clone_split", "fixed"] = "clone_split"
    """`clone_split` is 3DGS's; `fixed` keeps the Gaussians that training starts with."""
    start: float = 0.02
    """Fraction of the run before the first densification (3DGS: 500 of 30,000)."""
    stop: float = 0.5
    """Fraction of the run after which none happens (3DGS: 15,000 of 30,000)."""
    interval: float = 1 / 300
    """Fraction of the run between two (3DGS: 100 of 30,000)."""
    min_interval: int = 50
    """The least number of steps between two, so that short runs still average gradients."""
    gradient: float = 2e-4
    """A Gaussian grows if its mean screen-space gradient reaches this, in units of half the
    picture's size (3DGS: 2e-4)."""
    split_scale: float = 0.01
    """Growing Gaussians larger than this fraction of the scene's extent are split, others
    cloned."""
    prune_opacity: float = 0.005
    """Fainter Gaussians are removed."""
    prune_scale: float = 0.1
    """Larger ones, as a fraction of the scene's extent, are removed; 0 never removes them."""
    prune_scale_from: float = 0.1
    """Fraction of the run from which that holds (3DGS: 3,000 of 30,000)."""
    opacity_reset: float = 0.0
    """Fraction of the run between two resets of all opacities to at most 0.01 while densifying
    (3DGS: 3,000 of 30,000); 0 never resets, as in Mini-Splatting."""


@dataclass(frozen=True)
class Schedule:
    """The densification's steps in a run of a given length, counted from 1."""

    start: int
    stop: int
    interval: int
    prune_scale_from: int
    opacity_reset: int

    @staticmethod
    def of(config: DensifyConfig, steps: int) -> "Schedule":
        """The fractions of `config` in a run of `steps`."""
        return Schedule(
            start=round(config.start * steps),
            stop=round(config.stop * steps),
            interval=max(1, config.min_interval, round(config.interval * steps)),
            prune_scale_from=round(config.prune_scale_from * steps),
            opacity_reset=round(config.opacity_reset * steps),
        )


class CloneSplit:
    """3DGS's densification: observes every step's gradients, changes the rows now and then."""

    def __init__(
        self,
        config: DensifyConfig,
        *,
        steps: int,
        extent: float,
        max_splats: int,
        count: int,
        device: torch.device,
    ) -> None:
        """`extent` in world units, `count` the number of Gaussians to begin with."""
        self.config = config
        self.schedule = Schedule.of(config, steps)
        self.extent = extent
        self.max_splats = max_splats
        self._clear(count, device)

    def observe(
        self, screen_grads: Float[Tensor, "n 2"], radii: Float[Tensor, "n"], camera: Camera
    ) -> None:
        """Add one picture's gradients of the projected centres (in 1 / px) to the averages."""
        half = screen_grads.new_tensor([camera.width / 2, camera.height / 2])
        self.gradients += (screen_grads * half).norm(dim=1)
        self.views += radii > 0

    @torch.no_grad()
    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Grow and prune if the schedule says so after step number `step` (from 1)."""
        when = self.schedule
        if not when.start < step <= when.stop:
            return
        if step % when.interval == 0:
            self._grow(adam, generator)
            self._prune(adam, large_too=step > when.prune_scale_from)
            self._clear(len(adam.tensors["means"]), self.gradients.device)
        if when.opacity_reset and step % when.opacity_reset == 0:
            faint = torch.logit(torch.tensor(0.01)).item()
            adam.reset("logit_opacities", adam.tensors["logit_opacities"].clamp_max(faint))

    def state(self) -> dict:
        """The averages so far."""
        return {"gradients": self.gradients, "views": self.views}

    def restore(self, state: dict) -> None:
        """Take back what `state()` gave."""
        device = self.gradients.device
        self.gradients, self.views = state["gradients"].to(device), state["views"].to(device)

    def _clear(self, count: int, device: torch.device) -> None:
        self.gradients = torch.zeros(count, device=device)  # sum of norms
        self.views = torch.zeros(count, dtype=torch.int32, device=device)

    def _grow(self, adam: NamedAdam, generator: torch.Generator) -> None:
        rows = self._pulled()
        scales = adam.tensors["log_scales"].exp()
        large = scales.amax(1) > self.config.split_scale * self.extent
        cloned, split = rows & ~large, rows & large
        twice = torch.cat([split.nonzero()[:, 0]] * 2)
        new = {
            name: torch.cat([tensor[cloned], tensor[twice]])
            for name, tensor in adam.tensors.items()
        }
        children = slice(int(cloned.sum()), None)
        noise = torch.randn(len(twice), 3, generator=generator).to(scales.device)
        turn = rotation_matrices(adam.tensors["quats"][twice])
        new["means"][children] += (turn @ (scales[twice] * noise)[:, :, None])[:, :, 0]
        new["log_scales"][children] = (scales[twice] / 1.6).log()
        adam.append_rows(new)
        added = torch.ones(len(new["means"]), dtype=torch.bool, device=rows.device)
        adam.keep_rows(torch.cat([~split, added]))

    def _pulled(self) -> Bool[Tensor, "n"]:
        """Which Gaussians grow: those over the threshold, the largest first up to the cap."""
        mean = self.gradients / self.views.clamp_min(1)
        rows = mean >= self.config.gradient
        room = max(0, self.max_splats - len(mean))
        if int(rows.sum()) > room:  # cloned or split, each adds exactly one
            ranked = torch.argsort(mean, descending=True, stable=True)
            rows = torch.zeros_like(rows).index_fill_(0, ranked[:room], True)
        return rows

    def _prune(self, adam: NamedAdam, *, large_too: bool) -> None:
        keep = adam.tensors["logit_opacities"].sigmoid() >= self.config.prune_opacity
        if large_too and self.config.prune_scale:
            largest = adam.tensors["log_scales"].amax(1).exp()
            keep &= largest <= self.config.prune_scale * self.extent
        if keep.any() and not keep.all():
            adam.keep_rows(keep)
