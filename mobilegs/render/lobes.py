"""Lobes: how opaque and how heavy a Gaussian is, as a function of the direction it is seen from.

Whatever makes them (learned per Gaussian, decoded from latents, a network asked anew for every
view), a renderer only ever sees spherical harmonics, and a frame pays a dot product. The lobes of
a Gaussian are `[m, 2]`, m = (degree + 1)^2 with the basis of `sh_basis`: in the first column those
of the opacity's logit, in the second those of phi before its ReLU.
"""

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.spherical_harmonics import C0, sh_basis


def seen_along(
    lobes: Float[Tensor, "n m 2"], directions: Float[Tensor, "n 3"]
) -> tuple[Float[Tensor, "n"], Float[Tensor, "n"]]:
    """Opacity in (0, 1) and phi (>= 0) along unit `directions` from the eye to the Gaussians."""
    basis = sh_basis(directions, lobe_degree(lobes))
    logits, raw_phi = (basis[:, :, None] * lobes).sum(1).unbind(1)
    return logits.sigmoid(), raw_phi.relu()


def lobe_degree(lobes: Float[Tensor, "n m 2"]) -> int:
    """Degree of the lobes' spherical harmonics, 0 to 3; InputError for any other shape."""
    if lobes.shape[1] not in (1, 4, 9, 16):
        raise InputError(f"{lobes.shape[1]} spherical harmonics per lobe: use 1, 4, 9 or 16")
    return round(lobes.shape[1] ** 0.5) - 1


def constant_lobes(
    logits: Float[Tensor, "n"], raw_phi: Float[Tensor, "n"] | float = 1.0
) -> Float[Tensor, "n 1 2"]:
    """Lobes of degree 0 that look the same from everywhere: phi = 1 unless said otherwise."""
    raw_phi = torch.as_tensor(raw_phi, dtype=logits.dtype, device=logits.device)
    return torch.stack([logits, raw_phi.expand_as(logits)], dim=1)[:, None, :] / C0
