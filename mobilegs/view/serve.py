"""A web server for the viewer and a scene, for this machine or the local network."""

import gzip
import io
import ipaddress
import logging
import socket
import sys
import threading
import time
import webbrowser
from collections.abc import Mapping
from functools import cache
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote, unquote, urlsplit

from mobilegs.atomic import open_input
from mobilegs.data.ply_table import parse_header
from mobilegs.errors import InputError
from mobilegs.formats.ply import COLUMNS
from mobilegs.scene_file import open_scene, up_source
from mobilegs.up import Axis
from mobilegs.view.assets import (
    SCRIPT,
    SCRIPTS,
    TITLE,
    content_policy,
    escaped,
    index_page,
    preload_script,
    script,
    script_tags,
    version_of,
)
from mobilegs.view.poster import camera_notes

SCENE, OTHER = "/scene", "/other"  # the viewer recognises a format by its first bytes
VIEWER = "/viewer.js"
BLOCK = 1 << 20
CONNECTIONS_MAX = 256
BUSY_SECONDS = 0.1  # of waiting where the system gives no connection
UNDECODED = "surrogateescape"  # file names may be any bytes
SUFFIXES = (".mgs", ".ply", ".spz")
# headers of every answer
SECURITY = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",  # addresses may have a token
    "Cross-Origin-Resource-Policy": "same-origin",
}
CONVERT_HINT = " (`mobilegs export --to ply` converts scenes of other tools)"
log = logging.getLogger(__name__)


def names_this_machine(host: str) -> bool:
    """Return True if a `Host` header is an IP address, localhost, or a name of the local network.

    Pages of other sites can make their own names resolve to any address, but not these.
    """
    try:
        name = (urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:  # a bracket without an end
        return False
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return name in ("localhost", socket.gethostname().lower()) or name.endswith(".local")
    return True


class BoundedServer(ThreadingHTTPServer):
    """A server with a thread per connection, and a limit of their number."""

    daemon_threads = True
    request_queue_size = 128  # with the usual 5, visitors who came together were sent away

    def __init__(self, address: tuple[str, int], handler: type[BaseHTTPRequestHandler]) -> None:
        super().__init__(address, handler)
        self._free = threading.Semaphore(CONNECTIONS_MAX)

    def get_request(self) -> tuple[socket.socket, Any]:
        try:
            return super().get_request()
        except OSError:  # too many open files: the connection waits, and so do we
            time.sleep(BUSY_SECONDS)
            raise

    def process_request(self, request: Any, client_address: Any) -> None:
        if not self._free.acquire(blocking=False):
            self.shutdown_request(request)
            return
        try:
            super().process_request(request, client_address)
        except RuntimeError:  # the system starts no more threads
            self._free.release()
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()


class Server(BoundedServer):
    """An HTTP server for the viewer's page and one scene, or two to compare; nothing else.

    Attributes:
        scenes: files by URL path, read again for every request.
    """

    def __init__(
        self,
        scene: Path,
        other: Path | None = None,
        *,
        up: Axis | None = None,
        notes: Mapping[str, str] | None = None,
        host: str = "127.0.0.1",
        port: int = 0,
    ) -> None:
        """Listen on `host` and `port`, 0 for any free port; `up` replaces the scene's direction.

        `notes` are attributes of the page's element (`poster.camera_notes`). Raises InputError if a
        file does not exist or the address cannot be used.
        """
        self.up, self.notes = up, notes or {}
        self.scenes = {SCENE: scene}
        if other:  # with file names, which the page shows
            self.scenes = {
                f"{SCENE}/{scene.name}": scene,
                f"{OTHER}/{other.name}": other,
            }
        for file in self.scenes.values():
            if not file.is_file():
                raise InputError(f"cannot read {file}: there is no such file")
        if not 0 <= port <= 65535:
            raise InputError(f"the port must lie between 0 and 65535, not {port}")
        try:
            super().__init__((host, port), Handler)
        except OSError as error:
            raise InputError(f"cannot listen on {host}:{port}: {error.strerror}") from None
        for name in ("viewer.js", "worker.js"):  # before the first request
            _gzipped(script(name))

    def address(self, host: str) -> str:
        """Return the page's URL for a browser that reaches this machine as `host`."""
        return f"http://{host}:{self.server_port}{self.path}"

    def run(self, address: str, *, browser: bool) -> None:
        """Answer requests until Ctrl-C; with `browser`, open the address in the usual one."""
        log.info("Ctrl-C ends it")
        if browser:  # in a thread: some commands return only when the browser ends
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        try:
            self.serve_forever()
        except KeyboardInterrupt:
            log.info("")

    @property
    def title(self) -> str:
        """The page's title: file and folder of each scene, as file names are often the same."""
        return " | ".join("/".join(file.parts[-2:]) for file in self.scenes.values())

    @property
    def path(self) -> str:
        """The page's URL path, with the addresses of its scenes."""
        addresses = [quote(path, errors=UNDECODED) for path in self.scenes]
        options = [*zip(("url", "compare"), map(quote, addresses), strict=False)]
        options += [("up", self.up)] if self.up else []
        options += [(name, quote(text)) for name, text in self.notes.items()]
        return "/?" + "&".join(f"{name}={value}" for name, value in options)


class TimedReader(io.RawIOBase):
    """The input of a connection; reading raises TimeoutError at a deadline, however slow it is."""

    def __init__(self, connection: socket.socket, seconds: float) -> None:
        """Read from `connection`, for `seconds` after each `restart`."""
        self._connection, self._seconds = connection, seconds
        self.restart()

    def restart(self) -> None:
        """Put the deadline off, for another request."""
        self._deadline = time.monotonic() + self._seconds

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        self._connection.settimeout(max(self._deadline - time.monotonic(), 1e-3))
        try:
            return self._connection.recv_into(buffer)
        finally:
            self._connection.settimeout(self._seconds)  # of writing


class Handler(BaseHTTPRequestHandler):
    """Answers the requests of one connection."""

    server: Server  # pyright: ignore[reportIncompatibleVariableOverride]
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True  # the body of an answer would wait for the head's receipt
    timeout = 60.0  # seconds until a request must have arrived, or the connection ends

    def setup(self) -> None:
        super().setup()
        self.rfile.close()
        assert self.timeout
        self._received = TimedReader(self.connection, self.timeout)
        self.rfile = io.BufferedReader(self._received)

    def handle_one_request(self) -> None:
        self._received.restart()
        super().handle_one_request()

    def do_GET(self) -> None:
        if not names_this_machine(self.headers.get("Host", "localhost")):  # browsers send one
            self.send_error(HTTPStatus.FORBIDDEN, "use the address that is printed, with numbers")
            return
        try:
            request = urlsplit(self.path)
        except ValueError:
            self.send_error(HTTPStatus.BAD_REQUEST, "malformed address")
            return
        path = unquote(request.path, errors=UNDECODED)
        if request.path == "/" and "url" not in parse_qs(request.query):
            options = "&" + request.query if request.query else ""
            self.send_response(HTTPStatus.FOUND)
            self.send_header("Location", self.server.path + options)
            self.send_header("Content-Length", "0")
            self.end_headers()
        elif request.path == "/":
            page = index_page().replace(SCRIPT, script_tags(VIEWER))
            title = f"<title>{escaped(self.server.title)}</title>"
            self._answer_text("text/html", page.replace(TITLE, title))
        elif request.path[1:] in SCRIPTS:
            text = script(request.path[1:])
            immutable = request.query == version_of(text)
            self._answer_text("text/javascript", text, immutable=immutable)
        elif path in self.server.scenes:
            self._answer_scene(self.server.scenes[path])
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such file here")

    def do_HEAD(self) -> None:
        self.do_GET()

    def _answer_text(self, kind: str, text: str, *, immutable: bool = False) -> None:
        packed = "gzip" in self.headers.get("Accept-Encoding", "")
        headers = {"Content-Encoding": "gzip"} if packed else {}
        if immutable:  # the address of a script contains its version
            headers["Cache-Control"] = "max-age=31536000, immutable"
        body = _gzipped(text) if packed else text.encode()
        self._answer(f"{kind}; charset=utf-8", body, headers)

    def _answer(
        self,
        kind: str,
        body: bytes,
        headers: Mapping[str, str],
        status: HTTPStatus = HTTPStatus.OK,
    ) -> None:
        self._head(kind, len(body), headers, status)
        if self.command != "HEAD":
            self.wfile.write(body)

    def _answer_scene(self, file: Path) -> None:
        try:
            opened = open_input(file)
        except InputError:  # deleted since the server started
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
            if size:  # the file was truncated meanwhile: the browser sees a short answer
                self.close_connection = True

    def _head(
        self,
        kind: str,
        size: int,
        headers: Mapping[str, str] | None = None,
        status: HTTPStatus = HTTPStatus.OK,
    ) -> None:
        self.send_response(status)
        usual = {
            "Content-Type": kind,
            "Content-Length": str(size),
            "Cache-Control": "no-cache",
            "Vary": "Accept-Encoding",
        }
        for name, value in {**usual, **(headers or {})}.items():
            self.send_header(name, value)
        self.end_headers()

    def end_headers(self) -> None:
        policy = f"{self.policy()}; frame-ancestors 'none'"
        for name, value in {**SECURITY, "Content-Security-Policy": policy}.items():
            self.send_header(name, value)
        super().end_headers()

    def policy(self) -> str:
        """Return the Content-Security-Policy of pages."""
        return content_policy(preload_script())

    def handle(self) -> None:
        try:
            super().handle()
        except ConnectionError:  # the browser closed the connection
            self.close_connection = True

    def log_message(self, format: str, *args: object) -> None:
        pass


@cache
def _gzipped(text: str) -> bytes:
    """Compress a page or script, once."""
    return gzip.compress(text.encode(), mtime=0)


def serve(
    scene: Path, other: Path | None, *, up: Axis | None = None, lan: bool, port: int, browser: bool
) -> None:
    """Serve the viewer with a scene, or with two to compare, until interrupted.

    `up` replaces the scene's upward direction. With `lan`, other devices in the network can open
    it; the address is shown as a QR code. They get WebGL2: browsers allow WebGPU over plain http
    only from the same machine. Raises InputError for files that the viewer does not show.
    """
    for file in (scene, other):
        if file is not None:
            validate_scene_file(file)
    plain = None if scene.suffix.lower() == ".mgs" else open_scene(scene)
    notes = {} if plain is None else camera_notes(plain, up)
    host = "0.0.0.0" if lan else "127.0.0.1"
    server = Server(scene, other, up=up, notes=notes, host=host, port=port)
    with server:
        local = server.address("127.0.0.1")
        log.info("%s is shown at %s", scene, local)
        if up is None and plain is not None:
            turn = "" if plain.up is not None else " (the key U or --up changes it)"
            log.info("up is %s%s", up_source(scene, plain.up), turn)
        host = own_address() if lan else None
        if host:
            log.info("in this network at %s", server.address(host))
            if sys.stdout.isatty():
                _show_code(server.address(host))
        elif lan:
            log.info("this machine has no network: only it can open the page")
        server.run(local, browser=browser)


def _show_code(address: str) -> None:
    """Print a QR code, if the terminal has the characters."""
    import segno

    try:
        segno.make(address, error="l").terminal(compact=True)
    except UnicodeEncodeError:
        log.info("(this terminal cannot show a QR code)")


def validate_scene_file(path: Path) -> None:
    """Raise InputError for a file that does not exist, is empty or of a format without a viewer.

    Does not check the rest of its content.
    """
    with open_input(path) as file:
        head = file.read(1 << 16)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path} is not a scene: give a .mgs, .ply or .spz file{CONVERT_HINT}")
    if not head:
        raise InputError(f"{path} is empty")
    if head.startswith(b"ply"):
        if b" packed_position" in head:
            raise InputError(
                f"{path} is a compressed .ply, which the web viewer does not show{CONVERT_HINT}"
            )
        header = parse_header(head, path)
        names = [element.name for element in header.elements]
        plain = names[:1] == ["vertex"] and header.order == "<"
        if not plain or any(header.elements[0].columns.get(name) != "f4" for name in COLUMNS):
            raise InputError(
                f"{path} is not a .ply that the web viewer shows: it needs the vertices first, as "
                f"binary little-endian floats{CONVERT_HINT}"
            )


def own_address() -> str | None:
    """Return this machine's address in its network, or None without a network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing: the system only picks a route
            return probe.getsockname()[0]
        except OSError:
            return None
