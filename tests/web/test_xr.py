"""Sessions of WebXR in the viewer, in an emulated headset."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.evaluate.metrics import psnr
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.render import Rendered
from mobilegs.render.scene import Scene
from mobilegs.viewpoints.framing import Framing, Start
from tests.support.browser import Chromium, Tab
from tests.support.scene_cases import Case, make_scene
from tests.support.viewer_page import MGS, still, until, visit
from tests.support.xr_page import (
    RECORD,
    Eye,
    act,
    enter,
    eye_camera,
    leave,
    look,
    page_state,
    visitor,
    xr_frames,
    xr_tab,
)

pytestmark = pytest.mark.thorough

UP = np.array([0.0, -1.0, 0.0])
EYE = np.array([0.3, -0.1, -2.2])
START = Start(EYE, np.array([0.1, 0.2, 0.3]), (0.3, 0.2))
HEIGHT = 0.8  # of the first view's eye above the floor
SCALE = 1.6 / HEIGHT  # metres per unit: the eye is as high as that of someone who takes photos
NOTES = {
    "up": "0 -1 0",
    "floor": f"0 -1 0 {-EYE[1] - HEIGHT:.3f}",
    **Framing(START, None, None).notes,
}
SCENE = encode_mgs(replace(decode_mgs(MGS), meta=NOTES))
IPD = 0.063
NEAR = 0.1  # metres, of the emulated headset
Served = Callable[[str, bytes], Any]


@pytest.fixture
def headset(chromium: Chromium) -> Iterator[Tab]:
    """A tab whose pages have a headset."""
    tab = xr_tab(chromium)
    yield tab
    tab.close()


def level(direction: np.ndarray) -> np.ndarray:
    """The direction without its height."""
    flat = direction - UP * (direction @ UP)
    return flat / np.linalg.norm(flat)


AHEAD = level(START.target - START.eye)
RIGHT = np.cross(-UP, AHEAD)


def rendered(eye: Eye, position: np.ndarray, scene: Scene, scale: float) -> Rendered:
    """The reference's picture for an eye that looks ahead, where a unit is so many metres."""
    camera = eye_camera(eye, position, AHEAD, UP, max(scene.near, NEAR / scale))
    return scene.render(camera)


def standing(eye: Eye, offset: float) -> torch.Tensor:
    """The reference's picture so many metres to the right of the first view."""
    return rendered(eye, EYE + RIGHT * offset / SCALE, decode_mgs(SCENE).decode(), SCALE).image


@pytest.mark.parametrize(("renderer", "by"), [("webgl", "headset"), ("webgpu", "page")])
def test_a_session_draws_both_eyes_and_leaves_the_page_as_it_was(
    headset: Tab, served: Served, renderer: str, by: str
) -> None:
    tab = headset
    assert visit(tab, served("scene.mgs", SCENE), f"renderer={renderer}") == "loaded"
    tab.page.evaluate("window.lenses = { left: { 8: -0.2, 9: 0.1 }, right: { 8: 0.2, 9: 0.1 } }")
    before, picture = page_state(tab), still(tab)[:120].astype(int)  # buttons are below
    enter(tab, "Enter VR")
    references: list[torch.Tensor] = []

    def complete() -> bool:
        """Return True once the scene has loaded again, where the page draws with WebGPU."""
        eye, _ = look(tab)
        references[:] = references or [standing(eye, -IPD / 2)]
        return psnr(eye.image[..., :3], references[0]) > 45

    until(tab, complete)
    for eye, offset in zip(look(tab), (-IPD / 2, IPD / 2), strict=True):
        reference = standing(eye, offset)
        assert reference.std() > 0.05
        own = psnr(eye.image[..., :3], reference)
        other = psnr(eye.image[..., :3], standing(eye, -offset))
        print(f"{renderer}: {own:.1f} dB, as the other eye {other:.1f} dB")
        assert own > 45
        assert other < own - 15
    leave(tab, by)
    assert page_state(tab) == before
    # WebGPU adds up in any order
    assert abs(still(tab)[:120] - picture).max() <= 1
    enter(tab, "Enter VR")
    tab.page.evaluate("document.querySelector('mobile-gs').remove()")
    tab.page.wait_for_function("!headset.activeSession", timeout=20_000)


@pytest.mark.quick
def test_a_point_has_the_parallax_of_its_depth(headset: Tab, served: Served) -> None:
    tab = headset
    one = make_scene(Case(1, size=1))
    where = one.decode().gaussians.means[0].double().numpy()
    depth = 1.5
    start = Start(where - depth * AHEAD, where, (0.3, 0.3))
    meta = (
        NOTES | {"floor": f"0 -1 0 {-start.eye[1] - HEIGHT:.9f}"} | Framing(start, None, None).notes
    )
    scene = encode_mgs(replace(one, meta=meta))
    assert visit(tab, served("scene.mgs", scene), "renderer=webgl") == "loaded"
    enter(tab, "Enter VR")
    eyes = look(tab)
    columns = []
    for eye in eyes:
        light = eye.image[..., 3].double()
        across = torch.arange(light.shape[1]) + 0.5
        columns.append(((light.sum(0) * across).sum() / light.sum()).item())
    expected = eyes[0].lens()[0, 0].item() * IPD / SCALE / depth
    print(f"{columns[0] - columns[1]:.2f} pixels, {expected:.2f} expected")
    assert columns[0] - columns[1] == pytest.approx(expected, rel=0.02)


def test_a_miniature_stands_in_the_room(headset: Tab, served: Served) -> None:
    tab = headset
    slope = 0.6
    start = replace(START, box=(0.7, slope))
    content = encode_mgs(replace(decode_mgs(MGS), meta=NOTES | Framing(start, None, None).notes))
    assert visit(tab, served("scene.mgs", content), "renderer=webgl") == "loaded"
    before = page_state(tab)
    enter(tab, "View in your room")
    radius = slope * float(np.linalg.norm(START.target - START.eye))
    scale = 0.3 / radius
    scene = decode_mgs(SCENE).decode()
    ends = 2 * scene.gaussians.scales.amax(1)
    shown = (scene.gaussians.means - torch.tensor(START.target)).norm(dim=1) + ends < radius
    assert 0 < shown.sum() < len(shown)
    assert scene.lobes is not None
    parts = {name: values[shown] for name, values in scene.gaussians.tensors().items()}
    scene = replace(
        scene,
        gaussians=replace(scene.gaussians, **parts),
        lobes=scene.lobes[shown],
        background=torch.zeros(3),
    )
    for eye, offset in zip(look(tab), (-IPD / 2, IPD / 2), strict=True):
        place = START.target + (offset * RIGHT + 0.35 * UP - 0.8 * AHEAD) / scale
        reference = rendered(eye, place, scene, scale)
        assert 0.1 < reference.alpha.mean() < 0.9
        color = psnr(eye.image[..., :3], reference.image)
        alpha = psnr(
            *(one[..., None].expand(-1, -1, 3) for one in (eye.image[..., 3], reference.alpha))
        )
        print(f"{color:.1f} dB, alpha {alpha:.1f} dB")
        assert color > 45 and alpha > 45
    leave(tab)
    assert page_state(tab) == before


def test_a_miniature_stands_on_a_surface_until_it_is_held(headset: Tab, served: Served) -> None:
    tab = headset
    assert visit(tab, served("scene.mgs", SCENE), "renderer=webgl") == "loaded"
    tab.page.evaluate(RECORD)
    # the emulator finds surfaces in scenes of another package only
    tab.page.evaluate("""() => {
      window.surface = { x: 0.2, y: 0.7, z: -1 };
      XRSession.prototype.requestHitTestSource = async () => ({});
      const pose = () => ({ transform: { position: surface } });
      XRFrame.prototype.getHitTestResults = () => [{ getPose: pose }];
    }""")
    enter(tab, "View in your room")
    scale = 0.3 / (0.2 * float(np.linalg.norm(START.target - START.eye)))
    # the scene's floor lies on the surface
    foot = START.target - UP * (UP @ (START.target - START.eye) + HEIGHT)
    place = foot + (-0.2 * RIGHT + (1.6 - 0.7) * UP - 1 * AHEAD) / scale
    until(tab, lambda: np.abs(visitor(tab).eye - place).max() < 1e-4)
    act(tab, "right.updateButtonValue('trigger', 1)")
    act(tab, "right.updateButtonValue('trigger', 0)")
    tab.page.evaluate("window.surface.y = 0.4")
    assert visitor(tab).eye == pytest.approx(place, abs=1e-4)


def test_sticks_and_hands_move_the_visitor(headset: Tab, served: Served) -> None:
    tab = headset
    tab.page.set_viewport_size({"width": 320, "height": 240})  # for many quick frames
    assert visit(tab, served("scene.mgs", SCENE), "renderer=webgl") == "loaded"
    tab.page.evaluate(RECORD)
    enter(tab, "Enter VR")
    first = visitor(tab)
    assert first.eye == pytest.approx(EYE, abs=1e-5)
    assert first.forward == pytest.approx(AHEAD, abs=1e-5)
    assert first.apart == pytest.approx(IPD / SCALE, rel=1e-3)

    # a push of the right stick turns once, by 30 degrees
    act(tab, "right.updateAxes('thumbstick', 1, 0)")
    turned = visitor(tab)
    assert turned.eye == pytest.approx(EYE, abs=1e-5)
    angle = np.radians(30)
    ahead = np.cos(angle) * AHEAD + np.sin(angle) * RIGHT
    assert turned.forward == pytest.approx(ahead, abs=1e-5)
    act(tab, "right.updateAxes('thumbstick', 0, 0)")

    # the left one walks where the visitor looks
    act(tab, "left.updateAxes('thumbstick', 0, -1)")
    xr_frames(tab, 3)
    act(tab, "left.updateAxes('thumbstick', 0, 0)")
    walked = visitor(tab)
    way = walked.eye - turned.eye
    assert np.linalg.norm(way) > 0.02
    assert way / np.linalg.norm(way) == pytest.approx(ahead, abs=1e-4)

    # a hand holds the scene
    act(tab, "right.updateButtonValue('trigger', 1)")
    act(tab, "right.position.x += 0.3; right.position.y += 0.1")
    act(tab, "right.updateButtonValue('trigger', 0)")
    act(tab, "right.position.x -= 0.3; right.position.y -= 0.1")
    dragged = visitor(tab)
    beside = np.cross(-UP, ahead)
    expected = walked.eye - (0.3 * beside + 0.1 * UP) / SCALE
    assert dragged.eye == pytest.approx(expected, abs=1e-4)

    # two hands enlarge it and turn it
    act(tab, "left.position.set(-0.2, 1, -0.5); right.position.set(0.2, 1, -0.5)")
    act(tab, "left.updateButtonValue('squeeze', 1); right.updateButtonValue('squeeze', 1)")
    act(tab, "left.position.set(0, 1, -0.1); right.position.set(0, 1, -0.9)")
    act(tab, "left.updateButtonValue('squeeze', 0); right.updateButtonValue('squeeze', 0)")
    large = visitor(tab)
    # a controller is held a little beside the point that it has
    assert large.apart == pytest.approx(dragged.apart / 2, rel=0.04)
    assert large.forward == pytest.approx(beside, abs=0.04)

    # a pressed stick leads back
    act(tab, "left.updateButtonValue('thumbstick', 1)")
    act(tab, "left.updateButtonValue('thumbstick', 0)")
    back = visitor(tab)
    assert back.eye == pytest.approx(EYE, abs=1e-5)
    assert back.apart == pytest.approx(first.apart)

    # fingers pinch
    act(tab, "headset.primaryInputMode = 'hand'")
    act(tab, "headset.hands.left.updatePinchValue(1)")
    act(tab, "headset.hands.left.position.z -= 0.2")
    act(tab, "headset.hands.left.updatePinchValue(0)")
    assert visitor(tab).eye == pytest.approx(EYE - 0.2 * AHEAD / SCALE, abs=1e-4)


def test_a_hidden_session_rests_and_a_phone_has_one_view(headset: Tab, served: Served) -> None:
    tab = headset
    assert visit(tab, served("scene.mgs", SCENE), "renderer=webgl") == "loaded"
    tab.page.evaluate(RECORD)
    enter(tab, "Enter VR")
    tab.page.evaluate("headset.updateVisibilityState('hidden')")
    until(tab, lambda: tab.page.evaluate("headset.visibilityState") == "hidden")
    drawn = tab.page.evaluate("drawn.count")
    xr_frames(tab, 5)
    assert tab.page.evaluate("drawn.count") == drawn
    tab.page.evaluate("headset.updateVisibilityState('visible')")
    until(tab, lambda: tab.page.evaluate("drawn.count") > drawn)
    leave(tab)
    tab.page.evaluate("headset.stereoEnabled = false")
    enter(tab, "Enter VR")
    left, right = look(tab)
    assert tab.page.evaluate("drawn.eyes.length") == 1
    assert left.image[..., 3].max() > 0.5
    assert right.image.shape[1] == 0


@pytest.mark.parametrize("viewports", [True, False])
def test_a_slow_headset_gets_fewer_pixels_and_coarser_levels(
    headset: Tab, served: Served, viewports: bool
) -> None:
    tab = headset
    # without a fixed scale
    tab.page.goto(served("scene.mgs", SCENE).address("127.0.0.1") + "&renderer=webgl")
    loaded = "document.querySelector('mobile-gs').dataset.state === 'loaded'"
    tab.page.wait_for_function(loaded, timeout=60_000)
    tab.page.evaluate(RECORD)
    if not viewports:  # then the framebuffer changes
        tab.page.evaluate("""() => {
          delete XRView.prototype.requestViewportScale;
          window.XRWebGLLayer = class extends XRWebGLLayer {
            constructor(session, context, options) {
              super(session, context, options);
              requested.push(options.framebufferScaleFactor);
            }
          };
        }""")
    enter(tab, "Enter VR")
    # the emulated headset wants 90 frames per second, and each takes twice as long at least
    tab.page.evaluate("""() => {
      const wait = () => {
        const end = performance.now() + 25;
        while (performance.now() < end);
        headset.activeSession?.requestAnimationFrame(wait);
      };
      wait();
    }""")
    until(tab, lambda: tab.page.evaluate("requested.at(-1) < 0.5"))
    assert tab.page.evaluate("drawn.coarseness") == 0.6
    assert tab.page.evaluate("requested[0]") == 0.7


def test_a_scene_that_needs_webgpu_says_so(headset: Tab, served: Served) -> None:
    tab = headset
    scene = encode_mgs(make_scene(Case(50, network=True, size=30)))
    assert visit(tab, served("scene.mgs", scene), "renderer=webgpu") == "loaded"
    tab.page.get_by_role("button", name="Enter VR").click()
    tab.page.get_by_text("takes WebGPU").wait_for(timeout=20_000)
    tab.page.wait_for_function("!document.querySelector('mobile-gs').viewer.session")


def test_a_device_without_sessions_has_no_buttons(tab: Tab, served: Served) -> None:
    assert visit(tab, served("scene.mgs", MGS)) == "loaded"
    assert not tab.page.get_by_role("button", name="Enter VR").is_visible()
    assert not tab.page.get_by_role("button", name="View in your room").is_visible()
    fetched = "performance.getEntriesByType('resource').some(({ name }) => name.includes('xr.js'))"
    assert not tab.page.evaluate(fetched)
