"""Files that appear whole or not at all; files that are read only if they can be right."""

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mobilegs.errors import InputError

HEAD = 64  # bytes that tell what a file is


@contextmanager
def atomic_path(path: Path | str) -> Iterator[Path]:
    """A temporary path beside `path`, with its suffix, renamed to `path` if the block succeeds.

    On any exception, Ctrl-C included, the temporary file is removed and `path` is left as it
    was. Parent folders are made, links are followed. Raises InputError if that is no place for a
    file.
    """
    path = Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder")
    if path.exists() and not path.is_file():
        raise InputError(f"cannot write {path}: it is no file, but a device or a pipe")
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
        temporary.chmod(0o666 & ~mask)  # mkstemp makes private files; outputs follow the umask
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def make_folder(path: Path) -> None:
    """Make a folder, and those above it, unless it is there. InputError if that cannot be."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {path}: {_reason(error)}") from error


def _reason(error: OSError) -> str:
    if isinstance(error, FileExistsError | NotADirectoryError):
        return "there is a file in the way"
    return (error.strerror or str(error)).lower()


def atomic_write(path: Path | str, content: bytes | str) -> None:
    """Write `content` to `path` by way of a temporary file; text is UTF-8."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


def file_size(path: Path) -> int:
    """Bytes of a file that can be read: a pipe would be waited for, a device may never end.

    Raises InputError for what is no file, OSError where there is nothing.
    """
    found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"cannot read {path}: it is no file, but a folder, a device or a pipe")
    return found.st_size


def read_if(path: Path, starts: tuple[bytes, ...]) -> bytes:
    """All of a file that begins with one of `starts`, or else its first bytes alone.

    Raises like `file_size`.
    """
    file_size(path)
    with path.open("rb", buffering=0) as file:
        head = file.read(HEAD)
        if not head.startswith(starts):
            return head
        file.seek(0)
        return file.readall()
