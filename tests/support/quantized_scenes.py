"""Small quantised scenes with codebooks, and functions that split their files.

`tests/conftest.py` registers the fixture `data`: PYTEST_DONT_REWRITE, since test files import this
module first.
"""

import json
import struct
import zlib
from dataclasses import replace
from typing import Any

import pytest
import torch
from torch import Tensor

from mobilegs.camera import Camera, look_at
from mobilegs.mgs.codec import encode_mgs
from mobilegs.mgs.container import PREFIX
from mobilegs.mgs.encode import encode_scene
from mobilegs.mgs.positions import PositionGrid
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render import Weighting
from mobilegs.render.view_network import ViewNetwork
from mobilegs.representation.appearance import AppearanceDecoder
from mobilegs.representation.codebooks import CUTS, Attribute, SubVectorCodebooks
from mobilegs.representation.lobes import LobeDecoder, LobeShape

SIZES: dict[Attribute, int] = {"scale": 5, "rotation": 16, "appearance": 37, "opacity": 1}


# lobe decoders by name
SHAPES = {
    "lobes": LobeShape(2, 6),
    "decoded": LobeShape(1, 0, (7, 5)),
    "all by latents": LobeShape(3, 6, (8,)),
}
SHAPE = {"degree": 2, "latents": 6, "hidden": []}  # "lobes" as a header has it
VIEWS = ["nothing", "network", *SHAPES]


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def camera() -> Camera:
    viewmat = look_at(torch.tensor([0.3, 0.1, -4.0]), torch.zeros(3), torch.tensor([0.0, -1, 0]))
    K = torch.tensor([[40.1, 0, 16], [0, 41.7, 12], [0, 0, 1]])
    return Camera(viewmat, K, 32, 24)


def make_scene(count: int = 40, *, view: str = "lobes", seed: int = 0) -> QuantizedScene:
    g = seeded(seed)
    decoder = LobeDecoder(SHAPES[view], g) if view in SHAPES else None
    books: dict[Attribute, SubVectorCodebooks] = {}
    for name, cut in CUTS.items():
        centers = 0.5 * torch.randn(cut.count, SIZES[name], cut.length, generator=g)
        indices = torch.randint(SIZES[name], (count, cut.count), generator=g)
        books[name] = SubVectorCodebooks(centers - 1.5 * (name == "scale"), indices)
    if view in ("lobes", "all by latents"):
        centers = torch.randn(SHAPES[view].latents // 2, 8, 2, generator=g)
        books["lobes"] = SubVectorCodebooks(centers, torch.randint(8, (count, 3), generator=g))
    if view == "all by latents":
        books.pop("opacity")
    scene = encode_scene(
        torch.randn(count, 3, generator=g),
        books,
        PositionGrid(torch.tensor([0.1, -0.2, 0.3]), 1.7),
        AppearanceDecoder(g),
        decoder,
        ViewNetwork(g) if view == "network" else None,
    )
    return replace(
        scene,
        weighting=Weighting(exponent_max=6.5),
        background=torch.tensor([0.1, 0.5, 1.0]),
        near=0.05,
        views=[camera(), camera().resized(64, 48)],
        meta={"generator": "mobilegs 0", "psnr": 25.1, "steps": 7, "test": True, "notes": None},
    )


def tensors(scene: QuantizedScene) -> list[Tensor]:
    """Return all tensors of a scene."""
    groups = (scene.indices, scene.codebooks, scene.decoder, scene.lobe_decoder, scene.network)
    return [scene.positions, *(value for group in groups for value in (group or {}).values())]


@pytest.fixture(scope="module")
def data() -> bytes:
    return encode_mgs(make_scene())


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
