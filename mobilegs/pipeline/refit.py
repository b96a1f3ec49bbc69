"""A sort-free scene fitted once more, so that viewers that sort show what it shows."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch

from mobilegs.camera import Camera
from mobilegs.data.dataset import TEST_EVERY, Dataset, Frame, ViewLoader, measure
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.evaluate.report import evaluate
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.synthetic_capture.placement import between_cameras, place_cameras
from mobilegs.synthetic_capture.render import SHAPE, Progress, silent
from mobilegs.synthetic_capture.scene_bounds import layout_of
from mobilegs.synthetic_capture.visibility import refuse_blind
from mobilegs.train.run_dir import stopping_between_steps
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig

STEPS = 800
SIDE = 640  # of pictures, in pixels, at most
LEARNED, HELD = 160, 24  # pictures that are learned from and held back, at most
PLACES = 112  # that are looked for where no capture tells
UPRIGHT = 0.3  # of the mean of their ups, from which on cameras agree about the vertical
ALIKE = 40  # degrees around their mean, within which cameras look in one direction
# 3DGS's rates but for centres: these Gaussians lie where they belong, and all of them stay
RATES = TeacherConfig(position_rate=1.6e-5, min_views=0, densify=DensifyConfig(strategy="fixed"))


@dataclass(frozen=True)
class Views:
    """What a refit learns from, and what it is measured by.

    Attributes:
        own: pictures of the scene without sorting, in memory; `test` is held back.
        photos: the photos from the same places; None where there are none.
    """

    own: Dataset
    photos: Dataset | None = None


@dataclass(frozen=True)
class Fit:
    """How well viewers that sort show a sort-free scene: PSNR in dB.

    Attributes:
        before, after: against the scene's own pictures without sorting, as it was and refitted.
        places: how many these are. They were held back.
        photos: against held-back photos, of the scene without sorting and refitted; None where
            there are no photos.
    """

    before: float
    after: float
    places: int
    photos: tuple[float, float] | None = None

    def __str__(self) -> str:
        """A sentence for people, and for the headers of files."""
        said = (
            f"refitted for viewers that sort: {self.after:.1f} dB against the scene's own pictures "
            f"from {self.places} held-back places, {self.before:.1f} dB before"
        )
        if self.photos is None:
            return said
        without, refitted = self.photos
        return f"{said}; against photos {refitted:.1f} dB, without sorting {without:.1f} dB"


def views_from(scene: Scene, capture: Dataset, *, progress: Progress = silent) -> Views:
    """Pictures of a sort-free scene from where the photos of its capture were taken.

    Of many photos so many are taken, evenly, as a short training can use, and no larger than 640
    pixels. Raises InputError if the capture holds none back, or is of something else.
    """
    if not capture.test:
        raise InputError(
            f"the capture {capture.name} holds no photo back to measure with: it needs more photos"
        )
    train, test = _some(capture.train, LEARNED), _some(capture.test, HELD)
    photos = replace(capture, train=train, test=test)
    return Views(_pictures(scene, photos, progress), photos)


def views_around(
    scene: Scene, first_looks: Sequence[Camera], *, seed: int, progress: Progress = silent
) -> Views:
    """Pictures of a sort-free scene from places that the program finds.

    `first_looks` are the cameras that its file brings: half of the places lie among them, the
    others around the scene's middle. If there are several and they look in much the same
    direction, the scene looks torn from elsewhere, and all places lie among them. Pictures are no
    larger than theirs. Raises InputError if hardly any place shows the scene.
    """
    given = [camera.to(torch.device("cpu")) for camera in first_looks]
    cameras = _places(scene, given, torch.Generator().manual_seed(seed), progress)
    frames = [Frame(f"{number:04}.png", camera) for number, camera in enumerate(cameras)]
    train = [frame for number, frame in enumerate(frames) if number % TEST_EVERY]
    nothing = torch.zeros(0, 3)
    center, extent = measure([frame.camera for frame in train], scene.gaussians.means.cpu())
    places = Dataset(
        name="places",
        train=train,
        test=frames[::TEST_EVERY],
        points=nothing,
        colors=nothing,
        extent=extent,
        center=center,
        background=scene.background.cpu(),
        near=cameras[0].near,
    )
    return Views(_pictures(scene, places, progress))


def _places(
    scene: Scene, given: list[Camera], generator: torch.Generator, progress: Progress
) -> list[Camera]:
    """Cameras among those given and around the scene's middle, in any order."""
    side = min([SIDE, *(max(camera.width, camera.height) for camera in given)])
    up = -torch.stack([camera.viewmat[1, :3] for camera in given]).mean(0) if given else None
    layout = layout_of(scene.gaussians, up=up if up is not None and up.norm() > UPRIGHT else None)
    among = PLACES // 2 if given else 0
    if len(given) > 2 and _alike(given):
        among = PLACES
    cameras: list[Camera] = []
    if among < PLACES:
        size = {"width": side, "height": round(side / SHAPE)}
        with progress("finding places") as advance:
            cameras += place_cameras(
                scene, layout, PLACES - among, **size, generator=generator, progress=advance
            )
    if among:
        cameras += between_cameras(given, layout, among, size=side, generator=generator)
    # what is held back shall be anywhere
    order = torch.randperm(len(cameras), generator=generator).tolist()
    return [cameras[i] for i in order]


def refit(scene: Scene, views: Views, *, seed: int, progress: Progress = silent) -> Gaussians:
    """The scene's Gaussians, moved until they show sorted what they showed without sorting.

    They begin with the mean of their opacities over all directions. None is added or removed.
    Photos, where there are any, are learned from as much as pictures of the scene.
    The same seed gives the same ones. Raises KeyboardInterrupt if told to stop.
    """
    device = scene.gaussians.means.device
    frames = [*views.own.train, *(views.photos.train if views.photos else [])]
    config, places = replace(RATES, steps=STEPS), replace(views.own, train=frames)
    stage = Teacher(config, places, seed=seed, device=device, start=scene.gaussians)
    order = view_order(len(frames), 0, STEPS, seed)
    with (
        ViewLoader(frames) as loader,
        progress("refitting") as advance,
        stopping_between_steps() as stop,
    ):
        for index in order:
            stage.advance([(index, loader.get(index, device))])
            advance(stage.done, STEPS)
            if stop:
                raise KeyboardInterrupt
    return stage.gaussians()


def fit_of(scene: Scene, refitted: Gaussians, views: Views, *, progress: Progress = silent) -> Fit:
    """How near `refitted`, blended sorted, comes to the sort-free scene from held-back places."""

    def sorts(gaussians: Gaussians) -> Scene:
        there = gaussians.to(scene.gaussians.means.device)
        return Scene(there, background=scene.background, near=scene.near)

    def psnr(shown: Scene, photos: Dataset) -> float:
        with progress("measuring") as advance:
            return evaluate(shown, photos, progress=advance)["psnr"]

    before, after = sorts(scene.gaussians), sorts(refitted)
    photos = None
    if views.photos is not None:
        photos = psnr(scene, views.photos), psnr(after, views.photos)
    own = views.own
    return Fit(psnr(before, own), psnr(after, own), len(own.test), photos)


@torch.inference_mode()
def _pictures(scene: Scene, places: Dataset, progress: Progress) -> Dataset:
    """The capture with pictures of the scene in the place of its photos."""
    frames = [*places.train, *places.test]
    cameras = [frame.camera for frame in frames]
    instead = "give the capture that it was made of"
    refuse_blind(scene, cameras, f"photos of {places.name}", instead)
    drawn: list[Frame] = []
    with progress("taking pictures") as advance:
        for frame in frames:
            picture = scene.render(frame.camera.to(scene.gaussians.means.device))
            drawn.append(Frame(frame.name, frame.camera, pixels=to_bytes(picture.image).cpu()))
            advance(len(drawn), len(frames))
    count = len(places.train)
    return replace(places, train=drawn[:count], test=drawn[count:])


def _alike(cameras: Sequence[Camera]) -> bool:
    """Whether cameras all look in about one direction."""
    axes = torch.stack([camera.viewmat[2, :3] for camera in cameras])
    middle = torch.nn.functional.normalize(axes.sum(0), dim=0)
    return bool((axes @ middle).min() > math.cos(math.radians(ALIKE)))


def _some(frames: Sequence[Frame], most: int) -> list[Frame]:
    """At most so many of the frames, evenly, at no more than `SIDE` pixels."""
    chosen = torch.linspace(0, len(frames) - 1, min(most, len(frames))).round().long().tolist()
    return [replace(frames[i], camera=_sized(frames[i].camera)) for i in chosen]


def _sized(camera: Camera) -> Camera:
    sides = camera.width, camera.height
    factor = min(1.0, SIDE / max(sides))
    width, height = (max(1, math.floor(factor * side + 0.5)) for side in sides)
    return camera.resized(width, height)
