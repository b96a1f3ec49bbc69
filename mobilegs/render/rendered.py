"""What every renderer gives back."""

from typing import NamedTuple

from jaxtyping import Float
from torch import Tensor


class Rendered(NamedTuple):
    """A picture and what belongs to it.

    Attributes:
        image: sRGB as trained, background blended in, not clamped at 1, `[h, w, 3]`.
        alpha: how much of the background is covered, in [0, 1], `[h, w]`.
        depth: alpha-weighted camera-space z, 0 where nothing is: depth / alpha is the mean
            depth of a pixel, `[h, w]`; None where the caller did not ask for it.
        radii: larger half side, in pixels, of each Gaussian's box, 0 where it is not visible,
            `[n]`; no gradient.
    """

    image: Float[Tensor, "h w 3"]
    alpha: Float[Tensor, "h w"]
    depth: Float[Tensor, "h w"] | None
    radii: Float[Tensor, "n"]
