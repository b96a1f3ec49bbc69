"""Gradients with respect to a camera's pose.

An image depends on the pose through camera space, and through the directions in which harmonics
and lobes are evaluated. PyTorch differentiates both in the reference. The kernels have gradients of
the Gaussians only: `carried_by_gaussians` moves the Gaussians in place of the camera.
"""

from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize, pad

from mobilegs.camera import Camera
from mobilegs.render.inputs import RenderInputs
from mobilegs.render.lobes import lobe_degree
from mobilegs.spherical_harmonics import C0, sh_basis, sh_colors


def rigid(viewmat: Float[Tensor, "4 4"]) -> Float[Tensor, "4 4"]:
    """Return `viewmat` with a gradient that points along rigid motions.

    A rotation R can only change by R times a skew matrix. The gradient G of R becomes its part in
    these directions, `(G - R G^T R) / 2`, that of the last row 0.
    """
    fixed = viewmat.detach()
    change = viewmat - fixed  # 0
    rotation = fixed[:3, :3]
    turn = (change[:3, :3] - rotation @ change[:3, :3].T @ rotation) / 2
    return fixed + pad(torch.cat([turn, change[:3, 3:]], dim=1), (0, 0, 0, 1))


def carried_by_gaussians(inputs: RenderInputs, camera: Camera) -> tuple[RenderInputs, Camera]:
    """Return inputs through which the gradient of a rigid pose flows, and the camera without it.

    With `R = R0 + dR`, `t = t0 + dt`, `W = R0^T dR` (skew) and its axis w, the camera R, t sees a
    Gaussian as R0, t0 sees one with the mean `m + W m + R0^T dt` and the quaternion
    `q + (0, w) q / 2`, to first order. All changes are 0 here and have gradients. Colours and lobes
    are evaluated along the direction from the camera, since harmonics do not turn with a Gaussian.
    """
    given = (inputs.means, inputs.quats, inputs.colors, inputs.lobes)
    rows = [t.detach().flatten(1).isfinite().all(1) for t in given if t is not None]
    valid = torch.stack(rows).all(0)
    # 0 times a value that is not finite would reach the gradient of the pose
    means, quats, colors, lobes = (
        None if t is None else torch.where(valid.reshape(-1, *[1] * (t.ndim - 1)), t, 0.0)
        for t in given
    )
    assert means is not None and quats is not None and colors is not None
    change = (camera.viewmat - camera.viewmat.detach()).to(means)
    rotation = camera.viewmat.detach()[:3, :3].to(means)
    turn = rotation.T @ change[:3, :3]
    w, v = quats[:, :1], quats[:, 1:]
    axis = torch.stack([turn[2, 1], turn[0, 2], turn[1, 0]]).expand_as(v)
    scalar, vector = -(axis * v).sum(1, keepdim=True), w * axis + torch.linalg.cross(axis, v)
    directions = normalize(means - camera.position.to(means), dim=1)
    if colors.ndim == 3:
        colors = sh_colors(colors, directions)
    if lobes is not None:
        basis = sh_basis(directions, lobe_degree(lobes))
        lobes = (basis[:, :, None] * lobes).sum(1, keepdim=True) / C0
    moved = means + means @ turn.T + rotation.T @ change[:3, 3]
    inputs = inputs._replace(
        means=torch.where(valid[:, None], moved, torch.nan),
        quats=quats + torch.cat([scalar, vector], dim=1) / 2,
        colors=colors,
        lobes=lobes,
    )
    return inputs, replace(camera, viewmat=camera.viewmat.detach())
