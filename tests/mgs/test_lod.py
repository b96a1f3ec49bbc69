"""LOD levels of `.mgs` files: round trips, order, and prefixes that are scenes."""

from dataclasses import replace

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.mgs.lod import lod_levels_for, pixel_contributions, with_lod_levels
from mobilegs.mgs.quantized_scene import QuantizedScene, scenes_equal
from mobilegs.render.scene import Scene
from mobilegs.representation.lobes import LobeShape
from mobilegs.representation.uniform_quantizer import StepSizes
from mobilegs.train.student.config import ColorConfig, QuantizationConfig, StudentConfig
from mobilegs.train.student.view_dependence import ViewDependence
from tests.support.mgs_parts import parse_parts
from tests.support.scene_cases import CASES, Case, make_scene
from tests.support.scenes import camera, random_scene

VIEWS = [view.to("cpu", torch.float32) for view in (camera(), camera(33, 21))]


def in_levels(coded: QuantizedScene, count: int) -> QuantizedScene:
    return with_lod_levels(coded, count, VIEWS)


def rows_of(coded: QuantizedScene) -> list[tuple]:
    """Return all codes of each Gaussian, sorted."""
    parts = [coded.positions.double(), *(codes.double() for codes in coded.indices.values())]
    return sorted(map(tuple, torch.cat(parts, dim=1).tolist()))


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("one hidden layer", "3.0"),
        ("scalars with lobes", "3.1"),
        ("linear colours", "3.2"),
        ("colours of all directions", "3.3"),
        ("the paper's", "3.4"),
        ("antialiased", "4.0"),
    ],
)
def test_a_scene_in_lod_levels_round_trips_with_the_same_gaussians(name: str, version: str) -> None:
    whole = make_scene(CASES[name])
    coded = in_levels(whole, 3)
    data = encode_mgs(coded)
    found = decode_mgs(data)
    assert scenes_equal(found, coded) and encode_mgs(found) == data
    assert not scenes_equal(found, replace(found, lod_sizes=()))
    assert rows_of(found) == rows_of(whole)
    assert len(found.lod_sizes) == 3 and sum(found.lod_sizes) == len(whole)
    report = inspect(data)
    assert (report.get("layers"), report["version"]) == (list(found.lod_sizes), version)


def test_each_level_has_four_times_as_many_gaussians_of_less_contribution() -> None:
    whole = make_scene(CASES["one hidden layer"])
    coded = with_lod_levels(whole, 4, VIEWS)
    assert coded.lod_sizes == (7, 24, 94, 375)
    seen = pixel_contributions(coded.decode(), VIEWS)
    least = [float(seen[rows].min()) for rows in coded.lod_slices()]
    most = [float(seen[rows].max()) for rows in coded.lod_slices()]
    assert all(before >= after for before, after in zip(least, most[1:], strict=False))
    assert scenes_equal(with_lod_levels(coded, 1, VIEWS), whole.sorted())


@pytest.mark.parametrize("name", ["network", "scalars sorted, fine"])
def test_a_file_up_to_the_end_of_a_level_is_a_coarser_scene(name: str) -> None:
    coded = in_levels(make_scene(CASES[name]), 3)
    for kept in (1, 2):
        parts, sizes = parse_parts(encode_mgs(coded)), coded.lod_sizes[:kept]
        parts.pieces = [p for p in parts.pieces if int((p.name + "@0").split("@")[1]) < kept]
        parts.header |= {"layers": list(sizes), "count": sum(sizes)}
        found = decode_mgs(parts.to_bytes())
        assert scenes_equal(found, replace(coded.select(slice(sum(sizes))), lod_sizes=sizes))


@pytest.mark.parametrize("blend", ["sortfree", "sorted"])
def test_contributions_are_the_weights_of_the_colours(blend: str) -> None:
    made = {name: value.float() for name, value in random_scene(300, degree=0).items()}
    colors = torch.rand(300, 3)
    sh = (colors[:, None] - 0.5) / 0.28209479
    opacities = made["opacities"].clamp(1e-4, 1 - 1e-4).logit()
    gaussians = Gaussians(made["means"], made["quats"], made["scales"].log(), opacities, sh)
    scene = Scene(gaussians, blend, lobes=made["lobes"] if blend == "sortfree" else None)
    seen = pixel_contributions(scene, VIEWS[:1])
    expected = scene.render(VIEWS[0]).image.sum((0, 1))
    assert torch.allclose(seen @ colors, expected, rtol=1e-4)
    assert (seen >= 0).all() and (seen > 0).any()


def test_contributions_of_a_scene_with_a_view_network_use_its_colours() -> None:
    scene = make_scene(CASES["network"]).decode()
    seen = pixel_contributions(scene, VIEWS[:1])
    assert seen.shape == (120,) and seen.isfinite().all() and (seen > 0).any()


def test_the_number_of_levels_grows_with_the_scene() -> None:
    counts = (39_999, 40_000, 159_999, 160_000, 1 << 26)
    assert [lod_levels_for(count) for count in counts] == [1, 2, 2, 3, 7]


@pytest.mark.parametrize("count", [0, 9, 61])
def test_invalid_numbers_of_levels_are_refused(count: int) -> None:
    with pytest.raises(InputError, match="cannot be"):
        in_levels(make_scene(CASES["one place"]), count)


@pytest.mark.parametrize(
    "layers",
    [
        *([60, 0], [30, 29], [30, 30.5], "60", [52, 1, 1, 1, 1, 1, 1, 1, 1], [1 << 70, 1]),
    ],
)
def test_invalid_sizes_of_levels_are_refused(layers: object) -> None:
    parts = parse_parts(encode_mgs(in_levels(make_scene(CASES["one place"]), 2)))
    assert parts.header["layers"] == [15, 45]
    parts.header["layers"] = layers
    with pytest.raises(InputError, match="layers"):
        decode_mgs(parts.to_bytes())


def test_sizes_of_levels_must_add_up() -> None:
    coded = make_scene(CASES["one place"])
    with pytest.raises(InputError, match="do not add up to 60"):
        encode_mgs(replace(coded, lod_sizes=(30, 31)))
    with pytest.raises(InputError, match="9 LOD levels: 8"):
        encode_mgs(replace(coded, lod_sizes=(52, 1, 1, 1, 1, 1, 1, 1, 1)))


def test_a_student_has_no_more_layers_than_its_file_has_streams_for() -> None:
    asked = StudentConfig(color=ColorConfig(latents=12), view_dependence=ViewDependence(latents=12))
    assert asked.max_lod_levels == 7 and StudentConfig().max_lod_levels == 8
    with pytest.raises(InputError, match="at most 7 levels"):
        replace(asked, quantization=QuantizationConfig(lod_levels=8))
    most = StudentConfig(view_dependence=ViewDependence(degree=3, latents=32))
    shape = most.view_dependence.shape
    assert shape and shape.latents == 32 and most.max_lod_levels == 5
    shape = LobeShape(2, 12, (16,))
    case = Case(60, shape, steps=StepSizes(), colors="linear", color_latents=12)
    scene = make_scene(case)
    assert len(decode_mgs(encode_mgs(in_levels(scene, 7))).lod_sizes) == 7
    with pytest.raises(InputError, match="256 are allowed"):
        encode_mgs(in_levels(scene, 8))
