"""Compress a scene of another tool into a measured `scene.mgs`, with its photos or without."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import torch
from tyro.conf import Positional, UseAppendAction, arg

from mobilegs.data import load_capture
from mobilegs.device import Device, choose_device
from mobilegs.errors import InputError
from mobilegs.live import ADDRESS
from mobilegs.pipeline.preflight import validate_run
from mobilegs.pipeline.train import TrainRun, train_run
from mobilegs.progress_display import Progress, no_progress
from mobilegs.render.project import Footprint
from mobilegs.scene_file import plain_scene_at, read_plain_scene
from mobilegs.synthetic_capture.cameras_json import read_cameras_json
from mobilegs.synthetic_capture.render import (
    DEFAULT_BACKGROUND,
    CaptureOptions,
    render_synthetic_capture,
)
from mobilegs.train.recipes import PresetName
from mobilegs.up import Axis
from mobilegs.viewpoints.visibility import validate_visibility

# For a trained scene and renders of it: means move little, colours need more latents for their view
# dependence, and coarse, early quantisation costs no quality (docs/explanation/compression.md,
# playbot). No virtual views, because all images are renders of the teacher already.
FINISHED_SCENE = (
    "student.lr.means_max=0.01",
    "student.color.latents=9",
    "student.quantization.quality=1",
    "student.schedule.quantize_from=0.7",
    "student.schedule.rate_from=1",
    "student.loss.overdraw_weight=0",
    "student.loss.virtual_view_every=0",
    "student.exposure.learned=never",
)
# number of rendered views by preset, and pixels of their longer side
VIEWS: dict[PresetName, tuple[int, int]] = {
    "demo": (48, 240),
    "cpu": (400, 640),
    "gpu": (400, 1280),
    "paper": (400, 1280),
    "release": (400, 1280),
}


@dataclass(frozen=True)
class CompressRun:
    """Compress a trained 3DGS scene into a phone-sized scene.mgs.

    The scene becomes the teacher of a student, as in `mobilegs train`, and RUN receives the same
    files. Without --capture, the program places cameras around the scene's centre, renders the
    scene from them into RUN/capture, and trains the student on these renders. Every eighth image
    is held back for the metrics.
    """

    scene: Annotated[Positional[Path], arg(metavar="SCENE")]
    """A plain 3DGS scene: .ply, .spz, .sog, .splat or .glb."""
    output: Annotated[Path, arg(aliases=["-o"], metavar="RUN")]
    """Folder for the run; created if missing."""
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None
    """The photos that the scene was trained on, with their poses. The student then learns from
    the photos and the scene. Default: renders of the scene."""
    cameras: Annotated[Path | None, arg(metavar="JSON")] = None
    """The cameras.json that 3DGS writes. Views are rendered from these cameras and between them. A
    scene that was photographed from one side only needs them. Default: cameras around the scene's
    centre."""
    views: Annotated[int | None, arg(metavar="N")] = None
    """Number of views to render. Default: 48 with the preset demo,
    otherwise 400."""
    size: Annotated[int | None, arg(metavar="PIXELS")] = None
    """Longer side of rendered views. Default: 640 with the preset cpu, 1280 with gpu and 240 with
    demo."""
    downscale: Annotated[int | None, arg(metavar="N")] = None
    """Divide the width and height of the photos by N. Default: reduce photos to a width of at
    most 1600 pixels."""
    up: Annotated[Axis | None, arg(metavar="{x,-x,y,-y,z,-z}")] = None
    """Axis of the scene that points up, for cameras that the program places. Default: as the file
    tells, otherwise the direction across which the scene's middle is flattest."""
    background: Annotated[tuple[float, float, float] | None, arg(metavar="R G B")] = None
    """Background colour in 0..1 that the scene was trained with; scene files do not contain it.
    Default: black, or white if the photos of --capture have transparency."""
    minutes: Annotated[float | None, arg(metavar="N")] = None
    """Time of the training. The program times a few steps on this machine, chooses the number of
    steps, and keeps to the time. Rendering the views and measuring LPIPS come on top. Default: 30
    on a CPU and 10 on a GPU, unless --preset or --steps decide the length."""
    preset: PresetName | None = None
    """Length of the training, and number and size of the rendered views. cpu: 5,000 steps. gpu:
    30,000 steps. demo: 2,200 steps. Default: gpu if there is an NVIDIA GPU, otherwise cpu."""
    steps: Annotated[int | None, arg(metavar="N")] = None
    """Training steps; all schedules scale with them. Default: the steps of the preset."""
    target_mb: Annotated[float | None, arg(metavar="MB")] = None
    """Size of the file in megabytes (10^6 bytes). Default: no target; the setting
    student.quantization.quality decides."""
    seed: Annotated[int, arg(metavar="N")] = 0
    """Seed of all random choices."""
    resume: bool = False
    """Continue the run in RUN, or start it if there is none."""
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


def compress_run(
    run: CompressRun,
    *,
    progress: Progress = no_progress,
) -> dict[str, Any]:
    """Compress, or complete a run, and return the contents of `metrics.json`.

    Raises InputError before anything is written if an input cannot be used, and KeyboardInterrupt,
    after a checkpoint, if a signal asks to stop.
    """
    run = replace(run, scene=plain_scene_at(run.scene))
    preset: PresetName = run.preset or ("gpu" if torch.cuda.is_available() else "cpu")
    capture, training = run.capture, training_of(run)
    validate_run(training)
    if run.cameras is not None:  # validates the small file before reading the large scene
        read_cameras_json(run.cameras)
    scene = read_plain_scene(run.scene, choose_device(run.device))
    first, *further = training.settings
    kept = (*footprint_settings(scene.footprint), *first)
    training = replace(training, settings=(kept, *further))
    if capture is None:
        views, size = VIEWS[preset]
        if run.views is not None:
            views = run.views
        if run.size is not None:
            size = run.size
        options = CaptureOptions(
            views, size, run.cameras, run.seed, run.background or DEFAULT_BACKGROUND, run.up
        )
        render_synthetic_capture(scene, run.scene, training.capture, options, progress=progress)
    elif not (run.output / "config.json").exists():
        cameras = [view.camera for view in load_capture(capture, downscale=run.downscale).train]
        instead = "give the capture that it was made from"
        validate_visibility(scene, cameras, f"photos of {capture}", instead)
    del scene  # the training reads it again
    return train_run(training, progress=progress)


def training_of(run: CompressRun) -> TrainRun:
    """Return the training of the student, whose settings do not have the scene's footprint yet.

    Raises InputError for options that exclude each other.
    """
    capture = run.capture
    of_views = {"cameras": run.cameras, "views": run.views, "size": run.size, "up": run.up}
    if capture is not None:
        given = [name for name, value in of_views.items() if value is not None]
        if given:
            raise InputError(f"with --capture no views are rendered: leave out --{given[0]}")
    elif run.up is not None and run.cameras is not None:
        raise InputError("the cameras of --cameras tell which way is up: leave out --up")
    elif run.downscale is not None:
        raise InputError("--downscale is for the photos of --capture: use --size")
    settings: list[str] = [*FINISHED_SCENE] if capture is None else []
    if run.steps is not None:
        settings.append(f"student.steps={run.steps}")
    if run.target_mb is not None:
        settings.append(f"student.quantization.target_mb={run.target_mb}")
    return TrainRun(
        run.output / "capture" if capture is None else capture,
        run.output,
        minutes=run.minutes,
        preset=run.preset,
        downscale=run.downscale,
        background=run.background,
        seed=run.seed,
        resume=run.resume,
        teacher=run.scene,
        lpips_weights=run.lpips_weights,
        device=run.device,
        live=run.live,
        live_at=run.live_at,
        settings=(tuple(settings), *run.settings),
    )


def footprint_settings(footprint: Footprint) -> tuple[str, ...]:
    """Return the settings of a student that covers pixels as a finished scene does.

    Its Gaussians may be as small as the scene's: it may have been trained on larger images than
    those that are rendered here.
    """
    return (
        f"student.footprint.blur={footprint.blur}",
        f"student.footprint.antialiased={str(footprint.antialiased).lower()}",
        "student.least_variance=0",
    )
