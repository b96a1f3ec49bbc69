"""Real spherical harmonics up to degree 3, in the order and with the signs of 3DGS.

The same formula: `sh_basis` in csrc/core.h, `harmonics` in the viewer's project.wgsl and
project.glsl.
"""

import torch
from jaxtyping import Float
from torch import Tensor

C0 = 0.28209479177387814
C1 = 0.4886025119029199
C2 = (
    1.0925484305920792,
    -1.0925484305920792,
    0.31539156525252005,
    -1.0925484305920792,
    0.5462742152960396,
)
C3 = (
    -0.5900435899266435,
    2.890611442640554,
    -0.4570457994644658,
    0.3731763325901154,
    -0.4570457994644658,
    1.445305721320277,
    -0.5900435899266435,
)


def sh_basis(directions: Float[Tensor, "n 3"], degree: int) -> Float[Tensor, "n k"]:
    """Return the values of the `(degree + 1)^2` basis functions in unit `directions`.

    `degree` is 0 to 3. Within degree l the order is m = -l .. l; the signs are those of 3DGS (Kerbl
    et al. 2023), so coefficients in 3DGS files need no conversion.
    """
    x, y, z = directions.unbind(-1)
    columns = [torch.full_like(x, C0)]
    if degree >= 1:
        columns += [-C1 * y, C1 * z, -C1 * x]
    if degree >= 2:
        xx, yy, zz = x * x, y * y, z * z
        columns += [
            C2[0] * x * y,
            C2[1] * y * z,
            C2[2] * (2 * zz - xx - yy),
            C2[3] * x * z,
            C2[4] * (xx - yy),
        ]
    if degree >= 3:
        xx, yy, zz = x * x, y * y, z * z
        columns += [
            C3[0] * y * (3 * xx - yy),
            C3[1] * x * y * z,
            C3[2] * y * (4 * zz - xx - yy),
            C3[3] * z * (2 * zz - 3 * xx - 3 * yy),
            C3[4] * x * (4 * zz - xx - yy),
            C3[5] * z * (xx - yy),
            C3[6] * x * (xx - 3 * yy),
        ]
    return torch.stack(columns, dim=-1)


def sh_colors(sh: Float[Tensor, "n k 3"], directions: Float[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
    """Return the colours along unit `directions` (from the camera to the Gaussians), at least 0.

    `c = max(0, 0.5 + sum(basis sh))`, as in 3DGS.
    """
    basis = sh_basis(directions, round(sh.shape[1] ** 0.5) - 1)
    return (0.5 + (basis[:, :, None] * sh).sum(1)).clamp_min(0)


@torch.no_grad()
def rotated_sh(
    sh: Float[Tensor, "n k 3"], rotation: Float[Tensor, "3 3"]
) -> Float[Tensor, "n k 3"]:
    """Return the coefficients of the colours after a rotation of the scene, or a reflection.

    The new colour in the direction `rotation @ d` is the old one in the direction d. The matrix
    of the change is the solution of these equations for more directions than coefficients, and
    exact, because a rotation keeps each degree.
    """
    degree = round(sh.shape[1] ** 0.5) - 1
    generator = torch.Generator().manual_seed(0)
    directions = torch.randn(64, 3, generator=generator, dtype=torch.float64)
    directions = torch.nn.functional.normalize(directions, dim=1)
    after = sh_basis(directions @ rotation.double().cpu().T, degree)
    change = torch.linalg.lstsq(after, sh_basis(directions, degree)).solution
    return torch.einsum("jk,nkc->njc", change.to(sh), sh)


def rgb_to_sh0(rgb: Float[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
    """Return the degree-0 coefficients of colours `rgb` in [0, 1]."""
    return (rgb - 0.5) / C0
