"""The live view of a training: renders frames for browsers between two steps."""

import time
from dataclasses import dataclass
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.live import frames
from mobilegs.live.frame_budget import Detail, FrameBudget
from mobilegs.live.frames import BrowserCamera
from mobilegs.live.page import PHOTO_MODES, Page
from mobilegs.render.scene import Scene
from mobilegs.train.progress import Monitor
from mobilegs.train.run_dir import StopRequest
from mobilegs.train.stage import Stage

REST_SECONDS = 0.25  # without a movement, after which a camera is at rest
STATUS_SECONDS = 0.5  # between two updates of the status
POLL_SECONDS = 0.2  # between two looks at the stop request during a pause


class FrameRequest(NamedTuple):
    """A frame that a canvas should show."""

    mode: str
    source: BrowserCamera | int
    """A browser's camera, or the index of a training photo."""
    canvas: tuple[int, int]
    """Width and height in pixels."""
    detail: Detail
    step: tuple[str, int]
    """Stage and number of steps taken."""


@dataclass
class Client:
    """A connected browser: its camera, and the last frame that it received."""

    camera: BrowserCamera
    moved_at: float
    last_request: FrameRequest | None = None
    drawn_at: float = 0.0


class LiveSession:
    """Renders for all browsers of a page, in the training thread and within a `FrameBudget`."""

    def __init__(self, page: Page, dataset: Dataset, monitor: Monitor) -> None:
        """`monitor` supplies the status, and excludes pauses from the training time."""
        self.page = page
        self.budget = FrameBudget()
        self._dataset, self._monitor = dataset, monitor
        self._clients: dict[int, Client] = {}
        self._scene: Scene | None = None  # of the current step, once a frame needs it
        self._photo: tuple[int, View] | None = None  # the last one that was compared
        self._status: dict[str, str] = {}
        self._photo_status: dict[str, str] = {}
        self._status_at = float("-inf")

    def after_step(self, stage: Stage, stop: StopRequest) -> None:
        """Update the page; during a pause, block and render on request until `stop` is set."""
        self._status = {}
        self._update_status(stage)
        self._draw(stage)
        if self.page.paused:
            paused_at = time.monotonic()
            while self.page.paused and not stop:
                self._update_status(stage)
                self._draw(stage)
                self.page.changed.wait(POLL_SECONDS)
                self.page.changed.clear()
            self._monitor.exclude_time(time.monotonic() - paused_at)
        self._scene = None

    def _update_status(self, stage: Stage) -> None:
        if time.monotonic() - self._status_at < STATUS_SECONDS:
            return
        self._status_at = time.monotonic()
        if not self._status:
            step = f"{stage.done:,} of {stage.steps:,}"
            self._status = {stage.name: step, **self._monitor.summary(stage)}
        self.page.set_status(self._status | self._photo_status)

    @torch.no_grad()
    def _draw(self, stage: Stage) -> None:
        """Render a frame for every browser that needs one, the longest waiting first."""
        now = time.monotonic()
        self._update_clients(now)
        for number, client in sorted(self._clients.items(), key=lambda item: item[1].drawn_at):
            request = self._request(stage, client, now)
            if request == client.last_request:
                continue
            # all but the step changed
            urgent = client.last_request is None or client.last_request[:-1] != request[:-1]
            paused = self.page.paused
            if not paused and not self.budget.allows(urgent=urgent):
                return
            began = time.monotonic()
            self._send(stage, number, request)
            client.last_request, client.drawn_at = request, time.monotonic()
            if not paused:
                self.budget.spend(client.drawn_at - began)

    def _update_clients(self, now: float) -> None:
        cameras = self.page.clients()
        for number in self._clients.keys() - cameras.keys():
            del self._clients[number]
        for number, camera in cameras.items():
            if number not in self._clients:
                self._clients[number] = Client(camera, now)  # may still be moving to its start
            elif self._clients[number].camera != camera:
                self._clients[number].camera, self._clients[number].moved_at = camera, now

    def _request(self, stage: Stage, client: Client, now: float) -> FrameRequest:
        camera, mode = client.camera, self.page.mode
        canvas, step = (camera.width, camera.height), (stage.name, stage.done)
        if mode in PHOTO_MODES:
            photo = self.page.cameras.nearest(camera)
            return FrameRequest(mode, photo, canvas, "resting", step)
        detail: Detail = "paused" if self.page.paused else "resting"
        if now - client.moved_at < REST_SECONDS:
            detail = "moving"
        return FrameRequest(mode, camera, canvas, detail, step)

    def _send(self, stage: Stage, number: int, request: FrameRequest) -> None:
        if self._scene is None:
            self._scene = stage.scene()
        began = time.monotonic()
        if isinstance(request.source, BrowserCamera):
            size = self.budget.size(request.detail, *request.canvas)
            camera = request.source.camera(*size, near=self._dataset.near)
            camera = camera.to(self._scene.background.device)
            self._photo_status = {}
            if request.mode == "depth":
                image = frames.render_depth(self._scene, camera)
            else:
                image = self._scene.render(camera).image
            self.page.send_frame(number, to_bytes(image).cpu().numpy())
            self.budget.record_speed(request.detail, size[0] * size[1], time.monotonic() - began)
        else:
            image = self._photo_image(self._scene, request.mode, request.source, request.canvas)
            self.page.send_frame(number, to_bytes(image).cpu().numpy())

    def _photo_image(
        self, scene: Scene, mode: str, index: int, canvas: tuple[int, int]
    ) -> Float[Tensor, "h w 3"]:
        """Return photo `index`, its error map, or both with the render, at the training's size."""
        if self._photo is None or self._photo[0] != index:
            self._photo = index, load_view(self._dataset.train[index])
        view = self._photo[1].to(scene.background.device)
        image = scene.render(view.camera).image
        self._photo_status = {view.name: f"{frames.view_psnr(image, view):.2f} dB"}
        single = {"photo": view.image, "error": frames.error_map(image, view)}
        if mode in single:
            return frames.letterbox(single[mode], *canvas)
        row = [view.image, image, single["error"]]
        return frames.letterbox(frames.side_by_side(row, canvas[0] / canvas[1]), *canvas)
