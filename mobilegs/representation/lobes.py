"""Lobe decoder: turns a few latents per Gaussian into harmonics of opacity and weight.

Lobes are spherical harmonics of the direction from the eye: one set for the logit of the opacity,
one for phi, the weight before its ReLU. (This project; the paper has a network per view.)
"""

from dataclasses import dataclass
from itertools import pairwise

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import pad

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render.view_network import STATICS, static_inputs
from mobilegs.representation.float16 import SIGNIFICAND_BITS, round_float16
from mobilegs.reproducible import product
from mobilegs.spherical_harmonics import C0

LATENTS_MAX = 32
HIDDEN_MAX = 256
HIDDEN_LAYERS = 3
CHUNK = 65536
COEFFICIENT_MAX = 1e4  # exceeds that of any scene; sums of its squares are finite in float32


@dataclass(frozen=True)
class LobeShape:
    """Shape of a `LobeDecoder`; InputError if it is out of range."""

    degree: int
    """Degree of the lobes' harmonics, 0 to 3."""
    latents: int
    """Latents per Gaussian, 0 to 32, in addition to the base opacity."""
    hidden: tuple[int, ...] = ()
    """Widths of the hidden layers of a network that also sees the Gaussian's other attributes:
    at most three, each 1 to 256. Empty: the decoder is linear."""

    def __post_init__(self) -> None:
        sound = 0 <= self.degree <= 3 and 0 <= self.latents <= LATENTS_MAX
        sound &= len(self.hidden) <= HIDDEN_LAYERS and all(
            1 <= width <= HIDDEN_MAX for width in self.hidden
        )
        if not sound:
            raise InputError(f"a lobe decoder cannot have the shape {self}")

    @property
    def outputs(self) -> int:
        """Coefficients per Gaussian."""
        return 2 * (self.degree + 1) ** 2


class LobeDecoder(nn.Module):
    """`bias + latents @ basis`, plus the output of an optional network.

    The network has the inputs of the paper's view network (colour harmonics, proportions of the
    scales, rotation) with the latents instead of the direction, and ReLU between its layers. Its
    output starts at zero. The logit of the base opacity is added to the constant coefficient of
    the opacity. Weights are rounded to float16, as a file stores them.
    """

    def __init__(self, shape: LobeShape, generator: torch.Generator) -> None:
        super().__init__()
        self.shape = shape
        self.significand_bits = SIGNIFICAND_BITS  # of the matrices; mode `sq` has fewer
        self.bias = nn.Parameter(torch.zeros(shape.outputs))
        with torch.no_grad():
            self.bias[1] = 1 / C0  # phi = 1
        # orthonormal directions, without the constant coefficient of the opacity, which comes first
        start = torch.randn(shape.outputs - 1, shape.latents, generator=generator)
        rows = torch.linalg.qr(start).Q.T
        spare = shape.latents - len(rows)  # latents beyond the number of directions
        self.basis = nn.Parameter(pad(rows, (1, 0, 0, spare)))
        self.weights, self.offsets = nn.ParameterList(), nn.ParameterList()
        if not shape.hidden:
            return
        widths = (STATICS + shape.latents, *shape.hidden)
        for inputs, outputs in pairwise(widths):
            bound = inputs**-0.5  # the default of torch
            drawn = torch.rand(outputs, inputs + 1, generator=generator)
            drawn = (2 * drawn - 1) * bound
            self.weights.append(nn.Parameter(drawn[:, 1:].contiguous()))
            self.offsets.append(nn.Parameter(drawn[:, 0].contiguous()))
        self.weights.append(nn.Parameter(torch.zeros(shape.outputs, widths[-1])))

    def forward(
        self, latents: Float[Tensor, "n l"], gaussians: Gaussians, *, base: bool
    ) -> Float[Tensor, "n m 2"]:
        """Return the lobes, m = (degree + 1)^2, opacity before phi.

        With `base`, the logits of `gaussians` are added to the constant coefficient of the
        opacity. Otherwise that coefficient comes from latents and network too.
        """
        numbers, rows = latents, round_float16(self.basis, self.significand_bits)
        if base:  # one more latent, with a fixed direction
            numbers = torch.cat([latents, gaussians.logit_opacities[:, None]], dim=1)
            known = torch.zeros_like(self.bias)[None]
            known[0, 0] = 1 / C0
            rows = torch.cat([rows, known])
        lobes = product(numbers, rows, round_float16(self.bias))
        if self.shape.hidden:
            others = static_inputs(gaussians)
            if self.shape.latents:
                # latents distinguish the Gaussians: without gradients to colour and shape a step
                # takes less time
                others = others.detach()
            hidden = torch.cat([others, latents], dim=1)
            for weight, offset in zip(self.weights, self.offsets, strict=False):
                rounded = round_float16(weight, self.significand_bits)
                hidden = product(hidden, rounded.T, round_float16(offset)).relu_()
            last = round_float16(self.weights[-1], self.significand_bits)
            lobes = product(hidden, last.T, lobes)
        return lobes.unflatten(1, (-1, 2))

    @torch.no_grad()
    def decode(
        self, latents: Float[Tensor, "n l"], gaussians: Gaussians, *, base: bool
    ) -> Float[Tensor, "n m 2"]:
        """Compute `forward` without gradients, in C++ or in chunks that bound the memory.

        Coefficients are clamped to `COEFFICIENT_MAX`, which only hostile files exceed.
        """
        if binding.supports(latents, self.bias, *gaussians.tensors().values()):
            return self._decode_natively(latents, gaussians, base=base).clamp_(
                -COEFFICIENT_MAX, COEFFICIENT_MAX
            )
        parts = [
            self(
                latents[start : start + CHUNK],
                gaussians.select(slice(start, start + CHUNK)),
                base=base,
            )
            for start in range(0, len(latents), CHUNK)
        ]
        return torch.cat(parts).clamp_(-COEFFICIENT_MAX, COEFFICIENT_MAX)

    def _decode_natively(
        self, latents: Float[Tensor, "n l"], gaussians: Gaussians, *, base: bool
    ) -> Float[Tensor, "n m 2"]:
        """Compute `forward` in C++, with one matrix for hidden units, latents and base."""
        last = [round_float16(self.basis, self.significand_bits).T]
        if self.shape.hidden:
            last.insert(0, round_float16(self.weights[-1], self.significand_bits))
        if base:
            last.append(torch.eye(self.shape.outputs, 1) / C0)
        pairs = zip(self.offsets, self.weights, strict=False)
        return binding.decode_lobes(
            latents,
            gaussians,
            base=base,
            hidden=[(round_float16(o), round_float16(w, self.significand_bits)) for o, w in pairs],
            bias=round_float16(self.bias),
            last=torch.cat(last, dim=1),
        )
