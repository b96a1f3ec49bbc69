"""Where the teacher grows: Gaussians whose position the pictures pull at are cloned or split."""

from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render.project import rotation_matrices
from mobilegs.train.optim import NamedAdam
from mobilegs.validation import FRACTION, NOT_NEGATIVE, check


@dataclass(frozen=True)
class DensifyConfig:
    """When and where Gaussians are added and removed (3DGS, section 5.2)."""

    strategy: Literal["clone_split", "mini_splatting", "mcmc", "fixed"] = "clone_split"
    """`clone_split` is 3DGS's; `mini_splatting` also begins anew from surfaces and samples what
    matters; `mcmc` moves what is faint, up to max_splats; `fixed` keeps the Gaussians that
    training starts with. The fields below are clone_split's, of which mini_splatting makes use;
    mcmc only of `start`, `interval` and `min_interval`."""
    start: float = 1 / 60
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

    def __post_init__(self) -> None:
        times = ("start", "stop", "interval", "prune_scale_from", "opacity_reset")
        sizes = ("gradient", "split_scale", "prune_scale", "min_interval")
        check(
            self,
            **dict.fromkeys((*times, "prune_opacity"), FRACTION),
            **dict.fromkeys(sizes, NOT_NEGATIVE),
        )


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


class Fixed:
    """Keeps the Gaussians that training starts with; other strategies differ in what they say."""

    stop = 0
    """Gaussians are added before this step."""
    harmonics_wait = False
    """Whether there are none but of degree 0 until the strategy brings them, with a new Adam."""

    def rate_clock(self, done: int) -> int:
        """After `done` steps: how many the schedule of the centres' rate has behind it."""
        return done

    def harmonics_clock(self, done: int) -> int:
        """After `done` steps: how many the schedule of the harmonics' degree has behind it."""
        return done

    def regulariser(self, gaussians: Gaussians) -> Float[Tensor, ""]:
        """What is added to the loss."""
        return gaussians.means.new_zeros(())

    def observe(
        self,
        step: int,
        gaussians: Gaussians,
        camera: Camera,
        *,
        screen_grads: Float[Tensor, "n 2"],
        radii: Float[Tensor, "n"],
    ) -> None:
        """Take note of a picture of `gaussians`, before step number `step` (from 1) moves them.

        `screen_grads` are the gradients of the projected centres, in 1 / px.
        """

    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Change the rows if the schedule says so after step number `step` (from 1)."""

    def state(self) -> dict:
        """Everything that later changes depend on."""
        return {}

    def restore(self, state: dict) -> None:
        """Take back what `state()` gave."""


class CloneSplit(Fixed):
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
        self.stop = self.schedule.stop
        self.extent = extent
        self.max_splats = max_splats
        self._clear(count, device)

    def observe(
        self,
        step: int,
        gaussians: Gaussians,
        camera: Camera,
        *,
        screen_grads: Float[Tensor, "n 2"],
        radii: Float[Tensor, "n"],
    ) -> None:
        """Add one picture's gradients to the averages."""
        if step >= self.stop:
            return
        half = screen_grads.new_tensor([camera.width / 2, camera.height / 2])
        self.gradients += (screen_grads * half).norm(dim=1)
        self.views += radii > 0

    @torch.no_grad()
    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Grow and prune, reset opacities."""
        when = self.schedule
        if not when.start < step < when.stop:
            return
        if step % when.interval == 0:
            nobody = torch.zeros_like(self.views, dtype=torch.bool)
            self._densify(step, adam, generator, split_too=nobody)
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

    def _densify(
        self,
        step: int,
        adam: NamedAdam,
        generator: torch.Generator,
        *,
        split_too: Bool[Tensor, "n"],
    ) -> None:
        """Grow, prune, and begin new averages."""
        self._grow(adam, generator, split_too)
        self._prune(adam, large_too=step > self.schedule.prune_scale_from)
        self._clear(len(adam.tensors["means"]), self.gradients.device)

    def _grow(
        self, adam: NamedAdam, generator: torch.Generator, split_too: Bool[Tensor, "n"]
    ) -> None:
        scales = adam.tensors["log_scales"].exp()
        large = scales.amax(1) > self.config.split_scale * self.extent
        cloned, split = self._chosen(large, split_too)
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
        added = torch.ones(len(new["means"]), dtype=torch.bool, device=scales.device)
        adam.keep_rows(torch.cat([~split, added]))

    def _chosen(
        self, large: Bool[Tensor, "n"], split_too: Bool[Tensor, "n"]
    ) -> tuple[Bool[Tensor, "n"], Bool[Tensor, "n"]]:
        """Which are cloned and which are split: those over the threshold, and `split_too`.

        Each clone and each split adds one. Where there is no room for all, `split_too` comes
        first, then what is pulled at most.
        """
        mean = self.gradients / self.views.clamp_min(1)
        pulled = mean >= self.config.gradient
        wanted = torch.stack([pulled & ~large, pulled & large | split_too])  # [2, n]
        room = max(0, self.max_splats - len(mean))
        if int(wanted.sum()) > room:
            strength = torch.stack([mean, torch.where(split_too, torch.inf, mean)])
            strength = torch.where(wanted, strength, -1).flatten()
            ranked = torch.argsort(strength, descending=True, stable=True)
            wanted = torch.zeros_like(wanted).flatten().index_fill_(0, ranked[:room], True)
        cloned, split = wanted.reshape(2, -1)
        return cloned, split

    def _prune(self, adam: NamedAdam, *, large_too: bool) -> None:
        keep = adam.tensors["logit_opacities"].sigmoid() >= self.config.prune_opacity
        if large_too and self.config.prune_scale:
            largest = adam.tensors["log_scales"].amax(1).exp()
            keep &= largest <= self.config.prune_scale * self.extent
        if keep.any() and not keep.all():
            adam.keep_rows(keep)
