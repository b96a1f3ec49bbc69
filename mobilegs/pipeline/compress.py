"""Compress a scene of another tool into a measured `scene.mgs`, with its photos or without."""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any

import torch
from tyro.conf import Positional, arg

from mobilegs.device import choose_device
from mobilegs.errors import InputError
from mobilegs.evaluate.report import RunMetrics
from mobilegs.pipeline.options import RunOptions, TrainRun
from mobilegs.pipeline.preflight import validate_run
from mobilegs.pipeline.train import train_capture
from mobilegs.progress_display import Progress, no_progress
from mobilegs.scene_file import plain_scene_at, read_plain_with_cameras
from mobilegs.synthetic_capture.render import (
    DEFAULT_BACKGROUND,
    CaptureOptions,
    render_synthetic_capture,
)
from mobilegs.train.recipes import PresetName
from mobilegs.up import Axis
from mobilegs.viewpoints.cameras_json import read_cameras_json

# For a trained scene and renders of it: means move little, colours need more latents for their view
# dependence, and coarse, early quantisation costs no quality (docs/explanation/compression.md,
# playbot). No virtual views, because all images are renders of the teacher already.
FINISHED_SCENE = (
    "student.lr.means_max=0.01",
    "student.least_variance=0",  # the scene may be trained on larger images than the renders
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
    "short": (400, 640),
    "long": (400, 1280),
    "paper": (400, 1280),
    "release": (400, 1280),
}


@dataclass(frozen=True)
class CompressRun(RunOptions):
    """Compress a trained 3DGS scene into a phone-sized scene.mgs.

    The scene becomes the teacher of a student, as in `mobilegs train --teacher`, and RUN receives
    the same files. Without --capture, the program places cameras around the scene's centre, renders
    the scene from them into RUN/capture, and trains the student on these renders. Every eighth
    image is held back for the metrics.
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
    scene that was photographed from one side only needs them. Default: the cameras in a .ply of
    one photo, or of a cameras.json beside it; otherwise cameras around the scene's centre."""
    views: Annotated[int | None, arg(metavar="N")] = None
    """Number of views to render. Default: 48 with the preset demo, otherwise 400."""
    size: Annotated[int | None, arg(metavar="PIXELS")] = None
    """Longer side of rendered views. Default: 240 with the preset demo, 640 with short and 1280
    with the others; without --preset 1280 if there is an NVIDIA GPU, otherwise 640."""
    up: Annotated[Axis | None, arg(metavar="{x,-x,y,-y,z,-z}")] = None
    """Axis of the scene that points up, for cameras that the program places. Default: as the file
    tells, otherwise the direction across which the scene's middle is flattest."""


def compress_scene(run: CompressRun, *, progress: Progress = no_progress) -> RunMetrics:
    """Compress a scene into `scene.mgs`, as `mobilegs compress`, and return `metrics.json`.

    With photos this is `train_capture` with the scene as the teacher. With `run.resume`, what is
    left of the run is done.

    Example:

        run = CompressRun(Path("scene.ply"), Path("runs/small"), target_mb=3)
        print(compress_scene(run)["student"]["file_bytes"])

    Args:
        run: the options, those of `mobilegs compress`.
        progress: opens the rendering of views and the measuring, by their titles.

    Raises:
        InputError: an input or an option cannot be used; before anything is written.
        KeyboardInterrupt: a signal asked to stop; after a checkpoint.
    """
    run = replace(run, scene=plain_scene_at(run.scene))
    training = training_of(run)
    if run.capture is None:
        validate_run(training)
        render_views(run, training.capture, progress)
    return train_capture(training, progress=progress)


def render_views(run: CompressRun, folder: Path, progress: Progress) -> None:
    """Write the capture of renders from which a student learns that has no photos."""
    if run.cameras is not None:  # validates the small file before reading the large scene
        read_cameras_json(run.cameras)
    views, size = VIEWS[run.preset or ("long" if torch.cuda.is_available() else "short")]
    options = CaptureOptions(
        views if run.views is None else run.views,
        size if run.size is None else run.size,
        run.cameras,
        run.seed,
        run.background or DEFAULT_BACKGROUND,
        run.up,
    )
    scene, own = read_plain_with_cameras(run.scene, choose_device(run.device))
    render_synthetic_capture(scene, run.scene, folder, options, own=own, progress=progress)


def training_of(run: CompressRun) -> TrainRun:
    """Return the training of the student; raises InputError for options that exclude each other."""
    of_views = {"cameras": run.cameras, "views": run.views, "size": run.size, "up": run.up}
    settings, capture = run.settings, run.capture
    if capture is not None:
        given = [name for name, value in of_views.items() if value is not None]
        if given:
            raise InputError(f"with --capture no views are rendered: leave out --{given[0]}")
    elif run.up is not None and run.cameras is not None:
        raise InputError("the cameras of --cameras tell which way is up: leave out --up")
    elif run.downscale is not None:
        raise InputError("--downscale is for the photos of --capture: use --size")
    else:
        settings, capture = (FINISHED_SCENE, *settings), run.output / "capture"
    shared: dict[str, Any] = {field.name: getattr(run, field.name) for field in fields(RunOptions)}
    shared["settings"] = settings
    return TrainRun(capture, run.output, teacher=run.scene, **shared)
