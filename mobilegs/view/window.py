"""A window that shows a scene, with the keys and gestures of the web viewer.

`show` opens the window. `Window` works on any canvas of rendercanvas, also without a display.
"""

import logging
import math
import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from mobilegs.atomic import atomic_path, free_path
from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.extras import extra_module
from mobilegs.render.levels import usual_level_sigma
from mobilegs.render.supersampling import supersampling_for
from mobilegs.scene_file import open_with_views, up_source
from mobilegs.up import AXES, USUAL, Axis, next_axis
from mobilegs.view.input import COMMAND, Input, point_under
from mobilegs.view.wgpu_device import translated_errors
from mobilegs.view.wgpu_renderer import WgpuRenderer
from mobilegs.viewpoints.pose import Pose, camera_of, first_pose

log = logging.getLogger(__name__)
SIZE = (1280, 720)  # logical pixels
FPS_MAX = 120
SORT_ANGLE = math.cos(math.radians(0.5))  # sort again after a larger turn than this
SECONDS_MAX = 0.1  # longest time step of flying
TITLE_EVERY = 0.25  # seconds between updates of the title
LINGER_SECONDS = 0.15  # seconds after an input for which frame times still count
HELP = """\
  drag                  turn around the scene
  right drag, Shift     move sideways
  wheel                 come nearer, go away
  double click          look at this point
  arrows                turn
  W A S D Q E           fly; with Shift faster
  M                     switch between orbiting and looking around
  V                     next training camera
  R                     first view
  U                     turn another axis upwards
  F                     full screen
  P                     save an image
  I                     frame rate and time of each pass, in the title
  H                     these keys
  Esc, Ctrl-Q           leave full screen, close"""


def log_keys() -> None:
    """Log what the keys do, a line each."""
    for line in HELP.splitlines():
        log.info("%s", line)


def show(path: Path, up: Axis | None = None) -> None:
    """Show a scene in a window, until the window is closed; `up` replaces its upward direction.

    Raises InputError without a display, a GPU or the packages for them, for a file that
    WgpuRenderer does not support, and if the GPU fails.
    """
    toolkit = _toolkit()
    scene, views = open_with_views(path, torch.device("cpu"))
    level_sigma = usual_level_sigma(soft_edge=scene.footprint.soft_edge)
    renderer = WgpuRenderer(scene, level_sigma=level_sigma)
    canvas = toolkit.RenderCanvas(size=SIZE, title=path.stem, max_fps=FPS_MAX)
    try:
        window = Window(canvas, renderer, views, path.stem, up)
    except Exception:
        canvas.close()
        raise
    if up is None and scene.up is None:
        log.info("up is %s (the key U or --up changes it)", up_source(path, None))
    log.info("%s is open in a window. Keys:", path)
    log_keys()
    try:
        toolkit.loop.run()
    finally:
        window.close()
    if window.failure is not None:
        raise window.failure


def _toolkit() -> Any:
    """Return the module that opens windows. Raises InputError if it cannot."""
    glfw = extra_module("glfw", "a window needs glfw", "native")
    toolkit = extra_module("rendercanvas.glfw", "a window needs rendercanvas", "native")
    with warnings.catch_warnings():  # the error below replaces its warning
        warnings.simplefilter("ignore")
        ready = glfw.init()
    if not ready:
        raise InputError(
            "no window can be opened without a display: without --native, the scene opens in a "
            "browser, with --lan also in one on another machine"
        )
    return toolkit


class Window:
    """A scene on a canvas. Renders a frame after each input, and while keys are held.

    Attributes:
        canvas: the canvas, of rendercanvas.
        input: pointer and keys; `input.pose` is the viewer's pose.
        timed: True to show frame times in the title.
        failure: the error that closed the window, or None: toolkits only log those of handlers.
    """

    def __init__(
        self,
        canvas: Any,
        renderer: WgpuRenderer,
        views: Sequence[Camera],
        name: str,
        up: Axis | None = None,
    ) -> None:
        """Show the scene of `renderer`; `views` are its training cameras, or empty.

        `up` replaces the scene's upward direction.
        """
        self.canvas = canvas
        self.timed = False
        self.failure: Exception | None = None
        self._renderer, self._views, self._name = renderer, views, name
        scene = renderer.scene
        logits = scene.gaussians.logit_opacities if scene.lobes is None else scene.lobes[:, 0, 0]
        self._up: Axis | None = up
        self._start = first_pose(scene, views, up)
        self._solid = scene.gaussians.means[logits >= 0].cpu().numpy()  # targets of a double click
        self.input = Input(self._start.copy())
        self._view = 0
        # sorted scenes: the order, and the viewing direction for which it was computed
        self._order: tuple[np.ndarray, np.ndarray] | None = None
        self._next_order: Future | None = None
        self._sorter = ThreadPoolExecutor(1)
        self._touched = -math.inf  # time of the last input
        self._last_frame: float | None = None  # time of the last frame, if it followed an input
        self._times: list[float] = []  # milliseconds of consecutive frames
        self._titled = 0.0
        # position and size of the window, while it is full screen
        self._windowed: tuple[int, int, int, int] | None = None
        device = renderer.program.device
        with translated_errors(renderer.program.gpu):
            self._context = canvas.get_context("wgpu")
            # images are sRGB already: no format that converts to it
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
            canvas.add_event_handler(self._ending(handler), kind)
        self._say_title("")
        canvas.request_draw(self._ending(self._frame))

    def camera(self, width: int, height: int) -> Camera:
        """Return the camera of a frame of the given size in physical pixels."""
        view = self._views[0] if self._views else None
        return camera_of(self.input.pose, view, width, height, self._renderer.scene.near)

    def reset(self, index: int | None = None) -> None:
        """Go back to the first view, or to training camera `index`."""
        pose = self._start.copy()
        if index is not None and self._views:
            up = self._renderer.scene.up if self._up is None else AXES[self._up]
            pose = Pose.from_views(self._views, index % len(self._views), up)
        self.input.pose = pose

    def turn_up(self) -> None:
        """Let the next axis point up; the scene's own direction is one of the steps."""
        scene = self._renderer.scene
        self._up = next_axis(self._up, USUAL if scene.up is None else scene.up)
        self._start = first_pose(scene, self._views, self._up)
        self.reset()

    def close(self) -> None:
        """Close the window, if it is open."""
        self._sorter.shutdown()
        if not self.canvas.get_closed():
            self.canvas.close()

    def save(self) -> Path:
        """Write the current view to a new PNG file in the working folder. Returns its path."""
        path = free_path(Path(f"{self._name}.png"))
        camera = self.camera(*self.canvas.get_physical_size())
        n = supersampling_for(camera, self._views)
        image = self._renderer.render(camera, supersampling=n)
        with atomic_path(path) as temporary:
            Image.fromarray(to_bytes(image.image).numpy()).save(temporary, format="PNG")
        return path

    def _ending(self, function: Callable[..., None]) -> Callable[..., None]:
        """Return `function`, with errors that close the window and become its `failure`."""

        def guarded(*arguments: Any) -> None:
            try:
                function(*arguments)
            except Exception as error:
                self.failure = error
                self.canvas.close()

        return guarded

    def _frame(self) -> None:
        now = time.perf_counter()
        if self._last_frame is not None:
            seconds = now - self._last_frame
            self._times = [*self._times[-29:], 1000 * seconds]
            self.input.advance(min(seconds, SECONDS_MAX))
        with translated_errors(self._renderer.program.gpu):
            texture = self._context.get_current_texture()
            target = texture.create_view()
        camera = self.camera(*texture.size[:2])
        order = self._order_for(camera) if self._renderer.program.sorted else None
        n = supersampling_for(camera, self._views)
        self._renderer.render_into(target, self._format, camera, order=order, supersampling=n)
        moving = self.input.busy or now - self._touched < LINGER_SECONDS
        self._last_frame = now if moving else None
        if self.timed and now - self._titled > TITLE_EVERY:
            self._titled = now
            self._say_title(self._figures(camera))
        if self.input.busy:
            self.canvas.request_draw()

    def _order_for(self, camera: Camera) -> np.ndarray:
        """Return an order for about this direction; a thread computes the exact one."""
        forward = self.input.pose.forward
        if self._next_order is not None and self._next_order.done():
            self._order, self._next_order = self._next_order.result(), None
        order, direction = self._order or (self._renderer.far_first(camera), forward)
        self._order = order, direction
        if self._next_order is None and forward @ direction < SORT_ANGLE:
            self._next_order = self._sorter.submit(
                lambda: (self._renderer.far_first(camera), forward)
            )
            self._next_order.add_done_callback(lambda _: self.canvas.request_draw())
        return order

    def _figures(self, camera: Camera) -> str:
        passes = self._renderer.milliseconds() or {}
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
            place = point_under(self._solid, camera, event["x"], event["y"])
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
        """Perform the action of a key that does not move the pose."""
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
        elif key == "u":
            self.turn_up()
        elif key == "m":
            self.input.mode = "fly" if self.input.mode == "orbit" else "orbit"
        elif key == "f":
            self._full_screen()
        elif key == "p":
            try:
                log.info("saved %s", self.save())
            except (InputError, OSError) as error:
                log.warning("the image could not be saved: %s", error)
        elif key == "i":
            self.timed, self._titled = not self.timed, 0.0
            self._say_title("")
        elif key == "h":
            log_keys()
        self.canvas.request_draw()

    def _full_screen(self) -> None:
        """Switch full screen on or off, by glfw: rendercanvas has no function for it."""
        window = getattr(self.canvas, "_window", None)
        if window is None:
            return
        import glfw

        with warnings.catch_warnings():  # on Wayland, windows do not know their position
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
