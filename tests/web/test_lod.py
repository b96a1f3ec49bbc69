"""LOD levels: refused files, and levels shown while the rest is loading."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mobilegs.evaluate.metrics import psnr
from mobilegs.mgs.codec import pack, unpack
from mobilegs.representation.lobes import LobeShape
from tests.support.browser import Chromium, Tab
from tests.support.node import assert_same_refusals
from tests.support.quantized_scenes import join, split
from tests.support.scene_cases import CASES, Case, make_scene
from tests.support.viewer_page import (
    HAS_GAUSSIANS,
    LOD_SIZES,
    RENDERERS,
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
LAYERS: list[Any] = [
    None, [], [400], [390, 9], [390, 11], [0, 400], [-1, 401], [390, 10, 0], [400, 10], [10, 390],
    [50] * 8, [40] * 10, [391, 9], "xx", [True, 399], [390, None], [390, "10"], [[390], 10],
    [390.5, 9.5], [2**53, 400 - 2**53], {}, 400,
]  # fmt: skip


@pytest.mark.parametrize("version", [(2, 1), (3, 0), (3, 9), (4, 0), (1, 0)])
def test_bad_lod_levels_are_refused_alike(version: tuple[int, int], tmp_path: Path) -> None:
    cases = []
    for name in ("layers of scalars", "linear lobes"):
        header, body = split(pack(make_scene(CASES[name])))
        cases.append(join(header, body, version))
        without = {key: value for key, value in header.items() if key != "layers"}
        cases.append(join(without, body, version))
        cases += [join({**header, "layers": layers}, body, version) for layers in LAYERS]
    found = assert_same_refusals(tmp_path, cases)
    # in version 2 the field says nothing; what counts is that there are streams for all Gaussians
    known = {(2, 1): len(cases) // 2, (3, 0): 1, (3, 9): 1}
    assert found.count(None) == known.get(version, 0)


@pytest.mark.parametrize("damage", ["missing", "twice", "codec", "exchanged", "reversed"])
def test_bad_streams_of_lod_levels_are_refused_alike(damage: str, tmp_path: Path) -> None:
    cases = []
    header, body = split(pack(make_scene(CASES["layers of scalars"])))
    parts = []
    for row in header["streams"]:
        size = row["bytes"] + -row["bytes"] % 8
        parts.append((row, body[:size]))
        body = body[size:]
    for i, (row, content) in enumerate(parts):
        changed = list(parts)
        if damage == "missing":
            del changed[i]
        elif damage == "twice":
            changed.append(changed[i])
        elif damage == "codec":
            changed[i] = {**row, "codec": "zip"}, content
        elif damage == "exchanged":
            j = (i + 7) % len(parts)
            changed[i], changed[j] = (
                ({**row, "name": parts[j][0]["name"]}, content),
                ({**parts[j][0], "name": row["name"]}, parts[j][1]),
            )
        else:
            changed = changed[i:] + changed[:i]
        rows = [row for row, _ in changed]
        content = b"".join(content for _, content in changed)
        cases.append(join({**header, "streams": rows}, content, (3, 0)))
    found = assert_same_refusals(tmp_path, cases)
    if damage == "reversed":
        assert found.count(None) == len(cases)
    elif damage != "exchanged":
        assert None not in found


def ends(data: bytes) -> list[int]:
    """Bytes up to the end of each layer."""
    header, body = split(data)
    at, found = len(data) - len(body), [0] * len(LOD_SIZES)
    for row in header["streams"]:
        at += row["bytes"] + -row["bytes"] % 8
        _, _, number = row["name"].partition("@")
        found[int(number or 0)] = at
    return found


@pytest.mark.parametrize(
    ("renderer", "kind"),
    [("webgpu", "codebooks"), ("webgl", "scalars"), ("webgpu", "sorted"), ("webgl", "sorted")],
)
def test_lod_levels_appear_one_after_the_other(
    tab: Tab, served: Any, renderer: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = pack(leveled_scene(scalars=kind == "scalars", sorted=kind == "sorted"))
    gate = Gate(monkeypatch, data)
    open_page(tab, served("scene.mgs", data), renderer)
    whole = unpack(data)
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
    data = pack(leveled_scene())
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
    header, body = split(data)
    at, found = len(data) - len(body), 0
    for row in header["streams"]:
        at += row["bytes"] + -row["bytes"] % 8
        if row["name"].startswith(name) and "@" not in row["name"]:
            found = at
    return found


def test_a_slow_scene_shows_dots_until_colours_arrive(
    chromium: Chromium, served: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    tab = chromium.tab()
    count = 8000
    data = pack(make_scene(Case(count, LobeShape(2, 12, (64,)), size=300)))
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
    tab.close()


def test_a_file_cut_after_its_colours_is_shown_in_colour(tab: Tab, served: Any) -> None:
    data = pack(leveled_scene())
    assert "cut short" in visit(tab, served("scene.mgs", data[:-8]))
    tab.page.keyboard.press("Escape")
    assert tab.page.evaluate(SHOWN) == sum(LOD_SIZES)  # the last layer lacks some of its lobes
    whole = unpack(data).decode()
    assert nearness(tab, lambda camera: whole.render(camera).image, enough=20) > 20


@pytest.mark.parametrize("renderer", RENDERERS)
def test_lod_levels_do_not_change_the_final_image(tab: Tab, served: Any, renderer: str) -> None:
    pictures = []
    tab.page.set_viewport_size(SMALL)
    for name, layers in (("layers.mgs", LOD_SIZES), ("plain.mgs", ())):
        data = pack(replace(leveled_scene(), lod_sizes=layers))
        assert visit(tab, served(name, data), f"renderer={renderer}") == "loaded"
        pictures.append(seen(tab, 160, 120)[1])
        assert tab.page.evaluate(SHOWN) == sum(LOD_SIZES)
    assert pictures[1].std() > 0.05
    decibels = psnr(*pictures)
    print(f"{renderer}: {decibels:.1f} dB")
    assert decibels > 80


@pytest.mark.quick
def test_a_file_cut_after_a_level_shows_that_level(tab: Tab, served: Any) -> None:
    data = pack(leveled_scene())
    said = visit(tab, served("scene.mgs", data[: ends(data)[0]]))
    assert "cut short" in said
    tab.page.keyboard.press("Escape")
    some = replace(unpack(data).select(slice(0, LOD_SIZES[0])), lod_sizes=()).decode()
    assert nearness(tab, lambda camera: some.render(camera).image) > 45
    assert tab.page.evaluate(SHOWN) == LOD_SIZES[0]
