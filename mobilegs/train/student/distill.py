"""Images and depths of the teacher, the targets of distillation, with a cache."""

from typing import NamedTuple

import torch
from jaxtyping import Float, Float16
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render import Rendered
from mobilegs.render.scene import Scene
from mobilegs.representation.float16 import FLOAT16_MAX


class TeacherImage(NamedTuple):
    """The teacher's image of a view, in float32 with the precision of float16.

    Attributes:
        image: colours, `[h, w, 3]`.
        depth: mean camera-space z per pixel, `[h, w]`, and 0 where the teacher covers at most half
            of the pixel; or the depth of `release_depth`.
    """

    image: Float[Tensor, "h w 3"]
    depth: Float[Tensor, "h w"]


class TeacherImages:
    """Renders the teacher's views on first use, and caches them within a limit of memory.

    Cached or not, images are rounded to float16, so that training does not depend on the limit.
    """

    def __init__(self, teacher: Scene, *, cache_bytes: int, release_depths: bool = False) -> None:
        """Cache at most `cache_bytes`; `release_depths` takes depths from `release_depth`."""
        self.teacher, self.release_depths = teacher, release_depths
        self.free_bytes = cache_bytes
        self._cached: dict[int, Float16[Tensor, "h w 4"]] = {}

    @torch.no_grad()
    def get(self, index: int, camera: Camera) -> TeacherImage:
        """Return the image of view `index`, whose camera is `camera`."""
        packed = self._cached.get(index)
        if packed is None:
            packed = self._render(camera)
            if packed.nbytes <= self.free_bytes:
                self.free_bytes -= packed.nbytes
                self._cached[index] = packed
        image = packed.float()
        return TeacherImage(image[:, :, :3], image[:, :, 3])

    def _render(self, camera: Camera) -> Float16[Tensor, "h w 4"]:
        drawn = self.teacher.render(camera, depth=True)
        assert drawn.depth is not None
        if self.release_depths:
            depth = release_depth(drawn, self.teacher.background)
        else:
            depth = torch.where(drawn.alpha > 0.5, drawn.depth / drawn.alpha.clamp_min(0.5), 0.0)
        packed = torch.cat([drawn.image, depth[:, :, None]], dim=2)
        return packed.clamp(-FLOAT16_MAX, FLOAT16_MAX).half()


def release_depth(drawn: Rendered, background: Float[Tensor, "3"]) -> Float[Tensor, "h w"]:
    """Return the depth of the release: z rendered as a colour, over the background's mean."""
    assert drawn.depth is not None
    return drawn.depth + (1 - drawn.alpha) * background.mean()
