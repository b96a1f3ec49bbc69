"""Densification of the teacher: Gaussians with large screen-space gradients are cloned or split."""

from dataclasses import dataclass, replace
from typing import Literal

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render.project import rotation_matrices
from mobilegs.reproducible import sigmoid
from mobilegs.train.optim import NamedAdam
from mobilegs.validation import FRACTION, NOT_NEGATIVE, check, check_choice

Strategy = Literal["clone_split", "mini_splatting", "mcmc", "fixed"]
STOP = 0.5  # time at which densification ends (3DGS: 15,000 of 30,000)
INTERVAL = 1 / 300  # time between two densifications (3DGS: 100 of 30,000)
SPLIT_SCALE = 0.01  # share of the scene's extent: larger Gaussians are split, others are cloned
PRUNE_OPACITY = 0.005  # Gaussians of lower opacity are removed
PRUNE_SCALE_FROM = 0.1  # time from which on large Gaussians are removed (3DGS: 3,000 of 30,000)


@dataclass(frozen=True)
class DensifyConfig:
    """When and where Gaussians are added and removed (3DGS, section 5.2)."""

    strategy: Strategy = "clone_split"
    """`clone_split` is 3DGS's method. `mini_splatting` also restarts from surface points and keeps
    the important Gaussians. `mcmc` moves faint Gaussians, up to max_splats. `fixed` keeps the
    initial Gaussians. `clone_split` and `mini_splatting` use all fields below, `mcmc` only `start`
    and `min_interval`."""
    start: float = 1 / 60
    """Fraction of the run before the first densification (3DGS: 500 of 30,000)."""
    min_interval: int = 50
    """Minimum number of steps between two densifications, so that short runs also average
    gradients. In long runs it is a 300th of the run (3DGS: 100 of 30,000)."""
    gradient: float = 2e-4
    """Mean screen-space gradient from which on a Gaussian is cloned or split, in units of half the
    image's size (3DGS: 2e-4)."""
    prune_scale: float = 0.1
    """Gaussians larger than this fraction of the scene's extent are removed after a tenth of the
    run (3DGS: 3,000 of 30,000); 0 removes none."""
    opacity_reset: float = 0.0
    """Fraction of the run between two resets of all opacities to at most 0.01, until densification
    ends (3DGS: 3,000 of 30,000); 0 never resets, as in Mini-Splatting."""

    def __post_init__(self) -> None:
        check_choice("strategy", self.strategy, Strategy)
        check(
            self,
            **dict.fromkeys(("start", "opacity_reset"), FRACTION),
            **dict.fromkeys(("gradient", "prune_scale", "min_interval"), NOT_NEGATIVE),
        )


@dataclass(frozen=True)
class Schedule:
    """The steps of densification in a run of given length, counted from 1."""

    start: int
    stop: int
    interval: int
    prune_scale_from: int
    opacity_reset: int

    @staticmethod
    def of(config: DensifyConfig, steps: int) -> "Schedule":
        """Convert the fractions of `config` to steps of a run of `steps`."""
        return Schedule(
            start=round(config.start * steps),
            stop=round(STOP * steps),
            interval=max(1, config.min_interval, round(INTERVAL * steps)),
            prune_scale_from=round(PRUNE_SCALE_FROM * steps),
            opacity_reset=round(config.opacity_reset * steps),
        )


class Fixed:
    """The strategy that keeps the initial Gaussians, and the base class of the others."""

    stop = 0
    """Step at which the last Gaussians are added."""
    last_event = 0
    """Step after which no Gaussians are added or removed."""
    sh_delayed = False
    """True if Gaussians have only degree 0 until the strategy adds the higher degrees."""

    def shorten(self, steps: int) -> None:
        """End sooner if a run of `steps` does, where the strategy allows it."""

    def lr_step(self, done: int) -> int:
        """Return the step of the means' learning-rate schedule after `done` steps."""
        return done

    def sh_step(self, done: int) -> int:
        """Return the step of the schedule of the SH degree after `done` steps."""
        return done

    def regularizer(self, gaussians: Gaussians) -> Float[Tensor, ""] | None:
        """Return a term that is added to the loss, if there is one."""
        return None

    def observe(
        self,
        step: int,
        gaussians: Gaussians,
        camera: Camera,
        *,
        screen_grads: Float[Tensor, "n 2"],
        radii: Float[Tensor, "n"],
    ) -> None:
        """Record a view of `gaussians`, before step number `step` (from 1) changes them.

        `screen_grads` are gradients with respect to the projected means, in 1 / px; `radii` are in
        px, 0 for Gaussians outside the image.
        """

    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Add, remove or change Gaussians after step number `step` (from 1)."""

    def keep_rows(self, rows: Bool[Tensor, "n"]) -> None:
        """Gaussians have been removed: keep what is known of the others, where the mask is true."""

    def state(self) -> dict:
        """Return everything that later changes depend on."""
        return {}

    def restore(self, state: dict) -> None:
        """Restore a result of `state()`."""


class CloneSplit(Fixed):
    """3DGS's densification (Kerbl et al. 2023, section 5.2): clones, splits and prunes."""

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
        """`extent` is in world units, `count` is the initial number of Gaussians."""
        self.config = config
        self.schedule = Schedule.of(config, steps)
        self.stop = self.last_event = self.schedule.stop
        self.extent = extent
        self.max_splats = max_splats
        self._clear(count, device)

    def shorten(self, steps: int) -> None:
        """End densification where a run of `steps` does, if that is sooner."""
        stop = min(self.stop, Schedule.of(self.config, steps).stop)
        self.schedule = replace(self.schedule, stop=stop)
        self.stop = self.last_event = stop

    def observe(
        self,
        step: int,
        gaussians: Gaussians,
        camera: Camera,
        *,
        screen_grads: Float[Tensor, "n 2"],
        radii: Float[Tensor, "n"],
    ) -> None:
        if step >= self.stop:
            return
        across, down = screen_grads.unbind(1)  # a tensor of numbers would wait for a GPU
        self.gradients += torch.hypot(across * (camera.width / 2), down * (camera.height / 2))
        self.views += radii > 0

    @torch.no_grad()
    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Densify, prune and reset opacities by the schedule."""
        schedule = self.schedule
        if not schedule.start < step < schedule.stop:
            return
        if step % schedule.interval == 0:
            none = torch.zeros_like(self.views, dtype=torch.bool)
            self._densify(step, adam, generator, split_too=none)
        if schedule.opacity_reset and step % schedule.opacity_reset == 0:
            faint = torch.logit(torch.tensor(0.01)).item()
            adam.reset("logit_opacities", adam.tensors["logit_opacities"].clamp_max(faint))

    def keep_rows(self, rows: Bool[Tensor, "n"]) -> None:
        self.gradients, self.views = self.gradients[rows], self.views[rows]

    def state(self) -> dict:
        return {"gradients": self.gradients, "views": self.views}

    def restore(self, state: dict) -> None:
        device = self.gradients.device
        self.gradients, self.views = state["gradients"].to(device), state["views"].to(device)

    def _clear(self, count: int, device: torch.device) -> None:
        self.gradients = torch.zeros(count, device=device)  # sums of norms
        self.views = torch.zeros(count, dtype=torch.int32, device=device)

    def _densify(
        self,
        step: int,
        adam: NamedAdam,
        generator: torch.Generator,
        *,
        split_too: Bool[Tensor, "n"],
    ) -> None:
        """Clone, split and prune, then reset the averages."""
        self._grow(adam, generator, split_too)
        self._prune(adam, large_too=step > self.schedule.prune_scale_from)
        self._clear(len(adam.tensors["means"]), self.gradients.device)

    def _grow(
        self, adam: NamedAdam, generator: torch.Generator, split_too: Bool[Tensor, "n"]
    ) -> None:
        scales = adam.tensors["log_scales"].exp()
        large = scales.amax(1) > SPLIT_SCALE * self.extent
        cloned, split = self._select(large, split_too)
        once, twice = cloned.nonzero()[:, 0], torch.cat([split.nonzero()[:, 0]] * 2)
        origins, children = torch.cat([once, twice]), slice(len(once), None)
        new = {name: tensor[origins] for name, tensor in adam.tensors.items()}
        noise = torch.randn(len(twice), 3, generator=generator).to(scales.device)
        turn = rotation_matrices(adam.tensors["quats"][twice])
        new["means"][children] += (turn @ (scales[twice] * noise)[:, :, None])[:, :, 0]
        new["log_scales"][children] = (scales[twice] / 1.6).log()
        adam.append_rows(new)
        added = torch.ones(len(new["means"]), dtype=torch.bool, device=scales.device)
        adam.keep_rows(torch.cat([~split, added]))

    def _select(
        self, large: Bool[Tensor, "n"], split_too: Bool[Tensor, "n"]
    ) -> tuple[Bool[Tensor, "n"], Bool[Tensor, "n"]]:
        """Return the Gaussians to clone and to split: those above the threshold, and `split_too`.

        Each clone and each split adds one Gaussian. If `max_splats` does not allow all of them,
        those in `split_too` come first, then those with the largest gradients.
        """
        mean = self.gradients / self.views.clamp_min(1)
        strong = mean >= self.config.gradient
        selected = torch.stack([strong & ~large, strong & large | split_too])  # [2, n]
        room = max(0, self.max_splats - len(mean))
        if int(selected.sum()) > room:
            strength = torch.stack([mean, torch.where(split_too, torch.inf, mean)])
            strength = torch.where(selected, strength, -1).flatten()
            ranked = torch.argsort(strength, descending=True, stable=True)
            selected = torch.zeros_like(selected).flatten().index_fill_(0, ranked[:room], True)
        cloned, split = selected.reshape(2, -1)
        return cloned, split

    def _prune(self, adam: NamedAdam, *, large_too: bool) -> None:
        keep = sigmoid(adam.tensors["logit_opacities"]) >= PRUNE_OPACITY
        if large_too and self.config.prune_scale:
            largest = adam.tensors["log_scales"].amax(1).exp()
            keep &= largest <= self.config.prune_scale * self.extent
        if 0 < int(keep.sum()) < len(keep):
            adam.keep_rows(keep)
