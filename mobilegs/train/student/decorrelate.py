"""Latents in coordinates in which equal steps are equal errors, and numbers tell most apart."""

from collections.abc import Callable

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.compress.appearance import ColorDecoder
from mobilegs.compress.lobes import LobeDecoder
from mobilegs.gaussians import Gaussians
from mobilegs.render.view_network import STATICS

SAMPLES = 65536
NUDGE = 1e-2  # in standard deviations
RIDGE = 1e-6  # of the mean sensitivity: what nobody sees still has a size


@torch.no_grad()
def decorrelate_appearance(
    decoder: ColorDecoder,
    positions: Float[Tensor, "n 3"],
    static: Float[Tensor, "n 3"],
    view: Float[Tensor, "n v"],
) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n v"]]:
    """Static and view latents after a linear change each, which the decoder's weights undo."""
    found = []
    for latents, columns in zip((static, view), decoder.of_latents, strict=True):

        def decoded(changed: Tensor, rows: slice, of_static: bool = latents is static) -> Tensor:
            both = (changed, view[rows]) if of_static else (static[rows], changed)
            return decoder(positions[rows], *both).flatten(1)

        there, back = _axes(latents, decoded)
        columns.copy_(columns @ back.T)
        found.append(latents @ there)
    return found[0], found[1]


@torch.no_grad()
def decorrelate_lobes(
    decoder: LobeDecoder, latents: Float[Tensor, "n l"], gaussians: Gaussians, *, base: bool
) -> Float[Tensor, "n l"]:
    """Latents of the lobes after a linear change, which the decoder's weights undo."""

    def decoded(changed: Tensor, rows: slice) -> Tensor:
        return decoder(changed, gaussians.select(rows), base=base).flatten(1)

    there, back = _axes(latents, decoded)
    decoder.basis.copy_(back @ decoder.basis)
    for weight in list(decoder.weights)[:1]:
        weight[:, STATICS:] = weight[:, STATICS:] @ back.T
    return latents @ there


def _axes(
    latents: Float[Tensor, "n l"], decoded: Callable[[Tensor, slice], Tensor]
) -> tuple[Float[Tensor, "l l"], Float[Tensor, "l l"]]:
    """Matrices from latents (as rows) to the new coordinates, and back.

    There, a unit along any axis changes what is decoded by 1 in the mean over the Gaussians
    (root of the summed squares), and the coordinates are not correlated.
    """
    rows = slice(None, None, -(-len(latents) // SAMPLES))  # every so many
    some = latents[rows]
    start, columns = decoded(some, rows), []
    spread = some.std(0, correction=min(1, len(some) - 1))
    for i, size in enumerate((NUDGE * spread).clamp_min(1e-4).tolist()):
        moved = some.clone()
        moved[:, i] += size
        columns.append((decoded(moved, rows) - start) / size)
    slopes = torch.stack(columns, dim=2).double()
    metric = (slopes.transpose(1, 2) @ slopes).mean(0)
    ridge = RIDGE * metric.diagonal().mean().clamp_min(RIDGE)
    root = torch.linalg.cholesky(metric + ridge * torch.eye(len(metric)).to(metric))
    measured = latents.double() @ root
    covariance = torch.cov(measured.T) if len(latents) > 1 else torch.zeros_like(root)
    axes = torch.linalg.eigh(covariance).eigenvectors.flip(1)
    axes = axes * torch.where(axes.sum(0) < 0, -1.0, 1.0)  # fix the signs
    there = root @ axes
    return there.to(latents), torch.linalg.inv(there).to(latents)
