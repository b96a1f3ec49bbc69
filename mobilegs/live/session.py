"""The live view of a training: renders frames for browsers between two steps."""

import math
import time

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import decibels, to_bytes
from mobilegs.live import frames
from mobilegs.live.frame_budget import PIXELS_MAX, Detail, FrameBudget
from mobilegs.live.frames import BrowserCamera
from mobilegs.live.page import PHOTO_MODES, FrameRequest, Page, Visitor
from mobilegs.render.scene import Scene
from mobilegs.train.memory import return_freed_memory
from mobilegs.train.monitor import Monitor
from mobilegs.train.run_dir import StopRequest
from mobilegs.train.stage import Stage

REST_SECONDS = 0.25  # without a movement, after which a camera is at rest
STATUS_SECONDS = 0.5  # between two updates of the status
POLL_SECONDS = 0.2  # between two looks at the stop request during a pause


class LiveSession:
    """Renders for all browsers of a page, in the training thread and within a `FrameBudget`."""

    def __init__(self, page: Page, dataset: Dataset, monitor: Monitor) -> None:
        """`monitor` supplies the status, and excludes pauses from the training time."""
        self.page = page
        self.budget = FrameBudget()
        self._dataset, self._monitor = dataset, monitor
        self._scene: Scene | None = None  # of the current step, once a frame needs it
        self._photo: tuple[int, View] | None = None  # the last one that was compared
        self._watched = False  # by anybody, at the last step
        self._status: dict[str, str] = {}
        self._status_at = float("-inf")

    def show(self, dataset: Dataset) -> None:
        """Show the photos of `dataset`: the same ones, whose poses may have changed."""
        self._dataset, self._photo = dataset, None
        self.page.show(dataset)

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
        self.page.set_status(self._status)

    @torch.no_grad()
    def _draw(self, stage: Stage) -> None:
        """Render a frame for every browser that needs one, the longest waiting first."""
        now = time.monotonic()
        visitors = self.page.visitors()
        if self._watched and not visitors:  # their frames were large
            self._photo = None
            return_freed_memory()
            if self.page.paused:
                self._monitor.note(
                    f"the training is paused, and nobody looks on any more: {self.page.address} "
                    "continues it, Ctrl-C ends it"
                )
        self._watched = bool(visitors)
        for visitor in visitors:
            request = self._request(stage, visitor, now)
            last = visitor.last_request
            if request == last:
                continue
            urgent = last is None or last[:-1] != request[:-1]  # all but the step changed
            paused = self.page.paused
            if visitor.frame is not None and not urgent:
                continue  # nobody has fetched the last one
            if not paused and not self.budget.allows(urgent=urgent):
                continue
            began = time.monotonic()
            visitor.last_request = request
            try:
                self._send(stage, visitor, request)
            except (InputError, OSError, MemoryError, RuntimeError) as error:
                # a photo that is gone, or too little memory: the training goes on
                self._photo = None
                visitor.said = {"no picture": str(error).partition("\n")[0]}
            visitor.drawn_at = time.monotonic()
            if not paused:
                self.budget.spend(visitor.drawn_at - began)

    def _request(self, stage: Stage, visitor: Visitor, now: float) -> FrameRequest:
        camera, mode = visitor.camera, visitor.mode
        canvas, step = (camera.width, camera.height), (stage.name, stage.done)
        if mode in PHOTO_MODES:
            photo = self.page.cameras.nearest(camera)
            return FrameRequest(mode, photo, canvas, "resting", step)
        detail: Detail = "paused" if self.page.paused else "resting"
        if now - visitor.moved_at < REST_SECONDS:
            detail = "moving"
        return FrameRequest(mode, camera, canvas, detail, step)

    def _send(self, stage: Stage, visitor: Visitor, request: FrameRequest) -> None:
        if self._scene is None:
            self._scene = stage.scene()
        began, said = time.monotonic(), {}
        if isinstance(request.source, BrowserCamera):
            size = self.budget.size(request.detail, *request.canvas)
            camera = request.source.camera(*size, near=self._dataset.near)
            camera = camera.to(self._scene.background.device)
            if request.mode == "depth":
                image = frames.render_depth(self._scene, camera)
            else:
                image = self._scene.render(camera).image
            frame = to_bytes(image).cpu().numpy()
            self.budget.record_speed(request.detail, size[0] * size[1], time.monotonic() - began)
        else:
            image, said = self._photo_image(
                self._scene, request.mode, request.source, request.canvas[0] / request.canvas[1]
            )
            frame = (
                to_bytes(frames.letterbox(image, *self.budget.size("paused", *request.canvas)))
                .cpu()
                .numpy()
            )
        self.page.send_frame(visitor, frame, said)

    def _photo_image(
        self, scene: Scene, mode: str, index: int, aspect: float
    ) -> tuple[Float[Tensor, "h w 3"], dict[str, str]]:
        """Return photo `index`, its error map, or both with the render, and its PSNR.

        A photo of more than `PIXELS_MAX` pixels is reduced.
        """
        if self._photo is None or self._photo[0] != index:
            view = load_view(self._dataset.train[index])
            n = math.ceil(math.sqrt(view.camera.width * view.camera.height / PIXELS_MAX))
            self._photo = index, view.reduced(n)
        view = self._photo[1].to(scene.background.device)
        image = scene.render(view.camera).image
        size = "" if view.camera.width == self._dataset.train[index].camera.width else ", reduced"
        said = {view.name: f"{decibels(frames.view_psnr(image, view))}{size}"}
        single = {"photo": view.image, "error": frames.error_map(image, view)}
        row = [view.image, image, single["error"]]
        return single[mode] if mode in single else frames.side_by_side(row, aspect), said
