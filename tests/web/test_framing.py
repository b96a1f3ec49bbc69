"""First views and limits of the camera in the page."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.up import unit
from mobilegs.view.poster import posters_of
from mobilegs.viewpoints.framing import SECTORS, Framing, Limits, Start, azimuth_of, direction_of
from mobilegs.viewpoints.pose import Pose
from tests.support.browser import Chromium, Tab
from tests.support.viewer_page import MGS, frames, screen, until, visit

pytestmark = pytest.mark.thorough

UP = np.array([0.0, -1.0, 0.0])
PIVOT = np.array([0.1, 0.2, 0.3])
ELEVATIONS = np.tile([90.0, -90.0], (SECTORS, 1))
ELEVATIONS[2:7] = -10, 40
LIMITS = Limits(PIVOT, 0.5, 1.0, 4.0, ELEVATIONS)
WIDE = Start(PIVOT + 3 * direction_of(60.0, 10.0, UP), PIVOT, (0.3, 0.2))
HIGH = Start(PIVOT + 3.5 * direction_of(80.0, 20.0, UP), PIVOT, (0.2, 0.2))
FRAMED = encode_mgs(
    replace(
        decode_mgs(MGS),
        meta={"up": "0 -1 0", **Framing(WIDE, HIGH, LIMITS).notes, "title": "Framed"},
    )
)


def place(tab: Tab) -> tuple[float, float, float]:
    """Azimuth, elevation and distance of the camera, as seen from its target."""
    eye, target = tab.page.evaluate(
        "(({ eye, target }) => [eye, target])(document.querySelector('mobile-gs').viewer.pose)"
    )
    away = np.array(eye) - np.array(target)
    return *azimuth_of(unit(away), UP), float(np.linalg.norm(away))


def focal(tab: Tab, width: int, height: int) -> float:
    """The focal length, in pixels, of a picture of this size."""
    size = [width, height]
    return tab.page.evaluate(
        "(size) => document.querySelector('mobile-gs').viewer.camera(...size).fx", size
    )


def drag(tab: Tab, across: int, down: int) -> None:
    """Drag over the scene; the button stays down."""
    tab.page.mouse.move(150, 200)
    tab.page.mouse.down()
    tab.page.mouse.move(150 + across, 200 + down, steps=12)


@pytest.mark.quick
def test_the_first_view_is_the_noted_one(tab: Tab, served: Callable[[str, bytes], Any]) -> None:
    assert visit(tab, served("scene.mgs", FRAMED), "renderer=webgl") == "loaded"
    assert place(tab) == pytest.approx((60, 10, 3), abs=1e-3)
    assert focal(tab, 600, 300) == pytest.approx(300 / 0.4)  # the height decides
    assert focal(tab, 300, 300) == pytest.approx(300 / 0.6)
    # a phone that is turned shows another view, until somebody has moved
    tab.page.set_viewport_size({"width": 300, "height": 600})
    frames(tab, 5)
    assert place(tab) == pytest.approx((80, 20, 3.5), abs=1e-3)
    drag(tab, 20, 0)
    tab.page.mouse.up()
    moved = place(tab)
    tab.page.set_viewport_size({"width": 600, "height": 300})
    frames(tab, 5)
    assert place(tab) == pytest.approx(moved, abs=1e-3)
    tab.page.keyboard.press("r")
    assert place(tab) == pytest.approx((60, 10, 3), abs=1e-3)


def test_attributes_replace_notes_on_high_screens_too(
    tab: Tab, served: Callable[[str, bytes], Any]
) -> None:
    tab.page.set_viewport_size({"width": 300, "height": 600})
    other = Start(WIDE.eye + 1, WIDE.target, WIDE.box)
    wish = f"start={other.text.replace(' ', '+')}"
    assert visit(tab, served("scene.mgs", FRAMED), "renderer=webgl", wish) == "loaded"
    eye = tab.page.evaluate("document.querySelector('mobile-gs').viewer.pose.eye")
    assert eye == pytest.approx(other.eye.tolist(), abs=1e-4)


def test_the_camera_stays_inside_its_limits(tab: Tab, served: Callable[[str, bytes], Any]) -> None:
    assert visit(tab, served("scene.mgs", FRAMED), "renderer=webgl") == "loaded"
    for across, down in ((500, 0), (-900, 0), (0, 400), (0, -400)):
        drag(tab, across, down)
        azimuth, elevation, _ = place(tab)  # it gives way
        assert 15 < azimuth < 120 and -25 < elevation < 55
        tab.page.mouse.up()

        def inside() -> bool:
            azimuth, elevation, _ = place(tab)
            return 29.9 < azimuth < 105.1 and -10.1 < elevation < 40.1

        until(tab, inside)  # it springs back
    tab.page.mouse.move(150, 200)
    for amount, expected in ((4000, 4.0), (-8000, 1.0)):
        for _ in range(6):
            tab.page.mouse.wheel(0, amount / 6)
        until(tab, lambda e=expected: place(tab)[2] == pytest.approx(e, rel=0.02))
    # the same, where an address asks for no limits
    assert visit(tab, served("free.mgs", FRAMED), "renderer=webgl", "free") == "loaded"
    drag(tab, 600, 0)
    tab.page.mouse.up()
    tab.page.wait_for_timeout(500)
    assert not 20 < place(tab)[0] < 115


def test_it_rotates_back_at_a_limit(tab: Tab, served: Callable[[str, bytes], Any]) -> None:
    assert visit(tab, served("scene.mgs", FRAMED), "renderer=webgl", "autorotate") == "loaded"
    found = [place(tab)[0]]

    def turned_back() -> bool:
        tab.page.wait_for_timeout(200)
        found.append(place(tab)[0])
        steps = np.diff(found)
        return steps.min() < 0 < steps.max()

    until(tab, turned_back, seconds=60)
    assert min(found) > 20 and max(found) < 115


def test_a_poster_is_replaced_by_the_same_picture(
    chromium: Chromium, tmp_path: Path, served: Callable[[str, bytes], Any]
) -> None:
    coded = decode_mgs(MGS)
    first, second = (
        Start(pose.eye, pose.target, box)
        for pose, box in (
            (Pose.from_views(coded.views, 0), (0.3, 0.25)),
            (Pose.from_views(coded.views, 1), (0.25, 0.3)),
        )
    )
    framed = encode_mgs(replace(coded, meta=Framing(first, second).notes))
    (tmp_path / "framed.mgs").write_bytes(framed)
    posters = posters_of(tmp_path / "framed.mgs")
    assert "orientation: portrait" in posters.style and len(posters.style) < 60_000
    tab = chromium.tab(1)
    for width, height in ((500, 300), (300, 500)):
        tab.page.set_viewport_size({"width": width, "height": height})
        tab.page.goto(f"{tab.address}/blank.html")
        tab.page.evaluate(
            """(style) => {
              document.head.innerHTML += `<style>${style}
                mobile-gs { position: fixed; inset: 0; }</style>`;
              document.body.innerHTML = "<mobile-gs></mobile-gs>";
            }""",
            posters.style,
        )
        tab.page.wait_for_timeout(300)
        poster = screen(tab).astype(float)
        server = served(f"framed{width}.mgs", framed)
        assert visit(tab, server, "renderer=webgl", "noui") == "loaded"
        tab.page.wait_for_timeout(800)
        scene = screen(tab).astype(float)
        error = np.abs(poster - scene).mean()
        shifted = np.abs(np.roll(poster, 8, axis=1) - scene).mean()
        assert scene.std() > 15 and error < 12 and error < 0.7 * shifted
    tab.close()
