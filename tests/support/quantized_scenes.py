"""Functions that take `.mgs` files apart, and the file of a small scene with codebooks.

`tests/conftest.py` registers the fixture `data`: PYTEST_DONT_REWRITE, since test files import this
module first.
"""

import json
import struct
import zlib
from typing import Any

import pytest
from torch import Tensor

from mobilegs.mgs.codec import encode_mgs
from mobilegs.mgs.container import PREFIX
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.representation.lobes import LobeShape
from tests.support.scene_cases import Case, make_scene

SMALL = Case(40, LobeShape(2, 6), size=8)


def tensors(scene: QuantizedScene) -> list[Tensor]:
    """Return all tensors of a scene."""
    groups = (scene.indices, scene.codebooks, scene.decoder, scene.lobe_decoder, scene.network)
    return [scene.positions, *(value for group in groups for value in (group or {}).values())]


@pytest.fixture(scope="module")
def data() -> bytes:
    """The file of a small scene."""
    return encode_mgs(make_scene(SMALL))


def split(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the header of a file, and the bytes after it."""
    length = PREFIX.unpack_from(data)[3]
    return json.loads(data[PREFIX.size : PREFIX.size + length]), data[PREFIX.size + length :]


def join(header: dict[str, Any] | str, body: bytes, version: tuple[int, int] = (2, 1)) -> bytes:
    """Return a file with any header and a valid checksum."""
    text = (header if isinstance(header, str) else json.dumps(header)).encode()
    text += b" " * (-(PREFIX.size + len(text)) % 8)
    fixed = struct.pack("<HHI", *version, len(text))
    return (
        b"MGS\x1a\r\n\x00\x01" + fixed + struct.pack("<I", zlib.crc32(fixed + text)) + text + body
    )


def places(value: Any, path: tuple = ()) -> list[tuple]:
    """Return the path of every value inside a JSON value."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    found = []
    for key, inner in items:
        found.append((*path, key))
        if isinstance(inner, dict | list):
            found += places(inner, (*path, key))
    return found
