"""Reads and writes 3DGS scenes as PLY, in the layout of INRIA's release.

One row per Gaussian: mean, (unused) normal, degree-0 SH `f_dc_*`, higher SH coefficients `f_rest_*`
channel by channel (all of red, then green, then blue), logit of the opacity, logarithms of the
scales, rotation wxyz. Axes are OpenCV's, those of the capture. `ply_compressed.py` reads files in
PlayCanvas's compressed layout.
"""

import collections
import itertools
import logging
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import torch

from mobilegs.atomic import atomic_path, file_size
from mobilegs.errors import InputError
from mobilegs.formats.ply_compressed import SH_DEGREES, Table, read_compressed
from mobilegs.gaussians import Gaussians
from mobilegs.render.project import BLUR, BLUR_MAX, CLASSIC, Footprint

log = logging.getLogger(__name__)

HEADER_MAX = 1 << 16  # bytes; a 3DGS header has about 1500
BYTE_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
MEANS = ["x", "y", "z"]
BASE_COLOR = ["f_dc_0", "f_dc_1", "f_dc_2"]
SCALES = ["scale_0", "scale_1", "scale_2"]
ROTATION = ["rot_0", "rot_1", "rot_2", "rot_3"]
COLUMNS = [*MEANS, *ROTATION, *SCALES, "opacity", *BASE_COLOR]  # in the order of reading
RENDER_MODES = ("default", "mip")
BLOCK = 1 << 22  # bytes of rows that are read at a time
# replace infinities, which other tools write for opacities of 0 and 1 and scales of 0
LOGIT_MAX, LOG_SCALE_MIN = 13.8, -69.0  # logit of 1 - 1e-6, logarithm of 1e-30


@dataclass(frozen=True)
class Element:
    """An element (table) of a PLY file: name, number of rows, columns."""

    name: str
    count: int
    columns: dict[str, str]  # name -> numpy type without byte order
    has_lists: bool = False

    def dtype(self, order: str) -> np.dtype:
        """Return the numpy type of a row in byte order `<`, `>` or `=`."""
        return np.dtype([(name, order + kind) for name, kind in self.columns.items()])


@dataclass(frozen=True)
class Header:
    """The header of a PLY file."""

    order: str
    ascii: bool
    elements: list[Element]
    length: int  # bytes up to the first number
    render_mode: str
    blur: float  # px^2


def read_ply_scene(path: Path | str) -> tuple[Gaussians, Footprint]:
    """Read a PLY as `read_ply` does, and how its Gaussians cover pixels.

    `SplatRenderMode: mip` and Postshot's `antialiased 1` are antialiased, with the blur of a
    comment `mobilegs blur`, or 0.3. Raises InputError as `read_ply`.
    """
    header, _ = _read_header(Path(path))
    return read_ply(path), Footprint(header.blur, antialiased=header.render_mode == "mip")


def _read_header(path: Path) -> tuple[Header, int]:
    """Return the header of a PLY and the size of the file in bytes."""
    try:
        size = file_size(path)
        with path.open("rb") as file:
            return parse_header(file.read(HEADER_MAX), path), size
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None


def read_ply(path: Path | str) -> Gaussians:
    """Read a 3DGS scene as float32 on the CPU.

    The file may be text, little- or big-endian, with properties in any order, or in PlayCanvas's
    compressed layout. Properties that 3DGS does not use are skipped; the SH degree (0 to 3)
    follows from the number of `f_rest_*`. Infinite logits of opacities, and logarithms of scales
    of 0, become large finite ones. Rows with other values that are not finite are left out, and
    counted in a logged warning.

    Raises:
        InputError: the file is missing, not a PLY, cut off, or lacks a property of 3DGS.
    """
    path = Path(path)
    header, size = _read_header(path)
    if header.render_mode not in RENDER_MODES:
        log.warning(
            "%s was made for the render mode %r; drawn as plain 3DGS it may look different",
            path,
            header.render_mode,
        )
    vertex, before = find_vertex(header, path)
    if "packed_position" in vertex.columns:
        with path.open("rb") as file:
            return read_compressed(file, tables_of(header, vertex, size, path), path)
    rest = check_properties(vertex, path)
    start = check_size(header, vertex, before, size, path)
    names = [*COLUMNS, *rest]
    with path.open("rb") as file:
        file.seek(start)
        if header.ascii:
            blocks = read_text(file, vertex, sum(e.count for e in before), names, path)
        else:
            blocks = read_binary(file, vertex, header.order, names)
        return gaussians_from_rows(blocks, vertex.count, rest, path)


def parse_header(head: bytes, path: Path) -> Header:
    """Parse the header at the start of `head`; `path` is used in messages.

    Raises InputError if it is not a complete PLY header.
    """
    if not re.match(rb"ply\r?\n", head):
        raise InputError(f"{path} is not a PLY file: it does not begin with 'ply'")
    end = re.search(rb"\nend_header\r?\n", head)
    if end is None:
        raise InputError(f"{path} has no complete PLY header in its first {HEADER_MAX} bytes")
    elements: list[Element] = []
    kind, mode, blur = "", "default", str(BLUR)
    for line in head[: end.start()].decode("ascii", "replace").splitlines()[1:]:
        match line.split():
            case ["format", kind, *_]:
                pass
            case ["comment", "SplatRenderMode:", mode, *_]:
                mode = mode.lower()
            case ["comment", "antialiased", "1"] | ["comment", "postshot.anti_aliasing=1"]:
                mode = "mip"  # as Postshot writes it
            case ["comment", "mobilegs", "blur", blur]:
                pass
            case ["element", name, count] if re.fullmatch(r"\d{1,18}", count):
                elements.append(Element(name, int(count), {}))
            case ["property", "list", *_] if elements:
                elements[-1] = Element(elements[-1].name, elements[-1].count, {}, True)
            case ["property", type_, name] if elements and type_ in TYPES:
                if name in elements[-1].columns:
                    raise InputError(f"{path} declares the property {name[:40]!r} twice")
                elements[-1].columns[name] = TYPES[type_]
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise InputError(f"{path} has a header line that is not PLY: {line[:40]!r}")
    if kind not in BYTE_ORDERS:
        raise InputError(f"{path} has the PLY format {kind[:40]!r}, which does not exist")
    if not re.fullmatch(r"\d*\.?\d+", blur) or not 0 < float(blur) <= BLUR_MAX:
        raise InputError(f"{path} names the blur {blur[:40]!r}: above 0 and at most 4 is possible")
    of = BYTE_ORDERS[kind], kind == "ascii", elements, end.end(), mode[:40], float(blur)
    return Header(*of)


def find_vertex(header: Header, path: Path) -> tuple[Element, list[Element]]:
    """Return the element `vertex`, one row per Gaussian, and the elements before it."""
    for index, element in enumerate(header.elements):
        if element.name == "vertex":
            before = header.elements[:index]
            if element.has_lists or (not header.ascii and any(e.has_lists for e in before)):
                raise InputError(
                    f"{path} has lists in or before its vertices: it is not a 3DGS scene"
                )
            return element, before
    raise InputError(f"{path} has no 'vertex' element: it is not a 3DGS scene")


def check_properties(vertex: Element, path: Path) -> list[str]:
    """Return the names of the `f_rest_*` properties. Raises InputError if a property is missing."""
    missing = [name for name in COLUMNS if name not in vertex.columns]
    if missing:
        raise InputError(f"{path} is not a 3DGS scene: its vertices lack {', '.join(missing)}")
    count = sum(name.startswith("f_rest_") for name in vertex.columns)
    rest = [f"f_rest_{i}" for i in range(count)]
    if count not in SH_DEGREES or any(name not in vertex.columns for name in rest):
        raise InputError(
            f"{path} has {count} f_rest properties, and a 3DGS scene has 0, 9, 24 or 45"
        )
    return rest


def check_size(
    header: Header, vertex: Element, before: list[Element], size: int, path: Path
) -> int:
    """Return the offset of the vertices (of all rows in a text file).

    Raises InputError if a file of `size` bytes is too small for them.
    """
    start = header.length
    if header.ascii:
        needed = max(0, 2 * vertex.count * len(vertex.columns) - 1)  # a digit and a separator each
    else:
        start += sum(e.count * e.dtype(header.order).itemsize for e in before)
        needed = vertex.count * vertex.dtype(header.order).itemsize
    if start + needed > size:
        raise cut_off(path, vertex.count)
    return start


def tables_of(header: Header, vertex: Element, size: int, path: Path) -> dict[str, Table]:
    """Return the place of each element in a binary file of `size` bytes.

    Raises InputError for a text file, for lists, and for a file that is too small.
    """
    if header.ascii or any(e.has_lists for e in header.elements):
        raise InputError(
            f"{path} is a compressed PLY as text or with lists, which is not supported"
        )
    tables, start = {}, header.length
    for element in header.elements:
        dtype = element.dtype(header.order)
        tables[element.name] = Table(start, element.count, dtype)
        start += element.count * dtype.itemsize
    if start > size or len(tables) < len(header.elements):
        raise cut_off(path, vertex.count)
    return tables


def read_binary(
    file: BinaryIO, vertex: Element, order: str, names: list[str]
) -> Iterator[np.ndarray]:
    """Yield the columns `names` of the vertices in blocks of rows, float32 `[m, len(names)]`."""
    dtype = vertex.dtype(order)
    block = max(1, BLOCK // dtype.itemsize)
    for first in range(0, vertex.count, block):
        yield columns(np.fromfile(file, dtype, min(block, vertex.count - first)), names)


def read_text(
    file: BinaryIO, vertex: Element, skipped: int, names: list[str], path: Path
) -> Iterator[np.ndarray]:
    """Do the same as `read_binary` for a text file, after `skipped` lines of other elements."""
    width, order = len(vertex.columns), list(vertex.columns)
    places = [order.index(name) for name in names]
    collections.deque(itertools.islice(file, min(skipped, sys.maxsize)), maxlen=0)
    block = max(1, BLOCK // (8 * width))
    for first in range(0, vertex.count, block):
        table = np.empty((min(block, vertex.count - first), width))
        for row in table:
            words = file.readline().split(None, width)
            if len(words) != width:
                raise cut_off(path, vertex.count)
            try:
                row[:] = [float(word) for word in words]
            except ValueError:
                raise InputError(
                    f"{path} has a value among its vertices that is not a number"
                ) from None
        with np.errstate(over="ignore"):  # doubles beyond float32 become infinite
            found = table[:, places].astype(np.float32)
        yield found


def cut_off(path: Path, count: int) -> InputError:
    """Return the error for a file that is shorter than its header says."""
    return InputError(f"{path} is cut off: its header announces {count} vertices; copy it again")


def gaussians_from_rows(
    blocks: Iterable[np.ndarray], count: int, rest: list[str], path: Path
) -> Gaussians:
    """Convert blocks of `COLUMNS` and `rest`, `count` rows in all; only finite rows are kept."""
    sizes = (3, 4, 3, 1, 3 + len(rest))  # columns per tensor
    parts = [np.empty((count, size), np.float32) for size in sizes]
    kept = 0
    for table in blocks:
        opacity, scales = table[:, 10], table[:, 7:10]
        opacity[np.isposinf(opacity)], opacity[np.isneginf(opacity)] = LOGIT_MAX, -LOGIT_MAX
        scales[np.isneginf(scales)] = LOG_SCALE_MIN
        table = table[np.isfinite(table).all(axis=1)]
        sh = table[:, 11:]
        # [m, 3, k] in the file, [m, k, 3] here
        by_channel = sh[:, 3:].reshape(len(sh), 3, len(rest) // 3)
        sh[:, 3:] = by_channel.swapaxes(1, 2).reshape(len(sh), len(rest))
        for part, values in zip(parts, np.split(table, np.cumsum(sizes)[:-1], axis=1), strict=True):
            part[kept : kept + len(table)] = values
        kept += len(table)
    if kept < count:
        lost = count - kept
        message = "%s: left out %d of %d Gaussians, which have values that are not finite"
        log.warning(message, path, lost, count)
    means, quats, log_scales, opacities, sh = (torch.from_numpy(part[:kept]) for part in parts)
    return Gaussians(means, quats, log_scales, opacities[:, 0], sh.unflatten(1, (-1, 3)))


def columns(rows: np.ndarray, names: list[str]) -> np.ndarray:
    """Return columns of a structured array as float32 `[n, len(names)]`."""
    kinds = {rows.dtype[name] for name in rows.dtype.names or ()}
    with np.errstate(over="ignore", invalid="ignore"):  # doubles beyond float32 become infinite
        if len(kinds) == 1:  # common, and 3x faster
            order = {name: index for index, name in enumerate(rows.dtype.names or ())}
            matrix = rows.view(kinds.pop()).reshape(len(rows), len(order))
            return matrix[:, [order[name] for name in names]].astype(np.float32)
        return np.stack([rows[name].astype(np.float32) for name in names], axis=1)


def write_ply(
    path: Path | str, gaussians: Gaussians, *, footprint: Footprint = CLASSIC, note: str = ""
) -> None:
    """Write a scene for sorted blending to a PLY; the file appears complete or not at all.

    The layout is INRIA's, little-endian float32. The header has the comments `SplatRenderMode:
    default` or, antialiased, `mip`, which other tools read, and `mobilegs blend sorted`. A blur
    other than 0.3 and `note`, a line of ASCII, become further comments. Other tools draw a blur of
    0.3. Raises InputError for a soft edge, which sorted blending does not have.
    """
    if footprint.soft_edge:
        raise InputError(f"cannot write {path}: sorted blending has no soft edge")
    count, coefficients = gaussians.sh.shape[:2]
    rest = [f"f_rest_{i}" for i in range(3 * (coefficients - 1))]
    normal = ["nx", "ny", "nz"]
    names = [*MEANS, *normal, *BASE_COLOR, *rest, "opacity", *SCALES, *ROTATION]
    parts = [
        gaussians.means,
        torch.zeros_like(gaussians.means),
        gaussians.sh[:, 0],
        gaussians.sh[:, 1:].transpose(1, 2).reshape(count, len(rest)),
        gaussians.logit_opacities[:, None],
        gaussians.log_scales,
        gaussians.quats,
    ]
    table = torch.cat([part.detach().cpu().float() for part in parts], dim=1).numpy()
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {count}",  # INRIA's viewer expects it in this line
        *(f"property float {name}" for name in names),
        f"comment SplatRenderMode: {'mip' if footprint.antialiased else 'default'}",
        "comment mobilegs blend sorted",
        *([f"comment mobilegs blur {footprint.blur:g}"] if footprint.blur != BLUR else []),
        *([f"comment mobilegs {note}"] if note else []),
        "end_header\n",
    ]
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write("\n".join(header).encode())
        file.write(table.astype("<f4", copy=False).tobytes())
