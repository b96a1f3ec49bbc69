"""Round trips of `.mgs` files, decoding and inspection."""

import copy
import json
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect, inspect_mgs, read_mgs, write_mgs
from mobilegs.mgs.encode import encode_scene
from mobilegs.mgs.positions import PositionGrid, morton_codes
from mobilegs.mgs.quantized_scene import scenes_equal
from mobilegs.render import Weighting
from mobilegs.render.view_network import ViewNetwork
from mobilegs.representation.appearance import AppearanceDecoder
from mobilegs.representation.codebooks import CUTS, Attribute, SubVectorCodebooks
from mobilegs.representation.lobes import LobeShape
from tests.support.quantized_scenes import SHAPE, VIEWS, make_scene, seeded, split


@settings(deadline=None, max_examples=12)
@given(st.integers(1, 300), st.sampled_from(VIEWS), st.integers(0, 1000))
def test_unpacking_gives_the_packed_scene_in_morton_order(count: int, view: str, seed: int) -> None:
    scene = make_scene(count, view=view, seed=seed)
    assert scenes_equal(decode_mgs(encode_mgs(scene)), scene.sorted())


def test_a_large_scene_round_trips() -> None:
    scene = make_scene(20_000)
    assert scenes_equal(decode_mgs(encode_mgs(scene)), scene.sorted())


def test_gaussians_at_equal_positions_keep_their_order() -> None:
    scene = make_scene(50)
    scene.positions[:] = scene.positions[:1]
    back = decode_mgs(encode_mgs(scene))
    assert all(torch.equal(back.indices[name], scene.indices[name]) for name in CUTS)


def test_neither_row_order_nor_a_second_trip_changes_a_byte() -> None:
    scene = make_scene(200)
    order = torch.randperm(200, generator=seeded())
    shuffled = replace(
        scene,
        positions=scene.positions[order],
        indices={name: rows[order] for name, rows in scene.indices.items()},
    )
    assert encode_mgs(shuffled) == encode_mgs(scene) == encode_mgs(decode_mgs(encode_mgs(scene)))


def test_sorting_is_by_morton_code() -> None:
    codes = morton_codes(make_scene(100).sorted().positions)
    assert (np.diff(codes.astype(np.int64)) >= 0).all()


@pytest.mark.parametrize("size", [1, 2, 256, 1024, 4096])
def test_codebooks_of_every_size_round_trip(size: int) -> None:
    scene = make_scene(100)
    scene.codebooks["rotation"] = torch.randn(2, size, 2, generator=seeded()).half()
    scene.indices["rotation"] = torch.randint(size, (100, 2), generator=seeded()).short()
    assert scenes_equal(decode_mgs(encode_mgs(scene)), scene.sorted())


def test_scenes_equal_compares_every_field() -> None:
    scene = make_scene(10)
    flipped = {**scene.codebooks, "opacity": -scene.codebooks["opacity"]}
    others = [
        replace(scene, positions=-scene.positions),
        replace(scene, grid=replace(scene.grid, radius=1.8)),
        replace(scene, grid=replace(scene.grid, exponent=0)),
        replace(scene, codebooks=flipped),
        replace(scene, indices={**scene.indices, "scale": scene.indices["scale"].flip(0)}),
        replace(scene, lobe_decoder={**scene.lobe_decoder, "bias": -scene.lobe_decoder["bias"]}),
        replace(scene, lobe_shape=LobeShape(2, 6, (5,))),
        make_scene(10, view="nothing"),
        make_scene(10, view="network"),
        replace(scene, weighting=Weighting(exponent_max=7.0)),
        replace(scene, background=torch.zeros(3)),
        replace(scene, near=0.1),
        replace(scene, views=scene.views[:1]),
        replace(scene, meta={**scene.meta, "steps": 8}),
        make_scene(11),
    ]
    assert scenes_equal(scene, copy.deepcopy(scene))
    assert not any(scenes_equal(scene, other) for other in others)


def test_files_are_written_and_read_back(tmp_path: Path) -> None:
    scene = make_scene()
    size = write_mgs(tmp_path / "deep" / "scene.mgs", scene)
    assert size == (tmp_path / "deep" / "scene.mgs").stat().st_size
    assert scenes_equal(read_mgs(tmp_path / "deep" / "scene.mgs"), scene.sorted())


# --- decoding


def test_a_decoded_scene_has_the_values_of_its_quantisers() -> None:
    g = seeded()
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
    scene = replace(coded, background=torch.ones(3)).decode()
    assert scene.blend == "sortfree" and torch.equal(scene.background, torch.ones(3))
    found = scene.gaussians
    assert torch.equal(found.means, grid.round(means))
    assert torch.equal(found.log_scales, books["scale"]())
    assert torch.equal(found.quats, books["rotation"]())
    assert torch.equal(found.logit_opacities, books["opacity"]()[:, 0])
    static, view = books["appearance"]().split(3, dim=1)
    positions = grid.normalised(grid.store(means))
    assert torch.allclose(found.sh, decoder(positions, static, view), atol=1e-6)


def test_a_scene_from_a_file_renders(tmp_path: Path) -> None:
    write_mgs(tmp_path / "scene.mgs", make_scene())
    coded = read_mgs(tmp_path / "scene.mgs")
    drawn = coded.decode().render(coded.views[0])
    assert drawn.image.isfinite().all() and drawn.alpha.max() > 0.05


def test_decoding_leaves_the_global_random_state_alone() -> None:
    scene = make_scene()
    torch.manual_seed(1)
    expected = torch.rand(1)
    torch.manual_seed(1)
    decode_mgs(encode_mgs(scene)).decode()
    assert torch.equal(torch.rand(1), expected)


# --- inspection


def test_the_bytes_of_all_streams_add_up(tmp_path: Path) -> None:
    write_mgs(tmp_path / "scene.mgs", make_scene(100))
    report = inspect_mgs(tmp_path / "scene.mgs")
    parts = sum(row["bytes"] for row in report["streams"])
    assert parts + report["header_bytes"] + report["padding_bytes"] == report["file_bytes"]
    assert report["gaussians"] == 100 and report["meta"]["psnr"] == 25.1
    names = [row["name"] for row in report["streams"]]
    assert names[:4] == ["lobe-decoder", "appearance-decoder", "codebooks", "positions"]
    assert names[-4:] == ["opacity.0", "lobes.0", "lobes.1", "lobes.2"]
    assert all(row["bytes"] <= (row["raw_bytes"] or 0) for row in report["streams"][:3])
    assert report["lobes"] == SHAPE and report["network"] is False
    json.dumps(report)
    network = inspect(encode_mgs(make_scene(100, view="network")))
    assert network["streams"][0]["name"] == "view-network" and network["lobes"] is None
    assert network["network"] is True


def test_streams_start_at_multiples_of_eight_and_follow_the_order_of_use(data: bytes) -> None:
    header, body = split(data)
    assert (len(data) - len(body)) % 8 == 0
    start = 0
    for row in header["streams"]:
        assert zlib.crc32(body[start : start + row["bytes"]]) == row["crc32"]
        start += row["bytes"] + -row["bytes"] % 8
    assert start == len(body)


def test_index_streams_take_the_smaller_codec() -> None:
    scene = make_scene(3000)
    scene.indices["scale"] = torch.zeros(3000, 3).short()
    report = inspect(encode_mgs(scene))
    codecs = {row["name"]: row["codec"] for row in report["streams"]}
    assert codecs["scale.0"] == "rans" and codecs["rotation.0"] == "bits"
