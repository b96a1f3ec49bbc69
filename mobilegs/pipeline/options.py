"""Options of the runs that train, and the recipe that follows from them."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import torch
from tyro.conf import Positional, UseAppendAction, arg

from mobilegs.device import Device
from mobilegs.errors import InputError
from mobilegs.live import ADDRESS, validate_live_options
from mobilegs.render.project import Footprint
from mobilegs.train.budget import FILE_BYTES_PER_SPLAT
from mobilegs.train.loop import CHECKPOINT_SECONDS
from mobilegs.train.recipes import (
    RECIPES,
    MethodName,
    PresetName,
    Recipe,
    with_method,
    with_settings,
    with_steps,
)
from mobilegs.train.run_dir import RunConfig, load_config

MINUTES = (1.0, 10_000)  # that --minutes takes
USUAL_MINUTES = {"cpu": 30.0, "cuda": 3.0}
STEPS = ("teacher.steps", "student.steps")  # settings that exclude a budget
LONG_PRESETS = ("long", "paper", "release")  # too long for most CPUs
# options that may differ between the sessions of one run
SESSION_OPTIONS = (
    "capture", "output", "resume", "lpips_weights", "device", "checkpoint_seconds",
    "live", "live_at",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of every run that trains."""

    minutes: Annotated[float | None, arg(metavar="N")] = None
    """Time of the training. The program times a few steps on this machine, chooses the number of
    steps and, if it trains a teacher, the size of the photos and the number of Gaussians, and keeps
    to the time. Finding poses, rendering views and measuring LPIPS come on top. Default: 30 on a
    CPU and 3 on a GPU, unless --preset, --steps or a recipe decide the length."""
    preset: PresetName | None = None
    """Length and size of the training. demo: 2,000 steps of the teacher and 2,200 of the student,
    for small captures. short: 5,000 and 5,000 steps, about 6 minutes on two cores for photos of
    400x267 (see --downscale). long: 30,000 and 30,000 steps, for a GPU. paper: the steps of long,
    with the paper's choices in place of this project's. release: the same for the paper's published
    code, errors included. With --minutes, the preset decides all but steps, photo size and number
    of Gaussians. Default: short, and long for a run on an NVIDIA GPU whose --steps are given."""
    steps: Annotated[int | None, arg(metavar="N")] = None
    """Training steps in total: of teacher and student, or of the student alone if the teacher is a
    given scene. All schedules scale with them. Default: the steps of the preset."""
    target_mb: Annotated[float | None, arg(metavar="MB")] = None
    """Size of the file in megabytes (10^6 bytes). A teacher that is trained has at most as many
    Gaussians as fit, and the student's quantisation changes until the file has this size. A file
    that misses it by more than 5 % is reported. Default: no target; the setting
    student.quantization.quality decides."""
    downscale: Annotated[int | None, arg(metavar="N")] = None
    """Divide the width and height of the photos by N. Default: with a time, the plan chooses; else
    photos are reduced to a width of at most 1600 pixels."""
    background: Annotated[tuple[float, float, float] | None, arg(metavar="R G B")] = None
    """Background colour in 0..1, also that of a given scene, whose file does not contain it.
    Default: white for photos with transparency, otherwise black."""
    seed: Annotated[int, arg(metavar="N")] = 0
    """Seed of all random choices."""
    resume: bool = False
    """Continue the run in RUN, or start it if there is none. Of the options, those of the session
    may differ: device, live, live-at, lpips-weights, checkpoint-seconds."""
    lpips_weights: Annotated[str | None, arg(metavar="DIR")] = None
    """Folder or http(s) address of LPIPS weights. Default: the environment variable
    MOBILEGS_LPIPS; if that is not set, LPIPS is not measured."""
    device: Annotated[Device, arg(metavar="{auto,cpu,cuda,cuda:N}")] = "auto"
    """Device that trains; auto takes an NVIDIA GPU if there is one, cuda:N takes GPU number N."""
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
class TrainRun(RunOptions):
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
    method: MethodName | None = None
    """Training method of the teacher. 3dgs: clones, splits and prunes Gaussians, resets opacities.
    mini-splatting: the paper's method; restarts from surface points and keeps the most important
    Gaussians. mcmc: moves faint Gaussians and adds Gaussians up to --max-splats. Default:
    mini-splatting with the preset long, otherwise 3dgs without opacity resets."""
    recipe: Annotated[Path | None, arg(metavar="JSON")] = None
    """The config.json of another run: train with its settings, its photo size and its numbers of
    steps, those that a budget of minutes changed on the way included."""
    teacher: Annotated[Path | None, arg(metavar="SCENE")] = None
    """A plain 3DGS scene to use as the teacher, as `mobilegs compress SCENE --capture CAPTURE`
    does. The student covers pixels as the scene does. Default: train a teacher."""
    max_splats: Annotated[int | None, arg(metavar="N")] = None
    """Maximum number of Gaussians in the teacher. Default: with a time, the plan chooses; else one
    million with the preset long, 60 thousand with short, 20 thousand with demo."""
    views_per_step: Annotated[int | None, arg(metavar="N")] = None
    """Photos per step of teacher and student. Processes that torchrun started share them. To
    change only the student's, use `--set student.views_per_step=N`. Default: 1."""
    checkpoint_seconds: Annotated[float, arg(metavar="SECONDS")] = CHECKPOINT_SECONDS
    """Time between two checkpoints."""


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


def resolve_recipe(
    run: TrainRun, recipe: Recipe | None = None, footprint: Footprint | None = None
) -> Recipe:
    """Return the recipe of a new run: that of the preset, or `recipe`, changed by the options.

    `footprint` is that of a given teacher. Raises InputError for options that contradict each other
    or are out of range, and for students that no file can hold.
    """
    if not 0 <= run.seed < 1 << 32:
        raise InputError(f"the seed must be between 0 and {(1 << 32) - 1}, not {run.seed}")
    validate_live_options(run.live, run.live_at)
    on_cpu = run.device == "auto" and not torch.cuda.is_available()
    if run.preset in LONG_PRESETS and on_cpu and run.minutes is None and run.steps is None:
        raise InputError(
            f"the preset {run.preset} is for a GPU, and this machine has none: add --device cpu to "
            "train for many hours, or give --minutes or --steps, or leave out --preset"
        )
    if recipe is None:
        usual = "long" if trains_on_gpu(run) and budget_of(run) is None else "short"
        recipe = RECIPES[run.preset or usual]()
    if run.teacher is not None and run.method is not None:
        raise InputError(f"{run.teacher} is trained already: leave out --method")
    if run.teacher is not None and run.max_splats is not None:
        raise InputError(f"{run.teacher} keeps its Gaussians: leave out --max-splats")
    if run.method is not None:
        recipe = with_method(recipe, run.method)
    if run.steps is not None and run.teacher is None:
        recipe = with_steps(recipe, run.steps)
    return with_settings(recipe, [*_option_settings(run, recipe, footprint), *chain(*run.settings)])


def _option_settings(run: TrainRun, recipe: Recipe, footprint: Footprint | None) -> Iterator[str]:
    """Yield the settings that options stand for, and those that a given teacher brings."""
    own = recipe.teacher.footprint
    given = None if footprint is None else (footprint.blur, footprint.antialiased)
    if footprint is not None and given != (own.blur, own.antialiased):
        # its Gaussians may be as small as they are: it may be trained on larger photos
        yield f"student.footprint.blur={footprint.blur}"
        yield f"student.footprint.antialiased={str(footprint.antialiased).lower()}"
        yield "student.least_variance=0"
    if run.steps is not None and run.teacher is not None:
        yield f"student.steps={run.steps}"
    if run.max_splats is not None:
        yield f"teacher.max_splats={run.max_splats}"
    if run.target_mb is not None:
        yield f"student.quantization.target_mb={run.target_mb}"
        if run.max_splats is None and run.target_mb > 0:
            fitting = max(1, int(1e6 * run.target_mb / FILE_BYTES_PER_SPLAT))
            yield f"teacher.max_splats={min(recipe.teacher.max_splats, fitting)}"
    if run.views_per_step is not None:
        yield f"teacher.views_per_step={run.views_per_step}"
        yield f"student.views_per_step={run.views_per_step}"


def repeat_run(run: TrainRun) -> RunConfig:
    """Return the configuration of a run that repeats another with its numbers of steps."""
    assert run.recipe is not None
    clash = [n for n in ("preset", "method", "steps", "max_splats") if getattr(run, n) is not None]
    if clash:
        name = clash[0].replace("_", "-")
        raise InputError(f"{run.recipe} decides that already: leave out --{name}, or --recipe")
    config = load_config(run.recipe, "give the config.json of a run")
    plan = None if config.plan is None else replace(config.plan, final=True)
    downscale = config.options["downscale"] if run.downscale is None else run.downscale
    options = options_as_json(replace(run, downscale=downscale))
    return RunConfig(options, config.recipe, {}, plan)


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
