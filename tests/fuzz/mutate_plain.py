"""Mutate bytes, `.ply` and `.spz`; `mutate.py` has the `.mgs`."""

import random
import struct
import zlib

import zstandard

from tests.fuzz.seeds import spz_4

NUMBERS = [
    0, -1, 1, 2, 3, 4, 5, 7, 8, 15, 16, 31, 32, 33, 48, 49, 63, 64, 65, 127, 128, 255, 256, 257,
    4095, 4096, 4097, 2**14, 2**14 + 1, -(2**14), 2**15, 2**16 - 1, 2**16, 2**20, 2**26, 2**26 + 1,
    2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**40, 2**53, 2**63, 2**64, 10**400, -(10**400),
    0.5, -0.5, 1.5, 1e-5, 1e-20, 1e20, 1.0000001e20, -1e20, 80, 80.5, 1000, 1e-300, 1e300, 3e38,
    3.3e38, -3e38, 5e-324,
]  # fmt: skip
WORDS = [0, 1, 2, 3, 49, 64, 65, 256, 4096, 2**14, 2**15, 2**16 - 1, 2**16, 2**31, 2**32 - 1]


def damaged(r: random.Random, data: bytes, *, as_long: bool = False) -> bytes:
    """Change, cut off, move and repeat bytes, without knowledge of the format."""
    found = bytearray(data)
    for _ in range(1 if r.random() < 0.5 else r.randrange(2, 6)):
        if not found:
            break
        # half of the time near the start, which has headers
        at = r.randrange(len(found) if r.random() < 0.5 else min(len(found), 64))
        end = min(len(found), at + (1 << r.randrange(8)))
        way = r.randrange(2 if as_long else 8)
        if way == 0:
            found[at] ^= 1 << r.randrange(8)
        elif way == 1:
            found[at] = r.randrange(256)
        elif way == 2:
            del found[at:]
        elif way == 3:
            del found[at:end]
        elif way == 4:
            found[at:at] = found[at:end]
        elif way == 5:
            found[at:end] = r.choice([b"\0", b"\xff"]) * (end - at)
        elif way == 6:
            found[at : at + 4] = struct.pack("<I", r.choice(WORDS))
        else:
            found += r.randbytes(r.randrange(1, 40))
    return bytes(found)


# --- .ply


def mutated_ply(r: random.Random, data: bytes, files: list[bytes]) -> bytes:
    head, end, body = data.partition(b"end_header\n")
    lines = head.split(b"\n")[:-1]
    for _ in range(1 if r.random() < 0.6 else r.randrange(2, 4)):
        if not lines:
            break
        i, way = r.randrange(len(lines)), r.randrange(12)
        if way == 0:
            del lines[i]
        elif way == 1:
            lines.insert(r.randrange(len(lines) + 1), lines[i])
        elif way == 2:
            lines[i] = damaged(r, lines[i])
        elif way < 6:  # a word
            words = lines[i].split(b" ")
            number = str(r.choice(NUMBERS)).encode()
            names = [b"vertex", b"list", b"float", b"uchar", b"double", b"char", b"x", b"f_rest_0"]
            words[r.randrange(len(words))] = r.choice([*names, b"\xff", b"\x1b[2J", number, number])
            lines[i] = b" ".join(words)
        elif way == 6:
            where = [b"element face 4", b"element a 999999999999999999", b"element b 0"]
            more = [r.choice(where), *[b"property double q"] * r.randrange(3)]
            lines[i:i] = r.choice(
                [more, [b"property list uchar int v"], [b"comment " + b"x" * 70000]]
            )
        elif way == 7:
            body = damaged(r, body)
        elif way == 8 and len(body) > 4:  # what is no number
            at = r.randrange(len(body) - 4)
            body = body[:at] + r.choice(
                [b"\0\0\xc0\x7f", b"\0\0\x80\x7f", b"nan ", b" inf", b"1e99"]
            )
            body += data[-(len(body) - at) :]
        elif way == 9:
            lines = [
                b" ".join([*line.split(b" ")[:2], str(r.choice(NUMBERS)).encode()])
                if line.startswith(b"element vertex")
                else line
                for line in lines
            ]
        elif way == 10:
            body = body * r.choice([0, 2, 30]) + r.choice([b"", b"\n" * 2000, b"1 " * 2000])
        else:
            lines += [b"property char p%d" % k for k in range(r.choice([1, 100, 3000]))]
    ending = r.choice([b"\n"] * 20 + [b"\r\n", b"\r"])
    return ending.join([*lines, r.choice([end] * 20 + [b""]).replace(b"\n", ending)]) + body


# --- .spz


def mutated_spz(r: random.Random, data: bytes, files: list[bytes]) -> bytes:
    return _gzipped(r, data) if data[:2] == b"\x1f\x8b" else _streamed(r, data)


def _head(r: random.Random, head: bytearray) -> None:
    """A field of the first 16 bytes."""
    at, form = r.choice(
        [(4, "<I"), (8, "<I"), (8, "<I"), (12, "<B"), (13, "<B"), (14, "<B"), (15, "<B")]
    )
    (old,) = struct.unpack_from(form, head, at)
    new = r.choice([old + 1, old - 1, 0, 1, 2, 3, 4, 5, 24, 25, 255, 10_000_000, 2**24, 2**32 - 1])
    struct.pack_into(form, head, at, new % (1 << 8 * struct.calcsize(form)))


def _gzipped(r: random.Random, data: bytes) -> bytes:
    content = bytearray(zlib.decompress(data, wbits=31))
    for _ in range(r.randrange(1, 3)):
        way = r.randrange(6)
        if way < 3 and len(content) >= 16:
            _head(r, content)
        elif way == 3:
            content = bytearray(damaged(r, bytes(content)))
        elif way == 4:
            content += bytes(r.choice([1, 100, 10**6]))
        elif len(content) >= 12:
            struct.pack_into("<I", content, 8, r.choice([0, 1000, 100_000]))
            content += bytes(r.choice([0, 20_000]))
    zipper = zlib.compressobj(1, wbits=31)
    zipped = zipper.compress(bytes(content)) + zipper.flush()
    way = r.randrange(10)
    if way == 0:
        return zipped + r.choice([zipped, b"\0", b"rest"])
    return damaged(r, zipped) if way == 1 else zipped


def _streamed(r: random.Random, data: bytes) -> bytes:
    head = bytearray(data[:16])
    table, number = struct.unpack_from("<I", data, 16)[0], data[15]
    rows = [list(struct.unpack_from("<QQ", data, table + 16 * i)) for i in range(number)]
    streams, at = [], table + 16 * number
    for length, _ in rows:
        streams.append(data[at : at + length])
        at += length
    sizes = [size for _, size in rows]
    for _ in range(1 if r.random() < 0.6 else r.randrange(2, 4)):
        i, way = r.randrange(max(1, number)), r.randrange(9)
        if way < 2 or not streams:
            _head(r, head)
        elif way == 2:
            sizes[i] = r.choice(
                [0, 1, (sizes[i] + 1) % 2**64, 2 * sizes[i] % 2**64, 2**31, 2**40, 2**64 - 1]
            )
        elif way < 6:  # Zstandard's own bytes
            streams[i] = damaged(r, streams[i])
        elif way == 6:
            bomb = zstandard.ZstdCompressor(1).compress(
                bytes(r.choice([min(sizes[i], 10**5), 10**6]))
            )
            streams[i] = r.choice(
                [bomb, streams[i] + bomb, b"\x50\x2a\x4d\x18\2\0\0\0ab" + streams[i]]
            )
        elif way == 7:
            content = zstandard.ZstdCompressor(1).compress(r.randbytes(min(sizes[i], 4000)))
            streams[i] = content
        else:
            streams[i] = streams[r.randrange(len(streams))]
    rows_sent = r.choice([len(streams)] * 8 + [max(0, len(streams) - 1)])
    sealed = spz_4(
        bytes(head), streams[:rows_sent], sizes[:rows_sent], table=r.choice([32, 32, 40])
    )
    way = r.randrange(12)
    if way == 0:
        lie = bytearray(sealed)
        struct.pack_into("<I", lie, 16, r.choice([0, 16, 31, 33, len(sealed), 2**31, 2**32 - 1]))
        return bytes(lie)
    if way == 1 and rows_sent:
        lie = bytearray(sealed)
        at = struct.unpack_from("<I", sealed, 16)[0] + 16 * r.randrange(rows_sent)
        struct.pack_into("<Q", lie, at, r.choice([0, 1, len(sealed), 2**32, 2**63, 2**64 - 1]))
        return bytes(lie)
    return sealed
