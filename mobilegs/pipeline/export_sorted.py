"""Export a scene to a file for tools that sort: converted, its teacher instead, or refitted."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

from mobilegs.atomic import atomic_path
from mobilegs.data import load_capture
from mobilegs.device import Device, choose_device
from mobilegs.errors import InputError
from mobilegs.mgs.codec import inspect_mgs, read_mgs
from mobilegs.pipeline.refit import Views, measure_fit, refit, views_around, views_from
from mobilegs.progress_display import Progress, no_progress
from mobilegs.render.scene import Scene
from mobilegs.scene_file import (
    PLAIN,
    WRITERS,
    Kind,
    capture_of_run,
    open_scene,
    scene_at,
    teacher_of,
    turn_needed,
    write_gaussians,
)
from mobilegs.up import AXES, Axis, Vector


@dataclass(frozen=True)
class SortedExport:
    """Options of an export to a file for tools that sort."""

    scene: Path
    """A .mgs file, or a plain 3DGS scene in any format."""
    output: Path
    """The file to write."""
    kind: Kind
    """Format of the file."""
    up: Axis | None = None
    """Axis that points up; None is the scene's own direction."""
    refit: bool = False
    """Refit a student even if its teacher is there."""
    capture: Path | None = None
    """Photos with poses, whose cameras a refit renders from."""
    seed: int = 0
    """Seed of all random choices of a refit."""
    device: Device = "auto"
    """Device of a refit; auto takes an NVIDIA GPU if there is one."""


def export_sorted(run: SortedExport, *, progress: Progress = no_progress) -> tuple[int, str]:
    """Write the file; return its size in bytes and a message, which may be empty.

    A scene for sorted blending is converted. For a student in its run's folder, the run's teacher
    is written; any other student is refitted. A file that cannot name the upward direction gets
    the scene turned. The file appears complete or not at all.

    Raises InputError if the scene cannot be read, does not fit the format or would be overwritten,
    and for options that have no effect.
    """
    run = replace(run, scene=scene_at(run.scene))
    scene, output, kind = run.scene, run.output, run.kind
    if output.suffix.lower() != f".{kind}":
        raise InputError(f"{output} does not end in .{kind}: give the file such a name")
    if not 0 <= run.seed < 1 << 32:
        raise InputError(f"the seed must be between 0 and {(1 << 32) - 1}, not {run.seed}")
    opened = open_scene(scene, choose_device(run.device))
    up = opened.up if run.up is None else AXES[run.up]
    teacher = teacher_of(scene) if opened.blend != "sorted" else None
    for source, what in ((scene, "the scene itself"), (teacher, "the scene's teacher")):
        if source is not None and output.exists() and output.samefile(source):
            raise InputError(f"{output} is {what} and would be overwritten: give another name")
    if opened.blend == "sorted":
        if not opened.is_plain:
            raise InputError(
                f"{scene} has opacities that depend on the view, which a .{kind} cannot hold: "
                "export another scene, such as the teacher.ply of its run"
            )
        _validate_no_refit(run, f"{scene} is already made for sorted blending")
        options = {"footprint": opened.footprint, "up": up, "note": turn_note(up, kind)}
        with progress(f"writing a .{kind}"):
            size = write_gaussians(output, opened.gaussians, kind, **options)
        return size, _joined(turn_note(up, kind), antialiased_note(opened, kind))
    if teacher is not None and not run.refit:
        _validate_no_refit(run, f"{teacher} is written instead of {scene}, unless you add --refit")
        plain = open_scene(teacher, choose_device("cpu"))
        moved, turned = offset_of(scene), turn_note(up, kind)
        message = _joined(
            f"{scene} is sort-free: wrote {teacher} instead (--refit refits the scene)",
            turned,
            antialiased_note(plain, kind),
            moved and f"the capture's origin is moved by {moved}",
        )
        note = _joined(turned, moved and f"offset {moved}")
        options = {"footprint": plain.footprint, "up": up, "note": note}
        with progress(f"writing a .{kind}"):
            return write_gaussians(output, plain.gaussians, kind, **options), message
    with atomic_path(output) as path:  # raises for an unusable folder before the minutes of work
        views = _views(run, opened, progress)
        refitted = refit(opened, views, seed=run.seed, progress=progress)
        with progress(f"writing a .{kind}"):
            WRITERS[kind](path, refitted)  # measured as other tools will read it
        fit = measure_fit(opened, PLAIN[f".{kind}"](path), views, progress=progress)
        moved = offset_of(scene)
        note = _joined(str(fit), turn_note(up, kind), moved and f"offset {moved}")
        size = write_gaussians(path, refitted, kind, up=up, note=note)
    return size, f"{scene}: {note}"


def offset_of(scene: Path) -> str:
    """Return the offset that a .mgs notes, `X Y Z`: with it, positions are those of its capture.

    Empty for a scene without one.
    """
    if scene.suffix.lower() != ".mgs":
        return ""
    note = inspect_mgs(scene)["meta"].get("offset")
    return note if isinstance(note, str) and re.fullmatch(r"(-?\d{1,20} ?){3}", note) else ""


def turn_note(up: Vector | None, kind: Kind) -> str:
    """Return how a scene is turned for a file of this kind; empty if it is not."""
    if up is None or not turn_needed(up, kind):
        return ""
    return f"turned to be upright: up was {' '.join(f'{number:.6g}' for number in up + 0.0)}"


def _joined(*notes: str) -> str:
    return "; ".join(note for note in notes if note)


def antialiased_note(scene: Scene, kind: Kind) -> str:
    """Return what to know about an antialiased scene in a file; empty for others."""
    if kind == "glb" or not scene.footprint.antialiased:  # write_gaussians warns of a .glb
        return ""
    return (
        f"the scene is antialiased, and the .{kind} says so: tools that ignore it draw thin "
        "Gaussians too thick (--refit of a .mgs makes a scene for them)"
    )


def _validate_no_refit(run: SortedExport, why: str) -> None:
    """Raise InputError if an option is given that only a refit uses."""
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
    """Return views of the given capture, of the run's capture, or of placed cameras."""
    background = tuple(scene.background.tolist())
    if run.capture is not None:
        return views_from(
            scene, load_capture(run.capture, background=background), progress=progress
        )
    capture, downscale = capture_of_run(run.scene)
    if capture is None:
        return views_around(scene, read_mgs(run.scene).views, seed=run.seed, progress=progress)
    dataset = load_capture(capture, downscale=downscale, background=background)
    return views_from(scene, dataset, progress=progress)
