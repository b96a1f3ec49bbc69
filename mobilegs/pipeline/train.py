"""Train a capture into a measured `scene.mgs`: teacher, student, file, metrics."""

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, fields, replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import torch
from jaxtyping import Float
from tyro.conf import Positional, UseAppendAction, arg

from mobilegs import __version__
from mobilegs.atomic import make_folder
from mobilegs.camera import Camera
from mobilegs.data import Dataset, ViewLoader, load_capture
from mobilegs.data.dataset import Frame, Offset
from mobilegs.device import Device
from mobilegs.errors import InputError
from mobilegs.evaluate.contact_sheet import contact_sheet
from mobilegs.evaluate.lpips import LpipsSuite, lpips_from
from mobilegs.evaluate.report import evaluate_side_by_side, write_metrics
from mobilegs.formats.ply import read_ply_scene, write_ply
from mobilegs.live import ADDRESS, LiveView, open_live_view, validate_live_options
from mobilegs.mgs.codec import read_mgs, write_mgs
from mobilegs.mgs.lod import lod_levels_for, with_lod_levels
from mobilegs.mgs.quantized_scene import MetaValue
from mobilegs.progress_display import Progress, no_progress
from mobilegs.render.scene import Scene
from mobilegs.scene_file import read_plain_scene
from mobilegs.train.budget import Pace, Plan, make_plan
from mobilegs.train.distributed import Team, join_team
from mobilegs.train.exposure import exposures_for
from mobilegs.train.loop import CHECKPOINT_SECONDS, train_stage
from mobilegs.train.monitor import Monitor, exposures_of
from mobilegs.train.poses import with_poses, write_poses
from mobilegs.train.recipes import (
    RECIPES,
    MethodName,
    PresetName,
    Recipe,
    with_method,
    with_settings,
    with_steps,
)
from mobilegs.train.run_dir import (
    Checkpoint,
    RunConfig,
    RunDir,
    capture_fingerprint,
    load_config,
    same_capture,
)
from mobilegs.train.stage import Stage
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher
from mobilegs.up import up_of_cameras, written_up
from mobilegs.viewpoints.first_view import find_framing

MINUTES = (1.0, 10_000)  # that --minutes takes
USUAL_MINUTES = {"cpu": 30.0, "cuda": 10.0}
STEPS = ("teacher.steps", "student.steps")  # settings that exclude a budget
TARGET_TOLERANCE = 0.05  # share of target_mb by which a file may miss it without a message
GPU_PRESETS = ("gpu", "paper", "release")  # too long for most CPUs
FIRST_LOOKS = 4  # cameras in the file, for a first look
# options that may differ between the sessions of one run
SESSION_OPTIONS = (
    "capture", "output", "resume", "lpips_weights", "device", "checkpoint_seconds",
    "live", "live_at",
)  # fmt: skip


@dataclass(frozen=True)
class TrainRun:
    """Train a phone-sized scene.mgs from photos or a video.

    RUN receives scene.mgs, teacher.ply, metrics.json, contact_sheet.png and report.html, one file
    with the scene, photos beside renders, curves and figures; during the training also
    metrics.jsonl, previews and a checkpoint. Ctrl-C stops after the current step, and --resume
    continues the run.
    """

    capture: Annotated[Positional[Path], arg(metavar="CAPTURE")]
    """Folder of photos with camera poses (COLMAP, nerfstudio's transforms.json or NeRF-synthetic),
    folder of photos without poses, or a video. Without poses, `mobilegs train` first makes
    RUN/capture with the default options of `mobilegs capture`."""
    output: Annotated[Path, arg(aliases=["-o"], metavar="RUN")]
    """Folder for the run; created if missing."""
    minutes: Annotated[float | None, arg(metavar="N")] = None
    """Time of the training. The program times a few steps on this machine, chooses the size of the
    photos, the number of Gaussians and the steps, and keeps to the time. Finding poses and
    measuring LPIPS come on top. Default: 30 on a CPU and 10 on a GPU, unless --preset, --steps or
    --recipe decide the length."""
    preset: PresetName | None = None
    """Length and size of the training. cpu: 5,000 steps of the teacher and 5,000 of the student,
    about 6 minutes on two cores for photos of 400x267 (see --downscale). gpu: 30,000 and 30,000
    steps. demo: 2,000 and 2,200 steps, for small captures. paper: the steps of gpu, with the
    paper's choices in place of this project's. release: the same for the paper's published code,
    errors included. With --minutes, the preset decides all but steps, photo size and number of
    Gaussians. Default: cpu, and gpu for a run on an NVIDIA GPU whose --steps are given."""
    method: MethodName | None = None
    """Training method of the teacher. 3dgs: clones, splits and prunes Gaussians, resets opacities.
    mini-splatting: the paper's method; restarts from surface points and keeps the most important
    Gaussians. mcmc: moves faint Gaussians and adds Gaussians up to --max-splats. Default:
    mini-splatting with the preset gpu, otherwise 3dgs without opacity resets."""
    downscale: Annotated[int | None, arg(metavar="N")] = None
    """Divide the width and height of the photos by N. Default: reduce photos to a width of at most
    1600 pixels."""
    steps: Annotated[int | None, arg(metavar="N")] = None
    """Training steps of teacher and student together; all schedules scale with them. Default:
    the steps of the preset."""
    recipe: Annotated[Path | None, arg(metavar="JSON")] = None
    """The config.json of another run: train with its settings, its photo size and its numbers of
    steps, those that a budget of minutes changed on the way included."""
    seed: Annotated[int, arg(metavar="N")] = 0
    """Seed of all random choices."""
    resume: bool = False
    """Continue the run in RUN, or start it if there is none."""
    teacher: Annotated[Path | None, arg(metavar="SCENE")] = None
    """A plain 3DGS scene to use as the teacher. Default: train a teacher."""
    max_splats: Annotated[int | None, arg(metavar="N")] = None
    """Maximum number of Gaussians in the teacher. Default: one million with the preset
    gpu, 60 thousand with cpu, 20 thousand with demo."""
    views_per_step: Annotated[int | None, arg(metavar="N")] = None
    """Photos per step of teacher and student. Processes that torchrun started share them. To
    change only the student's, use `--set student.views_per_step=N`. Default: 1."""
    background: Annotated[tuple[float, float, float] | None, arg(metavar="R G B")] = None
    """Background colour in 0..1. Default: white for photos with transparency, otherwise black."""
    lpips_weights: Annotated[str | None, arg(metavar="DIR")] = None
    """Folder or http(s) address of LPIPS weights. Default: the environment variable
    MOBILEGS_LPIPS; if that is not set, LPIPS is not measured."""
    device: Annotated[Device, arg(metavar="{auto,cpu,cuda,cuda:N}")] = "auto"
    """Device that trains; auto takes an NVIDIA GPU if there is one, cuda:N takes GPU number N."""
    checkpoint_seconds: Annotated[float, arg(metavar="SECONDS")] = CHECKPOINT_SECONDS
    """Time between two checkpoints."""
    live: bool = False
    """Show the scene in the browser during the training; the address is printed. The result of
    the training does not change."""
    live_at: Annotated[str, arg(metavar="HOST:PORT")] = ADDRESS
    """Address of --live; if the port is taken, the next free one is used. With the host 0.0.0.0,
    browsers on other devices can watch and pause the training."""
    settings: Annotated[
        tuple[tuple[str, ...], ...], UseAppendAction, arg(name="set", metavar="PATH=VALUE ...")
    ] = ()
    """Change settings, as in `--set student.lr.opacities=0.02`; may be repeated. The config.json
    of a run lists all settings."""


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


def train_run(
    run: TrainRun, *, recipe: Recipe | None = None, progress: Progress = no_progress
) -> dict[str, Any]:
    """Train the rest of a run and return the contents of `metrics.json`.

    `recipe` replaces that of the preset; `progress` shows the measuring at the end. Raises
    InputError before anything is written if an input cannot be used, and KeyboardInterrupt, after a
    checkpoint, if a signal asks to stop.
    """
    with join_team(run.device) as team:
        return train_in_team(run, recipe, team, progress)


def train_in_team(
    run: TrainRun, recipe: Recipe | None, team: Team, progress: Progress = no_progress
) -> dict[str, Any]:
    """Do the work of `train_run` in one process of a team; only the main process writes."""
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
        count = 0 if given is None else len(given.gaussians)
        config = new_config(run, recipe, team, count, started)
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


def train_stages(
    run: TrainRun,
    config: RunConfig,
    dataset: Dataset,
    run_dir: RunDir,
    team: Team,
    lpips: LpipsSuite | None,
    progress: Progress,
) -> dict[str, Any]:
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
        with progress("measuring") as advance:
            measure(job, teacher, lpips, advance)
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
    framing = find_framing(coded.decode(job.team.device), cameras)
    coded = replace(coded, meta=meta | framing.notes)
    levels = config.quantization.lod_levels
    levels = levels or min(lod_levels_for(len(coded)), config.max_lod_levels)
    write_mgs(job.run_dir.scene, with_lod_levels(coded, levels, stage.cameras))
    target, size = config.quantization.target_mb, job.run_dir.scene.stat().st_size / 1e6
    if target and abs(size - target) > TARGET_TOLERANCE * target:
        job.monitor.note(
            f"the file has {size:.3f} MB, but target_mb is {target:g}: rate control changes step "
            "sizes up to eightfold, and networks and header not at all"
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
    job: Job, teacher: Scene, lpips: LpipsSuite | None, advance: Callable[[int, int], None]
) -> None:
    """Evaluate the files of a run; write `contact_sheet.png` and `metrics.json`.

    `advance` is called with the number of photos done and in total.
    """
    run_dir, dataset = job.run_dir, job.dataset
    started = time.monotonic()
    student = read_mgs(run_dir.scene).decode(job.team.device)
    scenes = {"teacher": teacher, "student": student}
    metrics = evaluate_side_by_side(scenes, dataset, lpips=lpips, progress=advance)
    contact_sheet(run_dir.contact_sheet, dataset, teacher, student)
    camera = dataset.test[0].camera
    write_metrics(
        run_dir.metrics,
        teacher={
            "file_bytes": run_dir.teacher.stat().st_size,
            "gaussians": len(teacher.gaussians),
            **metrics["teacher"],
        },
        student=metrics["student"],
        file_bytes=run_dir.scene.stat().st_size,
        gaussians=len(student.gaussians),
        seconds={**job.monitor.seconds, "evaluation": time.monotonic() - started},
        more={
            "capture": dataset.name,
            "image_size": [camera.width, camera.height],
            "views": {"train": len(dataset.train), "test": len(dataset.test)},
            "exposures": exposures_of(job.monitor.rows),
            "poses": "refined" if run_dir.poses.exists() else "as given",
            "seed": job.run.seed,
            "device": str(job.team.device),
        },
    )
    run_dir.remove_checkpoint()


# --- options --------------------------------------------------------------------------------------


def budget_of(run: TrainRun) -> float | None:
    """Return the minutes of a run, or None if something else decides its length.

    Raises InputError for options that contradict each other or are out of range.
    """
    fixed = [name for name in ("steps", "recipe") if getattr(run, name) is not None]
    fixed += [s for s in chain(*run.settings) if s.partition("=")[0].strip() in STEPS]
    if run.minutes is not None:
        if not MINUTES[0] <= run.minutes <= MINUTES[1]:
            raise InputError(
                f"--minutes takes {MINUTES[0]:g} to {MINUTES[1]:,}, not {run.minutes:g}"
            )
        if fixed:
            raise InputError(f"{fixed[0]} decides the length of the run: leave out --minutes")
        return run.minutes
    if fixed or run.preset is not None:
        return None
    return USUAL_MINUTES["cuda" if trains_on_gpu(run) else "cpu"]


def trains_on_gpu(run: TrainRun) -> bool:
    """Return True if the run's device is an NVIDIA GPU."""
    return run.device != "cpu" and torch.cuda.is_available()


def new_config(
    run: TrainRun, recipe: Recipe | None, team: Team, given: int, started: float
) -> RunConfig:
    """Return the configuration of a new run, without the photos.

    `recipe` replaces that of the preset, and then there is no budget. `given` is the number of
    Gaussians of a given teacher. Times count from `started`.
    """
    minutes = None if recipe is not None else budget_of(run)
    if run.recipe is not None:
        found = repeat_run(run)
        recipe = resolve_recipe(run, found.recipe)
        validate_views_per_step(run, recipe, team.world_size)
        return replace(found, recipe=recipe)
    resolved, plan = resolve_recipe(run, recipe), None
    validate_views_per_step(run, resolved, team.world_size)
    if minutes is not None:
        found = make_plan(
            resolved,
            minutes,
            lambda n: load_capture(run.capture, downscale=n, background=run.background),
            downscale=run.downscale,
            max_splats=run.max_splats,
            given=given,
            team=team,
            started=started,
        )
        resolved, plan = resolve_recipe(run, found.recipe), found.plan
        run = replace(run, downscale=found.downscale)
    return RunConfig(options_as_json(run), resolved, {}, plan)


def repeat_run(run: TrainRun) -> RunConfig:
    """Return the configuration of a run that repeats another with its numbers of steps."""
    assert run.recipe is not None
    clash = [n for n in ("preset", "method", "steps", "max_splats") if getattr(run, n) is not None]
    if clash:
        name = clash[0].replace("_", "-")
        raise InputError(f"{run.recipe} decides that already: leave out --{name}, or --recipe")
    found = load_config(run.recipe, "give the config.json of a run")
    plan = None if found.plan is None else replace(found.plan, final=True)
    downscale = found.options["downscale"] if run.downscale is None else run.downscale
    options = options_as_json(replace(run, downscale=downscale))
    return RunConfig(options, found.recipe, {}, plan)


def resolve_recipe(run: TrainRun, recipe: Recipe | None = None) -> Recipe:
    """Return the recipe of a new run: that of the preset, or `recipe`, changed by the options.

    Raises InputError for options that contradict each other or are out of range, and for students
    that no file can hold.
    """
    if not 0 <= run.seed < 1 << 32:
        raise InputError(f"the seed must be between 0 and {(1 << 32) - 1}, not {run.seed}")
    validate_live_options(run.live, run.live_at)
    on_cpu = run.device == "auto" and not torch.cuda.is_available()
    if run.preset in GPU_PRESETS and on_cpu and run.minutes is None and run.steps is None:
        raise InputError(
            f"the preset {run.preset} is for a GPU, and this machine has none: add --device cpu to "
            "train for many hours, or give --minutes or --steps, or leave out --preset"
        )
    if recipe is None:
        usual = "gpu" if trains_on_gpu(run) and budget_of(run) is None else "cpu"
        recipe = RECIPES[run.preset or usual]()
    if run.method is not None:
        if run.teacher is not None:
            raise InputError(f"{run.teacher} is trained already: leave out --method")
        recipe = with_method(recipe, run.method)
    if run.steps is not None:
        recipe = with_steps(recipe, run.steps)
    if run.max_splats is not None:
        if run.teacher is not None:
            raise InputError(f"{run.teacher} keeps its Gaussians: leave out --max-splats")
        recipe = replace(recipe, teacher=replace(recipe.teacher, max_splats=run.max_splats))
    if run.views_per_step is not None:
        recipe = Recipe(
            replace(recipe.teacher, views_per_step=run.views_per_step),
            replace(recipe.student, views_per_step=run.views_per_step),
        )
    return with_settings(recipe, chain(*run.settings))


def validate_views_per_step(run: TrainRun, recipe: Recipe, world_size: int) -> None:
    """Raise InputError unless `world_size` processes get equal shares of every step's views."""
    for name, stage in (("teacher", recipe.teacher), ("student", recipe.student)):
        given = name == "teacher" and run.teacher is not None
        if stage.views_per_step % world_size and not given:
            raise InputError(
                f"{world_size} processes cannot share the {stage.views_per_step} views of a step "
                f"of the {name} evenly: give --views-per-step a multiple of {world_size}, or start "
                "another number of processes"
            )


def options_as_json(run: TrainRun) -> dict[str, Any]:
    """Return the options as JSON values: paths become strings, tuples become lists."""
    values = {field.name: getattr(run, field.name) for field in fields(run)}
    values["settings"] = tuple(chain(*run.settings))
    return {
        name: str(value)
        if isinstance(value, Path)
        else list(value)
        if isinstance(value, tuple)
        else value
        for name, value in values.items()
    }


def resume_options(run: TrainRun, saved: dict[str, Any]) -> TrainRun:
    """Return the options of a session that resumes a run whose options are `saved`.

    Raises InputError if an option is given that contradicts the run's.
    """
    given = options_as_json(run)
    for field in fields(run):
        name = field.name
        if name in SESSION_OPTIONS or given[name] == saved.get(name):
            continue
        if getattr(run, name) != field.default:
            raise InputError(
                f"the run in {run.output} was started with {name} {saved.get(name)}, not "
                f"{given[name]}: leave the option out to resume, or start another run"
            )
    background = saved["background"]
    return replace(
        run,
        teacher=None if saved["teacher"] is None else Path(saved["teacher"]),
        downscale=saved["downscale"],
        seed=saved["seed"],
        background=None if background is None else tuple(background),
    )
