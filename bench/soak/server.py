"""Visit a served scene a thousand times: whole visits, aborted ones, slow ones, hostile ones.

    python -m bench.soak.server [--visits 1000] [--seed 0] [--json OUT]

`mobilegs view` runs in a process of its own, whose memory, threads and open files are watched.
Every answer is checked: scenes and scripts to the byte, refusals by their status.
"""

import argparse
import gzip
import json
import random
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import psutil

from bench.soak.record import add_record
from mobilegs.view.assets import viewer_script

VISITORS = 64  # at once
PATIENCE = 60.0  # seconds for an answer
SETTLE = 90.0  # seconds until the server has forgotten its last visitors
MIB = 1 << 20
TRICKS = (
    "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/scene/../../etc/passwd",
    "/..%2f..%2fetc%2fpasswd", "/scene%00.mgs", "/.%252e/etc/passwd", "/\\..\\..\\etc\\passwd",
    "/viewer.js/", "/" + "a" * 8000, "/scene?" + "b" * 8000, "http://[", "/scene/x/y/z",
)  # fmt: skip


@contextmanager
def served(scene: Path) -> Iterator[tuple[psutil.Process, int]]:
    """Serve a scene; yields the process and its port."""
    command = [sys.executable, "-m", "mobilegs", "view", str(scene), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if found := re.search(r"127\.0\.0\.1:(\d+)", line):
                break
        else:
            raise SystemExit("the server did not start")
        try:
            yield psutil.Process(process.pid), int(found[1])
        finally:
            process.terminate()


class Visitor:
    """Makes one visit of each kind; `content` and `script` are what the server must send."""

    def __init__(self, port: int, content: bytes) -> None:
        self.port, self.content, self.script = port, content, viewer_script().encode()

    def get(self, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
        """Ask for a path; return status, headers and body."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        try:
            connection.request("GET", path, headers=headers)
            answer = connection.getresponse()
            return answer.status, dict(answer.getheaders()), answer.read()
        finally:
            connection.close()

    def connect(self, request: str) -> socket.socket:
        """Open a connection and send the beginning of a request."""
        found = socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE)
        found.sendall(request.encode("latin-1"))
        return found

    def whole(self, rng: random.Random) -> None:
        """Load the page, its script and the scene."""
        status, headers, page = self.get("/?url=/scene", **{"Accept-Encoding": "gzip"})
        assert status == 200 and headers["Content-Encoding"] == "gzip"
        assert b"viewer.js" in gzip.decompress(page)
        assert self.get("/viewer.js")[2] == self.script
        assert self.get("/scene")[2] == self.content

    def aborted(self, rng: random.Random) -> None:
        """Leave in the middle of a transfer."""
        with self.connect("GET /scene HTTP/1.1\r\nHost: x\r\n\r\n") as connection:
            connection.recv(rng.randrange(1, 1 << 16))

    def slow(self, rng: random.Random) -> None:
        """Send a request byte by byte, and read the answer in small pieces."""
        with self.connect("GET /scene HTTP/1.1\r\n") as connection:
            for byte in b"Host: x\r\nConnection: close\r\n\r\n":
                connection.sendall(bytes([byte]))
                time.sleep(0.005)
            parts = []
            while part := connection.recv(1 << 14):
                parts.append(part)
                time.sleep(0.001)
        assert b"".join(parts).endswith(self.content)

    def silent(self, rng: random.Random) -> None:
        """Send half a request and go away."""
        with self.connect("GET /scene HT"):
            time.sleep(0.2 * rng.random())

    def parts(self, rng: random.Random) -> None:
        """Ask for a range: the answer is that range, or the whole file."""
        first = rng.randrange(len(self.content))
        last = rng.randrange(first, len(self.content))
        status, _, body = self.get("/scene", Range=f"bytes={first}-{last}")
        whole = self.content
        assert body == (whole[first : last + 1] if status == 206 else whole), status

    def hostile(self, rng: random.Random) -> None:
        """Ask for what is not served."""
        with self.connect(
            f"GET {rng.choice(TRICKS)} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
        ) as connection:
            parts = []
            while part := connection.recv(1 << 16):
                parts.append(part)
        answer = b"".join(parts)
        assert re.match(rb"HTTP/1.[01] (400|404|414) ", answer) or answer.endswith(self.content)
        assert b"root:" not in answer


KINDS = ("whole", "whole", "aborted", "slow", "silent", "parts", "hostile")


def use_of(process: psutil.Process) -> dict[str, float]:
    """Memory, threads and open files of a process."""
    with process.oneshot():
        return {
            "memory_mib": round(process.memory_info().rss / MIB, 1),
            "threads": process.num_threads(),
            "files": process.num_fds(),
        }


def soak(folder: Path, visits: int, seed: int, size: int = 4 * MIB) -> dict[str, Any]:
    """Visit a server and return what it used before, during and after, as JSON data.

    Raises AssertionError for a wrong answer.
    """
    scene = folder / "scene.mgs"
    scene.write_bytes(random.Random(seed).randbytes(size))  # the server does not look inside
    kinds: Counter[str] = Counter()
    with served(scene) as (process, port):
        visitor = Visitor(port, scene.read_bytes())
        visitor.whole(random.Random(0))
        peak = use_of(process)
        before, done, growth = dict(peak), threading.Event(), []

        def watch() -> None:
            while not done.wait(0.2):
                for name, value in use_of(process).items():
                    peak[name] = max(peak[name], value)

        def visit(number: int) -> None:
            rng = random.Random(f"{seed}-{number}")
            kind = rng.choice(KINDS)
            getattr(visitor, kind)(rng)
            kinds[kind] += 1

        watcher = threading.Thread(target=watch)
        watcher.start()
        try:
            with ThreadPoolExecutor(VISITORS) as pool:
                for quarter in range(4):
                    list(pool.map(visit, range(quarter, visits, 4)))
                    growth.append(use_of(process)["memory_mib"])
        finally:
            done.set()
            watcher.join()
        end = time.monotonic() + SETTLE
        while (after := use_of(process))["threads"] > before["threads"] and time.monotonic() < end:
            time.sleep(0.5)
        visitor.whole(random.Random(0))  # it still answers
    return {
        "visits": visits,
        "kinds": dict(sorted(kinds.items())),
        "before": before,
        "memory_mib_after_each_quarter": growth,
        "peak": peak,
        "after": after,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--visits", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = soak(Path(folder), options.visits, options.seed)
    print(json.dumps(found, indent=1))
    add_record(options.json, "server", found)


if __name__ == "__main__":
    main()
