"""The scene of the demo capture: a round stone terrace between sea and sky, ray-traced.

It has texture (paving, wood, leaves), occlusion, thin parts (a cage, guy wires), a lacquered ball
that mirrors the rest, and a background at infinity. World units, z up; the terrace's top is z = 0.
"""

import math

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.data.demo.solids import (
    Albedo,
    Box,
    Drum,
    Ellipsoid,
    Rod,
    Sheet,
    Solid,
    along,
    dot,
    unit,
)
from mobilegs.data.demo.textures import Noise, at, checker, edge, mix, plain, squares

TERRACE_RADIUS = 1.75
_SUN = torch.nn.functional.normalize(torch.tensor([-0.55, -0.5, 0.8]), dim=0)
_SUNLIGHT = torch.tensor([1.25, 1.13, 0.92])
_SHADOW_TEXELS = 1536
_SHADOW_REACH = 2.6  # world units: half side of the square that the shadow map covers


class DemoScene:
    """The demo scene, ready for ray tracing; the seed decides stones, grain and leaves."""

    def __init__(self, seed: int = 0) -> None:
        generator = torch.Generator().manual_seed(seed)
        self._noise = Noise(generator)
        self._solids = self._build()
        right = torch.nn.functional.normalize(torch.tensor([_SUN[1], -_SUN[0], 0.0]), dim=0)
        self._sun_axes = torch.stack([right, torch.linalg.cross(_SUN, right), _SUN])
        self._shadow = self._shadow_map()

    def picture(
        self, camera: Camera, *, samples: int = 2
    ) -> tuple[Float[Tensor, "h w 3"], Float[Tensor, "h w"]]:
        """Return (sRGB in [0, 1], depth) from `samples`^2 rays per pixel.

        Depth is the camera-space z of the pixel's nearest ray, infinite for the background; with
        one sample it is that of the pixel's centre.
        """
        rows, columns = camera.height * samples, camera.width * samples
        fine = camera.resized(columns, rows)
        y = (torch.arange(rows) + 0.5 - fine.K[1, 2]) / fine.K[1, 1]
        x = (torch.arange(columns) + 0.5 - fine.K[0, 2]) / fine.K[0, 0]
        plane = torch.stack(
            [x.expand(rows, columns), y[:, None].expand(rows, columns), torch.ones(rows, columns)]
        )
        # directions keep z = 1 in camera space, so distances along them are depths
        directions = (fine.viewmat[:3, :3].T @ plane.reshape(3, -1)).reshape(3, rows, columns)
        eye = fine.position
        depth = torch.full((rows, columns), torch.inf)
        owner = torch.full((rows, columns), -1)
        for index, solid in enumerate(self._solids):
            window = _window(fine, *solid.shape.bounds())
            seen = directions[:, *window]
            if seen.numel():
                t = solid.shape.hit(along(eye, seen), seen)
                closer = t < depth[window]
                depth[window] = torch.where(closer, t, depth[window])
                owner[window] = torch.where(closer, index, owner[window])
        color = self._radiance(
            eye[:, None], directions.reshape(3, -1), depth.flatten(), owner.flatten()
        )
        blocks = color.reshape(3, camera.height, samples, camera.width, samples)
        nearest = depth.reshape(camera.height, samples, camera.width, samples).amin((1, 3))
        return blocks.mean((2, 4)).permute(1, 2, 0).contiguous(), nearest

    def rays(
        self, origins: Float[Tensor, "3 n"], directions: Float[Tensor, "3 n"]
    ) -> tuple[Float[Tensor, "3 n"], Float[Tensor, "n"]]:
        """Return (sRGB in [0, 1], distance in units of the direction's length) of rays.

        The distance is infinite for the background.
        """
        depth, owner = self._trace(origins, directions)
        return self._radiance(origins, directions, depth, owner), depth

    def _trace(self, origins: Tensor, directions: Tensor) -> tuple[Tensor, Tensor]:
        shape = torch.broadcast_shapes(origins.shape, directions.shape)[1:]
        depth, owner = torch.full(shape, torch.inf), torch.full(shape, -1)
        for index, solid in enumerate(self._solids):
            t = solid.shape.hit(origins, directions)
            owner = torch.where(t < depth, index, owner)
            depth = torch.minimum(t, depth)
        return depth, owner

    def _radiance(
        self, origins: Tensor, directions: Tensor, depth: Tensor, owner: Tensor
    ) -> Float[Tensor, "3 n"]:
        """Return the sRGB colours that rays see."""
        linear = self._light(origins, directions, depth, owner, bounces=1)
        return linear.clamp(0, 1) ** (1 / 2.2)

    def _light(
        self, origins: Tensor, directions: Tensor, depth: Tensor, owner: Tensor, *, bounces: int
    ) -> Tensor:
        light = torch.empty_like(directions)
        sky = (owner < 0).nonzero()[:, 0]
        light[:, sky] = self._sky(unit(directions[:, sky]))
        origins = origins.expand_as(directions)
        for index in torch.bincount(owner + 1)[1:].nonzero()[:, 0].tolist():
            rays = (owner == index).nonzero()[:, 0]
            d = directions[:, rays]
            position = origins[:, rays] + depth[rays] * d
            light[:, rays] = self._shade(self._solids[index], position, unit(d), bounces)
        return light

    def _shade(self, solid: Solid, position: Tensor, d: Tensor, bounces: int) -> Tensor:
        """Return linear radiance towards the eye: sun with shadow, sky light, highlight, mirror."""
        normal = solid.shape.normal(position)
        normal = torch.where(dot(normal, d) > 0, -normal, normal)
        albedo = solid.albedo(position, normal)
        cosine = dot(along(_SUN, normal), normal)
        lit = self._sunlit(position + 0.012 * normal) * cosine.clamp_min(0)
        ambient = along(torch.tensor([0.34, 0.40, 0.50]), albedo) * (0.72 + 0.28 * normal[2])
        ambient = ambient * self._openness(position, normal)
        light = albedo * (ambient + along(_SUNLIGHT, albedo) * lit)
        if not (solid.mirror and bounces):
            return light
        mirrored = d - 2 * dot(d, normal) * normal
        start = position + 2e-3 * normal
        depth, owner = self._trace(start, mirrored)
        image = self._light(start, mirrored, depth, owner, bounces=bounces - 1)
        facing = (-dot(d, normal)).clamp(0, 1)
        fresnel = solid.mirror + (1 - solid.mirror) * (1 - facing) ** 5  # Schlick
        half = unit(along(_SUN, d) - d)
        highlight = dot(half, normal).clamp_min(0) ** 60 * (lit > 0)  # Blinn-Phong
        return light * (1 - fresnel) + fresnel * image + 0.9 * highlight

    def _openness(self, position: Tensor, normal: Tensor) -> Tensor:
        """Return the share of the sky that is not occluded, for soft contact shadows."""
        open_share = torch.ones_like(position[0])
        for x, y, z, radius in _OCCLUDERS:
            to = along(torch.tensor([x, y, z]), position) - position
            squared = dot(to, to).clamp_min(radius**2)
            toward = (dot(to, normal) * squared.rsqrt()).clamp_min(0)
            open_share = open_share * (1 - 0.8 * toward * radius**2 / squared)
        return open_share

    def _sun_coordinates(self, position: Tensor) -> Tensor:
        return (self._sun_axes @ position.reshape(3, -1)).reshape(position.shape)

    def _shadow_map(self) -> Float[Tensor, "s s"]:
        """Render the height, along the sun's direction, of the surfaces that the sun reaches."""
        ticks = (torch.arange(_SHADOW_TEXELS) + 0.5) / _SHADOW_TEXELS * 2 - 1
        across = (ticks * _SHADOW_REACH).expand(_SHADOW_TEXELS, -1)
        start = torch.stack([across, across.T, torch.full_like(across, 10.0)])
        heights = torch.full_like(across, -torch.inf)
        for solid in self._solids:
            center, radius = solid.shape.bounds()
            u, v = ((self._sun_axes @ center)[:2] / _SHADOW_REACH + 1) / 2 * _SHADOW_TEXELS
            reach = radius / _SHADOW_REACH / 2 * _SHADOW_TEXELS + 1
            window = (_span(v, reach, _SHADOW_TEXELS), _span(u, reach, _SHADOW_TEXELS))
            local = start[:, *window]
            origins = (self._sun_axes.T @ local.reshape(3, -1)).reshape(local.shape)
            height = 10.0 - solid.shape.hit(origins, along(-_SUN, origins))
            heights[window] = torch.maximum(heights[window], height)
        return heights

    def _sunlit(self, position: Tensor) -> Tensor:
        """Return the share of four shadow-map samples around each point that is lit."""
        u, v, height = self._sun_coordinates(position)
        scale = _SHADOW_TEXELS / 2 / _SHADOW_REACH
        share = torch.zeros_like(u)
        for du, dv in ((-1.4, -0.5), (0.5, -1.4), (1.4, 0.5), (-0.5, 1.4)):
            column = ((u + _SHADOW_REACH) * scale + du).long().clamp(0, _SHADOW_TEXELS - 1)
            row = ((v + _SHADOW_REACH) * scale + dv).long().clamp(0, _SHADOW_TEXELS - 1)
            share += self._shadow.flatten()[row * _SHADOW_TEXELS + column] < height + 0.012
        return share / 4

    def _sky(self, d: Tensor) -> Tensor:
        """Return linear radiance of the background along unit `d`: sky above, sea below."""
        light = torch.empty_like(d)
        for half, radiance in ((d[2] >= 0, self._heaven), (d[2] < 0, self._sea)):
            rays = half.nonzero()[:, 0]
            light[:, rays] = radiance(d[:, rays])
        return light

    def _heaven(self, d: Tensor) -> Tensor:
        """Return the sky: a gradient, clouds, the glow of the sun, two ridges of mountains."""
        x, y, up = d
        sky = mix((0.90, 0.66, 0.46), (0.16, 0.36, 0.75), up.sqrt() * 1.15)
        drift = self._noise.cloud(x / (up + 0.35) * 0.22, y / (up + 0.35) * 0.22)
        sky = mix(sky, (0.95, 0.92, 0.90), ((drift - 0.52) * 4).clamp(0, 1) * (up * 5).clamp(0, 1))
        glow = dot(along(_SUN, d), d).clamp_min(0)
        sky = sky + along(torch.tensor([0.9, 0.6, 0.3]), d) * (0.25 * glow**6 + glow**200)
        azimuth = torch.atan2(y, x)
        for height, phase, color in (
            (0.085, 0.3, (0.42, 0.45, 0.58)),
            (0.05, 2.1, (0.20, 0.25, 0.36)),
        ):
            waves = 0.5 * (3 * azimuth + phase).sin() + 0.35 * (7 * azimuth + 2 * phase).sin()
            rough = 0.06 * (self._noise.cloud(azimuth / math.tau, torch.full_like(up, phase)) - 0.5)
            sky = mix(sky, color, (height * (1 + waves) + rough - up) * 150)
        return sky

    def _sea(self, d: Tensor) -> Tensor:
        """Return the sea: haze at the horizon, darker water below, with a swell."""
        x, y, deep = d[0], d[1], -d[2]
        sea = mix((0.46, 0.50, 0.50), (0.015, 0.10, 0.16), deep.sqrt() * 1.3)
        swell = self._noise.cloud(x / (deep + 0.2) * 0.3, y / (deep + 0.2) * 0.3) - 0.5
        return sea * (1 + 0.9 * swell * (deep * 6).clamp(0, 1))

    def _build(self) -> list[Solid]:
        crate = Box(at(-0.95, 0.5, 0.27), at(0.27, 0.27, 0.27), 0.45)
        flag = Sheet(at(0.13, 1.3, 1.1), at(0.5, 0.22, 0.0), at(0.0, 0.0, 0.32))
        pole = at(0.1, 1.29, 0)
        wire = plain(0.10, 0.09, 0.09)
        brass = plain(0.50, 0.34, 0.11)
        return [
            Solid(Drum(at(0, 0, 0), TERRACE_RADIUS, 0.3), self._paving),
            Solid(_ball(0.0, -0.1, 0.5, 0.5), self._lacquer, mirror=0.12),
            Solid(crate, lambda p, n: self._wood(crate, p, n)),
            Solid(_ball(-0.95, 0.5, 0.73, 0.19), checker),
            *self._cairn(),
            *self._tree(),
            *self._cage(brass),
            Solid(Rod(pole, pole + at(0, 0, 1.46), 0.022), plain(0.75, 0.72, 0.66)),
            Solid(_ball(0.1, 1.29, 1.48, 0.05), brass),
            Solid(flag, lambda p, n: squares(*flag.uv(p))),
            Solid(Rod(pole + at(0, 0, 1.38), at(-1.25, 1.05, 0), 0.008), wire),
            Solid(Rod(pole + at(0, 0, 1.38), at(-0.35, 1.68, 0), 0.008), wire),
        ]

    def _cairn(self) -> list[Solid]:
        stones = (
            (0.0, 0.3, 0.26, 0.15, 0.6),
            (0.42, 0.2, 0.23, 0.13, 0.9),
            (0.63, 0.15, 0.13, 0.1, 0.4),
        )
        solids = []
        for bottom, rx, ry, rz, tint in stones:
            body = Ellipsoid(at(-0.7, -0.9, 0.145 + bottom * 0.87), at(rx, ry, rz))
            solids.append(Solid(body, lambda p, n, tint=tint: self._granite(p, tint)))
        return solids

    def _tree(self) -> list[Solid]:
        crowns = ((0.9, 0.75, 0.92, 0.40), (0.70, 0.93, 0.70, 0.25), (1.12, 0.62, 0.66, 0.24))
        trunk = Rod(at(0.92, 0.78, 0), at(0.88, 0.75, 0.9), 0.065)
        return [
            Solid(trunk, self._bark),
            *(Solid(_ball(x, y, z, r), lambda p, n: self._leaves(p, n)) for x, y, z, r in crowns),
        ]

    def _cage(self, brass: Albedo) -> list[Solid]:
        center = at(0.95, -0.7, 0)
        bars = []
        for k in range(14):
            foot = center + 0.27 * at(math.cos(k * math.tau / 14), math.sin(k * math.tau / 14), 0)
            bars.append(Solid(Rod(foot, foot + at(0, 0, 0.8), 0.013), brass))
        return [
            Solid(Drum(center + at(0, 0, 0.06), 0.32, 0.06), plain(0.20, 0.26, 0.30)),
            Solid(Drum(center + at(0, 0, 0.84), 0.30, 0.045), plain(0.20, 0.26, 0.30)),
            Solid(_ball(0.95, -0.7, 0.9, 0.07), brass),
            Solid(_ball(0.95, -0.7, 0.32, 0.16), lambda p, n: self._swirl(p)),
            *bars,
        ]

    def _paving(self, p: Tensor, n: Tensor) -> Tensor:
        """Rings of wedge-shaped stones with joints; layered rock at the side."""
        x, y, z = p
        radius, angle = (x * x + y * y).sqrt(), torch.atan2(y, x) / math.tau + 0.5
        ring = (radius / 0.25).floor()
        turn = (angle + 0.37 * ring) * 6 * ring.clamp_min(1)
        wedge = turn.floor()
        tint = self._noise.chance(ring, wedge, wedge * 0)
        warm = mix((0.50, 0.42, 0.33), (0.30, 0.31, 0.33), tint)
        warm = mix(
            warm, (0.45, 0.20, 0.12), (self._noise.chance(wedge, ring, ring) > 0.8).float() * 0.7
        )
        stone = warm * (0.55 + 0.9 * self._noise.cloud(x * 0.35 + tint * 3, y * 0.35))
        joint = torch.minimum(edge(radius / 0.25) * 0.25, edge(turn) * radius / ring.clamp_min(1))
        top = mix((0.10, 0.10, 0.08), stone, ((joint - 0.004) / 0.008).clamp(0, 1))
        layers = 0.6 + 0.8 * self._noise.cloud(angle * 2, z * 1.5)
        return torch.where(n[2] > 0.5, top, along(torch.tensor([0.33, 0.28, 0.23]), p) * layers)

    def _lacquer(self, p: Tensor, n: Tensor) -> Tensor:
        band = ((n[2] + 0.12 * (5 * torch.atan2(n[1], n[0])).sin()).abs() < 0.06).float()
        return mix((0.42, 0.012, 0.02), (0.62, 0.42, 0.10), band)

    def _wood(self, crate: Box, p: Tensor, n: Tensor) -> Tensor:
        """Planks across the sides of the crate, with a frame around each face."""
        local, face = crate.local(p), crate.turned(n).abs()
        side = torch.where(face[0] > 0.5, local[1], local[0])
        height = torch.where(face[2] > 0.5, local[1], local[2])
        plank = (height / 0.108 + 0.5).floor()
        grain = self._noise.cloud(side * 0.25 + 0.3 * plank, height * 2.5)
        wood = mix((0.22, 0.11, 0.05), (0.62, 0.40, 0.20), grain)
        wood = wood * (0.75 + 0.5 * self._noise.chance(plank, plank))
        wood = wood * (0.3 + 0.7 * (edge(height / 0.108 + 0.5) > 0.05))
        frame = (torch.maximum(side.abs(), height.abs()) > 0.215).float()
        return mix(wood, (0.16, 0.09, 0.05), frame * 0.8)

    def _granite(self, p: Tensor, tint: float) -> Tensor:
        stone = mix((0.16, 0.17, 0.20), (0.58, 0.50, 0.42), 0 * p[0] + tint)
        return stone * (0.35 + 1.3 * self._noise.solid_cloud(0.8 * p + tint))

    def _bark(self, p: Tensor, n: Tensor) -> Tensor:
        streaks = self._noise.cloud(p[0] + p[1], p[2] * 0.3)
        return mix((0.10, 0.06, 0.04), (0.34, 0.22, 0.14), streaks)

    def _leaves(self, p: Tensor, n: Tensor) -> Tensor:
        leaf = (self._noise.solid_cloud(1.7 * p) - 0.2) * 1.7
        green = mix((0.012, 0.05, 0.012), (0.27, 0.42, 0.06), leaf)
        cells = p * 9
        x, y, z = cells.floor()
        offset = cells - cells.floor() - 0.5
        berry = (dot(offset, offset) < 0.1) & (self._noise.chance(x, y, z) > 0.72)
        return mix(green, (0.80, 0.25, 0.06), berry.float())

    def _swirl(self, p: Tensor) -> Tensor:
        bend = self._noise.solid_cloud(0.4 * p)
        return mix(
            (0.70, 0.62, 0.50), (0.03, 0.30, 0.34), 0.5 + 0.5 * (26 * p[2] + 10 * bend).sin()
        )


_OCCLUDERS = (
    (0.0, -0.1, 0.5, 0.5),
    (-0.95, 0.5, 0.27, 0.3),
    (-0.7, -0.9, 0.15, 0.26),
    (0.9, 0.75, 0.9, 0.5),
    (0.95, -0.7, 0.3, 0.22),
)


def _ball(x: float, y: float, z: float, radius: float) -> Ellipsoid:
    return Ellipsoid(at(x, y, z), torch.full((3,), radius))


def _span(middle: Tensor | float, reach: float, size: int) -> slice:
    low, high = float(middle) - reach, float(middle) + reach
    return slice(min(max(math.floor(low), 0), size), min(max(math.ceil(high), 0), size))


def _window(camera: Camera, center: Tensor, radius: float) -> tuple[slice, slice]:
    """Return the rows and columns of the image that contain a ball."""
    x, y, z = (camera.viewmat[:3, :3] @ center + camera.viewmat[:3, 3]).tolist()
    if z + radius <= 0:
        return slice(0, 0), slice(0, 0)
    if z <= 1.01 * radius:
        return slice(0, camera.height), slice(0, camera.width)
    spans = []
    for position, axis, size in ((y, 1, camera.height), (x, 0, camera.width)):
        # tangents to the ball lie at +- asin(radius / distance) around its centre
        angle, spread = math.atan2(position, z), math.asin(radius / math.hypot(position, z))
        focal, principal = float(camera.K[axis, axis]), float(camera.K[axis, 2])
        low, high = (
            focal * math.tan(max(-1.57, min(1.57, angle + sign * spread))) + principal
            for sign in (-1, 1)
        )
        spans.append(_span((low + high) / 2, (high - low) / 2 + 1, size))
    return spans[0], spans[1]
