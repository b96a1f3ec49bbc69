"""Photos of a room with textured walls and pillars, from any place and through any lens."""

import math
from functools import cache

import numpy as np
from PIL import Image
from scipy.ndimage import map_coordinates
from scipy.spatial.transform import Rotation

ROOM = np.array([[-3.0, -1.5, -3.0], [3.0, 1.5, 3.0]])
PILLARS = [
    np.array([[x - 0.3, -1.5, z - 0.3], [x + 0.3, y, z + 0.3]])
    for x, y, z in ((1.6, 1.5, 1.2), (-1.4, 0.6, 1.7), (1.2, 0.2, -1.8), (-1.9, 1.5, -1.2))
]
TEXELS = 60  # per unit of length


@cache
def texture(index: int) -> np.ndarray:
    """Return noise of three scales for a wall of at most 6 x 6 units, in 0..255."""
    random, side = np.random.default_rng(index), 6 * TEXELS
    total = np.zeros((side, side, 3))
    for cell, weight in ((4, 0.3), (9, 0.35), (24, 0.35)):
        small = random.integers(0, 256, (side // cell + 1, side // cell + 1, 3), np.uint8)
        big = Image.fromarray(small).resize((side, side), Image.Resampling.BICUBIC)
        total += weight * np.asarray(big)
    return np.clip(1.6 * (total - 127.5) + 127.5, 0, 255)


def room_colors(eye: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Return the colour that each ray `[..., 3]` from `eye` sees, in 0..255."""
    flat = rays.reshape(-1, 3)
    flat = np.where(np.abs(flat) < 1e-12, 1e-12, flat)
    found = np.full(len(flat), np.inf)
    colors = np.zeros((len(flat), 3))
    for box, (low, high) in enumerate((ROOM, *PILLARS)):
        near, far = (low - eye) / flat, (high - eye) / flat
        entry, leave = np.minimum(near, far), np.maximum(near, far)
        inside = box == 0
        times = leave.min(1) if inside else entry.max(1)
        axes = leave.argmin(1) if inside else entry.argmax(1)
        hit = inside | ((times < leave.min(1)) & (times > 0))
        closer = hit & (times < found)
        found[closer] = times[closer]
        for axis in range(3):
            chosen = closer & (axes == axis)
            points = eye + times[chosen, None] * flat[chosen]
            side = (points[:, axis] > (low + high)[axis] / 2).astype(int)
            u, v = np.delete(points, axis, 1).T
            places = [TEXELS * (u + 3), TEXELS * (v + 3)]
            for number in (0, 1):
                image = texture(10 * box + 2 * axis + number)
                here = np.flatnonzero(chosen)[side == number]
                at = [place[side == number] for place in places]
                for channel in range(3):
                    colors[here, channel] = map_coordinates(
                        image[:, :, channel], at, order=1, mode="mirror"
                    )
    return colors.reshape(rays.shape)


def photo(eye: np.ndarray, to_world: np.ndarray, rays: np.ndarray) -> Image.Image:
    """Return the photo whose pixels see along `rays` `[h, w, 3]` in axes of the camera."""
    colors = room_colors(eye, rays @ to_world.T)
    return Image.fromarray(colors.round().astype(np.uint8))


def pinhole_rays(width: int, height: int, focal: float) -> np.ndarray:
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    x, y = (column - width / 2) / focal, (row - height / 2) / focal
    return np.stack([x, y, np.ones_like(x)], axis=-1)


def fisheye_rays(width: int, height: int, focal: float) -> np.ndarray:
    """Return rays of an equidistant fisheye: the angle is the radius over the focal length."""
    x, y, _ = np.moveaxis(pinhole_rays(width, height, focal), -1, 0)
    angle = np.maximum(np.hypot(x, y), 1e-9)
    scale = np.sin(angle) / angle
    return np.stack([x * scale, y * scale, np.cos(angle)], axis=-1)


def panorama_rays(width: int) -> np.ndarray:
    """Return rays of a panorama of the whole sphere, with the front in its middle."""
    height = width // 2
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    longitude, latitude = 2 * math.pi * (column / width - 0.5), math.pi * (row / height - 0.5)
    flat = np.cos(latitude)
    return np.stack([np.sin(longitude) * flat, np.sin(latitude), np.cos(longitude) * flat], axis=-1)


def path_poses(count: int, *, turn: float = 0.0) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return (eye, camera-to-world rotation) along a path near the middle of the room."""
    poses = []
    for index in range(count):
        share = index / max(count - 1, 1)
        eye = np.array([1.2 * share - 0.6, 0.15 * math.sin(5 * share), 0.7 * math.cos(3 * share)])
        rotation = Rotation.from_euler("yxz", [0.1 + turn * share, 0.05 * math.sin(index), 0.03])
        poses.append((eye, rotation.as_matrix()))
    return poses
