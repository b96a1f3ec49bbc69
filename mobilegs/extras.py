"""Packages of the extras of pip, which are imported where they are needed."""

from importlib import import_module
from typing import Any

from mobilegs.errors import InputError


def extra_module(name: str, needed: str, extra: str) -> Any:
    """Import a module of an extra; raises `not_installed` without it."""
    try:
        return import_module(name)
    except ImportError:
        raise not_installed(needed, extra) from None


def not_installed(needed: str, extra: str) -> InputError:
    """Return the error of a missing package; `needed` is like `a video needs PyAV`."""
    return InputError(f"{needed}, which is not installed: pip install 'mobilegs[{extra}]'")
