"""LOD levels of `.mgs` files: round trips, order, and prefixes that are scenes."""

from dataclasses import replace

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.mgs.lod import lod_levels_for, pixel_contributions, with_lod_levels
from mobilegs.mgs.quantized_scene import QuantizedScene, scenes_equal
from mobilegs.render.project import ALPHA_MIN, CLASSIC
from mobilegs.render.scene import Scene
from mobilegs.representation.appearance import LATENTS
from mobilegs.representation.codebooks import CUTS
from mobilegs.representation.lobes import LobeShape
from mobilegs.representation.uniform_quantizer import StepSizes
from mobilegs.train.student.config import ColorConfig, QuantizationConfig, StudentConfig
from mobilegs.train.student.view_dependence import ViewDependence
from tests.support.quantized_scenes import join, split
from tests.support.scene_cases import CASES, Case, make_scene
from tests.support.scenes import camera, random_scene
from tests.support.selection import few

VIEWS = [view.to("cpu", torch.float32) for view in (camera(), camera(33, 21))]
MANY = [name for name, case in CASES.items() if case.count >= 60]


def in_levels(coded: QuantizedScene, count: int) -> QuantizedScene:
    return with_lod_levels(coded, count, VIEWS)


def rows_of(coded: QuantizedScene) -> list[tuple]:
    """Return all codes of each Gaussian, sorted."""
    parts = [coded.positions.double(), *(codes.double() for codes in coded.indices.values())]
    return sorted(map(tuple, torch.cat(parts, dim=1).tolist()))


def minor(coded: QuantizedScene) -> int:
    """Return the least minor version 3.x that can hold a scene."""
    joint = any(cut.length > 2 for name, cut in coded.cuts.items() if name in CUTS)
    if joint or coded.color.colors == "latent_networks":
        return 4
    if coded.color.latents > 2 * LATENTS:
        return 3
    if coded.color.colors == "linear":
        return 2
    return int(coded.weighting.alpha_min != ALPHA_MIN)


@pytest.mark.parametrize("name", few(MANY, "one hidden layer", "scalars", "network"))
def test_a_scene_in_lod_levels_round_trips_with_the_same_gaussians(name: str) -> None:
    whole = make_scene(CASES[name])
    for count in (2, 3) if len(whole) < 5000 else (3,):
        coded = in_levels(whole, count)
        data = encode_mgs(coded)
        found = decode_mgs(data)
        assert scenes_equal(found, coded) and encode_mgs(found) == data
        assert not scenes_equal(found, replace(found, lod_sizes=()))
        assert rows_of(found) == rows_of(whole)
        assert len(found.lod_sizes) == count and sum(found.lod_sizes) == len(whole)
        assert inspect(data).get("layers") == list(found.lod_sizes)
        version = f"3.{minor(whole)}" if whole.footprint == CLASSIC else "4.0"
        assert inspect(data)["version"] == version


def test_each_level_has_four_times_as_many_gaussians_of_less_contribution() -> None:
    whole = make_scene(CASES["one hidden layer"])
    coded = with_lod_levels(whole, 4, VIEWS)
    assert coded.lod_sizes == (7, 24, 94, 375)
    seen = pixel_contributions(coded.decode(), VIEWS)
    least = [float(seen[rows].min()) for rows in coded.lod_slices()]
    most = [float(seen[rows].max()) for rows in coded.lod_slices()]
    assert all(before >= after for before, after in zip(least, most[1:], strict=False))
    assert scenes_equal(with_lod_levels(coded, 1, VIEWS), whole.sorted())


@pytest.mark.parametrize("name", ["one hidden layer", "scalars", "network"])
def test_a_file_up_to_the_end_of_a_level_is_a_coarser_scene(name: str) -> None:
    coded = in_levels(make_scene(CASES[name]), 3)
    header, body = split(encode_mgs(coded))
    for kept in (1, 2):
        table, size = [], 0
        for row in header["streams"]:
            if int((row["name"] + "@0").split("@")[1]) < kept:
                table.append(row)
                size += row["bytes"] + -row["bytes"] % 8
        count = sum(coded.lod_sizes[:kept])
        shorter = {"layers": list(coded.lod_sizes[:kept]), "count": count, "streams": table}
        found = decode_mgs(join({**header, **shorter}, body[:size], version=(3, 0)))
        assert scenes_equal(
            found, replace(coded.select(slice(count)), lod_sizes=coded.lod_sizes[:kept])
        )


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
    assert [lod_levels_for(n) for n in (1, 39_999, 40_000, 159_999, 160_000, 500_000, 1 << 26)] == [
        *(1, 1, 2, 2, 3, 3, 7)
    ]


@pytest.mark.parametrize("count", [0, 9, 61])
def test_invalid_numbers_of_levels_are_refused(count: int) -> None:
    with pytest.raises(InputError, match="cannot be"):
        in_levels(make_scene(CASES["one place"]), count)


@pytest.mark.parametrize(
    "layers",
    [
        *([], [60, 0], [61, -1], [30, 29], [30, 30.5], [30, True], "60", None),
        *([[30], 30], {"0": 60}, [52, 1, 1, 1, 1, 1, 1, 1, 1], [1 << 70, 1]),
    ],
)
def test_invalid_sizes_of_levels_are_refused(layers: object) -> None:
    header, body = split(encode_mgs(in_levels(make_scene(CASES["one place"]), 2)))
    assert header["layers"] == [15, 45]
    with pytest.raises(InputError, match="layers"):
        decode_mgs(join({**header, "layers": layers}, body, version=(3, 0)))
    del header["layers"]
    with pytest.raises(InputError, match="layers"):
        decode_mgs(join(header, body, version=(3, 0)))


def test_files_of_version_2_have_no_levels_even_with_a_field_layers() -> None:
    data = encode_mgs(make_scene(CASES["one place"]))
    header, body = split(data)
    found = decode_mgs(join({**header, "layers": [7]}, body, version=(2, 1)))
    assert scenes_equal(found, decode_mgs(data)) and found.lod_sizes == ()


def test_a_level_without_its_streams_is_refused() -> None:
    data = encode_mgs(in_levels(make_scene(CASES["one place"]), 2))
    header, body = split(data)
    for row in header["streams"]:
        if row["name"] == "scale.1@1":
            row["name"] = "scale.1@2"
    with pytest.raises(InputError, match=r"lacks its stream 'scale\.1@1'"):
        decode_mgs(join(header, body, version=(3, 0)))


def test_scenes_with_too_many_streams_are_refused() -> None:
    case = Case(100, LobeShape(0, 32), steps=StepSizes())
    encode_mgs(in_levels(make_scene(case), 5))
    with pytest.raises(InputError, match="256 are allowed"):
        encode_mgs(in_levels(make_scene(case), 6))


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
    case = Case(400, shape, steps=StepSizes(), colors="linear", color_latents=12)
    scene = make_scene(case)
    assert scenes_equal(decode_mgs(encode_mgs(in_levels(scene, 7))), in_levels(scene, 7))
    with pytest.raises(InputError, match="256 are allowed"):
        encode_mgs(in_levels(scene, 8))
