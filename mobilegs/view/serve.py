"""The web viewer, served to this machine's browser or to phones in the same network."""

import socket
import sys
import webbrowser
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlsplit

from mobilegs.errors import InputError

FOLDER = Path(__file__).resolve().parent
SCENE = "/scene"  # what it is, its first bytes say
SERVED = ("web", "shaders")  # of this folder, the only ones that leave it
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".wgsl": "text/plain; charset=utf-8",
    ".glsl": "text/plain; charset=utf-8",
}
BLOCK = 1 << 20


class Server(ThreadingHTTPServer):
    """Serves the viewer's own files and one scene; every other path is unknown.

    Attributes:
        scene: the scene's file, read anew for every visit.
    """

    daemon_threads = True

    def __init__(self, scene: Path, *, host: str = "127.0.0.1", port: int = 0) -> None:
        """Listen on `host`; port 0 takes any that is free. InputError if that cannot be."""
        if not scene.is_file():
            raise InputError(f"cannot read {scene}: there is no such file")
        self.scene = scene
        try:
            super().__init__((host, port), Handler)
        except OSError as error:
            raise InputError(f"cannot listen on {host}:{port}: {error.strerror}") from None

    def address(self, host: str) -> str:
        """What to open in a browser that reaches this machine as `host`."""
        return f"http://{host}:{self.server_port}/web/index.html?url={SCENE}"


class Handler(BaseHTTPRequestHandler):
    """Answers one connection."""

    server: Server
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        path = urlsplit(self.path).path
        if path == "/":
            self.send_response(HTTPStatus.FOUND)
            self.send_header("Location", f"/web/index.html?url={SCENE}")
            self.send_header("Content-Length", "0")
            self.end_headers()
            return
        file = self._file_of(path)
        try:
            opened = None if file is None else file.open("rb")
        except OSError:  # it was there a moment ago
            opened = None
        if file is None or opened is None:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such file here")
            return
        with opened:
            size = opened.seek(0, 2)
            opened.seek(0)
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", TYPES.get(file.suffix, "application/octet-stream"))
            self.send_header("Content-Length", str(size))
            self.send_header("Cache-Control", "no-cache")
            self.send_header("X-Content-Type-Options", "nosniff")
            self.end_headers()
            while block := opened.read(BLOCK):
                self.wfile.write(block)

    def handle(self) -> None:
        try:
            super().handle()
        except ConnectionError:  # the visitor went away
            self.close_connection = True

    def log_message(self, format: str, *args: object) -> None:
        pass

    def _file_of(self, path: str) -> Path | None:
        if path == SCENE:
            return self.server.scene
        file = FOLDER.joinpath(path.lstrip("/")).resolve()
        inside = any(file.is_relative_to(FOLDER / name) for name in SERVED)
        return file if inside and file.suffix in TYPES and file.is_file() else None


def serve(scene: Path, *, lan: bool, port: int, browser: bool) -> None:
    """Serve the viewer with a scene until interrupted.

    With `lan`, phones in the same network can open it too: the address is shown as a QR code.
    Browsers give no WebGPU to pages that come over plain http from elsewhere; the viewer then
    draws with WebGL2.
    """
    server = Server(scene, host="0.0.0.0" if lan else "127.0.0.1", port=port)
    with server:
        local = server.address("127.0.0.1")
        print(f"{scene} is shown at {local}")
        if lan:
            address = server.address(own_address())
            print(f"in this network at {address}")
            if sys.stdout.isatty():
                import segno

                segno.make(address, error="l").terminal(compact=True)
        print("Ctrl-C ends it", flush=True)
        if browser:
            webbrowser.open(local)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print()


def own_address() -> str:
    """This machine's address in its network; its name where it has none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # nothing is sent: the system only picks a way
            return probe.getsockname()[0]
        except OSError:
            return socket.gethostname()
