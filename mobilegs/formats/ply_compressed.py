"""Reads PlayCanvas's compressed `.ply`: 16 bytes per Gaussian, and 1 byte per SH value.

A chunk of 256 Gaussians shares bounds of positions, log-scales and colours. `packed_*` are values
relative to these bounds: 11, 10 and 11 bits for positions and scales, 8 bits for each colour and
the opacity. A rotation has its three smaller components in 10 bits each. Axes and the order of SH
coefficients are those of a plain `.ply`. Source: https://github.com/playcanvas/splat-transform.
`ply.py` parses the header first.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.packed_gaussians import gaussians_in_blocks, logits_of, quats_of_smallest_three
from mobilegs.spherical_harmonics import C0

CHUNK = 256  # Gaussians; blocks of rows are multiples of it
BOUNDS = [f"{end}_{axis}" for end in ("min", "max") for axis in "xyz"]
SCALES = [f"{end}_scale_{axis}" for end in ("min", "max") for axis in "xyz"]
COLORS = [f"{end}_{channel}" for end in ("min", "max") for channel in "rgb"]  # optional
PACKED = ["packed_position", "packed_rotation", "packed_scale", "packed_color"]
SH_DEGREES = {0: 0, 9: 1, 24: 2, 45: 3}  # number of f_rest properties -> degree
SH_RANGE = 8.0  # of the values of a byte


@dataclass(frozen=True)
class Table:
    """The place of an element's rows in a file."""

    start: int
    count: int
    dtype: np.dtype

    def rows(self, file: BinaryIO, first: int, count: int) -> np.ndarray:
        """Read `count` rows from row `first` on, or as many as exist."""
        file.seek(self.start + first * self.dtype.itemsize)
        return np.fromfile(file, self.dtype, max(0, min(count, self.count - first)))


def read_compressed(file: BinaryIO, tables: dict[str, Table], path: Path) -> Gaussians:
    """Read the Gaussians of a compressed `.ply` as float32 on the CPU.

    `tables` has the elements by name, all of them within the file; `path` is used in messages.
    Gaussians that cannot be drawn are left out (`Gaussians.drawable`). Raises InputError if an
    element or property is missing, there are too few chunks, or none can be drawn.
    """
    vertex, chunk = tables["vertex"], tables.get("chunk")
    rest = _validate(vertex, chunk, tables.get("sh"), path)
    assert chunk is not None

    def decode(rows: slice) -> tuple[np.ndarray, ...]:
        first, length = rows.start, rows.stop - rows.start
        chunks = chunk.rows(file, first // CHUNK, -(-length // CHUNK))
        bounds = np.repeat(chunks, CHUNK)[:length]
        *others, base = _decoded(vertex.rows(file, first, length), bounds)
        sh = base[:, None]
        if rest:
            sh = np.concatenate([sh, _higher_sh(tables["sh"].rows(file, first, length), rest)], 1)
        return *others, sh

    return gaussians_in_blocks(vertex.count, len(rest) // 3 + 1, decode).drawable(path)


def _validate(vertex: Table, chunk: Table | None, sh: Table | None, path: Path) -> list[str]:
    """Return the names of the SH properties. Raises InputError if something is missing."""
    kinds = {name: vertex.dtype[name].str[1:] for name in vertex.dtype.names or ()}
    wrong = [name for name in PACKED if kinds.get(name) != "u4"]
    if wrong:
        raise InputError(f"{path} is not a compressed PLY: its vertices lack {wrong[0]} as uint")
    have = set(chunk.dtype.names or ()) if chunk else set()
    missing = [name for name in [*BOUNDS, *SCALES] if name not in have]
    if chunk is None or missing or 0 < len(have & set(COLORS)) < len(COLORS):
        raise InputError(f"{path} is not a compressed PLY: its chunks lack bounds")
    if chunk.count * CHUNK < vertex.count:
        raise InputError(f"{path} has {vertex.count} Gaussians, but only {chunk.count} chunks")
    if sh is None:
        return []
    names = list(sh.dtype.names or ())
    rest = [f"f_rest_{i}" for i in range(len(names))]
    if len(rest) not in SH_DEGREES or set(names) != set(rest) or sh.count < vertex.count:
        raise InputError(
            f"{path} has {sh.count} rows of {len(rest)} SH values, which do not fit its vertices"
        )
    if any(sh.dtype[name].str[1:] != "u1" for name in names):
        raise InputError(f"{path} has SH values that are not uchar: it is not a compressed PLY")
    return rest


def _decoded(rows: np.ndarray, bounds: np.ndarray) -> tuple[np.ndarray, ...]:
    """Decode rows, each with its chunk: means, quaternions, log-scales, logits, degree-0 SH."""
    means = _within(_fields(rows["packed_position"], (11, 10, 11)), bounds, BOUNDS)
    scales = _within(_fields(rows["packed_scale"], (11, 10, 11)), bounds, SCALES)
    colors = _fields(rows["packed_color"], (8, 8, 8, 8))
    rgb = colors[:, :3]
    if COLORS[0] in (bounds.dtype.names or ()):
        rgb = _within(rgb, bounds, COLORS)
    quats = _quaternions(rows["packed_rotation"])
    return means, quats, scales, logits_of(colors[:, 3]), (rgb - 0.5) / C0


def _fields(words: np.ndarray, bits: tuple[int, ...]) -> np.ndarray:
    """Return bit fields of words, the highest first, as `[n, len(bits)]` in [0, 1]."""
    shifts = [sum(bits[i + 1 :]) for i in range(len(bits))]
    each = zip(bits, shifts, strict=True)
    return np.stack([(words >> s & (1 << b) - 1) / ((1 << b) - 1) for b, s in each], axis=1)


def _within(shares: np.ndarray, bounds: np.ndarray, names: list[str]) -> np.ndarray:
    """Map [0, 1] to the range from the first three bounds in `names` to the last three."""
    low, high = (
        np.stack([bounds[name].astype(np.float64) for name in half], axis=1)
        for half in (names[:3], names[3:])
    )
    return low * (1 - shares) + high * shares


def _quaternions(words: np.ndarray) -> np.ndarray:
    """Decode rotations wxyz: two bits give the largest component, the other three follow."""
    small = (_fields(words & (1 << 30) - 1, (10, 10, 10)) - 0.5) * math.sqrt(2)
    return quats_of_smallest_three(small, (words >> 30).astype(np.int64))


def _higher_sh(rows: np.ndarray, names: list[str]) -> np.ndarray:
    """Decode SH above degree 0 `[n, k, 3]`: bytes are step middles, 0 and 255 ends."""
    bytes_ = np.stack([rows[name] for name in names], axis=1).astype(np.float32)
    shares = np.where(bytes_ == 0, 0, np.where(bytes_ == 255, 1, (bytes_ + 0.5) / 256))
    by_channel = ((shares - 0.5) * SH_RANGE).reshape(len(rows), 3, len(names) // 3)
    return by_channel.swapaxes(1, 2)
