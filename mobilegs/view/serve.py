"""The web viewer, served to this machine's browser or to phones in the same network."""

import gzip
import socket
import sys
import threading
import webbrowser
from functools import cache
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, quote, unquote, urlsplit

from mobilegs.errors import InputError
from mobilegs.formats.ply import COLUMNS, parse_header
from mobilegs.view.bundle import (
    SCRIPT,
    TITLE,
    WEB,
    linked,
    shown,
    viewer_script,
    viewer_version,
)

SCENE, OTHER = "/scene", "/other"  # what they are, their first bytes say
VIEWER = "/viewer.js"
BLOCK = 1 << 20
UNDECODED = "surrogateescape"  # names of files may be any bytes
KINDS = (".mgs", ".ply", ".spz")
OTHERS = " (`mobilegs export --to ply` makes one of other tools' scenes)"


class Server(ThreadingHTTPServer):
    """Serves the viewer's page and a scene, or two to compare; every other path is unknown.

    Attributes:
        scenes: their files by path, read anew for every visit.
    """

    daemon_threads = True

    def __init__(
        self, scene: Path, other: Path | None = None, *, host: str = "127.0.0.1", port: int = 0
    ) -> None:
        """Listen on `host`; port 0 takes any that is free. InputError if that cannot be."""
        self.scenes = {SCENE: scene}
        if other:  # both with their names, which the page shows
            self.scenes = {
                f"{SCENE}/{scene.name}": scene,
                f"{OTHER}/{other.name}": other,
            }
        for file in self.scenes.values():
            if not file.is_file():
                raise InputError(f"cannot read {file}: there is no such file")
        if not 0 <= port <= 65535:
            raise InputError(f"a port lies between 0 and 65535, not at {port}")
        try:
            super().__init__((host, port), Handler)
        except OSError as error:
            raise InputError(f"cannot listen on {host}:{port}: {error.strerror}") from None
        _gzipped(viewer_script())  # before somebody waits for it

    def address(self, host: str) -> str:
        """What to open in a browser that reaches this machine as `host`."""
        return f"http://{host}:{self.server_port}{self.path}"

    @property
    def title(self) -> str:
        """Of the page: its scenes, with their folders, since most are called the same."""
        return " | ".join("/".join(file.parts[-2:]) for file in self.scenes.values())

    @property
    def path(self) -> str:
        """Of the page, with the addresses of the scenes that it shows."""
        addresses = [quote(path, errors=UNDECODED) for path in self.scenes]
        return "/?" + "&".join(
            f"{name}={quote(address)}"
            for name, address in zip(("url", "compare"), addresses, strict=False)
        )


class Handler(BaseHTTPRequestHandler):
    """Answers one connection."""

    server: Server
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        try:
            asked = urlsplit(self.path)
        except ValueError:
            self.send_error(HTTPStatus.BAD_REQUEST, "that is no address")
            return
        path = unquote(asked.path, errors=UNDECODED)
        if asked.path == "/" and "url" not in parse_qs(asked.query):
            wishes = "&" + asked.query if asked.query else ""
            self.send_response(HTTPStatus.FOUND)
            self.send_header("Location", self.server.path + wishes)
            self.send_header("Content-Length", "0")
            self.end_headers()
        elif asked.path == "/":
            page = (WEB / "index.html").read_text().replace(SCRIPT, linked(VIEWER))
            title = f"<title>{shown(self.server.title)}</title>"
            self._answer("text/html", page.replace(TITLE, title))
        elif asked.path == VIEWER:
            lasting = asked.query == viewer_version()
            self._answer("text/javascript", viewer_script(), lasting=lasting)
        elif path in self.server.scenes:
            self._answer_scene(self.server.scenes[path])
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such file here")

    def do_HEAD(self) -> None:
        self.do_GET()

    def _answer(self, kind: str, text: str, *, lasting: bool = False) -> None:
        packed = "gzip" in self.headers.get("Accept-Encoding", "")
        body = _gzipped(text) if packed else text.encode()
        self._head(f"{kind}; charset=utf-8", len(body), packed=packed, lasting=lasting)
        if self.command != "HEAD":
            self.wfile.write(body)

    def _answer_scene(self, file: Path) -> None:
        try:
            opened = file.open("rb")
        except OSError:  # it was there a moment ago
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such file here")
            return
        with opened:
            size = opened.seek(0, 2)
            opened.seek(0)
            self._head("application/octet-stream", size)
            if self.command == "HEAD":
                return
            while size and (block := opened.read(min(size, BLOCK))):
                self.wfile.write(block)
                size -= len(block)
            if size:  # it was cut meanwhile: nothing else tells the visitor
                self.close_connection = True

    def _head(self, kind: str, size: int, *, packed: bool = False, lasting: bool = False) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(size))
        if packed:
            self.send_header("Content-Encoding", "gzip")
        # a script's address changes with it
        self.send_header("Cache-Control", "max-age=31536000, immutable" if lasting else "no-cache")
        self.send_header("Vary", "Accept-Encoding")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()

    def handle(self) -> None:
        try:
            super().handle()
        except ConnectionError:  # the visitor went away
            self.close_connection = True

    def log_message(self, format: str, *args: object) -> None:
        pass


@cache
def _gzipped(text: str) -> bytes:
    """A page or script, packed once and not for every visit."""
    return gzip.compress(text.encode(), mtime=0)


def serve(scene: Path, other: Path | None, *, lan: bool, port: int, browser: bool) -> None:
    """Serve the viewer with a scene, or with two to compare, until interrupted.

    With `lan`, phones in the same network can open it too: the address is shown as a QR code.
    Browsers give no WebGPU to pages that come over plain http from elsewhere; the viewer then
    draws with WebGL2. InputError for files that are no scenes by their names, or empty.
    """
    for file in (scene, other):
        if file is not None:
            refuse_unreadable(file)
    server = Server(scene, other, host="0.0.0.0" if lan else "127.0.0.1", port=port)
    with server:
        local = server.address("127.0.0.1")
        print(f"{scene} is shown at {local}")
        host = own_address() if lan else None
        if host:
            print(f"in this network at {server.address(host)}")
            if sys.stdout.isatty():
                _show_code(server.address(host))
        elif lan:
            print("this machine is in no network: nobody else can open it")
        print("Ctrl-C ends it", flush=True)
        if browser:  # some commands wait until their browser ends
            threading.Thread(target=webbrowser.open, args=(local,), daemon=True).start()
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print()


def _show_code(address: str) -> None:
    """A QR code in the terminal, if that has what it is drawn with."""
    import segno

    try:
        segno.make(address, error="l").terminal(compact=True)
    except UnicodeEncodeError:
        print("(this terminal cannot show a QR code)")


def refuse_unreadable(path: Path) -> None:
    """Raise InputError unless there is a file of a kind that the web viewer shows, and not empty.

    What else is in it is left to who opens it.
    """
    if path.is_dir():
        raise InputError(f"cannot read {path}: it is a folder")
    if path.suffix.lower() not in KINDS:
        raise InputError(f"{path} is no scene: a .mgs, .ply or .spz file is needed{OTHERS}")
    try:
        with path.open("rb") as file:
            head = file.read(1 << 16)
    except FileNotFoundError:
        raise InputError(f"cannot read {path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    if not head:
        raise InputError(f"{path} is empty")
    if head.startswith(b"ply"):
        if b" packed_position" in head:
            raise InputError(
                f"{path} is a compressed .ply, which the web viewer does not show{OTHERS}"
            )
        header = parse_header(head, path)
        names = [element.name for element in header.elements]
        plain = names[:1] == ["vertex"] and header.order == "<"
        if not plain or any(header.elements[0].columns.get(name) != "f4" for name in COLUMNS):
            raise InputError(
                f"{path} is no .ply that the web viewer shows, whose vertices come first, in "
                f"binary, little-endian floats{OTHERS}"
            )


def own_address() -> str | None:
    """This machine's address in its network; None where it is in none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # nothing is sent: the system only picks a way
            return probe.getsockname()[0]
        except OSError:
            return None
