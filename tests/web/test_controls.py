"""Settings, keyboard access and screen readers."""

import re
from io import BytesIO
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.evaluate.metrics import psnr
from mobilegs.mgs.codec import decode_mgs
from tests.support.browser import Chromium, Tab
from tests.support.viewer_page import MGS, RENDERERS, frames, pose_moved, seen, until, visit

pytestmark = pytest.mark.thorough

FOCUS_OF_SCENE = "Press H for the keys"
# how a screen reader would call what has the focus, as far as this page's markup goes
FOCUSED = """() => {
  const focused = document.querySelector("mobile-gs").shadowRoot.activeElement;
  if (focused === null) return null;
  const label = focused.labels?.[0]?.textContent;
  return (focused.getAttribute("aria-label") ?? label ?? focused.textContent).trim();
}"""


def expected(tab: Tab, color: list[float] | None) -> torch.Tensor:
    camera, _ = seen(tab, 160, 120)
    scene = decode_mgs(MGS).decode()
    if color is not None:
        scene.background = torch.tensor(color, dtype=torch.float32)
    return scene.render(camera).image


@pytest.mark.parametrize("renderer", RENDERERS)
def test_the_background_can_be_set(tab: Tab, served: Any, renderer: str) -> None:
    visit(tab, served("scene.mgs", MGS), f"renderer={renderer}", "background=ff8000")
    # a training camera sees no background in this scene
    tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.dolly(8)")
    orange = expected(tab, [1, 128 / 255, 0])
    assert psnr(seen(tab, 160, 120)[1], orange) > 45
    own = expected(tab, None)
    assert psnr(orange, own) < 30
    for word, image in (
        ("Navy", expected(tab, [0, 0, 128 / 255])),
        ("no colour", own),
        ("#fff", expected(tab, [1, 1, 1])),
    ):
        tab.page.evaluate(
            "(word) => document.querySelector('mobile-gs').setAttribute('background', word)", word
        )
        assert psnr(seen(tab, 160, 120)[1], image) > 45, word
    tab.page.keyboard.press("o")
    assert tab.page.get_by_label("Background").input_value() == "#ffffff"
    tab.page.get_by_role("button", name="The scene's own").click()
    assert psnr(seen(tab, 160, 120)[1], own) > 45


def test_the_field_of_view_can_be_set(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS), "fov=90")
    camera, _ = seen(tab, 160, 120)
    focal = (160 * 120) ** 0.5 / 2  # between the width's and the height's
    assert camera.K[0, 0] == pytest.approx(focal) and camera.K[1, 1] == pytest.approx(focal)
    tab.page.evaluate("document.querySelector('mobile-gs').removeAttribute('fov')")
    trained = decode_mgs(MGS).views[0]
    camera, _ = seen(tab, trained.width, trained.height)
    assert camera.K[0, 0] == pytest.approx(
        (trained.K[0, 0] * trained.K[1, 1]).sqrt().item(), rel=1e-4
    )


def test_autorotate_stops_at_the_first_input(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS), "autorotate")
    first, _ = seen(tab, 16, 16)
    pose_moved(tab, first.position)
    tab.page.mouse.click(200, 200)
    stopped, _ = seen(tab, 16, 16)
    frames(tab, 10)
    torch.testing.assert_close(seen(tab, 16, 16)[0].viewmat, stopped.viewmat)
    tab.page.keyboard.press("o")
    box = tab.page.get_by_label("Rotate slowly")
    assert not box.is_checked()
    box.check()
    pose_moved(tab, stopped.position)
    box.uncheck()


def test_autorotate_respects_reduced_motion(tab: Tab, served: Any) -> None:
    tab.page.emulate_media(reduced_motion="reduce")
    visit(tab, served("scene.mgs", MGS), "autorotate")
    first, _ = seen(tab, 16, 16)
    frames(tab, 10)
    torch.testing.assert_close(seen(tab, 16, 16)[0].viewmat, first.viewmat)


@pytest.mark.quick
def test_the_settings_change_the_viewer(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    tab.page.evaluate("document.querySelector('mobile-gs').setAttribute('scale', 0.8)")
    tab.page.get_by_role("button", name="Settings").click()
    panel = tab.page.get_by_role("dialog", name="Settings")
    resolution = panel.get_by_label("Resolution")
    assert resolution.locator("option:checked").inner_text() == "80 %"
    canvas = tab.page.locator("mobile-gs canvas")
    for share in ("0.5", "1"):
        resolution.select_option(share)
        width = round(float(share) * tab.page.evaluate("innerWidth * devicePixelRatio"))
        until(tab, lambda width=width: canvas.evaluate("(canvas) => canvas.width") == width)
    panel.get_by_label("Dragging").select_option("fly")
    tab.page.keyboard.press("r")  # a letter that chooses in a list does nothing else
    viewer = "document.querySelector('mobile-gs').viewer"
    assert tab.page.evaluate(f"{viewer}.mode") == "fly"
    panel.get_by_label("Show the frame rate").check()
    stats = tab.page.locator("mobile-gs .stats")
    stats.wait_for(timeout=5000)
    stats.filter(has_text="800 Gaussians").wait_for(timeout=10_000)
    assert "Rendered with Web" in panel.inner_text()
    tab.page.evaluate(f"{viewer}.pose.dolly(2)")
    panel.get_by_role("button", name="Next camera").click()
    eye = tab.page.evaluate(f"{viewer}.pose.eye")
    assert eye == pytest.approx(decode_mgs(MGS).views[1].position.tolist(), abs=1e-4)


def test_keyboard_focus_is_visible(chromium: Chromium, served: Any) -> None:
    tab = chromium.tab(0.5)
    visit(tab, served("scene.mgs", MGS))
    tab.page.keyboard.press("Tab")
    before = tab.page.screenshot()
    tab.page.keyboard.press("Shift+Tab")
    assert FOCUS_OF_SCENE in tab.page.evaluate(FOCUSED)
    around = [
        np.asarray(Image.open(BytesIO(png)).convert("RGB"), float)
        for png in (before, tab.page.screenshot())
    ]
    changed = np.abs(around[0] - around[1]).max(axis=2) > 30
    assert changed[0].mean() > 0.9 and changed[:, 0].mean() > 0.9
    assert not changed[10:30, 10:30].any()
    tab.close()


def test_a_screen_reader_hears_the_label_and_what_happens(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    said = tab.page.get_by_role("status").first
    assert re.fullmatch(r"[\d,]+ Gaussians loaded\.", said.text_content())
    said.evaluate(
        """(part) => {
          window.notices = [];
          const note = () =>
            notices.push([part.textContent, part.matches(".seen"), performance.now()]);
          new MutationObserver(note).observe(part, { childList: true, attributeFilter: ["class"] });
        }"""
    )
    words = ["Dragging looks around.", "Walk with the stick", "Dragging rotates the scene."]
    for _ in words:
        tab.page.keyboard.press("m")
        tab.page.wait_for_timeout(300)
    tab.page.wait_for_function("notices.length > 1 && !notices.at(-1)[1]", timeout=20_000)
    *shown, (_, _, hidden) = tab.page.evaluate("notices")
    assert all(seen for _, seen, _ in shown)
    assert all(text.startswith(start) for (text, *_), start in zip(shown, words, strict=True))
    assert hidden - shown[-1][2] > 1900  # an earlier text's end does not cut it short
    tab.page.evaluate(
        """() => {
          const other = document.createElement("mobile-gs");
          other.setAttribute("alt", "A garden with a pond");
          document.body.append(other);
        }"""
    )
    canvas = "[...document.querySelectorAll('mobile-gs')].at(-1).shadowRoot.querySelector('canvas')"
    words = "A garden with a pond. Press H for the keys."
    tab.page.wait_for_function(f"{canvas}.ariaLabel === '{words}'")


def test_noui_hides_buttons_and_keeps_keys(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS), "noui")
    assert not tab.page.get_by_role("button").first.is_visible()
    tab.page.keyboard.press("h")
    assert tab.page.get_by_role("dialog").is_visible()


def test_a_poster_is_shown_until_there_is_a_scene(tab: Tab, served: Any) -> None:
    tab.page.route(
        re.compile(r"^[^?]*/poster"),
        lambda route: route.fulfill(body=b"", content_type="image/png"),
    )
    server = served("scene.mgs", MGS)
    server.scenes["/scene"].unlink()
    assert "404" in visit(tab, server, 'poster=/poster"),url("x.png')
    shown = tab.page.evaluate(
        "getComputedStyle(document.querySelector('mobile-gs')).backgroundImage"
    )
    assert shown.startswith(f'url("http://127.0.0.1:{server.server_port}/poster%22)')
    assert "x.png" in shown and shown.count('url("') == 1  # it is one address, whatever it holds
    tab.ignore("status of 404")
