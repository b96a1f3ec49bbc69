"""The benchmark of the viewer's page: fresh orders, rates by second and window, several scenes."""

import json
import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest
import torch

from mobilegs.camera import look_at
from mobilegs.mgs.codec import encode_mgs
from mobilegs.representation.lobes import LobeShape
from tests.support.browser import Tab
from tests.support.scene_cases import Case, make_scene
from tests.support.scenes import camera as make_camera
from tests.support.viewer_page import RENDERERS

pytestmark = pytest.mark.thorough

UP = torch.tensor([0.0, -1.0, 0.0])
# another direction in every frame
CAMERAS = [
    replace(make_camera(), viewmat=look_at(torch.tensor(eye), torch.zeros(3), UP))
    for eye in ((0.0, 0.0, -3.0), (3.0, -0.5, 0.0), (0.0, 0.5, 3.0))
]
SORTED = encode_mgs(replace(make_scene(Case(800, None, size=300)), blend="sorted", views=CAMERAS))
PLAIN = encode_mgs(replace(make_scene(Case(800, LobeShape(2, 12, (64,)), size=300)), views=CAMERAS))
DRAWN = {"project", "splat", "resolve"}
# each draw, with the direction of the order that came since the last one; null: none came
RECORD = """
window.drawn = [];
{
  let requested = null;
  let received = null;
  const Own = Worker;
  window.Worker = class extends Own {
    constructor(...given) {
      super(...given);
      // before the viewer's own listener
      this.addEventListener("message", ({ data }) => {
        if (data.kind === "order") received = requested;
      });
    }
    postMessage(message, ...more) {
      if ("forward" in message) requested = Array.from(message.forward);
      super.postMessage(message, ...more);
    }
  };
  addEventListener("load", () => {
    const element = document.querySelector("mobile-gs");
    element.addEventListener("load", () => {
      const { viewer } = element;
      const { drawAt } = viewer;
      viewer.drawAt = async function (...size) {
        const took = await drawAt.apply(viewer, size);
        const { viewmat } = viewer.camera(9, 9);
        drawn.push({ forward: Array.from(viewmat).slice(8, 11), order: received });
        received = null;
        return took;
      };
    }, { once: true });
  });
}
"""


def measured(tab: Tab, bench: str, renderer: str, *files: bytes) -> dict[str, Any]:
    """Open the page with `?bench` and some scenes, and return the report."""
    for i, data in enumerate(files):
        tab.share(f"{i}.mgs", data)
    urls = "".join(f"&url=/arrays/{i}.mgs" for i in range(len(files)))
    wishes = f"bench={bench}&renderer={renderer}&variant=floats"
    tab.page.goto(f"{tab.address}/dist/index.html?{wishes}{urls}")
    tab.page.get_by_role("dialog", name="Benchmark").wait_for(timeout=120_000)
    return json.loads(tab.page.get_by_label("Results as JSON").input_value())


def check_rates(scene: dict[str, Any], seconds: int) -> None:
    """Assert what holds for the rates of every scene."""
    cold, steady, whole = (scene[name] for name in ("cold", "steady", "whole"))
    for rate in (cold, steady, whole):
        assert rate["frames"] > 0 and 0 < rate["milliseconds"] <= rate["milliseconds95"]
        assert rate["fps"] > 0
    assert max(cold["frames"], steady["frames"]) <= whole["frames"]
    assert len(scene["fps_by_second"]) == seconds
    told = [fps for fps in scene["fps_by_second"] if fps is not None]
    assert told and min(told) <= whole["fps"] <= max(told)
    levels = 1 if scene["sorted"] else 4
    assert len(scene["fragments"]) == levels and sum(scene["fragments"]) > 0


@pytest.mark.parametrize("renderer", RENDERERS)
def test_the_report_has_the_rates_and_the_passes_of_each_scene(tab: Tab, renderer: str) -> None:
    tab.page.add_init_script(
        """navigator.getBattery = async () => ({ level: 0.83, charging: false });"""
    )
    found = measured(tab, "1,96x64", renderer, PLAIN, SORTED)
    assert (found["width"], found["height"], found["seconds"]) == (96, 64, 1)
    assert "Chrome" in found["browser"] and found["viewer"]
    files = {"/arrays/0.mgs": PLAIN, "/arrays/1.mgs": SORTED}
    assert [scene["scene"] for scene in found["scenes"]] == list(files)
    for scene in found["scenes"]:
        check_rates(scene, 1)
        assert scene["renderer"] == {"webgpu": "WebGPU", "webgl": "WebGL2"}[renderer]
        assert scene["adapter"] and scene["gaussians"] == 800
        assert scene["path"] == 120  # of three cameras
        assert scene["file_bytes"] == len(files[scene["scene"]]) and not scene["interrupted"]
        reading = {"percent": 83, "charging": False}
        assert scene["battery"] == {"start": reading, "end": reading}
        for passes in (scene["steady"]["passes"], scene["whole"]["passes"]):
            assert set(passes) == DRAWN and all(0 <= took < 10_000 for took in passes.values())
        assert scene["whole"]["passes"]["splat"] > 0
    plain, ordered = found["scenes"]
    assert (plain["sorted"], plain["sorted_by"]) == (False, None)
    assert (ordered["sorted"], ordered["sorted_by"]) == (True, "worker")
    assert all(plain[window]["order"] is None for window in ("cold", "steady", "whole"))
    heading = tab.page.get_by_role("dialog", name="Benchmark").locator("h2").inner_text()
    assert heading.count("frames/s cold") == 2


def test_each_frame_of_a_sorted_scene_has_the_order_of_its_camera(tab: Tab) -> None:
    tab.page.add_init_script(RECORD)
    found = measured(tab, "1,96x64", "webgpu", SORTED)
    (scene,) = found["scenes"]
    check_rates(scene, 1)
    assert 0 < scene["whole"]["order"] <= scene["whole"]["milliseconds"]
    drawn = tab.page.evaluate("drawn")
    assert len(drawn) >= scene["whole"]["frames"] + 10  # and those before the measurement
    for frame in drawn:
        assert frame["order"] is not None, "a frame was drawn in an old order"
        assert math.dist(frame["order"], frame["forward"]) < 1e-6
    assert all(one["forward"] != after["forward"] for one, after in pairwise(drawn))


def test_the_path_depends_on_the_number_of_frames_only(tab: Tab) -> None:
    """On a slow device, fewer frames are drawn, of the same cameras in the same order."""
    tab.page.add_init_script(
        """window.poses = [];
        addEventListener("load", () => {
          const element = document.querySelector("mobile-gs");
          const slowed = Number(new URLSearchParams(location.search).get("slowed"));
          element.addEventListener("load", () => {
            const { viewer } = element;
            const { drawAt } = viewer;
            viewer.drawAt = async function (...size) {
              poses.push([...viewer.pose.eye, ...viewer.pose.target]);
              const order = await drawAt.apply(viewer, size);
              await new Promise((resolve) => setTimeout(resolve, slowed));
              return order;
            };
          }, { once: true });
        });"""
    )
    paths = []
    for slowed in (0, 100):
        measured(tab, f"1,32x32&slowed={slowed}", "webgl", PLAIN)
        paths.append(tab.page.evaluate("poses"))
    fast, slow = paths
    assert len(slow) < len(fast) and slow == fast[: len(slow)]
    assert all(pose != after for pose, after in pairwise(slow))


def test_no_battery_and_a_hidden_page_are_reported(tab: Tab) -> None:
    tab.page.add_init_script(
        """delete Navigator.prototype.getBattery;
        addEventListener("load", () => {
          const element = document.querySelector("mobile-gs");
          element.addEventListener("load", () => {
            const { viewer } = element;
            const { drawAt } = viewer;
            viewer.drawAt = async function (...size) {
              viewer.drawAt = drawAt;
              const order = await drawAt.apply(viewer, size);
              Object.defineProperty(document, "hidden", { value: true, configurable: true });
              document.dispatchEvent(new Event("visibilitychange"));
              delete document.hidden;
              return order;
            };
          }, { once: true });
        });"""
    )
    (scene,) = measured(tab, "1,32x32", "webgl", PLAIN)["scenes"]
    assert scene["battery"] is None and scene["interrupted"] is True
    heading = tab.page.get_by_role("dialog", name="Benchmark").locator("h2").inner_text()
    assert "hidden" in heading


def test_a_second_scene_that_cannot_be_loaded_ends_the_measurement(tab: Tab) -> None:
    tab.share("0.mgs", PLAIN)
    tab.share("1.mgs", b"no scene at all")
    wishes = "bench=1,32x32&renderer=webgl&url=/arrays/0.mgs&url=/arrays/1.mgs"
    tab.page.goto(f"{tab.address}/dist/index.html?{wishes}")
    tab.page.get_by_role("alert").filter(has_text=".").wait_for(timeout=60_000)
    assert tab.page.get_by_role("dialog", name="Benchmark").is_hidden()
