"""Reads coloured points from a PLY file, as nerfstudio captures have them."""

from pathlib import Path

import numpy as np
from jaxtyping import Float

from mobilegs.data.colmap_files import read_bytes
from mobilegs.errors import InputError

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_HEADER_BYTES = 1 << 16


def read_points_ply(
    path: Path,
) -> tuple[Float[np.ndarray, "m 3"], Float[np.ndarray, "m 3"]]:
    """Return (points [m, 3] in world units, colours [m, 3] in [0, 1]); grey without colours.

    The vertices must be the first element of the file. Raises `InputError` for a file that is
    not such a PLY, or is damaged.
    """
    data = read_bytes(path)
    end = data.find(b"end_header\n", 0, _HEADER_BYTES)
    if not data.startswith(b"ply") or end < 0:
        raise InputError(f"{path} is not a PLY file: it does not have a PLY header")
    header = data[:end].decode("ascii", errors="replace").split("\n")
    order, count, names = _parse_header(path, header)
    body = memoryview(data)[end + len(b"end_header\n") :]
    rows = (
        _ascii_rows(path, bytes(body), count, names)
        if order == "ascii"
        else _binary_rows(path, body, count, names, order)
    )
    if not {"x", "y", "z"} <= rows.keys():
        raise InputError(f"{path} lacks the properties x, y, z")
    points = np.stack([rows[axis].astype(np.float64) for axis in "xyz"], axis=1)
    if not {"red", "green", "blue"} <= rows.keys():
        return points, np.full_like(points, 0.5)
    whole = all(names[channel][0] in "iu" for channel in ("red", "green", "blue"))
    colors = np.stack([rows[c].astype(np.float64) for c in ("red", "green", "blue")], axis=1)
    return points, colors / 255 if whole else colors


def _parse_header(path: Path, lines: list[str]) -> tuple[str, int, dict[str, str]]:
    """Return (byte order or `ascii`, number of vertices, numpy type of each property)."""
    orders = {"ascii": "ascii", "binary_little_endian": "<", "binary_big_endian": ">"}
    order, count, element = None, None, None
    names: dict[str, str] = {}
    for line in lines:
        match line.split():
            case ["format", name, _] if name in orders:
                order = orders[name]
            case ["element", "vertex", number] if element is None and number.isdecimal():
                element, count = "vertex", int(number[:18])
            case ["element", name, _] if count is None:
                raise InputError(
                    f"{path} has the element {name} before its vertices; put the vertices first"
                )
            case ["element", *_]:
                element = "other"
            case ["property", kind, name] if element == "vertex" and kind in _TYPES:
                names[name] = _TYPES[kind]
            case ["property", *_] if element == "vertex":
                raise InputError(f"{path} has the vertex property {line!r}, which is not a number")
    if order is None or count is None or not names:
        raise InputError(f"{path} has a PLY header without a known format or without vertices")
    return order, count, names


def _binary_rows(
    path: Path, body: memoryview, count: int, names: dict[str, str], order: str
) -> dict[str, np.ndarray]:
    layout = np.dtype([(name, order + kind) for name, kind in names.items()])
    if count * layout.itemsize > len(body):
        raise InputError(
            f"{path} announces {count} points of {layout.itemsize} bytes, but has only "
            f"{len(body)} bytes after its header; copy it again"
        )
    rows = np.frombuffer(body, layout, count)
    return {name: rows[name] for name in names}


def _ascii_rows(
    path: Path, body: bytes, count: int, names: dict[str, str]
) -> dict[str, np.ndarray]:
    tokens = body.split(maxsplit=count * len(names)) if count * len(names) <= len(body) else []
    if len(tokens) < count * len(names):
        raise InputError(f"{path} ends before the last of its {count} points; copy it again")
    try:
        table = np.array(tokens[: count * len(names)]).astype(np.float64)
    except ValueError as error:
        raise InputError(
            f"{path} has a vertex with a value that is not a number ({error})"
        ) from error
    table = table.reshape(count, len(names))
    return {name: table[:, column] for column, name in enumerate(names)}
