"""Images of the live view: renders, depths and error maps, and the cameras they are seen from."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import interpolate

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, View
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import displayed_colors, psnr
from mobilegs.render.scene import Scene
from mobilegs.up import up_of_cameras

ERROR_MAX = 0.25  # mean channel difference that gets the last colour of the map
ALPHA_MIN = 0.5  # pixels below have no depth
SIDE_MAX = 8192  # pixels of a canvas
ASPECT_MAX = 8.0  # of its sides
FOCAL_MIN, FOCAL_MAX = 0.05, 50.0  # in heights of the canvas
GREY = 0.09  # around images that do not fill the canvas
GAP = 6  # pixels between images side by side
# from small to large: black, purple, red, orange, light yellow; even steps of lightness
COLORMAP = (
    (0.0, 0.0, 0.02), (0.34, 0.06, 0.43), (0.73, 0.21, 0.33), (0.98, 0.55, 0.04), (0.99, 1.0, 0.64)
)  # fmt: skip

Image = Float[Tensor, "h w 3"]


@dataclass(frozen=True)
class BrowserCamera:
    """The camera of a browser and the size of its canvas.

    `viewmat` is world-to-camera, row by row, in OpenCV axes; `focal`, `width` and `height` are in
    pixels.
    """

    viewmat: tuple[float, ...]
    focal: float
    width: int
    height: int

    def check(self) -> None:
        """Raise InputError if no image can be rendered from here."""
        if not all(1 <= side <= SIDE_MAX for side in (self.width, self.height)):
            raise InputError(f"the sides of the canvas are not 1 to {SIDE_MAX} pixels")
        if not 1 / ASPECT_MAX <= self.width / self.height <= ASPECT_MAX:
            raise InputError("the canvas is too narrow")
        if not FOCAL_MIN <= self.focal / self.height <= FOCAL_MAX:
            raise InputError("the field of view is too wide or too narrow")
        turn = self._matrix()[:3, :3]
        error = (turn @ turn.T - torch.eye(3, dtype=torch.float64)).abs().max()
        if not error < 1e-3 or self.viewmat[12:] != (0, 0, 0, 1):
            raise InputError("the camera's matrix is not a rotation and a movement")

    @property
    def position(self) -> Float[Tensor, "3"]:
        """The place of the camera in the world."""
        matrix = self._matrix()
        return -matrix[:3, :3].T @ matrix[:3, 3]

    @property
    def forward(self) -> Float[Tensor, "3"]:
        """The direction of view, length 1."""
        return self._matrix()[2, :3]

    def camera(self, width: int, height: int, near: float) -> Camera:
        """Return the camera of an image of `width` x `height` pixels."""
        focal = self.focal * height / self.height
        K = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        return Camera(self._matrix().float(), K, width, height, near)

    def _matrix(self) -> Float[Tensor, "4 4"]:
        return torch.tensor(self.viewmat, dtype=torch.float64).reshape(4, 4)


class TrainingCameras:
    """The cameras of the training photos, and which of them is nearest to a browser's."""

    def __init__(self, dataset: Dataset) -> None:
        """Take the training cameras of `dataset`, in its order."""
        self.cameras = [frame.camera for frame in dataset.train]
        self.extent = dataset.extent
        mats = torch.stack([camera.viewmat for camera in self.cameras]).double()
        self.positions = torch.stack([camera.position for camera in self.cameras]).double()
        self.forwards = mats[:, 2, :3]
        self.up = up_of_cameras(mats.cpu().numpy())

    def nearest(self, browser: BrowserCamera) -> int:
        """Return the index of the camera with the most similar position and direction."""
        distances = (self.positions - browser.position).norm(dim=1)
        turned = 1 - self.forwards @ browser.forward  # 0: the same direction, 2: the opposite
        return int((distances / self.extent + turned).argmin())


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
    error = (displayed_colors(image) - view.image).abs().mean(2)
    if view.mask is not None:
        error = error * view.mask
    return apply_colormap(error / ERROR_MAX)


def view_psnr(image: Image, view: View) -> float:
    """Return the PSNR of an image against the view's photo in dB, as the evaluation does."""
    mask = None if view.mask is None else view.mask > 0.5
    return psnr(displayed_colors(image), view.image, mask)


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
