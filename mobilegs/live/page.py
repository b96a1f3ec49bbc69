"""The page of the live view: its server, and what each browser asks to see.

A browser posts its camera a few times per second and gets the newest frame that it lacks. The
server's threads only note the camera and compress the frame; the training thread renders.
"""

import io
import json
import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.live.frame_budget import Detail
from mobilegs.live.frames import BrowserCamera, TrainingCameras
from mobilegs.view.assets import TITLE, escaped, live_page, live_script
from mobilegs.view.private_server import PrivateHandler, PrivateServer
from mobilegs.view.serve import own_address

MODES = ("render", "depth", "error", "photo", "photo | render | error")
PHOTO_MODES = MODES[2:]  # seen from the nearest photo's camera instead of the browser's
VISITORS_MAX = 16
FORGET_SECONDS = 20.0  # without a sign of a browser, after which its frames are dropped
LOOKS = 50  # answers with frames per second, for all browsers together
QUALITY = 85  # of JPEG
PORTS = 20  # that are tried after the first
NUMBER_MAX = 1e12  # of a camera
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'unsafe-inline'; img-src data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'"
)
log = logging.getLogger(__name__)


class FrameRequest(NamedTuple):
    """A frame that a canvas should show."""

    mode: str
    source: BrowserCamera | int
    """A browser's camera, or the index of a training photo."""
    canvas: tuple[int, int]
    """Width and height in pixels."""
    detail: Detail
    step: tuple[str, int]
    """Stage and number of steps taken."""


@dataclass
class Visitor:
    """A browser: its wishes, and the last frame that was drawn for it."""

    camera: BrowserCamera
    mode: str
    seen_at: float
    moved_at: float
    last_request: FrameRequest | None = None
    drawn_at: float = 0.0
    frame: UInt8[np.ndarray, "h w 3"] | None = None
    frames: int = 0
    """Number of frames drawn."""
    drawn_from: BrowserCamera | None = None
    said: dict[str, str] = field(default_factory=dict)
    """Names and values about the frame."""


class Page(PrivateServer):
    """The page that every browser at the address sees, and the requests of its users.

    Attributes:
        address: http address of the page, with its token.
        changed: an event, set by every request for something new; the reader clears it.
        paused: True while the training should stand still.
        cameras: the training cameras.
    """

    posted_max = 4096

    def __init__(
        self, host: str, port: int, dataset: Dataset, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Listen at `host` and `port`, or the next free port; 0 takes any free port.

        `clock` returns seconds. Raises InputError if the address cannot be used.
        """
        self.changed = threading.Event()
        self.paused = False
        self.clock = clock
        self.title = f"mobilegs: {dataset.name}"
        self.show(dataset)
        self._visitors: dict[int, Visitor] = {}
        self._status: dict[str, str] = {}
        self._lock = threading.Lock()
        self._closed = False
        self._next_look = 0.0
        last = min(port + PORTS, 65535) if port else 0
        for other in range(port, last + 1):
            try:
                super().__init__((host, other), PageHandler)
                break
            except OSError as error:
                if other == last:
                    reason = f"--live cannot listen at {host}:{port} ({error.strerror})"
                    raise InputError(reason) from None
        place = own_address() or "127.0.0.1" if host == "0.0.0.0" else self.server_address[0]
        self.address = f"http://{place}:{self.server_port}{self.path}"
        self._thread = threading.Thread(target=self.serve_forever, daemon=True)
        self._thread.start()

    def show(self, dataset: Dataset) -> None:
        """Show the cameras of `dataset`: those of the same photos, whose poses may have changed."""
        self.cameras = TrainingCameras(dataset)
        self.about = json.dumps(about(dataset, self.cameras)).encode()

    def visitors(self) -> list[Visitor]:
        """Return the browsers that are there, the longest without a frame first."""
        with self._lock:
            self._forget(self.clock())
            return sorted(self._visitors.values(), key=lambda visitor: visitor.drawn_at)

    def send_frame(
        self, visitor: Visitor, frame: UInt8[np.ndarray, "h w 3"], said: dict[str, str]
    ) -> None:
        """Keep a frame until the browser asks for it, with names and values about it."""
        with self._lock:
            visitor.frame, visitor.said = frame, said
            visitor.frames += 1
            source = visitor.last_request.source if visitor.last_request else None
            visitor.drawn_from = source if isinstance(source, BrowserCamera) else None

    def _forget(self, now: float) -> None:
        for number, visitor in list(self._visitors.items()):
            if now - visitor.seen_at > FORGET_SECONDS:
                del self._visitors[number]

    def set_status(self, rows: dict[str, str]) -> None:
        """Show the state of the training as names and values."""
        self._status = rows

    def pause(self, paused: bool) -> None:
        """Pause the training or continue it."""
        self.paused = paused
        self.changed.set()

    def look(self, posted: Any) -> tuple[dict[str, Any], UInt8[np.ndarray, "h w 3"] | None]:
        """Note what a browser asks for; return the state, and the frame if it lacks the newest.

        Raises InputError for anything else than what the page posts.
        """
        number, seen = (whole(posted, name) for name in ("visitor", "seen"))
        mode, camera = posted.get("mode"), camera_from(posted)
        if mode not in MODES:
            raise InputError("there is no such mode")
        if self._closed:  # a connection from before is still open
            raise InputError("the training has ended")
        now = self.clock()
        with self._lock:
            visitor = self._visitors.get(number)
            if visitor is None:
                self._forget(now)
                if len(self._visitors) >= VISITORS_MAX:
                    raise InputError(f"{VISITORS_MAX} browsers look on already")
                visitor = self._visitors[number] = Visitor(camera, mode, now, now)
                self.changed.set()
            visitor.seen_at = now
            if (visitor.camera, visitor.mode) != (camera, mode):
                visitor.camera, visitor.mode, visitor.moved_at = camera, mode, now
                self.changed.set()
            drawn = visitor.drawn_from
            state = {
                "paused": self.paused,
                "rows": [*self._status.items(), *visitor.said.items()],
                "seen": visitor.frames,
                "nearest": self.cameras.nearest(camera),
                "camera": None if drawn is None else [*drawn.viewmat, drawn.focal, drawn.height],
            }
            frame, visitor.frame = visitor.frame, None
            if frame is None and seen != visitor.frames:  # an answer was lost
                visitor.last_request = None
            return state, frame

    def pace(self) -> None:
        """Wait for this browser's turn: many of them take no more from the training than two."""
        with self._lock:
            now = time.monotonic()
            turn = max(self._next_look, now)
            self._next_look = turn + 1 / LOOKS
        time.sleep(turn - now)

    def close(self) -> None:
        """Stop listening and answering."""
        self._closed = True
        self.shutdown()
        self.server_close()
        self._thread.join()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Note an error of one connection, which ends it alone."""
        log.debug("a connection of the live view ended", exc_info=True)


class PageHandler(PrivateHandler):
    """Answers the requests of one browser."""

    server: Page  # pyright: ignore[reportIncompatibleVariableOverride]

    def policy(self) -> str:
        return POLICY

    def get(self, asked: str) -> None:
        if asked == "":
            title = f"<title>{escaped(self.server.title)}</title>"
            self._answer_text("text/html", live_page().replace(TITLE, title))
        elif asked == "live.js":
            self._answer_text("text/javascript", live_script())
        elif asked == "photos":
            self.answer_bytes("application/json", self.server.about)
        else:
            self.answer_missing()

    def post(self, asked: str, posted: Any) -> None:
        if not isinstance(posted, dict):
            raise InputError("the page sent something else than its camera")
        if asked == "look":
            self.server.pace()
            state, frame = self.server.look(posted)
            head = json.dumps(state).encode()
            body = len(head).to_bytes(4, "little") + head + jpeg(frame)
            self.answer_bytes("application/octet-stream", body)
        elif asked == "pause" and isinstance(posted.get("paused"), bool):
            self.server.pause(posted["paused"])
            self.answer_json({})
        else:
            self.answer_missing()


def about(dataset: Dataset, cameras: TrainingCameras) -> dict[str, Any]:
    """Return the training photos, their cameras and the upward direction, for the page."""
    return {
        "modes": MODES,
        "up": cameras.up.tolist(),
        "extent": cameras.extent,
        "photos": [
            {
                "name": frame.name,
                "viewmat": camera.viewmat.flatten().tolist(),
                "K": camera.K.flatten().tolist(),
                "width": camera.width,
                "height": camera.height,
            }
            for frame, camera in zip(dataset.train, cameras.cameras, strict=True)
        ],
    }


def camera_from(posted: dict[str, Any]) -> BrowserCamera:
    """Return the camera that a page posts; raises InputError if no image can be rendered there."""
    numbers = posted.get("viewmat")
    if not isinstance(numbers, list) or len(numbers) != 16:
        raise InputError("the camera has not 16 numbers")
    values = [
        float(value)
        for value in (*numbers, posted.get("focal"))
        if isinstance(value, int | float) and type(value) is not bool and abs(value) < NUMBER_MAX
    ]
    if len(values) != 17:
        raise InputError("the camera has something else than numbers, or too large ones")
    width, height = (whole(posted, name) for name in ("width", "height"))
    camera = BrowserCamera(tuple(values[:16]), values[16], width, height)
    camera.check()
    return camera


def whole(posted: dict[str, Any], name: str) -> int:
    """Return a number that a page posts, from 0 to 2^53; raises InputError for anything else."""
    value = posted.get(name)
    if type(value) is not int or not 0 <= value <= 1 << 53:
        raise InputError(f"{name} is not a whole number")
    return value


def jpeg(frame: UInt8[np.ndarray, "h w 3"] | None) -> bytes:
    """Return a frame as JPEG, or nothing for no frame."""
    packed = io.BytesIO()
    if frame is not None:
        Image.fromarray(frame).save(packed, "JPEG", quality=QUALITY)
    return packed.getvalue()
