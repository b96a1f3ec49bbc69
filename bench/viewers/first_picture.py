"""Time the first meaningful picture of exported sites over slow networks, in headless Chromium.

    python -m bench.viewers.first_picture --mgs SCENE.mgs ... [--json OUT] [--rounds 3]

Each scene is exported with `export --to site` and opened by a browser that has never seen it, at
100 kB/s, 400 kB/s (each with 40 ms of latency) and without a limit, in the size of a phone, without
buttons: they would count as errors. The server compresses scripts and pages, as hosts do.
Chromium's screencast gives every picture that it painted, and when. A picture is meaningful from
20 dB to the last one on, which is the complete scene. Times are milliseconds from navigation,
medians of `--rounds` visits: `first_paint` (the first picture that is not blank), `meaningful`,
`loaded` (everything is decoded). `blank_after` counts pictures of one colour after the first paint.
"""

import argparse
import base64
import functools
import gzip
import http.server
import io
import os
import statistics
import tempfile
import threading
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from bench.record import RESULTS, Figures
from bench.viewers.chromium import launched
from mobilegs.view.export import export_site

RATES = {"100 kB/s": 100_000, "400 kB/s": 400_000, "unlimited": None}
SIZE = {"width": 390, "height": 844}
ENOUGH = 20.0  # dB
FLAT = 2.0  # standard deviation of a blank picture, of 255
LATENCY = 40  # milliseconds


class Host(http.server.SimpleHTTPRequestHandler):
    """Serves a folder like a host of static files: text is compressed."""

    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        path = Path(self.translate_path(self.path))
        path = path / "index.html" if path.is_dir() else path
        if not path.is_file():
            self.send_error(404)
            return
        body = path.read_bytes()
        packed = path.suffix in (".html", ".js", ".webmanifest")
        body = gzip.compress(body, 9) if packed else body
        self.send_response(200)
        self.send_header("Content-Type", self.guess_type(str(path)))
        self.send_header("Content-Length", str(len(body)))
        if packed:
            self.send_header("Content-Encoding", "gzip")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        pass


def visit(playwright: Any, address: str, rate: int | None) -> dict[str, float]:
    """Return the times of a first visit."""
    browser = launched(playwright)
    page = browser.new_page(viewport=SIZE)
    session = page.context.new_cdp_session(page)
    pictures: list[tuple[float, np.ndarray]] = []

    def record(event: dict) -> None:
        image = Image.open(io.BytesIO(base64.b64decode(event["data"]))).convert("RGB")
        pictures.append((event["metadata"]["timestamp"], np.asarray(image, np.float32)))
        session.send("Page.screencastFrameAck", {"sessionId": event["sessionId"]})

    session.on("Page.screencastFrame", record)
    session.send("Network.enable")
    if rate is not None:
        limits = {"latency": LATENCY, "downloadThroughput": rate, "uploadThroughput": rate}
        session.send("Network.emulateNetworkConditions", {"offline": False, **limits})
    session.send("Page.startScreencast", {"format": "png", "everyNthFrame": 1})
    page.goto(address, wait_until="commit")
    page.wait_for_selector("mobile-gs[data-state=loaded]", timeout=300_000)
    origin = page.evaluate("performance.timeOrigin") / 1000
    loaded = page.evaluate("performance.now()")
    page.wait_for_timeout(1500)
    browser.close()
    painted = [(when - origin, image) for when, image in pictures if when >= origin]
    _, last = painted[-1]
    painted = [(when, image) for when, image in painted if image.shape == last.shape]
    shown = [(when, image) for when, image in painted if image.std() > FLAT]
    meaningful = [when for when, image in shown if decibels(image, last) >= ENOUGH]
    late = [image for when, image in painted if when > shown[0][0] and image.std() <= FLAT]
    return {
        "first_paint": 1000 * shown[0][0],
        "meaningful": 1000 * meaningful[0],
        "loaded": loaded,
        "blank_after": len(late),
        "pictures": len(painted),
    }


def decibels(image: np.ndarray, other: np.ndarray) -> float:
    error = float(np.square(image - other).mean())
    return float(10 * np.log10(255**2 / max(error, 1e-9)))


def main() -> None:
    from playwright.sync_api import sync_playwright

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mgs", type=Path, nargs="+", required=True)
    parser.add_argument("--json", type=Path, default=RESULTS / "first_picture.json")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    figures = Figures(options.json, size=list(SIZE.values()), rounds=options.rounds)
    for path in options.mgs:
        with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
            site = Path(folder) / "site"
            export_site(path, site, title=path.stem)
            handler = functools.partial(Host, directory=str(site))
            server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
            threading.Thread(target=server.serve_forever, daemon=True).start()
            address = f"http://127.0.0.1:{server.server_port}/?noui"
            page = gzip.compress((site / "index.html").read_bytes(), 9)
            row: dict[str, Any] = {"file_bytes": path.stat().st_size, "page_bytes": len(page)}
            for name, rate in RATES.items():
                runs = [visit(playwright, address, rate) for _ in range(options.rounds)]
                row[name] = {
                    key: round(statistics.median(run[key] for run in runs)) for key in runs[0]
                }
            server.shutdown()
            figures.add(path.stem, **row, load_average=os.getloadavg()[0])


if __name__ == "__main__":
    main()
