"""Comparison of two scenes with one camera."""

import base64
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from playwright.sync_api import Route
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.evaluate.metrics import psnr
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.mgs.codec import decode_mgs
from mobilegs.render import render_sorted
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.scene import Scene
from tests.support.browser import Chromium, Tab
from tests.support.viewer_page import MGS, RENDERERS, SETTLED, nearness, screen, seen, still, visit

pytestmark = pytest.mark.thorough

OPEN = """(wishes) => Object.entries(wishes).forEach(([name, value]) =>
  document.querySelector("mobile-gs").setAttribute(name, value))"""


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scene that all tests open first, as a plain one."""
    path = tmp_path_factory.mktemp("plain") / "made.ply"
    write_ply(path, decode_mgs(MGS).decode().gaussians)
    return path


def offer(tab: Tab, name: str, content: bytes) -> None:
    """Makes the server of the page have another file."""

    def answer(route: Route) -> None:
        route.fulfill(body=content, content_type="application/octet-stream")

    tab.page.route(re.compile(rf"^[^?]*/{re.escape(name)}(\?|$)"), answer)


def both(tab: Tab, served: Any, plain: Path, *wishes: str) -> str:
    offer(tab, "plain.ply", plain.read_bytes())
    said = visit(tab, served("scene.mgs", MGS), "compare=/plain.ply", *wishes)
    tab.page.get_by_role("slider").wait_for(timeout=20_000)
    return said


def look(tab: Tab) -> np.ndarray:
    """The screen without the elements that lie over the picture."""
    return screen(tab)[60:340]


@pytest.mark.parametrize("renderer", RENDERERS)
@pytest.mark.quick
def test_both_sides_match_the_python_renderer(
    tab: Tab, served: Any, plain: Path, renderer: str
) -> None:
    assert both(tab, served, plain, f"renderer={renderer}") == "loaded"
    scenes = [decode_mgs(MGS).decode(), Scene(read_ply(plain))]
    for side, scene in enumerate(scenes):
        decibels = nearness(tab, lambda camera, scene=scene: scene.render(camera).image, side)
        print(f"{renderer}, side {side}: {decibels:.1f} dB")
        assert decibels > 45
    handle = tab.page.get_by_role("slider")
    assert handle.get_attribute("aria-label") == "scene on the left, plain.ply on the right"
    assert handle.inner_text().split() == ["scene", "plain.ply"]


def test_the_handle_moves_by_hand_and_keys_and_not_the_camera(
    tab: Tab, served: Any, plain: Path
) -> None:
    both(tab, served, plain)
    before, _ = seen(tab, 64, 48)
    handle = tab.page.get_by_role("slider")
    box = handle.bounding_box()
    width = tab.page.viewport_size["width"]
    assert box["x"] + box["width"] / 2 == pytest.approx(width / 2, abs=1)
    tab.page.mouse.move(width / 2, 300)
    tab.page.mouse.down()
    tab.page.mouse.move(width / 4, 350, steps=4)
    tab.page.mouse.up()
    tab.page.mouse.move(width / 3, 350)  # it is let go
    cut = tab.page.evaluate(
        "document.querySelector('mobile-gs').shadowRoot.querySelector('.over').style.clipPath"
    )
    assert cut == "inset(0px 0px 0px 25%)"
    assert handle.get_attribute("aria-valuenow") == "25"
    tab.page.locator("mobile-gs canvas").first.focus()
    tab.page.keyboard.press("Tab")  # it comes right after the picture
    for key, share in (
        ("ArrowRight", 27),
        ("PageUp", 37),
        ("End", 100),
        ("Home", 0),
        ("ArrowLeft", 0),
    ):
        tab.page.keyboard.press(key)
        assert handle.get_attribute("aria-valuenow") == str(share)
        assert handle.get_attribute("aria-valuetext").startswith(f"{share} % scene")
    torch.testing.assert_close(seen(tab, 64, 48)[0].viewmat, before.viewmat)


def test_both_sides_follow_one_camera(tab: Tab, served: Any) -> None:
    # the same scene on both sides has to look the same wherever it is cut
    assert visit(tab, served("scene.mgs", MGS), "compare=/scene") == "loaded"
    handle = tab.page.get_by_role("slider")
    handle.wait_for(timeout=20_000)
    still(tab)
    before = look(tab)
    tab.page.mouse.move(200, 200)
    tab.page.mouse.down()
    tab.page.mouse.move(320, 230, steps=4)
    tab.page.mouse.up()
    pictures = []
    for key in ("Home", "End"):
        handle.press(key)
        still(tab)
        pictures.append(look(tab)[:, 60:-60].astype(int))
    assert np.abs(pictures[0] - before[:, 60:-60]).mean() > 5
    assert np.abs(pictures[0] - pictures[1]).mean() < 0.5


def test_cameras_of_the_second_scene_are_used_if_the_first_has_none(
    tab: Tab, served: Any, plain: Path
) -> None:
    offer(tab, "other.mgs", MGS)
    visit(tab, served("scene.ply", plain.read_bytes()), "compare=/other.mgs")
    trained = decode_mgs(MGS).views[0]
    camera, _ = seen(tab, 64, 48)
    torch.testing.assert_close(camera.position, trained.position, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("renderer", RENDERERS)
def test_one_scene_is_compared_with_itself_sorted(tab: Tab, served: Any, renderer: str) -> None:
    said = visit(tab, served("scene.mgs", MGS), "compare=sorted", f"renderer={renderer}")
    assert said == "loaded"
    handle = tab.page.get_by_role("slider")
    handle.wait_for(timeout=20_000)
    assert handle.inner_text().split("\n") == ["scene", "scene, sorted"]
    # from another side too, where the far ones are others
    tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.orbit(0.7, 0)")
    tab.page.evaluate("document.querySelector('mobile-gs').viewer.redraw()")
    scene = decode_mgs(MGS).decode()
    assert scene.lobes is not None
    trained = scene.lobes

    def draw(camera: Camera) -> torch.Tensor:
        some = scene.gaussians
        opacities, _ = evaluate_lobes(trained, normalize(some.means - camera.position, dim=1))
        shapes = (some.means, some.quats, some.scales)
        options = {"camera": camera, "background": scene.background}
        return render_sorted(*shapes, opacities, some.sh, **options).image

    decibels = nearness(tab, draw, 1)
    print(f"{renderer}: {decibels:.1f} dB")
    assert decibels > 45
    (_, free), (_, ordered) = (seen(tab, 160, 120, side) for side in (0, 1))
    assert psnr(free, ordered) < 35  # it was not trained for that


@pytest.mark.parametrize(
    ("content", "sentence"),
    [(MGS[: len(MGS) // 2], "cut off|ends|truncated"), (None, "404")],
    ids=["truncated", "missing"],
)
def test_a_bad_second_scene_shows_an_error_and_keeps_the_first(
    tab: Tab, served: Any, content: bytes | None, sentence: str
) -> None:
    if content is not None:
        offer(tab, "other.mgs", content)
    said = visit(tab, served("scene.mgs", MGS), "compare=/other.mgs")
    if said == "loaded":  # the message was a moment later
        said = tab.page.get_by_role("alert").inner_text()
    assert "other.mgs" in said and any(part in said for part in sentence.split("|"))
    tab.page.wait_for_function("document.querySelector('mobile-gs').viewer.count > 0")
    tab.page.keyboard.press("Escape")
    assert not tab.page.get_by_role("alert").is_visible()
    scene = decode_mgs(MGS).decode()
    assert nearness(tab, lambda camera: scene.render(camera).image) > 45
    assert look(tab).std() > 10
    tab.ignore("status of 404")


def test_a_bad_file_keeps_the_comparison_with_sorted(tab: Tab, served: Any) -> None:
    assert visit(tab, served("scene.mgs", MGS), "compare=sorted") == "loaded"
    handle = tab.page.get_by_role("slider")
    handle.wait_for(timeout=20_000)
    open_file = """([text, name]) => document.querySelector("mobile-gs").open(
      new File([Uint8Array.from(atob(text), (one) => one.charCodeAt(0))], name))"""
    tab.page.evaluate(open_file, [base64.b64encode(b"no scene").decode(), "photo.jpg"])
    alert = tab.page.get_by_role("alert")
    alert.wait_for(timeout=20_000)
    assert alert.inner_text().count("photo.jpg") == 1 and ";" not in alert.inner_text()
    assert handle.is_visible() and handle.inner_text().split("\n") == ["scene", "scene, sorted"]
    assert not tab.page.get_by_role("button", name="Open a file").is_visible()
    tab.page.keyboard.press("Escape")
    tab.page.evaluate(open_file, [base64.b64encode(MGS).decode(), "other.mgs"])
    names = """() => [...document.querySelector("mobile-gs").shadowRoot
      .querySelectorAll(".split span")].map((one) => one.textContent).join()"""
    tab.page.wait_for_function(f"({names})() === 'other.mgs,other.mgs, sorted'", timeout=30_000)
    handle.wait_for(timeout=20_000)


def test_a_comparison_can_be_ended_and_restarted(tab: Tab, served: Any, plain: Path) -> None:
    both(tab, served, plain)
    tab.page.evaluate("document.querySelector('mobile-gs').removeAttribute('compare')")
    handle = tab.page.get_by_role("slider")
    assert not handle.is_visible()
    canvases = tab.page.locator("mobile-gs canvas")
    assert canvases.count() == 1
    tab.page.evaluate(OPEN, {"compare": "/plain.ply?again"})
    handle.wait_for(timeout=20_000)
    assert canvases.count() == 2
    tab.page.evaluate(OPEN, {"compare": "/scene"})
    tab.page.wait_for_function(SETTLED, timeout=20_000)
    handle.wait_for(timeout=20_000)
    assert canvases.count() == 2 and handle.inner_text().split() == ["scene"] * 2
    # names of files are no HTML
    name = "<img src=x onerror=alert(1)>.mgs"
    tab.page.evaluate(
        """([bytes, name]) => document.querySelector("mobile-gs").compareWith(
          new File([Uint8Array.from(bytes)], name))""",
        [list(MGS), name],
    )
    handle.get_by_text(name).wait_for()
    assert handle.locator("img").count() == 0


def test_a_saved_picture_has_both_sides(chromium: Chromium, served: Any, plain: Path) -> None:
    tab = chromium.tab(device_pixel_ratio=1)
    both(tab, served, plain)
    tab.page.get_by_role("slider").press("PageDown")
    still(tab)
    with tab.page.expect_download() as saved:
        tab.page.keyboard.press("p")
    from PIL import Image

    picture = np.array(Image.open(saved.value.path()).convert("RGB")).astype(int)
    shown = still(tab).astype(int)
    assert picture.shape == shown.shape
    for part in (slice(60, 200), slice(320, 600)):  # left and right of the handle
        assert np.abs(picture[60:300, part] - shown[60:300, part]).mean() < 1
    tab.close()
