"""The viewer's page in Chromium: open it, read its camera and pixels, wait for conditions."""

import threading
import time
from base64 import b64decode
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.evaluate.metrics import psnr
from mobilegs.mgs.codec import encode_mgs
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.representation.lobes import LobeShape
from mobilegs.view.serve import Handler, Server
from tests.support.browser import Tab
from tests.support.scene_cases import Case, make_scene

RENDERERS = ["webgpu", "webgl"]
# nothing inline, and no text becomes HTML or a script's address but by a policy of that name
STRICT = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; "
    "connect-src 'self'; img-src 'self' data:; worker-src blob:; "
    "require-trusted-types-for 'script'; trusted-types mobilegs"
)
MGS = encode_mgs(make_scene(Case(800, LobeShape(2, 12, (64,)), size=300)))
# "loaded", or the message that the viewer shows; null before that
SETTLED = """() => {
  const element = document.querySelector("mobile-gs");
  const message = element?.shadowRoot.querySelector(".message");
  if (message && !message.hidden) return message.querySelector("p").textContent;
  return element?.getAttribute("data-state") === "loaded" ? "loaded" : null;
}"""
SHOWN = "document.querySelector('mobile-gs').viewer?.count"
# whether the renderer has Gaussians and not only dots
HAS_GAUSSIANS = """async () => {
  const { viewer } = document.querySelector("mobile-gs");
  return Boolean(await viewer.pixels(viewer.camera(9, 9)).catch(() => null));
}"""
LOD_SIZES = (150, 1, 649)
SMALL = {"width": 320, "height": 240}
# records the addresses that workers are asked to load; counts adapters
COUNT_WORKERS = """{
  window.begun = [];
  window.adapters = 0;
  const Own = Worker;
  window.Worker = class extends Own {
    postMessage(message, options) {
      super.postMessage(message, options);
      begun.push(message.url);
    }
  };
  const { requestAdapter } = GPU.prototype;
  GPU.prototype.requestAdapter = function (...given) {
    window.adapters++;
    return requestAdapter.apply(this, given);
  };
}"""


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Callable[[str, bytes], Server]]:
    """A function that serves a file of the given name and bytes."""
    servers = []

    def start(name: str, content: bytes) -> Server:
        (tmp_path / name).write_bytes(content)
        server = Server(tmp_path / name)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        servers.append(server)
        return server

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


def visit(tab: Tab, server: Server, *wishes: str) -> str:
    """Open the viewer and wait; return `loaded` or the message that it shows instead."""
    tab.page.goto("&".join([server.address("127.0.0.1"), "scale=1", "variant=floats", *wishes]))
    return tab.page.wait_for_function(SETTLED, timeout=60_000).json_value()


def seen(tab: Tab, width: int, height: int, side: int = 0) -> tuple[Camera, torch.Tensor]:
    """Return the viewer's camera at the given size, and what the renderer draws with it."""
    found = tab.page.evaluate(
        """async ([width, height, side]) => {
          const { viewer } = document.querySelector("mobile-gs");
          const camera = viewer.camera(width, height);
          const bytes = new Uint8Array(Float32Array.from(await viewer.pixels(camera, side)).buffer);
          // as text: playwright takes a second to check a list of numbers
          const text = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
          return { ...camera, pixels: btoa(text) };
        }""",
        [width, height, side],
    )
    k = [[found["fx"], 0, found["cx"]], [0, found["fy"], found["cy"]], [0, 0, 1]]
    viewmat = torch.tensor(found["viewmat"]).reshape(4, 4)
    camera = Camera(viewmat, torch.tensor(k), width, height, found["near"])
    pixels = np.frombuffer(b64decode(found["pixels"]), np.float32).reshape(height, width, 4)
    return camera, torch.from_numpy(pixels[..., :3].copy())


def nearness(
    tab: Tab, draw: Callable[[Camera], torch.Tensor], side: int = 0, *, enough: float = 45
) -> float:
    """Return the PSNR between the viewer's image and the image that `draw` renders.

    Waits up to 20 s until it exceeds `enough`: sorted scenes get their order from a worker.
    """
    end = time.monotonic() + 20
    while True:
        camera, pixels = seen(tab, 160, 120, side)
        expected = draw(camera)
        assert expected.std() > 0.05
        decibels = psnr(pixels, expected)
        if decibels > enough or time.monotonic() > end:
            return decibels
        frames(tab, 5)


def screen(tab: Tab) -> np.ndarray:
    """Return a screenshot, uint8 [height, width, 3]."""
    from io import BytesIO

    from PIL import Image

    return np.array(Image.open(BytesIO(tab.page.screenshot())).convert("RGB"))


def frames(tab: Tab, count: int) -> None:
    """Wait for animation frames: what is still to happen at once has happened then."""
    tab.page.evaluate(
        """async (count) => {
          while (count--) await new Promise((resolve) => requestAnimationFrame(resolve));
        }""",
        count,
    )


def until(tab: Tab, condition: Callable[[], bool], seconds: float = 20) -> None:
    """Wait until a condition holds; an AssertionError if it does not in time."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "the condition did not become true"
        frames(tab, 2)


def still(tab: Tab) -> np.ndarray:
    """Wait until two screenshots some frames apart are equal, and return the last one."""
    pictures = [screen(tab)]

    def same() -> bool:
        frames(tab, 10)
        pictures.append(screen(tab))
        return bool((pictures[-1] == pictures[-2]).all())

    until(tab, same)
    return pictures[-1]


def pose_moved(tab: Tab, eye: torch.Tensor) -> None:
    """Wait until the camera is farther than 1e-3 from a position."""
    moved = """([x, y, z]) => {
      const { eye } = document.querySelector("mobile-gs").viewer.pose;
      return Math.hypot(eye[0] - x, eye[1] - y, eye[2] - z) > 1e-3;
    }"""
    tab.page.wait_for_function(moved, arg=eye.tolist(), timeout=20_000)


def leveled_scene(*, sorted: bool = False) -> QuantizedScene:
    """Return a scene with the LOD levels of `LOD_SIZES`."""
    shape = None if sorted else LobeShape(2, 12, (64,))
    scene = replace(make_scene(Case(sum(LOD_SIZES), shape, size=300)), lod_sizes=LOD_SIZES)
    return replace(scene, blend="sorted") if sorted else scene


class Gate:
    """Makes the server send a scene only up to a byte that the test sets."""

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
        """Allow the bytes before `end`."""
        with self._open:
            self._end = end
            self._open.notify_all()


def open_page(tab: Tab, server: Any, renderer: str) -> None:
    """Open the viewer without waiting for its scene."""
    wishes = f"scale=1&variant=floats&renderer={renderer}"
    tab.page.set_viewport_size(SMALL)
    tab.page.goto(f"{server.address('127.0.0.1')}&{wishes}")
