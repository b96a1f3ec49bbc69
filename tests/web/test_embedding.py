"""Elements in other pages: many, moved, under strict policies, without a height; walking."""

from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.support.browser import Tab
from tests.support.viewer_page import MGS, RENDERERS, STRICT, frames, visit

pytestmark = pytest.mark.thorough

HOLDERS = "[...document.querySelectorAll('mobile-gs')].map((one) => Boolean(one.viewer))"


def gallery(tab: Tab, count: int, style: str, renderer: str = "webgl") -> None:
    """Show a page with some elements, and wait until none is loading."""
    tab.share("scene.mgs", MGS)
    tab.page.evaluate(
        """async ([count, style, renderer]) => {
          document.body.innerHTML = "";
          await import("/src/element.js");
          for (let i = 0; i < count; i++) {
            const one = document.createElement("mobile-gs");
            one.style.cssText = style;
            one.setAttribute("renderer", renderer);
            one.setAttribute("variant", "floats");
            one.setAttribute("src", "/arrays/scene.mgs");
            document.body.append(one);
          }
        }""",
        [count, style, renderer],
    )
    quiet(tab)


def picture(tab: Tab, index: int) -> np.ndarray:
    """Return a screenshot of an element without buttons, float [height, width, 3], 0 to 1."""
    tab.page.evaluate(
        """(i) => {
          const { shadowRoot } = document.querySelectorAll("mobile-gs")[i];
          shadowRoot.querySelector(".chrome").hidden = true;
        }""",
        index,
    )
    taken = tab.page.locator("mobile-gs").nth(index).screenshot()
    return np.asarray(Image.open(BytesIO(taken)).convert("RGB")) / 255


def quiet(tab: Tab) -> None:
    """Wait until each element that has a viewer has loaded its scene."""
    tab.page.wait_for_function(
        """() => [...document.querySelectorAll("mobile-gs")].every(
          (one) => !one.viewer || (one.viewer.count && one.dataset.state === "loaded"))""",
        timeout=60_000,
    )
    frames(tab, 5)


def test_elements_out_of_sight_give_their_contexts_back(tab: Tab) -> None:
    gallery(tab, 7, "display: block; height: 380px")
    first = tab.page.evaluate(HOLDERS)
    assert sum(first) == 4 and first[0]
    tab.page.evaluate(
        """() => document.querySelectorAll("mobile-gs").forEach(({ viewer }) => {
          viewer?.pose.orbit(0.5, 0.1);
          if (viewer) viewer.background = [1, 0, 0];
        })"""
    )
    cameras = tab.page.evaluate(
        "[...document.querySelectorAll('mobile-gs')].map((one) => one.camera)"
    )
    come_into_sight(tab, 6)
    held = tab.page.evaluate(HOLDERS)
    assert held[6] and sum(held) == 4
    lost = next(index for index in range(7) if first[index] and not held[index])
    still = """(index) => {
      const root = document.querySelectorAll("mobile-gs")[index].shadowRoot;
      const still = root.querySelector(".still");
      if (!still) return null;
      const { data } = still.getContext("2d").getImageData(0, 0, still.width, still.height);
      return [!root.querySelector(".wake").hidden, Math.max(...data.slice(0, 40000))];
    }"""
    shown = tab.page.evaluate(still, lost)
    assert shown[0] and shown[1] > 0
    # it comes back as it was
    come_into_sight(tab, lost)
    assert sum(tab.page.evaluate(HOLDERS)) == 4
    assert tab.page.evaluate(still, lost) is None
    found = tab.page.evaluate(
        """(i) => {
          const one = document.querySelectorAll("mobile-gs")[i];
          return [one.camera, one.viewer.background];
        }""",
        lost,
    )
    assert found == [cameras[lost], [1, 0, 0]]


def come_into_sight(tab: Tab, index: int) -> None:
    """Scroll to an element, and wait until it shows its scene."""
    tab.page.evaluate("(i) => document.querySelectorAll('mobile-gs')[i].scrollIntoView()", index)
    tab.page.wait_for_function(
        "(i) => document.querySelectorAll('mobile-gs')[i].viewer?.count", arg=index
    )
    quiet(tab)


def test_elements_in_sight_wait_until_somebody_asks(tab: Tab) -> None:
    gallery(tab, 6, "display: inline-block; width: 190px; height: 180px")
    held = tab.page.evaluate(HOLDERS)
    assert held == [True] * 4 + [False] * 2
    before = picture(tab, 0)
    tab.page.evaluate(
        "document.querySelectorAll('mobile-gs')[5].shadowRoot.querySelector('.wake').click()"
    )
    quiet(tab)
    assert tab.page.evaluate(HOLDERS) == [False, True, True, True, False, True]
    # the picture stays, under the button in the middle
    changed = np.abs(picture(tab, 0) - before)
    height, width, _ = changed.shape
    assert before.std() > 0.05 and changed[:, : width // 4].max() < 0.02
    assert changed[height // 2 - 2 : height // 2 + 2].max() > 0.2
    # one that goes leaves its context to one that waits
    tab.page.evaluate("document.querySelectorAll('mobile-gs')[2].remove()")
    quiet(tab)
    assert sum(tab.page.evaluate(HOLDERS)) == 4


def test_eight_elements_of_webgpu_are_drawn_at_once(tab: Tab) -> None:
    gallery(tab, 9, "display: inline-block; width: 150px; height: 120px", "webgpu")
    assert tab.page.evaluate(HOLDERS) == [True] * 8 + [False]
    assert all(picture(tab, i).std() > 0.05 for i in (0, 7))


def test_an_element_that_is_scrolled_away_is_not_drawn(tab: Tab) -> None:
    gallery(tab, 3, "display: block; height: 380px")
    drawn = tab.page.evaluate(
        """async () => {
          const all = [...document.querySelectorAll("mobile-gs")];
          const count = all.map(() => 0);
          all.forEach((one, i) => one.addEventListener("frame", () => count[i]++));
          const frames = async (n) => { while (n--) await new Promise(requestAnimationFrame); };
          all.forEach(({ viewer }) => (viewer.turning = true));
          all.forEach(({ viewer }) => viewer.redraw());
          await frames(6);
          const before = count.slice();
          all[2].scrollIntoView();
          await frames(30);
          return [before, count];
        }"""
    )
    before, after = drawn
    assert before[0] > 1 and before[2] == 0
    assert after[2] > 1 and after[0] - before[0] < after[2]


def test_an_element_without_buttons_has_none_while_it_waits(tab: Tab) -> None:
    gallery(tab, 4, "display: inline-block; width: 190px; height: 180px")
    shown = tab.page.evaluate(
        """async () => {
          const one = document.createElement("mobile-gs");
          one.noui = true;
          document.body.append(one);
          await new Promise(requestAnimationFrame);
          const { hidden } = one.shadowRoot.querySelector(".chrome");
          return [Boolean(one.viewer), hidden, one.getAttribute("noui")];
        }"""
    )
    assert shown == [False, True, ""]


def test_an_element_that_is_moved_keeps_its_scene_and_camera(tab: Tab) -> None:
    gallery(tab, 1, "display: block; width: 300px; height: 200px")
    found = tab.page.evaluate(
        """async () => {
          const one = document.querySelector("mobile-gs");
          const { viewer } = one;
          viewer.pose.orbit(0.5, 0.1);
          const { camera } = one;
          const frame = document.createElement("div");
          document.body.prepend(frame);
          frame.append(one);
          await new Promise(requestAnimationFrame);
          const moved = one.viewer === viewer && one.camera === camera;
          one.remove();
          await new Promise(requestAnimationFrame);
          const gone = one.viewer;
          document.body.append(one);
          return [moved, gone, camera];
        }"""
    )
    quiet(tab)
    assert found[:2] == [True, None]
    assert tab.page.evaluate("document.querySelector('mobile-gs').camera") == found[2]
    assert picture(tab, 0).std() > 0.05


@pytest.mark.parametrize("renderer", RENDERERS)
def test_strict_policies_and_trusted_types_allow_an_element(renderer: str, tab: Tab) -> None:
    tab.share("scene.mgs", MGS)
    page = f"""<!doctype html><meta charset=utf-8><link rel=icon href=data:,><title>strict</title>
      <script type=module src=/src/element.js></script>
      <mobile-gs src=/arrays/scene.mgs variant=floats renderer={renderer}></mobile-gs>"""
    headers = {"Content-Type": "text/html", "Content-Security-Policy": STRICT}
    address = f"{tab.address}/strict.html"
    tab.page.route(address, lambda route: route.fulfill(body=page, headers=headers))
    tab.page.goto(address)
    tab.page.wait_for_function("document.querySelector('mobile-gs').viewer?.count")
    quiet(tab)
    assert picture(tab, 0).std() > 0.05
    # the parts that are loaded later, too
    tab.page.evaluate("document.querySelector('mobile-gs').act('share')")
    inside = "document.querySelector('mobile-gs').shadowRoot.querySelector"
    tab.page.wait_for_function(f"!{inside}('.sheet.share').hidden")
    height = tab.page.evaluate(f"getComputedStyle({inside}('.bar')).height")
    assert height == "3px"  # the style is there


def test_attributes_are_properties(tab: Tab) -> None:
    gallery(tab, 1, "display: block; width: 300px; height: 200px")
    found = tab.page.evaluate(
        """() => {
          const one = document.querySelector("mobile-gs");
          const before = [one.src, one.poster, one.noui];
          Object.assign(one, { fov: 40, startPortrait: "0 0 1 0 0 0 1 1", autorotate: true });
          const given = ["start-portrait", "autorotate"].map((name) => one.getAttribute(name));
          const set = [one.viewer.fov, ...given];
          Object.assign(one, { fov: null, autorotate: false });
          return [before, set, one.viewer.fov, one.hasAttribute("autorotate"), one.fov];
        }"""
    )
    assert found == [
        ["/arrays/scene.mgs", "", False],
        [40, "0 0 1 0 0 0 1 1", ""],
        None,
        False,
        "",
    ]


def test_an_element_has_a_height(tab: Tab) -> None:
    sizes = {
        "display: block; width: 320px": [320, 200],
        "display: block; width: 320px; height: 100px": [320, 120],  # the least
        "display: block; width: 320px; height: 300px": [320, 300],
        "position: fixed; inset: 0": [640, 400],
    }
    for style, size in sizes.items():
        gallery(tab, 1, style)
        box = tab.page.locator("mobile-gs").bounding_box()
        assert [box["width"], box["height"]] == size, style


def test_walking_keeps_the_height(tab: Tab, served: Callable[[str, bytes], Any]) -> None:
    assert visit(tab, served("scene.mgs", MGS), "renderer=webgl") == "loaded"
    height = """() => {
      const { pose } = document.querySelector("mobile-gs").viewer;
      return pose.eye.reduce((sum, x, i) => sum + x * pose.up[i], 0);
    }"""
    before = tab.page.evaluate(height)
    tab.page.evaluate(
        """() => {
          const { viewer } = document.querySelector("mobile-gs");
          viewer.mode = "walk";
          viewer.pose.look(0, 0.4); // downwards: walking ahead stays level
          viewer.stride(0.3, 1);
        }"""
    )
    eye = tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.eye")
    frames(tab, 20)
    tab.page.evaluate("document.querySelector('mobile-gs').viewer.stride(0, 0)")
    moved = tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.eye")
    assert max(abs(a - b) for a, b in zip(eye, moved, strict=True)) > 0.01
    assert tab.page.evaluate(height) == pytest.approx(before, abs=1e-3)
    # lifted, it falls back
    tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.move(0, -0.5, 0)")
    tab.page.evaluate("document.querySelector('mobile-gs').viewer.redraw()")
    tab.page.wait_for_function(f"Math.abs(({height})() - {before}) < 1e-2", timeout=20_000)


def test_no_element_is_suspended_for_one_that_does_not_fit_even_so(tab: Tab) -> None:
    found = tab.run(
        """
        const { take } = await import("/src/contexts.js");
        const suspended = [];
        const holder = (name, cost, inSight) =>
          ({ cost, inSight, suspend: () => suspended.push(name), resume() {} });
        take(holder("hidden", 1, false), false);
        for (let i = 0; i < 7; i++) take(holder(`seen ${i}`, 1, true), false);
        const webgl = holder("webgl", 2, true);
        const able = take(webgl, false);
        const before = [...suspended];
        return [able, before, take(webgl, true), suspended];
        """
    )
    assert found == [False, [], True, ["hidden", "seen 0"]]
