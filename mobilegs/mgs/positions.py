"""Positions as the file stores them: halves in a frame, in Morton order, as differences."""

import struct
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Float16, UInt16, UInt64
from torch import Tensor

from mobilegs.compress.float16 import to_half
from mobilegs.csrc import native
from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.bits import bit_lengths, pack_bits, unpack_bits

AXIS_BITS = 16
CLASSES = 3 * AXIS_BITS + 1  # bit lengths 0 to 48
# (shift, mask) that move 16 bits apart, to every third place
_SPREAD = (
    (32, 0xFFFF00000000FFFF),
    (16, 0x00FF0000FF0000FF),
    (8, 0xF00F00F00F00F00F),
    (4, 0x30C30C30C30C30C3),
    (2, 0x9249249249249249),
)


@dataclass(frozen=True, eq=False)
class Frame:
    """Where the halves of a file lie in the world.

    A half `p` stands for the normalised position `u = p * 2^exponent` (exact) and for the world
    position `center + radius * u`, in float32: one rounded product and one rounded sum, so
    that every decoder finds the same bits.

    Halves below 2^-14 are evenly spaced. So the grid has the step `2^(exponent - 24) * radius`
    up to `2^(exponent - 14) * radius` from the centre, along each axis, and eleven digits
    beyond, without a limit. With exponent 11 a file is as true as with plain halves (0, whose
    digits near the centre's planes are wasted) and 0.4 to 0.6 bytes per Gaussian smaller.

    Attributes:
        center: world units, float32.
        radius: world units, a float32 value; the appearance decoder contracts what lies
            farther from the centre.
        exponent: 0 to 14.
    """

    center: Float[Tensor, "3"]
    radius: float
    exponent: int = 11

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", self.center.detach().cpu().float())
        object.__setattr__(self, "radius", float(np.float32(self.radius)))

    @classmethod
    def around(cls, means: Float[Tensor, "n 3"]) -> "Frame":
        """The median as centre, and a radius that holds 4 of 5 Gaussians."""
        center = means.detach().median(dim=0).values
        distances = (means.detach() - center).norm(dim=1).sort().values
        return cls(center, max(float(distances[int(0.8 * (len(distances) - 1))]), 1e-6))

    def store(self, means: Float[Tensor, "n 3"]) -> Float16[Tensor, "n 3"]:
        """World positions as halves; no gradients."""
        relative = (means.detach() - self.center.to(means)) / self.radius
        halves = to_half(relative * 2.0**-self.exponent)
        return halves + 0.0  # there is one zero, the positive one

    def normalised(self, stored: Float16[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
        """Stored positions in units of the radius, as the appearance decoder takes them."""
        return stored.float() * 2.0**self.exponent

    def world(self, stored: Float16[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
        """World positions of stored ones, in float32."""
        offsets = self.normalised(stored) * torch.tensor(self.radius, device=stored.device)
        return self.center.to(stored.device) + offsets

    def round(self, means: Float[Tensor, "n 3"]) -> Float[Tensor, "n 3"]:
        """World positions where the file will put them; the gradient is the identity's."""
        return _RoundPositions.apply(means, self)  # pyright: ignore[reportReturnType]


class _RoundPositions(torch.autograd.Function):
    @staticmethod
    def forward(ctx, means: Tensor, frame: Frame) -> Tensor:
        return frame.world(frame.store(means)).to(means.dtype)

    @staticmethod
    def backward(ctx, *grads: Tensor):
        return grads[0], None


def morton_codes(stored: Float16[Tensor, "n 3"]) -> UInt64[np.ndarray, "n"]:
    """48-bit codes: the halves as ordered 16-bit numbers, bits interleaved, x lowest."""
    ordered = half_to_ordered(stored.cpu().numpy().view(np.uint16)).astype(np.uint64)
    for shift, mask in _SPREAD:
        ordered = (ordered | (ordered << np.uint64(shift))) & np.uint64(mask)
    x, y, z = ordered.T
    return x | (y << np.uint64(1)) | (z << np.uint64(2))


def from_morton(codes: UInt64[np.ndarray, "n"]) -> Float16[Tensor, "n 3"]:
    """The stored positions of 48-bit codes."""
    axes = (codes[:, None] >> np.arange(3, dtype=np.uint64)) & np.uint64(_SPREAD[-1][1])
    for (shift, _), mask in zip(
        reversed(_SPREAD), [m for _, m in reversed(_SPREAD[:-1])] + [0xFFFF], strict=True
    ):
        axes = (axes | (axes >> np.uint64(shift))) & np.uint64(mask)
    halves = ordered_to_half(axes.astype(np.uint16)).view(np.float16)
    return torch.from_numpy(halves)


def half_to_ordered(bits: UInt16[np.ndarray, "..."]) -> UInt16[np.ndarray, "..."]:
    """Bit patterns of halves as whole numbers in the order of their values."""
    return np.where(bits >> 15 == 1, ~bits, bits | np.uint16(0x8000))


def ordered_to_half(numbers: UInt16[np.ndarray, "..."]) -> UInt16[np.ndarray, "..."]:
    """The inverse of `half_to_ordered`."""
    return np.where(numbers >> 15 == 1, numbers & np.uint16(0x7FFF), ~numbers)


def encode_positions(stored: Float16[Tensor, "n 3"]) -> bytes:
    """The `morton-class` codec, for finite positions already in Morton order.

    Differences of consecutive codes (the first from 0): their bit lengths are rANS symbols,
    what follows the leading one is written as it is.
    """
    codes = morton_codes(stored)
    differences = np.diff(codes, prepend=np.uint64(0))
    classes = bit_lengths(differences).astype(np.uint16)
    # on small scenes 49 frequency tables cost more than they save
    coded = min((rans.encode(classes, CLASSES, contextual=c) for c in (False, True)), key=len)
    widths = np.maximum(classes.astype(np.int64) - 1, 0)
    lead = np.where(classes > 0, np.uint64(1) << widths.astype(np.uint64), np.uint64(0))
    return struct.pack("<I", len(coded)) + coded + pack_bits(differences ^ lead, widths)


def decode_positions(data: bytes | memoryview, count: int) -> Float16[Tensor, "n 3"]:
    """The `count` positions that `encode_positions` wrote.

    Raises:
        InputError: the bytes are damaged, or hold a position that is not finite.
    """
    rans.read_head(_classes(data), count, CLASSES)
    halves = native.decode_positions(data, count)
    if halves is None:
        return decode_by_definition(data, count)
    return torch.from_numpy(halves.view(np.float16))


def decode_by_definition(data: bytes | memoryview, count: int) -> Float16[Tensor, "n 3"]:
    """What `decode_positions` does, by its definition."""
    coded = _classes(data)
    classes = rans.decode_by_definition(coded, count, CLASSES)
    widths = np.maximum(classes.astype(np.int64) - 1, 0)
    lead = np.where(classes > 0, np.uint64(1) << widths.astype(np.uint64), np.uint64(0))
    differences = unpack_bits(data[4 + len(coded) :], widths) | lead
    codes = np.cumsum(differences, dtype=np.uint64)
    # a sum passes 2^48 long before it could wrap around 2^64: no overflow goes unseen
    if (codes >> np.uint64(3 * AXIS_BITS)).any():
        raise InputError("the stream of positions leaves its 48-bit grid")
    stored = from_morton(codes)
    if not stored.isfinite().all():
        raise InputError("the stream of positions holds numbers that are not finite")
    return stored


def _classes(data: bytes | memoryview) -> memoryview:
    """The stream of bit lengths in that of positions."""
    length = struct.unpack_from("<I", data)[0] if len(data) >= 4 else len(data)
    if 4 + length > len(data):
        raise InputError("the stream of positions is too short to hold what its header says")
    return memoryview(data)[4 : 4 + length]
