"""Reads and writes `.glb` with `KHR_gaussian_splatting`: 3DGS scenes as glTF points, in floats.

Scales and opacities are linear, rotations are xyzw, and each SH coefficient is an attribute. Axes
are LUF in glTF (y up, front towards +z) and RDF here: half a turn around z. Source: the extension
as ratified by Khronos in 2026,
https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_gaussian_splatting.
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
EXTENSION = "KHR_gaussian_splatting"
COLOR_SPACE = "srgb_rec709_display"  # of 3DGS
JSON_MAX = 1 << 19  # bytes; parsed JSON needs many times as much memory
POINTS, FLOAT, BYTE, VERTICES = 0, 5126, 5121, 34962  # OpenGL constants
TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
COMPONENTS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
SHAPES = {
    "POSITION": "VEC3",
    f"{EXTENSION}:ROTATION": "VEC4",
    f"{EXTENSION}:SCALE": "VEC3",
    f"{EXTENSION}:OPACITY": "SCALAR",
}
SH_ATTRIBUTES = [f"{EXTENSION}:SH_DEGREE_{d}_COEF_{m}" for d in range(4) for m in range(2 * d + 1)]
AXIS_SIGNS = np.array([-1, -1, 1], np.float32)  # RDF <-> LUF
SH_SIGNS = np.array([(-1) ** k for k in range(16)], np.float32)  # of SH under that turn
SCALE_MIN = 1e-30  # a scale of 0 has no logarithm
OPACITY_MIN, OPACITY_MAX = 1e-12, 1 - 2.0**-24  # opacities 0 and 1 have no logit
LOG_SCALE_MAX = 80.0  # of written scales, so that they stay finite


def write_glb(path: Path | str, gaussians: Gaussians, *, note: str = "") -> None:
    """Write a scene for sorted blending to a `.glb`; the file appears complete or not at all.

    `COLOR_0` holds the view-independent colours, in linear RGB as glTF requires, for viewers that
    show points but not splats. `note` goes into the asset's extras. Gaussians that are not finite
    are left out, and counted in a logged warning.

    Raises:
        InputError: no Gaussian is left, which glTF does not allow, or the file would be too large.
    """
    gaussians = gaussians.detached().to("cpu", torch.float32).finite(path)
    if not len(gaussians):
        raise InputError(f"cannot write {path}: glTF does not allow a scene without Gaussians")
    arrays = _attributes(gaussians)
    views, accessors, offset = [], [], 0
    for array in arrays.values():
        view = {
            "buffer": 0,
            "byteOffset": offset,
            "byteLength": array.nbytes,
            "target": VERTICES,
        }
        accessor: dict[str, Any] = {
            "bufferView": len(views),
            "componentType": FLOAT if array.dtype == np.float32 else BYTE,
            "count": len(array),
            "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[array.shape[1]],
        }
        if array.dtype == np.uint8:
            accessor["normalized"] = True
        views.append(view)
        accessors.append(accessor)
        offset += array.nbytes
    means = arrays["POSITION"]
    accessors[0] |= {"min": means.min(0).tolist(), "max": means.max(0).tolist()}
    primitive = {
        "attributes": {name: i for i, name in enumerate(arrays)},
        "mode": POINTS,
        "extensions": {EXTENSION: {"kernel": "ellipse", "colorSpace": COLOR_SPACE}},
    }
    content = {
        "asset": {
            "version": "2.0",
            "generator": f"mobilegs {__version__}",
            "extras": {"blend": "sorted"} | ({"note": note} if note else {}),
        },
        "extensionsUsed": [EXTENSION],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "buffers": [{"byteLength": offset}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    size = 28 + len(text) + offset
    if size >= 1 << 32:
        raise InputError(f"cannot write {path}: {size} bytes, and a .glb has at most 4 GiB")
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(MAGIC + struct.pack("<II", VERSION, size))
        file.write(struct.pack("<I", len(text)) + JSON + text)
        file.write(struct.pack("<I", offset) + BIN)
        for array in arrays.values():
            file.write(array.tobytes())


def _attributes(gaussians: Gaussians) -> dict[str, np.ndarray]:
    """Return the attributes by name, `[n, 1 | 3 | 4]`, float32 or uint8.

    Each array has a multiple of four bytes, as glTF requires.
    """
    w, x, y, z = gaussians.quats.T
    length = gaussians.quats.norm(dim=1, keepdim=True).clamp_min(1e-30)
    rotated = torch.stack([-y, x, w, -z], dim=1) / length  # xyzw, then half a turn around z
    rgb = (0.5 + C0 * gaussians.sh[:, 0]).clamp(0, 1).double()
    linear = torch.where(
        rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4
    )  # sRGB transfer
    opacities = gaussians.logit_opacities.double().sigmoid()[:, None]
    arrays = {
        "POSITION": gaussians.means.numpy() * AXIS_SIGNS,
        "COLOR_0": (torch.cat([linear, opacities], 1) * 255).round().to(torch.uint8).numpy(),
        f"{EXTENSION}:ROTATION": rotated.numpy(),
        f"{EXTENSION}:SCALE": gaussians.log_scales.clamp(max=LOG_SCALE_MAX).exp().numpy(),
        f"{EXTENSION}:OPACITY": opacities.float().numpy(),
    }
    for k in range(gaussians.sh.shape[1]):
        arrays[SH_ATTRIBUTES[k]] = gaussians.sh[:, k].numpy() * SH_SIGNS[k]
    return {name: np.ascontiguousarray(array) for name, array in arrays.items()}


def read_glb(path: Path | str) -> Gaussians:
    """Read the splats of a `.glb` as float32 on the CPU.

    Gaussians that are not finite are left out, and counted in a logged warning.

    Raises:
        InputError: the file is missing, not a `.glb`, damaged or cut off, has not exactly one set
            of splats, or uses compression or node transforms.
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
        names = [*SHAPES, *SH_ATTRIBUTES[: (degree + 1) ** 2]]
        arrays = [
            _accessor(content, body, attributes[name], SHAPES.get(name, "VEC3")) for name in names
        ]
    except InputError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError):
        raise InputError(
            f"{path} is damaged: its JSON is not consistent, or does not fit the file"
        ) from None
    if len({len(array) for array in arrays}) != 1:
        raise InputError(f"{path} is damaged: its attributes have different lengths")
    return _gaussians(arrays, path)


def _chunks(data: bytes, path: Path) -> tuple[dict[str, Any], memoryview]:
    """Return the JSON and the binary part."""
    if len(data) < 20 or data[:4] != MAGIC or data[16:20] != JSON:
        raise InputError(f"{path} is not a .glb file")
    version, size, length = struct.unpack_from("<III", data, 4)
    if version != VERSION:
        raise InputError(f"{path} has glTF version {version}, and only version 2 is supported")
    if size > len(data) or 20 + length > size:
        raise InputError(f"{path} is cut off: copy it again")
    if length > JSON_MAX:
        raise InputError(f"{path} has {length} bytes of JSON, more than {JSON_MAX}")
    try:
        content = json.loads(data[20 : 20 + length])
    except (ValueError, RecursionError):
        raise InputError(f"{path} is damaged: its JSON cannot be read") from None
    if not isinstance(content, dict):
        raise InputError(f"{path} is damaged: its JSON is not an object")
    begin = 20 + length + 8
    if begin > size or data[begin - 4 : begin] != BIN:
        raise InputError(f"{path} has no binary part, which holds the scene")
    (length,) = struct.unpack_from("<I", data, begin - 8)
    if begin + length > size:
        raise InputError(f"{path} is cut off: copy it again")
    return content, memoryview(data)[begin : begin + length]


def _splats(content: dict[str, Any], path: Path) -> dict[str, Any]:
    """Return the only primitive with splats."""
    meshes = content.get("meshes", [])
    found = [
        primitive
        for mesh in meshes
        for primitive in mesh["primitives"]
        if EXTENSION in primitive.get("extensions", {})
    ]
    if len(found) != 1:
        raise InputError(f"{path} has {len(found)} sets of splats, not one")
    about = found[0]["extensions"][EXTENSION]
    if about.get("extensions"):
        raise InputError(
            f"{path} has compressed splats, which are not supported: decompress it first"
        )
    if about.get("kernel", "ellipse") != "ellipse":
        raise InputError(f"{path} has splats that are not Gaussians, which are not supported")
    if about.get("colorSpace", COLOR_SPACE) != COLOR_SPACE:
        log.warning("%s does not have sRGB colours; they are drawn as sRGB", path)
    for node in content.get("nodes", []):
        if any(key in node for key in ("matrix", "rotation", "translation", "scale")):
            raise InputError(
                f"{path} transforms splats in its nodes: apply the transform to the splats first"
            )
    return found[0]


def _degree(attributes: dict[str, Any], path: Path) -> int:
    """Return the SH degree, once all required attributes are known to exist."""
    missing = [name for name in [*SHAPES, SH_ATTRIBUTES[0]] if name not in attributes]
    if missing:
        raise InputError(f"{path} has splats without {missing[0]}")
    count = sum(name in attributes for name in SH_ATTRIBUTES)
    degree = round(count**0.5) - 1
    if SH_ATTRIBUTES[: (degree + 1) ** 2] != [name for name in SH_ATTRIBUTES if name in attributes]:
        raise InputError(f"{path} has {count} SH coefficients, not the first 1, 4, 9 or 16")
    return degree


def _accessor(content: dict[str, Any], body: memoryview, index: int, shape: str) -> np.ndarray:
    """Return an accessor as `[n, 1 | 3 | 4]`, a view of the file, or floats if it is normalised.

    Raises ValueError, KeyError or TypeError if it does not fit the file.
    """
    accessor = content["accessors"][_natural(index)]
    kind = np.dtype(TYPES[accessor["componentType"]])
    count, width = _natural(accessor["count"]), COMPONENTS[shape]
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
    positions, rotations, scales, opacities, *sh_arrays = arrays
    count = len(positions)
    quats = np.empty((count, 4), np.float32)
    with np.errstate(all="ignore"):  # `finite` drops such rows
        means = positions * AXIS_SIGNS
        quats[:, 0], quats[:, 1], quats[:, 2], quats[:, 3] = (
            rotations[:, 2],
            rotations[:, 1],
            -rotations[:, 0],
            -rotations[:, 3],
        )
        log_scales = np.log(np.maximum(scales, SCALE_MIN), dtype=np.float32)
        opacity = np.clip(opacities[:, 0].astype(np.float64), OPACITY_MIN, OPACITY_MAX)
        logits = (np.log(opacity) - np.log1p(-opacity)).astype(np.float32)
        sh = np.empty((count, len(sh_arrays), 3), np.float32)
        for k, values in enumerate(sh_arrays):
            sh[:, k] = values * SH_SIGNS[k]
    parts = [means.astype(np.float32, copy=False), quats, log_scales, logits, sh]
    return Gaussians(*(torch.from_numpy(part) for part in parts)).finite(path)
