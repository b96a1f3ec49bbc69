"""The local server for the pages of bench/viewers/compare.py."""

import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from mobilegs.view.assets import DIST

TYPES = {".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript"}
TYPES |= {".json": "application/json", ".wasm": "application/wasm", ".css": "text/css"}


class Server(ThreadingHTTPServer):
    """Serves folders by name and scenes; receives pictures."""

    daemon_threads = True

    def __init__(self, folders: dict[str, Path], scenes: dict[str, Path]) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.folders = folders
        self.scenes = scenes
        self.plan = b""
        self.pictures: dict[str, bytes] = {}
        self.address = f"http://127.0.0.1:{self.server_port}"
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def file_of(self, path: str) -> Path:
        first, _, rest = path.partition("/")
        if first == "scene":
            return self.scenes[Path(rest).suffix[1:]]
        if path.endswith(".packed.js"):  # of the viewer, which the build makes
            return DIST / Path(path).name.replace(".packed", "")
        if rest and first in self.folders:
            return self.folders[first] / rest
        return self.folders[""] / path


class Handler(BaseHTTPRequestHandler):
    """Answers one request to a `Server`."""

    server: Server  # pyright: ignore[reportIncompatibleVariableOverride]
    protocol_version = "HTTP/1.1"
    wbufsize = -1  # an answer in one piece: in two, the second waits for TCP's acknowledgement

    def do_GET(self) -> None:
        path = urlsplit(self.path).path.lstrip("/")
        if path == "plan.json":
            return self._answer(self.server.plan, ".json")
        file = self.server.file_of(path)
        if not file.is_file():
            return self.send_error(HTTPStatus.NOT_FOUND)
        self._answer(file.read_bytes(), file.suffix)

    def do_POST(self) -> None:
        name = urlsplit(self.path).path.removeprefix("/pictures/")
        self.server.pictures[name] = self.rfile.read(int(self.headers["Content-Length"]))
        self._answer(b"")

    def log_message(self, format: str, *args: Any) -> None:
        pass

    def _answer(self, body: bytes, suffix: str = "") -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", TYPES.get(suffix, "application/octet-stream"))
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        # without these a page has no shared memory, which mkkellogg's worker wants
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        self.end_headers()
        self.wfile.write(body)
