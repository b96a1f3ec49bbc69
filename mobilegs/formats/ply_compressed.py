"""Compressed `.ply`, as PlayCanvas has it: 16 bytes a Gaussian and a byte a harmonic.

A chunk of 256 Gaussians shares the bounds of its positions, logarithms of scales and colours;
`packed_*` are places between them: 11, 10 and 11 bits for positions and scales, the three smaller
parts of a rotation in 10 bits each, a byte for each colour and for the opacity. Axes and the order
of harmonics are those of a plain `.ply`. The layout's facts are those of
github.com/playcanvas/splat-transform; `ply.py` has read the header before it comes here.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import torch

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import C0

CHUNK = 256  # Gaussians
BLOCK = 128 * CHUNK  # Gaussians that are decoded at a time
BOUNDS = [f"{end}_{axis}" for end in ("min", "max") for axis in "xyz"]
SCALES = [f"{end}_scale_{axis}" for end in ("min", "max") for axis in "xyz"]
COLORS = [f"{end}_{channel}" for end in ("min", "max") for channel in "rgb"]  # since 2024
PACKED = ["packed_position", "packed_rotation", "packed_scale", "packed_color"]
SH_DEGREES = {0: 0, 9: 1, 24: 2, 45: 3}  # number of f_rest properties -> degree
HARMONIC = 8.0  # the range of a harmonic in a byte
CLEAR = 1e-6  # 0 and 255 are no logits; both stay as good as invisible and opaque


@dataclass(frozen=True)
class Table:
    """Where the rows of an element are in a file."""

    start: int
    count: int
    dtype: np.dtype

    def rows(self, file: BinaryIO, first: int, count: int) -> np.ndarray:
        """Some rows, as many as there are."""
        file.seek(self.start + first * self.dtype.itemsize)
        return np.fromfile(file, self.dtype, max(0, min(count, self.count - first)))


def read_compressed(file: BinaryIO, tables: dict[str, Table], path: Path) -> Gaussians:
    """The Gaussians of a compressed `.ply`, float32 on the CPU; what is not finite is left out.

    `tables` are its elements by name, all of which lie within the file; `path` is for messages.

    Raises:
        InputError: an element or a property is missing, or there are too few chunks.
    """
    vertex, chunk = tables["vertex"], tables.get("chunk")
    rest = _check(vertex, chunk, tables.get("sh"), path)
    assert chunk is not None
    count = vertex.count
    shapes = [(count, 3), (count, 4), (count, 3), (count,), (count, len(rest) // 3 + 1, 3)]
    found = [np.empty(shape, np.float32) for shape in shapes]
    for first in range(0, count, BLOCK):
        rows = vertex.rows(file, first, BLOCK)
        chunks = chunk.rows(file, first // CHUNK, -(-len(rows) // CHUNK))
        block = slice(first, first + len(rows))
        with np.errstate(all="ignore"):  # what is not finite is left out in the end
            decoded = _decoded(rows, np.repeat(chunks, CHUNK)[: len(rows)])
            for whole, values in zip(found[:4], decoded, strict=False):
                whole[block] = values
            found[4][block, 0] = decoded[4]
        if rest:
            found[4][block, 1:] = _harmonics(tables["sh"].rows(file, first, len(rows)), rest)
    return Gaussians(*(torch.from_numpy(whole) for whole in found)).finite(path)


def _check(vertex: Table, chunk: Table | None, sh: Table | None, path: Path) -> list[str]:
    """Names of the harmonics, once all that is needed is known to be there."""
    kinds = {name: vertex.dtype[name].str[1:] for name in vertex.dtype.names or ()}
    wrong = [name for name in PACKED if kinds.get(name) != "u4"]
    if wrong:
        raise InputError(f"{path} is no compressed PLY: its vertices lack {wrong[0]} as uint")
    have = set(chunk.dtype.names or ()) if chunk else set()
    lost = [name for name in [*BOUNDS, *SCALES] if name not in have]
    if chunk is None or lost or 0 < len(have & set(COLORS)) < len(COLORS):
        raise InputError(f"{path} is no compressed PLY: its chunks lack bounds")
    if chunk.count * CHUNK < vertex.count:
        raise InputError(f"{path} has {vertex.count} Gaussians, but only {chunk.count} chunks")
    if sh is None:
        return []
    names = list(sh.dtype.names or ())
    rest = [f"f_rest_{i}" for i in range(len(names))]
    if len(rest) not in SH_DEGREES or set(names) != set(rest) or sh.count < vertex.count:
        raise InputError(f"{path} has {sh.count} rows of {len(rest)} harmonics: they do not fit")
    if any(sh.dtype[name].str[1:] != "u1" for name in names):
        raise InputError(f"{path} has harmonics that are no bytes: it is no compressed PLY")
    return rest


def _decoded(rows: np.ndarray, bounds: np.ndarray) -> tuple[np.ndarray, ...]:
    """Means, quaternions, log-scales, logits, constant harmonics of rows, each with its chunk."""
    means = _between(_parts(rows["packed_position"], (11, 10, 11)), bounds, BOUNDS)
    scales = _between(_parts(rows["packed_scale"], (11, 10, 11)), bounds, SCALES)
    colors = _parts(rows["packed_color"], (8, 8, 8, 8))
    opaque = np.clip(colors[:, 3], CLEAR, 1 - CLEAR)
    rgb = colors[:, :3]
    if COLORS[0] in (bounds.dtype.names or ()):
        rgb = _between(rgb, bounds, COLORS)
    quats = _quaternions(rows["packed_rotation"])
    return means, quats, scales, np.log(opaque / (1 - opaque)), (rgb - 0.5) / C0


def _parts(words: np.ndarray, bits: tuple[int, ...]) -> np.ndarray:
    """Fields of words, the highest first, as `[n, len(bits)]` in [0, 1]."""
    shifts = [sum(bits[i + 1 :]) for i in range(len(bits))]
    each = zip(bits, shifts, strict=True)
    return np.stack([(words >> s & (1 << b) - 1) / ((1 << b) - 1) for b, s in each], axis=1)


def _between(places: np.ndarray, bounds: np.ndarray, names: list[str]) -> np.ndarray:
    """Places in [0, 1] between the lower bounds, `names`' first three, and the upper ones."""
    low, high = (
        np.stack([bounds[name].astype(np.float64) for name in half], axis=1)
        for half in (names[:3], names[3:])
    )
    return low * (1 - places) + high * places


def _quaternions(words: np.ndarray) -> np.ndarray:
    """Two bits say which of w, x, y, z is largest; the others follow in order."""
    small = (_parts(words & (1 << 30) - 1, (10, 10, 10)) - 0.5) * math.sqrt(2)
    largest = (words >> 30).astype(np.int64)
    found = np.empty((len(words), 4))
    found[:, 0] = np.sqrt(np.clip(1 - (small**2).sum(1), 0, None))
    found[:, 1:] = small
    # of each row: the largest stands first in `found`, but belongs behind `largest` others
    order = np.array([[0, 1, 2, 3], [1, 0, 2, 3], [1, 2, 0, 3], [1, 2, 3, 0]])
    return np.take_along_axis(found, order[largest], axis=1)


def _harmonics(rows: np.ndarray, names: list[str]) -> np.ndarray:
    """Higher harmonics `[n, k, 3]`: a byte is the middle of its step, but 0 and 255 are ends."""
    bytes_ = np.stack([rows[name] for name in names], axis=1).astype(np.float32)
    steps = np.where(bytes_ == 0, 0, np.where(bytes_ == 255, 1, (bytes_ + 0.5) / 256))
    by_channel = ((steps - 0.5) * HARMONIC).reshape(len(rows), 3, len(names) // 3)
    return by_channel.swapaxes(1, 2)
