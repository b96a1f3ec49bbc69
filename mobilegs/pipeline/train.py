"""From a capture to a measured `scene.mgs`: teacher, student, file, figures."""

import time
from dataclasses import dataclass, fields, replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal

import torch
from PIL import Image
from tyro.conf import Positional, UseAppendAction, arg

from mobilegs import __version__
from mobilegs.atomic import atomic_path
from mobilegs.camera import Camera
from mobilegs.data import Dataset, ViewLoader, load_capture, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.contact_sheet import contact_sheet
from mobilegs.evaluate.lpips import LpipsSuite, lpips_from
from mobilegs.evaluate.metrics import as_displayed, psnr, to_bytes
from mobilegs.evaluate.report import evaluate_side_by_side, write_metrics
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.live import ADDRESS, Watch, refuse, watched
from mobilegs.mgs.codec import read_mgs, write_mgs
from mobilegs.mgs.lod import layered, layers_for
from mobilegs.mgs.quantized_scene import MetaValue
from mobilegs.render.scene import Scene
from mobilegs.scene_file import read_gaussians
from mobilegs.train.checkpoint import digest
from mobilegs.train.distributed import Team, joined
from mobilegs.train.progress import Monitor
from mobilegs.train.recipes import (
    RECIPES,
    MethodName,
    PresetName,
    Recipe,
    with_method,
    with_settings,
    with_steps,
)
from mobilegs.train.run_dir import RunFolder, photos_of, same_photos, stopping_between_steps
from mobilegs.train.stage import Stage, view_order
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher

PREVIEWS = 8  # pictures a stage leaves
MISSED = 0.05  # share of a size that was asked for, from which on it is said
PREFETCH = 8  # views decoded ahead
FIRST_LOOKS = 4  # cameras that go into the file, for viewers to begin at
BETWEEN_SESSIONS = (
    "capture", "output", "resume", "lpips_weights", "device", "checkpoint_seconds",
    "live", "live_at",
)  # fmt: skip


@dataclass(frozen=True)
class TrainRun:
    """Train a capture: photos with poses in, a phone-sized scene.mgs out.

    RUN then holds scene.mgs, teacher.ply, metrics.json, contact_sheet.png, and on the way
    metrics.jsonl, previews and a checkpoint. Ctrl-C leaves a run that --resume continues.
    """

    capture: Annotated[Positional[Path], arg(metavar="CAPTURE")]
    """Folder of the photos and their poses: COLMAP, nerfstudio's transforms.json, or
    NeRF-synthetic. Of photos without poses, or a video, mobilegs train makes RUN/capture first
    (mobilegs capture has options for that)."""
    output: Annotated[Path, arg(aliases=["-o"], metavar="RUN")]
    """Folder for the run; it is made if it is missing."""
    preset: PresetName | None = None
    """How long and how many: cpu is meant for two cores and some 15 minutes with photos of
    400x266 (see downscale), gpu has the paper's 30,000 + 30,000 steps, demo is small. Without
    it, gpu where there is one."""
    method: MethodName | None = None
    """How the teacher is trained. 3dgs: clone, split, prune, reset opacities. mini-splatting: the
    paper's; begins anew from surfaces and keeps what matters. mcmc: moves what is faint, always
    up to max_splats. Without it, mini-splatting with the preset gpu, with the others 3dgs that
    resets nothing."""
    downscale: Annotated[int | None, arg(metavar="N")] = None
    """Divide the photos' size by this. Without it they are at most 1600 pixels wide."""
    steps: Annotated[int | None, arg(metavar="N")] = None
    """Steps of teacher and student together; all schedules scale with it."""
    seed: int = 0
    """Start of all random choices."""
    resume: bool = False
    """Continue the run that RUN holds; begin one if there is none."""
    teacher: Annotated[Path | None, arg(metavar="SCENE")] = None
    """A plain 3DGS scene that is the teacher, instead of training one."""
    max_splats: Annotated[int | None, arg(metavar="N")] = None
    """The teacher never has more Gaussians than this."""
    views_per_step: Annotated[int | None, arg(metavar="N")] = None
    """Photos in one step of teacher and student; processes that torchrun started share them out.
    --set student.views_per_step=N is for the student alone."""
    background: tuple[float, float, float] | None = None
    """Colour behind everything, RGB in 0..1. Without it, white for renders with transparency,
    black otherwise."""
    lpips_weights: Annotated[str | None, arg(metavar="DIR")] = None
    """Folder or http(s) address of LPIPS weights; MOBILEGS_LPIPS says the same."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Where to compute; auto takes a GPU if there is one."""
    checkpoint_seconds: float = 60.0
    """Time between two checkpoints."""
    live: bool = False
    """Show the scene in the browser while it trains; prints the address."""
    live_at: Annotated[str, arg(metavar="HOST:PORT")] = ADDRESS
    """Where --live listens, or at the next port that is free. With 0.0.0.0 as the host, browsers
    on other devices can watch, and pause."""
    settings: Annotated[
        tuple[tuple[str, ...], ...], UseAppendAction, arg(name="set", metavar="PATH=VALUE ...")
    ] = ()
    """Any field of the recipe in config.json, like student.opacity_rate=0.02."""


def train_run(run: TrainRun, *, recipe: Recipe | None = None) -> dict[str, Any]:
    """Go the whole way, or what is left of it, and return the contents of `metrics.json`.

    `recipe` takes the place of the preset's. Raises InputError before anything is written if
    an input cannot be used, and KeyboardInterrupt, after a checkpoint, if told to stop.
    """
    with joined(run.device) as team:
        return train_together(run, recipe, team)


def train_together(run: TrainRun, recipe: Recipe | None, team: Team) -> dict[str, Any]:
    """What `train_run` does, in one process of a team. They all read; only the first one writes."""
    folder = RunFolder(run.output)
    resuming = run.resume and folder.config.exists()
    photos = None
    if resuming:
        options, recipe, photos = folder.continued()
        run = with_saved(run, options)
    else:
        recipe = resolved(run, recipe)
    refuse_uneven(run, recipe, team.world)
    lpips = lpips_from(run.lpips_weights)
    dataset = load_capture(run.capture, downscale=run.downscale, background=run.background)
    if photos is not None and not same_photos(photos, photos_of(dataset)):
        raise InputError(f"{run.capture} is not the capture that the run in {run.output} is of")
    if resuming and folder.metrics.exists():
        return folder.results()
    if not dataset.test:
        raise InputError(f"{run.capture} holds no photo back for the test: it needs more photos")
    given = None
    if run.teacher is not None and not folder.teacher.exists():
        given = read_gaussians(run.teacher)
    team.wait()  # until all have looked at the folder
    if team.first and not resuming:
        folder.begin(options=as_options(run), recipe=recipe, photos=photos_of(dataset))
    if team.first and given is not None:
        write_ply(folder.teacher, given)
    team.wait()
    saved = folder.saved() or {"stage": None, "seconds": {}, "journal": []}
    written = (folder.journal, saved["journal"], saved["seconds"])
    with (
        ViewLoader(dataset.train) as loader,
        Monitor(*written, sizes=recipe.student.bytes_expected, silent=not team.first) as monitor,
        watched(run.live, run.live_at, dataset, monitor) as live,
    ):
        camera = dataset.train[0].camera
        first = "" if run.teacher else f"{recipe.teacher.steps:,} steps for the teacher and "
        monitor.say(
            f"{len(dataset.train) + len(dataset.test)} photos of {camera.width}x{camera.height}, "
            f"{first}{recipe.student.steps:,} steps for the student"
        )
        session = Session(run, folder, dataset, loader, monitor, live, team, saved)
        if not folder.teacher.exists():
            train_teacher(session, recipe)
        scene = Scene(
            read_ply(folder.teacher).to(team.device),
            background=dataset.background.to(team.device),
            near=dataset.near,
        )
        if not folder.scene.exists():
            train_student(session, recipe, scene)
    if team.first:
        measure(session, scene, lpips)
    team.wait()
    return folder.results()


@dataclass(frozen=True)
class Session:
    """What both stages need of the process that trains them."""

    run: TrainRun
    folder: RunFolder
    dataset: Dataset
    loader: ViewLoader
    monitor: Monitor
    live: Watch | None
    team: Team
    saved: dict[str, Any]
    """The checkpoint that this session continues; its stage is None if there was none."""


def train_teacher(session: Session, recipe: Recipe) -> None:
    """Leave `teacher.ply`."""
    dataset, seed, team = session.dataset, session.run.seed, session.team
    stage = Teacher(recipe.teacher, dataset, seed=seed, device=team.device, team=team)
    run_stage(stage, session, order_seed=2 * seed)
    if team.first:
        write_ply(session.folder.teacher, stage.gaussians())
    team.wait()


def train_student(session: Session, recipe: Recipe, teacher: Scene) -> None:
    """Leave `scene.mgs`."""
    dataset, seed, team = session.dataset, session.run.seed, session.team
    stage = Student(
        recipe.student,
        teacher,
        [frame.camera for frame in dataset.train],
        extent=dataset.extent,
        seed=seed,
        team=team,
    )
    run_stage(stage, session, order_seed=2 * seed + 1)
    if not team.first:
        return
    frames = dataset.train[:: max(1, len(dataset.train) // FIRST_LOOKS)]
    camera = dataset.train[0].camera
    meta: dict[str, MetaValue] = {
        "generator": f"mobilegs {__version__}",
        "capture": dataset.name,
        "photos": f"{len(dataset.train)} of {camera.width}x{camera.height}",
        "student_steps": recipe.student.steps,
    }
    views: list[Camera] = [frame.camera for frame in frames[:FIRST_LOOKS]]
    coded = stage.coded(views=views, meta=meta)
    layers = recipe.student.layers or min(layers_for(len(coded)), recipe.student.layers_max)
    write_mgs(session.folder.scene, layered(coded, layers, stage.cameras))
    target, size = recipe.student.target_mb, session.folder.scene.stat().st_size / 1e6
    if target and abs(size - target) > MISSED * target:
        session.monitor.say(
            f"the file has {size:.3f} MB, not the {target:g} asked for: steps change up to "
            "eightfold, networks and header not at all"
        )


def run_stage(stage: Stage, session: Session, *, order_seed: int) -> None:
    """Train `stage` to its end, from the session's checkpoint if that is one of this stage."""
    loader, monitor, folder, team = session.loader, session.monitor, session.folder, session.team
    if session.saved["stage"] == stage.name:
        stage.restore(session.saved["state"])
    monitor.begin(stage)
    number, preview_every = stage.views_per_step, max(1, stage.steps // PREVIEWS)
    saved_at = time.monotonic()
    with stopping_between_steps() as stop:
        while stage.done < stage.steps:
            first = stage.done * number
            order = view_order(len(loader), first, number + PREFETCH * team.world, order_seed)
            mine = order[team.rank :: team.world]
            here = number // team.world
            loader.prefetch(mine[here:])
            views = [(index, loader.get(index, team.device)) for index in mine[:here]]
            monitor.after_step(stage, stage.advance(views))
            if stage.done % preview_every == 0:
                step = f"after step {stage.done} of the {stage.name}"
                team.refuse_difference(step, digest(stage.state()) if team.world > 1 else 0)
                if team.first:
                    preview(stage, session)
            if session.live is not None:
                session.live.between_steps(stage, stop)
            stopping = any(asked for [asked] in team.numbers(stop.asked))
            late = time.monotonic() - saved_at > session.run.checkpoint_seconds
            if team.first and (late or stopping or stage.done == stage.steps):
                folder.save(stage.name, stage.state(), seconds=monitor.seconds, rows=monitor.rows)
                saved_at = time.monotonic()
            if stopping:
                team.wait()  # for the checkpoint
                raise KeyboardInterrupt


@torch.no_grad()
def preview(stage: Stage, session: Session) -> None:
    """Draw the first held-back view as it looks now, and note its PSNR."""
    view = load_view(session.dataset.test[0]).to(session.team.device)
    image = as_displayed(stage.scene().render(view.camera).image)
    with atomic_path(session.folder.previews / f"{stage.name}_{stage.done:06}.png") as path:
        Image.fromarray(to_bytes(image).cpu().numpy()).save(path, format="PNG")
    mask = None if view.mask is None else view.mask > 0.5
    session.monitor.note(
        stage=stage.name, step=stage.done, preview_psnr=psnr(image, view.image, mask)
    )


def measure(session: Session, teacher: Scene, lpips: LpipsSuite | None) -> None:
    """Leave `contact_sheet.png` and `metrics.json`, from the files alone."""
    folder, dataset, run = session.folder, session.dataset, session.run
    started = time.monotonic()
    student = read_mgs(folder.scene).decode(session.team.device)
    figures = evaluate_side_by_side({"teacher": teacher, "student": student}, dataset, lpips=lpips)
    contact_sheet(folder.contact_sheet, dataset, teacher, student)
    camera = dataset.test[0].camera
    seconds = {**session.monitor.seconds, "evaluation": time.monotonic() - started}
    write_metrics(
        folder.metrics,
        teacher={
            "file_bytes": folder.teacher.stat().st_size,
            "gaussians": len(teacher.gaussians),
            **figures["teacher"],
        },
        student=figures["student"],
        file_bytes=folder.scene.stat().st_size,
        gaussians=len(student.gaussians),
        seconds=seconds,
        more={
            "capture": dataset.name,
            "image_size": [camera.width, camera.height],
            "views": {"train": len(dataset.train), "test": len(dataset.test)},
            "seed": run.seed,
            "device": str(session.team.device),
        },
    )
    folder.finish()


def refuse_uneven(run: TrainRun, recipe: Recipe, world: int) -> None:
    """Raise InputError if `world` processes cannot have equal shares of a step's views."""
    for name, stage in (("teacher", recipe.teacher), ("student", recipe.student)):
        given = name == "teacher" and run.teacher is not None
        if stage.views_per_step % world and not given:
            raise InputError(
                f"{world} processes cannot share the {stage.views_per_step} views of a step of the "
                f"{name} evenly: give --views-per-step a multiple of {world}, or start another "
                "number of processes"
            )


def resolved(run: TrainRun, recipe: Recipe | None) -> Recipe:
    """The recipe that the options of a new run ask for."""
    if not 0 <= run.seed < 1 << 32:
        raise InputError(f"a seed lies between 0 and {(1 << 32) - 1}, not at {run.seed}")
    refuse(run.live, run.live_at)
    if recipe is None:
        recipe = RECIPES[run.preset or ("gpu" if torch.cuda.is_available() else "cpu")]()
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


def as_options(run: TrainRun) -> dict[str, Any]:
    """The options as JSON holds them."""
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


def with_saved(run: TrainRun, saved: dict[str, Any]) -> TrainRun:
    """The options of a session that continues a run: those of the run.

    Raises InputError if an option is given that contradicts the run's.
    """
    given = as_options(run)
    for field in fields(run):
        name = field.name
        if name in BETWEEN_SESSIONS or given[name] == saved.get(name):
            continue
        if getattr(run, name) != field.default:
            raise InputError(
                f"the run in {run.output} was begun with {name} {saved.get(name)}, not "
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
