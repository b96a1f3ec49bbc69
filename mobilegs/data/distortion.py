"""Brown-Conrady lens distortion, and the undistortion of photos."""

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.nn.functional import grid_sample


@dataclass(frozen=True)
class Distortion:
    """Brown-Conrady distortion on the plane z = 1, as OpenCV and COLMAP define it.

    With `r2 = x^2 + y^2` the ideal point (x, y) is seen at

        x' = x * f + 2 p1 x y + p2 (r2 + 2 x^2)
        y' = y * f + 2 p2 x y + p1 (r2 + 2 y^2)
        f  = (1 + n1 r2 + n2 r2^2 + n3 r2^3 + n4 r2^4) / (1 + m1 r2 + m2 r2^2 + m3 r2^3)

    Attributes:
        numerator: n1..n4 (OpenCV's k1, k2, k3; n4 is nerfstudio's k4).
        denominator: m1..m3 (OpenCV's k4, k5, k6).
        tangential: p1, p2.
    """

    numerator: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    denominator: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tangential: tuple[float, float] = (0.0, 0.0)

    def __bool__(self) -> bool:
        return any((*self.numerator, *self.denominator, *self.tangential))

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
        """Return the distorted (x', y') of ideal points (x, y) on the plane z = 1, any shape."""
        (p1, p2), r2 = self.tangential, x * x + y * y
        f = self.radial(r2)
        return (
            x * f + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * f + 2 * p2 * x * y + p1 * (r2 + 2 * y * y),
        )

    def valid_radius(self, largest: float) -> float:
        """Return the radius up to which distorted radii still grow, at most `largest`.

        Fitted polynomials fold over outside the photo they were fitted to; beyond the fold they
        would show the photo a second time, mirrored.
        """
        radii = torch.linspace(0, largest, 2049, dtype=torch.float64)
        seen = radii * self.radial(radii * radii)
        falling = (~(seen.diff() > 0)).nonzero()
        return float(radii[falling[0, 0]]) if len(falling) else largest


def undistort(
    image: Float[Tensor, "h w c"], *, K: Float[Tensor, "3 3"], distortion: Distortion
) -> tuple[Float[Tensor, "h w c"], Bool[Tensor, "h w"]]:
    """Return (image [h, w, c] of a pinhole camera with the same `K`, known [h, w]).

    Each ideal pixel centre is distorted, and the photo is sampled there bilinearly. `known` is
    False for pixels that the photo does not show; those have the colour of the nearest edge.
    """
    height, width, _ = image.shape
    fx, fy, cx, cy = (float(K[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    y, x = torch.meshgrid(
        (torch.arange(height, dtype=torch.float64) + 0.5 - cy) / fy,
        (torch.arange(width, dtype=torch.float64) + 0.5 - cx) / fx,
        indexing="ij",
    )
    radius = (x * x + y * y).sqrt()
    xd, yd = distortion.apply(x, y)
    column, row = xd * fx + cx, yd * fy + cy
    known = (column >= 0) & (column <= width) & (row >= 0) & (row <= height)
    known &= radius <= distortion.valid_radius(float(radius.max()))
    # grid_sample's -1 and 1 are the outer edges of the corner pixels (align_corners=False),
    # so pixel centres at +0.5 need no further shift
    grid = torch.stack([column / width, row / height], dim=-1).nan_to_num(0, 0, 0) * 2 - 1
    sampled = grid_sample(
        image.permute(2, 0, 1)[None],
        grid.clamp(-2, 2).to(image.dtype)[None],
        mode="bilinear",
        padding_mode="border",
        align_corners=False,
    )
    return sampled[0].permute(1, 2, 0), known
