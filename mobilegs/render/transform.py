"""Moves, turns, scales and stretches Gaussians."""

import numpy as np
import torch
from jaxtyping import Float

from mobilegs.gaussians import Gaussians
from mobilegs.render.project import rotation_matrices
from mobilegs.spherical_harmonics import rotated_sh

BLOCK = 1 << 15  # Gaussians that are transformed at a time
EVEN_TOLERANCE = 1e-4  # relative difference of factors that count as equal; files have float32
SCALE_MIN = 1e-30  # a scale of 0 has no logarithm

Matrix = Float[np.ndarray, "3 3"]


def transformed(gaussians: Gaussians, linear: Matrix, offset: Float[np.ndarray, "3"]) -> Gaussians:
    """Return the Gaussians after the map `x -> linear @ x + offset` of the world, on the CPU.

    Means and shapes follow exactly, whatever the matrix. Colours turn with its rotation, which is
    exact if it stretches all directions evenly (`is_even`).
    """
    blocks = gaussians.detached().to("cpu")
    rows = range(0, max(1, len(blocks)), BLOCK)
    parts = [_block(blocks.select(slice(i, i + BLOCK)), linear, offset) for i in rows]
    names = blocks.tensors()
    return Gaussians(
        **{name: torch.cat([part.tensors()[name] for part in parts]) for name in names}
    )


def is_even(linear: Matrix) -> bool:
    """Return True if a matrix is a rotation or reflection times a factor above 0."""
    factors = np.linalg.svd(linear, compute_uv=False)
    return bool(factors[0] - factors[2] <= EVEN_TOLERANCE * factors[0] and factors[0] > 0)


def _block(gaussians: Gaussians, linear: Matrix, offset: Float[np.ndarray, "3"]) -> Gaussians:
    from scipy.spatial.transform import Rotation

    left, factors, right = np.linalg.svd(linear)
    turn = left @ right  # of determinant 1 or -1
    with np.errstate(over="ignore", invalid="ignore"):  # the caller drops what is not finite
        means = gaussians.means.double().numpy() @ linear.T + offset
    own = rotation_matrices(gaussians.quats.double()).numpy()
    if is_even(linear):
        # a Gaussian is the same after a reflection at its mean
        axes = np.linalg.det(turn) * turn @ own
        log_scales = gaussians.log_scales.double().numpy() + np.log(factors.mean())
    else:
        with np.errstate(over="ignore", invalid="ignore"):
            shapes = linear @ own * gaussians.log_scales.double().exp().numpy()[:, None]
        axes, scales, _ = np.linalg.svd(np.nan_to_num(shapes))
        axes *= np.linalg.det(axes)[:, None, None]
        log_scales = np.log(np.maximum(scales, SCALE_MIN))
    quats = Rotation.from_matrix(axes).as_quat()[:, [3, 0, 1, 2]]
    return Gaussians(
        torch.from_numpy(means).float(),
        torch.from_numpy(quats).float(),
        torch.from_numpy(log_scales).float(),
        gaussians.logit_opacities,
        rotated_sh(gaussians.sh, torch.from_numpy(turn)),
    )
