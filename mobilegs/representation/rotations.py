"""Rotation quantisation: three angles, with more bits where a Gaussian is elongated."""

import itertools
from functools import cache

import torch
from jaxtyping import Float, Int, Integer, UInt8
from torch import Tensor

from mobilegs.csrc import binding
from mobilegs.render.project import rotation_matrices
from mobilegs.representation.codebooks import canonical_quats
from mobilegs.representation.uniform_quantizer import (
    ANGLE_STEP_RANGE,
    StepSizeQuantizer,
    UniformQuantizer,
    scale_multiples,
)

# A small rotation about an axis changes the covariance, relative to its size, by at most
# 1 + 2 sinh(d), where d is the difference of the two other log-scales. From each of these
# differences on (in 256ths, where that bound passes 2^(c - 1/2)) an angle has one more bit.
LIMITS = (53, 210, 405, 600, 787, 970, 1151, 1329)
ANGLE_MIN = 1e-9
BLOCK = 1 << 16  # rows per pass, which bounds the memory


def canonical_pairs(
    quats: Float[Tensor, "n 4"], log_scales: Float[Tensor, "n 3"]
) -> tuple[Float[Tensor, "n 4"], Float[Tensor, "n 3"]]:
    """Return the same ellipsoids with the smallest rotation among 24 equivalent ones.

    The 24 permute and flip the axes of the ellipsoid, keeping them right-handed. The smallest
    rotation is at most 63 degrees. Returns unit quaternions (wxyz, w >= 0) and log-scales.
    """
    unit = canonical_quats(quats)
    # rotation q after the axis permutation p has the real part <q, conjugate of p>
    best = torch.full_like(unit[:, 0], -1.0)
    kept = torch.zeros(len(unit), dtype=torch.long, device=unit.device)
    permutations, orders = _axis_permutations()
    permutations = permutations.to(unit)
    for i, quat in enumerate(permutations):
        real = (unit * quat * quat.new_tensor([1.0, -1, -1, -1])).sum(1).abs()
        better = real > best + 1e-6  # the first of equals wins
        best, kept = torch.where(better, real, best), torch.where(better, i, kept)
    smallest = canonical_quats(_product(unit, permutations[kept]))
    return smallest, log_scales.gather(1, orders.to(kept.device)[kept])


def _axis_permutations() -> tuple[Float[Tensor, "24 4"], Int[Tensor, "24 3"]]:
    """Return the rotations that map axes to axes, as quaternions, and the source of each axis."""
    half = 0.5**0.5
    eighths = itertools.product((-half, 0.0, half), repeat=4)
    units = [torch.tensor(q) for q in itertools.product((-0.5, 0.5), repeat=4)]
    units += [q for q in map(torch.tensor, eighths) if abs(float(q @ q) - 1) < 1e-6]
    units += [row for row in torch.eye(4)]
    quats = torch.stack([q for q in units if (q[q.abs() > 1e-6][0] > 0)])
    matrices = rotation_matrices(quats)  # columns are the images of the axes
    return quats, matrices.abs().argmax(dim=1)


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
    """Return axis times angle (radians, at most pi) of each rotation."""
    unit = canonical_quats(quats)
    sine = unit[:, 1:].norm(dim=1, keepdim=True)
    angle = 2 * torch.atan2(sine, unit[:, :1])
    return unit[:, 1:] * (angle / sine.clamp_min(ANGLE_MIN))


def quats_of(vectors: Float[Tensor, "n 3"]) -> Float[Tensor, "n 4"]:
    """Return the unit quaternions (wxyz) of axis times angle (radians)."""
    angle = vectors.norm(dim=1, keepdim=True)
    share = torch.sin(angle / 2) / angle.clamp_min(ANGLE_MIN)
    # the limit at angle 0
    share = torch.where(angle < ANGLE_MIN, 0.5, share)
    return torch.cat([torch.cos(angle / 2), vectors * share], dim=1)


def refinement_bits(log_scales: Float[Tensor, "n 3"]) -> Int[Tensor, "n 3"]:
    """Return the refinement bits of the angle about each axis, 0 to 8.

    They depend on the difference of the log-scales of the two other axes.
    """
    a, b, c = log_scales.float().unbind(1)
    apart = torch.stack([b - c, a - c, a - b], dim=1).abs()
    # limits are whole 256ths: a table takes a third of the time of a search
    entries = (apart * 256).clamp_max(LIMITS[-1]).int()
    bits = bits_table(entries.device).int()
    return bits.index_select(0, entries.flatten()).reshape(entries.shape)


def refinement_bits_of(codes: Int[Tensor, "n 3"], step_size: float) -> UInt8[Tensor, "n 3"]:
    """Return `refinement_bits` of the log-scales `codes * step_size`, in little memory."""
    fast = binding.refinement_bits(codes, step_size, bits_table())
    if fast is not None:
        return fast
    bits = torch.empty(codes.shape, dtype=torch.uint8, device=codes.device)
    for start in range(0, len(codes), BLOCK):
        rows = slice(start, start + BLOCK)
        bits[rows] = refinement_bits(codes[rows].float() * step_size)
    return bits


@cache
def bits_table(device: torch.device | str = "cpu") -> UInt8[Tensor, "m"]:
    """Return the refinement bits by difference of log-scales, in 256ths."""
    differences = torch.arange(LIMITS[-1] + 1, dtype=torch.int32)
    limits = torch.tensor(LIMITS, dtype=torch.int32)
    return torch.bucketize(differences, limits, right=True).byte().to(device)


class RotationQuantizer(StepSizeQuantizer):
    """Quaternions `[n, 4]` as three integers each, for the scales of the quantiser `scales`.

    About an axis with `b` refinement bits the integer `k` stands for the angle
    `((k + 1/2) / 2^b - 1/2) step_size`, in radians.
    """

    step_size_range = ANGLE_STEP_RANGE

    def __init__(
        self, scales: UniformQuantizer, step_size: float, indices: Int[Tensor, "n 3"]
    ) -> None:
        super().__init__(step_size, indices)
        self._scales = (scales,)  # a tuple, so that it is not a submodule

    @classmethod
    def fit(
        cls, quats: Float[Tensor, "n 4"], *, scales: UniformQuantizer, step_size: float
    ) -> "RotationQuantizer":
        """Return a quantiser with the nearest codes of `quats`."""
        quantizer = cls(scales, step_size, torch.zeros_like(quats[:, 1:], dtype=torch.int32))
        quantizer.reassign(quats)
        return quantizer

    def forward(
        self, rows: Tensor | slice | None = None, targets: Float[Tensor, "m 4"] | None = None
    ) -> Float[Tensor, "m 4"]:
        """Return the dequantised unit quaternions of `rows` (None: all).

        With `targets`, the unquantised quaternions, the step size has a gradient, as in
        `UniformQuantizer`.
        """
        indices = self.indices if rows is None else self.indices[rows]
        multiples = _multiples(indices, refinement_bits(self._scales[0](rows)))
        vectors = None if targets is None else rotation_vectors(targets.detach())
        return quats_of(scale_multiples(multiples, self.step_size, vectors))

    @torch.no_grad()
    def reassign(self, quats: Float[Tensor, "n 4"]) -> None:
        """Assign the nearest codes of new quaternions; reassign the scales first."""
        self.indices = encode_rotations(quats, self._scales[0](), self.step_size)

    @staticmethod
    def nearest(values: Float[Tensor, "n 4"], step_size: Float[Tensor, ""]) -> Int[Tensor, "n 3"]:
        """Return the integers without refinement bits, which do not depend on the step size."""
        return torch.floor(rotation_vectors(values) / step_size + 0.5).int()


def encode_rotations(
    quats: Float[Tensor, "n 4"], log_scales: Float[Tensor, "n 3"], step_size: float | Tensor
) -> Int[Tensor, "n 3"]:
    """Return the codes of the rotation angles of `quats`."""
    parts = torch.exp2(refinement_bits(log_scales).float())
    return torch.floor((rotation_vectors(quats) / step_size + 0.5) * parts).int()


def decode_rotations(
    indices: Int[Tensor, "n 3"], bits: Integer[Tensor, "n 3"], step_size: float
) -> Float[Tensor, "n 4"]:
    """Return the unit quaternions of codes with `bits` refinement bits each."""
    quats = binding.empty(len(indices), 4, device=indices.device)
    for start in range(0, len(indices), BLOCK):
        rows = slice(start, start + BLOCK)
        quats[rows] = quats_of(_multiples(indices[rows], bits[rows]) * step_size)
    return quats


def _multiples(indices: Int[Tensor, "n 3"], bits: Integer[Tensor, "n 3"]) -> Tensor:
    return (indices.float() + 0.5) / torch.exp2(bits.float()) - 0.5
