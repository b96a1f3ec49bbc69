"""Streams of the mode `sq`: columns of integers, and the refinement bits of rotations."""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import islice, repeat
from typing import NamedTuple

import numpy as np
from jaxtyping import Int32, UInt16
from torch import Tensor

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.mgs.bits import pack_bits, unpack_short
from mobilegs.mgs.container import Stream
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.mgs.streams import decode_indices, encode_indices
from mobilegs.representation.codebooks import Attribute
from mobilegs.representation.rotations import refinement_bits_of
from mobilegs.representation.uniform_quantizer import COLUMNS

REFINEMENT = "rotation-finer"  # name of the stream
BLOCK = 4096  # rows per pass over the columns: they fit in a processor's cache


@dataclass(frozen=True)
class AttributeCoding:
    """The header's description of one attribute's codes."""

    step_size: float
    """A float32 value."""
    columns: tuple["Column", ...]
    """Of rotations, the columns of their cells."""


class Column(NamedTuple):
    """`size` consecutive codes from `least` on; `middle` is the median code.

    The field names are keys of the file's header.
    """

    least: int
    size: int
    middle: int


def attribute_codings(scene: QuantizedScene) -> dict[Attribute, AttributeCoding]:
    """Return the header's description of every attribute, in the file's order."""
    codings: dict[Attribute, AttributeCoding] = {}
    for name in (*COLUMNS, "lobes"):
        if name not in scene.step_sizes:
            continue
        codes = scene.cells if name == "rotation" else scene.indices[name]
        columns = []
        for column in codes.T:
            least, largest = int(column.min()), int(column.max())
            columns.append(Column(least, largest - least + 1, int(column.median())))
        codings[name] = AttributeCoding(scene.step_sizes[name], tuple(columns))
    return codings


def column_symbols(
    level: QuantizedScene, name: Attribute, coding: AttributeCoding
) -> list[UInt16[np.ndarray, "n"]]:
    """Return the symbols of an attribute's columns in one LOD level: codes above the least."""
    codes = level.cells if name == "rotation" else level.indices[name]
    return [
        (codes[:, i] - column.least).numpy().astype(np.uint16)
        for i, column in enumerate(coding.columns)
    ]


def encode_columns(
    level: QuantizedScene, codings: Mapping[Attribute, AttributeCoding]
) -> list[Stream]:
    """Return the streams of one LOD level; refinement bits follow the columns of rotations.

    `codings` describe the whole scene.
    """
    streams: list[Stream] = []
    for name, coding in codings.items():
        for i, symbols in enumerate(column_symbols(level, name, coding)):
            column = coding.columns[i]
            streams.append(encode_indices(f"{name}.{i}", symbols, column.size))
        if name == "rotation":
            widths = level.refinement_bits.flatten().numpy().astype(np.int64)
            rotations = level.indices[name].flatten().numpy().astype(np.int64)
            rest = (rotations & ((1 << widths) - 1)).astype(np.uint64)
            streams.append(Stream(REFINEMENT, "bits", pack_bits(rest, widths)))
    return streams


def decode_columns(
    codings: Mapping[Attribute, AttributeCoding],
    codes: Mapping[Attribute, Int32[Tensor, "n _"]],
    stream: Callable[[str], Stream],
    pool: Executor,
) -> None:
    """Fill the `codes` of one LOD level; `stream` finds a stream by name or raises."""
    names = {name: [f"{name}.{i}" for i in range(len(codings[name].columns))] for name in codings}
    streams = [stream(name) for row in names.values() for name in row]
    sizes = [column.size for coding in codings.values() for column in coding.columns]
    symbols = pool.map(decode_indices, streams, repeat(len(codes["scale"])), sizes)
    for name, coding in codings.items():
        columns = list(islice(symbols, len(names[name])))
        join_columns(columns, [column.least for column in coding.columns], out=codes[name].numpy())
    widths = refinement_bits_of(codes["scale"], codings["scale"].step_size).numpy().reshape(-1)
    rest = stream(REFINEMENT)
    if rest.codec != "bits":
        raise InputError(
            f"the stream '{REFINEMENT}' of the .mgs file uses the unknown codec '{rest.codec}'"
        )
    rotations = codes["rotation"].numpy().reshape(-1)
    np.left_shift(rotations, widths, out=rotations)
    np.bitwise_or(rotations, unpack_short(rest.data, widths), out=rotations)


def join_columns(
    columns: list[UInt16[np.ndarray, "n"]], least: list[int], *, out: Int32[np.ndarray, "n c"]
) -> None:
    """Write `columns[i] + least[i]` to column i of `out`."""
    if binding.join_columns(columns, least, out):
        return
    for start in range(0, len(out), BLOCK):
        rows = slice(start, start + BLOCK)
        for i, (column, first) in enumerate(zip(columns, least, strict=True)):
            np.add(column[rows], first, out=out[rows, i], dtype=np.int32)
