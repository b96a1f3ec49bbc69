"""Images, depths and coverages of the teacher, the targets of distillation, with a cache."""

from typing import NamedTuple

import torch
from jaxtyping import Float, Float16, UInt8
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.evaluate.front import front_coverage
from mobilegs.render import Rendered
from mobilegs.render.scene import Scene
from mobilegs.representation.float16 import FLOAT16_MAX

SOLID = 0.9  # the teacher's coverage from which a pixel shows a surface
PLANE_BEFORE = 0.1  # a plane lies at most this share of its depth before a surface


class TeacherImage(NamedTuple):
    """The teacher's image of a view, in float32 with the precision of float16.

    Attributes:
        image: colours, `[h, w, 3]`.
        depth: mean camera-space z per pixel, `[h, w]`, and 0 where the teacher covers at most half
            of the pixel; or the depth of `release_depth`.
    """

    image: Float[Tensor, "h w 3"]
    depth: Float[Tensor, "h w"]


class FrontTarget(NamedTuple):
    """The teacher's coverage before a plane.

    Attributes:
        z: camera-space depth of the plane.
        coverage: by the Gaussians nearer than it, in [0, 1] with the precision of 8 bits,
            `[h, w]`.
    """

    z: float
    coverage: Float[Tensor, "h w"]


class TeacherImages:
    """Renders the teacher's views on first use, and caches them within a limit of memory.

    Cached or not, images are rounded to float16 and coverages to 8 bits, so that training does not
    depend on the limit.
    """

    def __init__(self, teacher: Scene, *, cache_bytes: int, release_depths: bool = False) -> None:
        """Cache at most `cache_bytes`; `release_depths` takes depths from `release_depth`."""
        self.teacher, self.release_depths = teacher, release_depths
        self.free_bytes = cache_bytes
        self._cached: dict[int, Float16[Tensor, "h w 4"]] = {}
        self._fronts: dict[int, tuple[float, UInt8[Tensor, "h w"]]] = {}

    @torch.no_grad()
    def get(self, index: int, camera: Camera) -> TeacherImage:
        """Return the image of view `index`, whose camera is `camera`."""
        packed = self._cached.get(index)
        if packed is None:
            packed = self._render(camera)
            if self._reserve(packed):
                self._cached[index] = packed
        image = packed.float()
        return TeacherImage(image[:, :, :3], image[:, :, 3])

    @torch.no_grad()
    def front(self, index: int, camera: Camera) -> FrontTarget:
        """Return the coverage before the plane of view `index`, whose camera is `camera`.

        A view always has the same plane: at most a tenth before the teacher's surface at a random
        pixel. Where the teacher covers no pixel, z is 0.
        """
        found = self._fronts.get(index)
        if found is None:
            z = self._plane(index, camera)
            coverage = front_coverage(self.teacher, camera, z)
            found = z, (255 * coverage).round().to(torch.uint8)
            if self._reserve(found[1]):
                self._fronts[index] = found
        return FrontTarget(found[0], found[1].float() / 255)

    def _reserve(self, packed: Tensor) -> bool:
        """Take the bytes of a tensor from the free ones; False if there are too few."""
        fits = packed.nbytes <= self.free_bytes
        self.free_bytes -= packed.nbytes if fits else 0
        return fits

    def _plane(self, index: int, camera: Camera) -> float:
        drawn = self.teacher.render(camera, depth=True)
        assert drawn.depth is not None
        solid = drawn.alpha > SOLID
        depths = drawn.depth[solid] / drawn.alpha[solid]
        if not len(depths):
            return 0.0
        generator = torch.Generator().manual_seed(index)
        pixel, share = torch.rand(2, generator=generator, dtype=torch.float64).tolist()
        return float(depths[int(pixel * len(depths))]) * (1 - PLANE_BEFORE * share)

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
