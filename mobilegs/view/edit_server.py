"""The server of the editor: the viewer with tools, for this machine only.

Every address begins with a random token, which only the printed address has. Requests must name
this machine as their host (another site's name that resolves here is refused), and what is posted
must come from the page itself. The browser sends settings and which Gaussians to remove; the
server alone decides where the new file goes.
"""

import base64
import binascii
import hmac
import json
import logging
import secrets
import threading
import webbrowser
from collections.abc import Callable, Sequence
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
from mobilegs.framing import Start
from mobilegs.mgs.codec import inspect_mgs, read_mgs
from mobilegs.up import unit, written_up
from mobilegs.view.assets import (
    SCRIPT,
    SCRIPTS,
    TITLE,
    editor_script,
    escaped,
    script_tags,
)
from mobilegs.view.export import ELEMENT, page_with
from mobilegs.view.serve import Handler, Server, validate_scene_file

log = logging.getLogger(__name__)
SETTINGS_MAX = 1 << 20  # bytes that a page may post besides the mask
SECURITY = {
    "Referrer-Policy": "no-referrer",  # the address has the token
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}
FIELDS = {
    "title",
    "credit",
    "up",
    "start",
    "start_portrait",
    "floor",
    "annotations",
    "path",
    "free",
}
Cameras = Callable[[], tuple[Sequence[Camera], str]]


class EditServer(Server):
    """The viewer's server, with the editor, its settings and a place to save to.

    Attributes:
        token: what every address begins with.
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
        self.token = secrets.token_urlsafe(24)
        self.edited = scene
        self.count = int(inspect_mgs(scene)["gaussians"])
        self.saved: list[Path] = []
        self._output = output
        self._cameras = cameras
        self._lock = threading.Lock()
        self._counts: tuple[CameraCounts, str] | None = None

    @property
    def path(self) -> str:
        """The page's URL path, which has the token."""
        return f"/{self.token}/"

    @property
    def hosts(self) -> set[str]:
        """Names and ports by which requests may address this machine."""
        return {f"{name}:{self.server_port}" for name in ("127.0.0.1", "localhost")}

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


class EditHandler(Handler):
    """Answers the requests of one connection to the editor."""

    server: EditServer  # pyright: ignore[reportIncompatibleVariableOverride]

    def do_GET(self) -> None:
        asked = self._asked()
        if asked is None:
            return
        if asked == "":
            self._answer("text/html", editor_page(self.server))
        elif asked in ("scene", *SCRIPTS):
            self.path = f"/{asked}?{urlsplit(self.path).query}"
            super().do_GET()
        elif asked == "edit.js":
            self._answer("text/javascript", editor_script())
        elif asked == "notes":
            notes = inspect_mgs(self.server.edited)["meta"]
            self._answer_json({"notes": notes, "count": self.server.count})
        elif asked == "cameras":
            self._answer_cameras()
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such file here")

    def do_POST(self) -> None:
        # what was posted is not always read: the connection cannot be used again
        self.close_connection = True
        asked = self._asked()
        if asked is None:
            return
        origin = urlsplit(self.headers.get("Origin", ""))
        if origin.scheme != "http" or origin.netloc not in self.server.hosts:
            self.send_error(HTTPStatus.FORBIDDEN, "only the editor's own page may save")
            return
        if asked != "save":
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such file here")
            return
        if self.headers.get("Content-Type", "").split(";")[0] != "application/json":
            self.send_error(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "JSON is needed")
            return
        length = self.headers.get("Content-Length", "")
        if "Transfer-Encoding" in self.headers or not length.isdecimal():
            self.send_error(HTTPStatus.LENGTH_REQUIRED, "the length is not known")
            return
        if len(length) > 12 or int(length) > SETTINGS_MAX + self.server.count // 4:
            self.send_error(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "this is too much")
            return
        try:
            posted = json.loads(self.rfile.read(int(length)))
            output, report = self.server.save(posted)
        except (InputError, RecursionError, ValueError) as error:
            sentence = str(error) if isinstance(error, InputError) else "this is not JSON"
            self._answer_json({"error": sentence}, HTTPStatus.BAD_REQUEST)
            return
        log.info("\n".join([*report.lines, f"{output} is written"]))
        self._answer_json({"file": output.name, "lines": report.lines})

    def end_headers(self) -> None:
        for name, value in SECURITY.items():
            self.send_header(name, value)
        super().end_headers()

    def _asked(self) -> str | None:
        """Return what follows the token, or None after an answer that refuses the request."""
        if self.headers.get("Host", "") not in self.server.hosts:
            self.send_error(HTTPStatus.FORBIDDEN, "the editor is for its own machine")
            return None
        _, token, *rest = [*self.path.partition("?")[0].split("/", 2), ""]
        if not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such file here")
            return None
        return rest[0]

    def _answer_cameras(self) -> None:
        """Answer with the cameras that saw each Gaussian: their number in all, then u16 each."""
        try:
            counts, source = self.server.counts()
        except InputError as error:
            self._answer_json({"error": str(error)}, HTTPStatus.NOT_FOUND)
            return
        body = np.array([counts.cameras, *counts.seen.tolist()], "<u2").tobytes()
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "application/octet-stream")
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Cameras", source.encode("ascii", "replace").decode())
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def _answer_json(self, content: Any, status: HTTPStatus = HTTPStatus.OK) -> None:
        body = json.dumps(content).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)


def editor_page(server: EditServer) -> str:
    """Return the viewer's page with the tools."""
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
    if not isinstance(posted, dict) or not posted.keys() <= {*FIELDS, "removed"}:
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
        if up is not None and not any(up):
            raise InputError("the upward direction has no length")
        changes["up"] = "" if up is None else written_up(unit(np.array(up)))
    for name in ("start", "start_portrait"):
        if name in posted:
            view = _numbers(posted[name], 8, "start view")
            changes[name] = "" if view is None else n.start_text(_start(view))
    if "floor" in posted:
        plane = _numbers(posted["floor"], 4, "floor")
        if plane is not None and not any(plane[:3]):
            raise InputError("the floor has no normal")
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
        log.info("the address is a secret of this machine; Ctrl-C ends it")
        if browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            log.info("")


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
