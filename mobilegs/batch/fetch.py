"""Sources at addresses (s3://, gs://, https://, ...): fetched once into a cache, by fsspec.

An address may hold secrets: a password, a token, a signature. Files, pages and messages have
`shown_address` in its place.
"""

import hashlib
import json
import os
import re
import shutil
from pathlib import Path, PurePosixPath
from typing import Any

from filelock import FileLock

from mobilegs.atomic import make_folder, refuse_links
from mobilegs.errors import InputError
from mobilegs.extras import not_installed

# names that filesystems give to a file's version
VERSIONS = (
    "size", "ETag", "etag", "md5Hash", "content_md5", "crc32c", "generation", "mtime",
    "LastModified", "last_modified", "updated", "created",
)  # fmt: skip


# of an address; a name with a colon that no port follows is a password with a slash in it
USER_INFO = re.compile(r"(?<=://)(?:[^/?#]*@|[^/?#:\[]*:(?!:|\d*(?:[/?#]|$)).*@)")
ADDRESS = re.compile(r"[^\s'\"<>(]+://[^\s'\"<>]*[^\s'\"<>:,.;)]")  # in a sentence
SHOWN = re.compile(r"[^?#]*\?\*\*\*[0-9a-f]{8}")  # an address without its secrets
HTTP = ("http://", "https://")


def is_address(source: str) -> bool:
    """Return True for an address that must be fetched; `file://` is a path."""
    return "://" in source and not source.lower().startswith("file://")


def shown_address(source: str) -> str:
    """Return an address with `?***` and a digest in place of user info, query and fragment.

    Addresses that differ there differ in the digest, except for passwords: those that a dictionary
    holds could be found from it. A path is returned as it is.
    """
    public, users, rest = _parted(source)
    if not is_address(source) or not (users or rest) or SHOWN.fullmatch(source):
        return source
    names = [user.partition(":")[0] for user in users]
    digest = hashlib.sha256(json.dumps([names, rest]).encode()).hexdigest()
    return f"{public}?***{digest[:8]}"


def without_secrets(text: str) -> str:
    """Return a message with `shown_address` in place of the addresses in it."""
    return re.sub(ADDRESS, lambda found: shown_address(found[0]), text)


def public_address(source: str) -> str:
    """Return an address without user info, query and fragment."""
    return _parted(source)[0]


def _parted(source: str) -> tuple[str, list[str], str]:
    """Return an address in parts: without secrets, its user infos, its query with the fragment."""
    public = USER_INFO.sub("", source)
    end = re.search(r"[?#]|$", public)
    assert end is not None
    return public[: end.start()], USER_INFO.findall(source), public[end.start() :]


def validate_address(source: str) -> None:
    """Raise InputError if nothing installed can read an address of its kind."""
    import fsspec

    protocol, shown = source.partition("://")[0], shown_address(source)
    try:
        fsspec.get_filesystem_class(protocol)
    except ValueError:
        raise InputError(f"{shown} has an unknown kind of address: '{protocol}'") from None
    except ImportError as error:
        if source.startswith(HTTP):
            raise not_installed(f"{shown} needs aiohttp", "batch") from None
        raise InputError(f"{shown} cannot be read here: {error}") from None


def fetch(source: str, cache: Path) -> Path:
    """Return the local copy of the file or folder at an address, which has the same name.

    The copy is made once for each content: it belongs to the address with the sizes, versions and
    times of its files. Several processes may fetch at the same time. Raises InputError if nothing
    is there or may be read, and OSError if it fails otherwise.
    """
    import fsspec

    validate_address(source)
    try:
        files, root = fsspec.core.url_to_fs(source)
        listing = _listing(files, root)
    except FileNotFoundError as error:
        cause = error.__cause__  # fsspec says that nothing is there whatever a server answers
        if not source.startswith(HTTP) or not isinstance(cause, Exception):
            cause = error
        raise _failure(source, cause) from None
    except InputError:
        raise
    except Exception as error:
        raise _failure(source, error) from None
    if not listing:
        raise InputError(f"there is nothing at {shown_address(source)}")
    target = cache / _key(source, listing)
    end = public_address(root) if root.startswith(HTTP) else root
    place = target / (PurePosixPath(end.rstrip("/")).name or "source")
    make_folder(cache)
    with FileLock(target.with_name(f".{target.name}.lock")):
        if not target.exists():
            part = target.with_name(f".{target.name}.part")
            refuse_links(part)
            shutil.rmtree(part, ignore_errors=True)
            for name in listing:
                local = part / place.name / name if name else part / place.name
                make_folder(local.parent)
                try:
                    files.get_file(f"{root.rstrip('/')}/{name}" if name else root, str(local))
                except Exception as error:
                    raise _failure(source, error) from None
            os.replace(part, target)
    return place


def _failure(source: str, error: Exception) -> Exception:
    """Return the error of a fetch that failed, without secrets.

    The message of a library can hold parts of the address in any form. It is passed on only if the
    address has no secrets.
    """
    shown, status = shown_address(source), getattr(error, "status", None)
    if isinstance(error, FileNotFoundError) or status in (404, 410):
        return InputError(f"there is nothing at {shown}")
    why = type(error).__name__
    if shown == source:
        why += f": {without_secrets(str(error))}"
    elif isinstance(status, int):
        why += f", status {status}"
    elif isinstance(error, OSError) and error.errno is not None:
        why += f": {os.strerror(error.errno)}"
    if isinstance(error, PermissionError) or status in (401, 403):
        return InputError(f"{shown} may not be read: {why}")
    return OSError(f"{shown} cannot be fetched: {why}")


def _listing(files: Any, root: str) -> dict[str, dict[str, Any]]:
    """Return what a filesystem tells of the files at `root`, by their names below it."""
    if root.startswith(HTTP):  # without folders: links of a page may lead anywhere
        found = {root: files.info(root)}
    else:
        found = files.find(root, detail=True)
    top = str(files._strip_protocol(root)).rstrip("/")
    listing = {}
    for path, about in found.items():
        name = str(path)[len(top) :].lstrip("/")
        if ".." in PurePosixPath(name).parts:
            raise InputError(f"{root} has a file '{name}', which would leave the cache")
        listing[name] = {key: str(about[key]) for key in VERSIONS if about.get(key) is not None}
    return listing


def _key(source: str, listing: dict[str, dict[str, Any]]) -> str:
    """Return a name for the content at an address."""
    text = json.dumps([shown_address(source), sorted(listing.items())])
    return hashlib.sha256(text.encode()).hexdigest()[:20]
