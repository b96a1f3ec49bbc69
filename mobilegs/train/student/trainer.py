"""The student: distilled from the teacher, rendered without sorting, and quantised."""

from dataclasses import replace

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import MIN_SIDE, Camera
from mobilegs.data.dataset import View
from mobilegs.mgs.codec import encode_mgs
from mobilegs.mgs.encode import encode_scene
from mobilegs.mgs.quantized_scene import MetaValue, QuantizedScene
from mobilegs.render import Rendered, Weighting
from mobilegs.render.depth_pass import typical_depth
from mobilegs.render.scene import Scene
from mobilegs.representation.uniform_quantizer import COLUMNS
from mobilegs.spherical_harmonics import C0
from mobilegs.train.distributed import SINGLE_PROCESS, Team
from mobilegs.train.exposure import Exposures
from mobilegs.train.losses import (
    distillation_loss,
    front_loss,
    photo_loss_and_error,
    raw_depth_loss,
)
from mobilegs.train.optim import exponential_lr
from mobilegs.train.sampling import LIMIT_EVERY
from mobilegs.train.stage import StepResult
from mobilegs.train.student import quantization
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.distill import TeacherImages, release_depth
from mobilegs.train.student.model import Phase, StudentModel
from mobilegs.train.student.position_grid import choose_grid
from mobilegs.train.student.program import ProgramDecode, opacities_and_scales, runs_program
from mobilegs.train.student.shared_decode import SharedDecode
from mobilegs.train.student.vote_pruning import VoteCounter, vote
from mobilegs.train.threads import all_threads, one_thread
from mobilegs.train.times import Times
from mobilegs.viewpoints.virtual_views import (
    DIVISOR,
    move_off_path,
    virtual_cameras,
)

# rate control, which changes the quality. Shares of a file's size that training takes off are lower
# than the means over four captures: a quality that falls late costs more than one too low at first
RATE_UPDATES = 50  # in the quantised phase
EARLY_EVERY = 0.05  # of a run, between two updates before that
LATE_SHRINKAGE = 0.1  # by the quantised phase
EARLY_SHRINKAGE = 0.05  # by the rate term before it, when it begins
SETTLING = 0.1  # of a run, after which half of that is left
REGRESSION_STEPS = 400  # that fit colour networks to harmonics, at most a fifth of the run's
# learning rates of the codebooks; for those of the lobe latents, the ratio to these latents' rate
CODEBOOK_LRS = {"scale": 1e-3, "opacity": 1e-3, "rotation": 5e-4, "appearance": 1e-3}
LOBE_CODEBOOK_LR_RATIO = 0.25
COLOR_DECODER_LR = 1e-3
VIRTUAL_UNTIL = 0.5  # share of a run with distillation at virtual views
FRONT_EVERY = 4  # steps between two comparisons of the coverage before planes
SPARSE_EVERY = 4  # steps between two gradients of the rate term, times 4


class Student:
    """The training of a quantised, sort-free scene (Mobile-GS, sections 3.2 to 3.5).

    A step renders photos and takes a step of Adam. From `schedule.quantize_from` on it trains with
    the values of the file. The loss of a step, with the weights of `config.loss` and the rate's
    `lambda = quantization.rate_weight / quantization.quality**2`, is

        (1 - ssim_weight) L1 + ssim_weight (1 - SSIM)           at each photo
        + distill_weight L1(teacher's colours)
        + depth_weight Var(log-depth - teacher's log-depth)     at virtual views, in some steps
                                                                of the first half
        + front_weight L1(teacher's coverage before a plane)    at a view, in some steps
        + overdraw_weight (area of ellipses) + lambda (bits per Gaussian)
        + 0.01 |change of the photo's colours|^2                where exposures are learned

    Overdraw is that of the step's first photo. Bits count in every fourth step, four times.

    Example:

        student = Student(StudentConfig(), teacher.scene(), cameras, extent=3.0, seed=0)
        while student.done < student.steps:
            student.advance([(index, load_view(dataset.train[index]))])
        write_mgs(path, student.quantized_scene())
    """

    name = "student"

    def __init__(
        self,
        config: StudentConfig,
        teacher: Scene,
        cameras: list[Camera],
        *,
        extent: float,
        seed: int,
        team: Team = SINGLE_PROCESS,
        exposures: Exposures | None = None,
    ) -> None:
        """Start from the teacher.

        Args:
            config: all settings. `StudentConfig` raises InputError for values out of range.
            teacher: a scene, which gives the initial Gaussians and the targets of distillation.
            cameras: those of all training views, by their indices.
            extent: of the scene, in world units.
            seed: of all random choices.
            team: the processes that share the views of a step.
            exposures: of the photos, if they differ (`exposures_for`).
        """
        self.config = config
        self.quantization = config.quantization  # rate control changes the quality
        self.times = Times(config.steps)
        self.views_per_step = config.views_per_step
        self.done = 0
        gaussians, device = teacher.gaussians, teacher.gaussians.means.device
        sizes = gaussians.scales.topk(2, dim=1).values.prod(1).sqrt()
        self.means_lr = min(config.lr.means * extent, config.lr.means_max * float(sizes.median()))
        self.near = teacher.near
        self.background = teacher.background
        self.generator = torch.Generator().manual_seed(seed)
        self.teacher_images = TeacherImages(
            teacher,
            cache_bytes=config.cache_mib << 20,
            release_depths=not config.loss.mask_depth,
        )
        self.cameras = [camera.to(device) for camera in cameras]
        self.exposures = exposures
        self.team = team
        self.virtual_cameras: list[Camera] = []
        if config.loss.virtual_view_every and (self._distils or self._has_front_term):
            between = virtual_cameras(self.cameras, seed)
            off_path = move_off_path(between, gaussians.means, seed)
            self.virtual_cameras = [_reduced(camera) for camera in off_path]
        self._reduced_cameras = [_reduced(camera) for camera in self.cameras]
        if start := config.view_dependence.start_opacity:
            opacities = torch.full_like(gaussians.logit_opacities, start)
            gaussians = replace(gaussians, logit_opacities=opacities.logit())
        weighting = self.weighting
        if config.blend == "sorted":
            weighting = replace(weighting, name="mobile_gs")
        elif weighting.name == "depth_pass":
            with one_thread():
                depth = typical_depth(gaussians.means, self.cameras, self.near)
            weighting = replace(weighting, sigma=depth)
        self.model = StudentModel(
            gaussians,
            config.view_dependence,
            self._lrs(),
            self.generator,
            blend=config.blend,
            weighting=weighting,
            footprint=config.footprint.drawn(config.blend),
            level_sigma=config.level_sigma,
            color=config.color_shape,
            round_means=config.quantization.round_means,
            step_sizes=config.quantization.initial_step_sizes,
        )
        self.votes = VoteCounter(config.pruning, self.times, len(self.model), device)

    @property
    def weighting(self) -> Weighting:
        """The weighting with which the student trains; a subclass may have another one."""
        return self.config.weighting.weighting

    def candidates(
        self, opacities: Float[Tensor, "n"], scales: Float[Tensor, "n 3"]
    ) -> Bool[Tensor, "n"]:
        """Return the Gaussians that a vote goes against; a subclass may have another criterion."""
        return vote(opacities, scales, self.config.pruning.quantile)

    @property
    def runs_kernels(self) -> bool:
        """True for the default student, which is one program of kernels."""
        return runs_program(self.model)

    @property
    def phase(self) -> Phase:
        """The phase of the next step: `explicit`, `latents` or `quantized`."""
        time, schedule = self.times.of(self.done), self.config.schedule
        if time >= schedule.quantize_from:
            return "quantized"
        return "latents" if time >= schedule.latents_from else "explicit"

    @property
    def count(self) -> int:
        """Number of Gaussians."""
        return len(self.model)

    @property
    def steps(self) -> int:
        """Number of steps in total."""
        return self.times.steps

    def set_steps(self, steps: int, at: int) -> None:
        """Change the number of steps in total, when `at` of them are done."""
        self.times.set_steps(steps, at)

    def advance(self, views: list[tuple[int, View]]) -> StepResult:
        """Take a step on the sum of the views' losses; the result holds their means.

        `views` are this process's share of the views of a step, each with its index.
        """
        config = self.config
        self._enter(self.phase)
        self.model.set_lrs(self._lrs())
        cameras = [self.cameras[index] for index in self.team.interleave([i for i, _ in views])]
        results, decoded = self._add_gradients(cameras, views)
        if self._has_rate_term and self.done % SPARSE_EVERY == 0:
            bit_weight = SPARSE_EVERY * self.quantization.bit_weight
            self.model.add_rate_gradients(len(cameras) * bit_weight)
        decoded.step(len(cameras) * config.loss.overdraw_weight)
        self.done += 1
        if config.least_variance and (self.done % LIMIT_EVERY == 0 or self.done == self.steps):
            self.model.limit_scales(self.cameras, config.least_variance)
        self._control_rate()
        if self.model.phase == "quantized":
            every = config.schedule.reassign_every
            self.model.reassign(codebooks=every > 0 and self.done % every == 0)
        self._count_votes(cameras)
        if self.votes.prunes_after(self.done):
            self._prune(self.votes.kept())
        losses, errors = zip(*results, strict=True)
        return StepResult.of(losses, errors)

    def scene(self) -> Scene:
        """Return the current scene; once quantised, it is that of the file."""
        if self.model.phase == "quantized":
            return self.quantized_scene().decode(self.background.device)
        model = self.model
        with torch.no_grad():
            gaussians, lobe_inputs = model.gaussians()
            gaussians, lobes = gaussians.detached(), None
            if model.lobe_decoder is not None:
                lobes = model.lobes(gaussians, lobe_inputs, None).detach()
                gaussians = replace(gaussians, logit_opacities=C0 * lobes[:, 0, 0])
        return Scene(
            gaussians,
            model.blend,
            lobes=lobes,
            network=model.network,
            weighting=model.weighting,
            background=self.background,
            near=self.near,
            footprint=model.footprint,
        )

    def quantized_scene(
        self, *, views: list[Camera] | None = None, meta: dict[str, MetaValue] | None = None
    ) -> QuantizedScene:
        """Return the content of the file. If training has not quantised the model yet, this call
        quantises it.

        `views` and `meta` go into the file unchanged.
        """
        self._enter("quantized")
        return replace(self._coded(self.model), views=views or [], meta=meta or {})

    def _coded(self, model: StudentModel) -> QuantizedScene:
        """Return a quantised model as the content of a file, without views and notes."""
        assert model.decoder is not None and model.grid is not None
        scene = encode_scene(
            model.rows.tensors["means"],
            model.quantizers,
            model.grid,
            model.decoder,
            model.lobe_decoder,
            model.network,
        )
        return replace(
            scene,
            blend=model.blend,
            weighting=model.weighting,
            footprint=model.footprint,
            background=self.background,
            near=self.near,
        )

    def state(self) -> dict:
        """Return all that the rest of the training depends on, except for the teacher."""
        return {
            "done": self.done,
            "quality": self.quantization.quality,
            "generator": self.generator.get_state(),
            "model": self.model.state(),
            "votes": self.votes.state(),
            "exposures": None if self.exposures is None else self.exposures.state(),
        }

    def restore(self, state: dict) -> None:
        """Continue from the result of `state()`, in a student that has not taken a step."""
        self.done = state["done"]
        self._set_quality(state["quality"])
        self.generator.set_state(state["generator"])
        self.model.restore(state["model"])
        self.votes.restore(state["votes"])
        self.model.rows.validate_rows(self.votes.against)
        self.exposures = None
        if (exposures := state["exposures"]) is not None:
            device = self.background.device
            self.exposures = Exposures.restored(self.config.exposure, exposures, device)

    # --- phases

    def _enter(self, phase: Phase) -> None:
        """Bring the model into `phase`, through the phases before it."""
        if phase != self.model.phase:
            with all_threads():
                self._begin(phase)

    def _begin(self, phase: Phase) -> None:
        config = self.config
        if phase != "explicit" and self.model.phase == "explicit":
            means = self.model.rows.tensors["means"].detach()
            self.model.use_latents(
                choose_grid(means, self.cameras, config.quantization.position_error),
                regression_steps=min(REGRESSION_STEPS, self.steps // 5),
                generator=self.generator,
            )
            if not config.schedule.keep_moments:
                self.model.rows.reset_all_moments()
        if phase == "quantized" and self.model.phase == "latents":
            self.model.quantize(config.quantization.codebooks, generator=self.generator)

    # --- losses

    @property
    def _distils(self) -> bool:
        """True if the loss compares with the teacher."""
        return self.config.loss.distill_weight != 0 or self.config.loss.depth_weight != 0

    @property
    def front_cameras(self) -> list[Camera]:
        """The cameras before which coverages are compared: the virtual ones, if there are some."""
        return self.virtual_cameras or self._reduced_cameras

    @property
    def _has_front_term(self) -> bool:
        """True if the loss compares the coverage before planes with the teacher's."""
        return self.config.loss.front_weight > 0 and self.config.blend != "sorted"

    @property
    def _has_rate_term(self) -> bool:
        """True if the loss of the next step has a rate term."""
        schedule = self.config.schedule
        begins = min(schedule.rate_from, schedule.quantize_from)
        return self.config.quantization.method == "sq" and self.times.of(self.done) >= begins

    def _add_gradients(
        self, cameras: list[Camera], views: list[tuple[int, View]]
    ) -> tuple[list[tuple[Tensor, ...]], SharedDecode]:
        """Return the loss and squared error of each view, and the leaves with their gradients.

        `cameras` are those of all views of the step, `views` this process's share of them.
        """
        config, team, results = self.config, self.team, []
        virtual, depth = self._pick_virtual_view(), config.loss.depth_weight > 0
        front = self._pick_front_view(virtual)
        other = virtual if front is None else front  # the same where there are both
        rendered = cameras if other is None else [*cameras, self.front_cameras[other]]
        kind = ProgramDecode if runs_program(self.model) else SharedDecode
        shared = kind(self.model, rendered)
        photos = [] if self.exposures is None else self.exposures.leaves
        for number, (index, view) in enumerate(views):
            at = number * team.world_size + team.rank
            drawn = shared.render(
                at, background=self.background, depth=depth and not self.virtual_cameras
            )
            loss, error = self._view_loss(drawn, index, view)
            results += team.accumulate_gradients([*shared.leaves, *photos], loss, error)
        if self.exposures is not None:
            self.exposures.step(self.times.of(self.done + 1))
        if virtual is not None:  # every process renders the same virtual view
            drawn = shared.render(len(cameras), background=self.background, depth=depth)
            index = len(self.cameras) + virtual
            loss = self._distillation_loss(drawn, index, self.virtual_cameras[virtual])
            SINGLE_PROCESS.accumulate_gradients(shared.leaves, loss, weight=float(len(cameras)))
        if front is not None:
            target = self.teacher_images.front(front, self.front_cameras[front])
            drawn = shared.render(len(cameras), background=self.background, before=target.z)
            loss = front_loss(drawn.alpha, target.coverage)
            weight = len(cameras) * config.loss.front_weight
            SINGLE_PROCESS.accumulate_gradients(shared.leaves, loss, weight=weight)
        return results, shared

    def _pick_virtual_view(self) -> int | None:
        """Return the index of this step's virtual camera, at random; None in steps without one."""
        if not (self._distils and self.virtual_cameras):
            return None
        if (
            self.done % self.config.loss.virtual_view_every
            or self.times.of(self.done) >= VIRTUAL_UNTIL
        ):
            return None
        return self._pick(self.virtual_cameras)

    def _pick_front_view(self, virtual: int | None) -> int | None:
        """Return the index of the camera before which coverages are compared in this step.

        It is that of the virtual view, where there is one. None in steps without one.
        """
        if not self._has_front_term or self.done % FRONT_EVERY:
            return None
        return self._pick(self.front_cameras) if virtual is None else virtual

    def _pick(self, cameras: list[Camera]) -> int:
        """Return a random index of `cameras`."""
        return int(torch.randint(len(cameras), (1,), generator=self.generator))

    def _view_loss(
        self, drawn: Rendered, index: int, view: View
    ) -> tuple[Float[Tensor, ""], Float[Tensor, ""]]:
        """Return loss and squared error of photo `index`.

        The loss has the distillation's if there are no virtual views.
        """
        image = drawn.image
        if self.exposures is not None:
            image = self.exposures.apply(index, image)
        loss, error = photo_loss_and_error(
            image, view.image, mask=view.mask, ssim_weight=self.config.loss.ssim_weight
        )
        if self.exposures is not None:
            loss = loss + self.exposures.penalty(index)
        if self._distils and not self.virtual_cameras:
            loss = loss + self._distillation_loss(drawn, index, view.camera, mask=view.mask)
        return loss, error

    def _distillation_loss(
        self, drawn: Rendered, index: int, camera: Camera, *, mask: Tensor | None = None
    ) -> Float[Tensor, ""]:
        """Return the weighted distance to the teacher's image `index`, seen by `camera`."""
        loss, teacher = self.config.loss, self.teacher_images.get(index, camera)
        depth = drawn.depth if loss.mask_depth else None
        distance = distillation_loss(
            drawn.image,
            depth,
            drawn.alpha,
            *teacher,
            mask=mask,
            color_weight=loss.distill_weight,
            depth_weight=loss.depth_weight,
        )
        if loss.mask_depth or drawn.depth is None:
            return distance
        raw = raw_depth_loss(release_depth(drawn, self.background), teacher.depth, mask=mask)
        return distance + loss.depth_weight * raw

    # --- pruning

    @torch.no_grad()
    def _count_votes(self, cameras: list[Camera]) -> None:
        """Count a vote per camera, in steps that hold one."""
        if not self.votes.votes_at(self.done):
            return
        if runs_program(self.model):
            seen = opacities_and_scales(self.model, cameras)
        else:
            seen = map(self.model.opacities_and_scales, cameras)
        for opacities, scales in seen:
            self.votes.add(self.candidates(opacities, scales))

    def _prune(self, keep: Bool[Tensor, "n"]) -> None:
        if keep.any() and not keep.all():
            self.model.keep_rows(keep)
        self.votes.reset(len(self.model))

    # --- rate control and learning rates

    @property
    def _quantized_share(self) -> float:
        """The share of the run that the quantised phase takes."""
        return max(1 - self.config.schedule.quantize_from, 1 / self.steps)

    @property
    def _controls_rate(self) -> bool:
        """True after steps in which the quality may change, so that the file's size does."""
        schedule, phase = self.config.schedule, self.model.phase
        if not self.config.quantization.target_mb or phase == "explicit":
            return False
        if phase == "quantized":
            return self.times.passes(self.done, self._quantized_share / RATE_UPDATES)
        begun = self.times.of(self.done) >= schedule.rate_from
        return begun and self.times.passes(self.done, EARLY_EVERY)

    def _control_rate(self) -> None:
        """Bring the file's size towards `target_mb`, by step sizes and the rate term's weight."""
        if not self._controls_rate:
            return
        model, config = self.model, self.config
        with all_threads():
            model = model if model.phase == "quantized" else model.quantized_copy()
            size = len(encode_mgs(self._coded(model)))
        time = self.times.of(self.done)
        if self.model.phase == "quantized":
            left = min(1.0, (1 - time) / self._quantized_share)
            shrinkage = LATE_SHRINKAGE * left**2
        else:
            age = (time - config.schedule.rate_from) / SETTLING
            shrinkage = LATE_SHRINKAGE + EARLY_SHRINKAGE / (1 + age)
        self._set_quality(
            quantization.controlled_quality(
                self.quantization.quality,
                (1 - shrinkage) * size,
                1e6 * config.quantization.target_mb,
                config.quantization.quality,
            )
        )

    def _set_quality(self, quality: float) -> None:
        """Change the step sizes and the weight of the rate term."""
        self.quantization = replace(self.quantization, quality=quality)
        self.model.set_step_sizes(self.quantization.initial_step_sizes)

    def _lrs(self) -> dict[str, float]:
        """Return the learning rates of the next step, as `StudentModel.set_lrs` takes them."""
        config, lr, time = self.config, self.config.lr, self.times.of(self.done)
        decay_share = (time - lr.decay_from) / max(1 - lr.decay_from, 1e-9)
        decay = exponential_lr(1.0, lr.final_factor, decay_share)
        lrs = {
            "means": self.means_lr,
            "quats": lr.quats,
            "log_scales": lr.scales,
            "logit_opacities": lr.opacities,
            "lobe_latents": lr.lobes,
            "lobe_decoder": lr.network,
            "sh0": lr.sh0,
            "sh_rest": lr.sh_rest,
            "static": lr.color_latents,
            "view": lr.color_latents,
            "network": lr.network,
            "decoder": COLOR_DECODER_LR,
            **{name: value * lr.codebook_factor for name, value in CODEBOOK_LRS.items()},
            "lobes": LOBE_CODEBOOK_LR_RATIO * lr.lobes * lr.codebook_factor,
            "scale_values": lr.scales * lr.quantized_factor,
            "opacity_values": lr.opacities * lr.quantized_factor,
            "rotation_values": lr.quats * lr.quantized_factor,
            "lobes_values": lr.lobes * lr.quantized_factor,
            "appearance_values": lr.color_latents * lr.quantized_factor,
        }
        if config.quantization.method == "sq":
            lrs |= dict.fromkeys((*COLUMNS, "lobes"), lr.step_sizes)
        return {name: value * decay for name, value in lrs.items()}


def _reduced(camera: Camera) -> Camera:
    """Return the camera of a smaller image, in which the teacher is a target."""
    return camera.reduced(max(1, min(DIVISOR, min(camera.width, camera.height) // MIN_SIDE)))
