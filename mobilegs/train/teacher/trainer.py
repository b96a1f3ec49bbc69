"""Training of the teacher, a plain 3DGS scene, with sorted blending (Kerbl et al. 2023)."""

import math
from dataclasses import dataclass, field, fields
from typing import Any

import torch
from torch import Tensor
from torch.nn.functional import pad

from mobilegs.camera import MIN_SIDE, Camera
from mobilegs.data.dataset import Dataset, View
from mobilegs.gaussians import Gaussians
from mobilegs.render import Footprint, render_raw, render_sorted, visible_rows
from mobilegs.render.inputs import MoreHarmonics, RenderInputs, RenderSettings
from mobilegs.render.project import SortedFootprint
from mobilegs.render.scene import Scene
from mobilegs.train.distributed import SINGLE_PROCESS, Team
from mobilegs.train.exposure import START as EXPOSURE_START
from mobilegs.train.exposure import ExposureConfig, Exposures, exposures_for
from mobilegs.train.losses import photo_loss_and_error
from mobilegs.train.optim import NamedAdam, exponential_lr
from mobilegs.train.poses import LRS as POSE_LRS
from mobilegs.train.poses import START as POSE_START
from mobilegs.train.poses import PoseConfig, Poses
from mobilegs.train.sampling import LIMIT_EVERY, limit_scales
from mobilegs.train.stage import StepResult
from mobilegs.train.teacher.densify import CloneSplit, DensifyConfig, Fixed
from mobilegs.train.teacher.far import hidden_far
from mobilegs.train.teacher.importance import Metric
from mobilegs.train.teacher.init import initial_gaussians
from mobilegs.train.teacher.mcmc import Mcmc
from mobilegs.train.teacher.mini_splatting import MiniSplatting, MiniSplattingConfig
from mobilegs.train.times import ROUNDING, Times
from mobilegs.validation import (
    COUNT,
    DEGREE,
    FRACTION,
    NOT_NEGATIVE,
    POSITIVE,
    SHARE,
    check,
    check_choice,
)

INIT_OPACITY = 0.1  # of initial Gaussians, and after restarts of mini_splatting
MEANS_LR_RATIO = 100  # of the means' learning rate at the start to that at the end
DECAY_FROM = 0.5  # time from which the other learning rates fall
FULL_SIZE_FROM = 0.4  # time from which on photos have their full size
FAR_CHECKED = 0.3  # time at which `far_visibility` is checked
SH_INTERVAL = 1 / 30  # time after which the degree of the harmonics rises by 1


@dataclass(frozen=True)
class TeacherLearningRates:
    """Learning rates of Adam."""

    means: float = 1.6e-4
    """Learning rate of the means at the start, in extents of the scene, above 0. It falls
    geometrically to a hundredth."""
    quats: float = 1e-3
    """Learning rate of the quaternions, at least 0."""
    scales: float = 5e-3
    """Learning rate of the log-scales, at least 0."""
    opacities: float = 0.05
    """Learning rate of the logits of the opacities, at least 0."""
    sh0: float = 2.5e-3
    """Learning rate of the constant part of the colour, at least 0."""
    sh_rest: float = 1.25e-4
    """Learning rate of the view-dependent part of the colour, at least 0."""

    final_factor: float = 1.0
    """Factor on the other learning rates at the end, above 0 and at most 1 (3DGS: 1). In the second
    half of the run it falls geometrically from 1."""

    def __post_init__(self) -> None:
        rates = {field.name: NOT_NEGATIVE for field in fields(self)}
        check(self, **(rates | {"means": POSITIVE, "final_factor": SHARE}))


@dataclass(frozen=True)
class TeacherConfig:
    """Settings of the teacher. Times are fractions of its steps."""

    steps: int = 30_000
    """Number of steps."""
    views_per_step: int = 1
    """Photos per step. Their losses are summed, not averaged; Adam, which does not depend on the
    scale of gradients, mostly cancels the factor."""
    first_divisor: int = 1
    """Divisor of the photos' width and height in the first step; 1: all steps see the full size.
    In the first 0.4 of the steps it falls to 1, in equal times by equal factors."""
    max_splats: int = 1_000_000
    """Maximum number of Gaussians; mini_splatting exceeds it during densification (peak_splats)."""
    init_splats: int = 200_000
    """Maximum number of initial Gaussians; a random choice if the capture has more points."""
    far_splats: int = 0
    """Maximum number of initial Gaussians that lie on a far sphere, 0 or more: skies, and what is
    behind the scene where it has holes. Its radius is 20 extents of the scene. None if photos are
    transparent around an object. Large Gaussians must not be pruned (`densify.prune_scale=0`)."""
    far_visibility: float = 0.0
    """Visibility, 0 to 1, below which Gaussians near the far sphere are removed after 0.3 of the
    steps, in a room for example: the share of their blending weight that is left by what lies
    before them. 0 removes none."""
    sh_degree: int = 3
    """Final degree of the colour's spherical harmonics, 0 to 3. The degree, at first 0, rises by 1
    every thirtieth of the run; mini_splatting counts from its sampling."""
    sh_every: int = 1
    """Steps between two of Adam on the harmonics above degree 0. Their gradients add up meanwhile,
    and the learning rate is multiplied by this number. 3DGS: 1."""
    ssim_weight: float = 0.2
    """Weight of 1 - SSIM in the loss; the rest is L1."""
    footprint: SortedFootprint = field(
        default_factory=lambda: SortedFootprint(0.1, antialiased=True)
    )
    """Blur of Gaussians on the image, in training and in the scene: that of Mip-Splatting. 3DGS has
    a blur of 0.3 and no compensation."""
    least_variance: float = 0.2
    """Lower limit of the squared scales, in squared distances between pixels of the training camera
    that samples a Gaussian most finely (Mip-Splatting's filter); 0: no limit, as in 3DGS."""
    lr: TeacherLearningRates = field(default_factory=TeacherLearningRates)
    """Learning rates."""
    exposure: ExposureConfig = field(default_factory=ExposureConfig)
    """Exposure and white balance of each photo."""
    pose: PoseConfig = field(default_factory=PoseConfig)
    """Corrections of the photos' poses, which the student takes over."""
    densify: DensifyConfig = field(default_factory=DensifyConfig)
    """Adding and removing of Gaussians."""
    mini_splatting: MiniSplattingConfig = field(default_factory=MiniSplattingConfig)
    """Additional settings of the strategy mini_splatting."""
    importance: Metric = "indoor"
    """Importance of Gaussians, by which mini_splatting samples: `indoor` sums their weights in all
    pixels, `outdoor` averages them over the pixels that they touch, which favours small and distant
    ones. Mini-Splatting uses `outdoor` for the outdoor captures of Mip-NeRF 360 and for Tanks and
    Temples."""
    min_views: int = 2
    """Gaussians in the sight of fewer training cameras are removed in the last step: their depth is
    undetermined, and from other places they can cover the view."""

    def __post_init__(self) -> None:
        check(
            self,
            **dict.fromkeys(
                (
                    "steps",
                    "views_per_step",
                    "max_splats",
                    "init_splats",
                    "first_divisor",
                    "sh_every",
                ),
                COUNT,
            ),
            **dict.fromkeys(("min_views", "least_variance", "far_splats"), NOT_NEGATIVE),
            **dict.fromkeys(("ssim_weight", "far_visibility"), FRACTION),
            sh_degree=DEGREE,
        )
        check_choice("importance", self.importance, Metric)

    @property
    def scene_footprint(self) -> Footprint:
        """The footprint of the teacher's scene."""
        return Footprint(self.footprint.blur, self.footprint.antialiased)


class Teacher:
    """The training of a teacher: plain 3DGS with sorted blending (Kerbl et al. 2023).

    A step renders photos, takes a step of Adam on `photo_loss`, and adds or removes Gaussians by
    the strategy of `config.densify`.

    Example:

        dataset = load_capture("my_capture")
        teacher = Teacher(TeacherConfig(steps=500), dataset, seed=0, device=torch.device("cpu"))
        while teacher.done < teacher.steps:
            index = teacher.done % len(dataset.train)
            teacher.advance([(index, load_view(dataset.train[index]))])
        write_ply("teacher.ply", teacher.gaussians(), footprint=teacher.config.footprint)
    """

    name = "teacher"

    def __init__(
        self,
        config: TeacherConfig,
        dataset: Dataset,
        *,
        seed: int,
        device: torch.device,
        team: Team = SINGLE_PROCESS,
        start: Gaussians | None = None,
    ) -> None:
        """Start from the capture's points, or from random ones if it has none.

        Args:
            config: all settings. `TeacherConfig` raises InputError for values out of range.
            dataset: the capture; at least one training photo.
            seed: of all random choices.
            device: that trains.
            team: the processes that share the views of a step.
            start: trained Gaussians in place of points; all harmonics train from the first step.
        """
        self.config = config
        self.times = Times(config.steps)
        self.views_per_step = config.views_per_step
        self.team = team
        self.done = 0
        self.dataset = dataset
        self.extent = dataset.extent
        self.near = dataset.near
        self.frames = dataset.train
        self.shortest_side = min(min(f.camera.width, f.camera.height) for f in self.frames)
        self.background = dataset.background.to(device)
        self._reduced: tuple[int, list[Camera]] = 0, []  # divisor and cameras
        self.exposures: Exposures | None = None
        self.poses: Poses | None = None
        if config.pose.learned:
            cameras = [frame.camera.to(device) for frame in self.frames]
            self.poses = Poses(cameras, self.extent, POSE_LRS)
        self.generator = torch.Generator().manual_seed(seed)
        self.degree_max = config.sh_degree if start is None else start.sh_degree
        self.degree_first = 0 if start is None else start.sh_degree
        given = start is not None
        if start is None:
            start = initial_gaussians(
                dataset,
                count=min(config.init_splats, config.max_splats),
                opacity=INIT_OPACITY,
                sh_degree=config.sh_degree,
                generator=self.generator,
                far=config.far_splats,
            )
        far = config.far_splats and config.far_visibility and not given
        self.far_check = round(FAR_CHECKED * self.steps) if far else 0
        self.strategy = self._strategy(len(start), device)
        tensors = start.to(device).tensors()
        sh = tensors.pop("sh")
        rest = sh[:, 1:1] if self.strategy.sh_delayed and not given else sh[:, 1:]
        self.adam = NamedAdam({**tensors, "sh0": sh[:, :1], "sh_rest": rest}, self._lrs())

    @property
    def runs_kernels(self) -> bool:
        """True: renderers, losses and Adam of a teacher are kernels."""
        return True

    @property
    def phase(self) -> str:
        """`densify` while Gaussians can be added, then `refine`."""
        return "densify" if self.done < self.strategy.stop else "refine"

    @property
    def count(self) -> int:
        """Number of Gaussians."""
        return len(self.adam.tensors["means"])

    @property
    def sh_degree(self) -> int:
        """Degree of the harmonics in the next step."""
        raised = int(self.times.of(self.strategy.sh_step(self.done)) / SH_INTERVAL + ROUNDING)
        return min(self.degree_max, self.degree_first + raised)

    @property
    def steps(self) -> int:
        """Number of steps in total."""
        return self.times.steps

    def set_steps(self, steps: int, at: int) -> None:
        """Change the number of steps in total, when `at` of them are done.

        Fewer steps end densification earlier. They last at least until the last Gaussians come or
        go.
        """
        self.strategy.shorten(steps)
        self.times.set_steps(max(steps, self.strategy.last_event + 1, self.far_check + 1), at)

    @property
    def divisor(self) -> int:
        """Divisor of the photos' size in the next step."""
        config = self.config
        left = 1 - self.times.of(self.done) / FULL_SIZE_FROM
        divisor = math.ceil(config.first_divisor ** max(0.0, left))
        return max(1, min(divisor, self.shortest_side // MIN_SIDE))

    def advance(self, views: list[tuple[int, View]]) -> StepResult:
        """Take a step on the sum of the views' losses; the result has their means.

        `views` are this process's share of the views of a step, each with its index in
        `dataset.train`, and with images on the device: `[h, w, 3]` in [0, 1].
        """
        for name, rate in self._lrs().items():
            self.adam.set_lr(name, rate)
        spread = self._begin_exposures()
        shown, poses = self._gaussians(0).detached(), None
        if self.times.of(self.done) >= POSE_START:
            poses = self.poses
        leaves = [t for name, t in self.adam.tensors.items() if name != "sh_rest" or poses]
        leaves += [] if self.exposures is None else self.exposures.leaves
        leaves += [] if poses is None else [poses.motions]
        results, divisor = [], self.divisor
        cameras = self._cameras(divisor)
        for index, view in views:
            loss = self._view_loss(index, view.reduced(divisor, cameras[index]), poses)
            results += self.team.accumulate_gradients(leaves, *loss)
        self.done += 1
        if self.exposures is not None:
            self.exposures.step(self.times.of(self.done))
        if poses is not None:
            poses.step(self.times.of(self.done))
        order = self.team.interleave([index for index, _ in views])
        for index, (_, _, screen_grads, radii, *more) in zip(order, results, strict=True):
            seen = {"screen_grads": screen_grads, "radii": radii}
            self.strategy.observe(self.done, shown, cameras[index], **seen)
            if self.team.world_size > 1:
                rest = self.adam.tensors["sh_rest"]
                for grad in more:
                    rest.grad = grad if rest.grad is None else rest.grad + grad
        waits = self.done % self.config.sh_every and self.done < self.steps
        self.adam.step(without=("sh_rest",) if waits else ())
        self.strategy.after_step(self.done, self.adam, self.generator)
        if self.done == self.far_check:
            self._remove_far()
        if self.config.least_variance and (self.done % LIMIT_EVERY == 0 or self.done == self.steps):
            tensors, cameras = self.adam.tensors, [frame.camera for frame in self.frames]
            scales = tensors["log_scales"].detach()
            limit_scales(scales, tensors["means"], cameras, self.config.least_variance)
        if self.done == self.steps:
            self._remove_unsupported()
        losses, errors, *_ = zip(*results, strict=True)
        return StepResult.of(losses, errors, spread)

    def _cameras(self, divisor: int) -> list[Camera]:
        """Return the cameras of photos reduced by `divisor`: the same ones while it stays.

        Their numbers are then read from a GPU once.
        """
        if self._reduced[0] != divisor:
            device = self.background.device
            cameras = [frame.camera.reduced(divisor).to(device) for frame in self.frames]
            self._reduced = divisor, cameras
        return self._reduced[1]

    def _begin_exposures(self) -> float | None:
        """Decide in one of the steps whether photos differ; return their spread in that step."""
        config = self.config.exposure
        if self.done != round(EXPOSURE_START * self.config.steps):
            return None
        self.exposures, spread = exposures_for(config, self.scene(), self.frames)
        return spread

    def _view_loss(self, index: int, view: View, poses: Poses | None) -> tuple[Tensor, ...]:
        """Return loss and squared error of photo `index`, its screen-space gradients and radii.

        Those of harmonics above degree 0 follow where autograd does not have them. The backward
        pass fills in the gradients. `poses` corrects the camera.
        """
        shown, grads = self._gaussians(0), []
        screen_grads = torch.empty_like(shown.means[:, :2])
        options: dict[str, Any] = {"background": self.background, "screen_grads": screen_grads}
        if poses is None:
            more = self._more_harmonics()
            drawn = render_raw(
                RenderInputs(
                    *(shown.means, shown.quats, shown.log_scales),
                    *(shown.logit_opacities, shown.sh, None),
                ),
                view.camera,
                settings=RenderSettings(footprint=self.config.scene_footprint),
                more=more,
                sh_degree=self.sh_degree,
                **options,
            )
            grads = [] if more is None else [more.gradients]
        else:
            shown = self._gaussians(self.sh_degree)
            drawn = render_sorted(
                *(shown.means, shown.quats, shown.scales, shown.opacities, shown.sh),
                camera=poses.camera(index, view.camera),
                footprint=self.config.scene_footprint,
                **options,
            )
        image = drawn.image
        if self.exposures is not None:
            image = self.exposures.apply(index, image)
        loss, error = photo_loss_and_error(
            image, view.image, mask=view.mask, ssim_weight=self.config.ssim_weight
        )
        if (term := self.strategy.regularizer(shown)) is not None:
            loss = loss + term
        if self.exposures is not None:
            loss = loss + self.exposures.penalty(index)
        return loss, error, screen_grads, drawn.radii, *grads

    def _more_harmonics(self) -> MoreHarmonics | None:
        """Return the harmonics above degree 0 of the next step; None while there are none.

        A single process adds their gradients where Adam reads them.
        """
        rest = self.adam.tensors["sh_rest"]
        if self.sh_degree == 0:
            return None
        if self.team.world_size > 1:
            return MoreHarmonics(rest.detach(), torch.zeros_like(rest))
        if rest.grad is None:
            rest.grad = torch.zeros_like(rest)
        return MoreHarmonics(rest.detach(), rest.grad)

    def gaussians(self) -> Gaussians:
        """Return the current Gaussians, with harmonics of the final degree."""
        return self._gaussians(self.degree_max).detached()

    def scene(self) -> Scene:
        """Return the current scene, for sorted blending."""
        return Scene(
            self.gaussians(),
            "sorted",
            background=self.background,
            near=self.near,
            footprint=self.config.scene_footprint,
        )

    def state(self) -> dict:
        """Return everything that the remaining steps depend on."""
        return {
            "done": self.done,
            "generator": self.generator.get_state(),
            "adam": self.adam.state(),
            "strategy": self.strategy.state(),
            "exposures": None if self.exposures is None else self.exposures.state(),
            "poses": None if self.poses is None else self.poses.state(),
        }

    def restore(self, state: dict) -> None:
        """Continue from a result of `state()`."""
        self.done = state["done"]
        self.generator.set_state(state["generator"])
        self.adam.restore(state["adam"])
        self.strategy.restore(state["strategy"])
        self.adam.validate_rows()
        if self.poses is not None:
            self.poses.restore(state["poses"])
        if (exposures := state["exposures"]) is not None:
            device = self.background.device
            self.exposures = Exposures.restored(self.config.exposure, exposures, device)

    def _strategy(self, count: int, device: torch.device) -> Fixed:
        config, densify = self.config, self.config.densify
        if densify.strategy == "fixed":
            return Fixed()
        run = {"steps": config.steps, "max_splats": config.max_splats}
        if densify.strategy == "mcmc":
            return Mcmc(densify, **run)
        start = {"extent": self.extent, "count": count, "device": device}
        if densify.strategy == "clone_split":
            return CloneSplit(densify, **run, **start)
        begin = {"frames": self.frames, "opacity": INIT_OPACITY}
        begin |= {"sh_degree": self.degree_max, "footprint": config.scene_footprint}
        begin["metric"] = config.importance
        return MiniSplatting(densify, config.mini_splatting, **run, **start, **begin)

    def _remove_far(self) -> None:
        """Remove Gaussians of the far sphere that the photos hardly show."""
        config = self.config
        keep = ~hidden_far(
            self.gaussians(), self.dataset, config.scene_footprint, config.far_visibility
        )
        if not keep.all():
            self.adam.keep_rows(keep)
            self.strategy.keep_rows(keep)

    @torch.no_grad()
    def _remove_unsupported(self) -> None:
        gaussians = self.gaussians()
        views = torch.zeros(len(gaussians), dtype=torch.int32, device=gaussians.means.device)
        for frame in self.frames:
            camera = frame.camera.to(views.device)
            shapes = (gaussians.means, gaussians.quats, gaussians.scales)
            views[visible_rows(*shapes, camera=camera, footprint=self.config.scene_footprint)] += 1
        keep = views >= min(self.config.min_views, len(self.frames))
        if keep.any() and not keep.all():
            self.adam.keep_rows(keep)

    def _gaussians(self, degree: int) -> Gaussians:
        tensors, columns = self.adam.tensors, (degree + 1) ** 2 - 1
        rest = tensors["sh_rest"][:, :columns]
        if rest.shape[1] < columns:  # of sh_delayed strategies
            rest = pad(rest, (0, 0, 0, columns - rest.shape[1]))
        return Gaussians(
            means=tensors["means"],
            quats=tensors["quats"],
            log_scales=tensors["log_scales"],
            logit_opacities=tensors["logit_opacities"],
            sh=torch.cat([tensors["sh0"], rest], dim=1) if columns else tensors["sh0"],
        )

    def _lrs(self) -> dict[str, float]:
        lr = self.config.lr
        time = self.times.of(self.strategy.lr_step(self.done))
        position = exponential_lr(lr.means, lr.means / MEANS_LR_RATIO, time)
        share = (self.times.of(self.done) - DECAY_FROM) / (1 - DECAY_FROM)
        decay = exponential_lr(1.0, lr.final_factor, share)
        return {
            "means": position * self.extent,
            "quats": lr.quats * decay,
            "log_scales": lr.scales * decay,
            "logit_opacities": lr.opacities * decay,
            "sh0": lr.sh0 * decay,
            "sh_rest": self.config.sh_every * lr.sh_rest * decay,
        }
