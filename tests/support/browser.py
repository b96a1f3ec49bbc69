"""Headless Chromium for tests: one per process, with pages that Python calls into."""

import json
import threading
import time
from collections.abc import Iterator
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest

from bench.viewers.chromium import installed, launched
from mobilegs.view.assets import DIST

VIEWER = Path(__file__).parents[2] / "viewer"
TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".json": "application/json",
    ".css": "text/css",
    ".svg": "image/svg+xml",
    ".wgsl": "text/plain",
    ".glsl": "text/plain",
}
SMALL = {"width": 640, "height": 400}
# warnings that tests cause on purpose: reading pixels back, and empty scenes
MEANT = ("GPU stall due to ReadPixels", "count of 0 is unusual")
BLANK = b"<!doctype html><meta charset=utf-8><link rel=icon href=data:,><title>test</title>"
# arrays go through the server: as JSON they would take longer than what is tested
CALL = """
const KINDS = { "<f4": Float32Array, "<u4": Uint32Array, "<u2": Uint16Array, "|u1": Uint8Array };

export async function call(run, given, arrays) {
  for (const [name, kind] of arrays) {
    const answer = await fetch(`/arrays/${name}`);
    given[name] = new KINDS[kind](await answer.arrayBuffer());
  }
  const found = await run(given);
  if (!ArrayBuffer.isView(found)) return found;
  await fetch("/arrays/found", { method: "POST", body: found });
  return { kind: Object.keys(KINDS).find((kind) => found instanceof KINDS[kind]) };
}
"""


class Server(ThreadingHTTPServer):
    """Serves the viewer's sources at `/`, a blank page, and arrays in both directions.

    The build is at `/dist/`; its workers and shaders are also those of the sources.
    """

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.arrays: dict[str, bytes] = {}
        self.address = f"http://127.0.0.1:{self.server_port}"
        self._thread = threading.Thread(target=self.serve_forever, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self.shutdown()
        self._thread.join()
        self.server_close()


class Handler(BaseHTTPRequestHandler):
    """Answers one request to a `Server`."""

    server: Server  # pyright: ignore[reportIncompatibleVariableOverride]
    protocol_version = "HTTP/1.1"
    wbufsize = -1  # an answer in one piece: in two, the second waits for TCP's acknowledgement

    def handle(self) -> None:
        try:
            super().handle()
        except ConnectionError:  # a tab that was closed
            self.close_connection = True

    def do_GET(self) -> None:
        path = urlsplit(self.path).path
        file = (VIEWER / path.lstrip("/")).resolve()
        root = VIEWER
        if path.startswith("/dist/") or path.endswith(".packed.js"):
            file, root = DIST / file.name.replace(".packed", ""), DIST
        if path == "/blank.html":
            self._answer(BLANK, ".html")
        elif path == "/call.js":
            self._answer(CALL.encode(), ".js")
        elif path.startswith("/arrays/"):
            self._answer(self.server.arrays[path.removeprefix("/arrays/")])
        elif file.is_relative_to(root) and file.suffix in TYPES and file.is_file():
            self._answer(file.read_bytes(), file.suffix)
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        name = urlsplit(self.path).path.removeprefix("/arrays/")
        self.server.arrays[name] = self.rfile.read(int(self.headers["Content-Length"]))
        self._answer(b"")

    def log_message(self, format: str, *args: Any) -> None:
        pass

    def _answer(self, body: bytes, suffix: str = "") -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", TYPES.get(suffix, "application/octet-stream"))
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)


def polled(
    place: Any, expression: str, *, arg: Any = None, timeout: float = 30_000, **_: Any
) -> Any:
    """Wait until an expression, or the result of a function, is true, and return its handle.

    In a page or a frame, as playwright's `wait_for_function`: a page's policy forbids that one.
    """
    from playwright.sync_api import TimeoutError

    end = time.monotonic() + timeout / 1000
    while True:
        handle = place.evaluate_handle(expression, arg)
        if handle.evaluate("(found) => Boolean(found)"):
            return handle
        if time.monotonic() > end:
            raise TimeoutError(f"this did not become true: {expression}")
        place.wait_for_timeout(20)


class Tab:
    """A page of the test server, which opens blank.

    Attributes:
        page: playwright's page.
        address: where the server is.
        complaints: errors and warnings of the console, where WebGL and WebGPU report mistakes
            too, and what was thrown and not caught; a test fails if any is left when it ends.
    """

    def __init__(self, page: Any, server: Server) -> None:
        self.page = page
        self.address = server.address
        self.complaints: list[str] = []
        self._ignored: list[str] = list(MEANT)
        self._server = server
        page.wait_for_function = partial(polled, page)
        page.on("console", lambda message: self._hear(message.type, message.text))
        page.on("pageerror", lambda error: self._hear("error", str(error)))
        page.goto(f"{server.address}/blank.html")

    def run(self, code: str, **given: Any) -> Any:
        """Return the result of the body of an async JavaScript function.

        The body sees `given` by name: arrays as typed arrays, other values as JSON. A typed array
        that it returns becomes a numpy array.
        """
        arrays = {k: np.ascontiguousarray(v) for k, v in given.items() if isinstance(v, np.ndarray)}
        self._server.arrays.update({name: array.tobytes() for name, array in arrays.items()})
        values = json.dumps({k: v for k, v in given.items() if k not in arrays})
        kinds = json.dumps([[name, array.dtype.str] for name, array in arrays.items()])
        found = self.page.evaluate(
            f"""async () => {{
              const {{ call }} = await import("/call.js");
              return call(async ({{ {", ".join(given)} }}) => {{ {code} }}, {values}, {kinds});
            }}"""
        )
        if isinstance(found, dict) and set(found) == {"kind"}:
            return np.frombuffer(self._server.arrays.pop("found"), found["kind"])
        return found

    def share(self, name: str, content: bytes) -> None:
        """Serve bytes at `/arrays/` and the name."""
        self._server.arrays[name] = content

    def ignore(self, part: str) -> None:
        """Ignore complaints that contain a text, whether they came already or come later."""
        self._ignored.append(part)
        self.complaints = [text for text in self.complaints if part not in text]

    def close(self) -> None:
        """Close the page; an AssertionError if there were complaints."""
        self.page.close()
        assert not self.complaints, "the page complained: " + "; ".join(self.complaints)

    def _hear(self, kind: str, text: str) -> None:
        if kind in ("error", "warning") and not any(part in text for part in self._ignored):
            self.complaints.append(text)


class Chromium:
    """The browser and the server of its pages."""

    def __init__(self, browser: Any, server: Server) -> None:
        self._browser = browser
        self._server = server

    def tab(self, device_pixel_ratio: float = 0.25, **options: Any) -> Tab:
        """Open a page in a new browser context, with few pixels: a processor draws each of them.

        `options` are others of playwright's `new_page`.
        """
        page = self._browser.new_page(
            viewport=SMALL, device_scale_factor=device_pixel_ratio, **options
        )
        return Tab(page, self._server)

    def foreign(self) -> Any:
        """Return a new playwright page for another server; the caller closes it."""
        return self._browser.new_page(viewport={"width": 1200, "height": 600})


@pytest.fixture(scope="session")
def chromium() -> Iterator[Chromium]:
    """Chromium, started once per process; without it or playwright the test is skipped."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        pytest.skip("needs playwright")
    if installed() is None:
        pytest.skip("needs Chromium (make drivers)")
    server = Server()
    with sync_playwright() as playwright:
        # the page around the canvas takes less time on the processor itself
        browser = launched(playwright, "--disable-gpu-rasterization")
        yield Chromium(browser, server)
        browser.close()
    server.close()


@pytest.fixture
def tab(chromium: Chromium) -> Iterator[Tab]:
    """A blank page for one test."""
    tab = chromium.tab()
    yield tab
    tab.close()
