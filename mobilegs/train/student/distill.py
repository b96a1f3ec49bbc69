"""The teacher's pictures, remembered: what the student learns from beside the photos."""

from typing import NamedTuple

import torch
from jaxtyping import Float, Float16
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render import Rendered
from mobilegs.render.scene import Scene

HALF_MAX = 65504.0


class TeacherPicture(NamedTuple):
    """What the teacher shows of a view, in float32 but with the precision of halves.

    Attributes:
        image: the teacher's colours, `[h, w, 3]`.
        depth: mean camera-space z of each pixel, 0 where the teacher covers half of it or
            less, `[h, w]`; or the sum that `raw_depth` gives.
    """

    image: Float[Tensor, "h w 3"]
    depth: Float[Tensor, "h w"]


class TeacherPictures:
    """Draws a view on first demand, and again only if it did not fit into the memory allowed.

    Pictures are rounded to halves whether they are remembered or not, so training does not
    depend on the size of the cache.
    """

    def __init__(self, teacher: Scene, *, cache_bytes: int, raw: bool = False) -> None:
        """With `raw` depths are not divided by alpha, and stand in every pixel (the release)."""
        self.teacher, self.raw = teacher, raw
        self.left = cache_bytes
        self._drawn: dict[int, Float16[Tensor, "h w 4"]] = {}

    @torch.no_grad()
    def get(self, index: int, camera: Camera) -> TeacherPicture:
        """The teacher's picture of training view `index`, whose camera is `camera`."""
        halves = self._drawn.get(index)
        if halves is None:
            halves = self._draw(camera)
            if halves.nbytes <= self.left:
                self.left -= halves.nbytes
                self._drawn[index] = halves
        picture = halves.float()
        return TeacherPicture(picture[:, :, :3], picture[:, :, 3])

    def _draw(self, camera: Camera) -> Float16[Tensor, "h w 4"]:
        drawn = self.teacher.render(camera, depth=True)
        assert drawn.depth is not None
        if self.raw:
            depth = raw_depth(drawn, self.teacher.background)
        else:
            depth = torch.where(drawn.alpha > 0.5, drawn.depth / drawn.alpha.clamp_min(0.5), 0.0)
        picture = torch.cat([drawn.image, depth[:, :, None]], dim=2)
        return picture.clamp(-HALF_MAX, HALF_MAX).half()


def raw_depth(drawn: Rendered, background: Float[Tensor, "3"]) -> Float[Tensor, "h w"]:
    """The depth that the release compares: z drawn as a colour, over the background's mean."""
    assert drawn.depth is not None
    return drawn.depth + (1 - drawn.alpha) * background.mean()
