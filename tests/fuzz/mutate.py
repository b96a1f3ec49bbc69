"""Mutate valid files with knowledge of the format, and with valid checksums.

`Mutator(kind, seeds, seed).input(i)` always gives the same input.
"""

import json
import random
import struct
import zlib
from collections.abc import Callable
from copy import deepcopy
from typing import Any

from tests.fuzz.mutate_formats import mutated_glb, mutated_sog, mutated_splat
from tests.fuzz.mutate_plain import NUMBERS, WORDS, damaged, mutated_ply, mutated_spz
from tests.fuzz.seeds import Seed
from tests.support.mgs_parts import Parts, Piece, parse_parts

STRANGE = [
    *NUMBERS, None, True, False, "", "x", "1", "raw", "bits", "rans", "halves", "planes", "nvq",
    "sq", "sorted", "sortfree", "morton-class", "mobile_gs", "no_scale", "sort_free_gs", "scale.0",
    "__proto__", "constructor", "\x1b[2J", "a\nb", "\ud800", "\U0001f33f" * 4096, "x" * 5000,
    "\u4e00" * 64, "\u4e00" * 65, [], {}, [0.0] * 3, [1e300] * 3, [[]], {"a": {}}, [None] * 100,
    {"count": 1, "length": 1, "size": 1}, {"degree": 3, "latents": 32, "hidden": [256] * 3},
    {"degree": 0, "latents": 0, "hidden": []}, {str(i): i for i in range(65)},
    {"toString": 1}, [{"toString": 1}],
]  # fmt: skip
FLOAT16_PATTERNS = [0x7C00, 0xFC00, 0x7E00, 0xFFFF, 0x7BFF, 0xFBFF, 0x0001, 0x8000, 0x5500, 0x5501]
TEXTS = [
    b"", b"[]", b"1", b"{", b'{"streams":0}', b'{"streams":[]}', b"[" * 5000, b"null", b'"\\ud800"',
    b'{"near":' + b"9" * 5000 + b"}", b'{"a":NaN}', b"\xef\xbb\xbf{}", b"\xff\xfe{}",
]  # fmt: skip


class Mutator:
    """Makes inputs of one kind (a key of `MAKERS`)."""

    def __init__(self, kind: str, seeds: dict[str, Seed], seed: int) -> None:
        self.seed = seed
        self.make = MAKERS[kind]
        self.files = [seed.data for seed in seeds.values()]
        weights = [seed.weight for seed in seeds.values()]
        self.shares = [sum(weights[: i + 1]) for i in range(len(weights))]

    def input(self, number: int) -> bytes:
        """Return input `number`."""
        r = random.Random(self.seed << 40 | number)
        (data,) = r.choices(self.files, cum_weights=self.shares)
        if r.random() < 0.15:
            return damaged(r, data)
        return self.make(r, data, self.files)


# --- .mgs


def _mgs(r: random.Random, data: bytes, files: list[bytes]) -> bytes:
    parts = parse_parts(data)
    for _ in range(1 if r.random() < 0.6 else r.randrange(2, 4)):
        (change,) = r.choices(CHANGES, cum_weights=CHANGE_SHARES)
        if change is _borrow:
            _borrow(r, parts, files)
        else:
            change(r, parts)
    return parts.to_bytes()


def _places(value: Any, path: tuple = ()) -> list[tuple]:
    """Return the path of every value inside a JSON value."""
    items: Any = ()
    if isinstance(value, dict | list):
        items = value.items() if isinstance(value, dict) else enumerate(value)
    found = []
    for key, inner in items:
        found += [(*path, key), *_places(inner, (*path, key))]
    return found


def _header(r: random.Random, parts: Parts) -> None:
    """Change a value of the header to another of any type, or remove it."""
    if not parts.header:
        return
    name = r.choice(list(parts.header))  # not the numbers of matrices most of the time
    path: tuple[Any, ...] = r.choice(
        [(name,), *((name, *path) for path in _places(parts.header[name]))]
    )
    inner: Any = parts.header
    for key in path[:-1]:
        inner = inner[key]
    key, way = path[-1], r.randrange(8)
    value = inner[key]
    if way == 0:
        del inner[key]
    elif way == 1 and isinstance(inner, list):
        inner[key:key] = [value] * r.choice([1, 1, 2, 300])
    elif way < 5 and type(value) in (int, float) and abs(value) < 1e300:
        near = [value + 1, value - 1, 2 * value, -value, value * 0.5, value * 1.0000001, 10 * value]
        inner[key] = r.choice([*near, float(value)])  # 1.0 is 1
    else:
        inner[key] = deepcopy(r.choice(STRANGE))  # later changes are not to be of STRANGE


def _count(r: random.Random, parts: Parts) -> None:
    """Change the number of Gaussians, up to the limit by bytes and beyond."""
    count = parts.header.get("count")
    most = sum(len(piece.data) for piece in parts.pieces)
    near = [count + 1, count - 1, 2 * count] if type(count) is int else []
    parts.header["count"] = r.choice([*near, 1, 2047, 4096, most, most + 3000, 2**26, 2**40])
    if r.random() < 0.3:
        parts.pieces.append(Piece("spare", "none", bytes(r.randrange(3000))))


def _stream(r: random.Random, parts: Parts) -> None:
    """Change bytes of a stream."""
    full = [piece for piece in parts.pieces if piece.data]
    if not full:
        return
    # streams of weights are long: prefer the others
    small = [piece for piece in full if len(piece.data) < 4000] or full
    piece = r.choice(small if r.random() < 0.9 else full)
    piece.data = damaged(r, piece.data, as_long=r.random() < 0.7)


def _words(r: random.Random, parts: Parts) -> None:
    """Change lengths and counts at the start of a stream."""
    coded = [p for p in parts.pieces if p.codec in ("rans", "halves", "planes", "morton-class")]
    coded = [piece for piece in coded if len(piece.data) >= 20]
    if not coded:
        return
    piece = r.choice(coded)
    data, start = bytearray(piece.data), 0 if piece.codec == "rans" else r.choice([0, 4])
    place, form = r.choice([(0, "<H"), (2, "<H"), (4, "<I"), (8, "<I"), (12, "<I"), (0, "<I")])
    old = struct.unpack_from(form, data, start + place)[0]
    new = r.choice([old + 1, old - 1, old + 2, *WORDS])
    struct.pack_into(form, data, start + place, new % (1 << 8 * struct.calcsize(form)))
    piece.data = bytes(data)


def _weights(r: random.Random, parts: Parts) -> None:
    """Change weights and codebook entries to NaN, infinity, the largest or the smallest number."""
    raw = [piece for piece in parts.pieces if piece.codec == "raw" and len(piece.data) >= 2]
    if not raw:
        return
    piece = r.choice(raw)
    data = bytearray(piece.data)
    for _ in range(r.choice([1, 1, 5, 500])):
        struct.pack_into("<H", data, 2 * r.randrange(len(data) // 2), r.choice(FLOAT16_PATTERNS))
    piece.data = bytes(data)


def _table(r: random.Random, parts: Parts) -> None:
    """Repeat, reorder, remove, rename or recode streams."""
    pieces, way = parts.pieces, r.randrange(9)
    if not pieces:
        return
    i, j = r.randrange(len(pieces)), r.randrange(len(pieces))
    piece = pieces[i]
    if way == 0:
        pieces.insert(j, Piece(piece.name, piece.codec, pieces[j].data))
    elif way == 1:
        pieces[i], pieces[j] = pieces[j], pieces[i]
    elif way == 2:
        del pieces[i]
    elif way == 3:
        piece.name = r.choice([pieces[j].name, "", "x" * 65, "positions@1", "a\nb", "\ud800"])
    elif way == 4:
        piece.codec = r.choice(["raw", "bits", "rans", "halves", "planes", "morton-class", "", "x"])
    elif way == 5:
        piece.data = pieces[j].data
    elif way == 6:
        pieces.insert(i, Piece(f"new {i}", "new", r.randbytes(r.randrange(30))))
    elif way == 7:
        pieces += [Piece(f"{k}", "new", b"") for k in range(r.choice([200, 256]))]
    else:
        r.shuffle(pieces)


def _lie(r: random.Random, parts: Parts) -> None:
    """Make a row of the table disagree with its stream: streams then overlap or leave gaps."""
    if not parts.pieces:
        return
    piece = r.choice(parts.pieces)
    size = len(piece.data)
    key = r.choice(["bytes", "bytes", "crc32", "name", "codec"])
    lies = [size + 1, size - 1, size + 8, size - 8, 0, size // 2]
    piece.row[key] = r.choice(lies) if key == "bytes" and r.random() < 0.7 else r.choice(STRANGE)
    if key == "bytes" and r.random() < 0.7 and type(piece.row[key]) is int:
        # the checksum fits the claimed length, as far as it covers the following streams
        at = parts.pieces.index(piece)
        rest = b"".join(p.data + bytes(-len(p.data) % 8) for p in parts.pieces[at:])
        piece.row["crc32"] = zlib.crc32(rest[: max(0, min(piece.row[key], len(rest)))])


def _padding(r: random.Random, parts: Parts) -> None:
    if parts.pieces:
        piece = r.choice(parts.pieces)
        piece.padding = r.choice([b"", b"\0", b"\1" * 3, bytes(8), bytes(16), b"\0" * 6 + b"\1"])


def _version(r: random.Random, parts: Parts) -> None:
    parts.version = (r.choice([0, 1, 2, 2, 3, 3, 4, 65535]), r.choice([0, 1, 7, 65535]))
    if r.random() < 0.5:
        count = parts.header.get("count")
        half = count // 2 if type(count) is int else 1
        choices = [[count], [half, half], [], [0, count], [1] * 9, None, 1, [1.0], [half, -half]]
        parts.header["layers"] = r.choice(choices)


def _json(r: random.Random, parts: Parts) -> None:
    """Change the header's text: other spellings, and invalid JSON."""
    text, way = parts.text or parts.header_text(), r.randrange(8)
    if way == 0:
        text = r.choice(TEXTS)
    elif way == 1:
        text = damaged(r, text)
    elif way == 2:  # the last of equal names counts
        value = json.dumps(r.choice(STRANGE)).encode()
        name = r.choice(["count", "mode", "streams", "lobes", "positions", "near", "__proto__"])
        text = text[:-1] + b',"' + name.encode() + b'":' + value + b"}"
    elif way == 3:
        text = text.replace(b",", b" ,\t\n\r ")
    elif way == 4:
        depth = r.choice([10, 100, 400, 5000])
        # an unknown field may be nested too deep for Python only
        names = ["mode", "colors", "weighting", "meta", "views"]
        name = "deep" if depth < 5000 and r.random() < 0.5 else r.choice(names)
        text = text[:-1] + b',"' + name.encode() + b'":' + b"[" * depth + b"]" * depth + b"}"
    elif way == 5:
        text = text.replace(b'"', b"'", 1)
    elif way == 6:
        text += b" " * r.choice([1, 8, 5000, 2**20])
    else:
        text = text.replace(b":0", b":-0").replace(b":1,", b":1e0,")
    parts.text = text


def _borrow(r: random.Random, parts: Parts, files: list[bytes]) -> None:
    """Take a stream or a field of another file."""
    other = parse_parts(r.choice(files))
    if r.random() < 0.5 and other.pieces:
        piece = r.choice(other.pieces)
        own = [i for i, ours in enumerate(parts.pieces) if ours.name == piece.name]
        if own:
            parts.pieces[own[0]] = piece
        else:
            parts.pieces.append(piece)
    else:
        name = r.choice(list(other.header))
        parts.header[name] = other.header[name]


# errors in the header hide errors in the streams: streams get more weight
CHANGES: list[Callable[..., None]] = [
    _header, _stream, _words, _weights, _count, _table, _lie, _padding, _version, _json, _borrow,
]  # fmt: skip
CHANGE_WEIGHTS = [20, 30, 12, 6, 5, 7, 6, 1, 3, 5, 5]
CHANGE_SHARES = [sum(CHANGE_WEIGHTS[: i + 1]) for i in range(len(CHANGES))]


MAKERS: dict[str, Callable[[random.Random, bytes, list[bytes]], bytes]] = {
    "mgs": _mgs,
    "ply": mutated_ply,
    "compressed": mutated_ply,
    "spz": mutated_spz,
    "splat": mutated_splat,
    "sog": mutated_sog,
    "glb": mutated_glb,
}
