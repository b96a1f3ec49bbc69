"""Gaussians + Camera -> image, alpha, depth: definitions and kernels behind one signature."""

from typing import Literal

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render import contributions as contributions_definition
from mobilegs.render import sorted as sorted_definition
from mobilegs.render import sortfree as sortfree_definition
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

Backend = Literal["auto", "definition", "kernel"]


def _chosen(backend: Backend, means: Tensor) -> Backend:
    if backend != "auto":
        return backend
    return "kernel" if means.dtype == torch.float32 else "definition"


def _raster(means: Tensor) -> type[torch.autograd.Function]:
    if means.dtype != torch.float32:
        raise InputError(f"the kernels draw float32, not {means.dtype}: use backend='definition'")
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
    """Front-to-back alpha blending; `sorted.render_sorted` is its definition.

    `depth` asks for the depth image. `screen_grads`, if given, receives (overwritten, during
    the backward pass) the gradient of each centre's position on the picture, in 1 / px.
    `auto` takes the kernel of the tensors' device for float32, the definition for float64.
    """
    if _chosen(backend, means) == "definition":
        drawn = sorted_definition.render_sorted(
            means, quats, scales, opacities, sh, camera=camera, background=background
        )
        return drawn if depth else drawn._replace(depth=None)
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
    """Order-independent blending; `sortfree.render_sortfree` is its definition.

    `depth`, `screen_grads` and `backend` mean what they do in `render_sorted`.
    """
    if _chosen(backend, means) == "definition":
        drawn = sortfree_definition.render_sortfree(
            means,
            quats,
            scales,
            lobes,
            sh,
            camera=camera,
            background=background,
            weighting=weighting,
        )
        return drawn if depth else drawn._replace(depth=None)
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
    """What each Gaussian gives to a sorted picture; `contributions.py` has the definition."""
    if _chosen(backend, means) == "definition":
        return contributions_definition.measure_contributions(
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
    """Indices of the Gaussians that could touch the picture, whatever their opacity."""
    ones = torch.ones_like(means[:, 0])
    black = torch.zeros_like(means[:, None, :])
    if _chosen("auto", means) == "definition":
        visible = project(means, quats, scales, ones, black, camera=camera).visible
    else:
        view = kernel_view(camera, black.new_zeros(3), Weighting(), sh_size=1, lobe_size=0)
        kernels = cuda if means.is_cuda else cpu
        visible = kernels.project_radii(view, means, quats, scales, ones, black) > 0
    return visible.nonzero()[:, 0]
