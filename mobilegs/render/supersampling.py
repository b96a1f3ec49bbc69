"""Supersampling: images smaller than those of training, rendered larger and averaged.

A Gaussian narrower than a pixel counts as if it covered the pixel. Compensated alpha corrects its
coverage (Mip-Splatting), but not the ratio `sum(c a w) / sum(a w)` of sort-free blending, which is
not linear. So a small image is rendered with n x n pixels in place of one, and their mean is the
pixel: the area average of the larger image. The web viewer's resolve passes do the same.
"""

from collections.abc import Sequence
from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.rendered import Rendered

SUPERSAMPLING_MAX = 4  # pixels in place of one, along a side
SIDE_MAX = 4096  # pixels of an image that is rendered to be averaged


def supersampling_for(camera: Camera, views: Sequence[Camera]) -> int:
    """Return n, 1 to 4, at which `camera` has about the focal length of the training cameras.

    `views` are training cameras at the size of training, of which the first counts; without any,
    n is 1. n is smaller where the larger image would exceed 4,096 pixels along a side. Same
    formula: supersamplingFor in viewer/src/viewer/supersampling.js.
    """
    if not views:
        return 1
    trained, focal = (float((view.K[0, 0] * view.K[1, 1]).sqrt()) for view in (views[0], camera))
    most = min(SUPERSAMPLING_MAX, SIDE_MAX // max(camera.width, camera.height))
    return max(1, min(int(trained / focal + 0.5), most))


def magnified(camera: Camera, n: int) -> Camera:
    """Return the same view with n x n pixels in place of each."""
    if n == 1:
        return camera
    scale = torch.tensor([n, n, 1.0]).to(camera.K)
    size = {"width": n * camera.width, "height": n * camera.height}
    return replace(camera, K=camera.K * scale[:, None], **size)


def averaged(rendered: Rendered, n: int) -> Rendered:
    """Return the image of means over n x n pixels, and the radii in its pixels."""
    if n == 1:
        return rendered
    depth = rendered.depth
    return Rendered(
        _means(rendered.image, n),
        _means(rendered.alpha[..., None], n)[..., 0],
        None if depth is None else _means(depth[..., None], n)[..., 0],
        rendered.radii / n,
    )


def _means(image: Float[Tensor, "h w d"], n: int) -> Float[Tensor, "..."]:
    height, width = (side // n for side in image.shape[:2])
    return image.unflatten(1, (width, n)).unflatten(0, (height, n)).mean((1, 3))
