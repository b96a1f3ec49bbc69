"""Train a capture into a measured `scene.mgs`: teacher, student, file, metrics."""

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np
import torch
from jaxtyping import Float

from mobilegs import __version__
from mobilegs.atomic import atomic_write, make_folder
from mobilegs.camera import Camera
from mobilegs.data import Dataset, ViewLoader, load_capture
from mobilegs.data.dataset import Frame, Offset
from mobilegs.errors import InputError
from mobilegs.evaluate.contact_sheet import contact_sheet
from mobilegs.evaluate.front import lost_in_front
from mobilegs.evaluate.lpips import LpipsSuite, lpips_from
from mobilegs.evaluate.other_formats import FormatMetrics, measure_formats
from mobilegs.evaluate.report import (
    FileMetrics,
    RunMetrics,
    evaluate_side_by_side,
    peak_memory_mib,
    to_json,
)
from mobilegs.formats.ply import read_ply_scene, write_ply
from mobilegs.live import LiveView, open_live_view
from mobilegs.mgs.codec import read_mgs, write_mgs
from mobilegs.mgs.lod import lod_levels_for, with_lod_levels
from mobilegs.mgs.quantized_scene import MetaValue
from mobilegs.pipeline.options import (
    TrainRun,
    budget_of,
    options_as_json,
    repeat_run,
    resolve_recipe,
    resume_options,
    validate_views_per_step,
)
from mobilegs.progress_display import Progress, no_progress
from mobilegs.render.scene import Scene
from mobilegs.scene_file import read_plain_scene
from mobilegs.train.budget import Pace, Plan, make_plan
from mobilegs.train.distributed import Team, join_team
from mobilegs.train.exposure import exposures_for
from mobilegs.train.loop import train_stage
from mobilegs.train.monitor import Monitor, exposures_of
from mobilegs.train.poses import with_poses, write_poses
from mobilegs.train.recipes import Recipe
from mobilegs.train.run_dir import (
    Checkpoint,
    RunConfig,
    RunDir,
    capture_fingerprint,
    same_capture,
)
from mobilegs.train.stage import Stage
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher
from mobilegs.train.threads import torch_on_one_thread
from mobilegs.up import up_of_cameras, written_up
from mobilegs.viewpoints.first_view import find_framing
from mobilegs.viewpoints.visibility import validate_visibility

TARGET_TOLERANCE = 0.05  # share of target_mb by which a file may miss it without a message
FRONT_VIEWS = 12  # held-back photos in which light lost before surfaces is measured, or a few more
FIRST_LOOKS = 4  # cameras in the file, for a first look


@dataclass(frozen=True)
class Job:
    """A run with everything that its stages need, after all inputs were validated."""

    run: TrainRun
    recipe: Recipe
    run_dir: RunDir
    dataset: Dataset
    loader: ViewLoader
    monitor: Monitor
    team: Team
    live: LiveView | None
    checkpoint: Checkpoint
    pace: Pace | None


def train_capture(
    run: TrainRun, *, recipe: Recipe | None = None, progress: Progress = no_progress
) -> RunMetrics:
    """Train a capture into `scene.mgs`, as `mobilegs train`, and return `metrics.json`.

    With `run.resume`, what is left of the run is done.

    Example:

        run = TrainRun(Path("my_capture"), Path("runs/a"), preset="short", target_mb=1.5)
        print(train_capture(run)["student"]["psnr"])

    Args:
        run: the options, those of `mobilegs train`.
        recipe: all settings, in place of the preset's; then the run has no budget of minutes.
        progress: opens the measuring at the end, by its title.

    Raises:
        InputError: an input or an option cannot be used; before anything is written.
        KeyboardInterrupt: a signal asked to stop; after a checkpoint.
    """
    with join_team(run.device) as team:
        return train_in_team(run, recipe, team, progress)


def train_in_team(
    run: TrainRun, recipe: Recipe | None, team: Team, progress: Progress = no_progress
) -> RunMetrics:
    """Do the work of `train_capture` in one process of a team; only the main process writes."""
    started = time.monotonic()
    run_dir, given = RunDir(run.output), None
    resuming = run.resume and run_dir.config.exists()
    lpips = lpips_from(run.lpips_weights)
    if resuming:
        config = run_dir.load_config()
        run = resume_options(run, config.options)
        validate_views_per_step(run, config.recipe, team.world_size)
    else:
        run_dir.validate_new()
        if run.teacher is not None:
            given = read_plain_scene(run.teacher)
        config = new_config(run, recipe, team, given, started)
    recipe = config.recipe
    run = replace(run, downscale=config.options["downscale"])
    dataset = load_capture(run.capture, downscale=run.downscale, background=run.background)
    if not resuming:
        config = replace(config, photos=capture_fingerprint(dataset))
    elif not same_capture(config.photos, capture_fingerprint(dataset)):
        raise InputError(f"{run.capture} is not the capture that the run in {run.output} trains on")
    if resuming and run_dir.metrics.exists():
        return run_dir.load_metrics()
    if not dataset.test:
        raise InputError(f"{run.capture} holds no photo back for the test: it needs more photos")
    if run.teacher is not None and given is None and not run_dir.teacher.exists():
        given = read_plain_scene(run.teacher)
    team.barrier()  # until all processes have looked at the folder
    make_folder(run.output)
    with ExitStack() as opened:
        if team.is_main:
            opened.enter_context(run_dir.lock())
            if not resuming:
                run_dir.create(config)
            if given is not None:
                write_ply(run_dir.teacher, given.gaussians, footprint=given.footprint, up=given.up)
        team.barrier()
        return train_stages(run, config, dataset, run_dir, team, lpips, progress)


def validate_teacher(teacher: Scene, run: TrainRun) -> None:
    """Raise InputError if most photos of the run's capture show nothing of a given teacher."""
    dataset = load_capture(run.capture, downscale=run.downscale, background=run.background)
    cameras = [frame.camera for frame in dataset.train]
    remedy = "give the capture that it was made from"
    validate_visibility(teacher, cameras, f"photos of {run.capture}", remedy)


def train_stages(
    run: TrainRun,
    config: RunConfig,
    dataset: Dataset,
    run_dir: RunDir,
    team: Team,
    lpips: LpipsSuite | None,
    progress: Progress,
) -> RunMetrics:
    """Train what is left of a run, measure it and return the contents of `metrics.json`."""
    recipe, checkpoint = config.recipe, run_dir.load_checkpoint()
    with (
        ExitStack() as opened,
        ViewLoader(dataset.train) as loader,
        Monitor(
            run_dir.log,
            checkpoint.log,
            checkpoint.seconds,
            sizes=recipe.student.expected_bytes,
            silent=not team.is_main,
        ) as monitor,
        open_live_view(run.live, run.live_at, dataset, monitor) as live,
    ):
        pace = None
        if config.plan is not None:

            def save(plan: Plan) -> None:
                if team.is_main:
                    run_dir.write_config(replace(config, plan=plan))

            pace = Pace(config.plan, save)
        job = Job(run, recipe, run_dir, dataset, loader, monitor, team, live, checkpoint, pace)
        announce(job)
        if not run_dir.teacher.exists():
            train_teacher(job)
        if run_dir.poses.exists():
            dataset = with_poses(dataset, run_dir.poses)
            loader = opened.enter_context(ViewLoader(dataset.train))
            job = replace(job, dataset=dataset, loader=loader)
            if live is not None:
                live.show(dataset)
        gaussians, footprint = read_ply_scene(run_dir.teacher)
        teacher = Scene(
            gaussians.to(team.device),
            background=dataset.background.to(team.device),
            near=dataset.near,
            footprint=footprint,
        )
        if not run_dir.scene.exists():
            train_student(job, teacher)
    if team.is_main:
        formats: dict[str, FormatMetrics] = {}
        if run.teacher is not None:
            with progress("measuring other formats") as advance:
                formats = measure_formats(teacher, dataset, advance)
        with progress("measuring") as advance:
            measure(job, teacher, formats, lpips, advance)
    team.barrier()
    return run_dir.load_metrics()


def announce(job: Job) -> None:
    """Log the size of the capture and the length of the training."""
    dataset, recipe = job.dataset, job.recipe
    camera = dataset.train[0].camera
    first = "" if job.run.teacher else f"{recipe.teacher.steps:,} steps for the teacher and "
    text = (
        f"{len(dataset.train) + len(dataset.test)} photos of {camera.width}x{camera.height}, "
        f"{first}{recipe.student.steps:,} steps for the student"
    )
    if job.pace is not None and not job.pace.plan.final:
        most = "" if job.run.teacher else f"at most {recipe.teacher.max_splats:,} Gaussians, "
        text = (
            f"{job.pace.plan.minutes:g} minutes on this machine: "
            f"{text.replace(', ', ', ' + most + 'about ', 1)}"
        )
        text += job.pace.plan.memory_note
    job.monitor.note(text)
    teacher = recipe.teacher
    if not job.run.teacher and teacher.densify.strategy == "mini_splatting":
        other = {"indoor": "outdoor", "outdoor": "indoor"}[teacher.importance]
        job.monitor.note(
            f"Mini-Splatting weighs Gaussians as in {teacher.importance} captures "
            f"(else: --set teacher.importance={other})"
        )


def train_teacher(job: Job) -> None:
    """Train the teacher and write `teacher.ply`."""
    seed, team = job.run.seed, job.team
    stage = Teacher(job.recipe.teacher, job.dataset, seed=seed, device=team.device, team=team)
    run_stage(job, stage, order_seed=2 * seed)
    if team.is_main:
        if stage.poses is not None:
            write_poses(job.run_dir.poses, stage.poses.refined(job.dataset, stage.scene()))
        footprint, note = job.recipe.teacher.scene_footprint, offset_note(job.dataset.offset)
        options = {"footprint": footprint, "up": up_of_frames(job.dataset.train), "note": note}
        write_ply(job.run_dir.teacher, stage.gaussians(), **options)
    team.barrier()


def train_student(job: Job, teacher: Scene) -> None:
    """Train the student and write `scene.mgs`."""
    dataset, seed, team = job.dataset, job.run.seed, job.team
    exposures, spread = None, None
    with job.monitor.lines_of("preparing the student"):
        if job.checkpoint.stage != "student":  # a checkpoint holds them
            exposures, spread = exposures_for(job.recipe.student.exposure, teacher, dataset.train)
        stage = Student(
            job.recipe.student,
            teacher,
            [frame.camera for frame in dataset.train],
            extent=dataset.extent,
            seed=seed,
            team=team,
            exposures=exposures,
        )
    if spread is not None:
        job.monitor.exposures(stage, spread)
    run_stage(job, stage, order_seed=2 * seed + 1)
    if team.is_main:
        with job.monitor.lines_of("writing the scene"):
            write_scene(job, stage)


def run_stage(job: Job, stage: Stage, *, order_seed: int) -> None:
    """Run the step loop of a stage."""
    train_stage(
        stage,
        job.loader,
        job.run_dir,
        job.monitor,
        job.team,
        resume_from=job.checkpoint,
        order_seed=order_seed,
        preview_frame=job.dataset.test[0],
        live=job.live,
        checkpoint_seconds=job.run.checkpoint_seconds,
        pace=job.pace,
    )


def write_scene(job: Job, stage: Student) -> None:
    """Write `scene.mgs`, with notes on its training and cameras for a first look."""
    dataset, config = job.dataset, job.recipe.student
    frames = dataset.train[:: max(1, len(dataset.train) // FIRST_LOOKS)]
    camera = dataset.train[0].camera
    meta: dict[str, MetaValue] = {
        "generator": f"mobilegs {__version__}",
        "capture": dataset.name,
        "photos": f"{len(dataset.train)} of {camera.width}x{camera.height}",
        "student_steps": stage.steps,
        "up": written_up(up_of_frames(dataset.train)),
    }
    if note := offset_note(dataset.offset):
        meta["offset"] = note.removeprefix("offset ")
    views: list[Camera] = [frame.camera for frame in frames[:FIRST_LOOKS]]
    coded = stage.quantized_scene(views=views, meta=meta)
    cameras = [frame.camera for frame in dataset.train]
    with torch_on_one_thread():  # its many pictures are small
        framing = find_framing(coded.decode(job.team.device), cameras)
    coded = replace(coded, meta=meta | framing.notes)
    levels = config.quantization.lod_levels
    levels = levels or min(lod_levels_for(len(coded)), config.max_lod_levels)
    write_mgs(job.run_dir.scene, with_lod_levels(coded, levels, stage.cameras))
    target, size = config.quantization.target_mb, job.run_dir.scene.stat().st_size / 1e6
    if target and abs(size - target) > TARGET_TOLERANCE * target:
        more = "fewer" if size > target else "more"
        remedy = "" if job.run.teacher else " (--max-splats)"
        job.monitor.note(
            f"the file has {size:.3f} MB, not the {target:g} MB of target_mb: rate control ended "
            f"at a quality of {stage.quantization.quality:.3g}; a teacher with {more} "
            f"Gaussians{remedy} comes nearer"
        )


def up_of_frames(frames: list[Frame]) -> Float[np.ndarray, "3"]:
    """Return the upward direction that the cameras of photos share."""
    return up_of_cameras(torch.stack([frame.camera.viewmat for frame in frames]).double().numpy())


def offset_note(offset: Offset) -> str:
    """Return `offset X Y Z` for a georeferenced capture, else nothing.

    A scene's positions plus the offset are those of the capture.
    """
    return f"offset {' '.join(f'{part:.0f}' for part in offset)}" if any(offset) else ""


def measure(
    job: Job,
    teacher: Scene,
    formats: dict[str, FormatMetrics],
    lpips: LpipsSuite | None,
    advance: Callable[[int, int], None],
) -> None:
    """Evaluate the files of a run; write `contact_sheet.png` and `metrics.json`.

    `formats` are the figures of the teacher in other formats. `advance` is called with the number
    of photos done and in total.
    """
    run_dir, dataset = job.run_dir, job.dataset
    started = time.monotonic()
    student = read_mgs(run_dir.scene).decode(job.team.device)
    scenes = {"teacher": teacher, "student": student}
    measured = evaluate_side_by_side(scenes, dataset, lpips=lpips, progress=advance)
    some = dataset.test[:: max(1, len(dataset.test) // FRONT_VIEWS)]
    front = lost_in_front(teacher, scenes, [frame.camera for frame in some])
    contact_sheet(run_dir.contact_sheet, dataset, teacher, student)

    def of_file(name: str, path: Path) -> FileMetrics:
        size, count = path.stat().st_size, len(scenes[name].gaussians)
        about = {"file_bytes": size, "gaussians": count, "front": front[name]}
        return cast(FileMetrics, about | measured[name])

    camera = dataset.test[0].camera
    metrics: RunMetrics = {
        "teacher": of_file("teacher", run_dir.teacher),
        "student": of_file("student", run_dir.scene),
        "formats": formats,
        "seconds": {**job.monitor.seconds, "evaluation": time.monotonic() - started},
        "peak_memory_mib": peak_memory_mib(),
        "capture": dataset.name,
        "image_size": [camera.width, camera.height],
        "views": {"train": len(dataset.train), "test": len(dataset.test)},
        "exposures": exposures_of(job.monitor.rows),
        "poses": "refined" if run_dir.poses.exists() else "as given",
        "seed": job.run.seed,
        "device": str(job.team.device),
    }
    atomic_write(run_dir.metrics, to_json(metrics) + "\n")
    run_dir.remove_checkpoint()


def new_config(
    run: TrainRun, recipe: Recipe | None, team: Team, given: Scene | None, started: float
) -> RunConfig:
    """Return the configuration of a new run, without the photos.

    `recipe` replaces that of the preset, and then there is no budget. `given` is a teacher that is
    trained already. Times count from `started`.
    """
    footprint = None if given is None else given.footprint
    minutes = None if recipe is not None else budget_of(run)
    repeated, plan = None if run.recipe is None else repeat_run(run), None
    resolved = resolve_recipe(run, recipe if repeated is None else repeated.recipe, footprint)
    validate_views_per_step(run, resolved, team.world_size)
    if given is not None:
        validate_teacher(given, run)
    if repeated is not None:
        return replace(repeated, recipe=resolved)
    if minutes is not None:
        planned = make_plan(
            resolved,
            minutes,
            lambda n: load_capture(run.capture, downscale=n, background=run.background),
            downscale=run.downscale,
            max_splats=run.max_splats,
            given=0 if given is None else len(given.gaussians),
            team=team,
            started=started,
        )
        resolved, plan = resolve_recipe(run, planned.recipe, footprint), planned.plan
        run = replace(run, downscale=planned.downscale)
    return RunConfig(options_as_json(run), resolved, {}, plan)
