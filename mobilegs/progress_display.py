"""The progress of long work, and notes: bars on a terminal, lines in a log.

Bars go to standard error, if that is a terminal. Lines go to standard output, if that is not a
terminal or if no bar is shown: one at the start of the work, one every 30 seconds, and one at its
end. A verb that prints data to standard output has its lines on standard error.

Modules log their notes (INFO) and warnings. `printed_log` prints them while a command runs.
"""

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from threading import Event, Thread
from typing import Protocol, runtime_checkable

from mobilegs.errors import printable

INTERVAL = 30.0  # seconds between two lines
Advance = Callable[[int, int], None]  # called with what is done and the total
# opens a piece of work by its title
Progress = Callable[[str], AbstractContextManager[Advance]]


def no_progress(title: str) -> AbstractContextManager[Advance]:
    """A `Progress` that shows nothing."""
    return nullcontext(lambda done, total: None)


@runtime_checkable
class TextStream(Protocol):
    """A text file such as `sys.stdout`."""

    def write(self, text: str, /) -> object: ...
    def flush(self) -> object: ...
    def isatty(self) -> bool: ...


def is_terminal(stream: TextStream | None) -> bool:
    """Return whether a stream is a terminal that can redraw its last line."""
    dumb = os.environ.get("TERM", "").lower() in ("dumb", "unknown")
    return stream is not None and stream.isatty() and not dumb


def shows_bars() -> bool:
    """Return whether progress bars are shown, which is on standard error."""
    return is_terminal(sys.stderr)


def line_stream(*, data: bool = False) -> TextStream | None:
    """Return the stream for lines of progress, or None if bars are enough.

    `data` says that standard output is for data, such as JSON.
    """
    if shows_bars() and (data or is_terminal(sys.stdout)):
        return None
    return sys.stderr if data else sys.stdout


def print_line(stream: TextStream | None, text: str) -> None:
    """Print a line at once, as `printable` has it.

    A full disk or a closed pipe does not stop the work.
    """
    if stream is None:
        return
    encoding = getattr(stream, "encoding", None) or "utf-8"
    with suppress(OSError, ValueError):
        stream.write(printable(text).encode(encoding, "replace").decode(encoding) + "\n")
        stream.flush()


class LineHandler(logging.Handler):
    """Prints warnings to standard error, and notes to standard output.

    Notes go to both if bars are shown and standard output is a file. Streams are looked up for each
    record, because a bar replaces them.
    """

    def __init__(self) -> None:
        super().__init__()
        self.to_both = shows_bars() and not is_terminal(sys.stdout)

    def emit(self, record: logging.LogRecord) -> None:
        warns = record.levelno >= logging.WARNING
        if not warns:
            print_line(sys.stdout, self.format(record))
        if warns or self.to_both:
            print_line(sys.stderr, self.format(record))


@contextmanager
def printed_log() -> Iterator[None]:
    """Print notes and warnings of all modules, as commands do."""
    log, handler = logging.getLogger("mobilegs"), LineHandler()
    level = log.level
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


def clock(seconds: float) -> str:
    """Return a time like 1:05 or 2:01:05."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


class ProgressLines:
    """The lines of a piece of work; use it in a `with` block.

    A thread prints them, so that work without updates has lines, too.
    """

    def __init__(
        self, title: str, stream: TextStream | None, *, ended: Event | None = None
    ) -> None:
        """Print to `stream`, or nothing if that is None. `ended` replaces the thread's timer."""
        self.title, self.stream = title, stream
        self._ended = ended or Event()
        self._thread: Thread | None = None
        self._done, self._total, self._status = 0, 0, ""
        self._first: tuple[int, float] | None = None  # the first update, and its time
        self._started = time.monotonic()

    def update(self, done: int, total: int, status: str = "") -> None:
        """Set how much is done. `status` replaces the time left."""
        again = self._first is not None and done < self._done
        self._done, self._total, self._status = done, total, status
        if again:
            self._print("started again")
        if again or self._first is None:
            self._first = (done, time.monotonic())

    def __enter__(self) -> "ProgressLines":
        self._started = time.monotonic()
        if self.stream is not None:
            self._print("started")
            self._thread = Thread(target=self._report, daemon=True)
            self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
        self._print(f"{'stopped after' if kind else 'finished in'} {self._elapsed()}")

    def _report(self) -> None:
        while not self._ended.wait(INTERVAL):
            if self._first is None:
                self._print(f"running for {self._elapsed()}")
                continue
            status = self._status or self._time_left(*self._first)
            text = f"{self._done:,} of {self._total:,} after {self._elapsed()}"
            self._print(f"{text}, {status}" if status else text)

    def _time_left(self, first: int, begun: float) -> str:
        done, total = self._done, self._total
        if not first < done < total:
            return ""
        return f"{clock((total - done) * (time.monotonic() - begun) / (done - first))} left"

    def _elapsed(self) -> str:
        return clock(time.monotonic() - self._started)

    def _print(self, text: str) -> None:
        print_line(self.stream, f"{self.title}: {text}")


@contextmanager
def show_progress(title: str, *, data: bool = False) -> Iterator[Advance]:
    """Show the progress of a piece of work; yields a function to call with done and total.

    `data` says that standard output is for data, such as JSON.
    """
    with ProgressLines(title, line_stream(data=data)) as lines:
        if not shows_bars():
            yield lines.update
            return
        with _bar(title) as advance:

            def update(done: int, total: int) -> None:
                lines.update(done, total)
                advance(done, total)

            yield update


@contextmanager
def _bar(title: str) -> Iterator[Advance]:
    from rich import progress as bars
    from rich.console import Console

    columns = (
        bars.TextColumn("{task.description}", markup=False),
        bars.BarColumn(),
        bars.MofNCompleteColumn(),
        bars.TimeRemainingColumn(),
    )
    # text for a file must not go to the terminal of the bar
    redirect = is_terminal(sys.stdout)
    console = Console(stderr=True)
    shown = bars.Progress(*columns, console=console, transient=True, redirect_stdout=redirect)
    with shown:
        task = shown.add_task(printable(title), total=None)
        yield lambda done, total: shown.update(task, completed=done, total=total)
