"""Layers of `.mgs` files: round trips, order, and beginnings that are scenes of their own."""

from dataclasses import replace

import pytest
import torch

from mobilegs.compress.appearance import LATENTS
from mobilegs.compress.lobes import LobeShape
from mobilegs.compress.uniform_quantizer import ScalarSteps
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import inspect, pack, unpack
from mobilegs.mgs.lod import layered, layers_for, seen_of_each
from mobilegs.mgs.quantized_scene import CodedScene, same
from mobilegs.render.project import ALPHA_MIN
from mobilegs.render.scene import Scene
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.view_dependence import ViewDependence
from tests.support.coded import join, split
from tests.support.scenes import camera, random_scene
from tests.web.test_decoder import CASES, Case, make_scene

VIEWS = [view.to("cpu", torch.float32) for view in (camera(), camera(33, 21))]
MANY = [name for name, case in CASES.items() if case.count >= 60]


def looked_at(coded: CodedScene, count: int) -> CodedScene:
    return layered(coded, count, VIEWS)


def rows_of(coded: CodedScene) -> list[tuple]:
    """Everything that belongs to each Gaussian, in an order that does not matter."""
    parts = [coded.positions.double(), *(codes.double() for codes in coded.indices.values())]
    return sorted(map(tuple, torch.cat(parts, dim=1).tolist()))


def minor(coded: CodedScene) -> int:
    """The least version 3.x that can say what a scene holds."""
    if coded.color.latents > 2 * LATENTS:
        return 3
    if coded.color.colors == "linear":
        return 2
    return int(coded.weighting.alpha_min != ALPHA_MIN)


@pytest.mark.parametrize("name", MANY)
def test_a_scene_in_layers_comes_back_and_is_the_same_scene(name: str) -> None:
    whole = make_scene(CASES[name])
    for count in (2, 3):
        coded = looked_at(whole, count)
        data = pack(coded)
        found = unpack(data)
        assert same(found, coded) and pack(found) == data
        assert not same(found, replace(found, layers=()))
        assert rows_of(found) == rows_of(whole)
        assert len(found.layers) == count and sum(found.layers) == len(whole)
        assert inspect(data)["layers"] == list(found.layers)
        assert inspect(data)["version"] == f"3.{minor(whole)}"


def test_each_layer_makes_four_times_as_many_gaussians_which_are_seen_less() -> None:
    whole = make_scene(CASES["one hidden layer"])
    coded = layered(whole, 4, VIEWS)
    assert coded.layers == (7, 24, 94, 375)
    seen = seen_of_each(coded.decode(), VIEWS)
    least = [float(seen[rows].min()) for rows in coded.parts()]
    most = [float(seen[rows].max()) for rows in coded.parts()]
    assert all(before >= after for before, after in zip(least, most[1:], strict=False))
    assert same(layered(coded, 1, VIEWS), whole.sorted())


@pytest.mark.parametrize("name", ["one hidden layer", "scalars", "network"])
def test_a_file_that_ends_behind_a_layer_is_a_coarser_scene(name: str) -> None:
    coded = looked_at(make_scene(CASES[name]), 3)
    header, body = split(pack(coded))
    for kept in (1, 2):
        table, size = [], 0
        for row in header["streams"]:
            if int((row["name"] + "@0").split("@")[1]) < kept:
                table.append(row)
                size += row["bytes"] + -row["bytes"] % 8
        count = sum(coded.layers[:kept])
        shorter = {"layers": list(coded.layers[:kept]), "count": count, "streams": table}
        found = unpack(join({**header, **shorter}, body[:size], version=(3, 0)))
        assert same(found, replace(coded.pick(slice(count)), layers=coded.layers[:kept]))


@pytest.mark.parametrize("blend", ["sortfree", "sorted"])
def test_what_is_seen_of_gaussians_are_their_shares_in_the_colours(blend: str) -> None:
    made = {name: value.float() for name, value in random_scene(300, degree=0).items()}
    colors = torch.rand(300, 3)
    sh = (colors[:, None] - 0.5) / 0.28209479
    opacities = made["opacities"].clamp(1e-4, 1 - 1e-4).logit()
    gaussians = Gaussians(made["means"], made["quats"], made["scales"].log(), opacities, sh)
    scene = Scene(gaussians, blend, lobes=made["lobes"] if blend == "sortfree" else None)
    seen = seen_of_each(scene, VIEWS[:1])
    expected = scene.render(VIEWS[0]).image.sum((0, 1))
    assert torch.allclose(seen @ colors, expected, rtol=1e-4)
    assert (seen >= 0).all() and (seen > 0).any()


def test_a_network_is_asked_about_the_colours_that_it_knows() -> None:
    scene = make_scene(CASES["network"]).decode()
    seen = seen_of_each(scene, VIEWS[:1])
    assert seen.shape == (120,) and seen.isfinite().all() and (seen > 0).any()


def test_the_number_of_layers_grows_with_the_scene() -> None:
    assert [layers_for(n) for n in (1, 39_999, 40_000, 159_999, 160_000, 500_000, 1 << 26)] == [
        *(1, 1, 2, 2, 3, 3, 7)
    ]


@pytest.mark.parametrize("count", [0, 9, 61])
def test_numbers_of_layers_that_cannot_be_are_refused(count: int) -> None:
    with pytest.raises(InputError, match="cannot be"):
        looked_at(make_scene(CASES["one place"]), count)


@pytest.mark.parametrize(
    "layers",
    [
        *([], [60, 0], [61, -1], [30, 29], [30, 30.5], [30, True], "60", None),
        *([[30], 30], {"0": 60}, [52, 1, 1, 1, 1, 1, 1, 1, 1], [1 << 70, 1]),
    ],
)
def test_layers_that_do_not_make_the_scene_are_refused(layers: object) -> None:
    header, body = split(pack(looked_at(make_scene(CASES["one place"]), 2)))
    assert header["layers"] == [15, 45]
    with pytest.raises(InputError, match="layers"):
        unpack(join({**header, "layers": layers}, body, version=(3, 0)))
    del header["layers"]
    with pytest.raises(InputError, match="layers"):
        unpack(join(header, body, version=(3, 0)))


def test_files_of_version_2_have_no_layers_whatever_they_say() -> None:
    data = pack(make_scene(CASES["one place"]))
    header, body = split(data)
    found = unpack(join({**header, "layers": [7]}, body, version=(2, 1)))
    assert same(found, unpack(data)) and found.layers == ()


def test_a_layer_without_its_streams_is_refused() -> None:
    data = pack(looked_at(make_scene(CASES["one place"]), 2))
    header, body = split(data)
    for row in header["streams"]:
        if row["name"] == "scale.1@1":
            row["name"] = "scale.1@2"
    with pytest.raises(InputError, match=r"lacks its stream 'scale\.1@1'"):
        unpack(join(header, body, version=(3, 0)))


def test_scenes_with_more_streams_than_a_file_can_have_are_refused() -> None:
    case = Case(100, LobeShape(0, 32), steps=ScalarSteps())
    pack(looked_at(make_scene(case), 5))
    with pytest.raises(InputError, match="256 are allowed"):
        pack(looked_at(make_scene(case), 6))


def test_layers_of_a_coded_scene_must_add_up() -> None:
    coded = make_scene(CASES["one place"])
    with pytest.raises(InputError, match="do not make 60 Gaussians"):
        pack(replace(coded, layers=(30, 31)))
    with pytest.raises(InputError, match="9 layers: 8 are allowed"):
        pack(replace(coded, layers=(52, 1, 1, 1, 1, 1, 1, 1, 1)))


def test_a_student_has_no_more_layers_than_its_file_has_streams_for() -> None:
    asked = StudentConfig(coding="sq", color_latents=12, view=ViewDependence(latents=12))
    assert asked.layers_max == 7 and StudentConfig(coding="sq").layers_max == 8
    with pytest.raises(InputError, match="at most 7 layers"):
        replace(asked, layers=8)
    free = StudentConfig(view=ViewDependence("free", degree=3, fraction=0.5))
    assert free.view.shape and free.view.shape.latents == 32 and free.layers_max == 5
    shape = LobeShape(2, 12, (16,))
    case = Case(400, shape, steps=ScalarSteps(), colors="linear", color_latents=12)
    scene = make_scene(case)
    assert same(unpack(pack(looked_at(scene, 7))), looked_at(scene, 7))
    with pytest.raises(InputError, match="256 are allowed"):
        pack(looked_at(scene, 8))
