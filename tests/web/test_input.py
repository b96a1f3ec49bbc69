"""Input by mouse, fingers and files, and the viewer inside other pages."""

import base64
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import TimeoutError

from tests.support.browser import Tab
from tests.support.viewer_page import MGS, SETTLED, still, until, visit

pytestmark = pytest.mark.thorough

POSE = """() => {
  const { eye, target } = document.querySelector("mobile-gs").viewer.pose;
  return [eye, target];
}"""
COUNT = "document.querySelector('mobile-gs').viewer.count"


def pose(tab: Tab) -> tuple[np.ndarray, np.ndarray]:
    """The visitor's eye and target."""
    eye, target = tab.page.evaluate(POSE)
    return np.array(eye), np.array(target)


def reach(tab: Tab) -> float:
    eye, target = pose(tab)
    return float(np.linalg.norm(target - eye))


@pytest.mark.quick
def test_a_double_click_sets_the_target_and_two_drags_do_not(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    mouse = tab.page.mouse
    _, before = pose(tab)
    for _ in range(2):
        mouse.move(250, 150)
        mouse.down()
        mouse.move(290, 150, steps=4)
        mouse.up()
    eye, target = pose(tab)
    assert np.allclose(target, before)  # it turned around the same place
    for button in ("right", "middle"):
        mouse.dblclick(250, 150, button=button)
    assert np.allclose(pose(tab)[1], before)
    mouse.dblclick(250, 150)
    until(tab, lambda: not np.allclose(pose(tab)[1], before, atol=1e-3))
    after, _ = pose(tab)
    assert np.allclose(after, eye)


@pytest.mark.quick
def test_fingers_turn_pinch_and_pan(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    session = tab.page.context.new_cdp_session(tab.page)
    session.send("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2})

    def touch(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        session.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})

    def glide(begin: list[tuple[float, float]], end: list[tuple[float, float]]) -> None:
        for share in np.linspace(0.1, 1, 10):
            places = [
                (x + share * (u - x), y + share * (v - y))
                for (x, y), (u, v) in zip(begin, end, strict=True)
            ]
            touch("Move", *places)

    before, far = pose(tab), reach(tab)
    touch("Start", (200, 200))
    glide([(200, 200)], [(300, 200)])
    touch("End")
    turned = pose(tab)
    assert np.allclose(turned[1], before[1]) and not np.allclose(turned[0], before[0], atol=0.01)
    assert reach(tab) == pytest.approx(far, rel=1e-3)

    touch("Start", (280, 200), (360, 200))
    glide([(280, 200), (360, 200)], [(240, 200), (400, 200)])
    # a few pixels are no movement yet, and browsers may keep the last ones to themselves
    assert reach(tab) == pytest.approx(far / 2, rel=0.1)
    near, aim = reach(tab), pose(tab)[1]
    glide([(240, 200), (400, 200)], [(240, 260), (400, 260)])
    assert reach(tab) == pytest.approx(near, rel=0.1)
    assert np.linalg.norm(pose(tab)[1] - aim) > 0.05 * near
    # one of them is lifted first, far from the other: nothing jumps, and the other turns
    aim, eye = pose(tab)[1], pose(tab)[0]
    touch("End", (240, 260))
    assert np.allclose(pose(tab)[0], eye, atol=0.1 * near)
    touch("End")
    assert np.allclose(pose(tab)[1], aim, atol=0.1 * near)


def test_a_polite_element_lets_the_page_scroll(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    tab.page.evaluate(
        """() => {
          document.body.style.height = "auto";
          document.querySelector("mobile-gs").remove();
          const polite = document.createElement("mobile-gs");
          for (const name of ["polite", "noui"]) polite.setAttribute(name, "");
          polite.setAttribute("src", new URLSearchParams(location.search).get("url"));
          polite.style.cssText = "height: 200px; position: static";
          document.body.append(polite);
          document.body.insertAdjacentHTML("beforeend", "<div style='height: 3000px'></div>");
        }"""
    )
    tab.page.wait_for_function(SETTLED, timeout=60_000)
    far = reach(tab)
    tab.page.mouse.move(200, 100)
    tab.page.mouse.wheel(0, 300)
    tab.page.wait_for_function("scrollY > 0", timeout=10_000)
    assert reach(tab) == far
    tab.page.evaluate("scrollTo(0, 0)")
    tab.page.keyboard.down("Control")
    tab.page.mouse.wheel(0, 300)
    tab.page.keyboard.up("Control")
    until(tab, lambda: reach(tab) > far)


def without_policy(tab: Tab) -> str:
    """Open the viewer in a page that may frame others, and be framed; return its address."""
    tab.share("scene.mgs", MGS)
    address = f"{tab.address}/src/index.html?url=/arrays/scene.mgs&scale=1&variant=floats"
    tab.page.goto(address)
    tab.page.wait_for_function(SETTLED, timeout=60_000)
    return address


def test_the_viewer_works_in_a_srcdoc_frame(tab: Tab) -> None:
    address = without_policy(tab)
    page = tab.page.evaluate("async (address) => (await fetch(address)).text()", address)
    inside = page.replace("<head>", f"<head><base href='{address.partition('?')[0]}'>").replace(
        "<mobile-gs linkable>", "<mobile-gs src='/arrays/scene.mgs'>"
    )
    tab.page.evaluate(
        """(inside) => {
          document.body.innerHTML = "";
          const frame = document.createElement("iframe");
          frame.style.cssText = "width: 320px; height: 240px";
          frame.srcdoc = inside;
          document.body.append(frame);
        }""",
        inside,
    )
    frame = tab.page.frames[-1]
    frame.wait_for_function("document.querySelector('mobile-gs')?.shadowRoot", timeout=60_000)
    frame.wait_for_function(SETTLED, timeout=60_000)
    frame.evaluate(
        """() => {
          const { replaceState } = history;
          history.replaceState = (...given) => {
            window.tried = true;
            replaceState.apply(history, given);
          };
        }"""
    )
    for _ in range(20):  # the browser may route the first events before it knows the new frame
        tab.page.mouse.move(100, 100)
        tab.page.mouse.down()
        tab.page.mouse.move(160, 100, steps=4)
        tab.page.mouse.up()
        with suppress(TimeoutError):
            frame.wait_for_function("window.tried", timeout=1000)
            break
    assert frame.evaluate("window.tried")  # an error would be a complaint


def test_pinches_full_screen_and_keyboard_layouts(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    # fingers fly in fly mode
    pinch = """(mode) => {
      const { viewer, shadowRoot } = document.querySelector("mobile-gs");
      const canvas = shadowRoot.querySelector("canvas");
      canvas.setPointerCapture = () => {};
      viewer.mode = mode;
      const { pose } = viewer;
      const reach = () => Math.hypot(...pose.target.map((value, k) => value - pose.eye[k]));
      const [target, before] = [[...pose.target], reach()];
      const send = (kind, pointerId, x) =>
        canvas.dispatchEvent(new PointerEvent(kind, { pointerId, clientX: x, clientY: 200 }));
      send("pointerdown", 1, 300);
      send("pointerdown", 2, 320);
      for (let x = 330; x <= 620; x += 10) send("pointermove", 2, x);
      send("pointerup", 1, 300);
      send("pointerup", 2, 620);
      return [reach() / before, Math.hypot(...pose.target.map((value, k) => value - target[k]))];
    }"""
    fly = tab.page.evaluate(pinch, "fly")
    assert fly[0] == pytest.approx(1) and fly[1] > 1
    tab.page.mouse.move(500, 300)
    tab.page.mouse.down()  # presses elsewhere, so that the next one is not a double tap
    tab.page.mouse.up()
    # it comes nearer to what it looks at
    assert tab.page.evaluate(pinch, "orbit")[0] == pytest.approx(1 / 16)
    # a trackpad zooms
    tab.page.mouse.move(200, 150)
    far = reach(tab)
    wheel = """([x, y]) => document.querySelector("mobile-gs").shadowRoot.querySelector("canvas")
      .dispatchEvent(new WheelEvent("wheel", {
        deltaY: -3, ctrlKey: true, clientX: x, clientY: y, cancelable: true,
      }))"""
    taken = [not tab.page.evaluate(wheel, [200, 150]) for _ in range(20)]
    assert all(taken)  # or the page would be zoomed, too
    assert 0.4 < reach(tab) / far < 0.7
    # full screen
    tab.page.keyboard.press("f")
    tab.page.wait_for_function("document.fullscreenElement?.localName === 'mobile-gs'")
    tab.page.keyboard.press("f")
    tab.page.wait_for_function("document.fullscreenElement === null")
    # shortcuts on other layouts
    press = """([key, code]) => {
      const { shadowRoot, viewer } = document.querySelector("mobile-gs");
      shadowRoot.querySelector("canvas").dispatchEvent(
        new KeyboardEvent("keydown", { key, code, bubbles: true, cancelable: true }));
      return [viewer.mode, shadowRoot.querySelector(".settings").hidden];
    }"""
    # French, Russian, then Dvorak, whose O lies where others fly backwards
    assert tab.page.evaluate(press, ["m", "Semicolon"])[0] == "fly"
    assert tab.page.evaluate(press, ["ь", "KeyM"])[0] == "walk"
    assert tab.page.evaluate(press, ["m", "KeyM"])[0] == "orbit"
    assert tab.page.evaluate(press, ["o", "KeyS"])[1]


def test_files_can_be_dropped(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.ply", b"no scene"))
    tab.page.evaluate(
        """(text) => {
          const bytes = Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
          const dataTransfer = new DataTransfer();
          for (const name of ["a.mgs", "b.mgs"]) dataTransfer.items.add(new File([bytes], name));
          const element = document.querySelector("mobile-gs");
          const panel = element.shadowRoot.querySelector(".drop");
          for (const kind of ["dragover", "drop"]) {
            element.dispatchEvent(new DragEvent(kind, { dataTransfer, cancelable: true }));
            if (panel.hidden === (kind === "dragover")) throw new Error("the panel says nothing");
          }
        }""",
        base64.b64encode(MGS).decode(),
    )
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert tab.page.evaluate(COUNT) == 800
    tab.page.get_by_role("slider").wait_for()  # the other one is compared with it


def test_a_frame_keeps_the_focus_and_two_elements_render(tab: Tab) -> None:
    address = without_policy(tab)
    tab.page.evaluate(
        """(address) => {
          const frame = Object.assign(document.createElement("iframe"), { src: address });
          frame.style.cssText = "position: fixed; inset: 200px 0 0 0; width: 100%; height: 200px";
          const field = document.createElement("input");
          const [first] = document.querySelectorAll("mobile-gs");
          first.style.cssText = "position: fixed; inset: 0 50% auto 0; height: 200px";
          const second = first.cloneNode();
          second.style.cssText = "position: fixed; inset: 0 0 auto 50%; height: 200px";
          document.body.append(second, frame, field);
          field.focus();
        }""",
        address,
    )
    frame = next(one for one in tab.page.frames if one.parent_frame)
    for place in (tab.page.main_frame, frame):
        place.wait_for_function(
            """() => [...document.querySelectorAll("mobile-gs")].every(
              (one) => one.dataset.state === "loaded" && one.viewer.count === 800)""",
            timeout=60_000,
        )
    assert tab.page.evaluate("document.activeElement.localName") == "input"
    picture = still(tab).astype(int)
    down, across = (length // 2 for length in picture.shape[:2])
    for part in (picture[:down, :across], picture[:down, across:], picture[down:]):
        assert part.std() > 10  # something is to be seen in each
