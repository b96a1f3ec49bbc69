"""Places cameras around or inside a scene, or between given cameras."""

import math
from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera, look_at
from mobilegs.errors import InputError
from mobilegs.progress_display import Advance
from mobilegs.render.scene import Scene
from mobilegs.viewpoints.scene_bounds import SceneBounds

FIELD_OF_VIEW = 60  # degrees, horizontal
RADII = (0.6, 6.0)  # range of distances from the centre, in scene radii
# Cameras stand no nearer than where a typical Gaussian's standard deviation covers DETAIL of the
# image's width, but this limit is at most DETAIL_RADII scene radii.
DETAIL, DETAIL_RADII = 1 / 500, 2.0
RADII_INSIDE = (0.2, 1.5)  # range of distances if the scene surrounds its centre
ELEVATIONS = (-4.0, 62.0)  # degrees above the horizon
TEST_WIDTH = 64  # pixels, of the render that decides on a place
COVERED_MIN = 0.2  # mean alpha of the test render
# Ratios of a depth to the distance of the target: nearer pixels obstruct the view, and a nearer
# middle of the render hides the target.
CLOSE_RATIO, OCCLUDED_RATIO = 0.3, 0.6
CLOSE_PIXELS_MAX = 0.02  # share of pixels that may obstruct the view
TRIES = 60  # places that are tried per camera
ENCLOSED_COVERAGE = 0.6  # mean alpha all around a place that is inside a scene
WALL_RADII = 0.5  # distance, in scene radii, from which on surroundings count as walls
INSIDE_PROBES = 16  # places near the centre that decide whether the scene has an inside
NEIGHBOURS = 4  # nearest given cameras towards which a camera is interpolated
TURN_STD = 4.0  # degrees, random turn of an interpolated camera
NEAR = 0.02  # near plane, in scene radii
TARGETS_ANYWHERE = 0.7  # share of cameras that look at any part of the scene, not at its centre


@torch.inference_mode()
def place_cameras(
    scene: Scene,
    bounds: SceneBounds,
    count: int,
    *,
    width: int,
    height: int,
    generator: torch.Generator,
    progress: Advance = lambda done, total: None,
) -> list[Camera]:
    """Place `count` cameras that look at the centre of a scene or at a random part of it.

    Positions are random: log-uniform in distance, uniform in direction between `ELEVATIONS`, and
    no nearer than where single Gaussians become visible as blur. A small render decides on each:
    it must show enough of the scene, with nothing close in the way and the target not hidden,
    which keeps cameras out of objects. If most places near the centre are surrounded by the
    scene, it was captured from inside, and cameras stay inside. `width` and `height` are in
    pixels; `progress` takes (placed, count).

    Raises InputError if too few places are suitable.
    """
    focal = width / 2 / math.tan(math.radians(FIELD_OF_VIEW / 2))
    K = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    means = scene.gaussians.means.cpu()
    distances = (means - bounds.center.cpu()).norm(dim=1)
    worth = torch.where(distances <= 2 * bounds.radius, bounds.weights.cpu(), 0.0).double()
    up = bounds.up.cpu()
    side = _perpendicular(up)
    ahead = torch.linalg.cross(up, side)
    low, high = (math.sin(math.radians(angle)) for angle in ELEVATIONS)

    def somewhere(nearest: float, farthest: float) -> Float[Tensor, "3"]:
        radius, turn, rise = torch.rand(3, generator=generator).tolist()
        distance = bounds.radius * nearest * (farthest / nearest) ** radius
        sine = low + (high - low) * rise  # uniform on the sphere
        flat = math.cos(math.tau * turn) * side + math.sin(math.tau * turn) * ahead
        return bounds.center.cpu() + distance * (math.sqrt(1 - sine * sine) * flat + sine * up)

    nearest = min(
        max(RADII[0], focal / width / DETAIL * bounds.detail / bounds.radius), DETAIL_RADII
    )
    around = [_coverage_around(scene, somewhere(0.2, 1.0), bounds) for _ in range(INSIDE_PROBES)]
    inside = sorted(around)[INSIDE_PROBES // 2] > ENCLOSED_COVERAGE
    reach = RADII_INSIDE if inside else (nearest, RADII[1])
    cameras: list[Camera] = []
    for _ in range(TRIES * count):
        eye, target = somewhere(*reach), bounds.center.cpu()
        if float(torch.rand(1, generator=generator)) < TARGETS_ANYWHERE:
            target = means[int(torch.multinomial(worth, 1, generator=generator))]
        if (target - eye).norm() < 0.25 * bounds.radius:
            continue
        viewmat = look_at(eye, target, up)
        if not viewmat.isfinite().all():
            continue
        camera = Camera(viewmat, K, width, height, NEAR * bounds.radius)
        good = _is_good_view(scene, camera, float((target - eye).norm()))
        if good and not (inside and _coverage_around(scene, eye, bounds) < ENCLOSED_COVERAGE):
            cameras.append(camera)
            progress(len(cameras), count)
            if len(cameras) == count:
                return cameras
    raise InputError(
        f"only {len(cameras)} of {TRIES * count} random places show this scene, and {count} are "
        "needed: give the photos that it was made from (--capture), or to compress it their "
        "cameras (--cameras cameras.json)"
    )


def _is_good_view(scene: Scene, camera: Camera, distance: float) -> bool:
    """Return whether a camera sees its target, `distance` ahead, with a clear view."""
    height = max(1, round(TEST_WIDTH * camera.height / camera.width))
    small = camera.resized(TEST_WIDTH, height)
    drawn = scene.render(small.to(scene.gaussians.means.device), depth=True)
    assert drawn.depth is not None
    alpha = drawn.alpha.flatten()
    if float(alpha.mean()) < COVERED_MIN:
        return False
    depth = torch.where(alpha > 0.5, drawn.depth.flatten() / alpha.clamp_min(1e-6), math.inf)
    if float((depth < CLOSE_RATIO * distance).float().mean()) > CLOSE_PIXELS_MAX:
        return False
    row, column = small.height // 2, small.width // 2
    middle = depth.reshape(small.height, -1)[row - 2 : row + 2, column - 2 : column + 2]
    return float(middle.median()) >= OCCLUDED_RATIO * distance


def _coverage_around(scene: Scene, eye: Float[Tensor, "3"], bounds: SceneBounds) -> float:
    """Return the mean alpha all around `eye`, from the horizon to 27 degrees above it.

    Surfaces nearer than `WALL_RADII` do not count: a place in a bush is not inside a scene.
    """
    up, half = bounds.up.cpu(), TEST_WIDTH / 4
    K = torch.tensor([[half, 0, half], [0, half, half], [0, 0, 1]])
    ahead = _perpendicular(up)
    covered = 0.0
    for _ in range(4):
        ahead = torch.linalg.cross(up, ahead)
        camera = Camera(
            look_at(eye, eye + ahead, up), K, TEST_WIDTH // 2, TEST_WIDTH // 2, NEAR * bounds.radius
        )
        drawn = scene.render(camera.to(scene.gaussians.means.device), depth=True)
        assert drawn.depth is not None
        alpha, depth = (
            part[TEST_WIDTH // 8 : TEST_WIDTH // 4] for part in (drawn.alpha, drawn.depth)
        )
        far = depth > WALL_RADII * bounds.radius * alpha  # depth is weighted by alpha
        covered += float((alpha * far).mean()) / 4
    return covered


def _perpendicular(axis: Float[Tensor, "3"]) -> Float[Tensor, "3"]:
    other = torch.eye(3)[int(axis.abs().argmin())]
    return torch.nn.functional.normalize(torch.linalg.cross(axis, other), dim=0)


def interpolate_cameras(
    given: list[Camera], bounds: SceneBounds, count: int, *, size: int, generator: torch.Generator
) -> list[Camera]:
    """Return `count` cameras: the given ones, then ones interpolated between two neighbours.

    Interpolated cameras also turn at random, by a standard deviation of `TURN_STD` degrees. `size`
    is the longer side of every image in pixels. If there are more than `count` given
    cameras, the result is an even selection of them.
    """
    near = NEAR * bounds.radius
    sized = [
        replace(camera.scaled(size / max(camera.width, camera.height)), near=near)
        for camera in given
    ]
    if len(sized) > count:
        chosen = torch.linspace(0, len(sized) - 1, count).round().long().tolist()
        return [sized[i] for i in chosen]
    eyes = torch.stack([camera.position for camera in sized])
    apart = torch.cdist(eyes, eyes)
    cameras = list(sized)
    while len(cameras) < count:
        first = int(torch.randint(len(sized), (1,), generator=generator))
        nearest = apart[first].argsort()[: NEIGHBOURS + 1]
        second = int(nearest[torch.randint(len(nearest), (1,), generator=generator)])
        share = float(torch.rand(1, generator=generator))
        turn = math.radians(TURN_STD) * torch.randn(3, generator=generator, dtype=torch.float64)
        cameras.append(sized[first].interpolate(sized[second], share, turn=turn))
    return cameras
