"""Scenes that a `.mgs` cannot hold, and headers with invalid fields."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.mgs.positions import PositionGrid
from mobilegs.representation.codebooks import Attribute
from mobilegs.representation.lobes import LobeShape
from tests.support.quantized_scenes import SMALL, join, split
from tests.support.scene_cases import Case, camera, make_scene

SHAPE = {"degree": 2, "latents": 6, "hidden": []}
NOTHING = {
    "positions": torch.zeros(0, 3).half(),
    "indices": {name: rows[:0] for name, rows in make_scene(SMALL).indices.items()},
}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"positions": torch.full((40, 3), torch.inf).half()}, "positions"),
        ({"grid": PositionGrid(torch.zeros(3), torch.nan)}, "radius"),
        ({"grid": PositionGrid(torch.zeros(3), 1.0, 15)}, "exponent"),
        ({"views": [camera()] * 65}, "views"),
        ({"views": [replace(camera(), width=0)]}, "0 x 24"),
        ({"views": [replace(camera(), viewmat=torch.full((4, 4), torch.nan))]}, "camera"),
        ({"meta": {"psnr": float("nan")}}, "psnr"),
        ({"meta": {"story": "x" * 5000}}, "story"),
        ({"meta": {str(i): i for i in range(65)}}, "65 notes"),
        ({"decoder": {}}, "decoder"),
        ({"indices": {}}, "scale"),
        (NOTHING, "0 Gaussians"),
        ({"lobe_decoder": {}}, "lobe decoder"),
        ({"lobe_shape": None, "lobe_decoder": {}}, "no decoder for them"),
        ({"lobe_shape": LobeShape(2, 4)}, "do not hold 4 latents"),
        ({"network": make_scene(Case(40, network=True)).network}, "remove one of them"),
    ],
)
def test_a_scene_that_a_file_cannot_hold_is_refused(change: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        encode_mgs(replace(make_scene(SMALL), **change))


@pytest.mark.parametrize(
    ("lobes", "sentence"),
    [
        ([], "field 'lobes'"),
        ({**SHAPE, "degree": True}, "field 'degree'"),
        ({**SHAPE, "degree": 1}, "'lobe-decoder' of the .mgs file has a wrong length"),
        ({**SHAPE, "latents": 5}, "field 'codebooks.lobes'"),
        ({**SHAPE, "hidden": [5.5]}, "field 'hidden'"),
        ({**SHAPE, "hidden": [257]}, "field 'hidden'"),
        ({**SHAPE, "hidden": [3] * 4}, "field 'lobes.hidden'"),
        ({**SHAPE, "latents": 33}, "field 'latents'"),
    ],
)
def test_invalid_lobe_shapes_are_refused(data: bytes, lobes: Any, sentence: str) -> None:
    header, body = split(data)
    assert header["lobes"] == SHAPE
    with pytest.raises(InputError, match=sentence):
        decode_mgs(join({**header, "lobes": lobes}, body))


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
        (_set("near", to=-1), "near plane -1.0 is out of range"),
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


@pytest.mark.parametrize("name", ["scale", "lobes"])
def test_codes_out_of_range_are_refused(name: Attribute) -> None:
    scene = make_scene(SMALL)
    scene.indices[name][3] = scene.codebooks[name].shape[1]
    with pytest.raises(InputError, match=f"{name} indices"):
        encode_mgs(scene)
    scene = make_scene(SMALL)
    scene.codebooks[name][0, 0] = torch.inf
    with pytest.raises(InputError, match=f"{name} codebooks"):
        encode_mgs(scene)


def test_weights_that_are_not_finite_are_refused() -> None:
    scene = make_scene(SMALL)
    scene.decoder["view1"][0, 0] = torch.nan
    with pytest.raises(InputError, match="colour decoder"):
        encode_mgs(scene)
