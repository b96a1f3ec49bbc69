"""Both blendings in numpy, from the papers' formulas and without the package's code."""

import numpy as np
import torch

from mobilegs.camera import Camera
from mobilegs.render.project import CLASSIC, Footprint


def alphas_and_depths(
    scene: dict[str, torch.Tensor],
    opacities: torch.Tensor,
    view: Camera,
    footprint: Footprint = CLASSIC,
    least: float = 1 / 255,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the alpha of every Gaussian at every pixel, `[h w, n]`, and the depths, `[n]`.

    EWA splatting (3DGS, Eq. 5), by default with 3DGS's constants.
    """
    means, quats, scales, o = (
        t.detach().numpy() for t in (scene["means"], scene["quats"], scene["scales"], opacities)
    )
    viewmat, k = view.viewmat.detach().numpy(), view.K.numpy()
    x, y, z = (means @ viewmat[:3, :3].T + viewmat[:3, 3]).T
    columns, rows = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
    pixels = np.stack([columns.ravel(), rows.ravel()], 1)
    alphas = np.zeros((len(pixels), len(means)))
    for i in np.flatnonzero(z > view.near):
        a, b, c, d = quats[i] / np.linalg.norm(quats[i])
        turn = 2 * np.array(
            [
                [0.5 - c * c - d * d, b * c - a * d, b * d + a * c],
                [b * c + a * d, 0.5 - b * b - d * d, c * d - a * b],
                [b * d - a * c, c * d + a * b, 0.5 - b * b - c * c],
            ]
        )
        # x / z and y / z are those of a place at most 0.15 image sizes outside of the image
        u, v = (
            np.clip(at / z[i], (-0.15 * n - c) / f, (1.15 * n - c) / f)
            for at, n, f, c in (
                (x[i], view.width, k[0, 0], k[0, 2]),
                (y[i], view.height, k[1, 1], k[1, 2]),
            )
        )
        jacobian = np.array(
            [[k[0, 0] / z[i], 0, -k[0, 0] * u / z[i]], [0, k[1, 1] / z[i], -k[1, 1] * v / z[i]]]
        )
        root = jacobian @ viewmat[:3, :3] @ turn @ np.diag(scales[i])
        covariance = root @ root.T + footprint.blur * np.eye(2)
        inverse = np.linalg.inv(covariance)
        center = np.array([k[0, 0] * x[i] / z[i] + k[0, 2], k[1, 1] * y[i] / z[i] + k[1, 2]])
        away = pixels - center
        alpha = o[i] * np.exp(-0.5 * np.einsum("pi,ij,pj->p", away, inverse, away))
        counts = alpha >= least
        if footprint.soft_edge:
            alpha = alpha - least
        if footprint.antialiased:
            alpha = alpha * np.sqrt(np.linalg.det(root @ root.T) / np.linalg.det(covariance))
        alphas[:, i] = np.where(counts, np.minimum(alpha, 0.99), 0)
    return alphas, z


def sorted_shares(alphas: np.ndarray, depths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the share `a T` of every Gaussian and the background's, `[h w, n]` and `[h w]`."""
    shares, passed = np.zeros_like(alphas), np.ones(len(alphas))
    for i in np.argsort(depths, kind="stable"):
        shares[:, i] = np.where(passed >= 1e-4, alphas[:, i] * passed, 0)
        passed = passed - shares[:, i]
    return shares, passed


def sortfree_shares(
    alphas: np.ndarray, depths: np.ndarray, largest: np.ndarray, phi: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the shares of Mobile-GS's Eq. 2 with the weights of Eq. 3, exponents up to 4."""
    weights = phi**2 + phi / depths**2 + np.exp(np.minimum(largest / depths, 4))
    passed = np.prod(1 - alphas, 1)
    parts = alphas * weights
    total = parts.sum(1, keepdims=True)
    return (1 - passed)[:, None] * parts / np.where(total > 0, total, 1), passed
