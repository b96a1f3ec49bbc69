"""Small valid files of other tools' formats."""

import io
import json
import struct
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from mobilegs.formats.glb import write_glb
from mobilegs.formats.sog import write_sog
from mobilegs.gaussians import Gaussians
from tests.fuzz.seeds import Seed
from tests.support.format_files import encode_compressed_ply
from tests.support.random_scenes import random_scene


def compressed_seeds() -> dict[str, Seed]:
    """Return files of all degrees, both byte orders, 0 to 2 chunks, with and without bounds."""
    files = {f"degree {d}": encode_compressed_ply(random_scene(3, d)) for d in range(4)}
    files["two chunks"] = encode_compressed_ply(random_scene(260, 0))
    files["big"] = encode_compressed_ply(random_scene(2, 1), order=">")
    files["old"] = encode_compressed_ply(random_scene(4, 0), colors=False)
    files["none"] = encode_compressed_ply(random_scene(0, 1))
    return {name: Seed(data) for name, data in files.items()}


def splat_seeds() -> dict[str, Seed]:
    """Return files of one row, and of several."""
    rows = (np.arange(32 * 7) ** 2 * 7 % 251).astype(np.uint8).reshape(7, 32)
    rows[:, 3:24:4] &= 0x3F  # floats that are finite and positive
    return {"one": Seed(rows[:1].tobytes()), "seven": Seed(rows.tobytes())}


def _written(write: Callable[[Path, Gaussians], object], scene: Gaussians) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "seed"
        write(path, scene)
        return path.read_bytes()


def glb_seeds() -> dict[str, Seed]:
    """Return files of every degree, and one with moved nodes and a camera."""
    files = {f"degree {d}": _written(write_glb, random_scene(3, d)) for d in range(4)}
    files["nodes"] = _with_nodes(files["degree 0"])
    return {name: Seed(data) for name, data in files.items()}


def _with_nodes(data: bytes) -> bytes:
    """Return a `.glb` whose nodes are the children of a moved, turned and scaled one."""
    (length,) = struct.unpack_from("<I", data, 12)
    content = json.loads(data[20 : 20 + length])
    nodes = content["nodes"]
    roots = content["scenes"][0]["nodes"]
    moved = {"translation": [1, 2, 3], "rotation": [0, 0, 0.6, 0.8], "scale": [2, 2, 2]}
    camera = {"camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]}
    content["nodes"] = [*nodes, camera, {**moved, "children": [*roots, len(nodes)]}]
    content["scenes"][0]["nodes"] = [len(nodes) + 1]
    content["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    return glb(json.dumps(content).encode(), data[28 + length :])


def sog_seeds() -> dict[str, Seed]:
    """Return files of every degree, compressed and not, without Gaussians, and of version 1."""
    files = {f"degree {d}": _written(write_sog, random_scene(20, d)) for d in range(4)}
    files["none"] = _written(write_sog, random_scene(0, 0))
    files["packed"] = rezipped(unzipped(files["degree 1"]), zipfile.ZIP_DEFLATED)
    files["version 1"] = rezipped(_version_1(unzipped(files["degree 2"])))
    return {name: Seed(data) for name, data in files.items()}


def _version_1(files: dict[str, bytes]) -> dict[str, bytes]:
    meta = json.loads(files["meta.json"])
    low, high = {"mins": [-1.0] * 3}, {"maxs": [1.0] * 3}
    old = {
        "means": {"shape": [meta["count"], 3], **meta["means"]},
        "scales": {**low, **high, "files": meta["scales"]["files"]},
        "quats": meta["quats"],
        "sh0": {"mins": [-1.0] * 4, "maxs": [1.0] * 4, "files": meta["sh0"]["files"]},
        "shN": {"mins": -1.0, "maxs": 1.0, "files": meta["shN"]["files"]},
    }
    return files | {"meta.json": json.dumps(old).encode()}


def unzipped(data: bytes) -> dict[str, bytes]:
    """The files of an archive."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def rezipped(files: dict[str, bytes], way: int = zipfile.ZIP_STORED) -> bytes:
    """An archive of files."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", way) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content, way)
    return out.getvalue()


def webp(pixels: np.ndarray, *, lossless: bool = True) -> bytes:
    """A picture, quickly."""
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "WEBP", lossless=lossless, exact=True, quality=0, method=0)
    return out.getvalue()


def glb(text: bytes, body: bytes) -> bytes:
    """A `.glb` around JSON."""
    text += b" " * (-len(text) % 4)
    head = b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(body))
    return (
        head
        + struct.pack("<I", len(text))
        + b"JSON"
        + text
        + struct.pack("<I", len(body))
        + b"BIN\0"
        + body
    )
