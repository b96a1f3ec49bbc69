"""Streams of the mode `sq`: columns of whole numbers, and the finer bits of rotations."""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import islice, repeat
from typing import NamedTuple

import numpy as np
from jaxtyping import Int32, UInt16
from torch import Tensor

from mobilegs.compress.codebooks import Attribute
from mobilegs.compress.rotations import finer_bits_of
from mobilegs.compress.uniform_quantizer import COLUMNS
from mobilegs.csrc import native
from mobilegs.errors import InputError
from mobilegs.mgs.bits import pack_bits, unpack_short
from mobilegs.mgs.container import Stream
from mobilegs.mgs.quantized_scene import CodedScene
from mobilegs.mgs.streams import decode_indices, encode_indices

FINER = "rotation-finer"  # name of the stream
BLOCK = 4096  # rows that a processor's cache holds while their columns are filled in


@dataclass(frozen=True)
class Scalar:
    """What the header says of an attribute."""

    step: float
    """A float32 value."""
    columns: tuple["Column", ...]
    """Of rotations those of the cells."""


class Column(NamedTuple):
    """Codes from `least` on, of which there are `size`; half of all are above `middle`."""

    least: int
    size: int
    middle: int


def scalars_of(coded: CodedScene) -> dict[Attribute, Scalar]:
    """What the header says of every attribute, in the file's order."""
    found: dict[Attribute, Scalar] = {}
    for name in (*COLUMNS, "lobes"):
        if name not in coded.steps:
            continue
        codes = coded.cells if name == "rotation" else coded.indices[name]
        columns = []
        for column in codes.T:
            least, largest = int(column.min()), int(column.max())
            columns.append(Column(least, largest - least + 1, int(column.median())))
        found[name] = Scalar(coded.steps[name], tuple(columns))
    return found


def pack_scalars(coded: CodedScene, scalars: Mapping[Attribute, Scalar]) -> list[Stream]:
    """All columns of a layer, and behind those of the rotations their finer bits.

    `scalars` are those of the whole scene.
    """
    streams: list[Stream] = []
    for name, scalar in scalars.items():
        codes = coded.cells if name == "rotation" else coded.indices[name]
        for i, column in enumerate(scalar.columns):
            symbols = (codes[:, i] - column.least).numpy().astype(np.uint16)
            streams.append(encode_indices(f"{name}.{i}", symbols, column.size))
        if name == "rotation":
            finer = coded.finer.flatten().numpy().astype(np.int64)
            turns = coded.indices[name].flatten().numpy().astype(np.int64)
            rest = (turns & ((1 << finer) - 1)).astype(np.uint64)
            streams.append(Stream(FINER, "bits", pack_bits(rest, finer)))
    return streams


def unpack_scalars(
    scalars: Mapping[Attribute, Scalar],
    codes: Mapping[Attribute, Int32[Tensor, "n _"]],
    stream: Callable[[str], Stream],
    pool: Executor,
) -> None:
    """Fill a layer's `codes` with what `pack_scalars` wrote; `stream` finds streams or raises."""
    names = {name: [f"{name}.{i}" for i in range(len(scalars[name].columns))] for name in scalars}
    streams = [stream(name) for row in names.values() for name in row]
    sizes = [column.size for scalar in scalars.values() for column in scalar.columns]
    symbols = pool.map(decode_indices, streams, repeat(len(codes["scale"])), sizes)
    for name, scalar in scalars.items():
        columns = list(islice(symbols, len(names[name])))
        join(columns, [column.least for column in scalar.columns], out=codes[name].numpy())
    finer = finer_bits_of(codes["scale"], scalars["scale"].step).numpy().reshape(-1)
    rest = stream(FINER)
    if rest.codec != "bits":
        raise InputError(f"the stream '{FINER}' of the .mgs file uses the codec '{rest.codec}'")
    turns = codes["rotation"].numpy().reshape(-1)
    np.left_shift(turns, finer, out=turns)
    np.bitwise_or(turns, unpack_short(rest.data, finer), out=turns)


def join(
    columns: list[UInt16[np.ndarray, "n"]], least: list[int], *, out: Int32[np.ndarray, "n c"]
) -> None:
    """Columns beside each other, each with its least code added."""
    if native.joined(columns, least, out):
        return
    for start in range(0, len(out), BLOCK):
        rows = slice(start, start + BLOCK)
        for i, (column, first) in enumerate(zip(columns, least, strict=True)):
            np.add(column[rows], first, out=out[rows, i], dtype=np.int32)
