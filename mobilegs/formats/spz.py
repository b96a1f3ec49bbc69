"""Niantic's `.spz`: 3DGS scenes in some nine times fewer bytes than PLY, versions 1 to 4.

Versions 1 to 3 are one gzip stream: a header of 16 bytes, then the positions of all Gaussians,
their opacities, colours, scales, rotations, harmonics. Version 4 has a header of 32 bytes in plain,
and each of these as a Zstandard stream. Axes are RUB (y up, z backwards), ours RDF. The facts are
those of github.com/nianticlabs/spz; `view/web/load/spz.js` reads the same in the browser. Version 3
is what is written: every reader knows it.
"""

import gzip
import io
import math
import struct
import zlib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch

from mobilegs.atomic import atomic_path, read_if
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians

MAGIC = b"NGSP"
GZIP = b"\x1f\x8b"
COUNT_MAX = 10_000_000  # as the format's own readers had it
HEADER, HEADER_4 = 16, 32  # bytes, up to version 3 and in version 4
COEFFICIENTS = (0, 3, 8, 15, 24)  # of a colour, by degree, without the constant
KEPT = 15  # of those: degree 4 cannot be drawn
COLOR = 0.15  # of the constant coefficient in a byte's range
GAUSSIANS_PER_BYTE = 1  # no real scene comes near; a small file must not ask for much memory
WINDOW_MAX = 1 << 27  # bytes that a Zstandard stream may ask for
FRACTION, FAR = 12, 24  # bits behind the point that are usual, and the most
PLACES = 16  # bits that the farthest position has at least
STEPS = (8, 16)  # of a harmonic's byte: five bits of degree 1, four of higher ones, as is usual
LEVEL = 6  # of gzip; 9 saves 2 % and takes five times as long
BLOCK = 1 << 15  # rows that are decoded at a time
# of harmonics when y and z change their signs: what each is odd in
SIGNS = np.array([-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1], np.float32)


@dataclass(frozen=True)
class Header:
    """What an `.spz` says of itself."""

    version: int
    count: int
    degree: int
    fraction: int  # bits behind the point of positions
    extended: bool  # something follows that only some tools know
    streams: int  # of version 4
    table: int  # where version 4 says how long its streams are

    @property
    def widths(self) -> list[int]:
        """Bytes of each attribute of a Gaussian."""
        each = [6 if self.version == 1 else 9, 1, 3, 3, 3 if self.version < 3 else 4]
        return [*each, 3 * COEFFICIENTS[self.degree]]

    @property
    def sizes(self) -> list[int]:
        """Bytes of each attribute."""
        return [self.count * width for width in self.widths]


def read_spz(path: Path | str) -> Gaussians:
    """Read an `.spz` scene as float32 on the CPU; harmonics of degree 4 are cut to 3.

    Raises:
        InputError: the file is missing, is no `.spz`, is of another version, is damaged or cut off.
    """
    path = Path(path)
    try:
        data = read_if(path, (GZIP, MAGIC))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None
    if data[:2] == GZIP:
        header, parts = _gunzipped(data, path)
    else:
        header = _parse(data, path, len(data))
        parts = _unpacked(header, data, path)
    return _gaussians(header, parts, path)


def _damaged(path: Path) -> InputError:
    return InputError(f"{path} is damaged or cut off: get it again from where it came")


def _parse(data: bytes, path: Path, size: int) -> Header:
    """The header at the start of `data`; the file has `size` bytes."""
    if len(data) < HEADER or data[:4] != MAGIC:
        raise InputError(f"{path} is not an .spz scene")
    version, count, degree, fraction, flags, streams = struct.unpack_from("<IIBBBB", data, 4)
    if not 1 <= version <= 4:
        raise InputError(f"{path} has version {version} of .spz: 1 to 4 can be read")
    if count > COUNT_MAX:
        raise InputError(f"{path} announces {count} Gaussians: {COUNT_MAX} can be read")
    if count > GAUSSIANS_PER_BYTE * size:
        raise InputError(f"{path} announces {count} Gaussians in {size} bytes: it is cut off")
    if degree > 4 or fraction > 24 or (version == 4 and len(data) < HEADER_4):
        raise _damaged(path)
    table = struct.unpack_from("<I", data, 16)[0] if version == 4 else 0
    return Header(version, count, degree, fraction, bool(flags & 2), streams, table)


def _gunzipped(data: bytes, path: Path) -> tuple[Header, list[np.ndarray]]:
    """Decompresses as much as the header announces, and no more."""
    unzip = zlib.decompressobj(wbits=31)
    try:
        head = unzip.decompress(data, HEADER)
        header = _parse(head, path, len(data))
        if header.version > 3:
            raise InputError(f"{path} is not an .spz scene")
        size = sum(header.sizes)
        content = unzip.decompress(unzip.unconsumed_tail, size + 1)
    except zlib.error:
        raise _damaged(path) from None
    if unzip.unused_data:
        raise _damaged(path)
    if len(content) > size and not header.extended:
        raise InputError(f"{path} holds more than the {header.count} Gaussians it announces")
    if len(content) < size or not (unzip.eof or header.extended):  # or without its checksum
        raise InputError(f"{path} is cut off: {header.count} Gaussians were announced")
    ends = np.cumsum([0, *header.sizes])
    whole = np.frombuffer(content, np.uint8)
    return header, [whole[start:end] for start, end in pairwise(ends)]


def _unpacked(header: Header, data: bytes, path: Path) -> list[np.ndarray]:
    """The streams of version 4."""
    import zstandard

    end = header.table + 16 * header.streams
    sent = sum(size > 0 for size in header.sizes)  # what is empty has no stream
    if header.version != 4 or header.table < HEADER_4 or end > len(data) or sent != header.streams:
        raise _damaged(path)
    unzip = zstandard.ZstdDecompressor(max_window_size=WINDOW_MAX)
    parts, entry, at = [], header.table, end
    for size in header.sizes:
        if size == 0:
            parts.append(np.zeros(0, np.uint8))
            continue
        length, announced = struct.unpack_from("<QQ", data, entry)
        if at + length > len(data) or announced != size:
            raise _damaged(path)
        try:
            source = io.BytesIO(data[at : at + length])
            with unzip.stream_reader(source, read_across_frames=True) as stream:
                content = stream.read(size + 1)
        except zstandard.ZstdError:
            raise _damaged(path) from None
        if len(content) != size:
            raise _damaged(path)
        parts.append(np.frombuffer(content, np.uint8))
        entry, at = entry + 16, at + length
    return parts


def _gaussians(header: Header, parts: list[np.ndarray], path: Path) -> Gaussians:
    count = header.count
    kept = min(COEFFICIENTS[header.degree], KEPT)
    shapes = [(count, 3), (count, 4), (count, 3), (count,), (count, kept + 1, 3)]
    found = [np.empty(shape, np.float32) for shape in shapes]
    tables = [part.reshape(count, width) for part, width in zip(parts, header.widths, strict=True)]
    for start in range(0, count, BLOCK):  # what is found on the way is several times as large
        rows = slice(start, start + BLOCK)
        for whole, values in zip(found, _decoded(header, *(t[rows] for t in tables)), strict=True):
            whole[rows] = values
    if not np.isfinite(found[0]).all():
        raise _damaged(path)
    return Gaussians(*(torch.from_numpy(whole) for whole in found))


def _decoded(
    header: Header,
    positions: np.ndarray,
    opacities: np.ndarray,
    colors: np.ndarray,
    scales: np.ndarray,
    rotations: np.ndarray,
    harmonics: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """Means, quaternions, log-scales, logits, harmonics of some rows of bytes."""
    sent = COEFFICIENTS[header.degree]
    kept = min(sent, KEPT)
    with np.errstate(invalid="ignore"):  # NaN, which is refused in the end
        means = _positions(header, positions) * np.array([1, -1, -1], np.float32)
    turn = _first_three if header.version < 3 else _smallest_three
    quats = turn(rotations)
    quats[:, 2:] *= -1  # y and z
    # 0 and 255 are no logits; both stay as good as invisible and opaque
    opaque = np.clip(opacities[:, 0] / 255, 1e-6, 1 - 1e-6)
    sh = np.empty((len(means), kept + 1, 3), np.float32)
    sh[:, 0] = (colors / 255 - 0.5) / COLOR
    rest = harmonics.reshape(len(means), sent, 3)[:, :kept].astype(np.float32) - 128
    sh[:, 1:] = rest / 128 * SIGNS[:kept, None]
    return means, quats, scales / 16 - 10, np.log(opaque / (1 - opaque)), sh


def _positions(header: Header, data: np.ndarray) -> np.ndarray:
    if header.version == 1:
        return np.ascontiguousarray(data).view("<f2").astype(np.float32)
    low, middle, high = data.reshape(-1, 3).astype(np.int32).T
    fixed = low | middle << 8 | high << 16
    fixed = np.where(high > 127, fixed - (1 << 24), fixed)
    return (fixed * 2.0**-header.fraction).astype(np.float32).reshape(len(data), 3)


def _first_three(data: np.ndarray) -> np.ndarray:
    """Versions 1 and 2: x, y, z; w follows, as it is not negative."""
    vector = data / 127.5 - 1
    w = np.sqrt(np.clip(1 - (vector**2).sum(1), 0, None))
    return np.column_stack([w, vector])


def _smallest_three(data: np.ndarray) -> np.ndarray:
    """From version 3 on: which of x, y, z, w is largest, the others as signs and nine bits."""
    words = np.ascontiguousarray(data).view("<u4")[:, 0]
    largest = words >> 30
    rows = np.arange(len(words))
    found = np.zeros((len(words), 4))  # x, y, z, w
    place = np.zeros(len(words), np.int64)
    for shift in (20, 10, 0):
        place += place == largest
        part = words >> shift
        size = (part & 511) / 511 * math.sqrt(0.5)
        found[rows, place] = np.where(part & 512, -size, size)
        place += 1
    found[rows, largest] = np.sqrt(np.clip(1 - (found**2).sum(1), 0, None))
    return found[:, [3, 0, 1, 2]]


def write_spz(path: Path | str, gaussians: Gaussians) -> None:
    """Write a scene for sorted blending as version 3, whole or not at all; what is not finite is
    left out.

    Raises:
        InputError: there are more Gaussians than readers take, or one is farther than 2^23 away.
    """
    gaussians = gaussians.detached().to("cpu", torch.float32).finite(path)
    count, degree = len(gaussians), gaussians.sh_degree
    if count > COUNT_MAX:
        raise InputError(f"cannot write {path}: {count} Gaussians are more than {COUNT_MAX}")
    # so many bits are before the point of the farthest position
    whole = math.frexp(float(gaussians.means.abs().max()))[1] if count else 0
    fraction = min(23 - whole, max(FRACTION, PLACES - whole), FAR)
    if fraction < 0:
        raise InputError(f"cannot write {path}: a Gaussian is farther away than a .spz can tell")
    header = Header(3, count, degree, fraction, False, 0, 0)
    start = MAGIC + struct.pack("<IIBBBB", 3, count, degree, fraction, 0, 0)
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        with gzip.GzipFile("", "wb", LEVEL, file, mtime=0) as zipped:
            zipped.write(start)
            for part in _encoded(header, gaussians):
                zipped.write(part.tobytes())


def _encoded(header: Header, gaussians: Gaussians) -> list[np.ndarray]:
    """The attributes' bytes, in their order."""
    means, quats, log_scales, logits, sh = (v.numpy() for v in gaussians.tensors().values())
    most = (1 << 23) - 1
    fixed = np.rint(means * np.array([1, -1, -1]) * 2.0**header.fraction).clip(-most, most)
    positions = fixed.astype("<i4").reshape(-1, 1).view(np.uint8)[:, :3]
    opacities = 255 / (1 + np.exp(-logits.astype(np.float64)))
    kept = sh.shape[1] - 1
    steps = np.repeat(STEPS, (3, max(0, kept - 3)))[:kept, None]
    rest = np.rint((sh[:, 1:] * SIGNS[:kept, None] * 128 + 128) / steps) * steps
    return [
        positions,
        _byte(opacities),
        _byte((sh[:, 0] * COLOR + 0.5) * 255),
        _byte((log_scales + 10) * 16),
        _three_of_four(quats),
        _byte(rest),
    ]


def _byte(values: np.ndarray) -> np.ndarray:
    return np.rint(values).clip(0, 255).astype(np.uint8)


def _three_of_four(quats: np.ndarray) -> np.ndarray:
    """What `_smallest_three` reads, as words."""
    turned = quats[:, [1, 2, 3, 0]] * np.array([1, -1, -1, 1.0])  # x, y, z, w in RUB
    turned /= np.linalg.norm(turned, axis=1, keepdims=True).clip(1e-30)
    largest = np.abs(turned).argmax(1)
    rows = np.arange(len(turned))
    turned *= np.where(turned[rows, largest] < 0, -1, 1)[:, None]
    words = largest.astype("<u4")
    for part in np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[largest].T:
        value = turned[rows, part]
        size = np.rint(np.abs(value) * math.sqrt(2) * 511).clip(0, 511).astype("<u4")
        words = words << 10 | (value < 0).astype("<u4") << 9 | size
    return words.astype("<u4")
