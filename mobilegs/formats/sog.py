"""Reads and writes PlayCanvas's `.sog`: lossless WebP images and a `meta.json`, zipped or not.

Every image has one pixel per Gaussian. Two images hold the low and high bytes of positions, which
are 16-bit signed logarithms. Rotations have their three smaller components as bytes. Scales,
colours and opacities are bytes, which version 2 looks up in codebooks of 256 values and version 1
maps to a range. Higher SH coefficients are indices into a palette, which is an image as well. Axes
are those of the source `.ply`. Source:
https://developer.playcanvas.com/user-manual/gaussian-splatting/formats/sog.
"""

import io
import json
import logging
import math
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from mobilegs import __version__
from mobilegs.atomic import atomic_path, open_input
from mobilegs.errors import InputError
from mobilegs.formats.sog_palette import codebook, palette
from mobilegs.gaussians import Gaussians
from mobilegs.packed_gaussians import BLOCK, SMALL_MAX, logits_of, quats_of_smallest_three
from mobilegs.render.project import BLUR, CLASSIC, Footprint

log = logging.getLogger(__name__)

ANTIALIASED = "antialiased"  # a value of meta.json's `model`
COUNT_MAX = 10_000_000
GAUSSIANS_PER_BYTE = 1  # far above real scenes; limits the memory for small files
JSON_MAX = 1 << 18  # bytes of meta.json, which has about 20,000
INDEX_MAX = 1 << 16  # bytes of a zip's list of files; parsed, it needs many times as much memory
SH_COEFFICIENTS = (0, 3, 8, 15)  # per channel above degree 0, by degree
PALETTE_MAX = 1 << 16
PALETTE_COLUMNS = 64  # palette entries per row of its image
MORTON_BITS = 10  # per axis

# the errors of `zipfile` for damaged, encrypted or unsupported archives
ZIP_ERRORS = (zipfile.BadZipFile, zlib.error, struct.error, OSError, EOFError, RuntimeError)

ReadFile = Callable[[str, int], bytes]  # (name, largest size) -> content


@dataclass(frozen=True)
class Tables:
    """Tables that decode bytes, and the bounds of positions.

    Attributes:
        bounds: lower and upper bounds of the positions' signed logarithms, `[2, 3]`.
        scales: logarithms of scales, `[256, 3]`.
        colors: SH coefficients of degree 0, `[256, 3]`.
        logits: of opacities, `[256]`.
        higher_sh: SH coefficients above degree 0, `[256]`.
    """

    bounds: np.ndarray
    scales: np.ndarray
    colors: np.ndarray
    logits: np.ndarray
    higher_sh: np.ndarray


def read_sog(path: Path | str) -> Gaussians:
    """Read the Gaussians of a `.sog`; see `read_sog_scene`."""
    return read_sog_scene(path)[0]


def read_sog_scene(path: Path | str) -> tuple[Gaussians, Footprint]:
    """Read a `.sog`, an unpacked folder, or the `meta.json` in one, as float32 on the CPU.

    The second result says how the Gaussians cover pixels: the field `model` of newer files. That
    of 2D Gaussians (`2dgs`) is drawn as plain 3DGS, with a logged warning.

    Gaussians that cannot be drawn are left out (`Gaussians.drawable`). Raises InputError if a file
    is missing, not a `.sog` of version 1 or 2, damaged or cut off, or none can be drawn.
    """
    path = Path(path)
    try:
        with _opened(path) as (read_file, size):
            meta = _read_meta(read_file, path)
            return _read(meta, read_file, size, path).drawable(path), _footprint(meta, path)
    except InputError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError):
        raise InputError(f"{path} is damaged: its parts are not consistent") from None


@contextmanager
def _opened(path: Path) -> Iterator[tuple[ReadFile, int]]:
    """Open a scene: a function that reads its files, and its size in bytes."""
    folder = path if path.is_dir() else path.parent if path.name == "meta.json" else None
    if folder is not None:
        files = [file for file in folder.iterdir() if file.suffix in (".json", ".webp")]
        yield _from_folder(folder), sum(file.stat().st_size for file in files)
        return
    with open_input(path) as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - 42))
        end = file.read(42)
        # check the list of files before `zipfile` parses it; ZIP64 is not supported
        signatures = end[-22:-18], end[:4]
        if len(end) < 22 or signatures[0] != b"PK\5\6" or signatures[1] == b"PK\6\7":
            raise InputError(
                f"{path} is not a .sog, or cut off: it does not end like a zip archive"
            )
        if struct.unpack_from("<I", end, len(end) - 10)[0] > INDEX_MAX:
            raise InputError(f"{path} is not a .sog: it is an archive of too many files")
        try:
            with zipfile.ZipFile(file) as archive:
                yield _from_zip(archive, path), size
        except ZIP_ERRORS:
            raise InputError(f"{path} is damaged: its archive cannot be opened") from None


def _from_zip(archive: zipfile.ZipFile, path: Path) -> ReadFile:
    def read_file(name: str, size_max: int) -> bytes:
        if name not in archive.namelist():
            raise InputError(f"{path} lacks {name[:40]}: it is not a .sog")
        if archive.getinfo(name).compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise NotImplementedError  # other methods ignore the limit of read()
        with archive.open(name) as file:
            return _content(file.read, size_max, f"{path}: {name}")

    return read_file


def _from_folder(folder: Path) -> ReadFile:
    def read_file(name: str, size_max: int) -> bytes:
        with open_input(folder / name) as file:
            return _content(file.read, size_max, str(folder / name))

    return read_file


def _content(read: Callable[[int], bytes], size_max: int, name: str) -> bytes:
    content = read(size_max + 1)
    if len(content) > size_max:
        raise InputError(f"{name} is too large: the scene is damaged")
    return content


def _read_meta(read_file: ReadFile, path: Path) -> dict[str, Any]:
    try:
        return json.loads(read_file("meta.json", JSON_MAX))
    except RecursionError:
        raise InputError(f"{path} is damaged: its meta.json cannot be read") from None


def _footprint(meta: dict[str, Any], path: Path) -> Footprint:
    model = meta.get("model", "default")
    if model not in ("default", ANTIALIASED):
        log.warning(
            "%s was made for the model %.40r; drawn as plain 3DGS it may look different",
            path,
            model,
        )
    return Footprint(antialiased=model == ANTIALIASED)


def _read(meta: dict[str, Any], read_file: ReadFile, size: int, path: Path) -> Gaussians:
    version = meta.get("version", 1)
    if version not in (1, 2):
        raise InputError(f"{path} has a version of .sog that is not supported: only 1 and 2 are")
    count = meta["count"] if version == 2 else meta["means"]["shape"][0]
    if type(count) is not int or not 0 <= count < 1 << 53:
        raise ValueError
    if count > min(COUNT_MAX, GAUSSIANS_PER_BYTE * size):
        raise InputError(f"{path} announces {count} Gaussians in {size} bytes: it is cut off")
    with np.errstate(all="ignore"):  # `drawable` drops bad rows
        tables = _tables(meta, version)

    def image(name: str, index: int, pixels_min: int, pixels_max: int) -> np.ndarray:
        file = meta[name]["files"][index]
        if not isinstance(file, str) or not re.fullmatch(r"[\w-][\w.-]{0,60}", file, re.ASCII):
            raise ValueError
        content = read_file(file, 5 * pixels_max + (1 << 16))
        return _decode_webp(content, pixels_min, pixels_max, f"{path}: {file}")

    def rows(name: str, index: int = 0) -> np.ndarray:
        return image(name, index, count, 2 * count + 4096).reshape(-1, 4)[:count]

    means = _means(rows("means"), rows("means", 1), tables)
    quats = _quaternions(rows("quats"))
    scales = _look_up(tables.scales, rows("scales"))
    entries = np.zeros((1, 0, 3), np.uint8)
    if meta.get("shN"):
        pixels = image("shN", 0, 1, PALETTE_MAX * SH_COEFFICIENTS[3])
        coefficients, remainder = divmod(pixels.shape[1], PALETTE_COLUMNS)
        if coefficients not in SH_COEFFICIENTS[1:] or remainder:
            raise ValueError
        if len(pixels) > PALETTE_MAX // PALETTE_COLUMNS:
            raise ValueError
        if version == 2 and coefficients != SH_COEFFICIENTS[meta["shN"]["bands"]]:
            raise ValueError
        entries = pixels[..., :3].reshape(-1, coefficients, 3)
    sh = np.empty((count, 1 + entries.shape[1], 3), np.float32)
    if entries.shape[1]:
        labels = rows("shN", 1)[:, :2].astype(np.uint16) @ np.array([1, 256], np.uint16)
        if count and int(labels.max()) >= len(entries):
            raise InputError(f"{path} is damaged: it refers to an entry beyond its SH palette")
        for first in range(0, count, BLOCK):
            block = slice(first, first + BLOCK)
            sh[block, 1:] = tables.higher_sh[entries[labels[block]]]
    colors = rows("sh0")
    sh[:, 0] = _look_up(tables.colors, colors)
    parts = [means, quats, scales, tables.logits[colors[:, 3]], sh]
    return Gaussians(*(torch.from_numpy(part) for part in parts))


def _tables(meta: dict[str, Any], version: int) -> Tables:
    bounds = np.array([meta["means"]["mins"], meta["means"]["maxs"]], np.float64)
    if bounds.shape != (2, 3):
        raise ValueError
    byte = np.arange(256)
    rest = meta.get("shN")
    if version == 2:
        names = ("scales", "sh0", "shN") if rest else ("scales", "sh0")
        books = [np.array(meta[name]["codebook"], np.float32) for name in names]
        if any(book.shape != (256,) for book in books):
            raise ValueError
        for book in books:
            if np.isnan(book[0]):  # null in files of 2025; PlayCanvas extrapolates it like this
                book[0] = book[1] + (book[1] - book[255]) / 255
        logits = logits_of(byte / 255)
        scales, colors = (np.repeat(book[:, None], 3, axis=1) for book in books[:2])
        higher_sh = books[2] if rest else np.zeros(256, np.float32)
        return Tables(bounds, scales, colors, logits.astype(np.float32), higher_sh)
    scales, colors = _ramp(meta["scales"], (3,)), _ramp(meta["sh0"], (4,))
    higher_sh = _ramp(rest, ()) if rest else np.zeros(256, np.float32)
    return Tables(bounds, scales, colors[:, :3], colors[:, 3], higher_sh)


def _ramp(about: dict[str, Any], shape: tuple[int, ...]) -> np.ndarray:
    """Return the values of bytes in the range of version 1, `[256, *shape]`."""
    low, high = (np.array(about[end], np.float64) for end in ("mins", "maxs"))
    if low.shape != shape or high.shape != shape:
        raise ValueError
    share = (np.arange(256) / 255).reshape(-1, *(1 for _ in shape))
    return (low + (high - low) * share).astype(np.float32)


def _decode_webp(data: bytes, pixels_min: int, pixels_max: int, name: str) -> np.ndarray:
    """Decode a lossless WebP as uint8 `[height, width, 4]`.

    Raises InputError, before decoding, if its number of pixels is out of range.
    """
    (bits,) = struct.unpack_from("<I", data, 21) if len(data) > 25 else (0,)
    if len(data) <= 25 or data[:4] != b"RIFF" or data[8:16] != b"WEBPVP8L" or data[20] != 0x2F:
        raise InputError(f"{name} is not a lossless WebP image")
    width, height = (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    if not pixels_min <= width * height <= pixels_max:
        raise InputError(f"{name} has {width} x {height} pixels for {pixels_min} values")
    try:
        with Image.open(io.BytesIO(data), formats=["WEBP"]) as image:
            pixels = np.asarray(image.convert("RGBA"))
    except (OSError, ValueError, SyntaxError, EOFError, RuntimeError):
        raise InputError(f"{name} is damaged: the image cannot be decoded") from None
    if pixels.shape != (height, width, 4):
        raise InputError(f"{name} is damaged: the image has another size than its header says")
    return pixels


def _means(low: np.ndarray, high: np.ndarray, tables: Tables) -> np.ndarray:
    means = np.empty((len(low), 3), np.float32)
    span = tables.bounds[1] - tables.bounds[0]
    for first in range(0, len(low), BLOCK):
        rows = slice(first, first + BLOCK)
        with np.errstate(all="ignore"):  # `drawable` drops bad rows
            share = (low[rows, :3] + high[rows, :3] * 256.0) / 65535
            signed = tables.bounds[0] + span * share
            means[rows] = np.sign(signed) * np.expm1(np.abs(signed))
    return means


def _quaternions(rows: np.ndarray) -> np.ndarray:
    """Decode rotations wxyz: the fourth byte, 252 to 255, gives the largest component."""
    quats = np.empty((len(rows), 4), np.float32)
    for first in range(0, len(rows), BLOCK):
        block = rows[first : first + BLOCK]
        small = (block[:, :3] / 127.5 - 1) * SMALL_MAX
        valid = block[:, 3] >= 252
        largest = np.where(valid, block[:, 3], 252) - 252
        decoded = quats_of_smallest_three(small, largest)
        decoded[~valid] = [1, 0, 0, 0]  # no rotation, as in other tools
        quats[first : first + BLOCK] = decoded
    return quats


def _look_up(table: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Look up bytes `[n, 3]` in a table `[256, 3]`, one column per channel."""
    return np.stack([table[rows[:, i], i] for i in range(3)], axis=1)


def write_sog(
    path: Path | str, gaussians: Gaussians, *, footprint: Footprint = CLASSIC, note: str = ""
) -> Gaussians:
    """Write a scene for sorted blending to a `.sog` of version 2; return it in the file's order.

    The file appears complete or not at all, and has the same bytes for the same scene. Gaussians
    are sorted along a Morton curve; those that cannot be drawn are left out (`Gaussians.drawable`).
    More than 65,536 Gaussians share a palette of 65,536 sets of higher SH coefficients. `note` goes
    into the meta.json. An antialiased footprint becomes its field `model`, and readers draw a blur
    of 0.3: another blur is named in a logged warning. Raises InputError if none can be drawn.
    """
    if footprint.blur != BLUR:
        log.warning("a .sog has no place for the blur %g: readers draw 0.3", footprint.blur)
    gaussians = gaussians.detached().to("cpu", torch.float32).drawable(path)
    gaussians = gaussians.select(morton_order(gaussians.means))
    count = len(gaussians)
    width = max(4, math.ceil(count**0.5 / 4) * 4)
    height = max(4, math.ceil(count / width / 4) * 4)

    def image(*channels: np.ndarray) -> bytes:
        pixels = np.zeros((height * width, 4), np.uint8)
        pixels[:, 3] = 255
        for i, channel in enumerate(channels):
            pixels[:count, i] = channel
        return _encode_webp(pixels.reshape(height, width, 4))

    signed = gaussians.means.double().sign() * gaussians.means.double().abs().log1p()
    low, high = (
        end(signed, dim=0) if count else signed.new_zeros(3) for end in (torch.amin, torch.amax)
    )
    steps = ((signed - low) / (high - low).clamp_min(1e-30) * 65535).round().clamp(0, 65535)
    words = steps.numpy().astype(np.uint16)
    scale_book, scales = codebook(gaussians.log_scales.numpy())
    color_book, colors = codebook(gaussians.sh[:, 0].numpy())
    opacities = (gaussians.opacities * 255).round().numpy().astype(np.uint8)
    files = {
        "means_l.webp": image(*(words & 255).T),
        "means_u.webp": image(*(words >> 8).T),
        "quats.webp": image(*_pack_quaternions(gaussians.quats).T),
        "scales.webp": image(*scales.T),
        "sh0.webp": image(*colors.T, opacities),
    }
    meta: dict[str, Any] = {
        "version": 2,
        "asset": {
            "generator": f"mobilegs {__version__}",
            "extras": {"blend": "sorted"} | ({"note": note} if note else {}),
        },
        "count": count,
        **({"model": ANTIALIASED} if footprint.antialiased else {}),
        "means": {
            "mins": low.tolist(),
            "maxs": high.tolist(),
            "files": ["means_l.webp", "means_u.webp"],
        },
        "scales": {"codebook": scale_book.tolist(), "files": ["scales.webp"]},
        "quats": {"files": ["quats.webp"]},
        "sh0": {"codebook": color_book.tolist(), "files": ["sh0.webp"]},
    }
    if count and gaussians.sh_degree:
        entries, labels = palette(gaussians.sh[:, 1:].flatten(1), PALETTE_MAX)
        book, indices = codebook(entries.numpy())
        names = ["shN_centroids.webp", "shN_labels.webp"]
        rows = math.ceil(len(entries) / PALETTE_COLUMNS)
        pixels = np.zeros((rows * PALETTE_COLUMNS, indices.shape[1] // 3, 4), np.uint8)
        pixels[..., 3] = 255
        pixels[: len(entries), :, :3] = indices.reshape(len(entries), -1, 3)
        files[names[0]] = _encode_webp(pixels.reshape(rows, -1, 4))
        files[names[1]] = image(*np.array([labels & 255, labels >> 8, labels * 0], np.uint8))
        degree = gaussians.sh_degree
        meta["shN"] = {
            "count": len(entries),
            "bands": degree,
            "codebook": book.tolist(),
            "files": names,
        }
    with atomic_path(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, content in {**files, "meta.json": json.dumps(meta).encode()}.items():
            archive.writestr(zipfile.ZipInfo(name), content)
    return gaussians


def _encode_webp(pixels: np.ndarray) -> bytes:
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "WEBP", lossless=True, exact=True)
    return out.getvalue()


def _pack_quaternions(quats: torch.Tensor) -> np.ndarray:
    """Encode rotations as bytes `[n, 4]`, which `_quaternions` decodes."""
    unit_quats = torch.nn.functional.normalize(quats.double(), dim=1)
    largest = unit_quats.abs().argmax(1, keepdim=True)
    unit_quats = unit_quats * torch.where(unit_quats.gather(1, largest) < 0, -1, 1)
    others = torch.tensor([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[largest[:, 0]]
    small = ((unit_quats.gather(1, others) * math.sqrt(2) + 1) * 127.5).round().clamp(0, 255)
    return torch.cat([small, 252 + largest], dim=1).to(torch.uint8).numpy()


def morton_order(means: torch.Tensor) -> torch.Tensor:
    """Return the order of Gaussians along a Morton curve, `[n]`: neighbours are similar."""
    if not len(means):
        return torch.arange(0)
    # ranks instead of positions, so that a few distant ones do not matter
    ranks = means.argsort(dim=0).argsort(dim=0) * (1 << MORTON_BITS) // len(means)
    curve = torch.zeros(len(means), dtype=torch.long)
    for bit in range(MORTON_BITS):
        for axis in range(3):
            curve |= (ranks[:, axis] >> bit & 1) << (3 * bit + axis)
    return curve.argsort(stable=True)
