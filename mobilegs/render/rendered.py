"""The output of every renderer."""

from typing import NamedTuple

from jaxtyping import Float
from torch import Tensor


class Rendered(NamedTuple):
    """A rendered image with its alpha, depth and the radii of the Gaussians.

    With a sequence of cameras, all have a leading dimension c.

    Attributes:
        image: sRGB over the background, at least 0, may exceed 1, `[h, w, 3]`; of colours given in
            place of harmonics as many channels, and any numbers, `[h, w, d]`.
        alpha: coverage of the background, in [0, 1], `[h, w]`.
        depth: alpha-weighted camera-space z in world units, 0 where no Gaussian is, `[h, w]`;
            depth / alpha is the mean depth of a pixel. None unless requested.
        radii: larger half side, in pixels, of each Gaussian's box, 0 where it is not visible,
            `[n]`; no gradient.
    """

    image: Float[Tensor, "*c h w d"]
    alpha: Float[Tensor, "*c h w"]
    depth: Float[Tensor, "*c h w"] | None
    radii: Float[Tensor, "*c n"]
