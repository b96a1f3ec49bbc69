"""The parts of a `.mgs` file, to change them and write a file with valid checksums.

Nothing here uses the container of the package, which is what is tested.
"""

import json
import struct
import zlib
from dataclasses import dataclass, field
from typing import Any

MAGIC = b"MGS\x1a\r\n\x00\x01"
PREFIX = 20  # bytes before the header


@dataclass
class Piece:
    """A stream. `row` replaces fields of its row in the table of streams, `padding` its padding."""

    name: str
    codec: str
    data: bytes
    row: dict[str, Any] = field(default_factory=dict)
    padding: bytes | None = None


@dataclass
class Parts:
    """The parts of a file.

    Attributes:
        header: its JSON without the table of streams.
        text: the bytes of the whole header, table included; None: made from the other parts.
    """

    header: dict[str, Any]
    pieces: list[Piece]
    version: tuple[int, int] = (2, 1)
    text: bytes | None = None

    def header_text(self) -> bytes:
        """Return the header as JSON, before it is padded."""
        table = [
            {
                "name": piece.name,
                "codec": piece.codec,
                "bytes": len(piece.data),
                "crc32": zlib.crc32(piece.data),
                **piece.row,
            }
            for piece in self.pieces
        ]
        return json.dumps({**self.header, "streams": table}, separators=(",", ":")).encode()

    def to_bytes(self) -> bytes:
        """Return the file with valid lengths and checksums, except where a part overrides them."""
        text = self.header_text() if self.text is None else self.text
        text += b" " * (-(PREFIX + len(text)) % 8)
        fixed = struct.pack("<HHI", *self.version, len(text))
        rows = [MAGIC, fixed, struct.pack("<I", zlib.crc32(fixed + text)), text]
        for piece in self.pieces:
            padding = bytes(-len(piece.data) % 8) if piece.padding is None else piece.padding
            rows += [piece.data, padding]
        return b"".join(rows)

    def piece(self, name: str) -> Piece:
        """Return the first stream of that name."""
        return next(piece for piece in self.pieces if piece.name == name)


def parse_parts(data: bytes) -> Parts:
    """Split a valid file into its parts."""
    major, minor, length = struct.unpack_from("<HHI", data, len(MAGIC))
    header = json.loads(data[PREFIX : PREFIX + length])
    pieces, start = [], PREFIX + length
    for row in header.pop("streams"):
        end = start + row["bytes"]
        pieces.append(Piece(row["name"], row["codec"], data[start:end]))
        start = end + -row["bytes"] % 8
    return Parts(header, pieces, (major, minor))


def ends_of(data: bytes) -> dict[str, int]:
    """Return the number of bytes up to the end of each stream of a valid file."""
    pieces = parse_parts(data).pieces
    sizes = [len(piece.data) + -len(piece.data) % 8 for piece in pieces]
    found, end = {}, len(data) - sum(sizes)
    for piece, size in zip(pieces, sizes, strict=True):
        end += size
        found[piece.name] = end
    return found
