"""An edit of a scene file: Gaussians that stay, notes that change, and the new file.

Codes and streams are carried over, never quantised again: the Gaussians that stay in a `.mgs`
decode to the same bits. A plain 3DGS scene keeps its numbers as well, and has no notes.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Bool, Int
from torch import Tensor

from mobilegs.atomic import atomic_path, free_path, open_input, read_input, read_text
from mobilegs.camera import Camera
from mobilegs.edit.camera_counts import count_cameras, floaters
from mobilegs.edit.notes import merged_notes
from mobilegs.edit.regions import Box, HalfSpace, Region
from mobilegs.errors import InputError
from mobilegs.formats import WRITTEN, Kind
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.mgs.container import MAGIC, VERSION, read_container, write_container
from mobilegs.mgs.limits import check_meta
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.progress_display import Advance
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene, size_of, write_gaussians

WRITTEN_SUFFIXES: dict[str, Kind] = {f".{kind}": kind for kind in WRITTEN}
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class SceneEdit:
    """An edit of a scene: the Gaussians that it removes, and the notes that it sets.

    A Gaussian stays if its mean lies in all of `keep` and in none of `remove`, and if no other
    field removes it.

    Attributes:
        keep: regions outside of which Gaussians are removed.
        remove: regions inside of which they are removed.
        rows: rows that are removed, in the order of the file; None for none.
        min_cameras: Gaussians that fewer cameras saw (`camera_counts.CameraCounts`) are removed.
        floaters: remove floaters (`camera_counts.floaters`).
        notes: notes by name, texts as `notes.py` writes them; an empty text removes a note.
    """

    keep: Sequence[Region] = ()
    remove: Sequence[Region] = ()
    rows: Int[Tensor, "m"] | None = None
    min_cameras: int = 0
    floaters: bool = False
    notes: Mapping[str, str] = field(default_factory=dict)

    @property
    def removes(self) -> bool:
        """True if the edit may remove Gaussians."""
        return bool(self.keep or self.remove or self.counts or self.rows is not None)

    @property
    def counts(self) -> bool:
        """True if the edit needs cameras, to count what they saw."""
        return bool(self.min_cameras or self.floaters)


@dataclass(frozen=True)
class EditReport:
    """The result of an edit.

    Attributes:
        count: number of Gaussians before.
        removed: number of those that each reason removed, by reason in words; a Gaussian counts
            for the first of them only.
        bytes_before, bytes_after: sizes of both files.
        notes: names of the notes that changed.
    """

    count: int
    removed: dict[str, int]
    bytes_before: int
    bytes_after: int
    notes: tuple[str, ...]

    @property
    def lines(self) -> list[str]:
        """The report in words, one sentence per line."""
        gone = sum(self.removed.values())
        lines = [f"{count:,} removed: {reason}" for reason, count in self.removed.items()]
        lines += [
            f"{self.count:,} Gaussians before, {self.count - gone:,} after "
            f"({100 * gone / self.count:.2f} % removed)",
            f"{self.bytes_before:,} bytes before, {self.bytes_after:,} after",
        ]
        return [*lines, f"notes set: {', '.join(self.notes)}"] if self.notes else lines


def edit_file(
    scene: Path,
    output: Path,
    edit: SceneEdit,
    *,
    cameras: Sequence[Camera] = (),
    camera_source: str = "",
    progress: Advance | None = None,
) -> EditReport:
    """Write an edited copy of a scene file to a new file, atomically.

    A `.mgs` becomes a `.mgs`; a plain 3DGS scene becomes the format that the output's suffix names.
    `cameras` are counted, or those of the file if there are none; `camera_source` says what they
    are. `progress` is called with the cameras that are counted and their number. Raises InputError
    if the output exists, no Gaussian would stay, or the scene cannot be read, has no cameras to
    count, or cannot hold the notes.
    """
    validate_output(scene, output)
    if scene.suffix.lower() == ".mgs":
        return _edit_mgs(scene, output, edit, cameras, camera_source, progress)
    if edit.notes:
        raise InputError(
            f"{scene} is not a .mgs and holds no notes ({', '.join(edit.notes)}): make a .mgs of "
            "it first (`mobilegs compress`)"
        )
    opened = open_scene(scene)
    keep, removed = _kept(opened, edit, list(cameras), camera_source, progress, scene)
    write_gaussians(
        output,
        opened.gaussians.select(keep),
        WRITTEN_SUFFIXES[output.suffix.lower()],
        footprint=opened.footprint,
        up=opened.up,
    )
    sizes = size_of(scene), size_of(output)
    return EditReport(len(opened.gaussians), removed, *sizes, notes=())


def validate_output(scene: Path, output: Path) -> None:
    """Raise InputError unless `output` is a new file of a format that the edited scene can have."""
    if output.exists():
        same = scene.exists() and output.samefile(scene)
        what = "the scene itself" if same else "already there"
        raise InputError(f"{output} is {what}, and an edit overwrites nothing: give another name")
    suffix = output.suffix.lower()
    if scene.suffix.lower() == ".mgs" and suffix != ".mgs":
        raise InputError(f"{output} does not end in .mgs: give the file such a name")
    if scene.suffix.lower() != ".mgs" and suffix not in WRITTEN_SUFFIXES:
        raise InputError(
            f"{output} does not end in {', '.join(WRITTEN_SUFFIXES)}: give the file such a name"
        )


def free_name(scene: Path) -> Path:
    """Return the first name beside the scene that no file has: scene-edited.mgs, -edited-2, ...

    A .splat and an unpacked .sog, which are only read, become a .ply.
    """
    suffix = scene.suffix.lower()
    suffix = suffix if suffix == ".mgs" or suffix in WRITTEN_SUFFIXES else ".ply"
    return free_path(scene.with_name(f"{scene.stem}-edited{suffix}"))


def kept_rows(scene: QuantizedScene, keep: Bool[Tensor, "n"]) -> QuantizedScene:
    """Return the scene with the Gaussians at `keep`, each in its LOD level, with the same codes.

    Levels that become empty are left out. Raises InputError if no Gaussian stays.
    """
    if not keep.any():
        raise InputError("no Gaussian would stay: keep at least one")
    sizes = [int(keep[rows].sum()) for rows in scene.lod_slices()]
    lod_sizes = tuple(size for size in sizes if size) if scene.lod_sizes else ()
    return replace(scene.select(keep.nonzero()[:, 0]), lod_sizes=lod_sizes)


def with_notes(data: bytes, changes: Mapping[str, str]) -> bytes:
    """Return the bytes of a `.mgs` with other notes and the same streams, which are not decoded.

    Raises InputError if the bytes are not a `.mgs`, or a file cannot hold the notes.
    """
    fields, streams = read_container(data)
    notes = fields.get("meta")
    merged = merged_notes(notes if isinstance(notes, dict) else {}, changes)
    check_meta(merged)
    present = {name: value for name, value in fields.items() if value is not None}
    # `lobes` is null where there are none; `layers` and `footprint` are missing there
    header = present | {"lobes": fields.get("lobes"), "meta": merged}
    return write_container(header, list(streams.values()), major=VERSION.unpack_from(data, 8)[0])


def _edit_mgs(
    path: Path,
    output: Path,
    edit: SceneEdit,
    cameras: Sequence[Camera],
    camera_source: str,
    progress: Advance | None,
) -> EditReport:
    data = read_input(path, starts=(MAGIC,))
    try:
        count = inspect(data)["gaussians"]
        coded = decode_mgs(data) if edit.removes else None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    removed: dict[str, int] = {}
    edited = data
    if coded is not None:
        opened = coded.decode()
        used = list(cameras) or coded.views
        source = camera_source if cameras else f"the {len(used)} cameras that the file stores"
        keep, removed = _kept(opened, edit, used, source, progress, path)
        if not keep.all():
            edited = encode_mgs(kept_rows(coded, keep))
    if edit.notes:
        edited = with_notes(edited, edit.notes)
    with atomic_path(output) as temporary:
        temporary.write_bytes(edited)
    sizes = len(data), len(edited)
    return EditReport(count, removed, *sizes, notes=tuple(edit.notes))


def _kept(
    scene: Scene,
    edit: SceneEdit,
    cameras: list[Camera],
    camera_source: str,
    progress: Advance | None,
    path: Path,
) -> tuple[Bool[Tensor, "n"], dict[str, int]]:
    """Return which Gaussians stay, and how many each reason removed."""
    gaussians = scene.gaussians
    means = gaussians.means
    reasons = [(f"outside of {_told(r)}", ~r.contains(means)) for r in edit.keep]
    reasons += [(_placed(r), r.contains(means)) for r in edit.remove]
    if edit.rows is not None:
        reasons.append(("selected", _mask_of(edit.rows, len(gaussians))))
    if edit.counts:
        if not cameras:
            raise InputError(
                f"{path} has no cameras to count: give --capture CAPTURE, photos with poses"
            )
        counts = count_cameras(scene, cameras, progress=progress)
        if edit.min_cameras > counts.cameras:
            raise InputError(
                f"{edit.min_cameras} cameras cannot have seen a Gaussian: there are only "
                f"{counts.cameras} ({camera_source})"
            )
        if edit.min_cameras:
            reason = f"seen by fewer than {edit.min_cameras} of {counts.cameras} cameras"
            reasons.append((f"{reason} ({camera_source})", counts.seen < edit.min_cameras))
        if edit.floaters:
            reasons.append((f"floaters ({camera_source})", floaters(counts)))
    keep = torch.ones(len(gaussians), dtype=torch.bool)
    removed = {}
    for reason, mask in reasons:
        removed[reason] = removed.get(reason, 0) + int((keep & mask).sum())
        keep &= ~mask
    if not keep.any():
        told = "; ".join(f"{number:,} {reason}" for reason, number in removed.items())
        raise InputError(f"no Gaussian of {path} would stay: {told}")
    return keep, removed


def _mask_of(rows: Int[Tensor, "m"], count: int) -> Bool[Tensor, "n"]:
    if len(rows) and not 0 <= int(rows.min()) <= int(rows.max()) < count:
        raise InputError(f"rows to remove must lie between 0 and {count - 1}")
    mask = torch.zeros(count, dtype=torch.bool)
    mask[rows.long()] = True
    return mask


def read_rows(path: Path) -> Int[Tensor, "m"]:
    """Return row numbers from a text of integers, or a .npy of integers or of booleans (a mask).

    Raises InputError for any other file.
    """
    try:
        if path.suffix.lower() == ".npy":
            with open_input(path) as file:
                rows = np.lib.format.read_array(file, allow_pickle=False)
            rows = rows.nonzero()[0] if rows.dtype == bool and rows.ndim == 1 else rows
        else:
            rows = np.array([int(word) for word in read_text(path).split()], np.int64)
    except InputError:
        raise
    except (ValueError, EOFError, OverflowError):
        rows = np.zeros(0)
    if rows.ndim != 1 or not np.issubdtype(rows.dtype, np.integer):
        raise InputError(f"{path} does not hold row numbers: one integer per line is needed")
    return torch.from_numpy(rows.astype(np.int64))


def _told(region: Region) -> str:
    return "the box" if isinstance(region, Box) else "the sphere"


def _placed(region: Region) -> str:
    if isinstance(region, HalfSpace):
        return "below the plane"
    return f"inside {_told(region)}"
