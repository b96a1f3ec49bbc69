"""Noise and patterns that colour the demo scene. Colours are linear RGB."""

import math

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.data.demo.solids import Albedo, along


class Noise:
    """Random textures; the generator decides them."""

    def __init__(self, generator: torch.Generator) -> None:
        self._texture = _cloud_texture(512, generator)
        self._dice = torch.rand(256, generator=generator)

    def cloud(self, u: Tensor, v: Tensor) -> Tensor:
        """Return fractal noise of mean 0.5 in about [0, 1], with period 1 in both coordinates."""
        size = self._texture.shape[0]
        u, v = u * size, v * size
        u0, v0 = u.floor(), v.floor()
        fu, fv = u - u0, v - v0
        last = size - 1  # `&` wraps around: the size is a power of two
        i0, j0 = u0.long() & last, v0.long() & last
        i1, j1 = (i0 + 1) & last, (j0 + 1) & last
        texels = self._texture.flatten()
        low = torch.lerp(texels[j0 * size + i0], texels[j0 * size + i1], fu)
        high = torch.lerp(texels[j1 * size + i0], texels[j1 * size + i1], fu)
        return torch.lerp(low, high, fv)

    def chance(self, *cells: Tensor) -> Tensor:
        """Return a random number in [0, 1) for each integer cell."""
        index = torch.zeros_like(cells[0]).long()
        for prime, cell in zip((31, 57, 113), cells, strict=False):
            index = index + prime * cell.long()
        return self._dice[index & 255]

    def solid_cloud(self, p: Tensor) -> Tensor:
        """Return 3D noise in [0, 1]: the scaled mean of 2D noise in three planes."""
        x, y, z = p
        planes = self.cloud(x, y) + self.cloud(y + 0.3, z) + self.cloud(z + 0.6, x)
        return ((planes - 1.5) * 0.6 + 0.5).clamp(0, 1)


def at(*xyz: int | float) -> Float[Tensor, "3"]:
    """Return a position, direction or colour as a tensor."""
    return torch.tensor(xyz, dtype=torch.float32)


def mix(a, b, share: Tensor) -> Tensor:
    """Interpolate from colour `a` to `b` (a triple or [3, n]) by `share`, clamped to [0, 1]."""
    share = share.clamp(0, 1)
    a, b = (torch.tensor(c)[:, None] if isinstance(c, tuple) else c for c in (a, b))
    return a + (b - a) * share


def edge(cells: Tensor) -> Tensor:
    """Return the distance to the nearest integer."""
    return (cells - cells.round()).abs()


def plain(red: float, green: float, blue: float) -> Albedo:
    """Return an albedo of one colour."""
    return lambda p, n: along(at(red, green, blue), p).expand_as(p)


def checker(p: Tensor, n: Tensor) -> Tensor:
    """Albedo of the small ball: ten by six fields between its meridians and parallels."""
    longitude = torch.atan2(n[1], n[0]) / math.tau * 10
    odd = (longitude.floor() + (n[2].clamp(-1, 1).asin() / math.pi * 6).floor()) % 2
    return mix((0.75, 0.70, 0.58), (0.06, 0.16, 0.38), odd)


def squares(u: Tensor, v: Tensor) -> Tensor:
    """Albedo of the flag: six by four squares."""
    odd = ((u * 6).floor() + (v * 4).floor()) % 2
    return mix((0.75, 0.68, 0.50), (0.02, 0.22, 0.27), odd)


def _cloud_texture(size: int, generator: torch.Generator) -> Float[Tensor, "s s"]:
    """Make tileable fractal noise: white noise with its spectrum scaled by 1 / f^1.3."""
    spectrum = torch.fft.rfft2(torch.randn(size, size, generator=generator))
    f = torch.hypot(torch.fft.fftfreq(size)[:, None] * size, torch.fft.rfftfreq(size) * size)
    noise = torch.fft.irfft2(spectrum * torch.where(f > 0, f.clamp_min(2) ** -1.3, 0.0))
    return (0.5 + 0.2 * noise / noise.std()).clamp(0, 1)
