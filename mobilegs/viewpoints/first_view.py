"""Finds the first view of a captured scene, and the limits within which photos show it.

Both follow from depth images of the training cameras: a point is *seen* if it lies in the picture
of a training camera and not behind its surface. The *subject* is what most cameras have in the
middle of their pictures.
"""

import math
from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Bool, Float, Int64
from torch import Tensor
from torch.nn.functional import max_pool2d

from mobilegs.camera import Camera, look_at
from mobilegs.render.scene import Scene
from mobilegs.viewpoints.framing import SECTORS, Framing, Limits, Start, direction_of

VIEWS_MAX = 48  # training cameras that are used
NEAR_VIEWS = 6  # of them, which are asked first whether they see a point
SIDE = 96  # pixels of the longer side of depth images
SEEN_DEPTH_RATIO = 1.05  # of the depth of a seen point to that of the surface, at most
EMPTY_SHARE = 0.2  # of pixels without a surface, above which an object has no surroundings
SOLID_ALPHA = 0.5  # above which a pixel has a surface
MIDDLE_RADIUS = 0.7  # of a picture's middle, as a share of half the picture
POINTS = 6000  # of surfaces, from which those of the subject are chosen
# Ratio of the subject's greatest depth to that of the nearest quarter of a picture's middle.
SUBJECT_DEPTH_RATIO = 1.5
# Share of cameras that have a point of the subject in the middle: the least for the best point, and
# the least ratio of another point's share to that of the best.
LOOKING_MIN, LOOKING_RATIO = 0.15, 0.6
CANDIDATES = 12  # training cameras from which the first view may be
DISTANCE_RATIOS = (1.0, 1.2)  # of the distance to the subject to that camera's
BOX_RATIOS = (0.55, 0.7, 0.9, 1.1, 1.3, 1.5, 1.8)  # of the picture's box to the subject's
BOX_RATIO_BEST = 1.5  # where everything was seen
SHAPES = {"start": (1.33, 2.16), "portrait": (0.46, 0.75)}  # width over height of screens
BOX_SHARE = 0.98  # of the subject's points that its box holds, on each axis
UNSEEN_START_MAX = 0.02  # share of a first view that no camera saw; more lowers its score
ELEVATION_STEP = 8  # degrees between pictures in which limits are tested
CAMERA_ANGLE_MAX = 24.0  # degrees between a tested direction from the subject and a camera's
FARTHEST_RATIO = 1.1  # of the greatest distance to the median one of cameras
UNSEEN_LIMITS_MAX = 0.12  # share of a picture at the limits that no camera saw
NEAREST_RATIO = 0.25  # of the least distance to the least one of cameras


class Coverage:
    """The surfaces that training cameras see, as depth images."""

    def __init__(self, scene: Scene, views: Sequence[Camera]) -> None:
        """Render the depth of some of the views, at least one."""
        device = scene.gaussians.means.device
        step = max(1, len(views) / VIEWS_MAX)
        chosen = [views[int(i * step)] for i in range(min(len(views), VIEWS_MAX))]
        self.scene = scene
        self.cameras = [
            view.scaled(SIDE / max(view.width, view.height), 8).to(device) for view in chosen
        ]
        drawn = [depth_of(scene, camera) for camera in self.cameras]
        self.depths = [depth for depth, _ in drawn]
        # an object without surroundings: there is nothing to see past it
        empty = torch.stack([~solid for _, solid in drawn]).float().mean()
        self.isolated = bool(empty > EMPTY_SHARE)
        self.viewmats = torch.stack([camera.viewmat for camera in self.cameras])
        self.eyes = torch.stack([camera.position for camera in self.cameras])
        self.K = torch.stack([camera.K for camera in self.cameras])
        sizes = [(camera.width, camera.height) for camera in self.cameras]
        self.sizes = torch.tensor(sizes, device=device)
        width, height = self.sizes.amax(0).tolist()
        # edges of surfaces are not exact at this size: the greatest depth of the neighbours counts
        self.reach = torch.zeros(len(sizes), height, width, device=device)
        for reach, depth in zip(self.reach, self.depths, strict=True):
            reach[: len(depth), : depth.shape[1]] = max_pool2d(depth[None, None], 3, 1, 1)[0, 0]

    def seen(
        self,
        points: Float[Tensor, "n 3"],
        *,
        radius: float = math.inf,
        front: Float[Tensor, "cameras"] | None = None,
        numbers: Int64[Tensor, "cameras"] | None = None,
    ) -> Bool[Tensor, "cameras n"]:
        """Return which points each camera sees, or each of those with these `numbers`.

        They lie within a radius around the middle of its picture (1 is its edge), and less deep
        than its `front`.
        """
        if numbers is None:
            numbers = torch.arange(len(self.sizes), device=points.device)
        viewmats, K = self.viewmats[numbers], self.K[numbers]
        # [cameras, 3, n]: long rows are faster on a CPU than points of three numbers
        local = viewmats[:, :3, :3].reshape(-1, 3) @ points.T
        local = local.reshape(len(numbers), 3, len(points)) + viewmats[:, :3, 3:]
        z = local[:, 2]
        place = local[:, :2] / z[:, None] * K.diagonal(dim1=1, dim2=2)[:, :2, None] + K[:, :2, 2:]
        across = 2 * place / self.sizes[numbers, :, None] - 1
        seen = (z > self.scene.near) & (across.abs() < 1).all(1)
        seen &= across.square().sum(1) < radius * radius
        if front is not None:
            seen &= z < front[:, None]
        column, row = torch.where(seen[:, None], place, 0.0).long().unbind(1)
        return seen & (z < SEEN_DEPTH_RATIO * self.reach[numbers[:, None], row, column])

    def unseen(self, camera: Camera) -> Bool[Tensor, "h w"]:
        """Return the pixels of a camera whose surface no training camera sees.

        A pixel without a surface counts as seen if a training camera looks past all surfaces in
        that direction, and everywhere around an object without surroundings.
        """
        depth, solid = depth_of(self.scene, camera)
        points = unprojected(camera, depth).reshape(-1, 3)
        numbers = (self.eyes - camera.position).norm(dim=1).argsort(stable=True)
        seen = self.seen(points, numbers=numbers[:NEAR_VIEWS]).any(0)
        (left,) = torch.where(~seen)
        seen[left] = self.seen(points[left], numbers=numbers[NEAR_VIEWS:]).any(0)
        unseen = ~seen.reshape(depth.shape)
        return unseen & solid if self.isolated else unseen


def depth_of(scene: Scene, camera: Camera) -> tuple[Float[Tensor, "h w"], Bool[Tensor, "h w"]]:
    """Return the depth of the surfaces in a picture, and where there are any.

    Elsewhere the depth is a million near planes.
    """
    drawn = scene.render(camera, depth=True)
    assert drawn.depth is not None
    solid = drawn.alpha > SOLID_ALPHA
    return torch.where(solid, drawn.depth / drawn.alpha.clamp_min(1e-6), 1e6 * camera.near), solid


def unprojected(camera: Camera, depth: Float[Tensor, "h w"]) -> Float[Tensor, "h w 3"]:
    """Return the world point of each pixel at its depth."""
    rows = torch.arange(camera.height, device=depth.device) + 0.5
    columns = torch.arange(camera.width, device=depth.device) + 0.5
    K = camera.K
    x = (columns - K[0, 2]) / K[0, 0] * depth
    y = ((rows - K[1, 2]) / K[1, 1])[:, None] * depth
    local = torch.stack([x, y, depth], dim=-1)
    return (local - camera.viewmat[:3, 3]) @ camera.viewmat[:3, :3]


@torch.no_grad()
def find_framing(scene: Scene, views: Sequence[Camera]) -> Framing:
    """Return first views and limits of a scene that was trained with `views`.

    Without views, without an upward direction, or where cameras look at nothing in common, the
    framing tells nothing: viewers then show the first of the views.
    """
    if not views or scene.up is None or not len(scene.gaussians):
        return Framing()
    coverage = Coverage(scene, views)
    subject = find_subject(coverage)
    if subject is None:
        return Framing()
    pivot = subject.median(0).values
    starts = {
        name: _best_start(coverage, subject, pivot, shapes) for name, shapes in SHAPES.items()
    }
    wide = _find_limits(coverage, pivot, views, starts["start"], _tangents(views[0]))
    tall = _shown(starts["portrait"].box, 1.0, SHAPES["portrait"][0])
    high = _find_limits(coverage, pivot, views, starts["portrait"], tall)
    return Framing(starts["start"], starts["portrait"], wide, high)


def find_subject(coverage: Coverage) -> Float[Tensor, "n 3"] | None:
    """Return points of the subject's surface; None if cameras look at nothing in common."""
    points = []
    count = math.ceil(POINTS / len(coverage.cameras))
    for camera, depth in zip(coverage.cameras, coverage.depths, strict=True):
        visible = unprojected(camera, depth)[depth < 1e5 * camera.near]
        points.append(visible[:: max(1, len(visible) // count)])
    surface = torch.cat(points)
    if not len(surface):
        return None
    fronts = []
    for depth in coverage.depths:
        y, x = len(depth) // 4, depth.shape[1] // 4
        fronts.append(SUBJECT_DEPTH_RATIO * depth[y:-y, x:-x].quantile(0.25))
    seen = coverage.seen(surface, radius=MIDDLE_RADIUS, front=torch.stack(fronts))
    looking = seen.float().mean(0)
    most = float(looking.max())
    if most < LOOKING_MIN:
        return None
    return surface[looking >= LOOKING_RATIO * most]


def _best_start(
    coverage: Coverage,
    subject: Float[Tensor, "n 3"],
    pivot: Float[Tensor, "3"],
    shapes: tuple[float, float],
) -> Start:
    """Return the first view for screens of these shapes."""
    up = torch.from_numpy(coverage.scene.up).to(pivot)
    eyes = coverage.eyes
    directions = torch.nn.functional.normalize(eyes - pivot, dim=1)
    heights = directions @ up
    middle, spread = heights.median(), heights.std(unbiased=False).clamp_min(0.05)
    best: tuple[float, Start] | None = None
    for index in _spread_out(eyes, CANDIDATES):
        for factor in DISTANCE_RATIOS:
            eye = pivot + factor * (eyes[index] - pivot)
            if abs(float(torch.nn.functional.normalize(eye - pivot, dim=0) @ up)) > 0.98:
                continue
            target, box = _aimed(eye, pivot, up, subject)
            # one picture that holds those of all shapes and sizes
            side = max(max(box[0], box[1] * shapes[1]), max(box[1], box[0] / shapes[0]))
            whole = BOX_RATIOS[-1] * side
            camera = _camera(eye, target, up, (whole, whole), coverage.scene.near)
            unseen = coverage.unseen(camera.to(pivot.device)).float()
            for ratio in BOX_RATIOS:
                share = max(
                    float(_middle(unseen, _shown(box, ratio, shape), whole).mean())
                    for shape in shapes
                )
                score = (
                    -60 * max(0.0, share - UNSEEN_START_MAX)
                    - share
                    - 0.5 * abs(math.log(ratio / BOX_RATIO_BEST))
                    - 0.5 * abs(math.log(factor))
                    - 0.3 * abs(float((heights[index] - middle) / spread))
                    - 0.6 * float((directions[index] @ directions[0]).clamp(-1, 1).acos()) / math.pi
                )
                if best is None or score > best[0]:
                    grown = (ratio * box[0], ratio * box[1])
                    best = score, Start(_numbers(eye), _numbers(target), grown)
    assert best is not None
    return best[1]


def _find_limits(
    coverage: Coverage,
    pivot: Float[Tensor, "3"],
    views: Sequence[Camera],
    start: Start,
    half: tuple[float, float],
) -> Limits | None:
    """Return limits inside of which cameras saw nearly all of each picture; None without any.

    The distance of the first view `start` is allowed. `half` has the tangents of half the picture.
    """
    up = coverage.scene.up
    assert up is not None
    eyes = torch.stack([view.position.to(pivot) for view in views])
    forwards = torch.stack([view.viewmat[2, :3].to(pivot) for view in views])
    distances = (eyes - pivot).norm(dim=1)
    directions = (eyes - pivot) / distances[:, None]
    targets = eyes + forwards * ((pivot - eyes) * forwards).sum(1, keepdim=True).clamp_min(0)
    pan = float((targets - pivot).norm(dim=1).quantile(0.75))
    reach = float(np.linalg.norm(start.eye - start.target))
    farthest = max(reach, FARTHEST_RATIO * float(distances.median()))
    elevations = np.tile([90.0, -90.0], (SECTORS, 1))
    angles = np.arange(-80, 81, ELEVATION_STEP)
    for sector in range(SECTORS):
        azimuth = 360 * (sector + 0.5) / SECTORS
        shown = []
        for angle in angles:
            direction = torch.from_numpy(direction_of(azimuth, float(angle), up)).to(pivot)
            near = float((directions @ direction).max()) > math.cos(math.radians(CAMERA_ANGLE_MAX))
            shown.append(near and _is_shown(coverage, pivot, farthest * direction, half))
        if run := _longest_run(shown):
            elevations[sector] = angles[run[0]], angles[run[1]]
    limits = Limits(
        _numbers(pivot), pan, NEAREST_RATIO * float(distances.min()), farthest, elevations
    )
    return limits if any(limits.open) else None


def _is_shown(
    coverage: Coverage,
    pivot: Float[Tensor, "3"],
    away: Float[Tensor, "3"],
    half: tuple[float, float],
) -> bool:
    """Return True if cameras saw nearly all of a picture of the pivot from `pivot + away`."""
    assert coverage.scene.up is not None
    up = torch.from_numpy(coverage.scene.up).to(pivot)
    near = coverage.scene.near
    camera = _camera(pivot + away, pivot, up, half, near, side=SIDE // 2)
    return float(coverage.unseen(camera).float().mean()) <= UNSEEN_LIMITS_MAX


def _longest_run(shown: list[bool]) -> tuple[int, int] | None:
    """Return the first and last index of the longest run of True; None without any."""
    best: tuple[int, int] | None = None
    begin = 0
    for index, each in enumerate([*shown, False]):
        if each:
            continue
        if index > begin and (best is None or index - begin > best[1] - best[0] + 1):
            best = begin, index - 1
        begin = index + 1
    return best


def _spread_out(points: Float[Tensor, "n 3"], count: int) -> list[int]:
    """Return indices of points that lie far from each other, the first one included."""
    chosen = [0]
    distances = (points - points[0]).norm(dim=1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(distances.argmax()))
        distances = torch.minimum(distances, (points - points[chosen[-1]]).norm(dim=1))
    return chosen


def _aimed(
    eye: Float[Tensor, "3"],
    pivot: Float[Tensor, "3"],
    up: Float[Tensor, "3"],
    points: Float[Tensor, "n 3"],
) -> tuple[Float[Tensor, "3"], tuple[float, float]]:
    """Return a target that has the points in the middle of the picture, and their box."""
    viewmat = look_at(eye, pivot, up)
    low, high = _ends(viewmat, points)
    middle = torch.cat([(low + high) / 2, low.new_ones(1)])
    target = eye + (pivot - eye).norm() * (viewmat[:3, :3].T @ middle)
    low, high = _ends(look_at(eye, target, up), points)
    x, y = torch.maximum(-low, high).clamp_min(0.02).tolist()
    return target, (x, y)


def _ends(
    viewmat: Float[Tensor, "4 4"], points: Float[Tensor, "n 3"]
) -> tuple[Float[Tensor, "2"], Float[Tensor, "2"]]:
    """Return the least and greatest tangents of most points to the right and downwards."""
    local = points @ viewmat[:3, :3].T + viewmat[:3, 3]
    slopes = local[:, :2] / local[:, 2:].clamp_min(1e-6)
    least = (1 - BOX_SHARE) / 2
    return slopes.quantile(least, dim=0), slopes.quantile(1 - least, dim=0)


def _shown(box: tuple[float, float], ratio: float, shape: float) -> tuple[float, float]:
    """Return the tangents of half the picture in which a screen of a shape shows the box."""
    half = ratio * max(box[1], box[0] / shape)
    return half * shape, half


def _middle(
    picture: Float[Tensor, "h w"], half: tuple[float, float], whole: float
) -> Float[Tensor, "y x"]:
    """Return the middle of a square picture whose half side has the tangent `whole`."""
    side = len(picture)
    x, y = (max(1, round(side / 2 * min(1.0, part / whole))) for part in half)
    return picture[side // 2 - y : side // 2 + y, side // 2 - x : side // 2 + x]


def _tangents(view: Camera) -> tuple[float, float]:
    return view.width / (2 * float(view.K[0, 0])), view.height / (2 * float(view.K[1, 1]))


def _camera(
    eye: Float[Tensor, "3"],
    target: Float[Tensor, "3"],
    up: Float[Tensor, "3"],
    half: tuple[float, float],
    near: float,
    *,
    side: int = SIDE,
) -> Camera:
    """Return a small camera whose half picture has these tangents."""
    longer = max(half)
    width, height = (max(8, 2 * round(side / 2 * part / longer)) for part in half)
    x, y = width / (2 * half[0]), height / (2 * half[1])
    K = torch.tensor([[x, 0, width / 2], [0, y, height / 2], [0, 0, 1]]).to(eye)
    return Camera(look_at(eye, target, up), K, width, height, near)


def _numbers(points: Tensor) -> np.ndarray:
    return points.double().cpu().numpy()
