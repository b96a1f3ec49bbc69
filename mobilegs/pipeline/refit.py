"""Refit a sort-free scene to sorted blending, for the viewers of other tools."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch

from mobilegs.camera import Camera
from mobilegs.data.dataset import TEST_EVERY, Dataset, Frame, ViewLoader, center_and_extent
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.evaluate.report import evaluate
from mobilegs.gaussians import Gaussians
from mobilegs.progress_display import Progress, no_progress
from mobilegs.render.project import CLASSIC
from mobilegs.render.scene import Scene
from mobilegs.synthetic_capture.render import ASPECT_RATIO
from mobilegs.train.run_dir import stop_between_steps
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig, TeacherLearningRates
from mobilegs.viewpoints.placement import interpolate_cameras, place_cameras
from mobilegs.viewpoints.scene_bounds import find_scene_bounds
from mobilegs.viewpoints.visibility import validate_visibility

STEPS = 800
SIDE_MAX = 640  # pixels of an image's longer side
TRAIN_MAX, TEST_MAX = 160, 24  # images
VIEWS = 112  # placed where there is no capture
PARALLEL_DEGREES = 40  # around their mean, within which cameras look in one direction
# 3DGS's learning rates except for the means, which are in place already; all Gaussians stay
# with the footprint of 3DGS: many tools ignore another one
CONFIG = TeacherConfig(
    lr=TeacherLearningRates(means=1.6e-5),
    min_views=0,
    densify=DensifyConfig(strategy="fixed"),
    footprint=CLASSIC,
    least_variance=0.0,
)


@dataclass(frozen=True)
class Views:
    """Training and test images of a refit.

    Attributes:
        renders: sort-free renders of the scene, in memory.
        photos: the photos from the same cameras, or None.
    """

    renders: Dataset
    photos: Dataset | None = None


@dataclass(frozen=True)
class Fit:
    """The quality of sorted blending before and after a refit: PSNR in dB.

    Attributes:
        before: of the original scene, sorted, against its sort-free test renders.
        after: of the refitted scene against the same renders.
        views: number of test renders.
        photos: against test photos: of the original scene, sort-free, and of the refitted scene;
            None without photos.
    """

    before: float
    after: float
    views: int
    photos: tuple[float, float] | None = None

    def __str__(self) -> str:
        """Return a sentence for people and for file headers."""
        text = (
            f"refitted to sorted blending: {self.after:.1f} dB (before: {self.before:.1f} dB) "
            f"against {self.views} held-back sort-free renders"
        )
        if self.photos is None:
            return text
        sort_free, refitted = self.photos
        return f"{text}; {refitted:.1f} dB (sort-free: {sort_free:.1f} dB) against photos"


def views_from(scene: Scene, capture: Dataset, *, progress: Progress = no_progress) -> Views:
    """Render a sort-free scene from the cameras of its capture.

    At most 160 training and 24 test cameras are used, evenly spaced, and images have at most 640
    pixels on their longer side. Raises InputError if the capture holds no photo back or shows
    another scene.
    """
    if not capture.test:
        raise InputError(
            f"the capture {capture.name} holds no photo back for the test: it needs more photos"
        )
    train, test = _evenly(capture.train, TRAIN_MAX), _evenly(capture.test, TEST_MAX)
    photos = replace(capture, train=train, test=test)
    return Views(_render_views(scene, photos, progress), photos)


def views_around(
    scene: Scene, first_looks: Sequence[Camera], *, seed: int, progress: Progress = no_progress
) -> Views:
    """Render a sort-free scene from cameras that the program places.

    `first_looks` are the cameras in its file: half of the cameras lie between them, the others
    around the scene's centre. If there are at least three and they look in about the same
    direction, all cameras lie between them, because the scene has holes seen from elsewhere. Images
    are at most as large as theirs. Raises InputError if too few cameras see the scene.
    """
    given = [camera.to(torch.device("cpu")) for camera in first_looks]
    cameras = _place_views(scene, given, torch.Generator().manual_seed(seed), progress)
    frames = [Frame(f"{number:04}.png", camera) for number, camera in enumerate(cameras)]
    train = [frame for number, frame in enumerate(frames) if number % TEST_EVERY]
    no_points = torch.zeros(0, 3)
    center, extent = center_and_extent(
        [frame.camera for frame in train], scene.gaussians.means.cpu()
    )
    views = Dataset(
        name="placed views",
        train=train,
        test=frames[::TEST_EVERY],
        points=no_points,
        colors=no_points,
        extent=extent,
        center=center,
        background=scene.background.cpu(),
        near=cameras[0].near,
    )
    return Views(_render_views(scene, views, progress))


def _place_views(
    scene: Scene, given: list[Camera], generator: torch.Generator, progress: Progress
) -> list[Camera]:
    """Return cameras between those given and around the scene's centre, shuffled."""
    side = min([SIDE_MAX, *(max(camera.width, camera.height) for camera in given)])
    bounds = find_scene_bounds(scene.gaussians, up=scene.up)
    between = VIEWS // 2 if given else 0
    if len(given) > 2 and _are_parallel(given):
        between = VIEWS
    cameras: list[Camera] = []
    if between < VIEWS:
        size = {"width": side, "height": round(side / ASPECT_RATIO)}
        with progress("placing cameras") as advance:
            cameras += place_cameras(
                scene, bounds, VIEWS - between, **size, generator=generator, progress=advance
            )
    if between:
        cameras += interpolate_cameras(given, bounds, between, size=side, generator=generator)
    # so that held-back views lie anywhere
    order = torch.randperm(len(cameras), generator=generator).tolist()
    return [cameras[i] for i in order]


def refit(scene: Scene, views: Views, *, seed: int, progress: Progress = no_progress) -> Gaussians:
    """Train the scene's Gaussians so that sorted blending shows what sort-free blending showed.

    They start with the mean of their opacities over all directions; none is added or removed.
    Photos, if there are any, and renders count alike. The result depends only on the arguments.
    Raises KeyboardInterrupt if a signal asks to stop.
    """
    device = scene.gaussians.means.device
    frames = [*views.renders.train, *(views.photos.train if views.photos else [])]
    config, dataset = replace(CONFIG, steps=STEPS), replace(views.renders, train=frames)
    stage = Teacher(config, dataset, seed=seed, device=device, start=scene.gaussians)
    order = view_order(len(frames), 0, STEPS, seed)
    with (
        ViewLoader(frames) as loader,
        progress("refitting") as advance,
        stop_between_steps() as stop,
    ):
        for index in order:
            stage.advance([(index, loader.get(index, device))])
            advance(stage.done, STEPS)
            if stop:
                raise KeyboardInterrupt
    return stage.gaussians()


def measure_fit(
    scene: Scene, refitted: Gaussians, views: Views, *, progress: Progress = no_progress
) -> Fit:
    """Compare `refitted`, blended sorted, with the sort-free scene on held-back views."""

    def as_sorted(gaussians: Gaussians) -> Scene:
        moved = gaussians.to(scene.gaussians.means.device)
        return Scene(moved, background=scene.background, near=scene.near)

    def psnr(shown: Scene, targets: Dataset) -> float:
        with progress("measuring") as advance:
            return evaluate(shown, targets, progress=advance)["psnr"]

    before, after = as_sorted(scene.gaussians), as_sorted(refitted)
    photos = None
    if views.photos is not None:
        photos = psnr(scene, views.photos), psnr(after, views.photos)
    renders = views.renders
    return Fit(psnr(before, renders), psnr(after, renders), len(renders.test), photos)


@torch.inference_mode()
def _render_views(scene: Scene, views: Dataset, progress: Progress) -> Dataset:
    """Return the capture with renders of the scene instead of its photos."""
    frames = [*views.train, *views.test]
    cameras = [frame.camera for frame in frames]
    instead = "give the capture that it was made from"
    validate_visibility(scene, cameras, f"photos of {views.name}", instead)
    drawn: list[Frame] = []
    with progress("rendering views") as advance:
        for frame in frames:
            image = scene.render(frame.camera.to(scene.gaussians.means.device)).image
            drawn.append(Frame(frame.name, frame.camera, pixels=to_bytes(image).cpu()))
            advance(len(drawn), len(frames))
    count = len(views.train)
    return replace(views, train=drawn[:count], test=drawn[count:])


def _are_parallel(cameras: Sequence[Camera]) -> bool:
    """Return True if all cameras look in about one direction."""
    axes = torch.stack([camera.viewmat[2, :3] for camera in cameras])
    middle = torch.nn.functional.normalize(axes.sum(0), dim=0)
    return bool((axes @ middle).min() > math.cos(math.radians(PARALLEL_DEGREES)))


def _evenly(frames: Sequence[Frame], most: int) -> list[Frame]:
    """Return at most `most` frames, evenly spaced, of at most `SIDE_MAX` pixels."""
    chosen = torch.linspace(0, len(frames) - 1, min(most, len(frames))).round().long().tolist()
    return [replace(frames[i], camera=_resized(frames[i].camera)) for i in chosen]


def _resized(camera: Camera) -> Camera:
    sides = camera.width, camera.height
    factor = min(1.0, SIDE_MAX / max(sides))
    width, height = (max(1, math.floor(factor * side + 0.5)) for side in sides)
    return camera.resized(width, height)
