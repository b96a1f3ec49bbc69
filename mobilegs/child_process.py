"""Starts modules of this package as processes of their own."""

import os
import sys


def module_command(module: str) -> tuple[list[str], dict[str, str]]:
    """Return the command and the environment of a process that imports from where this one does."""
    paths = os.pathsep.join(path or os.getcwd() for path in sys.path)
    # -P: a file of the user's called random.py must not be imported
    return [sys.executable, "-P", "-m", module], {**os.environ, "PYTHONPATH": paths}
