"""Where to photograph a scene from, so that what was learned there holds wherever one looks."""

import math
from collections.abc import Callable

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera, look_at
from mobilegs.errors import InputError
from mobilegs.render.scene import Scene
from mobilegs.synthetic_capture.scene_bounds import Layout

FIELD_OF_VIEW = 60  # degrees, across
RADII = (0.6, 6.0)  # distances from the middle, in radii of the scene
# of a picture's width: where the usual Gaussian is as wide (standard deviation), detail ends, and
# nearer to the middle nobody stands, unless that is more than so many radii away
DETAIL = 1 / 500
DETAIL_RADII = 2.0
RADII_WITHIN = (0.2, 1.5)  # the same where the scene is all around
ELEVATIONS = (-4.0, 62.0)  # degrees above the horizon
TRIAL = 64  # pixels across, of the picture that tells whether a place is good
COVERED = 0.2  # of such a picture, at least
CLEAR = 0.3  # of the way to what is looked at, nothing may be nearer ...
STRAYS = 0.02  # ... but in this share of pixels
OCCLUDED = 0.6  # of the way to what is looked at: nearer things hide it
TRIES = 60  # for each camera that is wanted
ENCLOSED = 0.6  # of what one sees all around, from which on one is within a scene
ROOM = 0.5  # radii of the scene, from which on what is all around are walls
WITHIN = 16  # places near the middle that tell whether the scene has an inside
NEIGHBOURS = 4  # given cameras that one in between may lie towards
WOBBLE = 4.0  # degrees, standard deviation of a turn away from a blended direction
NEAR = 0.02  # near plane, in radii of the scene
ANYWHERE = 0.7  # of all cameras look at any part of the scene, the others at its middle

Progress = Callable[[int, int], None]


@torch.inference_mode()
def place_cameras(
    scene: Scene,
    layout: Layout,
    count: int,
    *,
    width: int,
    height: int,
    generator: torch.Generator,
    progress: Progress = lambda done, total: None,
) -> list[Camera]:
    """Cameras around the middle of a scene, which look at its middle or at any part of it.

    Places are drawn at random, as much near as far, from about the horizon upwards, and from the
    distance on at which the scene is not yet a blur. One is taken
    if a small picture from there shows enough of the scene, nothing close in the way, and what it
    looks at not hidden: that keeps cameras out of things. Where most places near the middle have
    the scene all around, it was seen from within, and cameras stay within.

    Raises InputError if hardly any place will do.
    """
    focal = width / 2 / math.tan(math.radians(FIELD_OF_VIEW / 2))
    K = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    means = scene.gaussians.means.cpu()
    distances = (means - layout.center.cpu()).norm(dim=1)
    worth = torch.where(distances <= 2 * layout.radius, layout.weights.cpu(), 0.0).double()
    up = layout.up.cpu()
    side = _perpendicular(up)
    ahead = torch.linalg.cross(up, side)
    low, high = (math.sin(math.radians(angle)) for angle in ELEVATIONS)

    def somewhere(nearest: float, farthest: float) -> Float[Tensor, "3"]:
        radius, turn, rise = torch.rand(3, generator=generator).tolist()
        distance = layout.radius * nearest * (farthest / nearest) ** radius
        sine = low + (high - low) * rise  # as much of the sphere everywhere
        flat = math.cos(math.tau * turn) * side + math.sin(math.tau * turn) * ahead
        return layout.center.cpu() + distance * (math.sqrt(1 - sine * sine) * flat + sine * up)

    nearest = min(
        max(RADII[0], focal / width / DETAIL * layout.detail / layout.radius), DETAIL_RADII
    )
    around = [_around(scene, somewhere(0.2, 1.0), layout) for _ in range(WITHIN)]
    inside = sorted(around)[WITHIN // 2] > ENCLOSED
    reach = RADII_WITHIN if inside else (nearest, RADII[1])
    found: list[Camera] = []
    for _ in range(TRIES * count):
        eye, target = somewhere(*reach), layout.center.cpu()
        if float(torch.rand(1, generator=generator)) < ANYWHERE:
            target = means[int(torch.multinomial(worth, 1, generator=generator))]
        if (target - eye).norm() < 0.25 * layout.radius:
            continue
        viewmat = look_at(eye, target, up)
        if not viewmat.isfinite().all():
            continue
        camera = Camera(viewmat, K, width, height, NEAR * layout.radius)
        good = _good(scene, camera, float((target - eye).norm()))
        if good and not (inside and _around(scene, eye, layout) < ENCLOSED):
            found.append(camera)
            progress(len(found), count)
            if len(found) == count:
                return found
    raise InputError(
        f"of {TRIES * count} places only {len(found)} show this scene, where {count} are wanted: "
        "give the photos that it was made from (--capture), or if it is to be compressed their "
        "cameras (--cameras cameras.json)"
    )


def _good(scene: Scene, camera: Camera, distance: float) -> bool:
    """Whether one would want to look from there at what is `distance` ahead."""
    small = camera.resized(TRIAL, max(1, round(TRIAL * camera.height / camera.width)))
    drawn = scene.render(small.to(scene.gaussians.means.device), depth=True)
    assert drawn.depth is not None
    alpha = drawn.alpha.flatten()
    if float(alpha.mean()) < COVERED:
        return False
    depth = torch.where(alpha > 0.5, drawn.depth.flatten() / alpha.clamp_min(1e-6), math.inf)
    if float((depth < CLEAR * distance).float().mean()) > STRAYS:
        return False
    row, column = small.height // 2, small.width // 2
    middle = depth.reshape(small.height, -1)[row - 2 : row + 2, column - 2 : column + 2]
    return float(middle.median()) >= OCCLUDED * distance


def _around(scene: Scene, eye: Float[Tensor, "3"], layout: Layout) -> float:
    """How much of what one sees there is covered, all around from the horizon to 27 degrees up.

    What is close to the eye, as within a bush, does not count.
    """
    up, half = layout.up.cpu(), TRIAL / 4
    K = torch.tensor([[half, 0, half], [0, half, half], [0, 0, 1]])
    ahead = _perpendicular(up)
    covered = 0.0
    for _ in range(4):
        ahead = torch.linalg.cross(up, ahead)
        camera = Camera(
            look_at(eye, eye + ahead, up), K, TRIAL // 2, TRIAL // 2, NEAR * layout.radius
        )
        drawn = scene.render(camera.to(scene.gaussians.means.device), depth=True)
        assert drawn.depth is not None
        alpha, depth = (part[TRIAL // 8 : TRIAL // 4] for part in (drawn.alpha, drawn.depth))
        far = depth > ROOM * layout.radius * alpha  # a mean depth: what is nearer is a thing
        covered += float((alpha * far).mean()) / 4
    return covered


def _perpendicular(axis: Float[Tensor, "3"]) -> Float[Tensor, "3"]:
    other = torch.eye(3)[int(axis.abs().argmin())]
    return torch.nn.functional.normalize(torch.linalg.cross(axis, other), dim=0)


def between_cameras(
    given: list[Camera], layout: Layout, count: int, *, size: int, generator: torch.Generator
) -> list[Camera]:
    """Cameras among given ones, which come first: each lies between two neighbours, and turns
    a little away from the direction in between.

    `size` is the longer side of their pictures in pixels; those of the given cameras are as large.
    """
    sized = [_sized(camera, size, NEAR * layout.radius) for camera in given]
    if len(sized) > count:
        chosen = torch.linspace(0, len(sized) - 1, count).round().long().tolist()
        return [sized[i] for i in chosen]
    eyes = torch.stack([camera.position for camera in sized])
    apart = torch.cdist(eyes, eyes)
    found = list(sized)
    while len(found) < count:
        first = int(torch.randint(len(sized), (1,), generator=generator))
        nearest = apart[first].argsort()[: NEIGHBOURS + 1]
        second = int(nearest[torch.randint(len(nearest), (1,), generator=generator)])
        found.append(_blended(sized[first], sized[second], generator))
    return found


def _sized(camera: Camera, size: int, near: float) -> Camera:
    factor = size / max(camera.width, camera.height)
    sides = (max(1, round(factor * side)) for side in (camera.width, camera.height))
    resized = camera.resized(*sides)
    return Camera(resized.viewmat, resized.K, resized.width, resized.height, near)


def _blended(one: Camera, other: Camera, generator: torch.Generator) -> Camera:
    share = float(torch.rand(1, generator=generator))
    wobble = math.radians(WOBBLE) * torch.randn(3, generator=generator, dtype=torch.float64)
    return one.interpolate(other, share, turn=wobble)
