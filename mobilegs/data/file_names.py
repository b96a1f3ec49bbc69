"""Finds the files of a capture under the names that other programs and systems give them."""

import difflib
import logging
import os
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import islice, product, takewhile
from pathlib import Path
from posixpath import normpath
from typing import NamedTuple
from urllib.parse import unquote

from mobilegs.data import images
from mobilegs.errors import InputError, quoted

FILES_MAX = 1 << 18  # files of a folder that are looked through
# a photo may lie here as another file than the listed one
SOURCES = (*images.SUFFIXES, ".heic", ".heif", ".dng", ".cr2", ".cr3", ".nef", ".arw", ".exr")
# folders whose files often have the names of photos: reduced, undistorted, masks, depth, ...
NOT_PHOTOS = re.compile(
    r"images?_\d+|dense|undistorted|.*(mask|depth|normal|segment|semantic|confidence|thumb|preview).*"
)
DRIVE = re.compile(r"[A-Za-z]:")
log = logging.getLogger(__name__)


class _Entry(NamedTuple):
    """A file: its folders as compared, its suffix as compared, and its path."""

    folders: tuple[str, ...]
    suffix: str
    path: Path


class Folder:
    """The files below a folder, which are found by their names. The index is built once.

    No name leads out of the folder. Links in the folder are followed.
    """

    def __init__(self, root: Path) -> None:
        self.root = root

    def find(self, name: str, *, photo: bool = False, loose: bool = False) -> Path | None:
        """Return the file that is called `name`, or None if there is none or more than one.

        Backslashes, another case or Unicode form and percent-encoding are read. Of an absolute
        path from another machine the longest ending counts that is a file here. A `photo` may
        have another suffix, none, or more folders in its name than here. With `loose` it may also
        lie in subfolders that its name does not have.
        """
        if not leads_out(name) and images.is_file(self.root / name):
            return self.root / name
        for spelled in dict.fromkeys((name, unquote(name))):
            ranked = sorted(self._ranked(spelled, photo, loose), reverse=True)
            if ranked and (len(ranked) == 1 or ranked[0][0] > ranked[1][0]):
                return ranked[0][1]
        return None

    def _ranked(self, name: str, photo: bool, loose: bool) -> Iterator[tuple[tuple, Path]]:
        """Yield the files that `name` may mean, with a rank that is larger for likelier ones."""
        *folders, file = _parts(name)
        stem, suffix = _split(file)
        for entry in self._index.get(stem, ()):
            ends = zip(reversed(folders), reversed(entry.folders), strict=False)
            shared = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], ends))
            above = entry.folders[: len(entry.folders) - shared]
            if above and (not loose or any(map(NOT_PHOTOS.fullmatch, above))):
                continue
            same = entry.suffix == suffix
            if photo and (same or entry.suffix in images.SUFFIXES):
                other = 0 if same else images.SUFFIXES.index(entry.suffix)
                yield (shared, not above, same, -other), entry.path
            elif same and (shared == len(folders) or leads_out(name)):
                yield (shared, True, True, 0), entry.path

    def find_all(self, names: Sequence[str], *, loose: bool = False) -> dict[str, Path]:
        """Return the photos that are found, by their names; none is found for two of them."""
        found = {n: self.find(n, photo=True, loose=loose) for n in names}
        uses = Counter(found.values())
        return {n: f for n, f in found.items() if f and (uses[f] == 1 or f == self.root / n)}

    def nearest(self, name: str) -> str | None:
        """Return the file whose name is most like `name`, relative to this folder."""
        files = {e.path.name: e.path for entries in self._index.values() for e in entries}
        close = difflib.get_close_matches(name.replace("\\", "/").split("/")[-1], files, 1, 0.5)
        return files[close[0]].relative_to(self.root).as_posix() if close else None

    @cached_property
    def _index(self) -> dict[str, list[_Entry]]:
        index: dict[str, list[_Entry]] = {}
        for path in islice(walk_files(self.root), FILES_MAX):
            *folders, file = _parts(path.relative_to(self.root).as_posix())
            stem, suffix = _split(file)
            if file:
                index.setdefault(stem, []).append(_Entry(tuple(folders), suffix, path))
        return index


def walk_files(root: Path) -> Iterator[Path]:
    """Yield the files below a folder, links followed but no folder twice, none of hidden ones."""
    seen = set()
    for folder, below, files in os.walk(root, followlinks=True):
        real = os.path.realpath(folder)
        below[:] = [] if real in seen else sorted(n for n in below if not n.startswith("."))
        if real not in seen:
            yield from (Path(folder, file) for file in sorted(files) if not file.startswith("."))
        seen.add(real)


def _parts(name: str) -> list[str]:
    """Return the folders and the file of a name as they are compared."""
    path = DRIVE.sub("", unicodedata.normalize("NFC", name).replace("\\", "/"), count=1)
    parts = normpath(path).casefold().split("/")
    return [part for part in parts if part not in ("", ".", "..")] or [""]


def _split(file: str) -> tuple[str, str]:
    """Return the stem and the suffix of a photo; `0001.png.png` has the stem `0001`."""
    stem, suffix = file, ""
    while (end := os.path.splitext(stem))[1] in SOURCES:
        stem, suffix = end[0], suffix or end[1]
    return stem, suffix


def leads_out(name: str) -> bool:
    """Return whether a name is an absolute path, or has `..` among its folders."""
    path = name.replace("\\", "/")
    return path.startswith("/") or bool(DRIVE.match(path)) or ".." in path.split("/")


class Photos(NamedTuple):
    """The photos of a capture: the folder in which they are, and the file of each listed name."""

    folder: Folder
    files: dict[str, Path]


def find_photos(
    capture: Path, folders: Sequence[Path], names: Sequence[str], source: Path
) -> Photos:
    """Return the photos that `source` names, from the folder of `folders` that holds most.

    The first folder that holds more than half of them is taken. Raises `InputError` if a name leads
    to a file outside of the capture.
    """
    inside = [Folder(folder) for folder in folders if folder.is_dir()] or [Folder(capture)]
    best, guessed = Photos(inside[-1], {}), False
    for loose, folder in product((False, True), inside):
        files = folder.find_all(names, loose=loose)
        if len(files) > len(best.files):
            best, guessed = Photos(folder, files), loose
        if 2 * len(best.files) > len(names):
            break
    _refuse_outside(best.folder.root, names if guessed else set(names) - best.files.keys(), source)
    renamed = [name for name, file in best.files.items() if guessed or _other_suffix(name, file)]
    if renamed:
        file = best.files[renamed[0]].relative_to(best.folder.root).as_posix()
        log.warning(
            "%d photos that %s lists have other names in %s: %s is %s there, for example",
            len(renamed),
            source,
            best.folder.root,
            quoted(renamed[0]),
            quoted(file),
        )
    _report_links(capture, list(best.files.values()))
    return best


def _other_suffix(name: str, file: Path) -> bool:
    (_, listed), (_, own) = (_split(_parts(each)[-1]) for each in (name, file.name))
    return listed not in ("", own)


def _refuse_outside(root: Path, names: Iterable[str], source: Path) -> None:
    """Raise InputError for a name that leads from `root` to a file outside."""
    for name in names:
        target = Path(os.path.normpath(root / name.replace("\\", "/")))
        if root not in target.parents and images.is_file(target):
            raise InputError(
                f"{source} names the file {quoted(name)}, which is outside of {root}; copy the "
                "photos into the capture, or link their folder there"
            )


def _report_links(capture: Path, files: Sequence[Path]) -> None:
    """Say which photos are not in the capture but behind links in it."""
    home = Path(os.path.realpath(capture))
    targets = [Path(os.path.realpath(file)) for file in files]
    outside = [pair for pair in zip(files, targets, strict=True) if home not in pair[1].parents]
    if outside:
        log.warning(
            "%d photos of %s lie outside of it, behind links: %s is %s, for example",
            len(outside),
            capture,
            quoted(outside[0][0].relative_to(capture).as_posix()),
            quoted(str(outside[0][1])),
        )


def report_missing(
    folder: Folder, files: Mapping[str, Path], names: Sequence[str], source: Path
) -> None:
    """Say which of `names` have no file in the folder, as `source` lists them.

    Raises `InputError` if it is half of them or more.
    """
    gone = [name for name in names if name not in files]
    if not gone:
        return
    if 2 * len(gone) >= len(names):
        near = folder.nearest(gone[0])
        hint = f" (the nearest file found is {quoted(near)})" if near else ""
        raise InputError(
            f"{folder.root} lacks {len(gone)} of the {len(names)} photos that {source} lists, such "
            f"as {quoted(gone[0])}{hint}; put them back, or compute the poses without them"
        )
    shown = ", ".join(quoted(name) for name in gone[:3]) + (", ..." if len(gone) > 3 else "")
    log.warning(
        "%d of %d photos that %s lists are not in %s and are left out: %s",
        len(gone),
        len(names),
        source,
        folder.root,
        shown,
    )


def reduced_photos(
    folder: Path, sizes: Mapping[str, tuple[int, int]], downscale: int | None
) -> dict[str, Path] | None:
    """Return the photos in `images_4/` next to `folder`, `images/`, for a `downscale` of 4.

    `sizes` has width and height of the whole photos by name. None if there is no such folder, or if
    it lacks a photo by name or has one of another size.
    """
    reduced = folder.with_name(f"{folder.name}_{downscale}")
    if downscale is None or downscale == 1 or not reduced.is_dir():
        return None
    files = Folder(reduced).find_all(list(sizes))
    lost = [name for name in sizes if name not in files]
    if not lost:
        lost = [name for name, size in sizes.items() if not _fits(files[name], size, downscale)]
        if not lost:
            return files
    log.warning(
        "%s is not used: %d of %d photos are not there by name and size, such as %s",
        reduced,
        len(lost),
        len(sizes),
        quoted(lost[0]),
    )
    return None


def _fits(file: Path, whole: tuple[int, int], downscale: int) -> bool:
    """Return whether a photo has the size of a `whole` one divided by `downscale`, turned or not.

    Sides may be rounded up or down.
    """
    sides = zip(sorted(images.image_size(file)), sorted(whole), strict=True)
    return all(abs(side - full / downscale) < 1.01 for side, full in sides)
