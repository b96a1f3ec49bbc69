"""The step loop of a training stage, the same for teacher and student."""

import time
from typing import Protocol, runtime_checkable

import torch
from PIL import Image

from mobilegs.atomic import atomic_path
from mobilegs.data.dataset import Dataset, Frame, View, ViewLoader, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import displayed_colors, psnr, to_bytes
from mobilegs.train.budget import Pace
from mobilegs.train.distributed import Team
from mobilegs.train.monitor import Monitor
from mobilegs.train.run_dir import Checkpoint, RunDir, StopRequest, stop_between_steps
from mobilegs.train.stage import Stage, view_order
from mobilegs.train.state_file import STATE_ERRORS, UNUSABLE, digest
from mobilegs.train.threads import torch_on_one_thread

PREVIEWS = 8  # per stage
PREFETCH = 8  # views that are decoded ahead, per process
CHECKPOINT_SECONDS = 60.0


@runtime_checkable
class LiveView(Protocol):
    """A view of the training for people, updated between steps."""

    def show(self, dataset: Dataset) -> None:
        """Show the photos of `dataset` from now on: the same ones, with other poses."""
        ...

    def after_step(self, stage: Stage, stop: StopRequest) -> None:
        """Show the stage. While a person pauses the training, block until `stop` is set."""
        ...


def train_stage(
    stage: Stage,
    loader: ViewLoader,
    run_dir: RunDir,
    monitor: Monitor,
    team: Team,
    *,
    resume_from: Checkpoint,
    order_seed: int,
    preview_frame: Frame,
    live: LiveView | None = None,
    checkpoint_seconds: float = CHECKPOINT_SECONDS,
    pace: Pace | None = None,
) -> None:
    """Train `stage` to its last step.

    The stage resumes from `resume_from` if that is a checkpoint of this stage. `loader` gives the
    training views, in an order that follows from `order_seed`. `run_dir` receives checkpoints, at
    most one per `checkpoint_seconds`, and previews of `preview_frame`. `pace` may change the number
    of steps on the way.

    Raises KeyboardInterrupt after a checkpoint if Ctrl-C or SIGTERM asks to stop, and InputError
    for a damaged checkpoint and if the processes of `team` no longer hold the same scene.
    """
    if resume_from.stage == stage.name:
        try:
            stage.restore(resume_from.state)
            if type(stage.done) is not int or not 0 <= stage.done <= stage.steps:
                raise ValueError(f"{stage.done} steps are done of {stage.steps}")
        except (*STATE_ERRORS, RuntimeError) as error:  # RuntimeErrors are those of torch
            raise InputError(
                f"{run_dir.checkpoint} does not fit this run ({error}): {UNUSABLE}"
            ) from error
    if pace is not None:
        pace.before(stage)
    lines = monitor.begin(stage)
    preview_every = max(1, stage.steps // PREVIEWS)
    saved_at = time.monotonic()
    with lines, stop_between_steps() as stop, torch_on_one_thread(wanted=stage.runs_kernels):
        while stage.done < stage.steps:
            result = stage.advance(next_views(stage, loader, team, order_seed))
            monitor.after_step(stage, result)
            if result.spread is not None:
                monitor.exposures(stage, result.spread)
            if pace is not None:
                pace.after_step(stage, sum(monitor.seconds.values()), team)
            if stage.done % preview_every == 0:
                validate_same_state(stage, team)
                if team.is_main:
                    save_preview(stage, preview_frame, run_dir, monitor, team.device)
            if live is not None:
                live.after_step(stage, stop)
            stopping = any(flag for [flag] in team.all_gather_ints(stop.requested))
            due = time.monotonic() - saved_at > checkpoint_seconds
            if team.is_main and (due or stopping or stage.done == stage.steps):
                state = Checkpoint(stage.name, stage.state(), monitor.seconds, monitor.rows)
                run_dir.save_checkpoint(state)
                saved_at = time.monotonic()
            if stopping:
                team.barrier()  # until the checkpoint is written
                raise KeyboardInterrupt


def next_views(
    stage: Stage, loader: ViewLoader, team: Team, order_seed: int
) -> list[tuple[int, View]]:
    """Return this process's views of the next step with their indices, and prefetch later ones."""
    number = stage.views_per_step
    ahead = number + PREFETCH * team.world_size
    order = view_order(len(loader), stage.done * number, ahead, order_seed)
    own = order[team.rank :: team.world_size]
    count = number // team.world_size
    loader.prefetch(own[count:])
    return [(index, loader.get(index, team.device)) for index in own[:count]]


def validate_same_state(stage: Stage, team: Team) -> None:
    """Raise InputError unless the stage has the same state in every process."""
    step = f"after step {stage.done} of the {stage.name}"
    team.require_identical(step, digest(stage.state()) if team.world_size > 1 else 0)


@torch.no_grad()
def save_preview(
    stage: Stage, frame: Frame, run_dir: RunDir, monitor: Monitor, device: torch.device
) -> None:
    """Render a held-back view with the current scene, save it as a PNG and log its PSNR."""
    view = load_view(frame).to(device)
    image = displayed_colors(stage.scene().render(view.camera).image)
    with atomic_path(run_dir.previews / f"{stage.name}_{stage.done:06}.png") as path:
        Image.fromarray(to_bytes(image).cpu().numpy()).save(path, format="PNG")
    mask = None if view.mask is None else view.mask > 0.5
    if mask is not None and not mask.any():
        return
    monitor.log(stage=stage.name, step=stage.done, preview_psnr=psnr(image, view.image, mask))
