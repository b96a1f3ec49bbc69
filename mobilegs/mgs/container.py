"""The container of a `.mgs` file: magic, version, header, and streams with checksums."""

import json
import re
import struct
import zlib
from dataclasses import dataclass
from typing import Any

from mobilegs.errors import InputError
from mobilegs.representation.appearance import LATENTS

MAGIC = b"MGS\x1a\r\n\x00\x01"  # like PNG's: a transfer in text mode damages it
MAJORS = (2, 3, 4)
MINOR = {2: 1, 3: 0, 4: 0}  # the least that a writer gives; `_minor_increment` adds to it
PREFIX = struct.Struct("<8sHHII")  # magic, major, minor, bytes of header, CRC-32
VERSION = struct.Struct("<HH")  # at byte 8
HEADER_MAX = 1 << 20
STREAMS_MAX = 256
# control characters, which terminals obey, and unpaired surrogates, which cannot be printed
UNPRINTABLE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff]")
FOREIGN = {
    b"ply": "a PLY scene: train or compress it first",
    b"PK\x03\x04": "a zip archive (perhaps .sog)",
    b"\x1f\x8b": "a gzip file (perhaps .spz)",
    b"NGSP": "an .spz scene",
    b"glTF": "a binary glTF file",
    b"\xfd7zXZ": "an xz file (perhaps another program's comp.xz)",
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"<": "a web page",
    b"{": "a JSON text",
}


@dataclass(frozen=True)
class Stream:
    """A named part of the file and its codec."""

    name: str
    codec: str
    data: bytes | memoryview


def write_container(header: dict[str, Any], streams: list[Stream], *, major: int) -> bytes:
    """Return the bytes of a file: `header` with the table of streams, then the streams.

    Raises InputError if the header exceeds 1 MiB, or there are more than 256 streams.
    """
    if len(streams) > STREAMS_MAX:
        raise InputError(f"the scene has {len(streams)} streams: {STREAMS_MAX} are allowed")
    table = [
        {
            "name": stream.name,
            "codec": stream.codec,
            "bytes": len(stream.data),
            "crc32": zlib.crc32(stream.data),
        }
        for stream in streams
    ]
    text = json.dumps(
        {**header, "streams": table}, sort_keys=True, separators=(",", ":"), allow_nan=False
    ).encode()
    text += b" " * (-(PREFIX.size + len(text)) % 8)
    if len(text) > HEADER_MAX:
        raise InputError(f"the header has {len(text)} bytes: shorten the scene's notes")
    minor = MINOR[major] + _minor_increment(header, major)
    head = PREFIX.pack(MAGIC, major, minor, len(text), 0)
    head = PREFIX.pack(MAGIC, major, minor, len(text), _checksum(head, text))
    padded = (bytes(stream.data) + bytes(-len(stream.data) % 8) for stream in streams)
    return b"".join([head, text, *padded])


def _minor_increment(header: dict[str, Any], major: int) -> int:
    """Return the increment of the minor version by the features that a header uses."""
    depth_pass = header["weighting"]["name"] == "depth_pass"
    if major == 4:
        return int(depth_pass)
    if depth_pass:
        return 5
    books = header.get("codebooks", {})
    joint = "scale" in books and (books["scale"]["count"] == 1 or books["rotation"]["count"] == 1)
    by_direction = header["network"] or header["lobes"] is not None
    sorted_by_direction = header["blend"] == "sorted" and by_direction
    if joint or sorted_by_direction or header.get("colors") == "latent_networks":
        return 4
    if "colors" not in header:
        return int("alpha_min" in header["weighting"])
    columns = header["scalars"]["appearance"]["least"] if "scalars" in header else ()
    return 3 if len(columns) > 2 * LATENTS else 2


def read_container(data: bytes) -> tuple[dict[str, Any], dict[str, Stream]]:
    """Return the header without its table, and the streams by name, with checked checksums.

    The field `layers` is None in files without LOD levels: all of version 2, some of version 4.
    `footprint` is None in files before version 4. Raises InputError if this is not a `.mgs`, has an
    unknown version, or is damaged.
    """
    length = _check_prefix(data)
    text = data[PREFIX.size : PREFIX.size + length]
    try:
        header = json.loads(text.decode(), parse_constant=_no_constant, parse_int=_integer)
    except (ValueError, RecursionError):
        raise InputError("the header of the .mgs file is not valid JSON") from None
    if not isinstance(header, dict):
        raise InputError("the header of the .mgs file is not a JSON object")
    major = VERSION.unpack_from(data, 8)[0]
    needed = ["footprint"] if major == 4 else []
    if major == 2 or (major == 4 and "layers" not in header):
        header["layers"] = None
    else:  # null is no way to leave it out
        needed.append("layers")
    if major < 4:
        header["footprint"] = None
    for name in needed:
        if header.get(name) is None:
            raise InputError(f"the header of the .mgs file lacks the field '{name}'")
    table = header.pop("streams", None)
    if not isinstance(table, list) or len(table) > STREAMS_MAX:
        raise InputError("the header of the .mgs file lacks a table of streams")
    streams: dict[str, Stream] = {}
    start = PREFIX.size + length
    for row in table:
        name, codec, size, crc = _check_row(row)
        if name in streams:
            raise InputError(f"the .mgs file has two streams called '{name}'")
        if start + size > len(data):
            raise InputError(
                f"the .mgs file ends inside its stream '{name}': it has been cut short"
            )
        content = memoryview(data)[start : start + size]
        start += size + -size % 8
        if zlib.crc32(content) != crc:
            raise InputError(f"the stream '{name}' of the .mgs file is damaged (wrong checksum)")
        if any(data[start - (-size % 8) : start]) or start > len(data):
            raise InputError(f"the .mgs file is damaged after its stream '{name}'")
        streams[name] = Stream(name, codec, content)
    if start != len(data):
        raise InputError(f"the .mgs file has {len(data) - start} bytes too many at its end")
    return header, streams


def _check_prefix(data: bytes) -> int:
    """Check magic, version and checksum; returns the length of the header."""
    if data[: len(MAGIC)] != MAGIC:
        raise InputError(_not_ours(data))
    if len(data) < PREFIX.size:
        raise InputError("the .mgs file ends inside its first bytes: it has been cut short")
    _, major, minor, length, checksum = PREFIX.unpack_from(data)
    if major not in MAJORS:
        raise InputError(
            f"the .mgs file has version {major}.{minor}, this program reads "
            f"{MAJORS[0]}.x to {MAJORS[-1]}.x: "
            "use the mobilegs that wrote it, or a newer one"
        )
    if length > HEADER_MAX:
        raise InputError(f"the header of the .mgs file claims {length} bytes: it is damaged")
    if len(data) < PREFIX.size + length:
        raise InputError("the .mgs file ends inside its header: it has been cut short")
    if (PREFIX.size + length) % 8 or checksum != _checksum(data, data[PREFIX.size :][:length]):
        raise InputError("the header of the .mgs file is damaged (wrong checksum)")
    return length


def _checksum(prefix: bytes, text: bytes) -> int:
    """Return the CRC-32 of version, header length and header."""
    return zlib.crc32(text, zlib.crc32(prefix[8:16]))


def _check_row(row: Any) -> tuple[str, str, int, int]:
    if isinstance(row, dict):
        texts = [row.get(key) for key in ("name", "codec")]
        numbers: list[Any] = [row.get(key) for key in ("bytes", "crc32")]
        if all(short_text(text, 64) for text in texts) and all(map(_plain_size, numbers)):
            return *texts, *map(int, numbers)  # pyright: ignore[reportReturnType]
    raise InputError("the header of the .mgs file has a broken table of streams")


def _plain_size(value: Any) -> bool:
    """Return True for an integer from 0 to below 2^40; JSON has one type of number: 1.0 is 1."""
    return type(value) in (int, float) and 0 <= value < 1 << 40 and value == int(value)


def short_text(value: Any, longest: int) -> bool:
    """Return True for a printable text of at most `longest` characters."""
    return isinstance(value, str) and len(value) <= longest and not UNPRINTABLE.search(value)


def _not_ours(data: bytes) -> str:
    if not data:
        return "the file is empty, not a .mgs scene"
    if data[:3] == MAGIC[:3] or MAGIC.startswith(data):
        return "the first bytes of the .mgs file are damaged: transfer it again, in binary mode"
    for start, what in FOREIGN.items():
        if data.startswith(start):
            return f"this is not a .mgs scene but looks like {what}"
    return "this is not a .mgs scene"


def _integer(digits: str) -> int | float:
    """Parse like JavaScript: numbers beyond 2^53 are rounded, whatever their length."""
    value = float(digits)
    return int(value) if abs(value) <= 1 << 53 else value


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")
