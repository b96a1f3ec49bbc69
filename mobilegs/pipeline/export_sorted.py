"""A scene as a file for tools that sort: converted, or its teacher instead, or refitted first."""

import json
from dataclasses import dataclass
from pathlib import Path

from mobilegs.atomic import atomic_path
from mobilegs.data import load_capture
from mobilegs.errors import InputError
from mobilegs.mgs.codec import read_mgs
from mobilegs.pipeline.refit import Views, fit_of, refit, views_around, views_from
from mobilegs.render.scene import Scene
from mobilegs.scene_file import (
    PLAIN,
    Device,
    Kind,
    choose_device,
    open_scene,
    teacher_of,
    write_gaussians,
)
from mobilegs.synthetic_capture.render import Progress, silent


@dataclass(frozen=True)
class SortedExport:
    """What is to be written, as a file of which kind, and how a student gets there."""

    scene: Path
    """The scene: a .mgs, or a plain 3DGS scene of any kind."""
    output: Path
    """The file to write."""
    kind: Kind
    """What it is to be."""
    refit: bool = False
    """Refit a student even where its teacher is at hand."""
    capture: Path | None = None
    """Photos with poses: a student is refitted by pictures of it from there."""
    seed: int = 0
    """Start of all random choices of a refit."""
    device: Device = "auto"
    """Where a refit draws; auto takes an NVIDIA GPU if there is one."""


def export_sorted(run: SortedExport, *, progress: Progress = silent) -> tuple[int, str]:
    """Write the file, and return its bytes and what is to be said of it, which may be nothing.

    A scene that is blended sorted is converted. A student is no sorted splat: where it lies in its
    run, the run's teacher goes in its place, and else the student is refitted. The file appears
    whole or not at all. Raises InputError if the scene cannot be read, has no place in such a
    file, or would be lost, or if an option has nothing to act on.
    """
    scene, output, kind = run.scene, run.output, run.kind
    if output.suffix.lower() != f".{kind}":
        raise InputError(f"{output} would be a .{kind} file: give it a name that ends so")
    if not 0 <= run.seed < 1 << 32:
        raise InputError(f"a seed lies between 0 and {(1 << 32) - 1}, not at {run.seed}")
    opened = open_scene(scene, choose_device(run.device))
    teacher = teacher_of(scene) if opened.blend != "sorted" else None
    for source, what in ((scene, "the scene itself"), (teacher, "what the scene learned from")):
        if source is not None and output.exists() and output.samefile(source):
            raise InputError(f"{output} is {what}, and would be lost: give another name")
    if opened.blend == "sorted":
        _refuse_refit(run, f"{scene} is a sorted splat already")
        return write_gaussians(output, opened.gaussians, kind), ""
    if teacher is not None and not run.refit:
        _refuse_refit(run, f"{teacher} goes in the place of {scene}, or add --refit")
        plain = open_scene(teacher, choose_device("cpu"))
        said = f"{scene} is no sorted splat: {teacher} goes in its place (or it is refitted, with "
        return write_gaussians(output, plain.gaussians, kind), f"{said}--refit)"
    with atomic_path(output) as path:  # which refuses a bad place at once, not after minutes
        views = _views(run, opened, progress)
        found = refit(opened, views, seed=run.seed, progress=progress)
        write_gaussians(path, found, kind)  # what is measured is what a tool will read
        fit = fit_of(opened, PLAIN[f".{kind}"](path), views, progress=progress)
        size = write_gaussians(path, found, kind, note=str(fit))
    return size, f"{scene} is {fit}"


def _refuse_refit(run: SortedExport, why: str) -> None:
    """Raise InputError if an option is given that only a refit makes use of."""
    given = {
        "refit": run.refit,
        "capture": run.capture is not None,
        "seed": run.seed != 0,
        "device": run.device != "auto",
    }
    for name, is_given in given.items():
        if is_given:
            raise InputError(f"{why}: leave out --{name}")


def _views(run: SortedExport, scene: Scene, progress: Progress) -> Views:
    """What the refit looks at: from the capture that is given, the run's, or places it finds."""
    background = tuple(scene.background.tolist())
    if run.capture is not None:
        return views_from(
            scene, load_capture(run.capture, background=background), progress=progress
        )
    capture, downscale = _capture_of_run(run.scene)
    if capture is None:
        return views_around(scene, read_mgs(run.scene).views, seed=run.seed, progress=progress)
    dataset = load_capture(capture, downscale=downscale, background=background)
    return views_from(scene, dataset, progress=progress)


def _capture_of_run(scene: Path) -> tuple[Path | None, int | None]:
    """The capture of the run whose scene this is, if it is still there, and its downscale."""
    try:
        options = json.loads(scene.with_name("config.json").read_bytes())["options"]
        capture, downscale = Path(options["capture"]), options["downscale"]
    except (OSError, ValueError, KeyError, TypeError):
        return None, None
    if not capture.is_dir() or not (downscale is None or type(downscale) is int):
        return None, None
    return capture, downscale
