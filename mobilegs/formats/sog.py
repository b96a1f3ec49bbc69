"""PlayCanvas's `.sog`: scenes as lossless WebP pictures and a `meta.json`, in a zip or a folder.

Every picture has a pixel for each Gaussian: positions in a signed logarithm, 16 bits in two of
them; rotations as the three smaller parts in bytes; scales, colours and opacity as bytes, which
version 2 looks up among 256 values and version 1 takes between bounds; the higher harmonics as a
number in a palette, itself a picture. Axes are those of the `.ply` it was made of. The facts are
those of developer.playcanvas.com/user-manual/gaussian-splatting/formats/sog.
"""

import io
import json
import math
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
from mobilegs.atomic import atomic_path, file_size
from mobilegs.errors import InputError
from mobilegs.formats.sog_palette import codebook, palette
from mobilegs.gaussians import Gaussians

COUNT_MAX = 10_000_000
GAUSSIANS_PER_BYTE = 1  # no real scene comes near; a small file must not ask for much memory
TEXT_MAX = 1 << 18  # bytes of meta.json, which has about 20,000
INDEX_MAX = (
    1 << 16
)  # bytes of a zip's list of files, which takes many times as much when it is read
COEFFICIENTS = (0, 3, 8, 15)  # of a colour, by degree, without the constant
PALETTE = 1 << 16
ROW = 64  # sets of harmonics side by side in the palette's picture
CLEAR = 1e-6  # 0 and 255 are no logits; both stay as good as invisible and opaque
BLOCK = 1 << 15  # Gaussians that are decoded at a time
DIGITS = 10  # bits of an axis for the order of the Gaussians

# what `zipfile` makes of archives that are damaged, encrypted, or packed in a way unknown to it
BROKEN = (zipfile.BadZipFile, zlib.error, struct.error, OSError, EOFError, RuntimeError)

Take = Callable[[str, int], bytes]  # a file by its name, with so many bytes at most


@dataclass(frozen=True)
class Tables:
    """What bytes stand for.

    Attributes:
        bounds: of the positions' signed logarithms, `[2, 3]`.
        scales: logarithms of scales, `[256, 3]`.
        colors: constant harmonics, `[256, 3]`.
        logits: of opacities, `[256]`.
        harmonics: higher ones, `[256]`.
    """

    bounds: np.ndarray
    scales: np.ndarray
    colors: np.ndarray
    logits: np.ndarray
    harmonics: np.ndarray


def read_sog(path: Path | str) -> Gaussians:
    """Read a `.sog`, or a folder or the `meta.json` in it, as float32 on the CPU.

    What is not finite is left out, and counted in a logged warning.

    Raises:
        InputError: something is missing, is no `.sog`, is of another version, damaged or cut off.
    """
    path = Path(path)
    try:
        with _opened(path) as (take, size):
            return _read(take, size, path).finite(path)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError):
        raise InputError(f"{path} is damaged: its parts do not fit together") from None


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Take, int]]:
    """What takes files out of it, and its size in bytes."""
    folder = path if path.is_dir() else path.parent if path.name == "meta.json" else None
    if folder is not None:
        files = [file for file in folder.iterdir() if file.suffix in (".json", ".webp")]
        yield _from_folder(folder), sum(file.stat().st_size for file in files)
        return
    size = file_size(path)
    with path.open("rb") as file:
        file.seek(max(0, size - 42))
        end = file.read(42)
        # the list of files: not long, and not of the kind that is for more than 4 GB
        signs = end[-22:-18], end[:4]
        if len(end) < 22 or signs[0] != b"PK\5\6" or signs[1] == b"PK\6\7":
            raise InputError(
                f"{path} is no .sog, or cut off: it does not end as a zip archive does"
            )
        if struct.unpack_from("<I", end, len(end) - 10)[0] > INDEX_MAX:
            raise InputError(f"{path} is no .sog: it is an archive of too many files")
        try:
            with zipfile.ZipFile(file) as archive:
                yield _from_zip(archive, path), size
        except BROKEN:
            raise InputError(f"{path} is damaged: its archive cannot be opened") from None


def _from_zip(archive: zipfile.ZipFile, path: Path) -> Take:
    def take(name: str, most: int) -> bytes:
        if name not in archive.namelist():
            raise InputError(f"{path} lacks {name[:40]}: it is no .sog")
        if archive.getinfo(name).compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise NotImplementedError  # others unpack more than they are asked for
        with archive.open(name) as file:
            content = file.read(most + 1)
        if len(content) > most:
            raise InputError(f"{path} is damaged: its {name} is larger than it can be")
        return content

    return take


def _from_folder(folder: Path) -> Take:
    def take(name: str, most: int) -> bytes:
        file_size(folder / name)
        with (folder / name).open("rb") as file:
            content = file.read(most + 1)
        if len(content) > most:
            raise InputError(f"{folder / name} is larger than it can be")
        return content

    return take


def _read(take: Take, size: int, path: Path) -> Gaussians:
    try:
        meta = json.loads(take("meta.json", TEXT_MAX))
    except RecursionError:
        raise InputError(f"{path} is damaged: its meta.json cannot be read") from None
    version = meta.get("version", 1)
    if version not in (1, 2):
        raise InputError(f"{path} has another version of .sog: 1 and 2 can be read")
    count = meta["count"] if version == 2 else meta["means"]["shape"][0]
    if type(count) is not int or not 0 <= count < 1 << 53:
        raise ValueError
    if count > min(COUNT_MAX, GAUSSIANS_PER_BYTE * size):
        raise InputError(f"{path} announces {count} Gaussians in {size} bytes: it is cut off")
    with np.errstate(all="ignore"):  # what is not finite is left out in the end
        tables = _tables(meta, version)

    def picture(name: str, which: int, least: int, most: int) -> np.ndarray:
        file = meta[name]["files"][which]
        if not isinstance(file, str) or not re.fullmatch(r"[\w-][\w.-]{0,60}", file, re.ASCII):
            raise ValueError
        return _pixels(take(file, 5 * most + (1 << 16)), least, most, f"{path}: {file}")

    def rows(name: str, which: int = 0) -> np.ndarray:
        return picture(name, which, count, 2 * count + 4096).reshape(-1, 4)[:count]

    means = _means(rows("means"), rows("means", 1), tables)
    quats = _quaternions(rows("quats"))
    scales = _looked_up(tables.scales, rows("scales"))
    sh = np.zeros((1, 0, 3), np.uint8)
    if meta.get("shN"):
        sets = picture("shN", 0, 1, PALETTE * COEFFICIENTS[3])
        each = sets.shape[1] // ROW
        if each not in COEFFICIENTS[1:] or sets.shape[1] % ROW or len(sets) > PALETTE // ROW:
            raise ValueError
        if version == 2 and each != COEFFICIENTS[meta["shN"]["bands"]]:
            raise ValueError
        sh = sets[..., :3].reshape(-1, each, 3)
    harmonics = np.empty((count, 1 + sh.shape[1], 3), np.float32)
    if sh.shape[1]:
        labels = rows("shN", 1)[:, :2].astype(np.uint16) @ np.array([1, 256], np.uint16)
        if count and int(labels.max()) >= len(sh):
            raise InputError(f"{path} is damaged: it names harmonics that its palette has not")
        for first in range(0, count, BLOCK):
            block = slice(first, first + BLOCK)
            harmonics[block, 1:] = tables.harmonics[sh[labels[block]]]
    last = rows("sh0")
    harmonics[:, 0] = _looked_up(tables.colors, last)
    parts = [means, quats, scales, tables.logits[last[:, 3]], harmonics]
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
            if np.isnan(book[0]):  # null in files of 2025: PlayCanvas goes on as the others do
                book[0] = book[1] + (book[1] - book[255]) / 255
        opaque = np.clip(byte / 255, CLEAR, 1 - CLEAR)
        logits = np.log(opaque / (1 - opaque))
        scales, colors = (np.repeat(book[:, None], 3, axis=1) for book in books[:2])
        harmonics = books[2] if rest else np.zeros(256, np.float32)
        return Tables(bounds, scales, colors, logits.astype(np.float32), harmonics)
    scales, colors = _ramp(meta["scales"], (3,)), _ramp(meta["sh0"], (4,))
    harmonics = _ramp(rest, ()) if rest else np.zeros(256, np.float32)
    return Tables(bounds, scales, colors[:, :3], colors[:, 3], harmonics)


def _ramp(about: dict[str, Any], shape: tuple[int, ...]) -> np.ndarray:
    """What bytes stand for between the bounds of version 1, `[256, *shape]`."""
    low, high = (np.array(about[end], np.float64) for end in ("mins", "maxs"))
    if low.shape != shape or high.shape != shape:
        raise ValueError
    share = (np.arange(256) / 255).reshape(-1, *(1 for _ in shape))
    return (low + (high - low) * share).astype(np.float32)


def _pixels(data: bytes, least: int, most: int, what: str) -> np.ndarray:
    """Bytes `[height, width, 4]` of a lossless WebP with so many pixels."""
    (bits,) = struct.unpack_from("<I", data, 21) if len(data) > 25 else (0,)
    if len(data) <= 25 or data[:4] != b"RIFF" or data[8:16] != b"WEBPVP8L" or data[20] != 0x2F:
        raise InputError(f"{what} is no lossless WebP picture")
    width, height = (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    if not least <= width * height <= most:
        raise InputError(f"{what} has {width} x {height} pixels for {least} values")
    try:
        with Image.open(io.BytesIO(data), formats=["WEBP"]) as image:
            found = np.asarray(image.convert("RGBA"))
    except (OSError, ValueError, SyntaxError, EOFError, RuntimeError):
        raise InputError(f"{what} is damaged: the picture cannot be decoded") from None
    if found.shape != (height, width, 4):
        raise InputError(f"{what} is damaged: the picture has another size than it says")
    return found


def _means(low: np.ndarray, high: np.ndarray, tables: Tables) -> np.ndarray:
    found = np.empty((len(low), 3), np.float32)
    span = tables.bounds[1] - tables.bounds[0]
    for first in range(0, len(low), BLOCK):
        rows = slice(first, first + BLOCK)
        with np.errstate(all="ignore"):  # what is not finite is left out in the end
            share = (low[rows, :3] + high[rows, :3] * 256.0) / 65535
            signed = tables.bounds[0] + span * share
            found[rows] = np.sign(signed) * np.expm1(np.abs(signed))
    return found


def _quaternions(rows: np.ndarray) -> np.ndarray:
    """The fourth byte says which of w, x, y, z is largest, from 252 on; the others are in order."""
    found = np.empty((len(rows), 4), np.float32)
    order = np.array([[0, 1, 2, 3], [1, 0, 2, 3], [1, 2, 0, 3], [1, 2, 3, 0]])
    for first in range(0, len(rows), BLOCK):
        block = rows[first : first + BLOCK]
        parts = np.empty((len(block), 4))
        parts[:, 1:] = (block[:, :3] / 127.5 - 1) * math.sqrt(0.5)
        parts[:, 0] = np.sqrt(np.clip(1 - (parts[:, 1:] ** 2).sum(1), 0, None))
        sound = block[:, 3] >= 252  # other tools make of the rest no rotation, too
        parts[~sound] = [1, 0, 0, 0]
        largest = np.where(sound, block[:, 3], 252) - 252
        found[first : first + BLOCK] = np.take_along_axis(parts, order[largest], axis=1)
    return found


def _looked_up(table: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Values `[n, 3]` of a table with a column for each of three channels."""
    return np.stack([table[rows[:, i], i] for i in range(3)], axis=1)


def write_sog(path: Path | str, gaussians: Gaussians, *, note: str = "") -> None:
    """Write a scene for sorted blending as version 2, a zip, whole or not at all; the same bytes
    for the same scene.

    Gaussians change their order, neighbours in space come together; what is not finite is left out.
    Up to 65,536 Gaussians keep their own harmonics, more share as many sets of them. `note`
    goes into the meta.json.
    """
    gaussians = gaussians.detached().to("cpu", torch.float32).finite(path)
    gaussians = gaussians.select(morton_order(gaussians.means))
    count = len(gaussians)
    width = max(4, math.ceil(count**0.5 / 4) * 4)
    height = max(4, math.ceil(count / width / 4) * 4)

    def picture(*columns: np.ndarray) -> bytes:
        whole = np.zeros((height * width, 4), np.uint8)
        whole[:, 3] = 255
        for i, column in enumerate(columns):
            whole[:count, i] = column
        return _webp(whole.reshape(height, width, 4))

    signed = gaussians.means.double().sign() * gaussians.means.double().abs().log1p()
    low, high = (
        end(signed, dim=0).tolist() if count else [0.0] * 3 for end in (torch.amin, torch.amax)
    )
    span = (torch.tensor(high) - torch.tensor(low)).double().clamp_min(1e-30)
    places = ((signed - torch.tensor(low).double()) / span * 65535).round().clamp(0, 65535)
    words = places.numpy().astype(np.uint16)
    scale_book, scales = codebook(gaussians.log_scales.numpy())
    color_book, colors = codebook(gaussians.sh[:, 0].numpy())
    opacities = (gaussians.opacities * 255).round().numpy().astype(np.uint8)
    files = {
        "means_l.webp": picture(*(words & 255).T),
        "means_u.webp": picture(*(words >> 8).T),
        "quats.webp": picture(*_packed(gaussians.quats).T),
        "scales.webp": picture(*scales.T),
        "sh0.webp": picture(*colors.T, opacities),
    }
    meta: dict[str, Any] = {
        "version": 2,
        "asset": {
            "generator": f"mobilegs {__version__}",
            "extras": {"blend": "sorted"} | ({"note": note} if note else {}),
        },
        "count": count,
        "means": {"mins": low, "maxs": high, "files": ["means_l.webp", "means_u.webp"]},
        "scales": {"codebook": scale_book.tolist(), "files": ["scales.webp"]},
        "quats": {"files": ["quats.webp"]},
        "sh0": {"codebook": color_book.tolist(), "files": ["sh0.webp"]},
    }
    if count and gaussians.sh_degree:
        sets, labels = palette(gaussians.sh[:, 1:].flatten(1), PALETTE)
        book, found = codebook(sets.numpy())
        names = ["shN_centroids.webp", "shN_labels.webp"]
        rows = math.ceil(len(sets) / ROW)
        whole = np.zeros((rows * ROW, found.shape[1] // 3, 4), np.uint8)
        whole[..., 3] = 255
        whole[: len(sets), :, :3] = found.reshape(len(sets), -1, 3)
        files[names[0]] = _webp(whole.reshape(rows, -1, 4))
        files[names[1]] = picture(*np.array([labels & 255, labels >> 8, labels * 0], np.uint8))
        degree = gaussians.sh_degree
        meta["shN"] = {
            "count": len(sets),
            "bands": degree,
            "codebook": book.tolist(),
            "files": names,
        }
    with atomic_path(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, content in {**files, "meta.json": json.dumps(meta).encode()}.items():
            archive.writestr(zipfile.ZipInfo(name), content)


def _webp(pixels: np.ndarray) -> bytes:
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "WEBP", lossless=True, exact=True)
    return out.getvalue()


def _packed(quats: torch.Tensor) -> np.ndarray:
    """Rotations as bytes `[n, 4]`, see `_quaternions`."""
    found = torch.nn.functional.normalize(quats.double(), dim=1)
    largest = found.abs().argmax(1, keepdim=True)
    found = found * torch.where(found.gather(1, largest) < 0, -1, 1)
    others = torch.tensor([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[largest[:, 0]]
    small = ((found.gather(1, others) * math.sqrt(2) + 1) * 127.5).round().clamp(0, 255)
    return torch.cat([small, 252 + largest], dim=1).to(torch.uint8).numpy()


def morton_order(means: torch.Tensor) -> torch.Tensor:
    """Rows `[n]` along a Morton curve, in which `write_sog` has them: neighbours are alike."""
    if not len(means):
        return torch.arange(0)
    # positions' ranks, which a few far away ones do not squeeze together
    places = means.argsort(dim=0).argsort(dim=0) * (1 << DIGITS) // len(means)
    curve = torch.zeros(len(means), dtype=torch.long)
    for bit in range(DIGITS):
        for axis in range(3):
            curve |= (places[:, axis] >> bit & 1) << (3 * bit + axis)
    return curve.argsort(stable=True)
