"""Atomic writes, and reads that check the kind of the file first."""

import errno
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain, count
from pathlib import Path

from mobilegs.errors import InputError

HEAD = 64  # bytes that identify a format
FULL = os.strerror(errno.ENOSPC)


@contextmanager
def atomic_path(path: Path | str) -> Iterator[Path]:
    """Give a temporary path, which is renamed to `path` if the block succeeds.

    The temporary file is in the same folder and has the same suffix. On any exception, Ctrl-C
    included, it is removed and `path` stays as it was. Makes parent folders and follows links.
    Raises InputError if no file can be written at `path`, or the disk becomes full.
    """
    path = Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder")
    if path.exists() and not path.is_file():
        raise InputError(f"cannot write {path}: it is a device or a pipe")
    make_folder(path.parent)
    name = f".{path.stem[:50]}-"
    try:
        handle, name = tempfile.mkstemp(prefix=name, suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise InputError(f"cannot write {path}: {_reason(error)}") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)  # mkstemp makes private files, but outputs follow the umask
        temporary.replace(path)
    except Exception as error:  # libraries have errors of their own for a full disk
        if getattr(error, "errno", None) == errno.ENOSPC or FULL in str(error):
            raise InputError(f"cannot write {path}: the disk is full; make room") from error
        raise
    finally:
        temporary.unlink(missing_ok=True)


def make_folder(path: Path) -> None:
    """Make a folder and its parents, unless they exist. Raises InputError if it cannot."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {path}: {_reason(error)}") from error


def _reason(error: OSError) -> str:
    if isinstance(error, FileExistsError | NotADirectoryError):
        return "a file of that name exists"
    return (error.strerror or str(error)).lower()


def atomic_write(path: Path | str, content: bytes | str) -> None:
    """Write `content` to `path` atomically, text as UTF-8. Raises as `atomic_path`."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


def free_path(path: Path) -> Path:
    """Return the first of NAME, NAME-2, NAME-3, ... beside `path` that no file has."""
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
    return next(each for each in chain([path], numbered) if not each.exists())


def remove_unfinished(path: Path) -> None:
    """Remove temporary files of `path`, a pattern, that killed processes left.

    No process may write these files now.
    """
    random = "[a-z0-9_]" * 8  # as mkstemp makes them
    for left in path.parent.glob(f".{path.stem}-{random}{path.suffix}"):
        left.unlink(missing_ok=True)


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Raise InputError for a file that the block cannot read."""
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error


def file_size(path: Path) -> int:
    """Return the bytes in a regular file.

    Raises InputError if `path` does not exist, and for a folder, a device or a pipe, which could
    block or never end.
    """
    with reading(path):
        status = path.stat()
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"cannot read {path}: it is a folder, a device or a pipe")
    return status.st_size


def read_if(path: Path, starts: tuple[bytes, ...]) -> bytes:
    """Return all of a file if it begins with one of `starts`, else only its first 64 bytes.

    Raises as `file_size`.
    """
    file_size(path)
    with reading(path), path.open("rb", buffering=0) as file:
        head = file.read(HEAD)
        if not head.startswith(starts):
            return head
        file.seek(0)
        return file.readall()
