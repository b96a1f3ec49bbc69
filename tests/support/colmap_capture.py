"""COLMAP captures of noise photos, and encoders of COLMAP's model files."""

import struct
from pathlib import Path

import numpy as np
from PIL import Image

from mobilegs.data.colmap_files import MODELS

Camera = tuple[int, int, int, int, tuple[float, ...]]  # id, model, width, height, parameters
ImageRow = tuple[str, tuple[float, ...], int]  # name, pose wxyz xyz, camera id
Point = tuple[tuple[float, ...], tuple[int, ...], int]  # xyz, rgb, length of the track

PINHOLE: Camera = (1, 1, 12, 8, (10.0, 11.0, 6.0, 4.0))


def cameras_bin(*cameras: Camera) -> bytes:
    out = struct.pack("<Q", len(cameras))
    for number, model, width, height, parameters in cameras:
        out += struct.pack(f"<IiQQ{len(parameters)}d", number, model, width, height, *parameters)
    return out


def cameras_txt(*cameras: Camera) -> bytes:
    lines = ["# cameras"]
    for number, model, width, height, parameters in cameras:
        values = " ".join(map(repr, parameters))
        lines.append(f"{number} {MODELS[model][0]} {width} {height} {values}")
    return "\n".join(lines).encode()


def images_bin(images: list[ImageRow], observations: int = 0) -> bytes:
    out = struct.pack("<Q", len(images))
    for number, (name, pose, camera) in enumerate(images):
        out += struct.pack("<I7dI", number, *pose, camera) + name.encode() + b"\0"
        out += struct.pack("<Q", observations) + bytes(24 * observations)
    return out


def images_txt(images: list[ImageRow], observations: str = "") -> bytes:
    lines = ["# images"]
    for number, (name, pose, camera) in enumerate(images):
        lines += [f"{number} {' '.join(map(repr, pose))} {camera} {name}", observations]
    return "\n".join(lines).encode()


def frames_bin(moments: list[list[int]]) -> bytes:
    """Encode the images of each moment, as the frames of a rig with one camera for each place."""
    out = struct.pack("<Q", len(moments))
    for number, photos in enumerate(moments):
        out += struct.pack("<2I7dI", number, 1, 1, *[0] * 6, len(photos))
        for camera, photo in enumerate(photos):
            out += struct.pack("<iIQ", 0, camera, photo)
    return out


def frames_txt(moments: list[list[int]]) -> bytes:
    lines = ["# frames"]
    for number, photos in enumerate(moments):
        data = " ".join(f"CAMERA {camera} {photo}" for camera, photo in enumerate(photos))
        lines.append(f"{number} 1 1 0 0 0 0 0 0 {len(photos)} {data}")
    return "\n".join(lines).encode()


def points_bin(points: list[Point]) -> bytes:
    out = struct.pack("<Q", len(points))
    for number, (xyz, rgb, track) in enumerate(points):
        out += struct.pack("<Q3d3BdQ", number, *xyz, *rgb, 0.5, track) + bytes(8 * track)
    return out


def points_txt(points: list[Point]) -> bytes:
    lines = ["# points"]
    for number, (xyz, rgb, track) in enumerate(points):
        numbers = [*map(repr, xyz), *map(str, rgb), "0.5", *["1 2"] * track]
        lines.append(f"{number} {' '.join(numbers)}")
    return "\n".join(lines).encode()


def random_poses(count: int) -> list[ImageRow]:
    turn = np.random.default_rng(3).normal(size=(count, 7))
    return [(f"p{i:02d}.png", tuple(turn[i].tolist()), 1) for i in range(count)]


POINTS: list[Point] = [((0.25 * i, -1.5, 3.0), (i, 2 * i, 255), i % 4) for i in range(9)]


def write_capture_of_noise(
    root: Path,
    *,
    views: int = 9,
    camera: Camera = PINHOLE,
    size: tuple[int, int] = (12, 8),
    model: str = "sparse/0",
    points: list[Point] = POINTS,
) -> Path:
    """Write a COLMAP capture into `root`, with photos of `size` (width, height), and return it."""
    (root / model).mkdir(parents=True)
    (root / "images").mkdir()
    (root / model / "cameras.bin").write_bytes(cameras_bin(camera))
    (root / model / "images.bin").write_bytes(images_bin(random_poses(views)))
    (root / model / "points3D.bin").write_bytes(points_bin(points))
    random = np.random.default_rng(0)
    for name, *_ in random_poses(views):
        pixels = random.integers(0, 256, (size[1], size[0], 3), dtype=np.uint8)
        Image.fromarray(pixels).save(root / "images" / name)
    return root
