"""`MobileGSMesh` in sessions of WebXR that three.js runs, in an emulated headset."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch

from mobilegs.evaluate.metrics import psnr
from mobilegs.mgs.codec import decode_mgs
from mobilegs.render import Rendered
from tests.support.browser import Chromium
from tests.support.three_page import ThreePage
from tests.support.viewer_page import MGS
from tests.support.xr_page import Eye, eye_camera, look, xr_tab

pytestmark = pytest.mark.thorough

IPD = 0.15  # metres: a difference that soft Gaussians show
SCALE = 2.0  # metres per unit
EYE = np.array([0.3, -0.1, -2.2])  # of the scene, where the visitor stands
AHEAD, UP, RIGHT = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0])
PLACE = """
const { renderer, scene, THREE, load } = three;
document.body.append(renderer.domElement);
renderer.setSize(320, 200);
renderer.xr.enabled = true;
const mesh = await load(url);
mesh.rotation.x = Math.PI;  // the scene's y axis points down
mesh.scale.setScalar(scale);
mesh.position.set(-scale * eye[0], 1.6 + scale * eye[1], scale * eye[2]);
"""
ENTER = """
const { renderer, scene, camera } = three;
const session = await navigator.xr.requestSession(mode, { optionalFeatures: ["local-floor"] });
await renderer.xr.setSession(session);
renderer.setAnimationLoop(() => renderer.render(scene, camera));
let frames = 0;
await new Promise((resolve) => {
  const count = () => (++frames > 3 ? resolve() : session.requestAnimationFrame(count));
  session.requestAnimationFrame(count);
});
"""
LEAVE = """
await headset.activeSession.end();
three.renderer.setAnimationLoop(null);
"""


@pytest.fixture
def page(chromium: Chromium) -> Iterator[ThreePage]:
    tab = xr_tab(chromium)
    tab.page.set_viewport_size({"width": 320, "height": 200})
    tab.page.goto(f"{tab.address}/blank.html")
    yield ThreePage(tab, "webgl", antialias=False)
    tab.close()


def expected(eye: Eye, offset: float) -> Rendered:
    """The reference's picture for an eye, so many metres to the right."""
    scene = replace(decode_mgs(MGS).decode(), background=torch.zeros(3))
    return scene.render(eye_camera(eye, EYE + RIGHT * offset / SCALE, AHEAD, UP, scene.near))


def test_both_eyes_see_the_scene_again_and_again_and_what_hides_it(page: ThreePage) -> None:
    tab = page.tab
    tab.run(PLACE, url=page.share("scene.mgs", MGS), scale=SCALE, eye=EYE.tolist())
    tab.page.evaluate(f"headset.ipd = {IPD}")
    tab.page.evaluate("window.lenses = { left: { 8: -0.2, 9: 0.1 }, right: { 8: 0.2, 9: 0.1 } }")
    draw = "three.renderer.render(three.scene, three.camera); return three.picture();"
    before = tab.run(draw)
    for mode in ("immersive-vr", "immersive-ar"):
        tab.run(ENTER, mode=mode)
        for eye, offset in zip(look(tab), (-IPD / 2, IPD / 2), strict=True):
            reference = expected(eye, offset)
            assert reference.image.std() > 0.05
            own = psnr(eye.image[..., :3], reference.image)
            other = psnr(eye.image[..., :3], expected(eye, -offset).image)
            print(f"{mode}: {own:.1f} dB, as the other eye {other:.1f} dB")
            assert own > 45
            assert other < own - 12
            if mode == "immersive-ar":  # the room is behind it
                assert (eye.image[..., 3] - reference.alpha).abs().max() < 0.02
        tab.run(LEAVE)
        assert (tab.run(draw) == before).all()

    # a mesh hides what is behind it
    distance, side = 0.4, 0.1
    code = """const { THREE, scene } = three;
    const material = new THREE.MeshBasicMaterial({ color: 0xff0000 });
    const box = new THREE.Mesh(new THREE.BoxGeometry(side, side, 0.001), material);
    box.position.set(0, 1.6, -distance);
    scene.add(box);"""
    tab.run(code, distance=distance, side=side)
    tab.run(ENTER, mode="immersive-vr")
    for eye, offset in zip(look(tab), (-IPD / 2, IPD / 2), strict=True):
        fx, cx, cy = eye.lens()[0, 0].item(), eye.lens()[0, 2].item(), eye.lens()[1, 2].item()
        column, half = cx - fx * offset / distance, 0.4 * fx * side / distance
        rows = slice(round(cy - half), round(cy + half))
        columns = slice(round(column - half), round(column + half))
        inside = eye.image[rows, columns, :3].flatten(0, 1)
        # a few Gaussians are nearer
        assert inside[:, 0].median() > 0.9
        assert inside[:, 1:].median() < 0.1
    # a phone has one view, and the emulator gives the other one no pixels
    tab.page.evaluate("headset.stereoEnabled = false")
    assert [eye.image.shape[1] for eye in look(tab)] == [320, 0]
    tab.run(LEAVE)
