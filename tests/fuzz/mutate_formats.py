"""Mutate `.splat`, `.glb` and `.sog`: their JSON, images and archives."""

import json
import random
import struct
import zipfile
from copy import deepcopy
from typing import Any

import numpy as np

from tests.fuzz.mutate_plain import NUMBERS, WORDS, damaged
from tests.fuzz.seeds_formats import glb, rezipped, unzipped, webp

ODD = [
    *NUMBERS, None, True, False, "", "x", "VEC3", "SCALAR", "meta.json", "../up", "a" * 5000,
    "\x1b[2J", "\ud800", [], {}, [[]], [None], [0.0] * 3, [1e300] * 3, [-1e300] * 256, [1] * 5000,
    ["quats.webp"] * 2, {"a": {}}, "KHR_gaussian_splatting", "NaN", 5120, 5121, 5122, 5123, 5125,
]  # fmt: skip
TEXTS = [b"", b"[]", b"1", b"{", b"[" * 9000, b"null", b'"\\ud800"', b'{"a":' + b"9" * 5000 + b"}"]
FLOATS = [b"\0\0\xc0\x7f", b"\0\0\x80\x7f", b"\0\0\x80\xff", b"\xff\xff\x7f\x7f", b"\0\0\0\x80"]


def mutated_splat(r: random.Random, data: bytes, files: list[bytes]) -> bytes:
    found = bytearray(data)
    for _ in range(r.randrange(1, 4)):
        at = 4 * r.randrange(len(found) // 4)
        found[at : at + 4] = r.choice([*FLOATS, b"\x80\x80\x80\x80", r.randbytes(4)])
    way = r.randrange(5)
    if way == 0:
        return bytes(found) * r.choice([2, 40, 2000])
    return bytes(found[: r.randrange(len(found) + 1)] if way == 1 else found)


def _places(value: Any, path: tuple = ()) -> list[tuple]:
    items: Any = ()
    if len(path) > 20:  # deeper than any valid file
        return []
    if isinstance(value, dict | list):
        items = value.items() if isinstance(value, dict) else enumerate(value[:8])
    return [
        place for key, inner in items for place in [(*path, key), *_places(inner, (*path, key))]
    ]


def _odd(r: random.Random, content: Any) -> None:
    """A value becomes another one, or goes, or comes twice."""
    places = _places(content)
    if not places:
        return
    *path, key = r.choice(places)
    inner = content
    for step in path:
        inner = inner[step]
    way, value = r.randrange(8), inner[key]
    if way == 0:
        del inner[key]
    elif way == 1 and isinstance(inner, list):
        inner[key:key] = [value] * r.choice([1, 2, 300])
    elif way < 5 and type(value) in (int, float) and abs(value) < 1e300:
        inner[key] = r.choice([value + 1, value - 1, 2 * value, -value, value * 0.5, 10 * value])
    else:
        inner[key] = deepcopy(r.choice(ODD))  # a later change is not to be one of ODD's


def mutated_json(r: random.Random, data: bytes) -> bytes:
    """Return JSON with other values, or other bytes."""
    way = r.randrange(12)
    if way == 0:
        return r.choice(TEXTS)
    if way == 1:
        return damaged(r, data)
    try:
        content = json.loads(data)
    except (ValueError, RecursionError):  # it was changed before
        return data
    for _ in range(1 if r.random() < 0.6 else r.randrange(2, 5)):
        _odd(r, content)
    return json.dumps(content).encode()


def mutated_glb(r: random.Random, data: bytes, files: list[bytes]) -> bytes:
    (length,) = struct.unpack_from("<I", data, 12)
    text, body = data[20 : 20 + length], data[28 + length :]
    if r.random() < 0.7:
        text = mutated_json(r, text)
    if r.random() < 0.3:
        body = damaged(r, body)
    if r.random() < 0.2 and len(body) > 8:
        at = 4 * r.randrange(len(body) // 4)
        body = body[:at] + r.choice(FLOATS) + body[at + 4 :]
    found = bytearray(glb(text, body))
    if r.random() < 0.15:  # lengths and kinds of chunks
        at = r.choice([0, 4, 8, 12, 16, len(found) - len(body) - 8, len(found) - len(body) - 4])
        struct.pack_into("<I", found, at, r.choice([*WORDS, len(found), len(found) - 1]))
    return bytes(found)


def mutated_sog(r: random.Random, data: bytes, files: list[bytes]) -> bytes:
    inside = unzipped(data)
    names = list(inside)
    for _ in range(1 if r.random() < 0.6 else r.randrange(2, 4)):
        name, way = r.choice(names), r.randrange(12)
        if way < 5:
            inside["meta.json"] = mutated_json(r, inside.get("meta.json", b"{}"))
        elif way == 5:
            inside.pop(name, None)
        elif way == 6:
            inside[name] = bytes(r.choice([0, 1000, 10**6]))
        elif way == 7 and name != "meta.json":
            inside[name] = inside.get(r.choice(names), b"")
        elif way < 10 and name.endswith(".webp") and inside.get(name):
            inside[name] = damaged(r, inside[name], as_long=r.random() < 0.5)
        elif name.endswith(".webp"):
            shape = r.choice([(1, 1), (8, 8), (2, 192), (1, 512), (1, 960), (300, 300), (1, 16000)])
            shade = r.choice([0, 252, 255, None])
            pixels = np.full((*shape, 4), shade or 0, np.uint8)
            if shade is None and shape[0] * shape[1] < 1000:
                pixels[:] = np.frombuffer(r.randbytes(pixels.size), np.uint8).reshape(pixels.shape)
            inside[name] = webp(pixels, lossless=r.random() < 0.9)
    packing = r.choice([zipfile.ZIP_STORED] * 6 + [zipfile.ZIP_DEFLATED] * 3 + [zipfile.ZIP_LZMA])
    found = bytearray(rezipped(inside, packing))
    if r.random() < 0.2:  # the list of files, and its end
        at = len(found) - 1 - r.randrange(min(len(found), 600))
        if r.random() < 0.5:
            found[at] = r.randrange(256)
        else:
            found[at : at + 4] = struct.pack("<I", r.choice(WORDS))
    return bytes(found)
