"""The student: learns to look like the photos and the teacher without sorting, and to be small."""

from dataclasses import replace

import torch
from jaxtyping import Bool
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.compress.uniform_quantizer import COLUMNS
from mobilegs.data.dataset import View
from mobilegs.mgs.codec import pack
from mobilegs.mgs.encode import encode_scene
from mobilegs.mgs.quantized_scene import CodedScene, MetaValue
from mobilegs.render import Rendered
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import C0
from mobilegs.train.distributed import ALONE, Team
from mobilegs.train.losses import (
    color_distillation_loss,
    depth_distillation_loss,
    photo_loss,
    raw_depth_loss,
)
from mobilegs.train.optim import log_linear
from mobilegs.train.stage import StepResult
from mobilegs.train.student import quantization
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.distill import TeacherPictures, raw_depth
from mobilegs.train.student.model import Phase, StudentModel
from mobilegs.train.student.position_grid import frame_for
from mobilegs.train.student.shared_decode import Seen
from mobilegs.train.student.virtual_views import cameras_between
from mobilegs.train.student.vote_pruning import Ballot, vote
from mobilegs.train.teacher.trainer import squared_error

STEERINGS = 50


class Student:
    """The stage that turns a teacher into a sort-free, coded scene (paper sections 3.2 to 3.5)."""

    name = "student"

    def __init__(
        self,
        config: StudentConfig,
        teacher: Scene,
        cameras: list[Camera],
        *,
        extent: float,
        seed: int,
        team: Team = ALONE,
    ) -> None:
        """`teacher` is drawn as its blend says; `extent` is the scene's, in world units.

        `cameras` are those of all training views, by their indices.
        """
        self.config = config
        self.steps = config.steps
        self.views_per_step = config.views_per_step
        self.done = 0
        sizes = teacher.gaussians.scales.topk(2, dim=1).values.prod(1).sqrt()
        self.position_rate = min(
            config.position_rate * extent, config.position_share * float(sizes.median())
        )
        self.near = teacher.near
        self.background = teacher.background
        self.generator = torch.Generator().manual_seed(seed)
        self.pictures = TeacherPictures(
            teacher, cache_bytes=config.cache_mib << 20, raw=not config.depth_masked
        )
        device = teacher.gaussians.means.device
        self.cameras = [camera.to(device) for camera in cameras]
        self.team = team
        self.between: list[Camera] = []
        if config.distill_between and (config.distill_weight or config.depth_weight):
            self.between = cameras_between(self.cameras, seed)
        gaussians = teacher.gaussians
        if config.start_opacity:
            level = torch.full_like(gaussians.logit_opacities, config.start_opacity)
            gaussians = replace(gaussians, logit_opacities=level.logit())
        weighting = config.weighting
        if weighting.name == "sort_free_gs":
            weighting = replace(weighting, sigma=weighting.sigma * extent)
        self.model = StudentModel(
            gaussians,
            config.view,
            self._rates(),
            self.generator,
            blend=config.blend,
            weighting=weighting,
            color=config.color,
            rounded=config.positions_rounded,
            steps=config.steps_of_codes,
            canonical=config.canonical,
        )
        if config.presence.weight:
            logits = config.presence.logits(len(self.model), device)
            self.model.rows.add("presence", logits, config.presence.rate)
        self.ballot = Ballot(config.votes, config.steps, len(self.model), device)

    @property
    def phase(self) -> Phase:
        """`explicit`, `networks` or `codes`: the form the next step works on."""
        progress = self.done / self.steps
        if progress >= self.config.codes_fraction:
            return "codes"
        return "networks" if progress >= self.config.net_fraction else "explicit"

    @property
    def _pays(self) -> bool:
        """Whether the next step asks a price for bits."""
        begins = min(self.config.price_fraction, self.config.codes_fraction)
        return self.config.coding == "sq" and self.done >= begins * self.steps

    @property
    def count(self) -> int:
        """Number of Gaussians."""
        return len(self.model)

    def advance(self, views: list[tuple[int, View]]) -> StepResult:
        """One step on the sum of the views' losses; the result holds their means."""
        self._enter(self.phase)
        if self.done >= self.steps * self.config.view.fraction:
            self._settle()
        self.model.set_rates(self._rates())
        cameras = [self.cameras[index] for index in self.team.in_order([i for i, _ in views])]
        results = self._pull(cameras, views)
        if self._pays:
            self.model.pay(len(cameras) * self.config.price)
        self.model.step()
        if self.config.view.decay:
            self.model.forget_directions(self.config.view.decay)
        self.done += 1
        if self.model.phase == "codes":
            self._steer()
            self.model.reassign(all_codes=self.done % self.config.reassign_every == 0)
        if self.ballot.votes_in(self.done):
            for camera in cameras:
                self._vote(camera)
        if self.ballot.prunes_after(self.done):
            self._prune(self.ballot.verdict())
        if "presence" in self.model.rows.tensors:
            self._thin_out()
        losses, errors = zip(*results, strict=True)
        return StepResult(torch.stack(losses).mean(), torch.stack(errors).mean())

    def scene(self) -> Scene:
        """The student as it stands; once it is coded, exactly what its file would show."""
        if self.model.phase == "codes":
            return self.coded().decode(self.background.device)
        model = self.model
        with torch.no_grad():
            gaussians, for_lobes = model.gaussians()
            gaussians, lobes = gaussians.detached(), None
            if model.network is None and model.view.kind != "constant":
                lobes = model.lobes(gaussians, for_lobes, None).detach()
                gaussians = replace(gaussians, logit_opacities=C0 * lobes[:, 0, 0])
        return Scene(
            gaussians,
            model.blend,
            lobes=lobes,
            network=model.network,
            weighting=model.weighting,
            background=self.background,
            near=self.near,
        )

    def coded(
        self, *, views: list[Camera] | None = None, meta: dict[str, MetaValue] | None = None
    ) -> CodedScene:
        """What the file holds; codes are made now if training has not come so far.

        `views` and `meta` go into the file as they are.
        """
        self._enter("codes")
        model = self.model
        assert model.decoder is not None and model.frame is not None
        return encode_scene(
            model.rows.tensors["means"],
            model.codebooks,
            frame=model.frame,
            decoder=model.decoder,
            lobe_decoder=model.lobe_decoder,
            network=model.network,
            blend=model.blend,
            weighting=model.weighting,
            background=self.background,
            near=self.near,
            views=views,
            meta=meta,
        )

    def state(self) -> dict:
        """Everything the rest of the training depends on, the teacher aside."""
        return {
            "done": self.done,
            "generator": self.generator.get_state(),
            "model": self.model.state(),
            "ballot": self.ballot.state(),
        }

    def restore(self, state: dict) -> None:
        """Continue from what `state()` gave; only into a student that has not begun."""
        self.done = state["done"]
        self.generator.set_state(state["generator"])
        self.model.restore(state["model"])
        self.ballot.restore(state["ballot"])

    def _enter(self, phase: Phase) -> None:
        if phase != "explicit" and self.model.phase == "explicit":
            means = self.model.rows.tensors["means"].detach()
            self.model.use_networks(
                frame_for(means, self.cameras, self.config.position_error),
                regression_steps=self.config.regression_steps,
                generator=self.generator,
            )
            if not self.config.moments_kept:
                self.model.rows.restart(self.model.rows.tensors)
        if phase == "codes" and self.model.phase == "networks":
            self._settle()
            self.model.use_codes(self.config.codebooks, generator=self.generator)

    def _settle(self) -> None:
        if not self.model.settled:
            self.model.settle(
                self.cameras,
                regression_steps=self.config.regression_steps,
                generator=self.generator,
            )

    def _pull(
        self, cameras: list[Camera], views: list[tuple[int, View]]
    ) -> list[tuple[Tensor, ...]]:
        """Give the model the gradients of a step; returns each view's loss and squared error.

        `cameras` are those of all views of the step, `views` this process's share of them.
        """
        config, team, results = self.config, self.team, []
        masks = self.model.rows.tensors.get("presence")
        presence = None if masks is None else config.presence.draw(masks, self.generator)
        asked, depth = self._asked(), config.depth_weight > 0
        seen = Seen(
            self.model,
            cameras if asked is None else [*cameras, self.between[asked]],
            presence=presence,
        )
        for number, (index, view) in enumerate(views):
            at = number * team.world + team.rank
            drawn = seen.draw(at, background=self.background, depth=depth and not self.between)
            loss, error = self._loss(drawn, index, view), squared_error(drawn.image, view)
            if config.fill_price:
                loss = loss + config.fill_price * seen.overdraw(at)
            results += team.add_gradients(seen.leaves, loss, error)
        if asked is not None:  # every process draws the same
            drawn = seen.draw(len(cameras), background=self.background, depth=depth)
            loss = self._to_teacher(drawn, len(self.cameras) + asked, self.between[asked])
            ALONE.add_gradients(seen.leaves, len(cameras) * loss)
        seen.backward()
        if masks is not None:
            (len(cameras) * config.presence.loss(masks)).backward()
        return results

    def _asked(self) -> int | None:
        """Which of the views between cameras a step looks at, if any."""
        if not self.between or self.done % self.config.distill_between:
            return None
        return int(torch.randint(len(self.between), (1,), generator=self.generator))

    def _loss(self, drawn: Rendered, index: int, view: View) -> Tensor:
        config = self.config
        loss = photo_loss(drawn.image, view.image, mask=view.mask, ssim_weight=config.ssim_weight)
        if self.between or not (config.distill_weight or config.depth_weight):
            return loss
        return loss + self._to_teacher(drawn, index, view.camera, mask=view.mask)

    def _to_teacher(
        self, drawn: Rendered, index: int, camera: Camera, *, mask: Tensor | None = None
    ) -> Tensor:
        """The weighted distance to the teacher's picture `index`, which `camera` sees."""
        config, teacher = self.config, self.pictures.get(index, camera)
        loss = config.distill_weight * color_distillation_loss(
            drawn.image, teacher.image, mask=mask
        )
        if drawn.depth is None:
            return loss
        if config.depth_masked:
            distance = depth_distillation_loss(drawn.depth, drawn.alpha, teacher.depth, mask=mask)
        else:
            depth = raw_depth(drawn, self.background)
            distance = raw_depth_loss(depth, teacher.depth, mask=mask)
        return loss + config.depth_weight * distance

    @torch.no_grad()
    def _vote(self, camera: Camera) -> None:
        votes = self.config.votes
        opacities, scales = self.model.seen_from(camera)
        self.ballot.cast(vote(opacities, scales, quantile=votes.quantile, by=votes.by))

    def _thin_out(self) -> None:
        """Remove what its mask says is not needed: the clear cases when votes are counted."""
        presence, masks = self.config.presence, self.model.rows.tensors["presence"]
        if self.done >= round(presence.until * self.steps):
            self.model.rows.drop("presence")
            self._prune(presence.stay(masks, last=True))
        elif self.ballot.prunes_after(self.done):
            self._prune(presence.stay(masks, last=False))

    def _prune(self, keep: Bool[Tensor, "n"]) -> None:
        if keep.any() and not keep.all():
            self.model.keep_rows(keep)
        self.ballot.clear(len(self.model))

    def _steer(self) -> None:
        """Bring the file nearer to the size that is asked for, some fifty times in all."""
        config = self.config
        every = max(1, round((1 - config.codes_fraction) * self.steps / STEERINGS))
        if config.target_mb and self.done % every == 0:
            size, wanted = len(pack(self.coded())), self.model.rows.tensors
            quantization.steer(self.model.codebooks, wanted, size, 1e6 * config.target_mb)

    def _rates(self) -> dict[str, float]:
        config, progress = self.config, self.done / self.steps
        rest = (progress - config.decay_from) / max(1 - config.decay_from, 1e-9)
        decay = log_linear(1.0, config.final_rate, rest)
        lobe_decoder = config.lobe_basis_rate
        if config.view.kind == "latent":
            lobe_decoder = config.network_rate
        elif config.view.kind == "decoded":  # a lobe's constant counts only C0 = 0.28 in a picture
            lobe_decoder = 2 * config.network_rate
        rates = {
            "means": self.position_rate,
            "quats": config.quat_rate,
            "log_scales": config.scale_rate,
            "logit_opacities": config.opacity_rate,
            "explicit_lobes": config.lobe_rate,
            "lobe_latents": config.lobe_rate,
            "lobe_decoder": lobe_decoder,
            "sh0": config.sh0_rate,
            "sh_rest": config.sh_rest_rate,
            "static": config.latent_rate,
            "view": config.latent_rate,
            "weighting": config.weighting_rate,
            "presence": config.presence.rate,
            "network": config.network_rate,
            "decoder": config.decoder_rate,
            "scale": config.codebook_rate,
            "opacity": config.codebook_rate,
            "rotation": config.rotation_codebook_rate,
            "appearance": config.appearance_codebook_rate,
            "lobes": config.lobe_codebook_rate,
            "free_scale": config.scale_rate * config.free_share,
            "free_opacity": config.opacity_rate * config.free_share,
            "free_rotation": config.quat_rate * config.free_share,
            "free_lobes": config.lobe_rate * config.free_share,
            "free_appearance": config.latent_rate * config.free_share,
        }
        if config.coding == "sq":
            rates |= dict.fromkeys((*COLUMNS, "lobes"), config.step_rate)
        return {name: rate * decay for name, rate in rates.items()}
