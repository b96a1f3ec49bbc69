"""Dots: the preview of a scene before its attributes have arrived."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.mgs.codec import decode_mgs, encode_mgs
from tests.support.browser import Chromium, Tab
from tests.support.mgs_parts import ends_of
from tests.support.page_renderers import Painters, in_javascript
from tests.support.scenes import camera
from tests.support.viewer_page import (
    LOD_SIZES,
    RENDERERS,
    SETTLED,
    SHOWN,
    Gate,
    leveled_scene,
    nearness,
    open_page,
    screen,
    until,
)

pytestmark = pytest.mark.thorough

DRAW = """
renderer.setDots({ means, color, side, background });
renderer.drawDots(camera);
const copy = new OffscreenCanvas(camera.width, camera.height).getContext("2d");
copy.drawImage(canvas, 0, 0);
renderer.setDots(null);
return Float32Array.from(copy.getImageData(0, 0, camera.width, camera.height).data);
"""
COLOR, BACKDROP = (0.2, 0.6, 1.0), (0.4, 0.0, 0.2)
SMALLEST, GROWTH = 1 / 500, 4  # sides of dots, in heights; and the largest
SNAP = 0.04  # pixels that corners may be off: rasterisers know sixteenths


@pytest.mark.parametrize(("kind", "side"), [("webgl", 1e-4), ("webgpu", 0.08), ("webgl", 10.0)])
def test_dots_are_squares_at_the_means(kind: str, side: float, painters: Painters) -> None:
    view = camera(600, 500).to(dtype=torch.float32)
    means = torch.randn((300, 3), generator=torch.Generator().manual_seed(1))
    means[:5] = torch.tensor([0.0, 0, 0.5]) @ view.viewmat[:3, :3] + view.position  # and behind:
    means[5:9] = view.position - view.viewmat[2, :3] * torch.arange(4)[:, None]
    given = {"color": COLOR, "side": side, "background": BACKDROP}
    found = painters(kind, full_precision=True).tab.run(
        DRAW, means=means.numpy(), camera=in_javascript(view), **given
    )
    pixels = found.reshape(view.height, view.width, 4)[..., :3] / 255

    seen = means @ view.viewmat[:3, :3].T + view.viewmat[:3, 3]
    seen = seen[seen[:, 2] > view.near]
    places = (seen[:, :2] / seen[:, 2:]) @ torch.diag(view.K.diagonal()[:2]) + view.K[:2, 2]
    least = SMALLEST * view.height
    sides = (view.K[1, 1] * side / seen[:, 2]).clamp(least, GROWTH * least)
    columns, rows = (np.arange(n) + 0.5 for n in (view.width, view.height))
    beyond = np.full((view.height, view.width), np.inf)  # from each pixel to the nearest dot
    for (x, y), wide in zip(places.numpy(), sides.numpy(), strict=True):
        apart = np.maximum(np.abs(columns - x), np.abs(rows - y)[:, None])
        np.minimum(beyond, apart - wide / 2, out=beyond)
    assert (beyond < 0).sum() > 100
    for which, color in ((beyond < -SNAP, COLOR), (beyond > SNAP, BACKDROP)):
        np.testing.assert_allclose(pixels[which] - np.array(color), 0, atol=0.003)


@pytest.mark.parametrize("renderer", RENDERERS)
def test_dots_appear_first_and_follow_the_camera(
    chromium: Chromium, served: Any, renderer: str, monkeypatch: Any
) -> None:
    tab = chromium.tab(0.5)  # dots have a size in pixels
    data = encode_mgs(replace(leveled_scene(), background=torch.zeros(3)))
    gate = Gate(monkeypatch, data)
    open_page(tab, served("scene.mgs", data), renderer)
    gate.let(ends_of(data)["positions"])
    tab.page.wait_for_function(f"{SHOWN} === {LOD_SIZES[0]}", timeout=20_000)
    until(tab, lambda: bool(screen(tab)[:100].any()))
    picture = screen(tab)[: -tab.page.viewport_size["height"] // 4, :, :]  # above the buttons
    colors, counts = np.unique(picture.reshape(-1, 3), axis=0, return_counts=True)
    assert 100 < counts[colors.any(1)].sum() < picture.size / 6  # dots on black
    viewer = "document.querySelector('mobile-gs').viewer"
    nothing = f"{viewer}.pixels({viewer}.camera(9, 9)).catch(({{ message }}) => message)"
    assert tab.page.evaluate(nothing) == "nothing can be drawn"
    tab.page.mouse.move(160, 80)
    tab.page.mouse.wheel(0, 240)  # dots follow the camera
    until(tab, lambda: bool((screen(tab)[: len(picture)] != picture).any()))
    gate.let(len(data))
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    whole = decode_mgs(data).decode()
    assert nearness(tab, lambda view: whole.render(view).image) > 45
    tab.close()


def test_a_file_cut_after_its_positions_shows_dots_and_an_error(tab: Tab, served: Any) -> None:
    data = encode_mgs(replace(leveled_scene(), background=torch.zeros(3)))
    open_page(tab, served("scene.mgs", data[: ends_of(data)["positions"]]), "webgl")
    said = tab.page.wait_for_function(SETTLED, timeout=60_000).json_value()
    assert "cut short" in said and tab.page.evaluate(SHOWN) == LOD_SIZES[0]
    tab.page.keyboard.press("Escape")
    assert screen(tab)[:100].any()
