"""Reads and writes 3DGS scenes as PLY, in the layout of INRIA's release.

One row per Gaussian: mean, (unused) normal, degree-0 SH `f_dc_*`, higher SH coefficients `f_rest_*`
channel by channel (all of red, then green, then blue), logit of the opacity, logarithms of the
scales, rotation wxyz. Axes are OpenCV's, those of the capture. `ply_compressed.py` reads files in
PlayCanvas's compressed layout. `viewer/src/load/ply.js` reads the same in the browser.
"""

import logging
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float

from mobilegs.atomic import atomic_path, open_input
from mobilegs.camera import Camera
from mobilegs.data.ply_table import (
    CHANNELS,
    Element,
    Header,
    channel_max,
    cut_off,
    find_vertex,
    read_header,
    type_name,
    vertex_rows,
)
from mobilegs.errors import InputError
from mobilegs.formats.ply_compressed import SH_DEGREES, Table, read_compressed
from mobilegs.gaussians import Gaussians
from mobilegs.packed_gaussians import logits_of
from mobilegs.render.project import BLUR, BLUR_MAX, CLASSIC, Footprint
from mobilegs.spherical_harmonics import C0
from mobilegs.up import AXES, Axis, Vector, parsed_up, up_text, written_up
from mobilegs.viewpoints.cameras_json import parse_camera

log = logging.getLogger(__name__)

MEANS = ["x", "y", "z"]
BASE_COLOR = ["f_dc_0", "f_dc_1", "f_dc_2"]
SCALES = ["scale_0", "scale_1", "scale_2"]
ROTATION = ["rot_0", "rot_1", "rot_2", "rot_3"]
COLUMNS = [*MEANS, *ROTATION, *SCALES, "opacity", *BASE_COLOR]  # in the order of reading
FLAT_AXIS, FLAT_FROM = SCALES[2], SCALES[0]  # 2DGS has no third scale
PREFIX = re.compile("^(scalar_)?(scal_)?")  # of CloudCompare's scalar fields
LOG_FLAT = -6.9  # logarithm of a thousandth
RENDER_MODES = ("default", "mip")
# of `Vertical Axis`: nerfstudio writes z for scenes with z up, Brush y for all scenes
VERTICAL_AXES: dict[str, Axis] = {"x": "x", "y": "-y", "z": "z"}


def read_ply(path: Path | str) -> Gaussians:
    """Read the Gaussians of a PLY; see `read_ply_scene`."""
    return read_ply_scene(path)[0]


def read_ply_up(path: Path | str) -> Vector | None:
    """Return the upward direction that a PLY names, length 1, or None. Raises as `read_ply`."""
    return upward(read_header(Path(path))[0])


def upward(header: Header) -> Vector | None:
    """Return the upward direction that the comments name, length 1, or None.

    nerfstudio writes `Vertical Axis: z`, and `write_ply` a direction: `mobilegs up X Y Z`. Brush
    writes `Vertical axis: y` for scenes of COLMAP, whose up is -y. Other words name none.
    """
    up = None
    for words in header.comments:
        match [word.lower() for word in words]:
            case ["vertical", "axis:", name] if name in VERTICAL_AXES:
                up = AXES[VERTICAL_AXES[name]]
            case ["mobilegs", "up", *numbers]:
                given = parsed_up(" ".join(numbers))
                up = up if given is None else given
    return up


def read_ply_camera(path: Path | str) -> Camera | None:
    """Return the camera of the photo from which Apple's SHARP made a scene; None without one.

    It is in elements after the vertices: `intrinsic` (3x3, by rows), `image_size` (width, height)
    and `extrinsic` (4x4, world to camera). Raises InputError if the file cannot be read, or the
    camera's numbers are not possible.
    """
    path = Path(path)
    header, size = read_header(path)
    if not {"intrinsic", "image_size", "extrinsic"} <= {e.name for e in header.elements}:
        return None
    tables = tables_of(header, find_vertex(header, path)[0], size, path)

    def numbers(name: str, count: int) -> np.ndarray:
        table = tables[name]
        if table.count != count or table.dtype.names != (name,):
            raise InputError(f"{path} has an element {name!r} that is not {count} numbers")
        with open_input(path) as file:
            return table.rows(file, 0, count)[name].astype(np.float64)

    viewmat, intrinsic = numbers("extrinsic", 16).reshape(4, 4), numbers("intrinsic", 9)
    with np.errstate(all="ignore"):  # `parse_camera` refuses what is not finite
        position = -viewmat[:3, :3].T @ viewmat[:3, 3]
    width, height = numbers("image_size", 2).tolist()
    row = {
        "width": int(width) if 0 < width < 1 << 31 else 0,
        "height": int(height) if 0 < height < 1 << 31 else 0,
        "fx": intrinsic[0],
        "fy": intrinsic[4],
        "position": position,
        "rotation": viewmat[:3, :3].T,
    }
    return parse_camera(row, f"the camera in {path}")


def coverage(header: Header, path: Path) -> tuple[str, float]:
    """Return the render mode that the comments name, in lower case, and the blur in px^2.

    Raises InputError for a blur out of range.
    """
    mode, blur = "default", str(BLUR)
    for words in header.comments:
        match words:
            case ["SplatRenderMode:", mode, *_]:
                mode = mode.lower()[:40]
            case ["antialiased", "1"] | ["postshot.anti_aliasing=1"]:
                mode = "mip"  # as Postshot writes it
            case ["mobilegs", "blur", blur]:
                pass
    if not re.fullmatch(r"\d*\.?\d+", blur) or not 0 < float(blur) <= BLUR_MAX:
        raise InputError(f"{path} names the blur {blur[:40]!r}: above 0 and at most 4 is possible")
    return mode, float(blur)


def read_ply_scene(path: Path | str) -> tuple[Gaussians, Footprint]:
    """Read a 3DGS scene as float32 on the CPU, and how its Gaussians cover pixels.

    The file may be text, little- or big-endian, with properties in any order, or in PlayCanvas's
    compressed layout. Gaussians with two scales, those of 2DGS, become flat ones with a thousandth
    of the smaller scale as the third. Properties that 3DGS does not use are skipped; the SH degree
    (0 to 3) follows from the number of `f_rest_*`. Rows that cannot be drawn are left out
    (`Gaussians.drawable`).

    Properties are floats of 64, 32 or 16 bits; a `ushort` in a binary file holds the bits of one of
    16. An opacity of type `uchar` is 255 times the opacity itself. Without `f_dc_*`, the colour is
    `red`, `green` and `blue`, as nerfstudio's `--ply-color-mode rgb` writes it. Names may have the
    prefix that CloudCompare gives them.

    `SplatRenderMode: mip` and Postshot's `antialiased 1` are antialiased, with the blur of a
    comment `mobilegs blur`, or 0.3. Raises InputError if the file is missing, not a PLY, cut off,
    lacks a property of 3DGS or has it in another type, or no row can be drawn.
    """
    path = Path(path)
    header, size = read_header(path)
    mode, blur = coverage(header, path)
    footprint = Footprint(blur, antialiased=mode == "mip")
    if mode not in RENDER_MODES:
        log.warning(
            "%s was made for the render mode %r; drawn as plain 3DGS it may look different",
            path,
            mode,
        )
    vertex, _ = find_vertex(header, path)
    if "packed_position" in vertex.columns:
        with open_input(path) as file:
            tables = tables_of(header, vertex, size, path)
            return read_compressed(file, tables, path), footprint
    rest, substitutes = check_properties(vertex, path, binary=not header.ascii)
    names = [substitutes.get(name, name) for name in (*COLUMNS, *rest)]
    blocks = vertex_rows(header, size, names, path)
    blocks = converted(blocks, vertex, substitutes)
    return gaussians_from_rows(blocks, vertex.count, rest, path), footprint


def check_properties(
    vertex: Element, path: Path, *, binary: bool
) -> tuple[list[str], dict[str, str]]:
    """Return the names of the `f_rest_*` properties, and those that stand in for missing ones.

    In binary files, columns of type `ushort` become `half`. Columns lose the prefix `scalar_` or
    `scal_` that CloudCompare gives them. Raises InputError if a property is missing or has a type
    that cannot hold it.
    """
    bare = {PREFIX.sub("", name): kind for name, kind in vertex.columns.items()}
    if "x" in vertex.columns and len(bare) == len(vertex.columns):
        vertex.columns.clear()
        vertex.columns.update(bare)
    if not {*SCALES, *ROTATION, "opacity"} & vertex.columns.keys():
        raise InputError(
            f"{path} holds points without sizes: it is a point cloud or a mesh, not a 3DGS scene. "
            "Scenes are trained from photos: see `mobilegs train --help`"
        )
    missing = [name for name in COLUMNS if name not in vertex.columns]
    substitutes = {FLAT_AXIS: FLAT_FROM} if FLAT_AXIS in missing else {}
    if {*BASE_COLOR} <= {*missing} and {*CHANNELS} <= vertex.columns.keys():
        substitutes |= zip(BASE_COLOR, CHANNELS, strict=True)
    missing = [name for name in missing if name not in substitutes]
    if missing:
        raise InputError(f"{path} is not a 3DGS scene: its vertices lack {', '.join(missing)}")
    count = sum(name.startswith("f_rest_") for name in vertex.columns)
    rest = [f"f_rest_{i}" for i in range(count)]
    if count not in SH_DEGREES or any(name not in vertex.columns for name in rest):
        raise InputError(
            f"{path} has {count} f_rest properties, and a 3DGS scene has 0, 9, 24 or 45"
        )
    for name in (*COLUMNS, *rest):
        kind = vertex.columns.get(name, "f4")
        if kind == "u2" and binary:
            vertex.columns[name] = "f2"
        elif kind[0] != "f" and (name, kind) != ("opacity", "u1"):
            raise InputError(
                f"{path} stores {name} as {type_name(kind)}, which cannot hold it: export the "
                "scene again with properties of type float"
            )
    return rest, substitutes


def tables_of(header: Header, vertex: Element, size: int, path: Path) -> dict[str, Table]:
    """Return the place of each element in a binary file of `size` bytes.

    Raises InputError for a text file, for lists, and for a file that is too small.
    """
    if header.ascii or any(e.has_lists for e in header.elements):
        raise InputError(
            f"{path} is a compressed PLY, or has a camera, as text or with lists, which is not "
            "supported"
        )
    tables, start = {}, header.length
    for element in header.elements:
        dtype = element.dtype(header.order)
        tables[element.name] = Table(start, element.count, dtype)
        start += element.count * dtype.itemsize
    if start > size or len(tables) < len(header.elements):
        raise cut_off(path, vertex.count)
    return tables


def converted(
    blocks: Iterable[np.ndarray], vertex: Element, substitutes: dict[str, str]
) -> Iterable[np.ndarray]:
    """Convert what other tools store in blocks of `COLUMNS` to the values of 3DGS.

    The Gaussians of 2DGS are disks in the plane of their first two axes: their third scale becomes
    a thousandth of the smaller of the others.
    """
    for table in blocks:
        with np.errstate(invalid="ignore"):  # rows with NaN are left out later
            if FLAT_AXIS in substitutes:
                table[:, 9] = table[:, 7:9].min(axis=1) + LOG_FLAT
            if BASE_COLOR[0] in substitutes:
                table[:, 11:14] = (table[:, 11:14] / channel_max(vertex) - 0.5) / C0
            if vertex.columns["opacity"] == "u1":
                table[:, 10] = logits_of(table[:, 10] / 255)
        yield table


def gaussians_from_rows(
    blocks: Iterable[np.ndarray], count: int, rest: list[str], path: Path
) -> Gaussians:
    """Convert blocks of `COLUMNS` and `rest`, `count` rows in all."""
    sizes = (3, 4, 3, 1, 3 + len(rest))  # columns per tensor
    parts = [np.empty((count, size), np.float32) for size in sizes]
    first = 0
    for table in blocks:
        sh = table[:, 11:]
        # [m, 3, k] in the file, [m, k, 3] here
        by_channel = sh[:, 3:].reshape(len(sh), 3, len(rest) // 3)
        sh[:, 3:] = by_channel.swapaxes(1, 2).reshape(len(sh), len(rest))
        for part, values in zip(parts, np.split(table, np.cumsum(sizes)[:-1], axis=1), strict=True):
            part[first : first + len(table)] = values
        first += len(table)
    means, quats, log_scales, opacities, sh = (torch.from_numpy(part[:first]) for part in parts)
    whole = Gaussians(means, quats, log_scales, opacities[:, 0], sh.unflatten(1, (-1, 3)))
    return whole.drawable(path)


def write_ply(
    path: Path | str,
    gaussians: Gaussians,
    *,
    footprint: Footprint = CLASSIC,
    up: Float[np.ndarray, "3"] | None = None,
    note: str = "",
) -> None:
    """Write a scene for sorted blending to a PLY; the file appears complete or not at all.

    The layout is INRIA's, little-endian float32. The header has the comments `SplatRenderMode:
    default` or, antialiased, `mip`, which other tools read, and `mobilegs blend sorted`. A blur
    other than 0.3, the upward direction and `note`, a line of ASCII, become further comments. Other
    tools draw a blur of 0.3. Gaussians that cannot be drawn are left out (`Gaussians.drawable`).
    Raises InputError for a soft edge, which sorted blending does not have, or if none can be drawn.
    """
    if footprint.soft_edge:
        raise InputError("a .ply is blended sorted, and sorted blending has no soft edge")
    gaussians = gaussians.detached().to("cpu", torch.float32).drawable(path)
    count, coefficients = gaussians.sh.shape[:2]
    rest = [f"f_rest_{i}" for i in range(3 * (coefficients - 1))]
    normal = ["nx", "ny", "nz"]
    names = [*MEANS, *normal, *BASE_COLOR, *rest, "opacity", *SCALES, *ROTATION]
    parts = [
        gaussians.means,
        torch.zeros_like(gaussians.means),
        gaussians.sh[:, 0],
        gaussians.sh[:, 1:].transpose(1, 2).reshape(count, len(rest)),
        gaussians.logit_opacities[:, None],
        gaussians.log_scales,
        gaussians.quats,
    ]
    table = torch.cat(parts, dim=1).numpy()
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {count}",  # INRIA's viewer expects it in this line
        *(f"property float {name}" for name in names),
        f"comment SplatRenderMode: {'mip' if footprint.antialiased else 'default'}",
        "comment mobilegs blend sorted",
        *([f"comment mobilegs blur {footprint.blur:g}"] if footprint.blur != BLUR else []),
        *([] if up is None else [f"comment {up_comment(up)}"]),
        *([f"comment mobilegs {note}"] if note else []),
        "end_header\n",
    ]
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write("\n".join(header).encode())
        file.write(table.astype("<f4", copy=False).tobytes())


def up_comment(up: Vector) -> str:
    """Return the comment from which `upward` reads a direction."""
    if up_text(up) == "z":  # other tools read this one
        return "Vertical Axis: z"
    return f"mobilegs up {written_up(up)}"
