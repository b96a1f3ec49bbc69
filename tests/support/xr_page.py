"""A headset in a page, emulated by the package iwer: enter, look through both eyes, use hands."""

from base64 import b64decode
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from tests.support.browser import VIEWER, Chromium, Tab
from tests.support.viewer_page import still

IWER = VIEWER / "node_modules" / "iwer" / "build" / "iwer.min.js"
# a real headset has a framebuffer of its own, with alpha; the emulated one shows a canvas
INSTALL = """
{
  const { getContext } = HTMLCanvasElement.prototype;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return getContext.call(this, kind, kind === "webgl2" ? { ...options, alpha: true } : options);
  };
  window.headset = new IWER.XRDevice(IWER.metaQuest3, { stereoEnabled: true, fovy: 1.2 });
  headset.installRuntime({ forceInstall: true });
  headset.position.set(0, 1.6, 0);
  window.lenses = {};  // of projections: entries that replace those of the emulator, by eye
  const { get } = Object.getOwnPropertyDescriptor(XRView.prototype, "projectionMatrix");
  Object.defineProperty(XRView.prototype, "projectionMatrix", { get() {
    const own = get.call(this).slice();
    for (const [i, value] of Object.entries(lenses[this.eye] ?? {})) own[i] = value;
    return own;
  } });
  window.requested = [];  // scales of viewports
  XRView.prototype.requestViewportScale = (scale) => requested.push(scale);
}
"""
# the emulator returns a canvas to its parent element, which the root of a shadow tree is not
WRAP = """() => {
  const canvas = document.querySelector("mobile-gs").shadowRoot.querySelector("canvas");
  if (canvas.parentElement) return;
  const around = document.createElement("div");
  around.style.display = "contents";
  canvas.replaceWith(around);
  around.append(canvas);
}"""
# what a frame showed: the viewer's own callback comes before this one
LOOK = """async () => {
  const session = headset.activeSession;
  const space = await session.requestReferenceSpace("local-floor");
  return new Promise((resolve) => session.requestAnimationFrame((_, frame) => {
    const layer = session.renderState.baseLayer;
    const gl = layer.context;
    resolve(frame.getViewerPose(space).views.map((view) => {
      const { x, y, width, height } = layer.getViewport(view);
      const bytes = new Uint8Array(4 * width * height);
      gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
      gl.readPixels(x, y, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
      const text = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
      return {
        width, height, pixels: btoa(text),
        projection: Array.from(view.projectionMatrix),
      };
    }));
  }));
}"""


# keeps what is drawn in `drawn`, and counts it
RECORD = """async () => {
  const { viewer } = document.querySelector("mobile-gs");
  const { sceneView } = await viewer.webglView();
  const { drawEyes } = sceneView;
  window.drawn = { count: 0, eyes: [], coarseness: 1 };
  sceneView.drawEyes = function (eyes, coarseness, crop) {
    const matrices = eyes.map(({ camera }) => Array.from(camera.viewmat));
    window.drawn = { count: drawn.count + 1, eyes: matrices, coarseness };
    drawEyes.call(this, eyes, coarseness, crop);
  };
}"""
FRAMES = """async (count) => {
  const session = headset.activeSession;
  while (count--) await new Promise((resolve) => session.requestAnimationFrame(resolve));
}"""


class Eye(NamedTuple):
    """The picture of one eye, and its projection."""

    projection: np.ndarray
    """Row by row: x right, y up, z back."""
    image: torch.Tensor
    """[height, width, 4], in [0, 1]."""

    def lens(self) -> torch.Tensor:
        """The intrinsics of the projection, from where it takes three directions."""
        height, width, _ = self.image.shape

        def pixel(x: float, y: float) -> np.ndarray:
            """The place of a point at depth 1, x to the right and y downwards."""
            clip = self.projection @ np.array([x, -y, -1, 1])
            ndc = clip[:2] / clip[3]
            return np.array([(ndc[0] + 1) / 2 * width, (1 - ndc[1]) / 2 * height])

        center, right, down = pixel(0, 0), pixel(1, 0), pixel(0, 1)
        columns = [[*(right - center), 0], [*(down - center), 0], [*center, 1]]
        return torch.tensor(np.array(columns).T, dtype=torch.float32)


class Visitor(NamedTuple):
    """A visitor of the scene, in its units."""

    eye: np.ndarray
    """The middle of both eyes."""
    forward: np.ndarray
    apart: float
    """From one eye to the other."""


def xr_tab(chromium: Chromium) -> Tab:
    """Open a blank tab whose pages have a headset."""
    if not IWER.exists():
        pytest.skip("needs the viewer's tools (npm ci in viewer/)")
    tab = chromium.tab(0.5)
    tab.page.add_init_script(Path(IWER).read_text() + INSTALL)
    # the emulator clears whichever framebuffer is bound
    tab.ignore("No defined conversion between clear value")
    return tab


def enter(tab: Tab, name: str) -> None:
    """Press a button of the viewer, and wait until the session draws."""
    tab.page.evaluate(WRAP)
    tab.page.get_by_role("button", name=name).click()
    tab.page.wait_for_function("headset.activeSession?.renderState.baseLayer", timeout=20_000)


def leave(tab: Tab, by: str = "headset") -> None:
    """End the session, as the headset's own button does, or as the button in the page."""
    if by == "headset":
        tab.page.evaluate("headset.activeSession.end()")
    else:  # the emulated headset covers the page
        tab.page.evaluate("document.querySelector('mobile-gs').act('vr')")
    tab.page.wait_for_function(
        "!document.querySelector('mobile-gs').viewer.session", timeout=20_000
    )


def look(tab: Tab) -> list[Eye]:
    """Return what the left and the right eye see in the next frame."""
    return [
        Eye(
            np.array(found["projection"]).reshape(4, 4).T,
            torch.from_numpy(
                np.frombuffer(b64decode(found["pixels"]), np.uint8)
                .reshape(found["height"], found["width"], 4)[::-1]
                .astype(np.float32)
                / 255
            ),
        )
        for found in tab.page.evaluate(LOOK)
    ]


def xr_frames(tab: Tab, count: int = 2) -> None:
    """Wait until the session has shown some frames."""
    tab.page.evaluate(FRAMES, count)


def visitor(tab: Tab) -> Visitor:
    """The visitor's place after the next frames; the page must have run `RECORD`."""
    xr_frames(tab)
    eyes = np.array(tab.page.evaluate("drawn.eyes")).reshape(2, 4, 4)
    left, right = (-eye[:3, :3].T @ eye[:3, 3] for eye in eyes)
    return Visitor((left + right) / 2, eyes[0][2, :3], float(np.linalg.norm(right - left)))


def act(tab: Tab, code: str) -> None:
    """Move the emulated devices: `headset`, `left` and `right` (controllers) are at hand."""
    tab.page.evaluate(
        f"() => {{ const {{ left, right }} = headset.controllers; {code} }}",
    )
    xr_frames(tab)


def eye_camera(
    eye: Eye, position: np.ndarray, forward: np.ndarray, up: np.ndarray, near: float
) -> Camera:
    """A camera of the scene with the lens of an eye; `forward` and `up` are perpendicular."""
    down = -up
    right = np.cross(down, forward)
    rotation = np.stack([right, down, forward])
    viewmat = np.eye(4)
    viewmat[:3, :3] = rotation
    viewmat[:3, 3] = -rotation @ position
    height, width, _ = eye.image.shape
    return Camera(torch.tensor(viewmat, dtype=torch.float32), eye.lens(), width, height, near)


def page_state(tab: Tab) -> Any:
    """The state that a session must leave as it was: camera, canvas, background."""
    still(tab)
    return tab.page.evaluate("""() => {
      const { viewer, shadowRoot } = document.querySelector("mobile-gs");
      const canvas = shadowRoot.querySelector("canvas");
      const { eye, target, up } = viewer.pose;
      const { x, y, width, height } = canvas.getBoundingClientRect();
      const sizes = [canvas.width, canvas.height, x, y, width, height];
      return [eye, target, up, ...sizes, viewer.background, viewer.mode];
    }""")
