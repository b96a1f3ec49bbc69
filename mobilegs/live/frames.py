"""Images of the live view: renders, depths and error maps, and the cameras they are seen from."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import interpolate

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, View
from mobilegs.evaluate.metrics import as_displayed, psnr
from mobilegs.render.scene import Scene
from mobilegs.up import up_of_cameras

ERROR_MAX = 0.25  # mean channel difference that gets the last colour of the map
ALPHA_MIN = 0.5  # pixels below have no depth
GREY = 0.09  # around images that do not fill the canvas
GAP = 6  # pixels between images side by side
# from small to large: black, purple, red, orange, light yellow; even steps of lightness
COLORMAP = (
    (0.0, 0.0, 0.02), (0.34, 0.06, 0.43), (0.73, 0.21, 0.33), (0.98, 0.55, 0.04), (0.99, 1.0, 0.64)
)  # fmt: skip

Image = Float[Tensor, "h w 3"]


@dataclass(frozen=True)
class BrowserCamera:
    """The camera of a browser and the size of its canvas in pixels.

    `rotation` is camera-to-world, row by row, in OpenCV axes; `fov` is the vertical field of view
    in radians.
    """

    position: tuple[float, float, float]
    rotation: tuple[float, ...]
    fov: float
    width: int
    height: int

    @property
    def is_valid(self) -> bool:
        """True if an image can be rendered from here."""
        numbers = (*self.position, *self.rotation, self.fov)
        sizes = self.width > 0 and self.height > 0
        return sizes and all(map(math.isfinite, numbers)) and 0 < self.fov < math.pi

    def camera(self, width: int, height: int, near: float) -> Camera:
        """Return the camera of an image of `width` x `height` pixels."""
        turn = torch.tensor(self.rotation, dtype=torch.float64).reshape(3, 3).T
        viewmat = torch.eye(4, dtype=torch.float64)
        viewmat[:3, :3] = turn
        viewmat[:3, 3] = -turn @ torch.tensor(self.position, dtype=torch.float64)
        focal = height / (2 * math.tan(self.fov / 2))
        K = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        return Camera(viewmat.float(), K, width, height, near)


class TrainingCameras:
    """The cameras of the training photos: the nearest one, and how a browser can take its place."""

    def __init__(self, dataset: Dataset) -> None:
        """Take the training cameras of `dataset`, in its order."""
        self.cameras = [frame.camera for frame in dataset.train]
        self.extent = dataset.extent
        mats = torch.stack([camera.viewmat for camera in self.cameras]).double()
        self.positions = torch.stack([camera.position for camera in self.cameras]).double()
        self.forwards = mats[:, 2, :3]
        self._center = dataset.center.double()
        self.up = up_of_cameras(mats.cpu().numpy())

    def nearest(self, browser: BrowserCamera) -> int:
        """Return the index of the camera with the most similar position and direction."""
        rotation = torch.tensor(browser.rotation, dtype=torch.float64).reshape(3, 3)
        distances = (self.positions - torch.tensor(browser.position, dtype=torch.float64)).norm(
            dim=1
        )
        turned = 1 - self.forwards @ rotation[:, 2]  # 0 for the same direction, 2 for the opposite
        return int((distances / self.extent + turned).argmin())

    def position_and_target(self, index: int) -> tuple[Float[Tensor, "3"], Float[Tensor, "3"]]:
        """Return the position of camera `index` and the point to look at and to orbit."""
        position, forward = self.positions[index], self.forwards[index]
        distance = float((self._center - position) @ forward)
        if not distance > 0.05 * self.extent:  # cameras that look outwards or in parallel
            distance = self.extent
        return position, position + distance * forward

    def fov(self, index: int, aspect: float) -> float:
        """Return the vertical field of view at which a canvas shows all of photo `index`.

        `aspect` is the canvas's width divided by its height; the result is in radians.
        """
        camera = self.cameras[index]
        half_width = camera.width / (2 * float(camera.K[0, 0]))
        half_height = camera.height / (2 * float(camera.K[1, 1]))
        return 2 * math.atan(max(half_height, half_width / aspect))


def render_depth(scene: Scene, camera: Camera) -> Image:
    """Render inverse depth as colours, scaled to the range of the image; black without depth."""
    drawn = scene.render(camera, depth=True)
    assert drawn.depth is not None
    known = drawn.alpha > ALPHA_MIN
    nearness = drawn.alpha / drawn.depth.clamp_min(1e-9)
    if not known.any():
        return torch.zeros_like(drawn.image)
    values = nearness[known].sort().values
    low, high = values[int(0.02 * (len(values) - 1))], values[int(0.98 * (len(values) - 1))]
    colors = apply_colormap((nearness - low) / (high - low).clamp_min(1e-9))
    return torch.where(known[:, :, None], colors, torch.zeros_like(colors))


def error_map(image: Image, view: View) -> Image:
    """Return the mean channel difference to the photo as colours; black where masked."""
    error = (as_displayed(image) - view.image).abs().mean(2)
    if view.mask is not None:
        error = error * view.mask
    return apply_colormap(error / ERROR_MAX)


def view_psnr(image: Image, view: View) -> float:
    """Return the PSNR of an image against the view's photo in dB, as the evaluation does."""
    mask = None if view.mask is None else view.mask > 0.5
    return psnr(as_displayed(image), view.image, mask)


def side_by_side(images: Sequence[Image], aspect: float) -> Float[Tensor, "rows columns 3"]:
    """Join images of one size in a row, or in a column if the canvas is narrower than they are."""
    height, width, _ = images[0].shape
    axis = 1 if aspect > width / height else 0
    shape = (height, GAP, 3) if axis == 1 else (GAP, width, 3)
    gap = torch.full(shape, GREY, device=images[0].device)
    row = [part for image in images for part in (gap, image)][1:]
    return torch.cat(row, dim=axis)


def letterbox(image: Image, width: int, height: int) -> Float[Tensor, "rows columns 3"]:
    """Centre an image on grey with the aspect ratio of a canvas of `width` x `height` pixels.

    An image that is larger than the canvas is reduced to fit.
    """
    scale = min(1.0, width / image.shape[1], height / image.shape[0])
    if scale < 1:
        size = [max(1, round(scale * side)) for side in image.shape[:2]]
        image = interpolate(image.permute(2, 0, 1)[None], size, mode="area")[0].permute(1, 2, 0)
    rows, columns, _ = image.shape
    full_rows = max(rows, round(columns * height / width))
    full_columns = max(columns, round(rows * width / height))
    canvas = torch.full((full_rows, full_columns, 3), GREY, device=image.device)
    top, left = (full_rows - rows) // 2, (full_columns - columns) // 2
    canvas[top : top + rows, left : left + columns] = image
    return canvas


def apply_colormap(values: Float[Tensor, "h w"]) -> Image:
    """Return colours for values in [0, 1]; values outside are clamped."""
    colors = torch.tensor(COLORMAP, device=values.device)
    place = values.nan_to_num(0).clamp(0, 1) * (len(COLORMAP) - 1)
    below = place.floor().clamp_max(len(COLORMAP) - 2)
    share, index = (place - below)[:, :, None], below.long()
    return (1 - share) * colors[index] + share * colors[index + 1]
