"""The verb `edit`: a scene without its floaters, cropped and with notes, as a new file.

`EditOptions` are also options of `export`.
"""

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from mobilegs.atomic import read_json
from mobilegs.errors import InputError, printable

if TYPE_CHECKING:
    from mobilegs.camera import Camera
    from mobilegs.edit.scene_edit import EditReport, SceneEdit
    from mobilegs.scene_file import Kind

FIELD = 0.42  # tangent of half the field of view of a start view, without a training camera
BoxText = Annotated[str, arg(metavar="BOX")]
View = Annotated[str, arg(metavar="VIEW")]
JsonFile = Annotated[Path | None, arg(metavar="JSON")]


@dataclass(frozen=True)
class EditOptions:
    """Options of an edit: the Gaussians that it removes, and the notes that it sets.

    Args:
        crop: Keep only Gaussians in this box: two opposite corners "X0 Y0 Z0 X1 Y1 Z1" in world
            units, and for a box that is turned around its centre also a quaternion "QW QX QY QZ".
        keep_sphere: Keep only Gaussians in this sphere: "X Y Z RADIUS".
        remove_box: Remove Gaussians in this box, written as for --crop; several separated by ";".
        remove_sphere: Remove Gaussians in this sphere: "X Y Z RADIUS"; several separated by ";".
        remove_below: Remove Gaussians below this plane: "NX NY NZ D" is the plane
            NX x + NY y + NZ z = D, whose normal points up.
        remove_rows: Remove these Gaussians: a text of row numbers in the order of the file, from
            0, or a .npy of row numbers or of a mask.
        min_cameras: Remove Gaussians that fewer than N cameras saw: the training cameras of
            --capture or of the scene's run, or else those that the file stores (at most 64).
        remove_floaters: Remove Gaussians that float: isolated ones that few cameras saw, or that
            are before what most of them see. Counts the same cameras.
        start_view: First view: eye, target "EX EY EZ TX TY TZ" in world units, and then, if given,
            the tangents of half the width and half the height that must be in the picture; or the
            address of the view in the viewer, with eye= and at=.
        start_portrait: The same for screens that are higher than wide. Default: as the other.
        floor: Plane of the floor, for walking, written as for --remove-below.
        credit: Name of the author, which viewers show.
        annotations: Numbered dots with texts: a JSON list of {"at": [X, Y, Z], "text": "...",
            "eye": [X, Y, Z]}; eye may be missing.
        camera_path: Path of the camera for autoplay: a JSON list of [EX, EY, EZ, TX, TY, TZ].
        no_limits: Let visitors move where no photo was taken.
    """

    crop: BoxText = ""
    keep_sphere: Annotated[str, arg(metavar="SPHERE")] = ""
    remove_box: BoxText = ""
    remove_sphere: Annotated[str, arg(metavar="SPHERE")] = ""
    remove_below: Annotated[str, arg(metavar="PLANE")] = ""
    remove_rows: Annotated[Path | None, arg(metavar="FILE")] = None
    min_cameras: Annotated[int, arg(metavar="N")] = 0
    remove_floaters: bool = False
    start_view: View = ""
    start_portrait: View = ""
    floor: Annotated[str, arg(metavar="PLANE")] = ""
    credit: Annotated[str, arg(metavar="TEXT")] = ""
    annotations: JsonFile = None
    camera_path: JsonFile = None
    no_limits: bool = False


NO_EDITS = EditOptions()


def edit(
    scene: Annotated[Positional[Path], arg(metavar="SCENE")],
    *,
    output: Annotated[Path | None, arg(aliases=["-o"], metavar="NEW")] = None,
    title: Annotated[str, arg(metavar="TEXT")] = "",
    up: Annotated[str, arg(metavar="AXIS")] = "",
    edits: EditOptions = NO_EDITS,
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None,
    port: Annotated[int, arg(metavar="PORT")] = 0,
    no_browser: bool = False,
) -> None:
    """Write an edited copy of a scene: cropped, without floaters, with a start view and texts.

    With editing options, writes the copy. Without, opens the scene in the browser with tools for
    the same edits; its button Save writes a copy next to the scene. The page and its server are
    for this machine only. Nothing is ever overwritten, and what stays of a .mgs decodes to the
    same bits. Other formats keep their numbers, too, but have no notes, only fewer Gaussians.

    Args:
        scene: A .mgs file, a run's folder, or a plain 3DGS scene: .ply, .spz, .sog, .splat or .glb.
            The browser opens a .mgs.
        output: The file to write, which must not exist. Default: SCENE-edited, next to the scene.
        title: Title, which viewers show.
        up: Direction that points up: x, -x, y, -y, z, -z, or three numbers "X Y Z".
        capture: Photos with poses, whose training cameras are counted. Default: the capture of the
            scene's run.
        port: Port of the tools' server. Default: a free port.
        no_browser: Print the address of the tools, and do not open the browser.
    """
    from mobilegs.edit.scene_edit import free_name, validate_output
    from mobilegs.scene_file import scene_at

    scene = scene_at(scene)
    if edits == NO_EDITS and not title and not up:
        return _edit_in_browser(scene, output, capture, port, browser=not no_browser)
    if port or no_browser:
        raise InputError("with editing options no browser opens: leave out --port and --no-browser")
    output = output or free_name(scene)
    validate_output(scene, output)
    scene_edit = edit_of(edits, scene, title=title, up=up)
    report = _written(scene, output, scene_edit, capture)
    for line in (*report.lines, f"{output} is written, {scene} is as it was"):
        print(printable(line))


def edit_of(options: EditOptions, scene: Path, *, title: str = "", up: str = "") -> "SceneEdit":
    """Return the edit that options describe. Raises InputError for an option without sense."""
    from mobilegs.edit import notes as n
    from mobilegs.edit import regions as r
    from mobilegs.edit.scene_edit import SceneEdit, read_rows

    if options.min_cameras < 0:
        raise InputError(f"--min-cameras must be at least 0, not {options.min_cameras}")
    keep: list[r.Region] = [*_regions(r.parsed_boxes, options.crop, "--crop")]
    keep += _regions(r.parsed_spheres, options.keep_sphere, "--keep-sphere")
    remove: list[r.Region] = [*_regions(r.parsed_boxes, options.remove_box, "--remove-box")]
    remove += _regions(r.parsed_spheres, options.remove_sphere, "--remove-sphere")
    if options.remove_below:
        remove.append(r.parsed_plane(options.remove_below, "--remove-below"))
    changes: dict[str, str] = {}
    for name, text in (("title", title), ("credit", options.credit)):
        if text:
            changes[name] = n.line_of_text(text, name)
    if up:
        changes["up"] = up_note(up)
    for name, text in (("start", options.start_view), ("start_portrait", options.start_portrait)):
        if text:
            option = "--start-view" if name == "start" else "--start-portrait"
            changes[name] = start_note(text, option, scene)
    if options.start_view and not options.start_portrait:
        changes["start_portrait"] = ""  # the file's own would hide the new view on phones
    if options.floor:
        plane = r.parsed_plane(options.floor, "--floor")
        changes["floor"] = n.plane_text(plane.normal, plane.offset)
    if options.annotations is not None:
        changes |= n.annotation_notes(n.parsed_annotations(read_json(options.annotations)))
    if options.camera_path is not None:
        changes |= n.path_notes(n.parsed_path(read_json(options.camera_path)))
    if options.no_limits:
        changes["limits"] = "none"
    return SceneEdit(
        keep=keep,
        remove=remove,
        rows=None if options.remove_rows is None else read_rows(options.remove_rows),
        min_cameras=options.min_cameras,
        floaters=options.remove_floaters,
        notes=changes,
    )


@contextmanager
def edited_copy(
    scene: Path, options: EditOptions, *, title: str, capture: Path | None
) -> Iterator[tuple[Path, dict[str, str]]]:
    """Give an edited copy of the scene, for an export, and the notes that it has no place for.

    The copy is removed afterwards. Without edits it is the scene itself. Raises InputError as
    `edit_of` and `edit_file`.
    """
    if options == NO_EDITS:
        yield scene, {}
        return
    from mobilegs.edit.notes import page_notes
    from mobilegs.edit.scene_edit import WRITTEN_SUFFIXES

    suffix = scene.suffix.lower()
    suffix = suffix if suffix == ".mgs" or suffix in WRITTEN_SUFFIXES else ".ply"
    scene_edit, notes = edit_of(options, scene, title=title), {}
    if suffix != ".mgs":
        scene_edit, notes = replace(scene_edit, notes={}), page_notes(scene_edit.notes)
    if not scene_edit.removes and not scene_edit.notes:
        yield scene, notes
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, f"{scene.stem}{suffix}")
        report = _written(scene, copy, scene_edit, capture)
        for line in report.lines:
            print(printable(line))
        yield copy, notes


def convert_edited(
    scene: Path,
    output: Path,
    kind: "Kind",
    edits: EditOptions,
    *,
    capture: Path | None,
    **options: Any,
) -> int:
    """Convert an edited copy of a scene, or of a run's teacher; as `cli.train.convert`."""
    from mobilegs.cli.train import convert
    from mobilegs.scene_file import teacher_of

    source = scene
    if scene.suffix.lower() == ".mgs":
        teacher = None if options["refit"] else teacher_of(scene)
        if teacher is None:
            raise InputError(
                f"{scene} would be refitted for a .{kind}: write the edited scene first "
                "(`mobilegs edit`), then export that"
            )
        source = teacher
        print(printable(f"{scene} is sort-free: {teacher} is edited and written instead"))
    with edited_copy(source, edits, title="", capture=capture) as (copy, notes):
        if notes:
            raise InputError(f"a .{kind} has no place for {', '.join(notes)}: export a page")
        return convert(copy, output, kind, **options)


def start_note(text: str, option: str, scene: Path) -> str:
    """Return the note of a start view from an option's text. Raises InputError if it is none."""
    import numpy as np

    from mobilegs.edit.notes import start_text
    from mobilegs.edit.regions import numbers_of
    from mobilegs.viewpoints.framing import Start

    shape = "six or eight numbers: eye, target and, if wanted, tangents"
    if "eye=" in text and "at=" in text:  # the address of the viewer
        parts = dict(re.findall(r"(eye|at)=([^&#]*)", text))
        text = f"{parts['eye']} {parts['at']}".replace("%2C", ",")
    numbers = numbers_of(text, (6, 8), option, shape)
    if len(numbers) == 6:
        numbers += [_field_of(scene)] * 2
    eye, target, (across, down) = np.array(numbers[:3]), np.array(numbers[3:6]), numbers[6:]
    return start_text(Start(eye, target, (across, down)))


def up_note(text: str) -> str:
    """Return the note of an upward direction, an axis or three numbers; raises InputError."""
    import numpy as np

    from mobilegs.edit.regions import numbers_of
    from mobilegs.up import AXES, unit, written_up

    if text in AXES:
        return written_up(AXES[text])
    numbers = numbers_of(text, (3,), "--up", "an axis (x, -x, y, -y, z, -z) or three numbers")
    if not any(numbers):
        raise InputError("--up cannot be 0 0 0")
    return written_up(unit(np.array(numbers)))


def cameras_for(scene: Path, capture: Path | None) -> "tuple[list[Camera], str]":
    """Return the training cameras of a capture, by default the run's, and what they are in words.

    Without a capture there are none.
    """
    from mobilegs.cli.render import open_scene_and_capture
    from mobilegs.scene_file import capture_of_run

    own, downscale = capture_of_run(scene)
    used = own if capture is None else capture
    if used is None:
        return [], ""
    _, _, dataset = open_scene_and_capture(scene, used, downscale if used == own else None, "cpu")
    return [frame.camera for frame in dataset.train], f"the training cameras of {used}"


def _written(
    scene: Path, output: Path, scene_edit: "SceneEdit", capture: Path | None
) -> "EditReport":
    from mobilegs.edit.scene_edit import edit_file
    from mobilegs.progress_display import show_progress

    if not scene_edit.counts:
        if capture is not None:
            raise InputError("no cameras are counted: leave out --capture")
        return edit_file(scene, output, scene_edit)
    cameras, source = cameras_for(scene, capture)
    with show_progress("counting cameras") as advance:
        return edit_file(
            scene,
            output,
            scene_edit,
            cameras=cameras,
            camera_source=source,
            progress=advance,
        )


def _edit_in_browser(
    scene: Path, output: Path | None, capture: Path | None, port: int, *, browser: bool
) -> None:
    from mobilegs.view.edit_server import serve_editor

    if scene.suffix.lower() != ".mgs":
        raise InputError(
            f"{scene} is not a .mgs, which the tools in the browser edit: give editing options "
            "(`mobilegs edit --help`), or make a .mgs of it (`mobilegs compress`)"
        )
    if capture is not None and not capture.exists():
        raise InputError(f"{capture} does not exist")
    serve_editor(scene, output, lambda: cameras_for(scene, capture), port=port, browser=browser)


def _regions(parse: Any, text: str, option: str) -> list[Any]:
    return parse(text, option) if text else []


def _field_of(scene: Path) -> float:
    """Return the tangent of half the smaller field of view of the scene's first camera."""
    from mobilegs.mgs.codec import inspect_mgs, read_mgs

    if scene.suffix.lower() != ".mgs" or not inspect_mgs(scene)["views"]:
        return FIELD
    view = read_mgs(scene).views[0]
    return min(view.width / float(view.K[0, 0]), view.height / float(view.K[1, 1])) / 2
