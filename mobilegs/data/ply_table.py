"""PLY files as tables of numbers: header, and rows of vertices, as text or binary.

Scenes (`formats/ply.py`) and points of captures (`points.py`) are read through this module.
"""

import collections
import itertools
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import DTypeLike

from mobilegs.atomic import open_input
from mobilegs.errors import InputError

HEADER_MAX = 1 << 16  # bytes; a 3DGS header has about 1500
BYTE_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
    "half": "f2", "float16": "f2",  # not of the format, but they can mean nothing else
}  # fmt: skip
CHANNELS = ["red", "green", "blue"]
BLOCK = 1 << 22  # bytes of rows that are read at a time


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
    """The header of a PLY file.

    Attributes:
        order: byte order of a binary file, `<` or `>`.
        ascii: True for a text file.
        elements: the tables, in the order of the file.
        length: bytes up to the first number.
        comments: their words, without `comment`.
    """

    order: str
    ascii: bool
    elements: list[Element]
    length: int
    comments: list[list[str]]


def read_header(path: Path) -> tuple[Header, int]:
    """Return the header of a PLY and the size of the file in bytes.

    Raises InputError if the file cannot be read, or has no complete PLY header.
    """
    with open_input(path) as file:
        head = file.read(HEADER_MAX)
        return parse_header(head, path), file.seek(0, os.SEEK_END)


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
    kind, comments = "", []
    for line in head[: end.start()].decode("ascii", "replace").splitlines()[1:]:
        match line.split():
            case ["format", kind, *_]:
                pass
            case ["comment", *words]:
                comments.append(words)
            case ["element", name, count] if re.fullmatch(r"\d{1,18}", count):
                elements.append(Element(name, int(count), {}))
            case ["property", "list", *_] if elements:
                elements[-1] = Element(elements[-1].name, elements[-1].count, {}, True)
            case ["property", type_, name] if elements and type_ in TYPES:
                if name in elements[-1].columns:
                    raise InputError(f"{path} declares the property {name[:40]!r} twice")
                elements[-1].columns[name] = TYPES[type_]
            case ["property", type_, _]:
                raise InputError(f"{path} has a property of type {type_[:40]!r}, which is not PLY")
            case ["obj_info", *_] | []:
                pass
            case _:
                raise InputError(f"{path} has a header line that is not PLY: {line[:40]!r}")
    if kind not in BYTE_ORDERS:
        raise InputError(f"{path} has the PLY format {kind[:40]!r}, which does not exist")
    return Header(BYTE_ORDERS[kind], kind == "ascii", elements, end.end(), comments)


def find_vertex(header: Header, path: Path) -> tuple[Element, list[Element]]:
    """Return the element `vertex` and the elements before it."""
    for index, element in enumerate(header.elements):
        if element.name == "vertex":
            before = header.elements[:index]
            if element.has_lists or (not header.ascii and any(e.has_lists for e in before)):
                raise InputError(f"{path} has lists in or before its vertices: they cannot be read")
            return element, before
    raise InputError(f"{path} has no 'vertex' element")


def _check_size(
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


def vertex_rows(
    header: Header, size: int, names: list[str], path: Path, dtype: DTypeLike = np.float32
) -> Iterator[np.ndarray]:
    """Return the columns `names` of the vertices in blocks of rows, `[m, len(names)]`.

    Raises InputError, before anything is read, if a file of `size` bytes is too small for them.
    """
    vertex, before = find_vertex(header, path)
    start = _check_size(header, vertex, before, size, path)

    def blocks() -> Iterator[np.ndarray]:
        with open_input(path) as file:
            file.seek(start)
            if header.ascii:
                skipped = sum(element.count for element in before)
                yield from _read_text(file, vertex, skipped, names, path, dtype)
                return
            row = vertex.dtype(header.order)
            block = max(1, BLOCK // row.itemsize)
            for first in range(0, vertex.count, block):
                rows = np.fromfile(file, row, min(block, vertex.count - first))
                yield columns(rows, names, dtype)

    return blocks()


def _read_text(
    file: BinaryIO, vertex: Element, skipped: int, names: list[str], path: Path, dtype: DTypeLike
) -> Iterator[np.ndarray]:
    """Yield the rows of a text file, after `skipped` lines of other elements."""
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
            block_rows = table[:, places].astype(dtype)
        yield block_rows


def type_name(kind: str) -> str:
    """Return the name in a PLY header of a numpy type without byte order."""
    return next(name for name, known in TYPES.items() if known == kind)


def channel_max(vertex: Element) -> float:
    """Return the value of full brightness in the columns `CHANNELS`; 1 if they are floats."""
    kind = vertex.columns[CHANNELS[0]]
    return 1.0 if kind[0] == "f" else 65535.0 if kind == "u2" else 255.0


def cut_off(path: Path, count: int) -> InputError:
    """Return the error for a file that is shorter than its header says."""
    return InputError(f"{path} is cut off: its header announces {count} vertices; copy it again")


def columns(rows: np.ndarray, names: list[str], dtype: DTypeLike = np.float32) -> np.ndarray:
    """Return columns of a structured array as a matrix `[n, len(names)]`."""
    kinds = {rows.dtype[name] for name in rows.dtype.names or ()}
    with np.errstate(over="ignore", invalid="ignore"):  # doubles beyond float32 become infinite
        if len(kinds) == 1:  # common, and 3x faster
            order = {name: index for index, name in enumerate(rows.dtype.names or ())}
            matrix = rows.view(kinds.pop()).reshape(len(rows), len(order))
            return matrix[:, [order[name] for name in names]].astype(dtype)
        return np.stack([rows[name].astype(dtype) for name in names], axis=1)
