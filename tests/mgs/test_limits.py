"""Scenes that a `.mgs` cannot hold, and headers with invalid fields."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.mgs import header as headers
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.mgs.positions import PositionGrid
from mobilegs.mgs.quantized_scene import QuantizedScene, scenes_equal
from mobilegs.render import Weighting
from mobilegs.representation import lobes as lobe_shapes
from mobilegs.representation.codebooks import Attribute
from mobilegs.representation.lobes import LobeDecoder, LobeShape
from tests.support.quantized_scenes import SHAPE, camera, join, make_scene, seeded, split


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"positions": torch.full((40, 3), torch.inf).half()}, "positions"),
        ({"grid": PositionGrid(torch.zeros(3), torch.nan)}, "radius"),
        ({"grid": PositionGrid(torch.zeros(3), 1.0, 15)}, "exponent"),
        ({"background": torch.tensor([0.0, 2.0, 0.0])}, "background"),
        ({"near": 0.0}, "near"),
        ({"weighting": Weighting(sigma=0.0)}, "sigma"),
        ({"views": [camera()] * 65}, "views"),
        ({"views": [replace(camera(), width=0)]}, "0 x 24"),
        ({"views": [replace(camera(), K=-camera().K)]}, "camera"),
        ({"views": [replace(camera(), viewmat=torch.full((4, 4), torch.nan))]}, "camera"),
        ({"meta": {"psnr": float("nan")}}, "psnr"),
        ({"meta": {"story": "x" * 5000}}, "story"),
        ({"meta": {str(i): i for i in range(65)}}, "65 notes"),
        ({"decoder": {}}, "decoder"),
        ({"indices": {}}, "scale"),
        ({"lobe_decoder": {}}, "lobe decoder"),
        ({"lobe_shape": None, "lobe_decoder": {}}, "no decoder for them"),
        ({"lobe_shape": LobeShape(2, 4)}, "do not hold 4 latents"),
        ({"lobe_shape": LobeShape(2, 0)}, "no decoder for them"),
        ({"network": make_scene(view="network").network}, "remove one of them"),
    ],
)
def test_a_scene_that_a_file_cannot_hold_is_refused(change: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        encode_mgs(replace(make_scene(), **change))


@pytest.mark.parametrize(
    ("lobes", "sentence"),
    [
        (0, "field 'lobes'"),
        ([], "field 'lobes'"),
        ({}, "field 'hidden'"),
        ({**SHAPE, "degree": 4}, "field 'degree'"),
        ({**SHAPE, "degree": -1}, "field 'degree'"),
        ({**SHAPE, "degree": True}, "field 'degree'"),
        ({**SHAPE, "degree": 1}, "'lobe-decoder' of the .mgs file has a wrong length"),
        ({**SHAPE, "latents": 5}, "field 'codebooks.lobes'"),
        ({**SHAPE, "hidden": [0]}, "field 'hidden'"),
        ({**SHAPE, "hidden": [10**9]}, "field 'hidden'"),
        ({**SHAPE, "hidden": [5.0]}, "'lobe-decoder' of the .mgs file has a wrong length"),
        ({**SHAPE, "hidden": [5.5]}, "field 'hidden'"),
        ({**SHAPE, "hidden": [True]}, "field 'hidden'"),
        ({**SHAPE, "hidden": None}, "field 'hidden'"),
        (None, "field 'codebooks.lobes'"),
    ],
)
def test_invalid_lobe_shapes_are_refused(data: bytes, lobes: Any, sentence: str) -> None:
    header, body = split(data)
    assert header["lobes"] == SHAPE
    with pytest.raises(InputError, match=sentence):
        decode_mgs(join({**header, "lobes": lobes}, body))


def test_a_header_without_the_field_lobes_is_refused(data: bytes) -> None:
    header, body = split(data)
    del header["lobes"]
    with pytest.raises(InputError, match="field 'lobes'"):
        decode_mgs(join(header, body))


@pytest.mark.parametrize(
    ("limit", "shape", "beyond", "field"),
    [
        ("LATENTS_MAX", (1, 32), (1, 33), "latents"),
        ("HIDDEN_LAYERS", (1, 2, (3,) * 3), (1, 2, (3,) * 4), "lobes.hidden"),
        ("HIDDEN_MAX", (1, 2, (256,)), (1, 2, (257,)), "hidden"),
    ],
)
def test_lobe_decoders_at_the_limits_are_read_and_larger_ones_refused(
    limit: str, shape: tuple, beyond: tuple, field: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def with_lobes(shape: LobeShape) -> QuantizedScene:
        g, scene = seeded(), make_scene(view="decoded")
        books = {"lobes": torch.randn(shape.latents, 4, 1, generator=g).half()}
        rows = torch.randint(4, (len(scene), shape.latents), generator=g, dtype=torch.int16)
        weights = LobeDecoder(shape, g).named_parameters()
        return replace(
            scene,
            codebooks=scene.codebooks | books,
            indices=scene.indices | {"lobes": rows},
            lobe_shape=shape,
            lobe_decoder={name: value.detach().half() for name, value in weights},
        ).sorted()

    largest = with_lobes(LobeShape(*shape))
    assert scenes_equal(decode_mgs(encode_mgs(largest)), largest)
    with monkeypatch.context() as patch:
        for module in (lobe_shapes, headers):
            patch.setattr(module, limit, getattr(module, limit) + 1)
        larger = with_lobes(LobeShape(*beyond))
        data = encode_mgs(larger)
        assert scenes_equal(decode_mgs(data), larger)  # it has no other error
    for read in (inspect, decode_mgs):
        with pytest.raises(InputError, match=f"the field '{field}' in the header"):
            read(data)


@pytest.mark.parametrize(
    "book",
    [None, [], {}, {"count": 33, "length": 1, "size": 8}, {"count": 3, "length": 1, "size": 8},
     {"count": 3, "length": 2, "size": 0}, {"count": 3, "length": 2, "size": 5000}],
)  # fmt: skip
def test_invalid_lobe_codebooks_are_refused_from_the_header(data: bytes, book: Any) -> None:
    header, body = split(data)
    assert header["codebooks"]["lobes"] == {"count": 3, "length": 2, "size": 8}
    with pytest.raises(InputError, match=r"lobes|count|length|size"):
        inspect(join({**header, "codebooks": {**header["codebooks"], "lobes": book}}, body))
    without = {name: b for name, b in header["codebooks"].items() if name != "lobes"}
    with pytest.raises(InputError, match=r"codebooks\.lobes"):
        inspect(join({**header, "codebooks": without}, body))


def _set(*path: str | int, to: Any) -> Callable[[dict[str, Any]], None]:
    """Return a function that sets a value inside of a header."""

    def change(header: dict[str, Any]) -> None:
        inner: Any = header
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = to

    return change


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (_set("positions", "radius", to=1e21), "centre or radius"),
        (_set("positions", "radius", to=0.0), "centre or radius"),
        (_set("positions", "center", 1, to=-1e21), "centre or radius"),
        (_set("near", to=-1), "near plane -1.0 is out of range"),
        (_set("near", to=1e21), "near plane"),
        (_set("background", 2, to=1.5), "background colour"),
        (_set("weighting", "sigma", to=-1), "sigma"),
        (_set("weighting", "background_weight", to=-0.1), "background weight"),
        (_set("views", 0, "K", 0, to=-5.0), "focal length"),
        (_set("views", 1, "K", 8, to=2.0), "matrices are not those of a camera"),
        (_set("views", 1, "viewmat", 12, to=0.5), "matrices are not those of a camera"),
    ],
)
def test_numbers_out_of_range_are_refused_from_the_header(
    data: bytes, change: Callable[[dict[str, Any]], None], sentence: str
) -> None:
    header, body = split(data)
    change(header)
    for read in (inspect, decode_mgs):
        with pytest.raises(InputError, match=sentence):
            read(join(header, body))


def test_lobes_with_a_network_and_a_missing_opacity_are_refused(data: bytes) -> None:
    header, body = split(data)
    with pytest.raises(InputError, match="only one of them"):
        inspect(join({**header, "network": True}, body))
    books = {name: b for name, b in header["codebooks"].items() if name not in ("opacity", "lobes")}
    with pytest.raises(InputError, match="opacity"):
        inspect(join({**header, "codebooks": books, "lobes": None}, body))


def test_an_empty_scene_is_refused() -> None:
    scene = make_scene()
    nothing = {name: rows[:0] for name, rows in scene.indices.items()}
    with pytest.raises(InputError, match="0 Gaussians"):
        encode_mgs(replace(scene, positions=scene.positions[:0], indices=nothing))


@pytest.mark.parametrize("name", ["scale", "rotation", "appearance", "opacity", "lobes"])
def test_codes_out_of_range_are_refused(name: Attribute) -> None:
    scene = make_scene()
    scene.indices[name][3] = scene.codebooks[name].shape[1]
    with pytest.raises(InputError, match=f"{name} indices"):
        encode_mgs(scene)
    scene = make_scene()
    scene.codebooks[name][0, 0] = torch.inf
    with pytest.raises(InputError, match=f"{name} codebooks"):
        encode_mgs(scene)


def test_weights_that_are_not_finite_are_refused() -> None:
    scene = make_scene()
    scene.decoder["view1"][0, 0] = torch.nan
    with pytest.raises(InputError, match="colour decoder"):
        encode_mgs(scene)
