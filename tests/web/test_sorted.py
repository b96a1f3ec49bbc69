"""Sorted scenes in the browser: .spz files of another program, and a .mgs."""

import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mobilegs.evaluate.metrics import psnr
from mobilegs.formats.ply import read_ply
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.render.scene import Scene
from mobilegs.representation.lobes import LobeShape
from tests.support.browser import Tab
from tests.support.golden import view_network
from tests.support.node import WEB, node_program
from tests.support.scene_cases import Case, make_scene
from tests.support.viewer_page import nearness, seen, visit

pytestmark = pytest.mark.thorough


@pytest.mark.parametrize(("name", "renderer"), [("spz_v3.spz", "webgl"), ("spz_v4.spz", "webgpu")])
def test_a_spz_is_rendered_sorted(
    tab: Tab, served: Any, tmp_path: Path, name: str, renderer: str
) -> None:
    subprocess.run([node_program(), WEB / "plain.js", tmp_path / "made.ply"], check=True)
    scene = Scene(read_ply(tmp_path / "made.ply"))
    server = served("scene", (WEB / name).read_bytes())  # its bytes say what it is
    assert visit(tab, server, f"renderer={renderer}") == "loaded"
    # the order comes from a worker
    decibels = nearness(tab, lambda camera: scene.render(camera).image, enough=42)
    print(f"{renderer}: {decibels:.1f} dB")
    assert decibels > 42  # colours are rounded to steps of 1/38, harmonics to 1/16


SORTED = {
    "constant": Case(800, size=300),
    "lobes": Case(800, LobeShape(2, 6), size=300),
    "network": Case(800, network=True, size=300),
}


@pytest.mark.parametrize(
    ("kind", "renderer"),
    [("constant", "webgpu"), ("lobes", "webgl"), ("lobes", "webgpu"), ("network", "webgpu")],
)
def test_a_sorted_mgs_is_rendered_sorted(tab: Tab, served: Any, kind: str, renderer: str) -> None:
    coded = replace(make_scene(SORTED[kind]), blend="sorted")
    if kind == "network":  # whose opacities change much with the direction
        weights = view_network().named_parameters()
        coded = replace(coded, network={name: value.half() for name, value in weights})
    data = encode_mgs(coded)
    assert visit(tab, served("scene.mgs", data), f"renderer={renderer}") == "loaded"
    scene = decode_mgs(data).decode()
    decibels = nearness(tab, lambda camera: scene.render(camera).image, enough=50)
    camera, _ = seen(tab, 160, 120)
    expected = scene.render(camera).image
    unsorted = psnr(replace(scene, blend="sortfree").render(camera).image, expected)
    print(f"{renderer}: {decibels:.1f} dB, unsorted {unsorted:.1f}")
    assert decibels > 50 > unsorted + 10
