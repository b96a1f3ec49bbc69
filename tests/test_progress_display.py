"""Progress as bars on a terminal, and as lines elsewhere."""

import io
import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from mobilegs import progress_display
from mobilegs.progress_display import INTERVAL, ProgressLines, clock, print_line

STAGE = """
import sys
from mobilegs.progress_display import show_progress
with show_progress("counting", data="--json" in sys.argv) as advance:
    advance(1, 2)
    advance(2, 2)
print('{"count": 2}')
"""
NOTES = """
import logging
from mobilegs.progress_display import printed_log, show_progress
log = logging.getLogger("mobilegs.module")
log.info("nobody asked")
log.warning("by default")
with printed_log(), show_progress("counting") as advance:
    advance(1, 2)
    log.info("a note of %d words", 5)
    log.warning("[a warning]")
    advance(2, 2)
"""
LINES = "counting: started\ncounting: finished in 0:00\n"
RESULT = '{"count": 2}\n'


class Timer(threading.Event):
    """A timer of a fake clock: before each wait of the thread ends, a function is called."""

    def __init__(self, now: list[float], *calls: Callable[[], None]) -> None:
        super().__init__()
        self.now, self.calls = now, [*calls]
        self.waits: list[float] = []
        self.called = threading.Event()

    def wait(self, timeout: float | None = None) -> bool:
        if self.calls and timeout is not None:
            self.waits.append(timeout)
            self.now[0] += timeout
            self.calls.pop(0)()
            return False
        self.called.set()
        return super().wait(60)


class Unread(io.StringIO):
    """A pipe that nobody reads any more."""

    def write(self, text: str, /) -> int:
        raise BrokenPipeError


@pytest.fixture
def now(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    seconds = [0.0]
    monkeypatch.setattr(progress_display.time, "monotonic", lambda: seconds[0])
    return seconds


def test_a_stage_has_a_line_at_its_start_every_30_seconds_and_at_its_end(now: list[float]) -> None:
    log = io.StringIO()

    def update(done: int, total: int) -> Callable[[], None]:
        return lambda: lines.update(done, total)

    timer = Timer(
        now, lambda: None, update(0, 128), update(32, 128), update(128, 128), update(0, 9)
    )
    lines = ProgressLines("finding features", log, ended=timer)
    with lines:
        assert timer.called.wait(60)
        for done in range(1, 9):
            lines.update(done, 9)
    assert timer.waits == [INTERVAL] * 5
    assert log.getvalue().splitlines() == [
        "finding features: started",
        "finding features: running for 0:30",
        "finding features: 0 of 128 after 1:00",
        "finding features: 32 of 128 after 1:30, 1:30 left",
        "finding features: 128 of 128 after 2:00",
        "finding features: started again",
        "finding features: 0 of 9 after 2:30",
        "finding features: finished in 2:30",
    ]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_a_stage_that_fails_does_not_finish(error: type[BaseException]) -> None:
    log = io.StringIO()
    with pytest.raises(error), ProgressLines("matching", log):
        raise error
    assert log.getvalue() == "matching: started\nmatching: stopped after 0:00\n"


def test_a_line_needs_neither_unicode_nor_a_reader() -> None:
    raw = io.BytesIO()
    ascii_only = io.TextIOWrapper(raw, encoding="ascii")
    print_line(ascii_only, "f\u00eate: started")
    assert raw.getvalue() == b"f?te: started\n"
    print_line(Unread(), "started")  # without an error


def test_hours_minutes_and_seconds() -> None:
    assert [clock(0.4), clock(65.0), clock(7265.0)] == ["0:00", "1:05", "2:01:05"]


# --- processes whose output is a terminal or none


def output_of(
    tmp_path: Path, terminals: str, *words: str, code: str = STAGE, **environment: str
) -> tuple[str, str]:
    """Return what a stage prints to standard output and to standard error.

    `terminals` names those of the two (`out`, `err`) that are terminals.
    """
    pty = pytest.importorskip("pty", reason="Windows has no pseudo-terminals")
    streams, readers = {}, {}
    for name in ("out", "err"):
        if name in terminals:
            readers[name], streams[name] = pty.openpty()
        else:
            streams[name] = os.open(tmp_path / name, os.O_RDWR | os.O_CREAT)
            readers[name] = os.open(tmp_path / name, os.O_RDONLY)
    own = {"TERM": "xterm", "FORCE_COLOR": "1", "PYTHONIOENCODING": "ascii", **environment}
    subprocess.run(
        [sys.executable, "-c", code, *words],
        stdout=streams["out"],
        stderr=streams["err"],
        env={**os.environ, **own},
        check=True,
    )
    printed = [_rest(readers[name], streams[name]) for name in ("out", "err")]
    return printed[0], printed[1]


def _rest(reader: int, stream: int) -> str:
    """Return what was written to a stream, as if it took no second; a terminal keeps kilobytes."""
    os.set_blocking(reader, False)
    try:
        text = os.read(reader, 1 << 16)
    except BlockingIOError:
        text = b""
    os.close(reader)
    os.close(stream)
    return re.sub(r"finished in \d+:\d\d", "finished in 0:00", text.decode().replace("\r\n", "\n"))


BAR = "2/2"  # of the screen of a terminal


@pytest.mark.parametrize(
    ("terminals", "words", "environment", "out", "err"),
    [
        ("", [], {}, LINES + RESULT, ""),
        ("err", [], {}, LINES + RESULT, BAR),
        ("out err", [], {}, RESULT, BAR),
        ("out", [], {}, LINES + RESULT, ""),  # a bar cannot be shown
        ("out err", [], {"TERM": "dumb"}, LINES + RESULT, ""),
        ("", ["--json"], {}, RESULT, LINES),  # data stays alone on standard output
        ("err", ["--json"], {}, RESULT, BAR),
    ],
)
def test_a_terminal_shows_a_bar_and_a_log_has_lines(
    tmp_path: Path,
    terminals: str,
    words: list[str],
    environment: dict[str, str],
    out: str,
    err: str,
) -> None:
    log, screen = output_of(tmp_path, terminals, *words, **environment)
    assert log == out
    assert ("counting" in screen and BAR in screen) if err == BAR else screen == err


def test_a_command_prints_notes_and_warnings_once_and_a_library_warnings(tmp_path: Path) -> None:
    begun, ended = LINES.splitlines(keepends=True)
    note, warnings = "a note of 5 words\n", "by default\n[a warning]\n"
    assert output_of(tmp_path, "", code=NOTES) == (begun + note + ended, warnings)
    log, screen = output_of(tmp_path, "err", code=NOTES)
    assert log == begun + note + ended
    assert screen.count(note.strip()) == screen.count("[a warning]") == 1
    log, screen = output_of(tmp_path, "out err", code=NOTES)
    assert log == ""
    assert screen.count(note.strip()) == screen.count("[a warning]") == 1
