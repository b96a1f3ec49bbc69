"""Files in layers: what is refused, and the first layer in Chromium before the rest has come."""

import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mobilegs.compress.lobes import LobeShape
from mobilegs.compress.uniform_quantizer import ScalarSteps
from mobilegs.evaluate.metrics import psnr
from mobilegs.mgs.codec import pack, unpack
from mobilegs.mgs.quantized_scene import CodedScene
from mobilegs.view.serve import Handler
from tests.support.browser import Tab
from tests.support.coded import join, split
from tests.web.test_decoder import CASES, Case, assert_same_refusals, make_scene
from tests.web.test_viewer import RENDERERS, SETTLED, nearness, seen, served, visit

__all__ = ["served"]
SIZES = (150, 1, 649)
COUNT = sum(SIZES)
SMALL = {"width": 320, "height": 240}
SHOWN = "document.querySelector('mobile-gs').viewer?.count"
# settles when there are more than dots
TRUE_COLOURS = """async () => {
  const { viewer } = document.querySelector("mobile-gs");
  for (let i = 0; i < 300; i++) {
    if (await viewer.pixels(viewer.camera(9, 9)).catch(() => null)) return;
    await new Promise((later) => setTimeout(later, 100));
  }
}"""
LAYERS: list[Any] = [
    None, [], [400], [390, 9], [390, 11], [0, 400], [-1, 401], [390, 10, 0], [400, 10], [10, 390],
    [50] * 8, [40] * 10, [391, 9], "xx", [True, 399], [390, None], [390, "10"], [[390], 10],
    [390.5, 9.5], [2**53, 400 - 2**53], {}, 400,
]  # fmt: skip


@pytest.mark.parametrize("version", [(2, 1), (3, 0), (3, 9), (4, 0), (1, 0)])
def test_layers_are_refused_alike(version: tuple[int, int], tmp_path: Path) -> None:
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
def test_streams_of_layers_are_refused_alike(damage: str, tmp_path: Path) -> None:
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


def coded(*, scalars: bool = False, sorted: bool = False) -> CodedScene:
    shape = None if sorted else LobeShape(2, 12, (64,))
    steps = ScalarSteps() if scalars else None
    scene = replace(make_scene(Case(COUNT, shape, size=300, steps=steps)), layers=SIZES)
    return replace(scene, blend="sorted") if sorted else scene


def ends(data: bytes) -> list[int]:
    """Bytes up to the end of each layer."""
    header, body = split(data)
    at, found = len(data) - len(body), [0] * len(SIZES)
    for row in header["streams"]:
        at += row["bytes"] + -row["bytes"] % 8
        _, _, number = row["name"].partition("@")
        found[int(number or 0)] = at
    return found


class Gate:
    """Lets no more of a scene through than it is told."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, data: bytes) -> None:
        self._open = threading.Condition()
        self._end = 0

        def answer(handler: Handler, file: Path) -> None:
            handler._head("application/octet-stream", len(data))
            sent = 0
            while sent < len(data):
                with self._open:
                    if not self._open.wait_for(lambda sent=sent: self._end > sent, timeout=60):
                        return
                    end = self._end
                handler.wfile.write(data[sent:end])
                handler.wfile.flush()
                sent = end

        monkeypatch.setattr(Handler, "_answer_scene", answer)

    def let(self, end: int) -> None:
        with self._open:
            self._end = end
            self._open.notify_all()


def begin(tab: Tab, server: Any, renderer: str) -> None:
    wishes = f"scale=1&variant=floats&renderer={renderer}"
    tab.page.set_viewport_size(SMALL)
    tab.page.goto(f"{server.address('127.0.0.1')}&{wishes}")


@pytest.mark.parametrize("kind", ["codebooks", "scalars", "sorted"])
@pytest.mark.parametrize("renderer", RENDERERS)
def test_layers_are_seen_in_true_colours_one_after_the_other(
    tab: Tab, served: Any, renderer: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = pack(coded(scalars=kind == "scalars", sorted=kind == "sorted"))
    gate = Gate(monkeypatch, data)
    begin(tab, served("scene.mgs", data), renderer)
    whole = unpack(data)
    for i, end in enumerate(ends(data)):
        gate.let(end)
        count = sum(SIZES[: i + 1])
        tab.page.wait_for_function(f"{SHOWN} === {count}", timeout=30_000)
        tab.page.evaluate(TRUE_COLOURS)
        some = replace(whole.pick(slice(0, count)), layers=()).decode()
        decibels = nearness(tab, lambda camera, some=some: some.render(camera).image)
        print(f"{renderer}, {kind}, {count} Gaussians: {decibels:.1f} dB")
        assert decibels > 45
        state = tab.page.evaluate("document.querySelector('mobile-gs').dataset.state")
        assert state == "loading" or i == len(SIZES) - 1
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"


def behind(data: bytes, name: str) -> int:
    """Bytes up to the end of a stream, by how its name begins; of several, of the last one."""
    header, body = split(data)
    at, found = len(data) - len(body), 0
    for row in header["streams"]:
        at += row["bytes"] + -row["bytes"] % 8
        if row["name"].startswith(name) and "@" not in row["name"]:
            found = at
    return found


def test_a_slow_scene_keeps_its_dots_until_there_are_colours(
    tab: Tab, served: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 8000
    data = pack(make_scene(Case(count, LobeShape(2, 12, (64,)), size=300)))
    gate = Gate(monkeypatch, data)
    begin(tab, served("scene.mgs", data), "webgpu")
    gate.let(behind(data, "positions"))
    tab.page.wait_for_function(f"{SHOWN} === {count}", timeout=30_000)
    tab.page.wait_for_timeout(2500)  # what comes from here on is slow
    gate.let(behind(data, "rotation"))
    tab.page.wait_for_timeout(2500)
    viewer = "document.querySelector('mobile-gs').viewer"
    nothing = f"{viewer}.pixels({viewer}.camera(9, 9)).catch(({{ message }}) => message)"
    assert tab.page.evaluate(nothing) == "nothing can be drawn"
    gate.let(max(behind(data, "appearance"), behind(data, "opacity")))
    tab.page.evaluate(TRUE_COLOURS)
    assert tab.page.evaluate("document.querySelector('mobile-gs').dataset.state") == "loading"
    assert seen(tab, 160, 120)[1].std() > 0.05
    gate.let(len(data))
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"


def test_what_is_cut_where_colours_are_there_is_seen_with_them(tab: Tab, served: Any) -> None:
    data = pack(coded())
    assert "cut short" in visit(tab, served("scene.mgs", data[:-8]))
    tab.page.keyboard.press("Escape")
    assert tab.page.evaluate(SHOWN) == COUNT  # the last layer lacks some of its lobes
    whole = unpack(data).decode()
    assert nearness(tab, lambda camera: whole.render(camera).image) > 20


@pytest.mark.parametrize("renderer", RENDERERS)
def test_in_the_end_layers_make_no_difference(tab: Tab, served: Any, renderer: str) -> None:
    pictures = []
    tab.page.set_viewport_size(SMALL)
    for name, layers in (("layers.mgs", SIZES), ("plain.mgs", ())):
        data = pack(replace(coded(), layers=layers))
        assert visit(tab, served(name, data), f"renderer={renderer}") == "loaded"
        pictures.append(seen(tab, 160, 120)[1])
        assert tab.page.evaluate(SHOWN) == COUNT
    assert pictures[1].std() > 0.05
    decibels = psnr(*pictures)
    print(f"{renderer}: {decibels:.1f} dB")
    assert decibels > 80


def test_what_is_cut_behind_a_layer_stays_to_be_seen(tab: Tab, served: Any) -> None:
    data = pack(coded())
    said = visit(tab, served("scene.mgs", data[: ends(data)[0]]))
    assert "cut short" in said
    tab.page.keyboard.press("Escape")
    some = replace(unpack(data).pick(slice(0, SIZES[0])), layers=()).decode()
    assert nearness(tab, lambda camera: some.render(camera).image) > 45
    assert tab.page.evaluate(SHOWN) == SIZES[0]
