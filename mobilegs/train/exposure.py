"""Exposure and white balance of single photos: an affine change of colours for each of them.

The scene learns colours that all photos share. A render becomes `image @ A.T + b` before it is
compared with photo i, with A `[3, 3]` and b `[3]` of that photo. The changes start as gains that
explain the different colours of the same points in different photos, and learn with the scene. The
gain that a photo shares with its neighbours stays in the scene: light that changes slowly with the
direction is a property of its surfaces. After every step the changes are moved so that their mean
over all photos is no change: the scene takes no tint. They are dropped when training ends.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import MIN_SIDE
from mobilegs.data import images
from mobilegs.data.dataset import Frame, View, load_view
from mobilegs.render.scene import Scene
from mobilegs.train.optim import NamedAdam, exponential_lr
from mobilegs.validation import check_choice

When = Literal["auto", "always", "never"]
POINTS = 8192  # whose colours are compared between photos
IMAGE_SIDE = 300  # pixels of the longer side of images in which they are looked up
DEPTH_TOLERANCE = 0.05  # relative difference of depth between a point and the surface
COLOR_RANGE = (0.02, 0.98)  # of colours that are compared: others are clipped, or too dark
SRGB_OFFSET = 0.055  # added to an sRGB colour, it makes it proportional to a power of the light
ITERATIONS = 8  # of reweighted least squares
RESIDUAL_SCALE = 0.05  # of Geman-McClure's weights, in log2: larger residuals count less
PRIOR_WEIGHT = 1e-3  # of the first guess; an observation has weight 1
SRGB_EXPONENT = 1 / 2.4  # log2 of the gain for twice the light
# Spread of the photos' gains from which on `auto` learns them: the root mean square over photos and
# channels of log2 of the gain over that of the photo's neighbours.
LEAST_SPREAD = 0.12
# Share of the differences between photos at half of the points that the gains from the other half
# must explain. It is at most 0.003 for renders, also where points are taken for visible that are
# not, and 0.14 for photos of a phone outdoors.
LEAST_EXPLAINED = 0.02
# time of the teacher at which this is decided and learning begins; it must not follow a reset of
# opacities (the student begins in its first step)
START = 0.18
LR, LR_END = 1e-3, 1e-4  # learning rate at the start and at the end; it falls geometrically
PENALTY_WEIGHT = 0.01  # of the squared distance to no change, in the loss
NEIGHBOURS = 16  # nearest photos, whose mean gain is left to the scene


@dataclass(frozen=True)
class ExposureConfig:
    """Learned exposure and white balance of each training photo."""

    learned: When = "auto"
    """Learn an affine change of colours for each photo: `always`, `never`, or `auto`, if the photos
    differ from their neighbours (`LEAST_SPREAD`)."""
    vignetting: bool = False
    """Also learn a falloff of brightness to the corners, one for all photos."""

    def __post_init__(self) -> None:
        check_choice("learned", self.learned, When)


class Exposures:
    """The changes of colours of all training photos, and the Adam that learns them."""

    def __init__(self, config: ExposureConfig, gains: Float[Tensor, "photos 3"]) -> None:
        """Begin with gains of the photos, as log2."""
        self.config = config
        self.same = torch.eye(3, 4, device=gains.device)
        factors = gains.exp2()
        offsets = SRGB_OFFSET * (factors - 1)
        changes = torch.cat([torch.diag_embed(factors), offsets[:, :, None]], dim=2)
        tensors = {"changes": changes - changes.mean(0) + self.same}
        if config.vignetting:
            tensors["falloff"] = gains.new_zeros(2)
        self.adam = NamedAdam(tensors, dict.fromkeys(tensors, LR))

    @property
    def leaves(self) -> list[Tensor]:
        """All that is learned."""
        return list(self.adam.tensors.values())

    @property
    def changes(self) -> Float[Tensor, "photos 3 4"]:
        """`(A | b)` of each photo."""
        return self.adam.tensors["changes"]

    def apply(self, index: int, image: Float[Tensor, "h w 3"]) -> Float[Tensor, "h w 3"]:
        """Return a render with the colours of photo `index`."""
        if self.config.vignetting:
            image = image * vignette(self.adam.tensors["falloff"], image)
        change = self.changes[index]
        return image @ change[:, :3].T + change[:, 3]

    def penalty(self, index: int) -> Float[Tensor, ""]:
        """Return the term of the loss that keeps the change of photo `index` small."""
        return PENALTY_WEIGHT * (self.changes[index] - self.same).square().sum()

    @torch.no_grad()
    def step(self, time: float) -> None:
        """Take an Adam step with the gradients; `time` is 0 to 1."""
        for name in self.adam.tensors:
            self.adam.set_lr(name, exponential_lr(LR, LR_END, time))
        self.adam.step()
        self.changes.sub_(self.changes.mean(0) - self.same)

    def state(self) -> dict:
        """Return everything that later steps depend on."""
        return self.adam.state()

    @classmethod
    def restored(cls, config: ExposureConfig, state: dict, device: torch.device) -> "Exposures":
        """Return the exposures whose `state()` is given."""
        exposures = cls(config, torch.zeros(len(state["changes"]["value"]), 3, device=device))
        exposures.adam.restore(state)
        return exposures


def exposures_for(
    config: ExposureConfig, scene: Scene, frames: Sequence[Frame]
) -> tuple[Exposures | None, float | None]:
    """Return the exposures of photos to begin with, and the spread of the photos.

    The first is None if they are not learned, the second if it was not measured. The spread is 0
    unless something shows that the photos differ: their EXIF, or gains from half of the points
    that explain differences at the other half. `scene` holds the colours that all photos share.
    """
    if config.learned == "never":
        return None, None
    eyes = torch.stack([frame.camera.position for frame in frames])
    distances = torch.cdist(eyes, eyes).fill_diagonal_(torch.inf)
    nearest = distances.argsort(dim=1, stable=True)[:, : min(NEIGHBOURS, max(1, len(frames) - 1))]

    def beside_neighbours(gains: Float[Tensor, "photos c"]) -> Float[Tensor, "photos c"]:
        return gains - gains[nearest.to(gains.device)].mean(1)

    told = exposure_gains(frames)
    colors, shown = shared_colors(scene, frames)
    first, second = (
        beside_neighbours(solve_gains(colors[i::2], shown[i::2], told)) for i in range(2)
    )
    gains = (first + second) / 2
    noise = (first - second).square().mean() / 4  # of the mean of both
    spread = math.sqrt(max(0.0, float(gains.square().mean() - noise)))
    if told is None or beside_neighbours(told[:, None]).square().mean() <= LEAST_SPREAD**2:
        halves = [(colors[1::2], shown[1::2], first), (colors[::2], shown[::2], second)]
        before = sum(_misfit(colors, shown) for colors, shown, _ in halves)
        after = sum(_misfit(colors - other, shown) for colors, shown, other in halves)
        spread = spread if before - after >= LEAST_EXPLAINED * before > 0 else 0.0
    if config.learned == "auto" and spread <= LEAST_SPREAD:
        return None, spread
    return Exposures(config, gains), spread


@torch.no_grad()
def shared_colors(
    scene: Scene, frames: Sequence[Frame]
) -> tuple[Float[Tensor, "n photos 3"], Float[Tensor, "n photos"]]:
    """Return log2 of the colours of points in all photos, and 1 for points that they show, else 0.

    The scene gives its geometry only: points, and depths that tell which photos see them.
    """
    means = scene.gaussians.means
    points = means[:: math.ceil(len(means) / POINTS)]
    seen = [_colors_at(points, scene, load_view(frame).to(points.device)) for frame in frames]
    colors, weights = zip(*seen, strict=True)
    return torch.stack(colors, 1), torch.stack(weights, 1)


def exposure_gains(frames: Sequence[Frame]) -> Float[Tensor, "photos"] | None:
    """Return log2 of the gains that follow from the exposures in EXIF, with a mean of 0.

    None unless the exposure of each photo is known.
    """
    known = [exposure_of(frame) for frame in frames]
    exposures = torch.tensor([each for each in known if each is not None])
    if len(exposures) < len(frames):
        return None
    return (exposures - exposures.mean()) * SRGB_EXPONENT


def exposure_of(frame: Frame) -> float | None:
    """Return the exposure of a photo, from its capture or its file."""
    if frame.exposure is not None or frame.image_path is None:
        return frame.exposure
    with images.open_image(frame.image_path) as image:
        return images.exposure_of(image)


def _colors_at(
    points: Float[Tensor, "n 3"], scene: Scene, view: View
) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n"]]:
    """Return log2 of the colours of points in a photo, and 1 for points that it shows, else 0."""
    longer, shorter = sorted((view.camera.width, view.camera.height), reverse=True)
    view = view.reduced(max(1, min(longer // IMAGE_SIDE, shorter // MIN_SIDE)))
    drawn = scene.render(view.camera, depth=True)
    assert drawn.depth is not None
    viewmat, K = view.camera.viewmat, view.camera.K
    inside = points @ viewmat[:3, :3].T + viewmat[:3, 3]
    z = inside[:, 2].clamp_min(view.camera.near)
    x, y = ((inside[:, i] / z * K[i, i] + K[i, 2]).floor().long() for i in range(2))
    shown = (inside[:, 2] > view.camera.near) & (x >= 0) & (x < view.camera.width)
    shown &= (y >= 0) & (y < view.camera.height)
    x, y = torch.where(shown, x, 0), torch.where(shown, y, 0)
    surface = drawn.depth[y, x] / drawn.alpha[y, x].clamp_min(1e-6)
    shown &= (drawn.alpha[y, x] > 0.5) & ((z - surface).abs() < DEPTH_TOLERANCE * surface)
    color = view.image[y, x]
    shown &= (color > COLOR_RANGE[0]).all(1) & (color < COLOR_RANGE[1]).all(1)
    if view.mask is not None:
        shown &= view.mask[y, x] > 0.5
    return (color + SRGB_OFFSET).log2(), shown.float()


def solve_gains(
    colors: Float[Tensor, "n photos 3"],
    weights: Float[Tensor, "n photos"],
    guess: Float[Tensor, "photos"] | None = None,
) -> Float[Tensor, "photos 3"]:
    """Return the gains g of photos that best explain colours of points: `colors = g + a`.

    Each point has a colour a of its own. Least squares, reweighted so that observations far from
    the rest count little (Geman-McClure); `weights` are 0 where a photo does not show a point.
    `guess`, 0 if it is None, is a prior of the gains with a small weight.
    """
    gains = colors.new_zeros(colors.shape[1:]).double()
    eye = torch.eye(len(gains), dtype=gains.dtype, device=gains.device)
    prior = gains if guess is None else guess.to(gains)[:, None].expand_as(gains)
    colors, visible = colors.double(), weights.double()
    weights = visible
    for _ in range(ITERATIONS):
        own = _weighted_mean(colors, weights)
        # normal equations of the gains, without the points' colours
        each = weights.sum(1).clamp_min(1e-9)
        matrix = torch.diag(weights.sum(0)) - weights.T @ (weights / each[:, None])
        right = (weights[:, :, None] * (colors - own)).sum(0)
        gains = torch.linalg.solve(matrix + PRIOR_WEIGHT * eye, right + PRIOR_WEIGHT * prior)
        left = colors - gains
        left = left - _weighted_mean(left, weights)
        weights = visible / (1 + left.square().mean(2) / RESIDUAL_SCALE**2).square()
    return gains.float()


def _misfit(colors: Float[Tensor, "n photos 3"], weights: Float[Tensor, "n photos"]) -> float:
    """Return the sum of Geman-McClure's measure, 0 to 1, of each difference from a point's mean."""
    colors, visible = colors.double(), weights.double()
    squares = torch.zeros_like(visible)
    for _ in range(ITERATIONS):
        robust = visible / (1 + squares).square()
        squares = (colors - _weighted_mean(colors, robust)).square().mean(2) / RESIDUAL_SCALE**2
    return float((visible * squares / (1 + squares)).sum())


def _weighted_mean(
    values: Float[Tensor, "n photos 3"], weights: Float[Tensor, "n photos"]
) -> Float[Tensor, "n 1 3"]:
    total = weights.sum(1).clamp_min(1e-9)
    return ((weights[:, :, None] * values).sum(1) / total[:, None])[:, None]


def vignette(falloff: Float[Tensor, "2"], image: Float[Tensor, "h w 3"]) -> Float[Tensor, "h w 1"]:
    """Return the brightness `1 + a r^2 + b r^4`, where r is 0 in the middle and 1 in the corners.

    `falloff` is (a, b).
    """
    height, width = image.shape[:2]
    y, x = (
        (torch.arange(n, device=image.device, dtype=image.dtype) + 0.5) * 2 / n - 1
        for n in (height, width)
    )
    squares = (x.square() * width**2 + y.square()[:, None] * height**2) / (width**2 + height**2)
    return (1 + falloff[0] * squares + falloff[1] * squares.square())[..., None]
