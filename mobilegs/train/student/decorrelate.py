"""Linear transforms of latents, so that uniform quantisation loses least per bit."""

from collections.abc import Callable

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.gaussians import Gaussians
from mobilegs.render.view_network import STATICS
from mobilegs.representation.appearance import ColorDecoder
from mobilegs.representation.lobes import LobeDecoder
from mobilegs.train.threads import one_thread

SAMPLES = 65536
DIFFERENCE = 1e-2  # of the finite differences, in standard deviations
RIDGE = 1e-6  # relative to the mean sensitivity; gives latents without an effect a scale


@torch.no_grad()
def decorrelate_appearance(
    decoder: ColorDecoder,
    positions: Float[Tensor, "n 3"],
    static: Float[Tensor, "n 3"],
    view: Float[Tensor, "n v"],
) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n v"]]:
    """Transform static and view latents, and the weights of `decoder` inversely."""
    decorrelated = []
    for latents, columns in zip((static, view), decoder.latent_weights, strict=True):

        def decode(changed: Tensor, rows: slice, of_static: bool = latents is static) -> Tensor:
            both = (changed, view[rows]) if of_static else (static[rows], changed)
            return decoder(positions[rows], *both).flatten(1)

        transform, inverse = _decorrelation(latents, decode)
        columns.copy_(columns @ inverse.T)
        decorrelated.append(latents @ transform)
    return decorrelated[0], decorrelated[1]


@torch.no_grad()
def decorrelate_lobes(
    decoder: LobeDecoder, latents: Float[Tensor, "n l"], gaussians: Gaussians, *, base: bool
) -> Float[Tensor, "n l"]:
    """Transform latents of the lobes, and the weights of `decoder` inversely."""

    def decode(changed: Tensor, rows: slice) -> Tensor:
        return decoder(changed, gaussians.select(rows), base=base).flatten(1)

    transform, inverse = _decorrelation(latents, decode)
    with one_thread():
        decoder.basis.copy_(inverse @ decoder.basis)
        for weight in list(decoder.weights)[:1]:
            weight[:, STATICS:] = weight[:, STATICS:] @ inverse.T
    return latents @ transform


def _decorrelation(
    latents: Float[Tensor, "n l"], decode: Callable[[Tensor, slice], Tensor]
) -> tuple[Float[Tensor, "l l"], Float[Tensor, "l l"]]:
    """Return the transform of latents (as rows) and its inverse.

    After it, a unit along any axis changes the decoded values by 1 (root of the summed squares,
    mean over the Gaussians), and the latents are not correlated. So one step size fits all axes,
    and the entropy of each axis alone is that of the whole.
    """
    rows = slice(None, None, -(-len(latents) // SAMPLES))
    sample = latents[rows]
    start, columns = decode(sample, rows), []
    spread = sample.std(0, correction=min(1, len(sample) - 1))
    for i, size in enumerate((DIFFERENCE * spread).clamp_min(1e-4).tolist()):
        moved = sample.clone()
        moved[:, i] += size
        columns.append((decode(moved, rows) - start) / size)
    jacobian = torch.stack(columns, dim=2).double()
    with one_thread():
        metric = (jacobian.transpose(1, 2) @ jacobian).mean(0)
        ridge = RIDGE * metric.diagonal().mean().clamp_min(RIDGE)
        root = torch.linalg.cholesky(metric + ridge * torch.eye(len(metric)).to(metric))
        measured = latents.double() @ root
        covariance = torch.cov(measured.T) if len(latents) > 1 else torch.zeros_like(root)
        axes = torch.linalg.eigh(covariance).eigenvectors.flip(1)
        axes = axes * torch.where(axes.sum(0) < 0, -1.0, 1.0)  # fix the signs
        transform = root @ axes
        return transform.to(latents), torch.linalg.inv(transform).to(latents)
