"""Small valid files of every kind, mode, codec and option, the seeds of mutations."""

import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
import zstandard
from torch import Tensor

from mobilegs.compress.appearance import AppearanceDecoder
from mobilegs.compress.float16 import to_float16
from mobilegs.compress.lobes import LobeShape
from mobilegs.compress.uniform_quantizer import StepSizes
from mobilegs.mgs import rans
from mobilegs.mgs.bits import pack_bits
from mobilegs.mgs.codec import inspect, pack
from mobilegs.mgs.container import Stream
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.mgs.streams import decode_float16, decode_indices, index_width
from tests.support.mgs_parts import Parts, parse_parts
from tests.support.scene_cases import Case, make_scene

FLOATS = ("raw", "halves", "planes")
USUAL = {
    "appearance-decoder": "planes",
    "color-matrices": "raw",
    "view-network": "planes",
    "lobe-decoder": "raw",
    "codebooks": "raw",
}
DENSITY = 0.02  # share of weights that are not 0: makes files small and readers fast


@dataclass(frozen=True)
class Seed:
    """A valid file, and its relative frequency."""

    data: bytes
    weight: float = 1.0


def mgs_seeds() -> dict[str, Seed]:
    """Return files of every mode, blend, degree, codec, lobe decoder and number of LOD levels."""
    sq = StepSizes(0.15, 0.3, 0.1, 0.5, 1.0)
    linear = _made(Case(12, LobeShape(1, 2), size=5))
    plain = _made(Case(12, LobeShape(1, 2), size=5, colors="linear", alpha_min=0.02))
    hidden = _made(Case(9, LobeShape(2, 4, (3,)), size=40, skewed=True))
    scalars = _made(Case(14, LobeShape(1, 2, (4,)), steps=sq))
    coarse = StepSizes(3.0, 2.0, 2.0, 9.0, 1.0)
    codings: list[tuple[str, QuantizedScene, dict[str, str], float]] = [
        ("one", _made(Case(1)), {"codebooks": "raw"}, 1),
        ("linear", linear, {"codebooks": "halves"}, 2),
        ("hidden", hidden, {"lobe-decoder": "planes", "scale.0": "rans", "lobes.1": "rans"}, 2),
        (
            "three hidden",
            _made(Case(8, LobeShape(1, 2, (2, 3, 1)), opacity=False, size=3)),
            {"lobe-decoder": "halves", "codebooks": "planes", "rotation.1": "rans"},
            1,
        ),
        ("no latents", _made(Case(9, LobeShape(0, 0, (1,)), size=1)), {}, 1),
        ("nothing but a bias", _made(Case(7, LobeShape(0, 0), opacity=False)), {}, 1),
        ("rans", _made(Case(300, LobeShape(0, 2), size=6, skewed=True)), {"": "rans"}, 0.3),
        ("sorted", replace(_made(Case(20)), blend="sorted"), {}, 1),
        ("linear colours", plain, {"color-matrices": "halves"}, 3),
        (
            "linear colours of scalars",
            _made(Case(14, LobeShape(1, 2, (4,)), steps=sq, colors="linear")),
            {"color-matrices": "planes"},
            3,
        ),
        (
            "more latents of colours",
            _made(Case(11, steps=sq, colors="linear", color_latents=10)),
            {"color-matrices": "halves"},
            3,
        ),
        ("one place", _made(Case(30, LobeShape(3, 4), skewed=True, spread=0.0)), {}, 1),
        ("scalars", scalars, {"scale.1": "rans", "lobe-decoder": "raw"}, 3),
        (
            "scalars without opacity",
            _made(Case(5, LobeShape(1, 4), opacity=False, steps=coarse)),
            {"": "rans"},
            1,
        ),
        ("scalars, sorted", _made(Case(40, steps=StepSizes(0.01, 0.002, 0.01, 0.5))), {}, 1),
        ("two layers", _with_levels(_made(Case(20, LobeShape(1, 2), size=5)), 5, 15), {}, 2),
        ("layers of scalars", _with_levels(scalars, 1, 3, 10), {"scale.0@1": "rans"}, 3),
        ("one layer", _with_levels(linear, 12), {}, 1),
        *[(f"degree {d}", _of_degree(linear, d), {}, 1) for d in (0, 2, 3)],
        ("network", _made(Case(5, network=True)), {}, 0.05),
        ("halves", linear, {"appearance-decoder": "halves"}, 0.1),
        ("raw", linear, {"appearance-decoder": "raw"}, 0.1),
        ("tiny", tiny(), {}, 1),
        # two lanes; and the most Gaussians that a file of this size may have
        ("two lanes", _made(Case(4100, size=2)), {}, 0.003),
        ("crowd", crowd(), {"appearance-decoder": "raw"}, 0.003),
    ]
    return {
        name: Seed(recoded(pack(scene), {**USUAL, **codecs}), weight)
        for name, scene, codecs, weight in codings
    }


def tiny() -> QuantizedScene:
    """Return a scene of less than 1.5 kB."""
    scene = _made(Case(3, size=1))
    decoder = {name: torch.zeros_like(value) for name, value in scene.decoder.items()}
    books = {name: torch.zeros_like(book) for name, book in scene.codebooks.items()}
    return replace(scene, decoder=decoder, codebooks=books, views=[], meta={})


def crowd() -> QuantizedScene:
    """Return 16,384 equal Gaussians at one position: about one byte each, all of them weights."""
    scene = make_scene(Case(16_384, size=1, spread=0.0))
    return replace(scene, views=[], meta={})


def _with_levels(scene: QuantizedScene, *sizes: int) -> QuantizedScene:
    return replace(scene, lod_sizes=sizes).sorted()


def _made(case: Case) -> QuantizedScene:
    """Return a scene with sparse weights."""
    scene, g = make_scene(case), torch.Generator().manual_seed(0)
    network = None if scene.network is None else _thinned(scene.network, g)
    return replace(scene, decoder=_thinned(scene.decoder, g), network=network)


def _thinned(weights: dict[str, Tensor], g: torch.Generator) -> dict[str, Tensor]:
    return {n: w * (torch.rand(w.shape, generator=g) < DENSITY) for n, w in weights.items()}


def _of_degree(scene: QuantizedScene, degree: int) -> QuantizedScene:
    g = torch.Generator().manual_seed(degree)
    weights = AppearanceDecoder(g, degree).named_parameters()
    return replace(scene, decoder=_thinned({n: to_float16(w.detach()) for n, w in weights}, g))


def recoded(data: bytes, codecs: dict[str, str]) -> bytes:
    """Return the file with other codecs, by name of the stream; "" stands for all indices."""
    parts = parse_parts(data)
    raw = {row["name"]: row["raw_bytes"] for row in inspect(data)["streams"]}
    coded = indices(parts)
    for piece in parts.pieces:
        stream = Stream(piece.name, piece.codec, piece.data)
        if piece.codec in FLOATS:
            piece.codec = codecs.get(piece.name, piece.codec)
            piece.data = _encoded(decode_float16(stream, raw[piece.name] // 2), piece.codec)
        elif piece.name in coded:
            count, size = coded[piece.name]
            symbols = decode_indices(stream, count, size)
            piece.codec = codecs.get(piece.name, codecs.get("", piece.codec))
            piece.data = (
                rans.encode(symbols, size)
                if piece.codec == "rans"
                else pack_bits(symbols.astype(np.uint64), np.full(count, index_width(size)))
            )
    return parts.to_bytes()


def indices(parts: Parts) -> dict[str, tuple[int, int]]:
    """Return the count and bound of each stream of indices."""
    header = parts.header
    if header["mode"] == "sq":
        columns = {name: scalar["size"] for name, scalar in header["scalars"].items()}
    else:
        columns = {n: [book["size"]] * book["count"] for n, book in header["codebooks"].items()}
    levels = list(enumerate(header.get("layers", [header["count"]])))
    return {
        f"{name}.{i}" + (f"@{number}" if number else ""): (count, size)
        for number, count in levels
        for name, sizes in columns.items()
        for i, size in enumerate(sizes)
    }


def _encoded(patterns: np.ndarray, codec: str) -> bytes:
    if codec == "raw":
        return patterns.astype("<u2").tobytes()
    upper = rans.encode(patterns >> 8, 256)
    lower = (patterns & 255).astype(np.uint8).tobytes()
    rest = lower if codec == "halves" else rans.encode(patterns & 255, 256)
    return struct.pack("<I", len(upper)) + upper + rest


# --- .ply

ROW = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()
TYPES = {"float": "f4", "double": "f8", "uchar": "u1", "short": "i2"}
FORMATS = {"binary_little_endian": "<", "binary_big_endian": ">"}


def ply(
    format_: str,
    names: Sequence[str],
    *,
    count: int = 3,
    types: tuple[str, ...] = ("float",),
    before: str = "",
    body_before: bytes = b"",
) -> bytes:
    """Return a PLY file of computed numbers; columns cycle through `types`."""
    kinds = [types[i % len(types)] for i in range(len(names))]
    properties = "".join(f"property {k} {n}\n" for k, n in zip(kinds, names, strict=True))
    text = f"ply\nformat {format_} 1.0\n{before}element vertex {count}\n{properties}end_header\n"
    table = np.sin(np.arange(count * len(names), dtype=np.float64)).reshape(count, len(names)) * 3
    if format_ == "ascii":
        body = "\n".join(" ".join(f"{x:.6g}" for x in row) for row in table).encode() + b"\n"
    else:
        row = np.dtype(
            [(n, FORMATS[format_] + TYPES[k]) for n, k in zip(names, kinds, strict=True)]
        )
        rows = np.zeros(count, row)
        for i, name in enumerate(names):
            rows[name] = np.abs(table[:, i]) if TYPES[kinds[i]][0] == "u" else table[:, i]
        body = rows.tobytes()
    return text.encode() + body_before + body


def ply_seeds() -> dict[str, Seed]:
    """Return files of all formats and degrees, mixed types, elements and comments first."""
    rest = {d: [f"f_rest_{i}" for i in range(3 * (d + 1) ** 2 - 3)] for d in range(4)}
    little = "binary_little_endian"
    files = {f"degree {d}": ply(little, ROW + rest[d]) for d in range(4)}
    files["big"] = ply("binary_big_endian", ROW)
    files["text"] = ply("ascii", ROW + rest[1])
    files["doubles"] = ply(little, list(reversed(ROW)), types=("double",))
    files["mixed"] = ply(little, [*ROW, "label"], types=("float", "uchar", "double", "short"))
    camera = "comment by hand\nobj_info none\nelement camera 2\nproperty double t\n"
    files["camera before"] = ply(little, ROW, before=camera, body_before=bytes(16))
    files["text, camera before"] = ply("ascii", ROW, before=camera, body_before=b"1\n2\n")
    files["none"] = ply(little, ROW, count=0)
    files["text of none"] = ply("ascii", ROW, count=0)
    return {name: Seed(data) for name, data in files.items()}


# --- .spz

COEFFICIENTS = (0, 3, 8, 15, 24)


def spz_head(version: int, count: int, degree: int, *, flags: int = 0, streams: int = 0) -> bytes:
    """Return the first 16 bytes."""
    return b"NGSP" + struct.pack("<IIBBBB", version, count, degree, 12, flags, streams)


def attributes(version: int, count: int, degree: int) -> list[bytes]:
    """Return computed bytes of each attribute."""
    turns = 3 if version < 3 else 4
    widths = (6 if version == 1 else 9, 1, 3, 3, turns, 3 * COEFFICIENTS[degree])
    found = [(np.arange(count * w) ** 2 * 7 % 251).astype(np.uint8) for w in widths]
    if version == 1:  # finite float16 numbers
        found[0][1::2] &= 0x3F
    return [part.tobytes() for part in found]


def zipped(data: bytes) -> bytes:
    """Compress with gzip at its fastest level."""
    zipper = zlib.compressobj(1, wbits=31)
    return zipper.compress(data) + zipper.flush()


def spz_4(head: bytes, streams: list[bytes], sizes: list[int], *, table: int = 32) -> bytes:
    """Return a file of version 4 with compressed streams of `sizes` bytes before compression."""
    rows = b"".join(struct.pack("<QQ", len(s), n) for s, n in zip(streams, sizes, strict=True))
    return head + struct.pack("<I", table) + bytes(table - 20) + rows + b"".join(streams)


def spz_seeds() -> dict[str, Seed]:
    """Return files of all versions and degrees; of version 4 with all kinds of blocks."""
    files: dict[str, Seed] = {}
    for version in (1, 2, 3):
        for degree in range(5):
            content = spz_head(version, 5, degree) + b"".join(attributes(version, 5, degree))
            files[f"version {version}, degree {degree}"] = Seed(zipped(content))
    files["nothing"] = Seed(zipped(spz_head(3, 0, 0)))
    extended = spz_head(2, 4, 0, flags=2) + b"".join(attributes(2, 4, 0)) + b"something more"
    files["extended"] = Seed(zipped(extended))
    ways: dict[str, Callable[[bytes], bytes]] = {
        "quick": zstandard.ZstdCompressor(1).compress,
        "with checksums": zstandard.ZstdCompressor(9, write_checksum=True).compress,
        "of unknown size": zstandard.ZstdCompressor(3, write_content_size=False).compress,
    }
    for name, compress in ways.items():
        for count, degree in ((6, 0), (40, 3), (30, 4)):
            parts = [part for part in attributes(4, count, degree) if part]
            head = spz_head(4, count, degree, streams=len(parts))
            data = spz_4(head, [compress(part) for part in parts], [len(part) for part in parts])
            files[f"version 4, degree {degree}, {name}"] = Seed(data)
    files["version 4, nothing"] = Seed(spz_4(spz_head(4, 0, 0), [], []))
    return files
