"""Rotations as three small angles, each as fine as its Gaussian needs."""

import itertools
import math
from functools import cache

import torch
from jaxtyping import Float, Int, Integer, UInt8
from torch import Tensor, nn

from mobilegs.compress.codebooks import canonical_quats
from mobilegs.compress.uniform_quantizer import (
    ANGLE_STEPS,
    NUDGE,
    ScalarCodes,
    entropy,
    stepped,
)
from mobilegs.csrc import native
from mobilegs.render.project import rotation_matrices

# Turning by a small angle about an axis changes the covariance, relative to its size, by
# 1 + 2 sinh(d) at most, where d is the difference of the two other log-scales. From each of these
# differences on (in 256ths, where that passes 2^(c - 1/2)) an angle has one more bit.
LIMITS = (53, 210, 405, 600, 787, 970, 1151, 1329)
ANGLE_MIN = 1e-9
BLOCK = 1 << 16  # rows at a time where there may be many


def canonical_pairs(
    quats: Float[Tensor, "n 4"], log_scales: Float[Tensor, "n 3"]
) -> tuple[Float[Tensor, "n 4"], Float[Tensor, "n 3"]]:
    """The same ellipsoids, turned as little as possible: of 24 ways to name the axes the nearest.

    Axes may change places and signs as long as they stay right-handed. What is left of the turn
    is at most 63 degrees. Returns unit quaternions (wxyz, w >= 0) and log-scales.
    """
    unit = canonical_quats(quats)
    # a turn by q after the turn p that renames the axes has the real part <q, conjugate of p>
    best = torch.full_like(unit[:, 0], -1.0)
    kept = torch.zeros(len(unit), dtype=torch.long, device=unit.device)
    turns, orders = _renamings()
    turns = turns.to(unit)
    for i, turn in enumerate(turns):
        real = (unit * turn * turn.new_tensor([1.0, -1, -1, -1])).sum(1).abs()
        better = real > best + 1e-6  # ties go to the first
        best, kept = torch.where(better, real, best), torch.where(better, i, kept)
    turned = canonical_quats(_product(unit, turns[kept]))
    return turned, log_scales.gather(1, orders.to(kept.device)[kept])


def _renamings() -> tuple[Float[Tensor, "24 4"], Int[Tensor, "24 3"]]:
    """The turns that map axes to axes, as quaternions, and which axis each one comes from."""
    half = 0.5**0.5
    eighths = itertools.product((-half, 0.0, half), repeat=4)
    found = [torch.tensor(q) for q in itertools.product((-0.5, 0.5), repeat=4)]
    found += [q for q in map(torch.tensor, eighths) if abs(float(q @ q) - 1) < 1e-6]
    found += [row for row in torch.eye(4)]
    turns = torch.stack([q for q in found if (q[q.abs() > 1e-6][0] > 0)])
    matrices = rotation_matrices(turns)  # columns are where the axes go
    return turns, matrices.abs().argmax(dim=1)


def _product(a: Float[Tensor, "n 4"], b: Float[Tensor, "n 4"]) -> Float[Tensor, "n 4"]:
    aw, ax, ay, az = a.unbind(1)
    bw, bx, by, bz = b.unbind(1)
    return torch.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        dim=1,
    )


def rotation_vectors(quats: Float[Tensor, "n 4"]) -> Float[Tensor, "n 3"]:
    """Axis times angle (radians, at most pi) of each rotation."""
    unit = canonical_quats(quats)
    sine = unit[:, 1:].norm(dim=1, keepdim=True)
    angle = 2 * torch.atan2(sine, unit[:, :1])
    return unit[:, 1:] * (angle / sine.clamp_min(ANGLE_MIN))


def quats_of(vectors: Float[Tensor, "n 3"]) -> Float[Tensor, "n 4"]:
    """Unit quaternions (wxyz) of axis times angle."""
    angle = vectors.norm(dim=1, keepdim=True)
    share = torch.sin(angle / 2) / angle.clamp_min(ANGLE_MIN)
    # at no angle at all the share is 1/2
    share = torch.where(angle < ANGLE_MIN, 0.5, share)
    return torch.cat([torch.cos(angle / 2), vectors * share], dim=1)


def finer_bits(log_scales: Float[Tensor, "n 3"]) -> Int[Tensor, "n 3"]:
    """How many more bits the angle about each axis has, 0 to 8, by the two other log-scales."""
    a, b, c = log_scales.float().unbind(1)
    apart = torch.stack([b - c, a - c, a - b], dim=1).abs()
    # limits are whole 256ths: looking them up takes a third of the time of a search
    steps = (apart * 256).clamp_max(LIMITS[-1]).int()
    bits = _bits_by_steps().int().to(steps.device)
    return bits.index_select(0, steps.flatten()).reshape(steps.shape)


def finer_bits_of(codes: Int[Tensor, "n 3"], step: float) -> UInt8[Tensor, "n 3"]:
    """`finer_bits` of log-scales that are multiples of a step, with little memory beside them."""
    fast = native.finer_bits(codes, step, _bits_by_steps())
    if fast is not None:
        return fast
    found = torch.empty(codes.shape, dtype=torch.uint8, device=codes.device)
    for start in range(0, len(codes), BLOCK):
        rows = slice(start, start + BLOCK)
        found[rows] = finer_bits(codes[rows].float() * step)
    return found


@cache
def _bits_by_steps() -> UInt8[Tensor, "m"]:
    steps = torch.arange(LIMITS[-1] + 1, dtype=torch.int32)
    return torch.bucketize(steps, torch.tensor(LIMITS, dtype=torch.int32), right=True).byte()


class RotationCodes(nn.Module):
    """Quaternions `[n, 4]` held as three whole numbers each, for the scales that `scales` gives.

    About an axis with `b` finer bits the number `k` stands for the angle
    `((k + 1/2) / 2^b - 1/2) step`.

    Attributes:
        growth: logarithm of what the step, in radians, is now in units of what it was at first,
            a parameter.
        indices: the numbers, `[n, 3]`, a buffer.
    """

    indices: Tensor

    def __init__(self, scales: ScalarCodes, step: float, indices: Int[Tensor, "n 3"]) -> None:
        super().__init__()
        self.first = step
        self.growth = nn.Parameter(torch.zeros((), device=indices.device))
        self._scales = (scales,)  # in a tuple it is no part of this module
        self.register_buffer("indices", indices.detach().int())

    @property
    def step(self) -> Float[Tensor, ""]:
        """The step as it is now."""
        return (self.first * self.growth.exp()).clamp(*ANGLE_STEPS)

    @classmethod
    def fit(
        cls, quats: Float[Tensor, "n 4"], *, scales: ScalarCodes, step: float
    ) -> "RotationCodes":
        """The nearest codes of `quats`."""
        codes = cls(scales, step, torch.zeros_like(quats[:, 1:], dtype=torch.int32))
        codes.reassign(quats)
        return codes

    def forward(
        self, rows: Tensor | slice | None = None, wanted: Float[Tensor, "m 4"] | None = None
    ) -> Float[Tensor, "m 4"]:
        """Quaternions of all rows or of those that `rows` picks.

        With what these are `wanted` to be the step has a gradient, as that of `ScalarCodes`.
        """
        indices = self.indices if rows is None else self.indices[rows]
        multiples = _multiples(indices, finer_bits(self._scales[0](rows)))
        vectors = None if wanted is None else rotation_vectors(wanted.detach())
        return quats_of(stepped(multiples, self.step, vectors))

    @torch.no_grad()
    def reassign(self, quats: Float[Tensor, "n 4"]) -> None:
        """The nearest codes of new quaternions; the scales must have theirs already."""
        self.indices = encode_rotations(quats, self._scales[0](), self.step)

    def select(self, rows: Tensor) -> None:
        """Keep only the rows that `rows` picks; the scales keep their own."""
        self.indices = self.indices[rows]

    @torch.no_grad()
    def bits_by_growth(self, quats: Float[Tensor, "n 4"]) -> float:
        """By how many bits a row of codes grows with `growth`; finer bits are as many as before."""
        vectors, step = rotation_vectors(quats), self.step
        finer, coarser = (entropy(_cells(vectors, step * f)) for f in (1 / NUDGE, NUDGE))
        return (coarser - finer) / (2 * math.log(NUDGE))


def encode_rotations(
    quats: Float[Tensor, "n 4"], log_scales: Float[Tensor, "n 3"], step: float | Tensor
) -> Int[Tensor, "n 3"]:
    """Whole numbers for the angles of `quats`."""
    parts = torch.exp2(finer_bits(log_scales).float())
    return torch.floor((rotation_vectors(quats) / step + 0.5) * parts).int()


def decode_rotations(
    indices: Int[Tensor, "n 3"], finer: Integer[Tensor, "n 3"], step: float
) -> Float[Tensor, "n 4"]:
    """Unit quaternions of what `encode_rotations` gave, with the `finer_bits` that there are."""
    quats = native.room(len(indices), 4, device=indices.device)
    for start in range(0, len(indices), BLOCK):  # which a processor's cache holds
        rows = slice(start, start + BLOCK)
        quats[rows] = quats_of(_multiples(indices[rows], finer[rows]) * step)
    return quats


def _multiples(indices: Int[Tensor, "n 3"], finer: Integer[Tensor, "n 3"]) -> Tensor:
    return (indices.float() + 0.5) / torch.exp2(finer.float()) - 0.5


def _cells(vectors: Float[Tensor, "n 3"], step: Tensor) -> Int[Tensor, "n 3"]:
    return torch.floor(vectors / step + 0.5).int()
