"""The teacher: a plain 3DGS scene, trained with sorted blending."""

import math
from dataclasses import dataclass, field

import torch
from torch import Tensor
from torch.nn.functional import pad

from mobilegs.data.dataset import Dataset, View
from mobilegs.gaussians import Gaussians
from mobilegs.render import render_sorted, visible_rows
from mobilegs.render.scene import Scene
from mobilegs.train.distributed import ALONE, Team
from mobilegs.train.losses import photo_loss
from mobilegs.train.optim import NamedAdam, log_linear
from mobilegs.train.stage import StepResult
from mobilegs.train.teacher.densify import CloneSplit, DensifyConfig, Fixed
from mobilegs.train.teacher.init import initial_gaussians
from mobilegs.train.teacher.mcmc import Mcmc, McmcConfig
from mobilegs.train.teacher.mini_splatting import MiniSplatting, MiniSplattingConfig
from mobilegs.validation import COUNT, DEGREE, FRACTION, NOT_NEGATIVE, POSITIVE, Range, check


@dataclass(frozen=True)
class TeacherConfig:
    """How the teacher is trained. Times are fractions of the run, rates those of Adam."""

    steps: int = 30_000
    """Number of steps."""
    views_per_step: int = 1
    """Photos of a step. Their losses are summed, not averaged: Adam, whose steps do not depend on
    the gradients' scale, mostly cancels the factor."""
    max_splats: int = 1_000_000
    """Never more Gaussians than this (while mini_splatting densifies: than its own peak)."""
    init_splats: int = 200_000
    """At most so many to begin with; of more points a random choice is taken."""
    init_opacity: float = 0.1
    """Opacity of all Gaussians at the start, and of those that mini_splatting begins anew."""
    init_scale: float = 1.0
    """Their size at the start, in distances to their neighbours."""
    sh_degree: int = 3
    """Degree that the colour's spherical harmonics reach, 0 to 3."""
    sh_interval: float = 1 / 30
    """Fraction of the run between two raises of that degree, beginning at 0 (with
    mini_splatting: from its draw on)."""
    ssim_weight: float = 0.2
    """Share of D-SSIM in the loss, the rest is L1."""
    position_rate: float = 1.6e-4
    """Rate of the centres at the start, in extents of the scene."""
    position_rate_end: float = 1.6e-6
    """Rate of the centres at the end; in between it falls geometrically."""
    sh0_rate: float = 2.5e-3
    """Rate of the colour's constant part."""
    sh_rest_rate: float = 1.25e-4
    """Rate of its view-dependent part."""
    opacity_rate: float = 0.05
    """Rate of the opacities' logits."""
    scale_rate: float = 5e-3
    """Rate of the scales' logarithms."""
    quat_rate: float = 1e-3
    """Rate of the quaternions."""
    densify: DensifyConfig = field(default_factory=DensifyConfig)
    """How Gaussians are added and removed."""
    mini_splatting: MiniSplattingConfig = field(default_factory=MiniSplattingConfig)
    """What the strategy of that name does besides."""
    mcmc: McmcConfig = field(default_factory=McmcConfig)
    """What the strategy of that name does."""
    min_views: int = 2
    """Gaussians that fewer of the training cameras see are removed in the last step: nothing has
    told how far away they are, and from elsewhere they may be a veil before the eye."""

    def __post_init__(self) -> None:
        rates = ("sh0_rate", "sh_rest_rate", "opacity_rate", "scale_rate", "quat_rate")
        check(
            self,
            **dict.fromkeys(("steps", "views_per_step", "max_splats", "init_splats"), COUNT),
            **dict.fromkeys(("position_rate", "position_rate_end", "init_scale"), POSITIVE),
            **dict.fromkeys((*rates, "min_views"), NOT_NEGATIVE),
            **dict.fromkeys(("sh_interval", "ssim_weight"), FRACTION),
            init_opacity=Range(high=1.0, above=True, below=True),
            sh_degree=DEGREE,
        )


class Teacher:
    """The stage that trains the teacher (3DGS, Kerbl et al. 2023)."""

    name = "teacher"

    def __init__(
        self,
        config: TeacherConfig,
        dataset: Dataset,
        *,
        seed: int,
        device: torch.device,
        team: Team = ALONE,
        start: Gaussians | None = None,
    ) -> None:
        """Start from the capture's points, or random ones; `seed` decides all that is random.

        `start` takes their place: Gaussians that are worth something already, all of whose
        harmonics learn from the first step on.
        """
        self.config = config
        self.steps = config.steps
        self.views_per_step = config.views_per_step
        self.team = team
        self.done = 0
        self.extent = dataset.extent
        self.near = dataset.near
        self.frames = dataset.train
        self.background = dataset.background.to(device)
        self.generator = torch.Generator().manual_seed(seed)
        self.degree_max = config.sh_degree if start is None else start.sh_degree
        self.degree_first = 0 if start is None else start.sh_degree
        given = start is not None
        if start is None:
            start = initial_gaussians(
                dataset,
                count=min(config.init_splats, config.max_splats),
                opacity=config.init_opacity,
                sh_degree=config.sh_degree,
                generator=self.generator,
            )
            start.log_scales += math.log(config.init_scale)
        self.strategy = self._strategy(len(start), device)
        tensors = start.to(device).tensors()
        sh = tensors.pop("sh")
        rest = sh[:, 1:1] if self.strategy.harmonics_wait and not given else sh[:, 1:]
        self.adam = NamedAdam({**tensors, "sh0": sh[:, :1], "sh_rest": rest}, self._rates())

    @property
    def phase(self) -> str:
        """`densify` while Gaussians may still be added, then `refine`."""
        return "densify" if self.done < self.strategy.stop else "refine"

    @property
    def count(self) -> int:
        """Number of Gaussians."""
        return len(self.adam.tensors["means"])

    @property
    def sh_degree(self) -> int:
        """Degree of the harmonics that the next step uses."""
        interval = max(1, round(self.config.sh_interval * self.steps))
        raised = self.strategy.harmonics_clock(self.done) // interval
        return min(self.degree_max, self.degree_first + raised)

    def advance(self, views: list[tuple[int, View]]) -> StepResult:
        """One step on the sum of the views' losses; the result holds their means."""
        for name, rate in self._rates().items():
            self.adam.set_rate(name, rate)
        leaves, shown = list(self.adam.tensors.values()), self._gaussians(0).detached()
        results = []
        for _, view in views:
            results += self.team.add_gradients(leaves, *self._look(view))
        self.done += 1
        order = self.team.in_order([index for index, _ in views])
        for index, (_, _, screen_grads, radii) in zip(order, results, strict=True):
            camera = self.frames[index].camera.to(radii.device)
            seen = {"screen_grads": screen_grads, "radii": radii}
            self.strategy.observe(self.done, shown, camera, **seen)
        self.adam.step()
        self.strategy.after_step(self.done, self.adam, self.generator)
        if self.done == self.steps:
            self._remove_unsupported()
        losses, errors, *_ = zip(*results, strict=True)
        return StepResult(torch.stack(losses).mean(), torch.stack(errors).mean())

    def _look(self, view: View) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Loss and squared error of a view, and what densification observes of it.

        The gradients on the screen are there after the backward pass.
        """
        shown = self._gaussians(self.sh_degree)
        screen_grads = torch.zeros_like(shown.means[:, :2])
        drawn = render_sorted(
            shown.means,
            shown.quats,
            shown.scales,
            shown.opacities,
            shown.sh,
            camera=view.camera,
            background=self.background,
            screen_grads=screen_grads,
        )
        loss = photo_loss(
            drawn.image, view.image, mask=view.mask, ssim_weight=self.config.ssim_weight
        )
        loss = loss + self.strategy.regulariser(shown)
        return loss, squared_error(drawn.image, view), screen_grads, drawn.radii

    def gaussians(self) -> Gaussians:
        """The teacher as it stands, with harmonics of the full degree."""
        return self._gaussians(self.degree_max).detached()

    def scene(self) -> Scene:
        """The teacher as it stands, to be drawn sorted."""
        return Scene(self.gaussians(), "sorted", background=self.background, near=self.near)

    def state(self) -> dict:
        """Everything the rest of the training depends on."""
        return {
            "done": self.done,
            "generator": self.generator.get_state(),
            "adam": self.adam.state(),
            "strategy": self.strategy.state(),
        }

    def restore(self, state: dict) -> None:
        """Continue from what `state()` gave."""
        self.done = state["done"]
        self.generator.set_state(state["generator"])
        self.adam.restore(state["adam"])
        self.strategy.restore(state["strategy"])

    def _strategy(self, count: int, device: torch.device) -> Fixed:
        config, densify = self.config, self.config.densify
        if densify.strategy == "fixed":
            return Fixed()
        run = {"steps": config.steps, "max_splats": config.max_splats}
        if densify.strategy == "mcmc":
            return Mcmc(densify, config.mcmc, **run)
        start = {"extent": self.extent, "count": count, "device": device}
        if densify.strategy == "clone_split":
            return CloneSplit(densify, **run, **start)
        begin = {"frames": self.frames, "opacity": config.init_opacity}
        begin["sh_degree"] = self.degree_max
        return MiniSplatting(densify, config.mini_splatting, **run, **start, **begin)

    @torch.no_grad()
    def _remove_unsupported(self) -> None:
        gaussians = self.gaussians()
        views = torch.zeros(len(gaussians), dtype=torch.int32, device=gaussians.means.device)
        for frame in self.frames:
            camera = frame.camera.to(views.device)
            quats, scales = gaussians.quats, gaussians.scales
            views[visible_rows(gaussians.means, quats, scales, camera=camera)] += 1
        keep = views >= min(self.config.min_views, len(self.frames))
        if keep.any() and not keep.all():
            self.adam.keep_rows(keep)

    def _gaussians(self, degree: int) -> Gaussians:
        tensors, columns = self.adam.tensors, (degree + 1) ** 2 - 1
        rest = tensors["sh_rest"][:, :columns]
        if rest.shape[1] < columns:  # they still wait
            rest = pad(rest, (0, 0, 0, columns - rest.shape[1]))
        return Gaussians(
            means=tensors["means"],
            quats=tensors["quats"],
            log_scales=tensors["log_scales"],
            logit_opacities=tensors["logit_opacities"],
            sh=torch.cat([tensors["sh0"], rest], dim=1),
        )

    def _rates(self) -> dict[str, float]:
        config = self.config
        progress = self.strategy.rate_clock(self.done) / self.steps
        position = log_linear(config.position_rate, config.position_rate_end, progress)
        return {
            "means": position * self.extent,
            "quats": config.quat_rate,
            "log_scales": config.scale_rate,
            "logit_opacities": config.opacity_rate,
            "sh0": config.sh0_rate,
            "sh_rest": config.sh_rest_rate,
        }


@torch.no_grad()
def squared_error(image: Tensor, view: View) -> Tensor:
    """Mean squared difference to the photo over the pixels that count."""
    error = (image - view.image).square().mean(2)
    if view.mask is None:
        return error.mean()
    return (error * view.mask).sum() / view.mask.sum().clamp_min(1)
