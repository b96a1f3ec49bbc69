"""Gaussians + Camera -> image, alpha, depth: the definitions and the kernels behind one signature."""

from typing import Literal

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render import sorted as sorted_definition
from mobilegs.render import sortfree as sortfree_definition
from mobilegs.render.project import project
from mobilegs.render.rendered import Rendered
from mobilegs.render.sortfree import Weighting

__all__ = ["Rendered", "Weighting", "render_sorted", "render_sortfree", "visible_rows"]

Backend = Literal["auto", "definition", "cpu", "cuda"]


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
    return sorted_definition.render_sorted(
        means, quats, scales, opacities, sh, camera=camera, background=background
    )


def render_sortfree(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    sh: Float[Tensor, "n k 3"],
    phi: Float[Tensor, "n"],
    *,
    camera: Camera,
    background: Float[Tensor, "3"],
    weighting: Weighting = Weighting(),  # noqa: B008 - frozen
    depth: bool = False,
    screen_grads: Float[Tensor, "n 2"] | None = None,
    backend: Backend = "auto",
) -> Rendered:
    """Order-independent blending; `sortfree.render_sortfree` is its definition."""
    return sortfree_definition.render_sortfree(
        means,
        quats,
        scales,
        opacities,
        sh,
        phi,
        camera=camera,
        background=background,
        weighting=weighting,
    )


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
    return project(means, quats, scales, ones, black, camera=camera).visible.nonzero()[:, 0]
