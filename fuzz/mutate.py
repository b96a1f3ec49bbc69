"""Change inputs with knowledge of their format: a part changes, checksums and lengths fit again."""

import io
import json
import random
import struct
import zipfile
import zlib
from collections.abc import Callable
from copy import deepcopy
from typing import Any, TypeVar

import zstandard
from PIL import Image

from tests.support.mgs_parts import parse_parts

T = TypeVar("T")

NUMBERS = [
    0, -1, 1, 2, 3, 4, 7, 8, 31, 32, 48, 49, 64, 65, 255, 256, 4096, 4097, 2**14, 2**14 + 1, 2**16,
    2**26, 2**26 + 1, 2**31, 2**32 - 1, 2**40, 2**53, 2**63, 2**64, 10**400, -(10**400), 0.5, -0.5,
    1e-5, 1e-20, 1e20, 1.0000001e20, 80, 80.5, 1e300, 3e38, 3.3e38, -3e38, 5e-324, 5120, 5126,
]  # fmt: skip
STRANGE = [
    *NUMBERS, None, True, False, "", "x", "1", "raw", "bits", "rans", "halves", "planes", "nvq",
    "sq", "sorted", "sortfree", "morton-class", "no_scale", "scale.0", "__proto__", "constructor",
    "VEC3", "SCALAR", "meta.json", "../up", "\x1b[2J", "a\nb", "\ud800", "\U0001f33f" * 4096,
    "\u4e00" * 64, "\u4e00" * 65, [], {}, [[]], [None] * 100, [0.0] * 3, [1e300] * 3, [1] * 5000,
    {"a": {}}, {"degree": 3, "latents": 32, "hidden": [256] * 3}, {"toString": 1},
]  # fmt: skip
TEXTS = [
    b"", b"[]", b"1", b"{", b"null", b"[" * 9000, b'"\\ud800"', b'{"streams":0}', b'{"streams":[]}',
    b'{"near":' + b"9" * 5000 + b"}", b'{"a":NaN}', b"\xef\xbb\xbf{}", b"\xff\xfe{}",
]  # fmt: skip
WORDS = [
    b"vertex", b"list", b"float", b"uchar", b"double", b"x", b"f_rest_0", b"\xff", b"\x1b[2J",
    b"nan", b"-1", b"1e300", b"9" * 30, b"", b"element face 4\nproperty double q", b"\n" * 2000,
    b"property list uchar int v", b"comment " + b"x" * 70000,
]  # fmt: skip
SPECIAL = [  # lengths, float16, float32 and float64 numbers at the limits of what a format allows
    *(struct.pack("<I", n) for n in (0, 1, 2, 49, 65, 2**14, 2**16, 10**7, 2**31, 2**32 - 1)),
    *(struct.pack("<Q", n) for n in (0, 1, 1 << 16, 1 << 31, 1 << 62, (1 << 64) - 1)),
    *(struct.pack("<H", n) for n in (0, 0x7C00, 0xFC00, 0x7E00, 0x7BFF, 0xFBFF, 1, 0x5501)),
    *(struct.pack("<f", x) for x in (-0.0, 3.3e38, float("nan"), float("inf"), -float("inf"))),
    *(struct.pack("<d", x) for x in (0.0, -1.0, 1e-320, 1e30, 1e300, float("nan"), float("inf"))),
]
PNG = b"\x89PNG\r\n\x1a\n"


def mutated(kind: str, r: random.Random, data: bytes, files: list[bytes]) -> bytes:
    """Return an input of a kind that differs from `data`, perhaps by a part of another file."""
    if r.random() < 0.85:
        try:
            return FORMATS[kind](r, data, r.choice(files))
        except Exception:  # not a file that can be taken apart
            pass
    return damaged(r, data)


# --- bytes, text, JSON, lists


def damaged(r: random.Random, data: bytes, *, as_long: bool = False) -> bytes:
    """Change, cut off, move and repeat bytes; the length stays if `as_long`."""
    found = bytearray(data)
    for _ in range(1 if r.random() < 0.5 else r.randrange(2, 6)):
        if not found:
            break
        # half of the time near the start, which has headers
        at = r.randrange(len(found) if r.random() < 0.5 else min(len(found), 64))
        end = min(len(found), at + (1 << r.randrange(8)))
        way = r.randrange(3 if as_long else 7)
        if way == 0:
            found[at] ^= 1 << r.randrange(8)
        elif way == 1:
            found[at] = r.randrange(256)
        elif way == 2:
            special = r.choice(SPECIAL)
            at -= at % min(4, len(special))
            found[at : at + len(special)] = special[: len(found) - at]
        elif way == 3:
            del found[at : r.choice([end, len(found)])]
        elif way == 4:
            found[at:at] = found[at:end]
        elif way == 5:
            found[at:end] = r.choice([b"\0", b"\xff"]) * (end - at)
        else:
            found += r.choice([r.randbytes(r.randrange(1, 40)), bytes(20_000), found[:3000] * 9])
    return bytes(found)


def _text(r: random.Random, data: bytes) -> bytes:
    """Change words and lines."""
    lines = data.split(b"\n")
    i, way = r.randrange(len(lines)), r.randrange(8)
    if way == 0:
        lines = _list(r, lines, lines)
    elif way == 1:
        lines[i] = damaged(r, lines[i])
    elif way == 2:
        lines[i:i] = [b"property char p%d" % k for k in range(r.choice([1, 100, 3000]))]
    elif way == 3:
        return r.choice([b"\r\n", b"\r", b" \n"]).join(lines)
    else:
        words = lines[i].split(b" ")
        word = r.choice([*WORDS, str(r.choice(NUMBERS)).encode()])
        words[-1 if way == 4 else r.randrange(len(words))] = word
        lines[i] = b" ".join(words)
    return b"\n".join(lines)


def _json(r: random.Random, data: bytes) -> bytes:
    """Change values of JSON, or its spelling."""
    way = r.randrange(16)
    if way == 0:
        return r.choice(TEXTS)
    if way == 1:
        return damaged(r, data)
    if way == 2:  # the last of equal names counts
        name = r.choice([b"count", b"mode", b"streams", b"lobes", b"positions", b"later"])
        deep = r.choice([10, 400, 5000])
        value = r.choice([json.dumps(r.choice(STRANGE)).encode(), b"[" * deep + b"]" * deep])
        return data.rstrip()[:-1] + b',"' + name + b'":' + value + b"}"
    if way == 3:
        return data.replace(b",", b" ,\t\n\r ").replace(b":0", b":-0") + b" " * r.choice([0, 2**20])
    content = json.loads(data)
    for _ in range(1 if r.random() < 0.6 else r.randrange(2, 4)):
        _value(r, content)
    return json.dumps(content).encode()


def _places(value: Any, path: tuple = ()) -> list[tuple]:
    """Return the path of every value inside a JSON value, of the first ones of long lists."""
    if not isinstance(value, dict | list) or len(path) > 20:
        return []
    items = value.items() if isinstance(value, dict) else list(enumerate(value))[:8]
    return [p for key, inner in items for p in [(*path, key), *_places(inner, (*path, key))]]


def _value(r: random.Random, content: Any) -> None:
    """Change a value to another of any type, repeat it or remove it."""
    *path, key = r.choice(_places(content))
    for step in path:
        content = content[step]
    way, value = r.randrange(8), content[key]
    if way == 0:
        del content[key]
    elif way == 1 and isinstance(content, list):
        content[key:key] = [value] * r.choice([1, 2, 300])
    elif way < 5 and type(value) in (int, float) and abs(value) < 1e300:
        content[key] = r.choice([value + 1, value - 1, 2 * value, -value, value / 2, float(value)])
    else:
        content[key] = deepcopy(r.choice(STRANGE))  # later changes are not to be of STRANGE


def _list(r: random.Random, items: list[T], others: list[T]) -> list[T]:
    """Remove, repeat, move or replace a member."""
    i, way = r.randrange(len(items)), r.randrange(4)
    if way == 3:
        return r.sample(items, len(items))
    replaced = [[], [r.choice(others)], [items[i]] * r.choice([2, 3, 60])][way]
    return [*items[:i], *replaced, *items[i + 1 :]]


# --- formats


def _mgs(r: random.Random, data: bytes, other: bytes) -> bytes:
    parts = parse_parts(data)
    for _ in range(1 if r.random() < 0.6 else r.randrange(2, 4)):
        # streams of weights are long: prefer the others
        small = [each for each in parts.pieces if 0 < len(each.data) < 4000] or parts.pieces
        piece = r.choice(small if r.random() < 0.9 else parts.pieces)
        way = r.randrange(20)
        if way < 10:  # errors in the header would hide errors in the streams
            piece.data = damaged(r, piece.data, as_long=r.random() < 0.8)
        elif way < 14:
            name = r.choice(list(parts.header))
            value = {name: parts.header.pop(name)}
            _value(r, value)
            parts.header |= value
        elif way == 14:
            parts.pieces = _list(r, parts.pieces, parse_parts(other).pieces)
        elif way == 15:
            parts.header |= [r.choice(list(parse_parts(other).header.items()))]
        elif way == 16:  # a row of the table that disagrees with its stream
            if r.random() < 0.5:
                piece.row[r.choice(["bytes", "crc32", "name", "codec"])] = r.choice(STRANGE)
            else:  # a length with a checksum that fits
                end = max(0, len(piece.data) + r.choice([1, -1, 8, -20]))
                rest = parts.pieces[parts.pieces.index(piece) :]
                found = b"".join(each.data + bytes(-len(each.data) % 8) for each in rest)[:end]
                piece.row |= {"bytes": end, "crc32": zlib.crc32(found)}
        elif way == 17:
            piece.padding = r.choice([b"", b"\0", b"\1" * 3, bytes(16), b"\0" * 6 + b"\1"])
        elif way == 18:
            parts.version = (r.choice([0, 1, 2, 3, 4, 5, 65535]), r.choice([0, 1, 65535]))
            count = parts.header["count"]
            parts.header["layers"] = r.choice([[count], [1, count - 1], [], [0, count], None, 1])
        else:
            parts.text = _json(r, parts.header_text())
    return parts.to_bytes()


def _ply(r: random.Random, data: bytes, other: bytes) -> bytes:
    head, end, body = data.partition(b"end_header\n")
    if r.random() < 0.3:
        return head + end + (_text if b"ascii" in head and r.random() < 0.5 else damaged)(r, body)
    return _text(r, head) + end + body


def _spz(r: random.Random, data: bytes, other: bytes) -> bytes:
    if data[:2] == b"\x1f\x8b":
        zipper = zlib.compressobj(1, wbits=31)
        content = damaged(r, zlib.decompress(data, wbits=31))
        found = zipper.compress(content) + zipper.flush()
        return found + r.choice([b""] * 8 + [found, b"rest"])
    number, table = data[15], struct.unpack_from("<I", data, 16)[0]
    at = table + 16 * number
    if not number or r.random() < 0.4:  # the header, or the lengths of streams
        return damaged(r, data[:at], as_long=r.random() < 0.8) + data[at:]
    i, rows = r.randrange(number), bytearray(data[table:at])
    lengths = [struct.unpack_from("<Q", rows, 16 * k)[0] for k in range(number)]
    at += sum(lengths[:i])
    stream, rest = data[at : at + lengths[i]], data[at + lengths[i] :]
    (size,) = struct.unpack_from("<Q", rows, 16 * i + 8)
    content = r.choice([bytes(min(size, 10**5)), bytes(10**6), r.randbytes(min(size, 4000))])
    skipped = b"\x50\x2a\x4d\x18\2\0\0\0ab" + stream
    others = [damaged(r, stream), zstandard.ZstdCompressor(1).compress(content), skipped]
    (new,) = r.choices(others, [6, 2, 1])
    struct.pack_into("<Q", rows, 16 * i, len(new))
    return data[:table] + bytes(rows) + data[table + len(rows) : at] + new + rest


def _glb(r: random.Random, data: bytes, other: bytes) -> bytes:
    (length,) = struct.unpack_from("<I", data, 12)
    text, body = data[20 : 20 + length], data[28 + length :]
    if r.random() < 0.7:
        text = _json(r, text)
    else:
        body = damaged(r, body, as_long=r.random() < 0.8)
    text += b" " * (-len(text) % 4)
    chunks = ((b"JSON", text), (b"BIN\0", body))
    content = b"".join(struct.pack("<I", len(each)) + name + each for name, each in chunks)
    found = b"glTF" + struct.pack("<II", 2, 12 + len(content)) + content
    return damaged(r, found[:28], as_long=True) + found[28:] if r.random() < 0.1 else found


def _sog(r: random.Random, data: bytes, other: bytes) -> bytes:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        files = [(name, archive.read(name)) for name in archive.namelist()]
    i, way = r.randrange(len(files)), r.randrange(8)
    name, content = files[i]
    if way == 0:
        files = _list(r, files, [(name, each) for _, each in files])
    elif way == 1:
        files[i] = (name, bytes(r.choice([0, 1000, 10**6])))
    elif way == 2 and name != "meta.json":  # another size, or pixels that lost something
        size = r.choice([(1, 1), (8, 8), (192, 2), (512, 1), (300, 300), (16000, 1)])
        image, out = Image.new("RGBA", size, (r.choice([0, 252, 255]),) * 4), io.BytesIO()
        image.save(out, "WEBP", exact=True, quality=0, method=0, lossless=r.random() < 0.9)
        files[i] = (name, out.getvalue())
    elif way == 3:
        files[i] = (name, damaged(r, content, as_long=r.random() < 0.5))
    else:
        files = [(n, _json(r, each) if n == "meta.json" else each) for n, each in files]
    out = io.BytesIO()
    packing = r.choice([zipfile.ZIP_STORED] * 6 + [zipfile.ZIP_DEFLATED] * 3 + [zipfile.ZIP_LZMA])
    with zipfile.ZipFile(out, "w", packing) as archive:
        for name, content in dict(files).items():
            archive.writestr(zipfile.ZipInfo(name), content, packing)
    found = out.getvalue()
    if r.random() < 0.1:  # the list of files, and its end
        return found[:-600] + damaged(r, found[-600:], as_long=True)
    return found


def _photo(r: random.Random, data: bytes, other: bytes) -> bytes:
    """Change a chunk of a PNG and give it a valid checksum."""
    if data[:8] != PNG:
        return damaged(r, data)
    chunks, at = [], len(PNG)
    while at + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + length]))
        at += 12 + length
    i = r.randrange(len(chunks))
    name, content = chunks[i]
    if name == b"IDAT" and r.random() < 0.5:
        content = zlib.compress(damaged(r, zlib.decompress(content)))
    else:
        content = damaged(r, content)
    chunks[i] = (r.choice([name] * 9 + [b"tRNS", b"eXIf", b"acTL"]), content)
    chunks = _list(r, chunks, chunks) if r.random() < 0.1 else chunks
    rows = [(struct.pack(">I", len(each)), name + each) for name, each in chunks]
    return PNG + b"".join(n + each + struct.pack(">I", zlib.crc32(each)) for n, each in rows)


def _file_of_a_capture(r: random.Random, data: bytes, other: bytes) -> bytes:
    """Change a file behind the byte that chooses it."""
    content = data[1:]
    if content[:4] == b"ply\n":
        return data[:1] + _ply(r, content, other)
    if content[:1] == b"{":
        return data[:1] + _json(r, content)
    change = damaged if b"\0" in content or r.random() < 0.4 else _text
    return data[:1] + change(r, content)


FORMATS: dict[str, Callable[[random.Random, bytes, bytes], bytes]] = {
    "mgs": _mgs, "ply": _ply, "compressed": _ply, "spz": _spz, "sog": _sog, "glb": _glb,
    "splat": lambda r, data, other: damaged(r, data), "image": _photo,
    "colmap": _file_of_a_capture, "transforms": _file_of_a_capture,
}  # fmt: skip
