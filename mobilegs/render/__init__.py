"""Gaussians + Camera -> image, alpha, depth: two renderers, each with a reference and kernels.

The reference is PyTorch: `project.py`, `sorted.py`, `sortfree.py`, `contributions.py`. The kernels
compute the same in float32: C++ for the CPU and CUDA, both from `csrc/core.h` and `csrc/pairs.h`.
Tests compare every output and every gradient of a kernel with the reference in float64.

The weight w of a Gaussian (paper Eq. 3) is `Weighting.weights` in `sortfree.py`; the kernels and
shaders have it as `weight_of`.
"""

from typing import Literal

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render import contributions as contributions_reference
from mobilegs.render import sorted as sorted_reference
from mobilegs.render import sortfree as sortfree_reference
from mobilegs.render.contributions import Contributions
from mobilegs.render.kernels import cpu, cuda
from mobilegs.render.kernels.kernel_view import kernel_view
from mobilegs.render.project import project
from mobilegs.render.rendered import Rendered
from mobilegs.render.sortfree import Weighting

__all__ = [
    "Contributions",
    "Rendered",
    "Weighting",
    "measure_contributions",
    "render_sorted",
    "render_sortfree",
    "visible_rows",
]

Backend = Literal["auto", "reference", "kernel"]


def _resolve(backend: Backend, means: Tensor) -> Backend:
    if backend != "auto":
        return backend
    return "kernel" if means.dtype == torch.float32 else "reference"


def _raster(means: Tensor) -> type[torch.autograd.Function]:
    if means.dtype != torch.float32:
        raise InputError(f"the kernels render float32, not {means.dtype}: use backend='reference'")
    return cuda.CudaRaster if means.is_cuda else cpu.CpuRaster


def render_sorted(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    sh: Float[Tensor, "n k 3"],
    *,
    camera: Camera,
    background: Float[Tensor, "3"],
    depth: bool = False,
    screen_grads: Float[Tensor, "n 2"] | None = None,
    backend: Backend = "auto",
) -> Rendered:
    """Render by sorted alpha blending, as 3DGS does: `C = sum(c a T) + T_end bg`.

    The reference, with the formula's source, is `render/sorted.py`. All inputs but `camera`,
    `background` and `screen_grads` have gradients.

    Args:
        means: world space, `[n, 3]`.
        quats: rotations wxyz of any length but 0, `[n, 4]`.
        scales: standard deviations in world units, `[n, 3]`.
        opacities: in [0, 1], `[n]`.
        sh: spherical harmonics of the colour, `[n, (degree + 1)^2, 3]`, degree 0 to 3.
        camera: the view; sides of at most 32,767 pixels for the kernels.
        background: sRGB in [0, 1], `[3]`.
        depth: also render the depth image.
        screen_grads: if given, the backward pass overwrites it with the gradient of each mean's
            position in the image, in 1 / px, `[n, 2]`, contiguous. Kernels only.
        backend: `kernel` is the float32 kernel of the tensors' device, `reference` the PyTorch
            code in any precision; `auto` takes the kernel for float32, else the reference.

    Raises InputError for shapes, types or devices that do not belong together.
    """
    if _resolve(backend, means) == "reference":
        rendered = sorted_reference.render_sorted(
            means, quats, scales, opacities, sh, camera=camera, background=background
        )
        return rendered if depth else rendered._replace(depth=None)
    view = kernel_view(camera, background, Weighting(), sh_size=sh.shape[1], lobe_size=0)
    tensors = (means, quats, scales, opacities, sh, None)
    return Rendered(*_raster(means).apply(view, screen_grads, depth, *tensors))


def render_sortfree(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    lobes: Float[Tensor, "n m 2"],
    sh: Float[Tensor, "n k 3"],
    *,
    camera: Camera,
    background: Float[Tensor, "3"],
    weighting: Weighting = Weighting(),  # noqa: B008 - frozen
    depth: bool = False,
    screen_grads: Float[Tensor, "n 2"] | None = None,
    backend: Backend = "auto",
) -> Rendered:
    """Render by order-independent blending: `C = (1 - T) sum(c a w) / sum(a w) + T bg` (Eq. 2).

    The reference, with all formulas, is `render/sortfree.py`; w is `Weighting.weights` (Eq. 3).
    `lobes` are spherical harmonics of the opacity's logit and of phi before its ReLU,
    `[n, (degree + 1)^2, 2]`. All other arguments are those of `render_sorted`.

    Raises InputError for shapes, types or devices that do not belong together.
    """
    if _resolve(backend, means) == "reference":
        rendered = sortfree_reference.render_sortfree(
            means,
            quats,
            scales,
            lobes,
            sh,
            camera=camera,
            background=background,
            weighting=weighting,
        )
        return rendered if depth else rendered._replace(depth=None)
    sizes = {"sh_size": sh.shape[1], "lobe_size": lobes.shape[1]}
    view = kernel_view(camera, background, weighting, **sizes)
    tensors = (means, quats, scales, None, sh, lobes)
    return Rendered(*_raster(means).apply(view, screen_grads, depth, *tensors))


@torch.no_grad()
def measure_contributions(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    *,
    camera: Camera,
    backend: Backend = "auto",
) -> Contributions:
    """Return how much each Gaussian contributes to a sorted image, without gradients.

    The reference is `render/contributions.py`; arguments as in `render_sorted`.
    """
    if _resolve(backend, means) == "reference":
        return contributions_reference.measure_contributions(
            means, quats, scales, opacities, camera=camera
        )
    black = torch.zeros_like(means[:, None, :])
    view = kernel_view(camera, black.new_zeros(3), Weighting(), sh_size=1, lobe_size=0)
    kernels = cuda if means.is_cuda else cpu
    return kernels.measure_contributions(view, means, quats, scales, opacities, black)


@torch.no_grad()
def visible_rows(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    *,
    camera: Camera,
) -> Int[Tensor, "m"]:
    """Return the indices of the Gaussians that could touch the image if they were opaque."""
    ones = torch.ones_like(means[:, 0])
    black = torch.zeros_like(means[:, None, :])
    if _resolve("auto", means) == "reference":
        visible = project(means, quats, scales, ones, black, camera=camera).visible
    else:
        view = kernel_view(camera, black.new_zeros(3), Weighting(), sh_size=1, lobe_size=0)
        kernels = cuda if means.is_cuda else cpu
        visible = kernels.project_radii(view, means, quats, scales, ones, black) > 0
    return visible.nonzero()[:, 0]
