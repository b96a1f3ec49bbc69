"""Files that appear whole or not at all, and reads that check the kind of the file first."""

import errno
import json
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from itertools import chain, count
from pathlib import Path
from typing import Any

from mobilegs.errors import InputError

HEAD = 64  # bytes that identify a format
FILE_MAX = 1 << 32  # bytes of a file that is read as a whole
TEXT_MAX = 1 << 26  # bytes of JSON and other text, which takes many times its size in memory
NO_FILE = "it is a folder, a device or a pipe"
# errors of a disk, which can come while a file is written; libraries give their texts only
DISK_ERRORS = {
    errno.ENOSPC: "the disk is full; make room",
    errno.EDQUOT: "your quota of the disk is used up; make room",
    errno.EFBIG: "the disk or a limit of this system allows no file of this size",
    errno.EROFS: "the disk can only be read",
    errno.EIO: "the disk has an error",
}


@contextmanager
def atomic_path(path: Path | str) -> Iterator[Path]:
    """Give a temporary path, which is renamed to `path` if the block succeeds.

    The temporary file is in the same folder and has the same suffix. On any exception, Ctrl-C
    included, it is removed and `path` stays as it was. Makes parent folders. A link at `path` is
    replaced, so the file to which it led stays as it was. Raises InputError if no file can be
    written at `path`, or the disk becomes full.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder")
    # /dev/stdout can lead to a file, but the link itself is the system's
    if (path.exists() and not path.is_file()) or path.absolute().parent == Path("/dev"):
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
    except InputError:
        raise
    except Exception as error:  # libraries have errors of their own for a full disk
        reason = disk_error(error)
        if not reason and getattr(error, "filename", None) == name:
            assert isinstance(error, OSError)
            reason = _reason(error)
        if reason:
            raise InputError(f"cannot write {path}: {reason}") from error
        raise
    finally:
        temporary.unlink(missing_ok=True)


def make_folder(path: Path) -> None:
    """Make a folder and its parents, unless they exist. Raises InputError if it cannot."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {path}: {_reason(error)}") from error


def refuse_links(*paths: Path) -> None:
    """Raise InputError if one of the program's own files or folders is a link.

    What is written or deleted there would be outside of the folder that the user gave.
    """
    for path in paths:
        if path.is_symlink():
            raise InputError(
                f"{path} is a link, so another place would change: put what it leads to in its "
                "place, or delete it"
            )


def disk_error(error: BaseException) -> str:
    """Return what is wrong with the disk if that is why an operation failed, else ''."""
    for number, reason in DISK_ERRORS.items():
        if getattr(error, "errno", None) == number or os.strerror(number) in str(error):
            return reason
    return ""


def _reason(error: OSError) -> str:
    if isinstance(error, FileExistsError | NotADirectoryError):
        return "a file of that name exists"
    return disk_error(error) or (error.strerror or str(error)).lower()


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


def open_input(path: Path | str) -> BufferedReader:
    """Open a regular file to read its bytes.

    Raises InputError if it cannot be opened, and for a folder, a device or a pipe, which could
    block or never end.
    """
    try:
        file = open(path, "rb", opener=_open_at_once)
    except IsADirectoryError as error:
        raise InputError(f"cannot read {path}: {NO_FILE}") from error
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        return file
    file.close()
    raise InputError(f"cannot read {path}: {NO_FILE}")


def _open_at_once(path: str, flags: int) -> int:
    """Open a file without waiting for the other end of a pipe."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0))


def file_size(path: Path | str) -> int:
    """Return the bytes in a regular file, before a library opens it. Raises as `open_input`."""
    with open_input(path) as file:
        return file.seek(0, os.SEEK_END)


def read_input(path: Path | str, most: int = FILE_MAX, starts: tuple[bytes, ...] = ()) -> bytes:
    """Return the content of a regular file of at most `most` bytes.

    With `starts`, a file that begins with none of them is read only up to its 64th byte. Raises
    InputError as `open_input`, for a larger file, and for a disk that cannot be read.
    """
    with open_input(path) as file:
        try:
            head = file.read(HEAD)
            if starts and not head.startswith(starts):
                return head
            size = file.seek(0, os.SEEK_END)
            if size <= most:
                file.seek(0)
                return file.read(size)
        except OSError as error:
            raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    raise InputError(f"{path} has {size:,} bytes, more than the {most:,} that are read")


def read_text(path: Path | str, most: int = TEXT_MAX) -> str:
    """Return the content of a text file in UTF-8, without a byte order mark.

    Raises InputError as `read_input`, and for other bytes.
    """
    try:
        return read_input(path, most).decode("utf-8-sig")  # Windows adds a byte order mark
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not text in UTF-8: see byte {error.start}") from error


def read_json(path: Path | str) -> Any:
    """Return the content of a JSON file. Raises InputError as `read_text`, and if it is none."""
    text = read_text(path)
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is not JSON ({error})") from error
