"""Colour decoders: matrices or networks from a few latents to spherical harmonics."""

import math
from functools import partial
from typing import Literal, NamedTuple, get_args

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import leaky_relu, linear

from mobilegs.csrc import binding
from mobilegs.representation.float16 import SIGNIFICAND_BITS, round_float16
from mobilegs.reproducible import product

ColorName = Literal["linear", "networks", "latent_networks"]
COLORS: tuple[ColorName, ...] = get_args(ColorName)
OCTAVES = 16
ENCODED = 2 * 3 * OCTAVES
CONTEXT = 13
LATENTS = 3  # static latents, and view latents of networks; matrices may have more of the latter
HIDDEN = 64
SLOPE = 0.01  # of the leaky ReLUs
CHUNK = 65536
LR = 2e-3  # of the regression, decays linearly to 0


class ColorShape(NamedTuple):
    """Shape of a colour decoder."""

    colors: str = "linear"
    """One of `COLORS`."""
    degree: int = 1
    """Degree of the spherical harmonics, 0 to 3."""
    latents: int = 2 * LATENTS
    """Latents per Gaussian: three static ones, followed by the view latents."""

    @property
    def latents_max(self) -> int:
        """The number of harmonics that latents can distinguish; networks take six latents."""
        rest = 3 * (self.degree + 1) ** 2 - 3
        return LATENTS + (max(LATENTS, rest) if self.colors == "linear" else LATENTS)


def contract(positions: Float[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
    """Contract space into [0, 1]^3; the unit ball keeps its shape.

    `|x| > 1 -> (2 - 1 / |x|) x / |x|` (Mip-NeRF 360, Eq. 10), then `x / 4 + 1/2`. Every operation
    is one float32 rounding, in this order: the encoding multiplies the result by up to 2^15, so
    other decoders must find the same bits.
    """
    x, y, z = positions.unbind(1)
    # torch's float32 root is sometimes off by a bit; a rounded float64 root is not
    length = (x * x + y * y + z * z).double().sqrt().to(x.dtype).clamp_min(1)[:, None]
    return (2 - 1 / length) * (positions / length) * 0.25 + 0.5


def encode_frequencies(unit: Float[Tensor, "n 3"]) -> Float[Tensor, "n 96"]:
    """Return `sin(2^k pi u)` for each axis and k = 0 .. 15 (k runs fastest), then the cosines.

    Angles are reduced before the product with pi. Products with powers of 2 are exact, so all
    octaves are equally accurate.
    """
    octaves = torch.exp2(torch.arange(-1, OCTAVES - 1, device=unit.device, dtype=unit.dtype))
    angles = (unit[:, :, None] * octaves).flatten(1)  # in whole turns, [n, 48]
    angles.sub_(angles.round()).mul_(2 * math.pi)
    encoded = unit.new_empty(len(unit), ENCODED)
    torch.sin(angles, out=encoded[:, : ENCODED // 2])
    torch.cos(angles, out=encoded[:, ENCODED // 2 :])
    return encoded


def _xavier(generator: torch.Generator, networks: int, rows: int, columns: int) -> nn.Parameter:
    """Draw the matrices of several networks, one below the other, Xavier-uniform."""
    bound = math.sqrt(6 / (rows + columns))
    return nn.Parameter((2 * torch.rand(networks * rows, columns, generator=generator) - 1) * bound)


def _make_linear(
    latents: Float[Tensor, "h 3"],
    first: Float[Tensor, "h i"],
    last: Float[Tensor, "o h"],
    out: Float[Tensor, "o 3"],
) -> None:
    """Make a network the map `out` of its latents, whose columns of `first` are `latents`.

    A pair of hidden units with opposite signs makes a leaky ReLU linear:
    `leaky(a) - leaky(-a) = (1 + slope) a`. Six of the 64 units form such pairs; the others keep
    random input weights, and their output weights are 0.
    """
    pair = torch.cat([torch.eye(LATENTS), -torch.eye(LATENTS)]).to(first)
    first[: 2 * LATENTS] = 0
    latents[: 2 * LATENTS] = pair
    last.zero_()
    last[:, : 2 * LATENTS] = out.to(last) @ pair.T / (1 + SLOPE)


class ColorDecoder(nn.Module):
    """A decoder from latents, and positions, to spherical harmonics of the colour.

    There are no biases. Weights are rounded to float16, as a file stores them.
    """

    significand_bits = SIGNIFICAND_BITS  # of the weights; networks have fewer with mode `sq`

    def forward(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n v"],
    ) -> Float[Tensor, "n k 3"]:
        """Return the harmonics.

        `positions` are normalised (`PositionGrid.normalised`) and get no gradient. Only
        `AppearanceDecoder` uses them.
        """
        raise NotImplementedError

    @torch.no_grad()
    def decode(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n v"],
    ) -> Float[Tensor, "n k 3"]:
        """Compute `forward` without gradients, in chunks that bound the memory."""
        chunks = zip(positions.split(CHUNK), static.split(CHUNK), view.split(CHUNK), strict=True)
        return torch.cat([self(*chunk) for chunk in chunks])

    def init_linear(self, directions: Float[Tensor, "d v"]) -> None:
        """Set the weights so that the output is `[static, directions @ view]` everywhere."""
        raise NotImplementedError

    @property
    def latent_weights(self) -> tuple[Float[Tensor, "_ 3"], Float[Tensor, "_ v"]]:
        """The matrices that static and view latents are multiplied by."""
        raise NotImplementedError

    def _rounded(self, weights: Float[Tensor, "..."]) -> Float[Tensor, "..."]:
        return round_float16(weights, self.significand_bits)


class LinearDecoder(ColorDecoder):
    """Two matrices: static latents -> degree 0, view latents -> the other harmonics.

    Codes can hold a mean, in place of biases. (This project; the paper has networks.)
    """

    def __init__(self, degree: int = 1, view: int = LATENTS) -> None:
        """Start at zero view dependence; `degree` is 0 to 3, `view` the number of view latents."""
        super().__init__()
        self.degree = degree
        self.static2 = nn.Parameter(torch.eye(3, LATENTS))
        self.view2 = nn.Parameter(torch.zeros(3 * (degree + 1) ** 2 - 3, view))

    def forward(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n v"],
    ) -> Float[Tensor, "n k 3"]:
        latents, matrix = torch.cat([static, view], dim=1), self.matrix().T
        return product(latents, matrix, matrix.new_zeros(matrix.shape[1])).unflatten(1, (-1, 3))

    @torch.no_grad()
    def decode(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n v"],
    ) -> Float[Tensor, "n k 3"]:
        """Compute `forward` without gradients, in memory from `binding.empty`."""
        matrix, device = self.matrix(), static.device
        latents = binding.empty(len(static), matrix.shape[1], dtype=static.dtype, device=device)
        torch.cat([static, view], dim=1, out=latents)
        sh = binding.empty(len(static), matrix.shape[0], dtype=static.dtype, device=device)
        return torch.mm(latents, matrix.T, out=sh).unflatten(1, (-1, 3))

    def matrix(self) -> Float[Tensor, "o l"]:
        """Return both matrices as one: the product is bound by memory, not by arithmetic."""
        return torch.block_diag(self._rounded(self.static2), self._rounded(self.view2))

    @torch.no_grad()
    def init_linear(self, directions: Float[Tensor, "d v"]) -> None:
        self.static2.copy_(torch.eye(3, LATENTS))
        self.view2.copy_(directions)

    @property
    def latent_weights(self) -> tuple[Float[Tensor, "_ 3"], Float[Tensor, "_ v"]]:
        return self.static2, self.view2


class AppearanceDecoder(ColorDecoder):
    """Networks from position and latents to harmonics, as in the paper's release.

    | input | hidden | output |
    |---|---|---|
    | encoded position, 96 | 64 ReLU | context, 13 |
    | context and static latents, 16 | 64 LeakyReLU | degree 0, 3 |
    | context and view latents, 16 | 64 LeakyReLU | other degrees, 9 for degree 1 |

    Outputs are coefficient-major; degree 2 has 24 others, degree 3 has 45. The 9,792 weights for
    degree 1 are Xavier-uniform at the start.
    """

    def __init__(self, generator: torch.Generator, degree: int = 1) -> None:
        """Draw the weights from `generator`; `degree` is 0 to 3."""
        super().__init__()
        self.degree = degree
        weights = partial(_xavier, generator, 1)
        self.context1 = weights(HIDDEN, ENCODED)
        self.context2 = weights(CONTEXT, HIDDEN)
        self.static1 = weights(HIDDEN, CONTEXT + LATENTS)
        self.static2 = weights(3, HIDDEN)
        self.view1 = weights(HIDDEN, CONTEXT + LATENTS)
        self.view2 = weights(3 * (degree + 1) ** 2 - 3, HIDDEN)

    def forward(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n 3"],
    ) -> Float[Tensor, "n k 3"]:
        encoded = encode_frequencies(contract(positions.detach()))
        hidden = torch.relu_(linear(encoded, self._rounded(self.context1)))
        context = linear(hidden, self._rounded(self.context2))
        # both heads as one of twice the width: this is bound by memory, not by arithmetic
        of_static = self.static1.split([CONTEXT, LATENTS], dim=1)
        of_view = self.view1.split([CONTEXT, LATENTS], dim=1)
        latent_weights = torch.block_diag(of_static[1], of_view[1])
        first = torch.cat(
            [torch.cat([of_static[0], of_view[0]]), latent_weights], dim=1
        )  # [128, 19]
        last = torch.block_diag(self.static2, self.view2)  # [12, 128] for degree 1
        hidden = linear(torch.cat([context, static, view], dim=1), self._rounded(first))
        out = linear(leaky_relu(hidden, SLOPE, inplace=True), self._rounded(last))
        return out.unflatten(1, (-1, 3))

    @torch.no_grad()
    def decode(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n 3"],
    ) -> Float[Tensor, "n k 3"]:
        """Compute `forward` without gradients, in C++ where that is possible."""
        if binding.supports(positions, static, view, self.context1):
            weights = [self._rounded(matrix) for matrix in self.parameters()]
            return binding.decode_colors(positions, static, view, weights=weights)
        return super().decode(positions, static, view)

    @torch.no_grad()
    def init_linear(self, directions: Float[Tensor, "d 3"]) -> None:
        _make_linear(self.static1[:, CONTEXT:], self.static1, self.static2, torch.eye(3))
        _make_linear(self.view1[:, CONTEXT:], self.view1, self.view2, directions)

    @property
    def latent_weights(self) -> tuple[Float[Tensor, "_ 3"], Float[Tensor, "_ 3"]]:
        return self.static1[:, CONTEXT:], self.view1[:, CONTEXT:]


class LatentDecoder(ColorDecoder):
    """Networks from all latents to harmonics: the paper's Eq. 6.

    `MLP_d` gives degree 0 and `MLP_v` the others, each from static and view latents together, with
    64 hidden units and leaky ReLUs. The 1,536 weights for degree 1 are Xavier-uniform at the start.

    Attributes:
        both1: the first layers, `[128, 6]`: 64 rows of `MLP_d`, then 64 of `MLP_v`.
        static2, view2: the last layers, `[3, 64]` and `[9, 64]` for degree 1.
    """

    def __init__(self, generator: torch.Generator, degree: int = 1) -> None:
        """Draw the weights from `generator`; `degree` is 0 to 3."""
        super().__init__()
        self.degree = degree
        self.both1 = _xavier(generator, 2, HIDDEN, 2 * LATENTS)
        self.static2 = _xavier(generator, 1, 3, HIDDEN)
        self.view2 = _xavier(generator, 1, 3 * (degree + 1) ** 2 - 3, HIDDEN)

    def forward(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n 3"],
    ) -> Float[Tensor, "n k 3"]:
        first = self._rounded(self.both1)
        last = torch.block_diag(*(self._rounded(part) for part in (self.static2, self.view2)))
        hidden = leaky_relu(linear(torch.cat([static, view], dim=1), first), SLOPE, inplace=True)
        return linear(hidden, last).unflatten(1, (-1, 3))

    @torch.no_grad()
    def init_linear(self, directions: Float[Tensor, "d 3"]) -> None:
        first = self.both1
        _make_linear(first[:HIDDEN, :LATENTS], first[:HIDDEN], self.static2, torch.eye(3))
        _make_linear(first[HIDDEN:, LATENTS:], first[HIDDEN:], self.view2, directions)

    @property
    def latent_weights(self) -> tuple[Float[Tensor, "_ 3"], Float[Tensor, "_ 3"]]:
        return self.both1[:, :LATENTS], self.both1[:, LATENTS:]


def color_decoder(shape: ColorShape, generator: torch.Generator) -> ColorDecoder:
    """Return a decoder of a shape; `generator` draws the weights of networks."""
    if shape.colors == "linear":
        return LinearDecoder(shape.degree, shape.latents - LATENTS)
    networks = LatentDecoder if shape.colors == "latent_networks" else AppearanceDecoder
    return networks(generator, shape.degree)


def fit_appearance(
    decoder: ColorDecoder,
    positions: Float[Tensor, "n 3"],
    sh: Float[Tensor, "n k 3"],
    *,
    generator: torch.Generator,
    steps: int = 400,
    batch: int = 4096,
) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n v"]]:
    """Fit latents, and the weights of `decoder`, to given harmonics.

    Static latents are the degree-0 coefficients, view latents the projection of the others on
    their principal directions (0 if there are none). Distances between latents are then distances
    between colours, as k-means needs. The decoder starts as the best linear map. Networks are then
    regressed with Adam on random batches, so that they also use their other inputs.

    Args:
        positions: normalised.
        sh: the harmonics, of the decoder's degree.
        generator: a CPU generator, which draws the batches.
        steps, batch: of the regression.

    Returns:
        Static and view latents, without gradients.
    """
    target = sh.detach()
    rest = target[:, 1:].flatten(1)  # [n, 9] for degree 1
    count = decoder.latent_weights[1].shape[1]
    directions = torch.zeros(rest.shape[1], count, dtype=torch.float64)
    if rest.shape[1]:
        gram = (rest.T.double() @ rest.double()).cpu()
        directions = torch.linalg.eigh(gram).eigenvectors[:, -count:].flip(1)
        directions = directions * torch.where(directions.sum(0) < 0, -1.0, 1.0)  # fix the signs
    decoder.init_linear(directions.float())
    static, view = target[:, 0], rest @ directions.to(rest)
    if isinstance(decoder, LinearDecoder):
        return static.clone(), view
    optimizer = torch.optim.Adam(decoder.parameters(), lr=LR, eps=1e-15)
    for step in range(steps):
        optimizer.param_groups[0]["lr"] = LR * (1 - step / steps)
        rows = torch.randint(len(sh), (batch,), generator=generator).to(sh.device)
        # harmonics are orthonormal: this is the mean squared error of the colour over directions
        loss = (decoder(positions[rows], static[rows], view[rows]) - target[rows]).square().mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    return static.clone(), view
