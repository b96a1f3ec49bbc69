"""Loads pycolmap, chooses its threads, and runs its calls so that Ctrl-C stops them."""

import os
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

from mobilegs.errors import InputError

INSTALL = "pip install 'mobilegs[capture]'"
SEED = 0  # of all random choices
POLL_SECONDS = 0.25
STOP_SECONDS = 20.0  # wait for a cancelled call; global mapping cannot be cancelled

Progress = Callable[[int, int], None]


@cache
def load_pycolmap() -> Any:
    """Return the module pycolmap. Raises InputError if it is not installed."""
    try:
        import pycolmap
    except ImportError:
        raise InputError(
            f"computing camera poses needs pycolmap, which is not installed: {INSTALL}"
        ) from None
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    return pycolmap


def threads() -> int:
    """Return the number of threads: OMP_NUM_THREADS, or -1 for all cores."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    return int(asked) if asked.isdigit() and int(asked) > 0 else -1


def in_background(call: Callable[[Any], Any], watch: Callable[[], None] = lambda: None) -> Any:
    """Run `call(token)` in another thread and return its result.

    pycolmap runs for minutes without handling signals. This thread calls `watch` every
    `POLL_SECONDS` and cancels the token on Ctrl-C. Exceptions of both functions are raised here.
    """
    token = load_pycolmap().CancellationToken()
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
            thread.join(POLL_SECONDS)
            watch()
    except BaseException:
        token.cancel()
        thread.join(STOP_SECONDS)
        raise
    if failures:
        raise failures[0]
    return results[0]
