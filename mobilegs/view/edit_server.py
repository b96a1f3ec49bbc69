"""The server of the editor: the viewer with tools, for this machine only.

The browser sends settings and which Gaussians to remove; the server alone decides where the new
file goes.
"""

import base64
import binascii
import html
import logging
import math
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import torch

from mobilegs.camera import Camera
from mobilegs.edit import notes as n
from mobilegs.edit.camera_counts import CameraCounts, count_cameras
from mobilegs.edit.scene_edit import EditReport, SceneEdit, edit_file, free_name, validate_output
from mobilegs.errors import InputError
from mobilegs.mgs.codec import inspect_mgs, read_mgs
from mobilegs.up import unit, written_up
from mobilegs.view.assets import SCRIPT, SCRIPTS, TITLE, editor_script, escaped, script_tags
from mobilegs.view.export import ELEMENT, page_with
from mobilegs.view.private_server import PrivateHandler, PrivateServer
from mobilegs.view.serve import Handler, Server, validate_scene_file
from mobilegs.viewpoints.framing import Start

log = logging.getLogger(__name__)
SETTINGS_MAX = 1 << 20  # bytes that a page may post besides the mask
FIELDS = {
    "title", "credit", "up", "start", "start_portrait", "floor", "annotations", "path", "free",
    "removed",
}  # fmt: skip
Cameras = Callable[[], tuple[Sequence[Camera], str]]


class EditServer(PrivateServer, Server):
    """The viewer's server, with the editor, its settings and a place to save to.

    Attributes:
        edited: the scene, a `.mgs`.
        saved: files that were written, in order.
    """

    def __init__(
        self, scene: Path, output: Path | None, cameras: Cameras, *, port: int = 0
    ) -> None:
        """Listen on this machine only; `cameras` returns those to count, and what they are.

        Without `output`, each file gets the next free name beside the scene. Raises InputError as
        `Server`, and if `output` exists.
        """
        if output is not None:
            validate_output(scene, output)
        super().__init__(scene, port=port)
        self.RequestHandlerClass = EditHandler
        self.edited = scene
        self.count = int(inspect_mgs(scene)["gaussians"])
        self.posted_max = SETTINGS_MAX + self.count // 4
        self.saved: list[Path] = []
        self._output = output
        self._cameras = cameras
        self._lock = threading.Lock()
        self._counts: tuple[CameraCounts, str] | None = None

    def counts(self) -> tuple[CameraCounts, str]:
        """Return what the cameras saw, measured at the first call, and what these cameras are."""
        with self._lock:
            if self._counts is None:
                coded = read_mgs(self.edited)
                cameras, source = self._cameras()
                if not cameras:
                    cameras, source = coded.views, f"the {len(coded.views)} cameras of the file"
                if not cameras:
                    raise InputError("no cameras are known: start with --capture CAPTURE")
                self._counts = count_cameras(coded.decode(), cameras), source
            return self._counts

    def save(self, posted: Any) -> tuple[Path, EditReport]:
        """Write an edited copy as the page describes it.

        Raises InputError for anything else than what the page sends, and as `edit_file`.
        """
        edit = edit_from_page(posted, self.count)
        with self._lock:
            output = free_name(self.edited) if self._output is None else self._output
            report = edit_file(self.edited, output, edit)
            self.saved.append(output)
        return output, report


class EditHandler(PrivateHandler):
    """Answers the requests of one connection to the editor."""

    server: EditServer  # pyright: ignore[reportIncompatibleVariableOverride]

    def get(self, asked: str) -> None:
        if asked == "":
            self._answer_text("text/html", editor_page(self.server))
        elif asked in ("scene", *SCRIPTS):
            self.path = f"/{asked}?{urlsplit(self.path).query}"
            Handler.do_GET(self)
        elif asked == "edit.js":
            self._answer_text("text/javascript", editor_script())
        elif asked == "notes":
            notes = inspect_mgs(self.server.edited)["meta"]
            self.answer_json({"notes": notes, "count": self.server.count})
        elif asked == "cameras":
            self._answer_cameras()
        else:
            self.answer_missing()

    def post(self, asked: str, posted: Any) -> None:
        if asked != "save":
            self.answer_missing()
            return
        output, report = self.server.save(posted)
        for line in (*report.lines, f"{output} is written"):
            log.info("%s", line)
        self.answer_json({"file": output.name, "lines": report.lines})

    def _answer_cameras(self) -> None:
        """Answer with the cameras that saw each Gaussian: their number in all, then u16 each."""
        try:
            counts, source = self.server.counts()
        except InputError as error:
            self.answer_json({"error": str(error)}, HTTPStatus.NOT_FOUND)
            return
        body = np.array([counts.cameras, *counts.seen.tolist()], "<u2").tobytes()
        said = {"X-Cameras": source.encode("ascii", "replace").decode()}
        self.answer_bytes("application/octet-stream", body, said)


def editor_page(server: EditServer) -> str:
    return page_with(
        {
            TITLE: f"<title>Edit {escaped(server.title)}</title>",
            ELEMENT: '<mobile-gs src="scene" editable free></mobile-gs>',
            SCRIPT: f"{script_tags('viewer.js')}\n"
            '    <script type="module" src="edit.js"></script>',
        }
    )


def edit_from_page(posted: Any, count: int) -> SceneEdit:
    """Return the edit that the page posts, as JSON values.

    Fields, all of which may be missing: `title`, `credit` (texts), `up` (three numbers), `start`
    and `start_portrait` (eight), `floor` (four), `annotations` and `path` (as their notes, in one
    list each), `free` (true: no limits, false: the file's), `removed` (base64 of a bit per
    Gaussian, lowest first). An empty text or list, or null, removes a note. Raises InputError for
    anything else.
    """
    if not isinstance(posted, dict) or not posted.keys() <= FIELDS:
        raise InputError("the page sent something else than settings")
    changes: dict[str, str] = {}
    for name in ("title", "credit"):
        if name in posted:
            text = posted[name]
            if not isinstance(text, str):
                raise InputError(f"the {name} is not a text")
            changes[name] = n.line_of_text(text, name)
    if "up" in posted:
        up = _numbers(posted["up"], 3, "upward direction")
        if up is not None and not math.hypot(*up) > n.SHORTEST:
            raise InputError("the upward direction has no length")
        changes["up"] = "" if up is None else written_up(unit(np.array(up)))
    for name in ("start", "start_portrait"):
        if name in posted:
            view = _numbers(posted[name], 8, "start view")
            changes[name] = "" if view is None else n.start_text(_start(view))
    if "floor" in posted:
        plane = _numbers(posted["floor"], 4, "floor")
        changes["floor"] = (
            "" if plane is None else n.plane_text((plane[0], plane[1], plane[2]), plane[3])
        )
    if "annotations" in posted:
        changes |= n.annotation_notes(n.parsed_annotations(posted["annotations"]))
    if "path" in posted:
        path = posted["path"]
        changes |= n.path_notes([] if path in (None, []) else n.parsed_path(path))
    if posted.get("free") is True:
        changes["limits"] = "none"
    removed = posted.get("removed")
    rows = None if removed is None else _rows(removed, count)
    return SceneEdit(rows=rows, notes=changes)


def serve_editor(
    scene: Path, output: Path | None, cameras: Cameras, *, port: int, browser: bool
) -> None:
    """Serve the editor of a `.mgs` until interrupted; raises InputError for an unusable file."""
    validate_scene_file(scene)
    with EditServer(scene, output, cameras, port=port) as server:
        address = server.address("127.0.0.1")
        log.info("%s can be edited at %s", scene, address)
        log.info("the address is a secret of this machine")
        with redirect_file(address) as file:
            server.run(file, browser=browser)


@contextmanager
def redirect_file(address: str) -> Iterator[str]:
    """Yield the address of a file that leads a browser to `address`.

    Only its owner can read it. Arguments of programs are visible to everybody on the machine.
    """
    page = f'<!doctype html><meta http-equiv="refresh" content="0; url={html.escape(address)}">'
    with tempfile.TemporaryDirectory(prefix="mobilegs-") as folder:
        path = Path(folder) / "edit.html"
        path.write_text(page, encoding="utf-8")
        yield path.as_uri()


def _start(numbers: Sequence[float]) -> Start:
    eye, target = np.array(numbers[:3], np.float64), np.array(numbers[3:6], np.float64)
    return Start(eye, target, (float(numbers[6]), float(numbers[7])))


def _numbers(value: Any, count: int, what: str) -> list[float] | None:
    """Return finite numbers; None for null. Raises InputError for anything else."""
    if value is None:
        return None
    if isinstance(value, list) and len(value) == count:
        numbers = [float(v) for v in value if type(v) in (int, float) and abs(v) < 1e12]
        if len(numbers) == count:
            return numbers
    raise InputError(f"the {what} is not {count} numbers")


def _rows(text: Any, count: int) -> torch.Tensor:
    """Return the rows whose bits are set in a base64 text. Raises InputError for anything else."""
    try:
        data = base64.b64decode(text, validate=True)
    except (TypeError, ValueError, binascii.Error):
        data = b""
    bits = np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little")
    if len(bits) != count + -count % 8 or bits[count:].any():
        raise InputError("the page has another scene than the file: load it again")
    return torch.from_numpy(bits[:count].nonzero()[0].astype(np.int64))
