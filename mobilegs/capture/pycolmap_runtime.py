"""Loads pycolmap, and runs functions that call it in a process of their own.

pycolmap aborts its process when one of its checks fails, and may exhaust the memory. In another
process either one becomes an error message, and Ctrl-C does not wait for pycolmap.
"""

import importlib.util
import os
import pickle
import signal
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import IO, Any

from mobilegs.atomic import make_folder
from mobilegs.child_process import module_command
from mobilegs.errors import InputError
from mobilegs.extras import extra_module, not_installed
from mobilegs.progress_display import Advance

NEEDED = "computing camera poses needs pycolmap"
SEED = 0  # of all random choices
POLL_SECONDS = 0.25  # between two chances for Ctrl-C, which Windows does not deliver to a wait


@cache
def load_pycolmap() -> Any:
    """Return the module pycolmap. Raises InputError if it is not installed."""
    import PIL.Image  # noqa: F401  # first: with pycolmap's own zlib it aborts when it writes PNG

    pycolmap = extra_module("pycolmap", NEEDED, "capture")
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    return pycolmap


def validate_pycolmap() -> None:
    """Raise InputError if pycolmap is not installed. Does not load it."""
    if importlib.util.find_spec("pycolmap") is None:
        raise not_installed(NEEDED, "capture")


def threads() -> int:
    """Return the number of threads: OMP_NUM_THREADS, or -1 for all cores."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    return int(asked) if asked.isdigit() and int(asked) > 0 else -1


class PycolmapProcess:
    """A process that runs functions which call pycolmap; use it in a `with` block.

    It starts with the first call, and again after it has died, and is killed at the end of the
    block. It also ends when this process does, however that happens. The file `log` receives what
    pycolmap prints.
    """

    def __init__(self, log: Path) -> None:
        self._log = log
        self._process: subprocess.Popen[bytes] | None = None
        self._reader: Thread | None = None
        self._answers: SimpleQueue[tuple[str, Any] | None] = SimpleQueue()

    def call(
        self,
        doing: str,
        function: Callable[..., Any],
        *arguments: Any,
        progress: Advance | None = None,
        **options: Any,
    ) -> Any:
        """Return the result of `function(*arguments, **options)`, which runs in the process.

        Function, arguments and result must be picklable. With `progress` the function is given a
        `progress` of its own, whose calls are repeated here. Raises InputError if the function
        does, or if the process dies or runs out of memory; `doing` tells the user in which stage.
        """
        process = self._started()
        task = pickle.dumps((function, arguments, options, progress is not None))
        try:
            pickle.dump(task, _pipe(process.stdin))
            _pipe(process.stdin).flush()
        except OSError:  # it is dead, and the queue ends with None
            pass
        while True:
            answer = self._next_answer()
            if answer is None:
                code = process.wait()
                self._end()
                raise InputError(self._death(doing, code))
            kind, value = answer
            if kind == "progress" and progress is not None:
                progress(*value)
            elif kind == "result":
                return value
            elif kind == "refused":
                raise InputError(value)
            elif kind == "failed":
                raise InputError(f"pycolmap failed while {doing} ({value}): {self._advice()}")
            elif kind == "raised":
                raise RuntimeError(value)

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            make_folder(self._log.parent)
            command, environment = module_command("mobilegs.capture.pycolmap_worker")
            with self._log.open("ab") as log:
                self._process = subprocess.Popen(
                    command,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=log,
                    env=environment,
                )
            self._answers = SimpleQueue()
            arguments = (_pipe(self._process.stdout), self._answers)
            self._reader = Thread(target=_read_answers, args=arguments, daemon=True)
            self._reader.start()
        return self._process

    def _next_answer(self) -> tuple[str, Any] | None:
        while True:
            try:
                return self._answers.get(timeout=POLL_SECONDS)
            except Empty:
                continue

    def _death(self, doing: str, code: int) -> str:
        if code == -getattr(signal, "SIGKILL", 0):
            return (
                f"pycolmap was killed while {doing}, as happens when memory runs out: "
                f"{self._advice()}"
            )
        try:
            how = signal.Signals(-code).name
        except ValueError:  # Windows has no signals
            how = f"exit code {code}"
        return f"pycolmap crashed while {doing} ({how}): {self._advice()}"

    def _advice(self) -> str:
        return (
            "use fewer photos or smaller ones (`mobilegs capture --max-size 1000`); finished "
            f"stages are kept, and {self._log} has pycolmap's messages"
        )

    def __enter__(self) -> "PycolmapProcess":
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            if self._reader is not None:
                self._reader.join()
            _pipe(self._process.stdout).close()
            try:
                _pipe(self._process.stdin).close()
            except OSError:  # unsent bytes have no reader any more
                pass
            self._process = None


def _pipe(pipe: IO[bytes] | None) -> IO[bytes]:
    assert pipe is not None
    return pipe


def _read_answers(pipe: IO[bytes], answers: SimpleQueue[tuple[str, Any] | None]) -> None:
    """Move answers from the process to the queue, and None when it has ended."""
    try:
        while True:
            answers.put(pickle.load(pipe))
    except Exception:  # the end, or an answer that was cut off
        answers.put(None)
