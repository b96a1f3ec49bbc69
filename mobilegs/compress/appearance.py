"""Colour from a few numbers per Gaussian: the matrices, or networks, that decode its harmonics."""

import math
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import leaky_relu, linear

from mobilegs.compress.float16 import DIGITS, round_half
from mobilegs.csrc import native

COLORS = ("linear", "networks")
OCTAVES = 16
ENCODED = 2 * 3 * OCTAVES
CONTEXT = 13
LATENTS = 3  # each of the static and the view latents; of the latter matrices may have more
HIDDEN = 64
SLOPE = 0.01  # of the leaky ReLUs
CHUNK = 65536
LEARNING_RATE = 2e-3  # of the regression, falling to 0


class ColorShape(NamedTuple):
    """What colours are made of, and how."""

    colors: str = "linear"
    """One of `COLORS`."""
    degree: int = 1
    """Of the spherical harmonics, 0 to 3."""
    latents: int = 2 * LATENTS
    """Numbers of a Gaussian: three static ones, and behind them those of the view."""

    @property
    def latents_max(self) -> int:
        """More would say nothing: there are no more harmonics. Networks take six."""
        rest = 3 * (self.degree + 1) ** 2 - 3
        return LATENTS + (max(LATENTS, rest) if self.colors == "linear" else LATENTS)


def contract(positions: Float[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
    """All of space into [0, 1]^3: the unit ball keeps its shape, the rest shrinks around it.

    `|x| > 1 -> (2 - 1 / |x|) x / |x|` (Mip-NeRF 360's Eq. 10), then `x / 4 + 1/2`. Every
    operation is one float32 rounding, in this order: the encoding multiplies what comes out by
    up to 2^15, so a decoder elsewhere must find the same bits.
    """
    x, y, z = positions.unbind(1)
    # torch's float32 root is off by a bit now and then; a rounded float64 one is not
    length = (x * x + y * y + z * z).double().sqrt().to(x.dtype).clamp_min(1)[:, None]
    return (2 - 1 / length) * (positions / length) * 0.25 + 0.5


def encode_frequencies(unit: Float[Tensor, "n 3"]) -> Float[Tensor, "n 96"]:
    """`sin(2^k pi u)` of all axes and k = 0 .. 15 (k runs faster), then all the cosines.

    Angles are reduced before the product with pi, which is exact for powers of 2, so the
    highest octave is as accurate as the lowest.
    """
    octaves = torch.exp2(torch.arange(-1, OCTAVES - 1, device=unit.device, dtype=unit.dtype))
    angles = (unit[:, :, None] * octaves).flatten(1)  # in whole turns, [n, 48]
    angles.sub_(angles.round()).mul_(2 * math.pi)
    encoded = unit.new_empty(len(unit), ENCODED)
    torch.sin(angles, out=encoded[:, : ENCODED // 2])
    torch.cos(angles, out=encoded[:, ENCODED // 2 :])
    return encoded


class LinearDecoder(nn.Module):
    """Latents -> spherical harmonics: degree 0 of the static ones, the others of the view ones.

    A matrix each, without biases: what latents are added to is for their codes to hold. Computes
    with the matrices rounded to half precision, as they are stored.
    """

    def __init__(self, degree: int = 1, view: int = LATENTS) -> None:
        """`degree` is that of the harmonics, 0 to 3; `view` counts the view latents."""
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
        """Spherical harmonics of the colour, which do not depend on the positions."""
        return linear(torch.cat([static, view], dim=1), self._matrix()).unflatten(1, (-1, 3))

    @torch.no_grad()
    def decode(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n v"],
    ) -> Float[Tensor, "n k 3"]:
        """`forward` without gradients, written where it stays."""
        matrix, device = self._matrix(), static.device
        latents = native.room(len(static), matrix.shape[1], dtype=static.dtype, device=device)
        torch.cat([static, view], dim=1, out=latents)
        sh = native.room(len(static), matrix.shape[0], dtype=static.dtype, device=device)
        return torch.mm(latents, matrix.T, out=sh).unflatten(1, (-1, 3))

    def _matrix(self) -> Float[Tensor, "o l"]:
        """Both matrices as one, since memory, not arithmetic, is what takes the time."""
        return torch.block_diag(round_half(self.static2), round_half(self.view2))

    @torch.no_grad()
    def start_linear(self, directions: Float[Tensor, "d v"]) -> None:
        """Make the output `[static, directions @ view]`."""
        self.static2.copy_(torch.eye(3, LATENTS))
        self.view2.copy_(directions)

    @property
    def of_latents(self) -> tuple[Float[Tensor, "_ 3"], Float[Tensor, "_ v"]]:
        """What static and view latents are multiplied by."""
        return self.static2, self.view2


class AppearanceDecoder(nn.Module):
    """Position and latents -> spherical harmonics (paper's MLP_d and MLP_v, which have degree 1).

    Encoded position 96 -> 64 ReLU -> 13 numbers of context; context and static latents
    16 -> 64 LeakyReLU -> 3 (degree 0); context and view latents 16 -> 64 LeakyReLU -> 9 (degree 1;
    24 up to degree 2, 45 up to degree 3, none for degree 0; coefficient-major). No biases, 9,792
    weights, Xavier-uniform at first. Always computes with its weights rounded to half precision,
    as they are stored.
    """

    def __init__(self, generator: torch.Generator, degree: int = 1) -> None:
        """`degree` is that of the harmonics, 0 to 3."""
        super().__init__()
        self.digits = DIGITS  # of the weights; a coding may have fewer
        self.degree = degree

        def weights(rows: int, columns: int) -> nn.Parameter:
            bound = math.sqrt(6 / (rows + columns))
            drawn = torch.rand(rows, columns, generator=generator)
            return nn.Parameter((2 * drawn - 1) * bound)

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
        """Spherical harmonics of the colour.

        `positions` are the stored ones, normalised (`Frame.normalised`): no gradient reaches
        them.
        """
        encoded = encode_frequencies(contract(positions.detach()))
        hidden = torch.relu_(linear(encoded, round_half(self.context1, self.digits)))
        context = linear(hidden, round_half(self.context2, self.digits))
        # both heads as one, twice as wide: memory, not arithmetic, is what takes the time
        of_static = self.static1.split([CONTEXT, LATENTS], dim=1)
        of_view = self.view1.split([CONTEXT, LATENTS], dim=1)
        of_latents = torch.block_diag(of_static[1], of_view[1])
        first = torch.cat([torch.cat([of_static[0], of_view[0]]), of_latents], dim=1)  # [128, 19]
        last = torch.block_diag(self.static2, self.view2)  # [12, 128] for degree 1
        hidden = linear(torch.cat([context, static, view], dim=1), round_half(first, self.digits))
        out = linear(leaky_relu(hidden, SLOPE, inplace=True), round_half(last, self.digits))
        return out.unflatten(1, (-1, 3))

    @torch.no_grad()
    def decode(
        self,
        positions: Float[Tensor, "n 3"],
        static: Float[Tensor, "n 3"],
        view: Float[Tensor, "n 3"],
    ) -> Float[Tensor, "n k 3"]:
        """`forward` without gradients, by the C++ library or in chunks that bound its memory."""
        if native.takes(positions, static, view, self.context1):
            weights = [round_half(matrix, self.digits) for matrix in self.parameters()]
            return native.decode_colors(positions, static, view, weights=weights)
        chunks = zip(positions.split(CHUNK), static.split(CHUNK), view.split(CHUNK), strict=True)
        return torch.cat([self(*chunk) for chunk in chunks])

    @torch.no_grad()
    def start_linear(self, directions: Float[Tensor, "d 3"]) -> None:
        """Make the output `[static, directions @ view]`, whatever the position.

        A pair of hidden units with opposite signs makes a leaky ReLU linear:
        `leaky(a) - leaky(-a) = (1 + slope) a`. Six of the 64 units are set so; the others keep
        random inputs and start without a voice.
        """
        for first, last, out in (
            (self.static1, self.static2, torch.eye(3)),
            (self.view1, self.view2, directions),
        ):
            pair = torch.cat([torch.eye(LATENTS), -torch.eye(LATENTS)]).to(first)
            first[: 2 * LATENTS] = 0
            first[: 2 * LATENTS, CONTEXT:] = pair
            last.zero_()
            last[:, : 2 * LATENTS] = out.to(last) @ pair.T / (1 + SLOPE)

    @property
    def of_latents(self) -> tuple[Float[Tensor, "_ 3"], Float[Tensor, "_ 3"]]:
        """What static and view latents are multiplied by."""
        return self.static1[:, CONTEXT:], self.view1[:, CONTEXT:]


ColorDecoder = LinearDecoder | AppearanceDecoder


def color_decoder(shape: ColorShape, generator: torch.Generator) -> ColorDecoder:
    """The decoder of a shape; `generator` draws the weights of networks."""
    if shape.colors == "linear":
        return LinearDecoder(shape.degree, shape.latents - LATENTS)
    return AppearanceDecoder(generator, shape.degree)


def fit_appearance(
    decoder: ColorDecoder,
    positions: Float[Tensor, "n 3"],
    sh: Float[Tensor, "n k 3"],
    *,
    generator: torch.Generator,
    steps: int = 400,
    batch: int = 4096,
) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n v"]]:
    """Latents, and weights in `decoder`, that reproduce given harmonics as well as they can.

    The static latents are the degree-0 coefficients, the view latents the projection of the
    others on their principal directions (0 if there are none): distances between latents
    are distances between colours, which is what k-means needs. The decoder starts as the best
    linear one. Networks are then regressed (Adam on random batches), so that position tells them
    some of what three numbers cannot. Moving the latents afterwards gained nothing on real scenes.
    Returns (static, view) without gradients. Draws from `generator`, a CPU one.
    """
    target = sh.detach()
    rest = target[:, 1:].flatten(1)  # [n, 9] for degree 1
    count = decoder.of_latents[1].shape[1]
    directions = torch.zeros(rest.shape[1], count, dtype=torch.float64)
    if rest.shape[1]:
        gram = (rest.T.double() @ rest.double()).cpu()
        directions = torch.linalg.eigh(gram).eigenvectors[:, -count:].flip(1)
        directions = directions * torch.where(directions.sum(0) < 0, -1.0, 1.0)  # fix the signs
    decoder.start_linear(directions.float())
    static, view = target[:, 0], rest @ directions.to(rest)
    if isinstance(decoder, LinearDecoder):
        return static.clone(), view
    optimizer = torch.optim.Adam(decoder.parameters(), lr=LEARNING_RATE, eps=1e-15)
    for step in range(steps):
        optimizer.param_groups[0]["lr"] = LEARNING_RATE * (1 - step / steps)
        rows = torch.randint(len(sh), (batch,), generator=generator).to(sh.device)
        # harmonics are orthonormal: this is the colour's mean squared error over directions
        loss = (decoder(positions[rows], static[rows], view[rows]) - target[rows]).square().mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    return static.clone(), view
