"""Ten browsers at the live view of a training, which come and go; the result must not change.

    python -m bench.soak.live [--browsers 10] [--visits 40] [--json OUT]

A training with `--live` runs in a process of its own. Browsers open its page, stay for a moment and
leave, at most ten at a time. The run must end by itself with the same scene.mgs and teacher.ply as
one without a live view; its memory and open files are watched.
"""

import argparse
import json
import random
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import Error, Page, sync_playwright

from bench.soak.record import add_record
from bench.soak.server import use_of
from bench.soak.training import SoakError, Training, digests
from bench.viewers.chromium import launched
from mobilegs.data.demo.capture import demo_capture, write_capture

STEPS = 600
STAY = (0.5, 6.0)  # seconds


def address_of(process: subprocess.Popen[str]) -> str:
    """Wait for the address that a training prints."""
    assert process.stdout is not None
    for line in process.stdout:
        for word in line.split():
            if word.startswith("http://"):
                return word.rstrip(".,;:")
    raise SoakError("the training printed no address")


def soak(folder: Path, browsers: int, visits: int, seed: int = 0) -> dict[str, Any]:
    """Watch a training with many browsers and return the figures; raises SoakError."""
    rng = random.Random(seed)
    capture = folder / "capture"
    write_capture(capture, demo_capture(views=16, width=96, height=64, points=800))
    training = Training(capture, STEPS)
    training.complete(folder / "whole")
    run = folder / "run"
    process = subprocess.Popen(
        [*training.command(run), "--live", "--live-at", "127.0.0.1:0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    address = address_of(process)
    assert process.stdout is not None
    drain = threading.Thread(target=process.stdout.read)
    drain.start()
    watched = psutil.Process(process.pid)
    before, peak, made, most = use_of(watched), use_of(watched), 0, 0
    with sync_playwright() as playwright:
        browser = launched(playwright)
        open_pages: list[tuple[float, Page]] = []
        while process.poll() is None:
            now = time.monotonic()
            for leaves, page in [each for each in open_pages if each[0] < now]:
                page.close()
                open_pages.remove((leaves, page))
            if made < visits and len(open_pages) < browsers:
                page = browser.new_page(viewport={"width": 480, "height": 320})
                try:
                    page.goto(address)
                    made += 1
                except Error:  # the training has just ended
                    page.close()
                    continue
                open_pages.append((time.monotonic() + rng.uniform(*STAY), page))
                most = max(most, len(open_pages))
            else:
                time.sleep(0.1)
            try:
                peak = {key: max(peak[key], value) for key, value in use_of(watched).items()}
            except psutil.Error:
                break
        process.wait()
        drain.join()
        browser.close()
    if process.returncode:
        raise SoakError(f"the training ended with {process.returncode}")
    if digests(run) != digests(folder / "whole"):
        raise SoakError("the run with a live view differs")
    return {"visits": made, "at_once": most, "before": before, "peak": peak}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--browsers", type=int, default=10)
    parser.add_argument("--visits", type=int, default=40)
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = soak(Path(folder), options.browsers, options.visits)
        except SoakError as error:
            sys.exit(str(error))
    print(json.dumps(found, indent=1))
    add_record(options.json, "live", found)


if __name__ == "__main__":
    main()
