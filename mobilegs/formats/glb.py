"""Reads and writes `.glb` with `KHR_gaussian_splatting`: 3DGS scenes as glTF points, in floats.

Scales and opacities are linear, rotations are xyzw, and each SH coefficient is an attribute. Axes
are LUF in glTF (y up, front towards +z) and RDF here: half a turn around z. Nodes place sets of
splats in the scene, by a matrix or by translation, rotation and scale, below other nodes. Source:
the extension as ratified by Khronos in 2026,
https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_gaussian_splatting.
"""

import json
import logging
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float

from mobilegs import __version__
from mobilegs.atomic import atomic_path, read_input
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render.project import rotation_matrices
from mobilegs.render.transform import is_even, transformed
from mobilegs.spherical_harmonics import C0

log = logging.getLogger(__name__)

MAGIC, VERSION, JSON, BIN = b"glTF", 2, b"JSON", b"BIN\0"
EXTENSION = "KHR_gaussian_splatting"
COLOR_SPACE = "srgb_rec709_display"  # of 3DGS
JSON_MAX = 1 << 19  # bytes; parsed JSON needs many times as much memory
COUNT_MAX = 10_000_000  # Gaussians in all nodes
GAUSSIANS_PER_BYTE = 1  # far above real scenes: nodes may hold one set many times
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
NAMED_MAX = 5  # nodes in a message
OPACITY_MIN, OPACITY_MAX = 1e-12, 1 - 2.0**-24  # of written ones, of read ones: 1 has no logit

Matrix = Float[np.ndarray, "4 4"]


def write_glb(path: Path | str, gaussians: Gaussians, *, note: str = "") -> None:
    """Write a scene for sorted blending to a `.glb`; the file appears complete or not at all.

    `COLOR_0` holds the view-independent colours, in linear RGB as glTF requires, for viewers that
    show points but not splats. `note` goes into the asset's extras. Gaussians that cannot be drawn
    are left out (`Gaussians.drawable`). Raises InputError if no Gaussian is left, which glTF does
    not allow, or the file would be too large.
    """
    gaussians = gaussians.detached().to("cpu", torch.float32).drawable(path)
    if not len(gaussians):
        raise InputError("glTF does not allow a scene without Gaussians: write a .ply")
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
        raise InputError(f"a .glb has at most 4 GiB, and this scene needs {size:,} bytes")
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
        f"{EXTENSION}:SCALE": gaussians.log_scales.exp().numpy(),
        f"{EXTENSION}:OPACITY": opacities.clamp_min(OPACITY_MIN).float().numpy(),
    }
    for k in range(gaussians.sh.shape[1]):
        arrays[SH_ATTRIBUTES[k]] = gaussians.sh[:, k].numpy() * SH_SIGNS[k]
    return {name: np.ascontiguousarray(array) for name, array in arrays.items()}


def read_glb(path: Path | str) -> Gaussians:
    """Read the splats of a `.glb` as float32 on the CPU.

    The sets of splats in all nodes of the file's scene become one, each transformed by its nodes.
    Gaussians that cannot be drawn are left out (`Gaussians.drawable`). A node that stretches splats
    unevenly, and sets that are in no node, are named in logged warnings. Raises InputError if the
    file is missing, not a `.glb`, damaged or cut off, has no splats, uses compression, or none can
    be drawn.
    """
    path = Path(path)
    data = read_input(path, starts=(MAGIC,))
    content, body = _chunks(data, path)
    sets, count = [], 0
    try:
        for primitive, matrix in _placed_splats(content, path):
            arrays = _arrays(content, body, primitive["attributes"], path)
            count += len(arrays[0])
            if count > min(COUNT_MAX, GAUSSIANS_PER_BYTE * len(data)):
                raise InputError(f"{path} repeats its splats in too many nodes")
            sets.append(_gaussians(arrays, matrix))
    except InputError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError):
        raise InputError(
            f"{path} is damaged: its JSON is not consistent, or does not fit the file"
        ) from None
    return _merged(sets).drawable(path, count)


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


def _placed_splats(content: dict[str, Any], path: Path) -> list[tuple[dict[str, Any], Matrix]]:
    """Return the primitives with splats and the matrix of each, glTF's axes, `[4, 4]`.

    A mesh in several nodes is repeated. In a file without nodes every mesh counts.
    """
    meshes = [_splats(mesh["primitives"], path) for mesh in content.get("meshes", [])]
    if not any(meshes):
        raise InputError(f"{path} has no splats")
    placed, used, uneven = [], set(), []
    nodes = content.get("nodes") or [{"mesh": number} for number in range(len(meshes))]
    for number, matrix in _matrices(nodes, content, path).items():
        node = nodes[number]
        if "mesh" not in node or not (mesh := meshes[_natural(node["mesh"])]):
            continue
        used.add(node["mesh"])
        placed += [(primitive, matrix) for primitive in mesh]
        if not is_even(matrix[:3, :3]) and any(SH_ATTRIBUTES[1] in p["attributes"] for p in mesh):
            uneven.append(number)
    if uneven:
        log.warning(
            "%s: nodes that stretch splats unevenly, which shapes follow exactly, but "
            "view-dependent colours only turn: %s",
            path,
            ", ".join(map(str, uneven[:NAMED_MAX])) + (", ..." if uneven[NAMED_MAX:] else ""),
        )
    if any(
        _about(primitive).get("colorSpace", COLOR_SPACE) != COLOR_SPACE for primitive, _ in placed
    ):
        log.warning("%s does not have sRGB colours; they are drawn as sRGB", path)
    unused = sum(len(mesh) for number, mesh in enumerate(meshes) if number not in used)
    if not placed:
        raise InputError(f"{path} has splats, but no node of its scene holds them")
    if unused:
        log.warning("%s: left out sets of splats that no node of the scene holds: %d", path, unused)
    return placed


def _splats(primitives: list[dict[str, Any]], path: Path) -> list[dict[str, Any]]:
    """Return the primitives of a mesh that have splats. Raises InputError for unknown kinds."""
    splats = [primitive for primitive in primitives if EXTENSION in primitive.get("extensions", {})]
    for about in map(_about, splats):
        if about.get("extensions"):
            raise InputError(
                f"{path} has compressed splats, which are not supported: decompress it first"
            )
        if about.get("kernel", "ellipse") != "ellipse":
            raise InputError(f"{path} has splats that are not Gaussians, which are not supported")
    return splats


def _about(primitive: dict[str, Any]) -> dict[str, Any]:
    return primitive["extensions"][EXTENSION]


def _matrices(
    nodes: list[dict[str, Any]], content: dict[str, Any], path: Path
) -> dict[int, Matrix]:
    """Return the matrix of each node of the scene by its number, parents included.

    Without scenes, all nodes count. Raises InputError for a node with two parents or below itself,
    and for a transform that is not valid.
    """
    if content.get("nodes") and (scenes := content.get("scenes")):
        roots = scenes[_natural(content.get("scene", 0))].get("nodes", [])
    else:
        below = {child for node in nodes for child in node.get("children", [])}
        roots = [number for number in range(len(nodes)) if number not in below]
    matrices: dict[int, Matrix] = {}
    stack = [(root, np.eye(4)) for root in reversed(roots)]
    while stack:
        number, above = stack.pop()
        if number in matrices:
            raise InputError(
                f"{path} is damaged: node {number} has two parents, or is below itself"
            )
        node = nodes[_natural(number)]
        with np.errstate(all="ignore"):  # checked below
            matrix = above @ _own_matrix(node)
        if not np.isfinite(matrix).all() or not np.array_equal(matrix[3], [0, 0, 0, 1]):
            raise InputError(f"{path} is damaged: the transform of node {number} is not valid")
        matrices[number] = matrix
        stack += [(child, matrix) for child in reversed(node.get("children", []))]
    return matrices


def _own_matrix(node: dict[str, Any]) -> Matrix:
    """Return a node's transform relative to its parent, which may not be finite."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        x, y, z, w = quat = np.array(node["rotation"], np.float64).reshape(4)
        turn = rotation_matrices(torch.tensor([[w, x, y, z]], dtype=torch.float64))[0]
        matrix[:3, :3] = turn.numpy() if quat.any() else np.nan
    matrix[:3, :3] *= np.array(node.get("scale", [1, 1, 1]), np.float64).reshape(3)
    matrix[:3, 3] = np.array(node.get("translation", [0, 0, 0]), np.float64).reshape(3)
    return matrix


def _arrays(
    content: dict[str, Any], body: memoryview, attributes: dict[str, Any], path: Path
) -> list[np.ndarray]:
    """Return the attributes of a set of splats, in the order of `SHAPES` and `SH_ATTRIBUTES`."""
    names = [*SHAPES, *SH_ATTRIBUTES[: (_degree(attributes, path) + 1) ** 2]]
    arrays = [
        _accessor(content, body, attributes[name], SHAPES.get(name, "VEC3")) for name in names
    ]
    if len({len(array) for array in arrays}) != 1:
        raise InputError(f"{path} is damaged: its attributes have different lengths")
    return arrays


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
    values = np.ndarray((count, width), kind, body, begin + offset, (stride, kind.itemsize))
    if kind.kind == "f" or accessor.get("normalized") is not True:
        return values
    return np.maximum(values / np.float32(np.iinfo(kind).max), -1)


def _natural(value: Any) -> int:
    if type(value) is not int or not 0 <= value < 1 << 40:
        raise ValueError
    return value


def _gaussians(arrays: list[np.ndarray], matrix: Matrix) -> Gaussians:
    """Return a set of splats in a node of this matrix, in the axes used here."""
    positions, rotations, scales, opacities, *sh_arrays = arrays
    count = len(positions)
    quats = np.empty((count, 4), np.float32)
    with np.errstate(all="ignore"):  # `drawable` drops such rows
        means = positions * AXIS_SIGNS
        quats[:, 0], quats[:, 1], quats[:, 2], quats[:, 3] = (
            rotations[:, 2],
            rotations[:, 1],
            -rotations[:, 0],
            -rotations[:, 3],
        )
        log_scales = np.log(scales, dtype=np.float32)
        opacity = np.minimum(opacities[:, 0].astype(np.float64), OPACITY_MAX)
        logits = (np.log(opacity) - np.log1p(-opacity)).astype(np.float32)
        sh = np.empty((count, len(sh_arrays), 3), np.float32)
        for k, values in enumerate(sh_arrays):
            sh[:, k] = values * SH_SIGNS[k]
    parts = [means.astype(np.float32, copy=False), quats, log_scales, logits, sh]
    gaussians = Gaussians(*(torch.from_numpy(part) for part in parts))
    if np.array_equal(matrix, np.eye(4)):
        return gaussians
    linear = AXIS_SIGNS[:, None] * matrix[:3, :3] * AXIS_SIGNS
    drawn = gaussians.select(gaussians.can_be_drawn())
    return transformed(drawn, linear, AXIS_SIGNS * matrix[:3, 3])


def _merged(sets: list[Gaussians]) -> Gaussians:
    """Return all Gaussians as one set of the highest SH degree."""
    if len(sets) == 1:
        return sets[0]
    most = max(part.sh.shape[1] for part in sets)
    padded = [
        replace(part, sh=torch.nn.functional.pad(part.sh, (0, 0, 0, most - part.sh.shape[1])))
        for part in sets
    ]
    names = padded[0].tensors()
    return Gaussians(
        **{name: torch.cat([part.tensors()[name] for part in padded]) for name in names}
    )
