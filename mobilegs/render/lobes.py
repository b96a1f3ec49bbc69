"""Lobes: view-dependent opacity and phi of a Gaussian, as spherical harmonics.

The paper's network gives the opacity o and phi of each Gaussian in each view (section 3.2,
`view_network.py`). Renderers take lobes instead, wherever these come from: learned per Gaussian,
decoded from latents, or the network's output for one view. The lobes of a Gaussian are `[m, 2]`,
m = (degree + 1)^2 in the basis of `sh_basis`: the first column holds the logit of the opacity, the
second phi before its ReLU.

The same formula: `evaluate_lobes` in csrc/core.h, `lobes_along` in the viewer's wide.wgsl and
packed.wgsl, and the sigmoid and maximum of `look_at` in project.wgsl; each also in GLSL.
"""

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.reproducible import sigmoid
from mobilegs.spherical_harmonics import C0, sh_basis


def evaluate_lobes(
    lobes: Float[Tensor, "n m 2"], directions: Float[Tensor, "n 3"]
) -> tuple[Float[Tensor, "n"], Float[Tensor, "n"]]:
    """Return opacities in (0, 1) and phi (>= 0) along unit `directions` from the camera.

    `o = sigmoid(sum(basis lobes[:, 0]))`, `phi = max(0, sum(basis lobes[:, 1]))`.
    """
    basis = sh_basis(directions, lobe_degree(lobes))
    logits, raw_phi = (basis[:, :, None] * lobes).sum(1).unbind(1)
    return sigmoid(logits), raw_phi.relu()


def lobe_degree(lobes: Float[Tensor, "n m 2"]) -> int:
    """Return the degree of the lobes, 0 to 3. Raises InputError for any other shape."""
    if lobes.shape[1] not in (1, 4, 9, 16):
        raise InputError(f"{lobes.shape[1]} spherical harmonics per lobe: use 1, 4, 9 or 16")
    return round(lobes.shape[1] ** 0.5) - 1


def constant_lobes(
    logits: Float[Tensor, "n"], raw_phi: Float[Tensor, "n"] | float = 1.0
) -> Float[Tensor, "n 1 2"]:
    """Return lobes of degree 0, which are the same in every direction."""
    raw_phi = torch.as_tensor(raw_phi, dtype=logits.dtype, device=logits.device)
    return torch.stack([logits, raw_phi.expand_as(logits)], dim=1)[:, None, :] / C0


def opacity_lobes(opacities: Float[Tensor, "n"]) -> Float[Tensor, "n 1 2"]:
    """Return lobes of degree 0 with these opacities, in [0, 1], and phi = 1.

    The logits of 0 and 1 are infinite: opacities nearer to them than 1e-7 move to that distance,
    and keep their gradient. Raises InputError for opacities outside [0, 1].
    """
    if bool(((opacities < 0) | (opacities > 1)).any()):
        raise InputError(
            f"opacities lie between {opacities.min():.3g} and {opacities.max():.3g}: [0, 1] was "
            "expected; logits need a sigmoid"
        )
    inside = opacities + (opacities.clamp(1e-7, 1 - 1e-7) - opacities).detach()
    return constant_lobes(inside.logit())
