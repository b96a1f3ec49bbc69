"""pycolmap: quiet, on as many threads as asked for, and stopped by Ctrl-C."""

import os
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

from mobilegs.errors import InputError

INSTALL = "pip install 'mobilegs[capture]'"
SEED = 0  # of everything that draws at random
WATCH_EVERY = 0.25  # seconds
PATIENCE = 20.0  # seconds that work in the background has to stop; global mapping cannot be told

Progress = Callable[[int, int], None]


@cache
def engine() -> Any:
    """The module pycolmap; InputError with one sentence where it is missing."""
    try:
        import pycolmap
    except ImportError:
        raise InputError(
            f"finding out where photos were taken needs pycolmap, which is not installed: {INSTALL}"
        ) from None
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    return pycolmap


def threads() -> int:
    """How many threads to use: what OMP_NUM_THREADS says, or -1 for all cores."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    return int(asked) if asked.isdigit() and int(asked) > 0 else -1


def in_background(call: Callable[[Any], Any], watch: Callable[[], None] = lambda: None) -> Any:
    """What `call` returns, while `watch` is called now and then from this thread.

    pycolmap works for minutes without looking at signals, so `call` runs in another thread.
    It is given a cancellation token, which Ctrl-C sets; what it raises is raised here.
    """
    token = engine().CancellationToken()
    results: list[Any] = []
    failures: list[BaseException] = []

    def work() -> None:
        try:
            results.append(call(token))
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=work, name="pycolmap", daemon=True)
    thread.start()
    try:
        while thread.is_alive():
            thread.join(WATCH_EVERY)
            watch()
    except BaseException:
        token.cancel()
        thread.join(PATIENCE)
        raise
    if failures:
        raise failures[0]
    return results[0]
