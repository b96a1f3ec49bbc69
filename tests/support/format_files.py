"""Encoders for formats that the package only reads: compressed `.ply` and `.splat`."""

import math

import numpy as np

from mobilegs.formats.ply_compressed import BOUNDS, CHUNK, COLORS, PACKED, SCALES
from mobilegs.formats.splat import ROW
from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import C0


def _quantize(values: np.ndarray, bits: int) -> np.ndarray:
    """Map [0, 1] to the integers of `bits` bits."""
    return np.rint(values * ((1 << bits) - 1)).astype(np.uint32)


def encode_compressed_ply(
    scene: Gaussians,
    *,
    colors: bool = True,
    order: str = "<",
    kinds: tuple[str, str, str] = ("float", "uint", "uchar"),
    chunks: int | None = None,
) -> bytes:
    """Encode a scene by the format's description.

    Args:
        colors: whether chunks have bounds of colours, as they do since 2024.
        order: byte order, `<` or `>`.
        kinds: PLY types of bounds, packed words and SH values.
        chunks: announced number of chunks; None is the right one.
    """
    count = len(scene)
    number = -(-count // CHUNK)
    rgb = (0.5 + C0 * scene.sh[:, 0]).clamp(*((-9, 9) if colors else (0, 1))).numpy()
    parts = [scene.means.numpy(), scene.log_scales.numpy(), rgb]
    bounds, shares = [], []
    for part, names in zip(parts, (BOUNDS, SCALES, COLORS), strict=True):
        pieces = np.split(part, range(CHUNK, count, CHUNK)) if count else []
        low = np.array([piece.min(0) for piece in pieces], np.float32).reshape(number, 3)
        high = np.array([piece.max(0) for piece in pieces], np.float32).reshape(number, 3)
        if names is COLORS and not colors:
            shares.append(part)
            continue
        bounds += [low, high]
        wide = np.repeat(np.maximum(high - low, 1e-20), CHUNK, axis=0)[:count]
        shares.append((part - np.repeat(low, CHUNK, axis=0)[:count]) / wide)
    q = scene.quats.numpy()
    largest = np.abs(q).argmax(1)
    q = q * np.sign(q[np.arange(count), largest])[:, None]
    rotation = largest.astype(np.uint32)
    for i in range(3):
        which = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[largest, i]
        small = q[np.arange(count), which] / math.sqrt(2) + 0.5
        rotation = rotation << 10 | _quantize(small, 10)

    def three(values: np.ndarray) -> np.ndarray:
        x, y, z = (_quantize(values[:, i], bits) for i, bits in enumerate((11, 10, 11)))
        return x << 21 | y << 11 | z

    r, g, b = (_quantize(shares[2][:, i], 8) for i in range(3))
    color = r << 24 | g << 16 | b << 8 | _quantize(scene.opacities.numpy(), 8)
    words = np.stack([three(shares[0]), rotation, three(shares[1]), color], axis=1)
    rest = scene.sh[:, 1:].transpose(1, 2).flatten(1).numpy()
    sh_bytes = np.trunc((rest / 8 + 0.5) * 256).clip(0, 255).astype(np.uint8)
    format_ = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    names = [*BOUNDS, *SCALES, *(COLORS if colors else [])]
    lines = [
        "ply",
        f"format {format_} 1.0",
        f"element chunk {number if chunks is None else chunks}",
    ]
    lines += [f"property {kinds[0]} {name}" for name in names]
    lines += [f"element vertex {count}", *(f"property {kinds[1]} {name}" for name in PACKED)]
    if rest.shape[1]:
        lines += [f"element sh {count}"]
        lines += [f"property {kinds[2]} f_rest_{i}" for i in range(rest.shape[1])]
    table = np.concatenate(bounds, axis=1) if number else np.zeros((0, len(names)))
    body = table.astype(order + "f4").tobytes() + words.astype(order + "u4").tobytes()
    return "\n".join([*lines, "end_header\n"]).encode() + body + sh_bytes.tobytes()


def encode_splat(scene: Gaussians) -> np.ndarray:
    """Encode a scene as rows of type `ROW`, as the format's own converter does."""
    rows = np.zeros(len(scene), ROW)
    rows["mean"], rows["scale"] = scene.means, scene.scales
    rows["color"][:, :3] = ((0.5 + C0 * scene.sh[:, 0]) * 255).round().clamp(0, 255)
    rows["color"][:, 3] = (scene.opacities * 255).round()
    rows["rotation"] = (scene.quats * 128 + 128).round().clamp(0, 255)
    return rows
