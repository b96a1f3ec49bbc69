"""Lenses (projection and Brown-Conrady distortion), and pinhole views of photos through them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.nn.functional import grid_sample

Projection = Literal["perspective", "equidistant", "fov", "equirectangular"]


@dataclass(frozen=True)
class Distortion:
    """A lens as OpenCV and COLMAP define it: a projection to a plane, and distortion on the plane.

    The projection maps the direction (x, y, z) in camera space to the ideal point

        perspective      (x / z, y / z)
        equidistant      (x, y) theta / r, with r = sqrt(x^2 + y^2), theta = atan2(r, z) (fisheye)
        fov              as perspective, moved to the radius atan(2 radius tan(omega / 2)) / omega
        equirectangular  (atan2(x, z), atan2(y, sqrt(x^2 + z^2))): longitude and latitude

    With `r2 = x^2 + y^2` the ideal point (x, y) is seen at

        x' = x * f + 2 p1 x y + p2 (r2 + 2 x^2) + s1 r2
        y' = y * f + 2 p2 x y + p1 (r2 + 2 y^2) + s2 r2
        f  = (1 + n1 r2 + n2 r2^2 + n3 r2^3 + n4 r2^4) / (1 + m1 r2 + m2 r2^2 + m3 r2^3)

    Attributes:
        numerator: n1..n4 (OpenCV's k1, k2, k3; n4 is nerfstudio's k4; k1..k4 of a fisheye).
        denominator: m1..m3 (OpenCV's k4, k5, k6).
        tangential: p1, p2.
        prism: s1, s2.
        projection: one of the four above.
        omega: of the projection `fov`, radians in (0, pi).
    """

    numerator: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    denominator: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tangential: tuple[float, float] = (0.0, 0.0)
    prism: tuple[float, float] = (0.0, 0.0)
    projection: Projection = "perspective"
    omega: float = 0.0

    def __bool__(self) -> bool:
        coefficients = (*self.numerator, *self.denominator, *self.tangential, *self.prism)
        return any(coefficients) or self.projection != "perspective"

    def ideal(
        self, x: Float[Tensor, "..."], y: Float[Tensor, "..."], z: Float[Tensor, "..."]
    ) -> tuple[Float[Tensor, "..."], Float[Tensor, "..."]]:
        """Return the ideal points of directions (x, y, z), any shape."""
        if self.projection == "equirectangular":
            return torch.atan2(x, z), torch.atan2(y, torch.hypot(x, z))
        if self.projection == "equidistant":
            r = torch.hypot(x, y)
            scale = _ratio(torch.atan2(r, z), r, 1 / z)
            return x * scale, y * scale
        x, y = x / z, y / z
        if self.projection == "fov":
            r, slope = torch.hypot(x, y), 2 * math.tan(self.omega / 2)
            scale = _ratio(torch.atan(slope * r), r, torch.full_like(r, slope)) / self.omega
            return x * scale, y * scale
        return x, y

    def radial(self, r2: Float[Tensor, "..."]) -> Float[Tensor, "..."]:
        """Return the factor f at squared radius `r2`, any shape."""
        above, below = torch.zeros_like(r2), torch.zeros_like(r2)
        for coefficient in reversed(self.numerator):
            above = (above + coefficient) * r2
        for coefficient in reversed(self.denominator):
            below = (below + coefficient) * r2
        return (1 + above) / (1 + below)

    def apply(
        self, x: Float[Tensor, "..."], y: Float[Tensor, "..."]
    ) -> tuple[Float[Tensor, "..."], Float[Tensor, "..."]]:
        """Return the distorted (x', y') of ideal points (x, y), any shape."""
        (p1, p2), (s1, s2), r2 = self.tangential, self.prism, x * x + y * y
        f = self.radial(r2)
        return (
            x * f + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + s1 * r2,
            y * f + 2 * p2 * x * y + p1 * (r2 + 2 * y * y) + s2 * r2,
        )

    def valid_radius(self, largest: float) -> float:
        """Return the ideal radius up to which distorted radii still grow, at most `largest`.

        Fitted polynomials fold over outside the photo they were fitted to; beyond the fold they
        would show the photo a second time, mirrored.
        """
        radii = torch.linspace(0, largest, 2049, dtype=torch.float64)
        seen = radii * self.radial(radii * radii)
        falling = (~(seen.diff() > 0)).nonzero()
        return float(radii[falling[0, 0]]) if len(falling) else largest


@dataclass(frozen=True)
class LensPhoto:
    """A photo through a lens, from which a pinhole view is resampled.

    Attributes:
        width, height: in pixels.
        intrinsics: fx, fy, cx, cy in pixels, from distorted points to pixels.
        distortion: of the lens.
        rotation: rows of the rotation from the axes of the pinhole view to those of the photo.
    """

    width: int
    height: int
    intrinsics: tuple[float, float, float, float]
    distortion: Distortion
    rotation: Sequence[Sequence[float]] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def pixels_of(
        self, x: Float[Tensor, "..."], y: Float[Tensor, "..."], z: Float[Tensor, "..."]
    ) -> tuple[Float[Tensor, "..."], Float[Tensor, "..."], Bool[Tensor, "..."]]:
        """Return (column, row, seen) of directions in the axes of the photo, any shape.

        `seen` is False outside of the photo and beyond the fold of the distortion.
        """
        fx, fy, cx, cy = self.intrinsics
        ideal = self.distortion.ideal(x, y, z)
        xd, yd = self.distortion.apply(*ideal)
        column, row = xd * fx + cx, yd * fy + cy
        seen = (column >= 0) & (column <= self.width) & (row >= 0) & (row <= self.height)
        radius = torch.hypot(*ideal)
        return column, row, seen & (radius <= self.distortion.valid_radius(float(radius.max())))


def _ratio(
    above: Float[Tensor, "..."], below: Float[Tensor, "..."], at_zero: Float[Tensor, "..."]
) -> Float[Tensor, "..."]:
    """Return `above / below`, or its limit `at_zero` where `below` is 0."""
    tiny = below < 1e-9
    return torch.where(tiny, at_zero, above / torch.where(tiny, 1.0, below))


def undistort(
    image: Float[Tensor, "H W c"], photo: LensPhoto, *, K: Float[Tensor, "3 3"], size: Sequence[int]
) -> tuple[Float[Tensor, "h w c"], Bool[Tensor, "h w"]]:
    """Return (pixels [h, w, c], known [h, w]) of a pinhole view of a photo with pixels `image`.

    `K` and `size` (width, height) are those of the view. Each of its pixel centres is projected
    into the photo, which is sampled there bilinearly. `known` is False for pixels that the photo
    does not show; those have the colour of the nearest edge.
    """
    width, height = size
    fx, fy, cx, cy = (float(K[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    y, x = torch.meshgrid(
        (torch.arange(height, dtype=torch.float64) + 0.5 - cy) / fy,
        (torch.arange(width, dtype=torch.float64) + 0.5 - cx) / fx,
        indexing="ij",
    )
    rotation = torch.tensor(photo.rotation, dtype=torch.float64)
    rays = torch.stack([x, y, torch.ones_like(x)], dim=-1) @ rotation.T
    column, row, known = photo.pixels_of(*rays.unbind(-1))
    columns = photo.width
    if photo.distortion.projection == "equirectangular":  # the left edge continues the right one
        image = torch.cat([image[:, -1:], image, image[:, :1]], dim=1)
        column, columns = column + 1, columns + 2
    # grid_sample's -1 and 1 are the outer edges of the corner pixels (align_corners=False),
    # so pixel centres at +0.5 need no further shift
    grid = torch.stack([column / columns, row / photo.height], dim=-1).nan_to_num(0, 0, 0) * 2 - 1
    sampled = grid_sample(
        image.permute(2, 0, 1)[None],
        grid.clamp(-2, 2).to(image.dtype)[None],
        mode="bilinear",
        padding_mode="border",
        align_corners=False,
    )
    return sampled[0].permute(1, 2, 0), known
