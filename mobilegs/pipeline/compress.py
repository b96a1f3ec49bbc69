"""From a scene of another tool to a measured `scene.mgs`, with its photos or without."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import torch
from tyro.conf import Positional, UseAppendAction, arg

from mobilegs.data import load_capture
from mobilegs.errors import InputError
from mobilegs.live import ADDRESS
from mobilegs.pipeline.preflight import refuse_beforehand
from mobilegs.pipeline.train import TrainRun, train_run
from mobilegs.render.scene import Scene
from mobilegs.scene_file import choose_device, read_gaussians
from mobilegs.synthetic_capture.cameras_json import read_cameras_json
from mobilegs.synthetic_capture.render import BLACK, Progress, Shoot, photograph, silent
from mobilegs.synthetic_capture.visibility import refuse_blind
from mobilegs.train.recipes import PresetName

# Of a scene that is finished, and seen from places that say little about its detail: it moves
# little, colours tell of more directions than six latents can, and codes are as coarse as was found
# to be good enough (docs/compression.md, playbot), and gain nothing by coming late. All pictures
# are the teacher's already.
FINISHED = (
    "student.position_share=0.01",
    "student.color_latents=9",
    "student.fineness=1",
    "student.codes_fraction=0.7",
    "student.price_fraction=1",
    "student.fill_price=0",
    "student.distill_between=0",
)
# of a preset: pictures, and their longer side in pixels
SHOTS: dict[PresetName, tuple[int, int]] = {
    "demo": (48, 240),
    "cpu": (400, 640),
    "gpu": (400, 1280),
}


@dataclass(frozen=True)
class CompressRun:
    """Make a phone-sized scene.mgs of a trained 3DGS scene, with its photos or without.

    Without photos, pictures are taken of the scene itself, from places around its middle, and kept
    in RUN/capture. What is measured at the end are pictures that were not learned from.
    """

    scene: Annotated[Positional[Path], arg(metavar="SCENE")]
    """A plain 3DGS scene: .ply, .spz, and what else `mobilegs info` opens."""
    output: Annotated[Path, arg(aliases=["-o"], metavar="RUN")]
    """Folder for scene.mgs and everything else; it is made if it is missing."""
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None
    """The photos that the scene was trained on, with their poses: the student then learns from
    both."""
    cameras: Annotated[Path | None, arg(metavar="JSON")] = None
    """The cameras.json that 3DGS leaves beside a scene: pictures are taken from there and from in
    between. A scene that was seen from one side alone needs it."""
    views: Annotated[int | None, arg(metavar="N")] = None
    """Pictures to take; every eighth is held back. Without it 400, with the preset demo 48."""
    size: Annotated[int | None, arg(metavar="PIXELS")] = None
    """Their longer side. Without it 640 with the preset cpu, 1280 with gpu, 240 with demo."""
    downscale: Annotated[int | None, arg(metavar="N")] = None
    """Divide the size of CAPTURE's photos by this."""
    background: tuple[float, float, float] | None = None
    """Colour behind everything that the scene was trained with, RGB in 0..1: a file does not say.
    Without it black; with CAPTURE, white for renders with transparency, too."""
    preset: PresetName | None = None
    """How long: cpu is meant for two cores, gpu has 30,000 steps, demo is quick. Without it, gpu
    where there is one."""
    steps: Annotated[int | None, arg(metavar="N")] = None
    """Steps of the student; all schedules scale with it."""
    target_mb: Annotated[float | None, arg(metavar="MB")] = None
    """Megabytes (10^6) that the file shall have. Without it, what the quality needs."""
    seed: int = 0
    """Start of all random choices."""
    resume: bool = False
    """Continue the run that RUN holds; begin one if there is none."""
    lpips_weights: Annotated[str | None, arg(metavar="DIR")] = None
    """Folder or http(s) address of LPIPS weights; MOBILEGS_LPIPS says the same."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Where to compute; auto takes a GPU if there is one."""
    live: bool = False
    """Show the scene in the browser while it trains; prints the address."""
    live_at: Annotated[str, arg(metavar="HOST:PORT")] = ADDRESS
    """Where --live listens, or at the next port that is free. With 0.0.0.0 as the host, browsers
    on other devices can watch, and pause."""
    settings: Annotated[
        tuple[tuple[str, ...], ...], UseAppendAction, arg(name="set", metavar="PATH=VALUE ...")
    ] = ()
    """Any field of the recipe in config.json, like student.opacity_rate=0.02."""


def compress_run(
    run: CompressRun,
    *,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Go the whole way, or what is left of it, and return the contents of `metrics.json`.

    Raises InputError before anything is written if an input cannot be used.
    """
    preset: PresetName = run.preset or ("gpu" if torch.cuda.is_available() else "cpu")
    capture = run.capture
    of_pictures = {"cameras": run.cameras, "views": run.views, "size": run.size}
    if capture is not None:
        given = [name for name, value in of_pictures.items() if value is not None]
        if given:
            raise InputError(f"with --capture no pictures are taken: leave out --{given[0]}")
    elif run.downscale is not None:
        raise InputError("--downscale is for the photos of --capture: use --size")
    settings: list[str] = [*FINISHED] if capture is None else []
    if run.steps is not None:
        settings.append(f"student.steps={run.steps}")
    if run.target_mb is not None:
        settings.append(f"student.target_mb={run.target_mb}")
    training = TrainRun(
        run.output / "capture" if capture is None else capture,
        run.output,
        preset=preset,
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
    refuse_beforehand(training)

    def opened() -> Scene:  # not kept: the training reads it again
        return Scene(read_gaussians(run.scene).to(choose_device(run.device)))

    if capture is None:
        views, size = SHOTS[preset]
        if run.views is not None:
            views = run.views
        if run.size is not None:
            size = run.size
        shoot = Shoot(views, size, run.cameras, run.seed, run.background or BLACK)
        if run.cameras is not None:
            read_cameras_json(run.cameras)  # refused before the scene is read, which is large
        photograph(opened(), run.scene, training.capture, shoot, progress=progress)
    elif not (run.output / "config.json").exists():
        cameras = [view.camera for view in load_capture(capture, downscale=run.downscale).train]
        instead = "give the capture that it was made of"
        refuse_blind(opened(), cameras, f"photos of {capture}", instead)
    return train_run(training)
