"""Reads Niantic's `.spz`, versions 1 to 4, and writes version 3, which every reader supports.

An `.spz` is about nine times smaller than a PLY. Versions 1 to 3 are one gzip stream: a header of
16 bytes, then positions, opacities, colours, scales, rotations and SH coefficients of all
Gaussians. Version 4 has an uncompressed header of 32 bytes and one Zstandard stream per attribute.
Axes are RUB (y up, z backwards) in the file and RDF here. Source:
https://github.com/nianticlabs/spz. `viewer/src/load/spz.js` reads the same in the browser.
"""

import gzip
import io
import logging
import math
import struct
import zlib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch

from mobilegs.atomic import atomic_path, read_input
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.packed_gaussians import (
    SMALL_MAX,
    gaussians_in_blocks,
    logits_of,
    quats_of_smallest_three,
)
from mobilegs.render.project import BLUR, CLASSIC, Footprint

log = logging.getLogger(__name__)

MAGIC = b"NGSP"
GZIP = b"\x1f\x8b"
COUNT_MAX = 10_000_000  # as in the format's own readers
HEADER, HEADER_4 = 16, 32  # bytes, up to version 3 and in version 4
SH_COEFFICIENTS = (0, 3, 8, 15, 24)  # per channel above degree 0, by degree
ANTIALIASED, EXTENDED = 1, 2  # bits of the flags
SH_KEPT = 15  # degree 4 is not supported by the renderers
COLOR_SCALE = 0.15  # of degree-0 SH in the range of a byte
GAUSSIANS_PER_BYTE = 1  # far above real scenes; limits the memory for small files
WINDOW_MAX = 1 << 27  # bytes of a Zstandard window
FRACTION_BITS, FRACTION_BITS_MAX = 12, 24  # of positions: usual and largest number
POSITION_BITS_MIN = 16  # of the farthest position
STEPS_PER_SIZE = 4  # of positions, in the size of a small Gaussian
SMALL_SHARE = 0.01  # of the Gaussians, those that are smaller than a small one
SH_STEPS = (8, 16)  # steps of a byte: 5 bits for degree 1 and 4 for higher ones, as is usual
GZIP_LEVEL = 6  # 9 saves 2 % and takes five times as long
# signs of the SH coefficients above degree 0 when y and z change sign
SH_SIGNS = np.array([-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1], np.float32)


@dataclass(frozen=True)
class Header:
    """The header of an `.spz`."""

    version: int
    count: int
    degree: int
    fraction_bits: int  # of positions
    antialiased: bool
    extended: bool  # extensions follow
    streams: int  # number of streams, version 4
    table: int  # offset of the streams' sizes, version 4

    @property
    def widths(self) -> list[int]:
        """Bytes per Gaussian of each attribute."""
        widths = [6 if self.version == 1 else 9, 1, 3, 3, 3 if self.version < 3 else 4]
        return [*widths, 3 * SH_COEFFICIENTS[self.degree]]

    @property
    def sizes(self) -> list[int]:
        return [self.count * width for width in self.widths]


def read_spz(path: Path | str) -> Gaussians:
    """Read the Gaussians of an `.spz`; see `read_spz_scene`."""
    return read_spz_scene(path)[0]


def read_spz_scene(path: Path | str) -> tuple[Gaussians, Footprint]:
    """Read an `.spz` as float32 on the CPU, and how its Gaussians cover pixels.

    SH of degree 4 are cut to degree 3. Gaussians that cannot be drawn are left out
    (`Gaussians.drawable`). Raises InputError if the file is missing, not an `.spz` of version 1 to
    4, damaged or cut off, or none can be drawn.
    """
    path = Path(path)
    data = read_input(path, starts=(GZIP, MAGIC))
    if data[:2] == GZIP:
        header, parts = _decompress_gzip(data, path)
    else:
        header = _parse(data, path, len(data))
        parts = _decompress_streams(header, data, path)
    return _gaussians(header, parts, path), Footprint(antialiased=header.antialiased)


def _damaged(path: Path) -> InputError:
    return InputError(f"{path} is damaged or cut off: copy it again")


def _parse(data: bytes, path: Path, size: int) -> Header:
    """Parse the header at the start of `data`; the file has `size` bytes."""
    if len(data) < HEADER or data[:4] != MAGIC:
        raise InputError(f"{path} is not an .spz scene")
    version, count, degree, fraction_bits, flags, streams = struct.unpack_from("<IIBBBB", data, 4)
    if not 1 <= version <= 4:
        raise InputError(f"{path} has .spz version {version}, and only 1 to 4 are supported")
    if count > COUNT_MAX:
        raise InputError(f"{path} announces {count} Gaussians, more than {COUNT_MAX}")
    if count > GAUSSIANS_PER_BYTE * size:
        raise InputError(f"{path} announces {count} Gaussians in {size} bytes: it is cut off")
    if degree > 4 or fraction_bits > FRACTION_BITS_MAX or (version == 4 and len(data) < HEADER_4):
        raise _damaged(path)
    table = struct.unpack_from("<I", data, 16)[0] if version == 4 else 0
    known = bool(flags & ANTIALIASED), bool(flags & EXTENDED)
    return Header(version, count, degree, fraction_bits, *known, streams, table)


def _decompress_gzip(data: bytes, path: Path) -> tuple[Header, list[np.ndarray]]:
    """Decompress versions 1 to 3, and no more bytes than the header announces."""
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
        raise InputError(f"{path} has more than the {header.count} Gaussians it announces")
    if len(content) < size or not (unzip.eof or header.extended):  # eof: with checksum
        raise InputError(f"{path} is cut off: its header announces {header.count} Gaussians")
    ends = np.cumsum([0, *header.sizes])
    whole = np.frombuffer(content, np.uint8)
    return header, [whole[start:end] for start, end in pairwise(ends)]


def _decompress_streams(header: Header, data: bytes, path: Path) -> list[np.ndarray]:
    import zstandard

    end = header.table + 16 * header.streams
    expected = sum(size > 0 for size in header.sizes)  # an empty attribute has no stream
    if header.version != 4 or header.table < HEADER_4 or end > len(data):
        raise _damaged(path)
    if expected != header.streams:
        raise _damaged(path)
    unzip = zstandard.ZstdDecompressor(max_window_size=WINDOW_MAX)
    parts, entry, offset = [], header.table, end
    for size in header.sizes:
        if size == 0:
            parts.append(np.zeros(0, np.uint8))
            continue
        length, announced = struct.unpack_from("<QQ", data, entry)
        if offset + length > len(data) or announced != size:
            raise _damaged(path)
        try:
            source = io.BytesIO(data[offset : offset + length])
            with unzip.stream_reader(source, read_across_frames=True) as stream:
                content = stream.read(size + 1)
        except zstandard.ZstdError:
            raise _damaged(path) from None
        if len(content) != size:
            raise _damaged(path)
        parts.append(np.frombuffer(content, np.uint8))
        entry, offset = entry + 16, offset + length
    return parts


def _gaussians(header: Header, parts: list[np.ndarray], path: Path) -> Gaussians:
    count = header.count
    kept = min(SH_COEFFICIENTS[header.degree], SH_KEPT)
    tables = [part.reshape(count, width) for part, width in zip(parts, header.widths, strict=True)]
    return gaussians_in_blocks(
        count, kept + 1, lambda rows: _decoded(header, *(table[rows] for table in tables))
    ).drawable(path)


def _decoded(
    header: Header,
    positions: np.ndarray,
    opacities: np.ndarray,
    colors: np.ndarray,
    scales: np.ndarray,
    rotations: np.ndarray,
    coefficients: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """Decode rows of bytes: means, quaternions, log-scales, logits, SH."""
    stored = SH_COEFFICIENTS[header.degree]
    kept = min(stored, SH_KEPT)
    means = _positions(header, positions) * np.array([1, -1, -1], np.float32)
    unpack = _first_three if header.version < 3 else _smallest_three
    quats = unpack(rotations)
    quats[:, 2:] *= -1  # y and z
    sh = np.empty((len(means), kept + 1, 3), np.float32)
    sh[:, 0] = (colors / 255 - 0.5) / COLOR_SCALE
    rest = coefficients.reshape(len(means), stored, 3)[:, :kept].astype(np.float32) - 128
    sh[:, 1:] = rest / 128 * SH_SIGNS[:kept, None]
    return means, quats, scales / 16 - 10, logits_of(opacities[:, 0] / 255), sh


def _positions(header: Header, data: np.ndarray) -> np.ndarray:
    if header.version == 1:
        return np.ascontiguousarray(data).view("<f2").astype(np.float32)
    low, middle, high = data.reshape(-1, 3).astype(np.int32).T
    fixed = low | middle << 8 | high << 16
    fixed = np.where(high > 127, fixed - (1 << 24), fixed)
    return (fixed * 2.0**-header.fraction_bits).astype(np.float32).reshape(len(data), 3)


def _first_three(data: np.ndarray) -> np.ndarray:
    """Decode rotations of versions 1 and 2: x, y, z as bytes; w is not negative."""
    vector = data / 127.5 - 1
    w = np.sqrt(np.clip(1 - (vector**2).sum(1), 0, None))
    return np.column_stack([w, vector])


def _smallest_three(data: np.ndarray) -> np.ndarray:
    """Decode rotations from version 3 on.

    Two bits give the largest of x, y, z, w; the others have a sign and nine bits each.
    """
    words = np.ascontiguousarray(data).view("<u4")[:, 0]
    parts = words[:, None] >> np.array([20, 10, 0], np.uint32)
    size = (parts & 511) / 511 * SMALL_MAX
    small = np.where(parts & 512, -size, size)
    return quats_of_smallest_three(small, words >> 30)[:, [3, 0, 1, 2]]  # from x, y, z, w


def write_spz(path: Path | str, gaussians: Gaussians, *, footprint: Footprint = CLASSIC) -> None:
    """Write a scene for sorted blending as version 3; the file appears complete or not at all.

    Gaussians that cannot be drawn are left out (`Gaussians.drawable`). An antialiased footprint
    becomes the format's flag, and readers draw a blur of 0.3: another blur is named in a logged
    warning. Raises InputError if there are more than 10 million Gaussians, a coordinate reaches
    2^23, or none can be drawn.
    """
    if footprint.blur != BLUR:
        log.warning("a .spz has no place for the blur %g: readers draw 0.3", footprint.blur)
    gaussians = gaussians.detached().to("cpu", torch.float32).drawable(path)
    count, degree = len(gaussians), gaussians.sh_degree
    if count > COUNT_MAX:
        raise InputError(f"a .spz holds at most {COUNT_MAX:,} Gaussians, not {count:,}")
    fraction_bits = _fraction_bits(gaussians) if count else FRACTION_BITS
    flags = ANTIALIASED * footprint.antialiased
    header = Header(3, count, degree, fraction_bits, footprint.antialiased, False, 0, 0)
    start = MAGIC + struct.pack("<IIBBBB", 3, count, degree, fraction_bits, flags, 0)
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        with gzip.GzipFile("", "wb", GZIP_LEVEL, file, mtime=0) as zipped:
            zipped.write(start)
            for part in _encoded(header, gaussians):
                zipped.write(part.tobytes())


def _fraction_bits(gaussians: Gaussians) -> int:
    """Return the fractional bits of positions, which small Gaussians and small scenes need.

    More than the usual ones cost space. Raises InputError for a Gaussian that is too far away.
    """
    integer_bits = math.frexp(float(gaussians.means.abs().max()))[1]  # of the farthest position
    sizes = gaussians.log_scales.amax(1)
    small = float(sizes.kthvalue(max(1, round(SMALL_SHARE * len(sizes)))).values)
    needed = math.ceil((math.log(STEPS_PER_SIZE) - small) / math.log(2))
    wanted = max(FRACTION_BITS, POSITION_BITS_MIN - integer_bits, needed)
    bits = min(23 - integer_bits, wanted, FRACTION_BITS_MAX)
    if bits < 0:
        raise InputError("a Gaussian is too far away for a .spz: 2^23 is the limit")
    return bits


def _encoded(header: Header, gaussians: Gaussians) -> list[np.ndarray]:
    """Return the bytes of each attribute, in the order of the file."""
    means, quats, log_scales, logits, sh = (v.numpy() for v in gaussians.tensors().values())
    largest = (1 << 23) - 1
    fixed = np.rint(means * np.array([1, -1, -1]) * 2.0**header.fraction_bits).clip(
        -largest, largest
    )
    positions = fixed.astype("<i4").reshape(-1, 1).view(np.uint8)[:, :3]
    opacities = 255 / (1 + np.exp(-logits.astype(np.float64)))
    kept = sh.shape[1] - 1
    steps = np.repeat(SH_STEPS, (3, max(0, kept - 3)))[:kept, None]
    rest = np.rint((sh[:, 1:] * SH_SIGNS[:kept, None] * 128 + 128) / steps) * steps
    return [
        positions,
        _byte(opacities),
        _byte((sh[:, 0] * COLOR_SCALE + 0.5) * 255),
        _byte((log_scales + 10) * 16),
        _pack_smallest_three(quats),
        _byte(rest),
    ]


def _byte(values: np.ndarray) -> np.ndarray:
    return np.rint(values).clip(0, 255).astype(np.uint8)


def _pack_smallest_three(quats: np.ndarray) -> np.ndarray:
    """Encode rotations as words, which `_smallest_three` decodes."""
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
