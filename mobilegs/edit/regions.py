"""Regions that an edit keeps or removes: boxes, spheres and half-spaces, and their texts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.render.project import rotation_matrices

REGIONS_MAX = 100  # in one text
Number = float | int
Triple = tuple[Number, Number, Number]


@dataclass(frozen=True)
class Box:
    """A box, which may be turned around its centre.

    Attributes:
        low, high: opposite corners before the turn, world units.
        quaternion: the turn, w x y z of any length but 0.
    """

    low: Triple
    high: Triple
    quaternion: tuple[Number, Number, Number, Number] = (1.0, 0.0, 0.0, 0.0)

    def contains(self, means: Float[Tensor, "n 3"]) -> Bool[Tensor, "n"]:
        low, high = (torch.tensor(end, dtype=torch.float64) for end in (self.low, self.high))
        turn = rotation_matrices(torch.tensor([self.quaternion], dtype=torch.float64))[0]
        inside = (means.double() - (low + high) / 2) @ turn  # row vectors: the inverse turn
        return (inside.abs() <= (high - low) / 2).all(1)


@dataclass(frozen=True)
class Sphere:
    """A sphere: centre and radius in world units."""

    center: Triple
    radius: Number

    def contains(self, means: Float[Tensor, "n 3"]) -> Bool[Tensor, "n"]:
        away = means.double() - torch.tensor(self.center, dtype=torch.float64)
        return away.norm(dim=1) <= self.radius


@dataclass(frozen=True)
class HalfSpace:
    """All points x with `normal . x < offset`: those below a floor whose normal points up.

    Attributes:
        normal: length 1.
        offset: world units.
    """

    normal: Triple
    offset: Number

    def contains(self, means: Float[Tensor, "n 3"]) -> Bool[Tensor, "n"]:
        return means.double() @ torch.tensor(self.normal, dtype=torch.float64) < self.offset


Region = Box | Sphere | HalfSpace


def parsed_boxes(text: str, option: str) -> list[Box]:
    """Return boxes from `X0 Y0 Z0 X1 Y1 Z1 [QW QX QY QZ]`, several separated by `;`.

    Raises InputError, which names the `option`, for any other text.
    """
    shape = "X0 Y0 Z0 X1 Y1 Z1, and for a turned box also QW QX QY QZ"
    boxes = []
    for numbers in _parts(text, (6, 10), option, shape):
        corners = np.array(numbers[:6]).reshape(2, 3)
        low, high = corners.min(0), corners.max(0)
        if (low == high).any():
            raise InputError(f"{option}: the box is flat, its corners need different coordinates")
        turn = numbers[6:] or [1.0, 0.0, 0.0, 0.0]
        if not any(turn):
            raise InputError(f"{option}: the quaternion of a turn cannot be 0 0 0 0")
        boxes.append(Box(tuple(low.tolist()), tuple(high.tolist()), tuple(turn)))  # pyright: ignore[reportArgumentType]
    return boxes


def parsed_spheres(text: str, option: str) -> list[Sphere]:
    """Return spheres from `X Y Z RADIUS`, several separated by `;`; raises as `parsed_boxes`."""
    spheres = []
    for x, y, z, radius in _parts(text, (4,), option, "X Y Z RADIUS"):
        if radius <= 0:
            raise InputError(f"{option}: the radius must be above 0, not {radius:g}")
        spheres.append(Sphere((x, y, z), radius))
    return spheres


def parsed_plane(text: str, option: str) -> HalfSpace:
    """Return the half-space below the plane `NX NY NZ D`; raises as `parsed_boxes`.

    The normal points up and may have any length: `2 0 0 4` is the plane x = 2.
    """
    parts = _parts(text, (4,), option, "NX NY NZ D")
    if len(parts) != 1:
        raise InputError(f"{option}: give one plane")
    *normal, offset = parts[0]
    size = math.hypot(*normal)
    if size == 0:
        raise InputError(f"{option}: the normal cannot be 0 0 0")
    x, y, z = (value / size for value in normal)
    return HalfSpace((x, y, z), offset / size)


def numbers_of(text: str, counts: Sequence[int], option: str, shape: str) -> list[float]:
    """Return the finite numbers in a text, separated by spaces or commas.

    Raises InputError, with the `shape` in words, unless there are as many as one of `counts`.
    """
    try:
        numbers = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(abs(number) < 1e12 for number in numbers):
        raise InputError(f"{option} needs {shape}, not {text[:60]!r}")
    return numbers


def _parts(text: str, counts: Sequence[int], option: str, shape: str) -> list[list[float]]:
    parts = text.split(";")
    if len(parts) > REGIONS_MAX:
        raise InputError(f"{option}: {len(parts)} are given, {REGIONS_MAX} are allowed")
    return [numbers_of(part, counts, option, shape) for part in parts]
