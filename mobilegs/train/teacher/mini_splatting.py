"""Mini-Splatting (Fang and Wang 2024): few Gaussians, placed where surfaces are."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.data.dataset import Frame
from mobilegs.gaussians import Gaussians
from mobilegs.render import measure_contributions
from mobilegs.train.optim import NamedAdam
from mobilegs.train.teacher.densify import CloneSplit, DensifyConfig
from mobilegs.train.teacher.importance import Metric, drawn_rows, holding_most, importance
from mobilegs.train.teacher.init import gaussians_at
from mobilegs.train.teacher.surface_points import surface_points
from mobilegs.validation import FRACTION, POSITIVE, SHARE, check

Event = Literal["", "densify", "reinitialise", "sample", "trim"]


@dataclass(frozen=True)
class MiniSplattingConfig:
    """What `mini_splatting` does beside 3DGS's densification; times are fractions of the run.

    Densification ends (`densify.stop`, 15,000 of 30,000) with a draw that leaves half of the
    Gaussians that matter. Harmonics rise and the centres' rate is wound back from then on.
    """

    blur: float = 1 / 5000
    """A Gaussian that has the largest share of more than this fraction of a picture is split."""
    reinit_interval: float = 1 / 6
    """Time between two new beginnings from the surfaces seen so far, while densifying (5,000 of
    30,000); 0 never begins anew."""
    reinit_splats: float = 3.5
    """Gaussians of a new beginning, in multiples of max_splats (3.5 million of 1 million)."""
    peak_splats: float = 4.5
    """Most Gaussians while densifying, in multiples of max_splats, which holds afterwards."""
    metric: Metric = "indoor"
    """What Gaussians are worth: `indoor` by all they add to the photos, `outdoor` by their mean
    share of the pixels they touch, which favours the small and far."""
    sampled: float = 0.5
    """Share of the Gaussians with any importance that the draw at densify.stop leaves."""
    trim_at: float = 2 / 3
    """When the least important Gaussians are removed (20,000 of 30,000)."""
    trim_keeps: float = 0.99
    """Share of the total importance that remains."""
    rewind_to: float = 1 / 6
    """Where the schedule of the centres' rate goes on after the draw (at 5,000 of 30,000)."""

    def __post_init__(self) -> None:
        check(
            self,
            **dict.fromkeys(("blur", "reinit_splats", "peak_splats"), POSITIVE),
            **dict.fromkeys(("reinit_interval", "trim_at", "rewind_to"), FRACTION),
            **dict.fromkeys(("sampled", "trim_keeps"), SHARE),
        )


class MiniSplatting(CloneSplit):
    """Densification that also splits what blurs, begins anew from surfaces, and samples."""

    def __init__(
        self,
        config: DensifyConfig,
        more: MiniSplattingConfig,
        *,
        frames: Sequence[Frame],
        opacity: float,
        sh_degree: int,
        steps: int,
        extent: float,
        max_splats: int,
        count: int,
        device: torch.device,
    ) -> None:
        """`frames` are the training photos; `opacity` is that of Gaussians that begin anew.

        `sh_degree` is what harmonics reach after the draw.
        """
        super().__init__(
            config,
            steps=steps,
            extent=extent,
            max_splats=max(max_splats, round(more.peak_splats * max_splats)),
            count=count,
            device=device,
        )
        self.more, self.frames, self.opacity = more, frames, opacity
        self.left_splats = max_splats
        self.harmonics_wait = self.stop > 0
        self.columns = (sh_degree + 1) ** 2 - 1
        self.reinit_splats = min(round(more.reinit_splats * max_splats), self.max_splats)
        self.reinit_interval = round(more.reinit_interval * steps)
        self.trim = max(round(more.trim_at * steps), self.stop + 1)
        self.rewind_to = round(more.rewind_to * steps)

    def event(self, step: int) -> Event:
        """What happens after step number `step` (from 1)."""
        when = self.schedule
        if step >= when.stop:
            return "sample" if step == when.stop else "trim" if step == self.trim else ""
        # steps may be no multiple of 6, and what the draw looks at has to have learned
        soon = when.stop - step < self.reinit_interval / 2
        if self.reinit_interval and step % self.reinit_interval == 0 and not soon:
            return "reinitialise"
        return "densify" if step > when.start and step % when.interval == 0 else ""

    def rate_clock(self, done: int) -> int:
        """Counts steps from 1, and goes on at `rewind_to` from the draw on."""
        step = done + 1
        return step if step < self.stop else step - self.stop + self.rewind_to

    def harmonics_clock(self, done: int) -> int:
        """Begins with the draw."""
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
        """Add one picture's gradients to the averages, and remember who covers much of it."""
        super().observe(step, gaussians, camera, screen_grads=screen_grads, radii=radii)
        if step >= self.stop:
            return
        shapes = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities)
        largest = measure_contributions(*shapes, camera=camera).largest
        self.blurred |= largest > self.more.blur * camera.width * camera.height

    @torch.no_grad()
    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Densify, begin anew, draw, trim."""
        event = self.event(step)
        if event == "densify":
            self._densify(step, adam, generator, split_too=self.blurred)
        elif event == "reinitialise":
            self._reinitialise(adam, generator)
        elif event == "sample":
            self._sample(adam, generator)
        elif event == "trim":
            keep = holding_most(self._importance(adam), self.more.trim_keeps)
            adam.restart({name: tensor[keep] for name, tensor in adam.tensors.items()})

    def state(self) -> dict:
        """The averages so far, and who was seen to blur."""
        return {**super().state(), "blurred": self.blurred}

    def restore(self, state: dict) -> None:
        """Take back what `state()` gave."""
        super().restore(state)
        self.blurred = state["blurred"].to(self.gradients.device)

    def _clear(self, count: int, device: torch.device) -> None:
        super()._clear(count, device)
        self.blurred = torch.zeros(count, dtype=torch.bool, device=device)

    def _reinitialise(self, adam: NamedAdam, generator: torch.Generator) -> None:
        """Round Gaussians on the surfaces, in the photos' colours, take the place of all."""
        points, colors = surface_points(
            shown(adam), self.frames, count=self.reinit_splats, generator=generator
        )
        if len(points):
            new = gaussians_at(points.cpu(), colors.cpu(), opacity=self.opacity, sh_degree=0)
            self._begin_anew(adam, new, columns=adam.tensors["sh_rest"].shape[1])
        self._clear(len(adam.tensors["means"]), self.gradients.device)

    def _sample(self, adam: NamedAdam, generator: torch.Generator) -> None:
        """Draw those that stay by importance; they keep their places and mean colours."""
        worth = self._importance(adam)
        count = int(self.more.sampled * int((worth > 0).sum()))
        rows = drawn_rows(worth, min(max(1, count), self.left_splats), generator)
        if not len(rows):  # nobody is seen: nothing says who matters
            rows = torch.arange(min(len(worth), self.left_splats))
        means, sh0 = (adam.tensors[name].detach().cpu()[rows] for name in ("means", "sh0"))
        new = gaussians_at(means, torch.zeros_like(means), opacity=self.opacity, sh_degree=0)
        new.sh = sh0
        self._begin_anew(adam, new, columns=self.columns)

    def _begin_anew(self, adam: NamedAdam, gaussians: Gaussians, *, columns: int) -> None:
        tensors = gaussians.to(self.gradients.device).tensors()
        zeros = tensors["sh"].new_zeros(len(gaussians), columns, 3)
        adam.restart({**tensors, "sh0": tensors["sh"], "sh_rest": zeros})

    def _importance(self, adam: NamedAdam) -> Float[Tensor, "n"]:
        cameras = [frame.camera for frame in self.frames]
        return importance(shown(adam), cameras, self.more.metric)


def shown(adam: NamedAdam) -> Gaussians:
    """The Gaussians that an optimiser of the teacher moves, in their mean colours."""
    names = ("means", "quats", "log_scales", "logit_opacities")
    shapes = {name: adam.tensors[name].detach() for name in names}
    return Gaussians(**shapes, sh=adam.tensors["sh0"].detach())
