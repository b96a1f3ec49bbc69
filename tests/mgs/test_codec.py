"""Round trips of `.mgs` files, decoding and inspection."""

import copy
import json
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect, inspect_mgs, read_mgs, write_mgs
from mobilegs.mgs.encode import encode_scene
from mobilegs.mgs.positions import PositionGrid
from mobilegs.mgs.quantized_scene import scenes_equal
from mobilegs.render import Weighting
from mobilegs.render.view_network import ViewNetwork
from mobilegs.representation.appearance import AppearanceDecoder
from mobilegs.representation.codebooks import CUTS, Attribute, SubVectorCodebooks
from mobilegs.representation.lobes import LobeShape
from tests.support.quantized_scenes import SMALL
from tests.support.scene_cases import CASES, Case, make_scene
from tests.support.selection import few

SHORT = [name for name, case in CASES.items() if case.count <= 1000]


@pytest.mark.parametrize("name", few(SHORT, "network", "linear lobes", "scalars with lobes"))
def test_a_scene_round_trips_in_morton_order_and_a_second_trip_changes_no_byte(name: str) -> None:
    scene = make_scene(CASES[name])
    data = encode_mgs(scene)
    found = decode_mgs(data)
    assert scenes_equal(found, scene.sorted()) and encode_mgs(found) == data


def test_the_order_of_rows_changes_no_byte() -> None:
    scene = make_scene(SMALL)
    order = torch.randperm(len(scene), generator=torch.Generator().manual_seed(0))
    shuffled = replace(
        scene,
        positions=scene.positions[order],
        indices={name: rows[order] for name, rows in scene.indices.items()},
    )
    assert encode_mgs(shuffled) == encode_mgs(scene)


def test_scenes_equal_compares_every_field() -> None:
    scene = make_scene(SMALL)
    flipped = {**scene.codebooks, "opacity": -scene.codebooks["opacity"]}
    others = [
        replace(scene, positions=-scene.positions),
        replace(scene, grid=replace(scene.grid, radius=1.8)),
        replace(scene, grid=replace(scene.grid, exponent=0)),
        replace(scene, codebooks=flipped),
        replace(scene, indices={**scene.indices, "scale": scene.indices["scale"].flip(0)}),
        replace(scene, lobe_decoder={**scene.lobe_decoder, "bias": -scene.lobe_decoder["bias"]}),
        replace(scene, lobe_shape=LobeShape(2, 6, (5,))),
        make_scene(replace(SMALL, shape=None)),
        make_scene(replace(SMALL, shape=None, network=True)),
        replace(scene, weighting=Weighting(exponent_max=7.0)),
        replace(scene, background=torch.zeros(3)),
        replace(scene, near=0.1),
        replace(scene, views=scene.views[:1]),
        replace(scene, meta={**scene.meta, "steps": 8}),
        make_scene(replace(SMALL, count=41)),
    ]
    assert scenes_equal(scene, copy.deepcopy(scene))
    assert not any(scenes_equal(scene, other) for other in others)


def test_files_are_written_and_read_back(tmp_path: Path) -> None:
    scene = make_scene(SMALL)
    size = write_mgs(tmp_path / "deep" / "scene.mgs", scene)
    assert size == (tmp_path / "deep" / "scene.mgs").stat().st_size
    assert scenes_equal(read_mgs(tmp_path / "deep" / "scene.mgs"), scene.sorted())


def test_a_decoded_scene_has_the_values_of_its_quantisers() -> None:
    g = torch.Generator().manual_seed(0)
    values = torch.randn(60, 6, generator=g)
    grid, means = PositionGrid(torch.zeros(3), 1.0), torch.randn(60, 3, generator=g)
    decoder = AppearanceDecoder(g)
    books: dict[Attribute, SubVectorCodebooks] = {
        name: SubVectorCodebooks.fit(
            values[:, : cut.count * cut.length], length=cut.length, size=8, generator=g
        )
        for name, cut in CUTS.items()
    }
    coded = encode_scene(means, books, grid, decoder, network=ViewNetwork(g))
    before = torch.get_rng_state()
    scene = replace(coded, background=torch.ones(3)).decode()
    assert torch.equal(torch.get_rng_state(), before)
    assert scene.blend == "sortfree" and torch.equal(scene.background, torch.ones(3))
    found = scene.gaussians
    assert torch.equal(found.means, grid.round(means))
    assert torch.equal(found.log_scales, books["scale"]())
    assert torch.equal(found.quats, books["rotation"]())
    assert torch.equal(found.logit_opacities, books["opacity"]()[:, 0])
    static, view = books["appearance"]().split(3, dim=1)
    positions = grid.normalised(grid.store(means))
    assert torch.allclose(found.sh, decoder(positions, static, view), atol=1e-6)


def test_the_bytes_of_all_streams_add_up(tmp_path: Path) -> None:
    write_mgs(tmp_path / "scene.mgs", make_scene(SMALL))
    report = inspect_mgs(tmp_path / "scene.mgs")
    parts = sum(row["bytes"] for row in report["streams"])
    assert parts + report["header_bytes"] + report["padding_bytes"] == report["file_bytes"]
    assert report["gaussians"] == 40 and report["meta"]["psnr"] == 25.1
    names = [row["name"] for row in report["streams"]]
    assert names[:4] == ["lobe-decoder", "appearance-decoder", "codebooks", "positions"]
    assert names[-4:] == ["opacity.0", "lobes.0", "lobes.1", "lobes.2"]
    assert all(row["bytes"] <= (row["raw_bytes"] or 0) for row in report["streams"][:3])
    assert report["lobes"] == {"degree": 2, "latents": 6, "hidden": []}
    assert report["network"] is False
    json.dumps(report)
    network = inspect(encode_mgs(make_scene(Case(40, network=True))))
    assert network["streams"][0]["name"] == "view-network" and network["lobes"] is None
    assert network["network"] is True


def test_index_streams_take_the_smaller_codec() -> None:
    scene = make_scene(Case(1000, size=16))
    scene.indices["scale"] = torch.zeros(1000, 3).short()
    codecs = {row["name"]: row["codec"] for row in inspect(encode_mgs(scene))["streams"]}
    assert codecs["scale.0"] == "rans" and codecs["rotation.0"] == "bits"
