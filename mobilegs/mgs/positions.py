"""Positions as a file stores them: float16 numbers in a grid, in Morton order, as differences."""

import struct
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Float16, UInt16, UInt64
from torch import Tensor

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.bits import bit_lengths, pack_bits, unpack_bits
from mobilegs.representation.float16 import to_float16

AXIS_BITS = 16
CLASSES = 3 * AXIS_BITS + 1  # bit lengths 0 to 48
# (shift, mask) that spread 16 bits to every third place
_SPREAD = (
    (32, 0xFFFF00000000FFFF),
    (16, 0x00FF0000FF0000FF),
    (8, 0xF00F00F00F00F00F),
    (4, 0x30C30C30C30C30C3),
    (2, 0x9249249249249249),
)


@dataclass(frozen=True, eq=False)
class PositionGrid:
    """The map from stored float16 positions to world space.

    A stored number `p` stands for the normalised position `u = p * 2^exponent` (exact in float32)
    and for the world position `center + radius * u`, computed in float32 with one rounded product
    and one rounded sum, so that every decoder finds the same bits.

    float16 numbers below 2^-14 are evenly spaced. The grid is therefore uniform, with a spacing of
    `2^(exponent - 24) * radius`, up to `2^(exponent - 14) * radius` from the centre along each
    axis; beyond, it has 11 significant bits, without a limit. Exponent 11 is as accurate as
    exponent 0, which wastes bits near the planes through the centre, and 0.4 to 0.6 bytes per
    Gaussian smaller.

    Attributes:
        center: world units, float32.
        radius: world units, a float32 value; networks of colour contract the space outside of it.
        exponent: 0 to 14.
    """

    center: Float[Tensor, "3"]
    radius: float
    exponent: int = 11

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", self.center.detach().cpu().float())
        object.__setattr__(self, "radius", float(np.float32(self.radius)))

    @classmethod
    def around(cls, means: Float[Tensor, "n 3"]) -> "PositionGrid":
        """Return a grid at the median of `means` whose radius holds 80 % of them."""
        center = means.detach().median(dim=0).values
        distances = (means.detach() - center).norm(dim=1).sort().values
        return cls(center, max(float(distances[int(0.8 * (len(distances) - 1))]), 1e-6))

    def store(self, means: Float[Tensor, "n 3"]) -> Float16[Tensor, "n 3"]:
        """Return world positions as stored numbers, without gradients."""
        relative = (means.detach() - self.center.to(means)) / self.radius
        stored = to_float16(relative * 2.0**-self.exponent)
        return stored + 0.0  # -0 becomes +0

    def normalised(self, stored: Float16[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
        """Return stored positions in units of the radius, the input of networks of colour."""
        return stored.float() * 2.0**self.exponent

    def world(self, stored: Float16[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
        """Return the world positions of stored ones, in float32."""
        offsets = self.normalised(stored) * torch.tensor(self.radius, device=stored.device)
        return self.center.to(stored.device) + offsets

    def round(self, means: Float[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
        """Round world positions to the grid; the gradient is the identity's."""
        return _RoundPositions.apply(means, self)  # pyright: ignore[reportReturnType]


class _RoundPositions(torch.autograd.Function):
    @staticmethod
    def forward(ctx, means: Tensor, grid: PositionGrid) -> Tensor:
        return grid.world(grid.store(means)).to(means.dtype)

    @staticmethod
    def backward(ctx, *grads: Tensor):
        return grads[0], None


def morton_codes(stored: Float16[Tensor, "n 3"]) -> UInt64[np.ndarray, "n"]:
    """Return 48-bit Morton codes: ordered 16-bit numbers with interleaved bits, x lowest."""
    ordered = float16_to_ordered(stored.cpu().numpy().view(np.uint16)).astype(np.uint64)
    for shift, mask in _SPREAD:
        ordered = (ordered | (ordered << np.uint64(shift))) & np.uint64(mask)
    x, y, z = ordered.T
    return x | (y << np.uint64(1)) | (z << np.uint64(2))


def positions_from_morton(codes: UInt64[np.ndarray, "n"]) -> Float16[Tensor, "n 3"]:
    """Return the stored positions of 48-bit Morton codes."""
    axes = (codes[:, None] >> np.arange(3, dtype=np.uint64)) & np.uint64(_SPREAD[-1][1])
    for (shift, _), mask in zip(
        reversed(_SPREAD), [m for _, m in reversed(_SPREAD[:-1])] + [0xFFFF], strict=True
    ):
        axes = (axes | (axes >> np.uint64(shift))) & np.uint64(mask)
    patterns = ordered_to_float16(axes.astype(np.uint16))
    return torch.from_numpy(patterns.view(np.float16))


def float16_to_ordered(patterns: UInt16[np.ndarray, "..."]) -> UInt16[np.ndarray, "..."]:
    """Map float16 bit patterns to integers that sort like the values."""
    return np.where(patterns >> 15 == 1, ~patterns, patterns | np.uint16(0x8000))


def ordered_to_float16(numbers: UInt16[np.ndarray, "..."]) -> UInt16[np.ndarray, "..."]:
    """Invert `float16_to_ordered`."""
    return np.where(numbers >> 15 == 1, numbers & np.uint16(0x7FFF), ~numbers)


def encode_positions(stored: Float16[Tensor, "n 3"]) -> bytes:
    """Encode finite positions in Morton order with the codec `morton-class`.

    The bit lengths of the differences between consecutive codes (the first difference is from 0)
    are rANS symbols. The bits after each leading one are written as they are.
    """
    codes = morton_codes(stored)
    differences = np.diff(codes, prepend=np.uint64(0))
    classes = bit_lengths(differences).astype(np.uint16)
    # in small scenes 49 frequency tables take more than they save
    coded = min((rans.encode(classes, CLASSES, contextual=c) for c in (False, True)), key=len)
    widths = np.maximum(classes.astype(np.int64) - 1, 0)
    lead = np.where(classes > 0, np.uint64(1) << widths.astype(np.uint64), np.uint64(0))
    return struct.pack("<I", len(coded)) + coded + pack_bits(differences ^ lead, widths)


def decode_positions(data: bytes | memoryview, count: int) -> Float16[Tensor, "n 3"]:
    """Decode the `count` positions that `encode_positions` wrote.

    Raises InputError if the bytes are damaged, or hold a position that is not finite.
    """
    rans.check_header(_classes(data), count, CLASSES)
    patterns = binding.decode_positions(data, count)
    if patterns is None:
        return decode_reference(data, count)
    return torch.from_numpy(patterns.view(np.float16))


def decode_reference(data: bytes | memoryview, count: int) -> Float16[Tensor, "n 3"]:
    """The numpy reference of `decode_positions`."""
    coded = _classes(data)
    classes = rans.decode_reference(coded, count, CLASSES)
    widths = np.maximum(classes.astype(np.int64) - 1, 0)
    lead = np.where(classes > 0, np.uint64(1) << widths.astype(np.uint64), np.uint64(0))
    differences = unpack_bits(data[4 + len(coded) :], widths) | lead
    codes = np.cumsum(differences, dtype=np.uint64)
    # a sum passes 2^48 long before it could wrap around 2^64, so this finds every overflow
    if (codes >> np.uint64(3 * AXIS_BITS)).any():
        raise InputError("the stream of positions leaves its 48-bit grid")
    stored = positions_from_morton(codes)
    if not stored.isfinite().all():
        raise InputError("the stream of positions holds numbers that are not finite")
    return stored


def _classes(data: bytes | memoryview) -> memoryview:
    """Return the rANS stream of bit lengths inside a stream of positions."""
    length = struct.unpack_from("<I", data)[0] if len(data) >= 4 else len(data)
    if 4 + length > len(data):
        raise InputError("the stream of positions is shorter than its header says")
    return memoryview(data)[4 : 4 + length]
