"""Lobes from a few numbers per Gaussian: what a file stores of the dependence on the view."""

from dataclasses import dataclass
from itertools import pairwise

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import linear, pad

from mobilegs.compress.float16 import DIGITS, round_half
from mobilegs.csrc import native
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render.view_network import STATICS, statics
from mobilegs.spherical_harmonics import C0

LATENTS_MAX = 32
HIDDEN_MAX = 256
HIDDEN_LAYERS = 3
LEARNING_RATE = 2e-3  # of the regression, falling to 0
ALIKE = 1e-4  # differences of coefficients that tell nothing
CHUNK = 65536
LARGEST = 1e4  # of coefficients that are drawn: beyond any scene, and its square sums in float32


@dataclass(frozen=True)
class LobeShape:
    """What a `LobeDecoder` is made of."""

    degree: int
    """Degree of the lobes' harmonics, 0 to 3."""
    latents: int
    """Numbers per Gaussian beside the base opacity."""
    hidden: tuple[int, ...] = ()
    """Widths of hidden layers that also look at the Gaussian's other attributes; none: linear."""

    def __post_init__(self) -> None:
        sound = 0 <= self.degree <= 3 and 0 <= self.latents <= LATENTS_MAX
        sound &= len(self.hidden) <= HIDDEN_LAYERS and all(
            1 <= width <= HIDDEN_MAX for width in self.hidden
        )
        if not sound:
            raise InputError(f"lobes cannot be decoded with {self}")

    @property
    def outputs(self) -> int:
        """Numbers in the lobes of a Gaussian."""
        return 2 * (self.degree + 1) ** 2


class LobeDecoder(nn.Module):
    """Latents -> lobes: `bias + latents @ basis`, and a small network's word beside it.

    The network, if there is one, sees what the paper's sees (harmonics, proportions of the
    scales, rotation) with the latents in the place of the direction; ReLU between its layers,
    zero at first. The base opacity's logit is added to the constant part of the opacity's lobe.
    Always computes with weights rounded to half precision, as they are stored.
    """

    def __init__(self, shape: LobeShape, generator: torch.Generator) -> None:
        super().__init__()
        self.shape = shape
        self.digits = DIGITS  # of the matrices; a coding may have fewer
        self.bias = nn.Parameter(torch.zeros(shape.outputs))
        with torch.no_grad():
            self.bias[1] = 1 / C0  # phi = 1
        # orthonormal directions; the constant part of the opacity, which comes first, has its base
        start = torch.randn(shape.outputs - 1, shape.latents, generator=generator)
        rows = torch.linalg.qr(start).Q.T
        spare = shape.latents - len(rows)  # more latents than there are directions idle
        self.basis = nn.Parameter(pad(rows, (1, 0, 0, spare)))
        self.weights, self.offsets = nn.ParameterList(), nn.ParameterList()
        if not shape.hidden:
            return
        widths = (STATICS + shape.latents, *shape.hidden)
        for inputs, outputs in pairwise(widths):
            bound = inputs**-0.5  # torch's default
            drawn = torch.rand(outputs, inputs + 1, generator=generator)
            drawn = (2 * drawn - 1) * bound
            self.weights.append(nn.Parameter(drawn[:, 1:].contiguous()))
            self.offsets.append(nn.Parameter(drawn[:, 0].contiguous()))
        self.weights.append(nn.Parameter(torch.zeros(shape.outputs, widths[-1])))

    def forward(
        self, latents: Float[Tensor, "n l"], gaussians: Gaussians, *, base: bool
    ) -> Float[Tensor, "n m 2"]:
        """The lobes; `base` says whether the opacities of `gaussians` are to be added.

        Without it the constant part of the opacity, too, comes from latents and network.
        """
        numbers, rows = latents, round_half(self.basis, self.digits)
        if base:  # one more number, whose direction is known
            numbers = torch.cat([latents, gaussians.logit_opacities[:, None]], dim=1)
            known = torch.zeros_like(self.bias)[None]
            known[0, 0] = 1 / C0
            rows = torch.cat([rows, known])
        lobes = torch.addmm(round_half(self.bias), numbers, rows)
        if self.shape.hidden:
            others = statics(gaussians)
            if self.shape.latents:
                # with numbers of its own, a Gaussian need not bend its colour and shape to be told
                # from others; without this gradient a step is shorter
                others = others.detach()
            hidden = torch.cat([others, latents], dim=1)
            for weight, offset in zip(self.weights, self.offsets, strict=False):
                hidden = linear(hidden, round_half(weight, self.digits), round_half(offset)).relu_()
            lobes = torch.addmm(lobes, hidden, round_half(self.weights[-1], self.digits).T)
        return lobes.unflatten(1, (-1, 2))

    @torch.no_grad()
    def decode(
        self, latents: Float[Tensor, "n l"], gaussians: Gaussians, *, base: bool
    ) -> Float[Tensor, "n m 2"]:
        """`forward` without gradients, by the C++ library or in chunks that bound its memory.

        Coefficients beyond `LARGEST`, as a hostile file may ask for, become the largest.
        """
        if native.takes(latents, self.bias, *gaussians.tensors().values()):
            return self._decode_natively(latents, gaussians, base=base).clamp_(-LARGEST, LARGEST)
        parts = [
            self(
                latents[start : start + CHUNK],
                gaussians.select(slice(start, start + CHUNK)),
                base=base,
            )
            for start in range(0, len(latents), CHUNK)
        ]
        return torch.cat(parts).clamp_(-LARGEST, LARGEST)

    def _decode_natively(
        self, latents: Float[Tensor, "n l"], gaussians: Gaussians, *, base: bool
    ) -> Float[Tensor, "n m 2"]:
        """The sums of `forward` are one product with all that they are made of."""
        last = [round_half(self.basis, self.digits).T]
        if self.shape.hidden:
            last.insert(0, round_half(self.weights[-1], self.digits))
        if base:
            last.append(torch.eye(self.shape.outputs, 1) / C0)
        pairs = zip(self.offsets, self.weights, strict=False)
        return native.decode_lobes(
            latents,
            gaussians,
            base=base,
            hidden=[(round_half(o), round_half(w, self.digits)) for o, w in pairs],
            bias=round_half(self.bias),
            last=torch.cat(last, dim=1),
        )


def fit_lobes(
    decoder: LobeDecoder,
    lobes: Float[Tensor, "n m 2"],
    gaussians: Gaussians,
    *,
    metric: Float[Tensor, "m m"],
    base: bool,
    rotated: bool,
    generator: torch.Generator,
    steps: int = 400,
    batch: int = 4096,
) -> Float[Tensor, "n l"]:
    """Latents, and weights in `decoder`, that reproduce given lobes as well as they can.

    The basis becomes the lobes' first principal directions, the latents the coordinates along
    them; without `rotated`, the latents are the coefficients themselves, all of them. A network,
    if there is one, is then regressed to what they leave (Adam, random batches). Lobes that are
    all alike have no principal directions: the basis stays as it is, and the latents are 0.
    `metric` is the mean product of the harmonics over the directions that matter: what is never
    looked at counts less. With `base` the opacities of `gaussians` are the constant part of the
    opacity's lobe, and only the rest is fitted. Draws from `generator`, a CPU one. Returns the
    latents, without gradients.
    """
    shape, target = decoder.shape, lobes.detach().flatten(1)
    if base:
        target = target.clone()
        target[:, 0] = 0
    mean = target.mean(0)
    if rotated and (target - mean).abs().max() < ALIKE:
        with torch.no_grad():
            decoder.bias.copy_(mean)
        return target.new_zeros(len(target), shape.latents)
    if rotated:
        root, inverse = _roots(metric, target.device)
        whitened = (target - mean).double() @ root
        found = torch.linalg.eigh(whitened.T @ whitened).eigenvectors.flip(1)
        directions = found[:, : shape.latents]
        directions = directions * torch.where(directions.sum(0) < 0, -1.0, 1.0)  # fix the signs
        basis, latents = (inverse @ directions).T, whitened @ directions
    else:
        basis = torch.eye(shape.outputs, device=target.device)[int(base) :]
        latents = (target - mean) @ basis.T
    spare = shape.latents - len(basis)  # sub-vectors may be longer than what is left for them
    with torch.no_grad():
        decoder.bias.copy_(mean)
        decoder.basis.copy_(torch.cat([basis, basis.new_zeros(spare, shape.outputs)]))
    latents = torch.cat([latents.to(target), target.new_zeros(len(target), spare)], dim=1)
    if shape.hidden:
        root = _roots(metric, target.device)[0].to(target)
        _regress(decoder, latents, lobes.detach(), gaussians, root, base, generator, steps, batch)
    return latents


def _regress(
    decoder: LobeDecoder,
    latents: Tensor,
    lobes: Tensor,
    gaussians: Gaussians,
    root: Tensor,
    base: bool,
    generator: torch.Generator,
    steps: int,
    batch: int,
) -> None:
    optimizer = torch.optim.Adam(decoder.parameters(), lr=LEARNING_RATE, eps=1e-15)
    for step in range(steps):
        optimizer.param_groups[0]["lr"] = LEARNING_RATE * (1 - step / steps)
        rows = torch.randint(len(lobes), (batch,), generator=generator).to(lobes.device)
        found = decoder(latents[rows], gaussians.select(rows), base=base)
        loss = ((found - lobes[rows]).flatten(1) @ root).square().mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()


def _roots(metric: Tensor, device: torch.device) -> tuple[Tensor, Tensor]:
    """Square root of the metric for both columns of the lobes, of mean 1, and its inverse."""
    metric = metric.double().cpu()
    metric = metric * (len(metric) / metric.trace())
    values, vectors = torch.linalg.eigh(metric)
    values = values.clamp_min(1e-2).sqrt()  # what is never seen is not free either
    root = vectors * values @ vectors.T
    inverse = vectors / values @ vectors.T
    both = torch.eye(2, dtype=torch.float64)
    return torch.kron(root, both).to(device), torch.kron(inverse, both).to(device)
