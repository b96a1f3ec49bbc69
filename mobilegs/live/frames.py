"""What an onlooker sees of a training: pictures, depths, and what is wrong with them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import interpolate, normalize

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, View
from mobilegs.evaluate.metrics import as_displayed, psnr
from mobilegs.render.scene import Scene

WRONG = 0.25  # mean difference of the channels from which on an error has the last colour
COVERED = 0.5  # pixels of less alpha have no depth
AROUND = 0.09  # grey around what does not fill the canvas
GAP = 6  # pixels between pictures side by side
# from small to large: black, purple, red, orange, light yellow; even steps of lightness
COLORS = (
    (0.0, 0.0, 0.02), (0.34, 0.06, 0.43), (0.73, 0.21, 0.33), (0.98, 0.55, 0.04), (0.99, 1.0, 0.64)
)  # fmt: skip

Image = Float[Tensor, "h w 3"]


@dataclass(frozen=True)
class Eye:
    """Where a browser looks from, and the size of its canvas in pixels.

    `rotation` is camera-to-world, row by row, OpenCV axes; `fov` the vertical angle, radians.
    """

    position: tuple[float, float, float]
    rotation: tuple[float, ...]
    fov: float
    width: int
    height: int

    @property
    def usable(self) -> bool:
        """Whether a picture can be drawn from here."""
        numbers = (*self.position, *self.rotation, self.fov)
        sizes = self.width > 0 and self.height > 0
        return sizes and all(map(math.isfinite, numbers)) and 0 < self.fov < math.pi

    def camera(self, width: int, height: int, near: float) -> Camera:
        """The camera of a picture of this many pixels."""
        turn = torch.tensor(self.rotation, dtype=torch.float64).reshape(3, 3).T
        viewmat = torch.eye(4, dtype=torch.float64)
        viewmat[:3, :3] = turn
        viewmat[:3, 3] = -turn @ torch.tensor(self.position, dtype=torch.float64)
        focal = height / (2 * math.tan(self.fov / 2))
        K = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        return Camera(viewmat.float(), K, width, height, near)


class Viewpoints:
    """The training cameras: which one is near, and where to stand to see what it saw."""

    def __init__(self, dataset: Dataset) -> None:
        """Those that `dataset` trains on, in its order."""
        self.cameras = [frame.camera for frame in dataset.train]
        self.extent = dataset.extent
        mats = torch.stack([camera.viewmat for camera in self.cameras]).double()
        self.positions = torch.stack([camera.position for camera in self.cameras]).double()
        self.forwards = mats[:, 2, :3]
        self._center = dataset.center.double()
        self.up = upward(mats)

    def nearest(self, eye: Eye) -> int:
        """The camera that sees most nearly the same: by its place, and by where it looks."""
        rotation = torch.tensor(eye.rotation, dtype=torch.float64).reshape(3, 3)
        apart = (self.positions - torch.tensor(eye.position, dtype=torch.float64)).norm(dim=1)
        turned = 1 - self.forwards @ rotation[:, 2]  # 0 for the same direction, 2 for the opposite
        return int((apart / self.extent + turned).argmin())

    def stand(self, index: int) -> tuple[Float[Tensor, "3"], Float[Tensor, "3"]]:
        """Where to stand for the view of camera `index`, and what to look at and turn around."""
        position, forward = self.positions[index], self.forwards[index]
        distance = float((self._center - position) @ forward)
        if not distance > 0.05 * self.extent:  # cameras that look outwards, or in parallel
            distance = self.extent
        return position, position + distance * forward

    def fov(self, index: int, aspect: float) -> float:
        """Vertical angle at which a canvas of this aspect shows all that camera `index` sees."""
        camera = self.cameras[index]
        half_width = camera.width / (2 * float(camera.K[0, 0]))
        half_height = camera.height / (2 * float(camera.K[1, 1]))
        return 2 * math.atan(max(half_height, half_width / aspect))


def upward(viewmats: Float[Tensor, "n 4 4"]) -> Float[Tensor, "3"]:
    """The direction of the sky: the mean of what is up in the pictures."""
    mean = -viewmats[:, 1, :3].mean(0)
    if mean.norm() < 1e-3:  # held in all ways
        mean = -viewmats[0, 1, :3]
    return normalize(mean, dim=0)


def drawn_picture(scene: Scene, camera: Camera) -> Image:
    """The scene as it is."""
    return scene.render(camera).image


def drawn_depth(scene: Scene, camera: Camera) -> Image:
    """How near things are, in colours from far to near; the range is that of the picture."""
    drawn = scene.render(camera, depth=True)
    assert drawn.depth is not None
    known = drawn.alpha > COVERED
    nearness = drawn.alpha / drawn.depth.clamp_min(1e-9)
    if not known.any():
        return torch.zeros_like(drawn.image)
    values = nearness[known].sort().values
    low, high = values[int(0.02 * (len(values) - 1))], values[int(0.98 * (len(values) - 1))]
    colors = in_colors((nearness - low) / (high - low).clamp_min(1e-9))
    return torch.where(known[:, :, None], colors, torch.zeros_like(colors))


def error_map(image: Image, view: View) -> Image:
    """Mean difference to the photo over the channels, in colours; black where nothing counts."""
    wrong = (as_displayed(image) - view.image).abs().mean(2)
    if view.mask is not None:
        wrong = wrong * view.mask
    return in_colors(wrong / WRONG)


def decibels(image: Image, view: View) -> float:
    """PSNR of a picture against the photo, as evaluation measures it."""
    mask = None if view.mask is None else view.mask > 0.5
    return psnr(as_displayed(image), view.image, mask)


def side_by_side(pictures: Sequence[Image], aspect: float) -> Float[Tensor, "rows columns 3"]:
    """Pictures of one size next to each other, or in a column where the canvas is narrower."""
    height, width, _ = pictures[0].shape
    axis = 1 if aspect > width / height else 0
    shape = (height, GAP, 3) if axis == 1 else (GAP, width, 3)
    gap = torch.full(shape, AROUND, device=pictures[0].device)
    row = [part for picture in pictures for part in (gap, picture)][1:]
    return torch.cat(row, dim=axis)


def fitted(picture: Image, width: int, height: int) -> Float[Tensor, "rows columns 3"]:
    """A picture in the middle of a canvas of this shape, no larger than it must be."""
    scale = min(1.0, width / picture.shape[1], height / picture.shape[0])
    if scale < 1:
        size = [max(1, round(scale * side)) for side in picture.shape[:2]]
        picture = interpolate(picture.permute(2, 0, 1)[None], size, mode="area")[0].permute(1, 2, 0)
    rows, columns, _ = picture.shape
    full_rows = max(rows, round(columns * height / width))
    full_columns = max(columns, round(rows * width / height))
    canvas = torch.full((full_rows, full_columns, 3), AROUND, device=picture.device)
    top, left = (full_rows - rows) // 2, (full_columns - columns) // 2
    canvas[top : top + rows, left : left + columns] = picture
    return canvas


def in_colors(values: Float[Tensor, "h w"]) -> Image:
    """Colours for values in [0, 1]; others are clamped."""
    colors = torch.tensor(COLORS, device=values.device)
    place = values.nan_to_num(0).clamp(0, 1) * (len(COLORS) - 1)
    below = place.floor().clamp_max(len(COLORS) - 2)
    share, index = (place - below)[:, :, None], below.long()
    return (1 - share) * colors[index] + share * colors[index + 1]
