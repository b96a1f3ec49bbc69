"""The shapes of the demo scene, and their intersections with rays.

Vectors have the shape `[3, ...]`, coordinates first, so that every operation runs over contiguous
memory. World units, z up. Every shape has three methods:

    bounds()                -> centre [3] and radius of a bounding ball
    hit(origin, direction)  -> distance in units of `direction`, infinite if the ray misses
    normal(position)        -> outward unit normal at points [3, n] of the surface
"""

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

Albedo = Callable[[Tensor, Tensor], Tensor]  # (position, normal) [3, n] -> linear RGB [3, n]


def dot(a: Tensor, b: Tensor) -> Tensor:
    """Return the dot product over the first axis."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit(vector: Tensor) -> Tensor:
    """Return vectors scaled to length 1."""
    return vector * dot(vector, vector).rsqrt()


def along(vector: Tensor, like: Tensor) -> Tensor:
    """Reshape a vector `[3]` to broadcast against `like [3, ...]`."""
    return vector.reshape(3, *[1] * (like.ndim - 1))


def _first(near: Tensor, far: Tensor) -> Tensor:
    """Return the nearer distance in front of the origin; infinite if there is none or for NaN."""
    ahead = torch.where(near > 1e-4, near, far)
    return torch.where(ahead > 1e-4, ahead, torch.inf)


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid around `center` with half axes `radii` along x, y, z."""

    center: Tensor
    radii: Tensor

    def bounds(self) -> tuple[Tensor, float]:
        return self.center, float(self.radii.max())

    def hit(self, origin: Tensor, direction: Tensor) -> Tensor:
        o = (origin - along(self.center, origin)) / along(self.radii, origin)
        d = direction / along(self.radii, direction)
        a, b, c = dot(d, d), dot(o, d), dot(o, o) - 1
        root = (b * b - a * c).sqrt()  # NaN if the ray misses; NaN compares as False
        return _first((-b - root) / a, (-b + root) / a)

    def normal(self, position: Tensor) -> Tensor:
        return unit((position - along(self.center, position)) / along(self.radii**2, position))


@dataclass(frozen=True)
class Box:
    """A box with half sizes `half`, rotated about z by `angle` radians."""

    center: Tensor
    half: Tensor
    angle: float

    def bounds(self) -> tuple[Tensor, float]:
        return self.center, float(self.half.norm())

    def turned(self, vector: Tensor, sign: float = 1.0) -> Tensor:
        """Rotate world directions into the box's axes, or back with `sign` -1."""
        turn = torch.tensor(self.angle)
        c, s = turn.cos(), sign * turn.sin()
        x, y, z = vector.unbind(0)
        return torch.stack([c * x + s * y, c * y - s * x, z])

    def local(self, position: Tensor) -> Tensor:
        """Convert world positions to coordinates along the box's axes."""
        return self.turned(position - along(self.center, position))

    def hit(self, origin: Tensor, direction: Tensor) -> Tensor:
        o, d = self.local(origin), self.turned(direction)
        middle, reach = -o / d, along(self.half, d) / d.abs()
        near, far = (middle - reach).amax(0), (middle + reach).amin(0)
        return torch.where(near < far, _first(near, far), torch.inf)

    def normal(self, position: Tensor) -> Tensor:
        local = self.local(position)
        ratio = local.abs() / along(self.half, local)
        faces = (ratio == ratio.amax(0)).float() * local.sign()
        return unit(self.turned(faces, -1.0))


@dataclass(frozen=True)
class Rod:
    """A cylinder from `start` to `end` without caps, for thin or embedded ends."""

    start: Tensor
    end: Tensor
    radius: float

    def bounds(self) -> tuple[Tensor, float]:
        return (self.start + self.end) / 2, float((self.end - self.start).norm()) / 2 + self.radius

    def hit(self, origin: Tensor, direction: Tensor) -> Tensor:
        length = (self.end - self.start).norm()
        axis = (self.end - self.start) / length
        o = origin - along(self.start, origin)
        oa, da = dot(along(axis, o), o), dot(along(axis, direction), direction)
        a = dot(direction, direction) - da * da
        b = dot(o, direction) - oa * da
        root = (b * b - a * (dot(o, o) - oa * oa - self.radius**2)).sqrt()
        t = (-b - root) / a
        height = oa + t * da
        inside = (t > 1e-4) & (height >= 0) & (height <= length)
        return torch.where(inside, t, torch.inf)

    def normal(self, position: Tensor) -> Tensor:
        axis = torch.nn.functional.normalize(self.end - self.start, dim=0)
        o = position - along(self.start, position)
        return unit(o - along(axis, o) * dot(along(axis, o), o))


@dataclass(frozen=True)
class Drum:
    """An upright cylinder with flat caps: `center` is the middle of the top."""

    center: Tensor
    radius: float
    height: float

    def bounds(self) -> tuple[Tensor, float]:
        middle = self.center - torch.tensor([0, 0, self.height / 2])
        return middle, (self.radius**2 + self.height**2 / 4) ** 0.5

    def hit(self, origin: Tensor, direction: Tensor) -> Tensor:
        o = origin - along(self.center, origin)
        a = direction[0] ** 2 + direction[1] ** 2
        b = o[0] * direction[0] + o[1] * direction[1]
        root = (b * b - a * (o[0] ** 2 + o[1] ** 2 - self.radius**2)).sqrt()
        up, down = -o[2] / direction[2], (-self.height - o[2]) / direction[2]
        near = torch.maximum((-b - root) / a, torch.minimum(up, down))
        far = torch.minimum((-b + root) / a, torch.maximum(up, down))
        return torch.where(near < far, _first(near, far), torch.inf)

    def normal(self, position: Tensor) -> Tensor:
        o = position - along(self.center, position)
        side = torch.stack([o[0], o[1], torch.zeros_like(o[2])]) / self.radius
        cap = torch.stack([0 * o[0], 0 * o[1], (o[2] + self.height / 2).sign()])
        margin = torch.minimum(o[2].abs(), (o[2] + self.height).abs())
        return unit(torch.where(margin < self.radius - (o[0] ** 2 + o[1] ** 2).sqrt(), cap, side))


@dataclass(frozen=True)
class Sheet:
    """A two-sided rectangle: `corner + u * a + v * b` for u, v in [0, 1]; `a` is normal to `b`."""

    corner: Tensor
    a: Tensor
    b: Tensor

    def bounds(self) -> tuple[Tensor, float]:
        far = max(float((self.a + self.b).norm()), float((self.a - self.b).norm()))
        return self.corner + (self.a + self.b) / 2, far / 2

    def uv(self, position: Tensor) -> tuple[Tensor, Tensor]:
        """Return the coordinates (u, v) of points in the sheet's plane."""
        o = position - along(self.corner, position)
        return (
            dot(along(self.a, o), o) / self.a.square().sum(),
            dot(along(self.b, o), o) / self.b.square().sum(),
        )

    def hit(self, origin: Tensor, direction: Tensor) -> Tensor:
        face = torch.linalg.cross(self.a, self.b)
        o = origin - along(self.corner, origin)
        t = -dot(along(face, o), o) / dot(along(face, direction), direction)
        u, v = self.uv(origin + t * direction)
        inside = (t > 1e-4) & (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        return torch.where(inside, t, torch.inf)

    def normal(self, position: Tensor) -> Tensor:
        face = torch.nn.functional.normalize(torch.linalg.cross(self.a, self.b), dim=0)
        return along(face, position).expand_as(position)


Shape = Ellipsoid | Box | Rod | Drum | Sheet


@dataclass(frozen=True)
class Solid:
    """A shape, its colour, and its mirror reflectance at normal incidence (0 = matte)."""

    shape: Shape
    albedo: Albedo
    mirror: float = 0.0
