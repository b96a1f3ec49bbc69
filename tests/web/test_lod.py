"""LOD levels: refused files, and levels shown while the rest is loading."""

import json
from dataclasses import replace
from typing import Any

import pytest

from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.representation.lobes import LobeShape
from tests.support.browser import Tab
from tests.support.mgs_parts import ends_of
from tests.support.scene_cases import Case, make_scene
from tests.support.viewer_page import (
    HAS_GAUSSIANS,
    LOD_SIZES,
    SETTLED,
    SHOWN,
    SMALL,
    Gate,
    frames,
    leveled_scene,
    nearness,
    open_page,
    seen,
    until,
    visit,
)

pytestmark = pytest.mark.thorough

PROGRESS = "document.querySelector('mobile-gs').shadowRoot.querySelector('.bar').ariaValueNow"
# in the worker time passes a thousand times as fast, so that every wait for bytes is a long one
SLOW_NETWORK = """{
  const { now } = performance;
  performance.now = () => 1000 * now.call(performance);
  const { setInterval } = globalThis;
  globalThis.setInterval = (run, milliseconds) => setInterval(run, milliseconds / 1000);
}
"""


def ends(data: bytes) -> list[int]:
    """Bytes up to the end of each layer."""
    found = [0] * len(LOD_SIZES)
    for name, end in ends_of(data).items():
        found[int(name.partition("@")[2] or 0)] = end
    return found


@pytest.mark.parametrize(("renderer", "kind"), [("webgpu", "codebooks"), ("webgl", "sorted")])
def test_lod_levels_appear_one_after_the_other(
    tab: Tab, served: Any, renderer: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = encode_mgs(leveled_scene(sorted=kind == "sorted"))
    gate = Gate(monkeypatch, data)
    open_page(tab, served("scene.mgs", data), renderer)
    whole = decode_mgs(data)
    for i, end in enumerate(ends(data)):
        gate.let(end)
        count = sum(LOD_SIZES[: i + 1])
        tab.page.wait_for_function(f"{SHOWN} === {count}", timeout=30_000)
        until(tab, lambda: tab.page.evaluate(HAS_GAUSSIANS))
        some = replace(whole.select(slice(0, count)), lod_sizes=()).decode()
        decibels = nearness(tab, lambda camera, some=some: some.render(camera).image)
        print(f"{renderer}, {kind}, {count} Gaussians: {decibels:.1f} dB")
        assert decibels > 45
        state = tab.page.evaluate("document.querySelector('mobile-gs').dataset.state")
        assert state == "loading" or i == len(LOD_SIZES) - 1
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"


@pytest.mark.parametrize("moves", [False, True])
def test_a_poster_stays_until_the_scene_shows_more(
    tab: Tab, served: Any, moves: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = encode_mgs(leveled_scene())
    gate = Gate(monkeypatch, data)
    tab.page.set_viewport_size(SMALL)
    address = served("scene.mgs", data).address("127.0.0.1")
    tab.page.goto(f"{address}&scale=1&variant=floats&renderer=webgl&poster=")
    visible = "document.querySelector('mobile-gs').shadowRoot.querySelector('canvas.drawn')"
    gate.let(behind(data, "positions"))
    frames(tab, 20)
    assert not tab.page.evaluate(f"{SHOWN} ?? 0")  # no dots
    gate.let(ends(data)[0])
    tab.page.wait_for_function(f"{SHOWN} === {LOD_SIZES[0]}", timeout=30_000)
    frames(tab, 10)
    assert tab.page.evaluate(f"{visible} === null")
    if moves:  # a poster cannot follow
        tab.page.mouse.move(100, 100)
        tab.page.mouse.down()
        tab.page.mouse.move(140, 100, steps=4)
        tab.page.wait_for_function(visible, timeout=10_000)
        tab.page.mouse.up()
    gate.let(len(data))
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    tab.page.wait_for_function(visible, timeout=10_000)


def behind(data: bytes, name: str) -> int:
    """Bytes up to the end of a stream, by how its name begins; of several, of the last one."""
    ends = ends_of(data).items()
    return max(end for each, end in ends if each.startswith(name) and "@" not in each)


def test_a_slow_scene_shows_dots_until_colours_arrive(
    tab: Tab, served: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 8000
    data = encode_mgs(make_scene(Case(count, LobeShape(2, 12, (64,)), size=300)))
    gate = Gate(monkeypatch, data)

    tab.page.add_init_script(
        f"""{{
          const Own = Blob;
          window.Blob = class extends Own {{
            constructor(parts, options) {{
              const script = options?.type === "text/javascript";
              super(script ? [{json.dumps(SLOW_NETWORK)}, ...parts] : parts, options);
            }}
          }};
        }}"""
    )
    open_page(tab, served("scene.mgs", data), "webgpu")
    gate.let(behind(data, "positions"))
    tab.page.wait_for_function(f"{SHOWN} === {count}", timeout=30_000)
    gate.let(behind(data, "rotation"))
    percent = round(100 * behind(data, "rotation") / len(data))
    tab.page.wait_for_function(f"{PROGRESS} >= {percent}", timeout=30_000)
    frames(tab, 10)
    viewer = "document.querySelector('mobile-gs').viewer"
    nothing = f"{viewer}.pixels({viewer}.camera(9, 9)).catch(({{ message }}) => message)"
    assert tab.page.evaluate(nothing) == "nothing can be drawn"
    gate.let(max(behind(data, "appearance"), behind(data, "opacity")))
    until(tab, lambda: tab.page.evaluate(HAS_GAUSSIANS))
    assert tab.page.evaluate("document.querySelector('mobile-gs').dataset.state") == "loading"
    assert seen(tab, 160, 120)[1].std() > 0.05
    gate.let(len(data))
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"


def test_a_file_cut_after_its_colours_is_shown_in_colour(tab: Tab, served: Any) -> None:
    data = encode_mgs(leveled_scene())
    assert "cut short" in visit(tab, served("scene.mgs", data[:-8]))
    tab.page.keyboard.press("Escape")
    assert tab.page.evaluate(SHOWN) == sum(LOD_SIZES)  # the last layer lacks some of its lobes
    whole = decode_mgs(data).decode()
    assert nearness(tab, lambda camera: whole.render(camera).image, enough=20) > 20


@pytest.mark.quick
def test_a_file_cut_after_a_level_shows_that_level(tab: Tab, served: Any) -> None:
    data = encode_mgs(leveled_scene())
    said = visit(tab, served("scene.mgs", data[: ends(data)[0]]))
    assert "cut short" in said
    tab.page.keyboard.press("Escape")
    some = replace(decode_mgs(data).select(slice(0, LOD_SIZES[0])), lod_sizes=()).decode()
    assert nearness(tab, lambda camera: some.render(camera).image) > 45
    assert tab.page.evaluate(SHOWN) == LOD_SIZES[0]
