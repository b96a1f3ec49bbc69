"""A scene in a window of its own, moved with the keys and gestures of the web viewer.

`show` opens the window; `Window` works on any of rendercanvas' canvases, also on one without a
display.
"""

import math
import sys
import time
import warnings
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from mobilegs.atomic import atomic_path
from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.view.orbit import COMMAND, Input, Pose, camera_of, place_under
from mobilegs.view.video import open_with_views
from mobilegs.view.wgpu_device import INSTALL
from mobilegs.view.wgpu_renderer import GpuRenderer

SIZE = (1280, 720)  # logical pixels
FPS_MAX = 120
SAME_SIDE = math.cos(math.radians(0.5))  # an order serves all directions as near as that
SECONDS_MAX = 0.1  # of flying in one frame, however long it took
TITLE_EVERY = 0.25  # seconds
LINGER = 0.15  # seconds after an input in which things still count as moving
HELP = """\
  drag                  turn around the scene
  right drag, Shift     move sideways
  wheel                 come nearer, go away
  double click          look at what is there
  arrows                turn
  W A S D Q E           fly; with Shift faster
  M                     orbit, or look around from where you are
  V                     next of the cameras the scene was taken with
  R                     back to the beginning
  F                     full screen
  P                     save a picture
  I                     frame rate, and what each pass takes, in the title
  H                     these keys
  Esc, Ctrl-Q           leave full screen, close"""


def show(path: Path) -> None:
    """Show a scene's file in a window until that is closed.

    Raises InputError where there is no display, no GPU or not the packages for them, or the file
    is not a scene that a GPU draws.
    """
    toolkit = _toolkit()
    scene, views = open_with_views(path, torch.device("cpu"))
    renderer = GpuRenderer(scene)
    canvas = toolkit.RenderCanvas(size=SIZE, title=path.stem, max_fps=FPS_MAX)
    try:
        window = Window(canvas, renderer, views, path.stem)
    except Exception:
        canvas.close()
        raise
    print(f"{path} is shown in a window; keys:\n{HELP}", flush=True)
    try:
        toolkit.loop.run()
    finally:
        window.close()


def _toolkit() -> Any:
    """The module that opens windows; InputError where none can be opened."""
    try:
        import glfw
        from rendercanvas import glfw as toolkit
    except ImportError:
        raise InputError(
            f"a window needs rendercanvas and glfw, which are not installed: {INSTALL}"
        ) from None
    with warnings.catch_warnings():  # it tells by a warning what is missing
        warnings.simplefilter("ignore")
        ready = glfw.init()
    if not ready:
        raise InputError(
            "no window can be opened, since there is no display here: without --native the scene "
            "is shown in a browser, with --lan in one of another machine"
        )
    return toolkit


class Window:
    """A scene on a canvas: draws what changes, follows the input.

    Attributes:
        canvas: rendercanvas' canvas.
        input: what moves the pose, `input.pose` from which the scene is seen.
        timed: whether the title says what a frame takes.
    """

    def __init__(
        self, canvas: Any, renderer: GpuRenderer, views: Sequence[Camera], name: str
    ) -> None:
        """Show what `renderer` draws; `views` are the training cameras, if they are known."""
        self.canvas = canvas
        self.timed = False
        self._renderer, self._views, self._name = renderer, views, name
        scene = renderer.scene
        logits = scene.gaussians.logit_opacities if scene.lobes is None else scene.lobes[:, 0, 0]
        centers = scene.gaussians.means[scene.gaussians.means.isfinite().all(1)]
        self._start = Pose.from_views(views) if views else Pose.around(centers.cpu().numpy())
        self._solid = scene.gaussians.means[logits >= 0].cpu().numpy()  # for a double click
        self.input = Input(self._start.copy())
        self._view = 0
        # of a sorted scene: an order, and the direction of looking that it is for
        self._order: tuple[np.ndarray, np.ndarray] | None = None
        self._coming: Future | None = None  # the next one
        self._sorter = ThreadPoolExecutor(1)
        self._touched = -math.inf  # time of the last input
        self._frame_before: float | None = None  # its time, if things moved then
        self._times: list[float] = []  # milliseconds of frames that followed one another
        self._titled = 0.0
        # place and size of the window, while the screen is full
        self._windowed: tuple[int, int, int, int] | None = None
        device = renderer.program.device
        self._context = canvas.get_context("wgpu")
        # pictures are sRGB as they are: a format that converts would do so twice
        preferred = self._context.get_preferred_format(device.adapter)
        self._format = preferred.removesuffix("-srgb")
        self._context.configure(device=device, format=self._format)
        handlers = {
            "pointer_down": self._press,
            "pointer_up": self.input.release,
            "pointer_move": self._drag,
            "wheel": self._wheel,
            "key_down": lambda event: self._key(event, True),
            "key_up": lambda event: self._key(event, False),
        }
        for kind, handler in handlers.items():
            canvas.add_event_handler(handler, kind)
        self._say_title("")
        canvas.request_draw(self._frame)

    def camera(self, width: int, height: int) -> Camera:
        """The camera of a frame of the given size, in pixels of the screen."""
        view = self._views[0] if self._views else None
        return camera_of(self.input.pose, view, width, height, self._renderer.scene.near)

    def reset(self, index: int | None = None) -> None:
        """Back to where the scene was first seen from, or to a training camera."""
        pose = self._start.copy()
        if index is not None and self._views:
            pose = Pose.from_views(self._views, index % len(self._views))
        self.input.pose = pose

    def close(self) -> None:
        """Close the window, if it is still there."""
        self._sorter.shutdown()
        if not self.canvas.get_closed():
            self.canvas.close()

    def save(self) -> Path:
        """Write what is seen to a new PNG file in the working folder."""
        path, number = Path(f"{self._name}.png"), 1
        while path.exists():
            number += 1
            path = Path(f"{self._name}-{number}.png")
        picture = self._renderer.draw(self.camera(*self.canvas.get_physical_size()))
        with atomic_path(path) as temporary:
            Image.fromarray(to_bytes(picture.image).numpy()).save(temporary, format="PNG")
        return path

    def _frame(self) -> None:
        now = time.perf_counter()
        if self._frame_before is not None:
            seconds = now - self._frame_before
            self._times = [*self._times[-29:], 1000 * seconds]
            self.input.advance(min(seconds, SECONDS_MAX))
        texture = self._context.get_current_texture()
        camera = self.camera(*texture.size[:2])
        order = self._order_for(camera) if self._renderer.program.sorted else None
        self._renderer.draw_into(texture.create_view(), self._format, camera, order=order)
        moving = self.input.busy or now - self._touched < LINGER
        self._frame_before = now if moving else None
        if self.timed and now - self._titled > TITLE_EVERY:
            self._titled = now
            self._say_title(self._figures(camera))
        if self.input.busy:
            self.canvas.request_draw()

    def _order_for(self, camera: Camera) -> np.ndarray:
        """An order for about this direction; the exact one comes with a later frame."""
        forward = self.input.pose.forward
        if self._coming is not None and self._coming.done():
            self._order, self._coming = self._coming.result(), None
        order, direction = self._order or (self._renderer.far_first(camera), forward)
        self._order = order, direction
        if self._coming is None and forward @ direction < SAME_SIDE:
            self._coming = self._sorter.submit(lambda: (self._renderer.far_first(camera), forward))
            self._coming.add_done_callback(lambda _: self.canvas.request_draw())
        return order

    def _figures(self, camera: Camera) -> str:
        passes = self._renderer.program.milliseconds() or {}
        words = [f"{camera.width} x {camera.height}"]
        if self._times:
            mean = sum(self._times) / len(self._times)
            words.append(f"{1000 / mean:.0f} frames/s")
        return ", ".join([*words, *(f"{name} {ms:.2f} ms" for name, ms in passes.items())])

    def _say_title(self, more: str) -> None:
        about = f"{self._name}: {self._renderer.count:,} Gaussians"
        self.canvas.set_title(f"{about}, {more}" if more else about)

    def _press(self, event: dict) -> None:
        if self.input.press(event):
            width, height = self.canvas.get_logical_size()
            camera = self.camera(round(width), round(height))
            place = place_under(self._solid, camera, event["x"], event["y"])
            if place is not None:
                self.input.pose.focus(place)
            self._touch()

    def _drag(self, event: dict) -> None:
        if self.input.drag(event, self.canvas.get_logical_size()[1]):
            self._touch()

    def _wheel(self, event: dict) -> None:
        self.input.wheel(event)
        self._touch()

    def _key(self, event: dict, down: bool) -> None:
        if self.input.key(event, down):
            self._touch()
        elif down:
            key = event["key"].lower()
            if not COMMAND & set(event["modifiers"]):
                self._act(key)
            elif key == "q":
                self.canvas.close()

    def _touch(self) -> None:
        self._touched = time.perf_counter()
        self.canvas.request_draw()

    def _act(self, key: str) -> None:
        """What a key that does not move stands for."""
        if key == "escape":
            if self._windowed is None:
                self.canvas.close()
            else:
                self._full_screen()
        elif key == "r":
            self.reset()
        elif key == "v":
            self._view += 1
            self.reset(self._view)
        elif key == "m":
            self.input.mode = "fly" if self.input.mode == "orbit" else "orbit"
        elif key == "f":
            self._full_screen()
        elif key == "p":
            try:
                print(f"saved {self.save()}", flush=True)
            except (InputError, OSError) as error:
                print(f"the picture could not be saved: {error}", file=sys.stderr)
        elif key == "i":
            self.timed, self._titled = not self.timed, 0.0
            self._say_title("")
        elif key == "h":
            print(HELP, flush=True)
        self.canvas.request_draw()

    def _full_screen(self) -> None:
        """To the whole screen, or back: rendercanvas leaves that to the toolkit below it."""
        window = getattr(self.canvas, "_window", None)
        if window is None:
            return
        import glfw

        with warnings.catch_warnings():  # Wayland tells no window where it is
            warnings.simplefilter("ignore", glfw.GLFWError)
            if self._windowed is None:
                self._windowed = (*glfw.get_window_pos(window), *glfw.get_window_size(window))
                monitor = glfw.get_primary_monitor()
                mode = glfw.get_video_mode(monitor)
                glfw.set_window_monitor(window, monitor, 0, 0, *mode.size, mode.refresh_rate)
            else:
                x, y, width, height = self._windowed
                nothing: Any = None
                glfw.set_window_monitor(window, nothing, x, y, width, height, glfw.DONT_CARE)
                self._windowed = None
