"""Mini-Splatting (Fang and Wang 2024): few Gaussians, placed on surfaces."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.data.dataset import Frame
from mobilegs.gaussians import Gaussians
from mobilegs.render import Footprint, measure_contributions
from mobilegs.train.optim import NamedAdam
from mobilegs.train.teacher.densify import CloneSplit, DensifyConfig
from mobilegs.train.teacher.importance import Metric, importance, importance_mask, sample_rows
from mobilegs.train.teacher.init import gaussians_at
from mobilegs.train.teacher.surface_points import surface_points
from mobilegs.validation import POSITIVE, SHARE, check

Event = Literal["", "densify", "reinit", "sample", "trim"]
BLUR_AREA = 1 / 5000  # share of an image: a Gaussian with the largest weight in more is split
# the following are times, fractions of the run
REINIT_INTERVAL = 1 / 6  # between two restarts during densification (5,000 of 30,000)
TRIM_AT = 2 / 3  # when the least important Gaussians are removed (20,000 of 30,000)
REWIND_TO = 1 / 6  # point of the means' schedule that follows the sampling (5,000 of 30,000)


@dataclass(frozen=True)
class MiniSplattingConfig:
    """Settings of `mini_splatting` in addition to densification; times are fractions of the run.

    At the end of densification (15,000 of 30,000), half of the important Gaussians
    are sampled. From there the SH degree rises, and the schedule of the means' learning rate goes
    back to its first sixth. The numbers in parentheses are the paper's.
    """

    reinit_splats: float = 3.5
    """Gaussians after a restart, in multiples of max_splats (3.5 million of 1 million)."""
    peak_splats: float = 4.5
    """Maximum of Gaussians during densification, in multiples of max_splats."""
    sampled: float = 0.5
    """Share of the Gaussians with importance above 0 that are sampled when densification ends."""
    trim_keeps: float = 0.99
    """Share of the total importance that remains when the least important Gaussians are removed, at
    two thirds of the run (20,000 of 30,000)."""

    def __post_init__(self) -> None:
        check(
            self,
            **dict.fromkeys(("reinit_splats", "peak_splats"), POSITIVE),
            **dict.fromkeys(("sampled", "trim_keeps"), SHARE),
        )


class MiniSplatting(CloneSplit):
    """Densification with blur splits, restarts from surface points, and importance sampling."""

    def __init__(
        self,
        config: DensifyConfig,
        mini: MiniSplattingConfig,
        *,
        frames: Sequence[Frame],
        opacity: float,
        sh_degree: int,
        footprint: Footprint,
        metric: Metric,
        steps: int,
        extent: float,
        max_splats: int,
        count: int,
        device: torch.device,
    ) -> None:
        """`frames` are the training photos, `opacity` is that of restarted Gaussians.

        `sh_degree` is the final SH degree, `footprint` that of the scene, `metric` that of
        importance. The other arguments are those of `CloneSplit`.
        """
        super().__init__(
            config,
            steps=steps,
            extent=extent,
            max_splats=max(max_splats, round(mini.peak_splats * max_splats)),
            count=count,
            device=device,
        )
        self.mini, self.frames, self.opacity = mini, frames, opacity
        self.footprint = footprint
        self.metric: Metric = metric
        self.final_splats = max_splats
        self.sh_delayed = self.stop > 0
        self.columns = (sh_degree + 1) ** 2 - 1
        self.reinit_splats = min(round(mini.reinit_splats * max_splats), self.max_splats)
        self.reinit_interval = round(REINIT_INTERVAL * steps)
        self.trim = self.last_event = max(round(TRIM_AT * steps), self.stop + 1)
        self.rewind_to = round(REWIND_TO * steps)

    def shorten(self, steps: int) -> None:
        """Keep the steps of sampling and trimming."""

    def event(self, step: int) -> Event:
        """Return the event after step number `step` (from 1)."""
        schedule = self.schedule
        if step >= schedule.stop:
            return "sample" if step == schedule.stop else "trim" if step == self.trim else ""
        # no restart shortly before the sampling, for which the Gaussians must have been trained
        soon = schedule.stop - step < self.reinit_interval / 2
        if self.reinit_interval and step % self.reinit_interval == 0 and not soon:
            return "reinit"
        return "densify" if step > schedule.start and step % schedule.interval == 0 else ""

    def lr_step(self, done: int) -> int:
        """Count steps from 1, and from `rewind_to` after the sampling."""
        step = done + 1
        return step if step < self.stop else step - self.stop + self.rewind_to

    def sh_step(self, done: int) -> int:
        """Count steps from the sampling."""
        return max(0, done + 1 - self.stop)

    @torch.no_grad()
    def observe(
        self,
        step: int,
        gaussians: Gaussians,
        camera: Camera,
        *,
        screen_grads: Float[Tensor, "n 2"],
        radii: Float[Tensor, "n"],
    ) -> None:
        """Add the gradients of a view to the averages, and record Gaussians that blur it."""
        super().observe(step, gaussians, camera, screen_grads=screen_grads, radii=radii)
        if step >= self.stop:
            return
        shapes = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities)
        contributions = measure_contributions(*shapes, camera=camera, footprint=self.footprint)
        self.blurred |= contributions.largest > BLUR_AREA * camera.width * camera.height

    @torch.no_grad()
    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Densify, restart, sample and trim by the schedule."""
        event = self.event(step)
        if event == "densify":
            self._densify(step, adam, generator, split_too=self.blurred)
        elif event == "reinit":
            self._reinit(adam, generator)
        elif event == "sample":
            self._sample(adam, generator)
        elif event == "trim":
            keep = importance_mask(self._importance(adam), self.mini.trim_keeps)
            adam.replace_all({name: tensor[keep] for name, tensor in adam.tensors.items()})

    def keep_rows(self, rows: Bool[Tensor, "n"]) -> None:
        super().keep_rows(rows)
        self.blurred = self.blurred[rows]

    def state(self) -> dict:
        return {**super().state(), "blurred": self.blurred}

    def restore(self, state: dict) -> None:
        super().restore(state)
        self.blurred = state["blurred"].to(self.gradients.device)

    def _clear(self, count: int, device: torch.device) -> None:
        super()._clear(count, device)
        self.blurred = torch.zeros(count, dtype=torch.bool, device=device)

    def _reinit(self, adam: NamedAdam, generator: torch.Generator) -> None:
        """Replace all Gaussians by isotropic ones at surface points, in the photos' colours."""
        points, colors = surface_points(
            constant_color(adam),
            self.frames,
            count=self.reinit_splats,
            generator=generator,
            footprint=self.footprint,
        )
        if len(points):
            new = gaussians_at(points.cpu(), colors.cpu(), opacity=self.opacity, sh_degree=0)
            self._replace_all(adam, new, columns=adam.tensors["sh_rest"].shape[1])
        self._clear(len(adam.tensors["means"]), self.gradients.device)

    def _sample(self, adam: NamedAdam, generator: torch.Generator) -> None:
        """Sample Gaussians by importance; they keep their means and constant colours."""
        scores = self._importance(adam)
        count = int(self.mini.sampled * int((scores > 0).sum()))
        rows = sample_rows(scores, min(max(1, count), self.final_splats), generator)
        if not len(rows):  # no Gaussian is visible
            rows = torch.arange(min(len(scores), self.final_splats))
        means, sh0 = (adam.tensors[name].detach().cpu()[rows] for name in ("means", "sh0"))
        new = gaussians_at(means, torch.zeros_like(means), opacity=self.opacity, sh_degree=0)
        new.sh = sh0
        self._replace_all(adam, new, columns=self.columns)

    def _replace_all(self, adam: NamedAdam, gaussians: Gaussians, *, columns: int) -> None:
        tensors = gaussians.to(self.gradients.device).tensors()
        zeros = tensors["sh"].new_zeros(len(gaussians), columns, 3)
        adam.replace_all({**tensors, "sh0": tensors["sh"], "sh_rest": zeros})

    def _importance(self, adam: NamedAdam) -> Float[Tensor, "n"]:
        cameras = [frame.camera for frame in self.frames]
        return importance(constant_color(adam), cameras, self.metric, self.footprint)


def constant_color(adam: NamedAdam) -> Gaussians:
    """Return the Gaussians of the teacher's optimiser with constant colours."""
    names = ("means", "quats", "log_scales", "logit_opacities")
    shapes = {name: adam.tensors[name].detach() for name in names}
    return Gaussians(**shapes, sh=adam.tensors["sh0"].detach())
