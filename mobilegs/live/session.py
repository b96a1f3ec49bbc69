"""What happens between two steps of a training that somebody watches."""

import time
from dataclasses import dataclass
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.live import frames
from mobilegs.live.frame_budget import Detail, Pace
from mobilegs.live.frames import Eye
from mobilegs.live.page import WITH_PHOTO, Page
from mobilegs.render.scene import Scene
from mobilegs.train.progress import Monitor
from mobilegs.train.run_dir import StopRequest
from mobilegs.train.stage import Stage

RESTS = 0.25  # seconds without a movement after which a camera is at rest
TOLD = 0.5  # seconds between two sets of figures
NAP = 0.2  # seconds after which one who waits looks whether to stop


class Wish(NamedTuple):
    """What should be on a canvas: of `place`, an eye or the number of a photo, after `step`."""

    shown: str
    place: Eye | int
    canvas: tuple[int, int]
    detail: Detail
    step: tuple[str, int]


@dataclass
class Onlooker:
    """A browser: where its camera was last, since when, and what it was shown, and when."""

    eye: Eye
    moved: float
    has: Wish | None = None
    drawn: float = 0.0


class Show:
    """Draws for all browsers on the page, in the thread that trains and within `Pace`."""

    def __init__(self, page: Page, dataset: Dataset, monitor: Monitor) -> None:
        """`monitor` knows the figures, and does not count the time of pauses."""
        self.page = page
        self.pace = Pace()
        self._dataset, self._monitor = dataset, monitor
        self._onlookers: dict[int, Onlooker] = {}
        self._scene: Scene | None = None  # of the present step, once it was asked for
        self._photo: tuple[int, View] | None = None  # the last one that was compared
        self._figures: dict[str, str] = {}
        self._compared: dict[str, str] = {}
        self._told = float("-inf")

    def between_steps(self, stage: Stage, stop: StopRequest) -> None:
        """Show what there is; while the page says pause, wait, and draw what is asked for."""
        self._figures = {}
        self._tell(stage)
        self._draw(stage)
        if self.page.paused:
            began = time.monotonic()
            while self.page.paused and not stop:
                self._tell(stage)
                self._draw(stage)
                self.page.asked.wait(NAP)
                self.page.asked.clear()
            self._monitor.leave_out(time.monotonic() - began)
        self._scene = None

    def _tell(self, stage: Stage) -> None:
        if time.monotonic() - self._told < TOLD:
            return
        self._told = time.monotonic()
        if not self._figures:
            step = f"{stage.done:,} of {stage.steps:,}"
            self._figures = {stage.name: step, **self._monitor.figures(stage)}
        self.page.tell(self._figures | self._compared)

    @torch.no_grad()
    def _draw(self, stage: Stage) -> None:
        """One picture for every browser that lacks one, whoever waited longest first."""
        now, eyes = time.monotonic(), self.page.eyes()
        for number in self._onlookers.keys() - eyes.keys():
            del self._onlookers[number]
        for number, eye in eyes.items():
            if number not in self._onlookers:
                self._onlookers[number] = Onlooker(eye, now)  # it may still be on its way
            elif self._onlookers[number].eye != eye:
                self._onlookers[number].eye, self._onlookers[number].moved = eye, now
        for number, onlooker in sorted(self._onlookers.items(), key=lambda item: item[1].drawn):
            wish = self._wish(stage, onlooker, now)
            if wish == onlooker.has:
                continue
            urgent = onlooker.has is None or onlooker.has[:-1] != wish[:-1]
            paused = self.page.paused
            if not paused and not self.pace.allows(urgent=urgent):
                return
            began = time.monotonic()
            self._show(stage, number, wish)
            onlooker.has, onlooker.drawn = wish, time.monotonic()
            if not paused:
                self.pace.spend(onlooker.drawn - began)

    def _wish(self, stage: Stage, onlooker: Onlooker, now: float) -> Wish:
        eye, shown = onlooker.eye, self.page.shown
        canvas, step = (eye.width, eye.height), (stage.name, stage.done)
        if shown in WITH_PHOTO:
            return Wish(shown, self.page.views.nearest(eye), canvas, "resting", step)
        rest: Detail = "paused" if self.page.paused else "resting"
        return Wish(shown, eye, canvas, "moving" if now - onlooker.moved < RESTS else rest, step)

    def _show(self, stage: Stage, number: int, wish: Wish) -> None:
        if self._scene is None:
            self._scene = stage.scene()
        began = time.monotonic()
        if isinstance(wish.place, Eye):
            size = self.pace.size(wish.detail, *wish.canvas)
            camera = wish.place.camera(*size, near=self._dataset.near)
            camera = camera.to(self._scene.background.device)
            draw = frames.drawn_depth if wish.shown == "depth" else frames.drawn_picture
            image, self._compared = draw(self._scene, camera), {}
        else:
            image = self._beside_photo(self._scene, wish.shown, wish.place, wish.canvas)
        self.page.show(number, to_bytes(image).cpu().numpy())
        if isinstance(wish.place, Eye):
            width, height = size
            self.pace.learn(wish.detail, width * height, time.monotonic() - began)

    def _beside_photo(
        self, scene: Scene, shown: str, index: int, canvas: tuple[int, int]
    ) -> Float[Tensor, "h w 3"]:
        """A photo and what is drawn from its camera, at the size at which training compares."""
        if self._photo is None or self._photo[0] != index:
            self._photo = index, load_view(self._dataset.train[index])
        view = self._photo[1].to(scene.background.device)
        image = scene.render(view.camera).image
        self._compared = {view.name: f"{frames.decibels(image, view):.2f} dB"}
        made = {"photo": view.image, "error": frames.error_map(image, view)}
        if shown in made:
            return frames.fitted(made[shown], *canvas)
        row = [view.image, image, made["error"]]
        return frames.fitted(frames.side_by_side(row, canvas[0] / canvas[1]), *canvas)
