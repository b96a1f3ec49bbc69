"""glTF's `KHR_gaussian_splatting` in a `.glb`: 3DGS scenes as points with attributes, in floats.

Scales and opacities are linear here, rotations are xyzw, the harmonics are those of 3DGS, an
attribute each. Axes are glTF's LUF (y up, the front towards +z), ours RDF: half a turn around z.
The facts are those of the extension as Khronos ratified it in 2026,
github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_gaussian_splatting.
"""

import json
import logging
import struct
from pathlib import Path
from typing import Any

import numpy as np
import torch

from mobilegs import __version__
from mobilegs.atomic import atomic_path, read_if
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import C0

log = logging.getLogger(__name__)

MAGIC, VERSION, JSON, BIN = b"glTF", 2, b"JSON", b"BIN\0"
NAME = "KHR_gaussian_splatting"
SPACE = "srgb_rec709_display"  # what 3DGS trains in
TEXT_MAX = 1 << 19  # bytes of JSON, which takes many times as much when it is parsed
POINTS, FLOAT, BYTE, VERTICES = 0, 5126, 5121, 34962  # of OpenGL
KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
SHAPES = {
    "POSITION": "VEC3",
    f"{NAME}:ROTATION": "VEC4",
    f"{NAME}:SCALE": "VEC3",
    f"{NAME}:OPACITY": "SCALAR",
}
HARMONICS = [f"{NAME}:SH_DEGREE_{d}_COEF_{m}" for d in range(4) for m in range(2 * d + 1)]
TURN = np.array([-1, -1, 1], np.float32)  # of places; a harmonic is even or odd in x and y together
SIGNS = np.array([(-1) ** k for k in range(16)], np.float32)
FLAT = 1e-30  # for scales of 0, which have no logarithm
CLEAR, SOLID = 1e-12, 1 - 2.0**-24  # what opacities are clipped to, which have no logit at 0 and 1
STEEP = 80.0  # the largest logarithm of a scale that is written


def write_glb(path: Path | str, gaussians: Gaussians, *, note: str = "") -> None:
    """Write a scene for sorted blending, whole or not at all; what is not finite is left out.

    `COLOR_0` holds the colours without harmonics, linear as glTF wants them, for viewers that know
    points but no splats; `note` goes into the asset's extras. Raises InputError for a scene without
    Gaussians, which glTF cannot hold.
    """
    gaussians = gaussians.detached().to("cpu", torch.float32).finite(path)
    if not len(gaussians):
        raise InputError(f"cannot write {path}: glTF has no place for a scene without Gaussians")
    arrays = _attributes(gaussians)
    views, accessors, at = [], [], 0
    for array in arrays.values():
        part = {"buffer": 0, "byteOffset": at, "byteLength": array.nbytes, "target": VERTICES}
        accessor: dict[str, Any] = {
            "bufferView": len(views),
            "componentType": FLOAT if array.dtype == np.float32 else BYTE,
            "count": len(array),
            "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[array.shape[1]],
        }
        if array.dtype == np.uint8:
            accessor["normalized"] = True
        views.append(part)
        accessors.append(accessor)
        at += array.nbytes
    means = arrays["POSITION"]
    accessors[0] |= {"min": means.min(0).tolist(), "max": means.max(0).tolist()}
    primitive = {
        "attributes": {name: i for i, name in enumerate(arrays)},
        "mode": POINTS,
        "extensions": {NAME: {"kernel": "ellipse", "colorSpace": SPACE}},
    }
    content = {
        "asset": {
            "version": "2.0",
            "generator": f"mobilegs {__version__}",
            "extras": {"blend": "sorted"} | ({"note": note} if note else {}),
        },
        "extensionsUsed": [NAME],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "buffers": [{"byteLength": at}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    whole = 28 + len(text) + at
    if whole >= 1 << 32:
        raise InputError(f"cannot write {path}: {whole} bytes are more than a .glb can have")
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(MAGIC + struct.pack("<II", VERSION, whole))
        file.write(struct.pack("<I", len(text)) + JSON + text)
        file.write(struct.pack("<I", at) + BIN)
        for array in arrays.values():
            file.write(array.tobytes())


def _attributes(gaussians: Gaussians) -> dict[str, np.ndarray]:
    """By name, `[n, 1 | 3 | 4]`, float32 or bytes; each takes a multiple of four bytes."""
    w, x, y, z = gaussians.quats.T
    length = gaussians.quats.norm(dim=1, keepdim=True).clamp_min(1e-30)
    turned = torch.stack([-y, x, w, -z], dim=1) / length  # xyzw of half a turn after the rotation
    rgb = (0.5 + C0 * gaussians.sh[:, 0]).clamp(0, 1).double()
    linear = torch.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)  # sRGB's
    opacities = gaussians.logit_opacities.double().sigmoid()[:, None]
    arrays = {
        "POSITION": gaussians.means.numpy() * TURN,
        "COLOR_0": (torch.cat([linear, opacities], 1) * 255).round().to(torch.uint8).numpy(),
        f"{NAME}:ROTATION": turned.numpy(),
        f"{NAME}:SCALE": gaussians.log_scales.clamp(max=STEEP).exp().numpy(),
        f"{NAME}:OPACITY": opacities.float().numpy(),
    }
    for k in range(gaussians.sh.shape[1]):
        arrays[HARMONICS[k]] = gaussians.sh[:, k].numpy() * SIGNS[k]
    return {name: np.ascontiguousarray(array) for name, array in arrays.items()}


def read_glb(path: Path | str) -> Gaussians:
    """Read the splats of a `.glb` as float32 on the CPU; what is not finite is left out.

    Raises:
        InputError: the file is missing, is no `.glb`, is damaged or cut off, holds no splats or
            several sets of them, compresses them, or turns, moves or scales them in its nodes.
    """
    path = Path(path)
    try:
        data = read_if(path, (MAGIC,))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None
    content, body = _chunks(data, path)
    try:
        primitive = _splats(content, path)
        attributes = primitive["attributes"]
        degree = _degree(attributes, path)
        names = [*SHAPES, *HARMONICS[: (degree + 1) ** 2]]
        arrays = [
            _accessor(content, body, attributes[name], SHAPES.get(name, "VEC3")) for name in names
        ]
    except InputError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError):
        raise InputError(
            f"{path} is damaged: what its JSON says does not fit together or into the file"
        ) from None
    if len({len(array) for array in arrays}) != 1:
        raise InputError(f"{path} is damaged: its attributes have different lengths")
    return _gaussians(arrays, path)


def _chunks(data: bytes, path: Path) -> tuple[dict[str, Any], memoryview]:
    """The JSON and the binary part."""
    if len(data) < 20 or data[:4] != MAGIC or data[16:20] != JSON:
        raise InputError(f"{path} is not a .glb file")
    version, whole, length = struct.unpack_from("<III", data, 4)
    if version != VERSION:
        raise InputError(f"{path} has version {version} of glTF: 2 can be read")
    if whole > len(data) or 20 + length > whole:
        raise InputError(f"{path} is cut off: get it again from where it came")
    if length > TEXT_MAX:
        raise InputError(f"{path} has {length} bytes of JSON: {TEXT_MAX} can be read")
    try:
        content = json.loads(data[20 : 20 + length])
    except (ValueError, RecursionError):
        raise InputError(f"{path} is damaged: its JSON cannot be read") from None
    if not isinstance(content, dict):
        raise InputError(f"{path} is damaged: its JSON is no object")
    begin = 20 + length + 8
    if begin > whole or data[begin - 4 : begin] != BIN:
        raise InputError(f"{path} has no binary part, where a scene would be")
    (length,) = struct.unpack_from("<I", data, begin - 8)
    if begin + length > whole:
        raise InputError(f"{path} is cut off: get it again from where it came")
    return content, memoryview(data)[begin : begin + length]


def _splats(content: dict[str, Any], path: Path) -> dict[str, Any]:
    """The one primitive that holds splats."""
    meshes = content.get("meshes", [])
    found = [
        primitive
        for mesh in meshes
        for primitive in mesh["primitives"]
        if NAME in primitive.get("extensions", {})
    ]
    if len(found) != 1:
        raise InputError(f"{path} has {len(found)} sets of splats: one is needed")
    about = found[0]["extensions"][NAME]
    if about.get("extensions"):
        raise InputError(f"{path} holds compressed splats, which are not read: decompress it first")
    if about.get("kernel", "ellipse") != "ellipse":
        raise InputError(f"{path} has splats that are no Gaussians: they cannot be drawn")
    if about.get("colorSpace", SPACE) != SPACE:
        log.warning("%s has linear or other colours, which are drawn as sRGB", path)
    for node in content.get("nodes", []):
        if any(key in node for key in ("matrix", "rotation", "translation", "scale")):
            raise InputError(f"{path} moves things in its nodes: apply that to the splats first")
    return found[0]


def _degree(attributes: dict[str, Any], path: Path) -> int:
    lost = [name for name in [*SHAPES, HARMONICS[0]] if name not in attributes]
    if lost:
        raise InputError(f"{path} has splats without {lost[0]}")
    count = sum(name in attributes for name in HARMONICS)
    degree = round(count**0.5) - 1
    if HARMONICS[: (degree + 1) ** 2] != [name for name in HARMONICS if name in attributes]:
        raise InputError(f"{path} has {count} harmonics: 1, 4, 9 or 16 belong to a scene")
    return degree


def _accessor(content: dict[str, Any], body: memoryview, index: int, shape: str) -> np.ndarray:
    """Numbers `[n, 1 | 3 | 4]` as they lie in the file, or floats if they are normalised there."""
    accessor = content["accessors"][_natural(index)]
    kind = np.dtype(KINDS[accessor["componentType"]])
    count, width = _natural(accessor["count"]), WIDTHS[shape]
    if accessor["type"] != shape or "sparse" in accessor or "extensions" in accessor:
        raise ValueError
    view = content["bufferViews"][_natural(accessor["bufferView"])]
    begin, length = _natural(view.get("byteOffset", 0)), _natural(view["byteLength"])
    offset = _natural(accessor.get("byteOffset", 0))
    stride = _natural(view.get("byteStride", width * kind.itemsize))
    if view["buffer"] != 0 or "extensions" in view or "uri" in content["buffers"][0]:
        raise ValueError
    if stride < width * kind.itemsize or begin + length > len(body):
        raise ValueError
    if count and offset + stride * (count - 1) + width * kind.itemsize > length:
        raise ValueError
    found = np.ndarray((count, width), kind, body, begin + offset, (stride, kind.itemsize))
    if kind.kind == "f" or accessor.get("normalized") is not True:
        return found
    return np.maximum(found / np.float32(np.iinfo(kind).max), -1)


def _natural(value: Any) -> int:
    if type(value) is not int or not 0 <= value < 1 << 40:
        raise ValueError
    return value


def _gaussians(arrays: list[np.ndarray], path: Path) -> Gaussians:
    places, turns, scales, opacities, *harmonics = arrays
    count = len(places)
    quats = np.empty((count, 4), np.float32)
    with np.errstate(all="ignore"):  # what is not finite is left out in the end
        means = places * TURN
        quats[:, 0], quats[:, 1], quats[:, 2], quats[:, 3] = (
            turns[:, 2],
            turns[:, 1],
            -turns[:, 0],
            -turns[:, 3],
        )
        log_scales = np.log(np.maximum(scales, FLAT), dtype=np.float32)
        opaque = np.clip(opacities[:, 0].astype(np.float64), CLEAR, SOLID)
        logits = (np.log(opaque) - np.log1p(-opaque)).astype(np.float32)
        sh = np.empty((count, len(harmonics), 3), np.float32)
        for k, values in enumerate(harmonics):
            sh[:, k] = values * SIGNS[k]
    parts = [means.astype(np.float32, copy=False), quats, log_scales, logits, sh]
    return Gaussians(*(torch.from_numpy(part) for part in parts)).finite(path)
