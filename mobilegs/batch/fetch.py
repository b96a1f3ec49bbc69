"""Sources at addresses (s3://, gs://, https://, ...): fetched once into a cache, by fsspec."""

import hashlib
import json
import os
import shutil
from pathlib import Path, PurePosixPath
from typing import Any

from filelock import FileLock

from mobilegs.atomic import make_folder, refuse_links
from mobilegs.errors import InputError

# names that filesystems give to a file's version
VERSIONS = (
    "size", "ETag", "etag", "md5Hash", "content_md5", "crc32c", "generation", "mtime",
    "LastModified", "last_modified", "updated", "created",
)  # fmt: skip


def is_address(source: str) -> bool:
    """Return True for an address that must be fetched; `file://` is a path."""
    return "://" in source and not source.startswith("file://")


def validate_address(source: str) -> None:
    """Raise InputError if nothing installed can read an address of its kind."""
    import fsspec

    protocol = source.partition("://")[0]
    try:
        fsspec.get_filesystem_class(protocol)
    except ValueError:
        raise InputError(f"{source} has an unknown kind of address: '{protocol}'") from None
    except ImportError as error:
        raise InputError(f"{source} cannot be read here: {error}") from None


def fetch(source: str, cache: Path) -> Path:
    """Return the local copy of the file or folder at an address, which has the same name.

    The copy is made once for each content: it belongs to the address with the sizes, versions and
    times of its files. Several processes may fetch at the same time. Raises InputError if nothing
    is there or may be read.
    """
    import fsspec

    validate_address(source)
    files, root = fsspec.core.url_to_fs(source)
    try:
        listing = _listing(files, root)
    except FileNotFoundError:
        listing = {}
    except PermissionError as error:
        raise InputError(f"{source} may not be read: {error}") from None
    if not listing:
        raise InputError(f"there is nothing at {source}")
    target = cache / _key(source, listing)
    place = target / (PurePosixPath(root.rstrip("/")).name or "source")
    make_folder(cache)
    with FileLock(target.with_name(f".{target.name}.lock")):
        if not target.exists():
            part = target.with_name(f".{target.name}.part")
            refuse_links(part)
            shutil.rmtree(part, ignore_errors=True)
            for name in listing:
                local = part / place.name / name if name else part / place.name
                make_folder(local.parent)
                files.get_file(f"{root.rstrip('/')}/{name}" if name else root, str(local))
            os.replace(part, target)
    return place


def _listing(files: Any, root: str) -> dict[str, dict[str, Any]]:
    """Return what a filesystem tells of the files at `root`, by their names below it."""
    top = str(files._strip_protocol(root)).rstrip("/")
    listing = {}
    for path, about in files.find(root, detail=True).items():
        name = str(path)[len(top) :].lstrip("/")
        if ".." in PurePosixPath(name).parts:
            raise InputError(f"{root} has a file '{name}', which would leave the cache")
        listing[name] = {key: str(about[key]) for key in VERSIONS if about.get(key) is not None}
    return listing


def _key(source: str, listing: dict[str, dict[str, Any]]) -> str:
    """Return a name for the content at an address."""
    text = json.dumps([source, sorted(listing.items())])
    return hashlib.sha256(text.encode()).hexdigest()[:20]
