"""Scene files of all formats: open, inspect and write them."""

import logging
from collections.abc import Callable, Iterable
from dataclasses import replace
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.atomic import atomic_path, read_json
from mobilegs.camera import NEAR, Camera
from mobilegs.errors import InputError
from mobilegs.formats import READ, WRITTEN, Kind
from mobilegs.formats.fidelity import measure_fidelity
from mobilegs.formats.ply import read_ply_camera, read_ply_up, write_ply
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import inspect_mgs, read_mgs
from mobilegs.mgs.contents import MgsContents
from mobilegs.render.project import CLASSIC, Footprint
from mobilegs.render.scene import Scene
from mobilegs.render.transform import transformed
from mobilegs.up import AXES, USUAL, Vector, turn_from_usual, up_of_cameras, up_text
from mobilegs.viewpoints.cameras_json import read_cameras_json
from mobilegs.viewpoints.framing import Framing, Limits, Start
from mobilegs.viewpoints.visibility import depths_in_view, fit_scene

log = logging.getLogger(__name__)

TURN_MIN = 1e-6  # difference of directions below which a scene is not turned
SAMPLE, INSIDE = 10_000, 0.9  # Gaussians from which `near_of` finds the size; those inside of it

# plain 3DGS scenes, blended sorted: the functions of each module of `formats`
MODULES = {name: import_module(f"mobilegs.formats.{name}") for name in READ}
PLAIN: dict[str, Callable[[Path], Gaussians]] = {
    f".{name}": getattr(module, f"read_{name}") for name, module in MODULES.items()
}
WITH_FOOTPRINT: dict[str, Callable[[Path], tuple[Gaussians, Footprint]]] = {
    f".{name}": getattr(module, f"read_{name}_scene")
    for name, module in MODULES.items()
    if hasattr(module, f"read_{name}_scene")
}
WRITERS: dict[str, Callable[..., Any]] = {
    name: getattr(MODULES[name], f"write_{name}") for name in WRITTEN
}


def scene_at(path: Path) -> Path:
    """Return the scene file that a person means: `path`, or the scene.mgs of a run's folder.

    Raises InputError if nothing is there, or if the run has no scene yet.
    """
    if not path.exists():
        raise InputError(f"{path} does not exist")
    if not (path / "config.json").is_file():
        return path
    if not (path / "scene.mgs").is_file():
        raise InputError(f"the run in {path} has no scene yet: continue it with --resume first")
    return path / "scene.mgs"


def plain_scene_at(path: Path) -> Path:
    """Return `path`, or the teacher of a run's folder. Raises InputError if nothing is there."""
    path = path / "teacher.ply" if (path / "config.json").is_file() else path
    if not path.exists():
        raise InputError(f"{path} does not exist")
    return path


def read_plain_scene(path: Path, device: torch.device | str = "cpu") -> Scene:
    """Read a plain 3DGS scene of any format; see `read_plain_with_cameras`."""
    return read_plain_with_cameras(path, device)[0]


def read_plain_with_cameras(
    path: Path, device: torch.device | str = "cpu"
) -> tuple[Scene, list[Camera]]:
    """Read a plain 3DGS scene, of a run's folder its teacher, and the cameras of a .ply.

    Raises InputError if the file is a .mgs or another kind of file, is damaged, or has no
    Gaussians.
    """
    path = plain_scene_at(path)
    if path.suffix.lower() == ".mgs":
        raise InputError(
            f"{path} is a .mgs: a plain 3DGS scene is needed, like a .ply; "
            f"`mobilegs export {path} --to ply -o NEW.ply` makes one of it"
        )
    scene, cameras = _open_plain(path, device)
    if not len(scene.gaussians):
        raise InputError(f"{path} has no Gaussians: there is nothing to learn from")
    return scene, cameras


def open_scene(path: Path | str, device: torch.device | str = "cpu") -> Scene:
    """Read a scene file onto `device`: .mgs, .ply, .spz, .sog (or its folder), .splat or .glb.

    A .mgs names its blending, footprint, background and near plane, and its training cameras tell
    which way is up. The others are blended sorted over black, with the near plane of `near_of`; a
    .ply, .spz or .sog may be antialiased, a .ply may name its upward direction, and that of a .glb
    is glTF's. The cameras of a .ply (`cameras_of_ply`) become notes: a first view and limits near
    them. Rows that cannot be drawn are left out (`Gaussians.drawable`). Raises InputError if the
    file is of another kind, is damaged, or cannot be read.
    """
    path = scene_at(Path(path))
    if path.suffix.lower() != ".mgs":
        return _open_plain(path, device)[0]
    scene = read_mgs(path).decode(device)
    scene.file = path
    return scene


def _open_plain(path: Path, device: torch.device | str) -> tuple[Scene, list[Camera]]:
    """Read a scene of another tool, and the cameras of a .ply."""
    kind = path.suffix.lower()
    if path.name == "meta.json" or (path / "meta.json").is_file():  # an unpacked .sog
        kind = ".sog"
    if kind not in PLAIN:
        raise InputError(f"{path} is not a scene: a .mgs, {_names(PLAIN)} file is needed")
    footprint = CLASSIC
    if kind in WITH_FOOTPRINT:
        gaussians, footprint = WITH_FOOTPRINT[kind](path)
    else:
        gaussians = PLAIN[kind](path)
    up = read_ply_up(path) if kind == ".ply" else AXES["-y"] if kind == ".glb" else None
    black, near = torch.zeros(3, device=device), near_of(gaussians.means)
    scene = Scene(gaussians.to(device), background=black, near=near, footprint=footprint, up=up)
    cameras = cameras_of_ply(path, gaussians.means, near) if kind == ".ply" else []
    if not cameras:
        return scene, []
    if scene.up is None:
        mats = np.stack([camera.viewmat.double().numpy() for camera in cameras])
        scene.up = up_of_cameras(mats)
    depths = depths_in_view(gaussians.means, cameras[0])
    if len(depths):
        start = Start.from_camera(cameras[0], float(depths.median()))
        eyes = np.stack([camera.position.double().numpy() for camera in cameras])
        limits = Limits.around(eyes, start.target, scene.up)
        scene.notes = Framing(start, limits=limits).notes
    return scene, cameras


def cameras_of_ply(path: Path, means: Float[Tensor, "n 3"], near: float) -> list[Camera]:
    """Return the cameras of a .ply, with this near plane; an empty list if there are none.

    They are the camera in the file, as Apple's SHARP writes it, or those of the `cameras.json` that
    INRIA's training writes, beside the file or above its folder `point_cloud`. Cameras that are not
    valid or do not fit the scene (`fit_scene`) are not used, with a logged warning.
    """
    folders = [path.parent]
    if path.absolute().parent.parent.name == "point_cloud":
        folders.append(path.absolute().parents[2])
    listed = [file for folder in folders if (file := folder / "cameras.json").is_file()]
    try:
        own = read_ply_camera(path)
        cameras = [own] if own is not None else read_cameras_json(listed[0]) if listed else []
    except (InputError, OSError) as error:
        log.warning("the cameras of %s are not used: %s", path, error)
        return []
    cameras = [replace(camera, near=near) for camera in cameras]
    if cameras and not fit_scene(cameras, means):
        source = path if own is not None else listed[0]
        log.warning("the cameras in %s are not used: they do not show this scene", source)
        return []
    return cameras


def up_source(path: Path, up: Vector | None) -> str:
    """Return the upward direction of the scene at `path` and how it is known, for people."""
    if up is None:
        return f"{up_text(USUAL)}, as usual: the file does not say"
    kind = path.suffix.lower()
    cameras = kind == ".mgs" or (kind == ".ply" and read_ply_up(path) is None)
    return f"{up_text(up)}, {'from its cameras' if cameras else 'as the file says'}"


def near_of(means: Float[Tensor, "n 3"]) -> float:
    """Return the near plane of a scene whose file has none, in world units, as near.js does.

    It is that of 3DGS, and less for a scene of a size below 1: the largest coordinate, from the
    median, of nine in ten Gaussians.
    """
    some = means[:: max(1, len(means) // SAMPLE)]
    if not len(some):
        return NEAR
    away = (some - some.median(0).values).abs().amax(1).sort().values
    return NEAR * min(1.0, max(float(away[int(INSIDE * (len(away) - 1))]), 1e-6))


class SceneContents(TypedDict):
    """The content of a scene file, as JSON values.

    Attributes:
        file: path of the file.
        blend: `sorted` or `sortfree`.
        gaussians: their number.
        left_out: rows of the file that cannot be drawn (`Gaussians.drawable`).
        sh_degree: degree of the colour's spherical harmonics, 0 to 3.
        file_bytes: size of the file.
        bytes_per_gaussian: the same, divided by its Gaussians.
        up: upward direction that the file or its cameras tell, length 1; None if they tell none.
    """

    file: str
    blend: str
    gaussians: int
    left_out: int
    sh_degree: int
    file_bytes: int
    bytes_per_gaussian: float
    up: list[float] | None


class MgsFileContents(SceneContents, MgsContents):
    """The content of a `.mgs` file: also its format, its streams and their bytes."""


def inspect_scene(path: Path) -> SceneContents | MgsFileContents:
    """Report the content of a scene file; that of a .mgs has the keys of `MgsFileContents`.

    Raises InputError as `open_scene`.
    """
    if path.suffix.lower() == ".mgs":
        up = read_mgs(path).up
        contents = inspect_mgs(path)
        up = None if up is None else up.tolist()
        return {"file": str(path), "left_out": 0, **contents, "up": up}
    scene = open_scene(path)
    gaussians = scene.gaussians
    size = size_of(path)
    return {
        "file": str(path),
        "blend": "sorted",
        "gaussians": len(gaussians),
        "left_out": gaussians.left_out,
        "sh_degree": gaussians.sh_degree,
        "file_bytes": size,
        "bytes_per_gaussian": size / max(len(gaussians), 1),
        "up": None if scene.up is None else scene.up.tolist(),
    }


def write_gaussians(
    output: Path,
    gaussians: Gaussians,
    kind: Kind,
    *,
    footprint: Footprint = CLASSIC,
    up: Float[np.ndarray, "3"] | None = None,
    note: str = "",
) -> int:
    """Write a scene for sorted blending in the format `kind`, atomically; returns its bytes.

    A .ply names the upward direction `up`. The other formats have one, to which the scene is turned
    (`turn_needed`). `note`, one line, goes into the file's header; a .spz has no place for it. A
    .glb has no place for an antialiased footprint. This, Gaussians that cannot be drawn, and what
    the file does not hold of the others (`formats.fidelity`) are named in logged warnings. Raises
    InputError if the format cannot hold the scene, or most of its Gaussians would be lost.
    """
    if kind == "ply":
        write_ply(output, gaussians, footprint=footprint, up=up, note=note)
        return output.stat().st_size
    gaussians = gaussians.detached().to("cpu", torch.float32).drawable(output)
    if turn_needed(up, kind):
        assert up is not None
        gaussians = transformed(gaussians, turn_from_usual(up).T, np.zeros(3))
    write = WRITERS[kind]
    held = signature(write).parameters  # `footprint`, `note`, if the file has a place for them
    if "footprint" not in held and footprint != CLASSIC:
        log.warning("a .%s has no place for the scene's footprint: readers draw 3DGS's", kind)
    values = {"footprint": footprint, "note": note}
    with atomic_path(output) as path:
        written = write(path, gaussians, **{name: values[name] for name in values if name in held})
        gaussians = gaussians if written is None else written  # in another order
        reread = PLAIN[f".{kind}"](path)
        if len(reread) < len(gaussians):
            raise InputError(f"a .{kind} cannot hold numbers as large as in this scene")
        loss = measure_fidelity(gaussians, reread)
        if 2 * loss.lost > loss.count:
            raise InputError(f"a .{kind} cannot hold this scene: {loss}; write a .ply or .glb")
        if str(loss):
            log.warning("the .%s does not hold all of the scene: %s", kind, loss)
    return output.stat().st_size


def turn_needed(up: Vector | None, kind: Kind) -> bool:
    """Return True if a scene with this upward direction is turned for a file of this kind."""
    return kind != "ply" and up is not None and bool(np.abs(up - USUAL).max() > TURN_MIN)


def teacher_of(student: Path) -> Path | None:
    """Return the teacher of a student in a run's folder, if it exists."""
    teacher = student.with_name("teacher.ply")
    if teacher.is_file() and student.with_name("metrics.json").is_file():
        return teacher
    return None


def capture_of_run(scene: Path) -> tuple[Path | None, int | None]:
    """Return the capture of the scene's run, if it is still there, and the divisor of its photos.

    Both are None for a scene that does not lie in the folder of a run.
    """
    try:
        options = read_json(scene.with_name("config.json"))["options"]
        capture, downscale = Path(options["capture"]), options["downscale"]
    except (ValueError, LookupError, TypeError):
        return None, None
    known = downscale is None or type(downscale) is int
    return capture if capture.is_dir() else None, downscale if known else None


def open_with_views(path: Path, device: torch.device | str = "cpu") -> tuple[Scene, list[Camera]]:
    """Read a scene and the training cameras that a .mgs stores; other formats have none.

    Raises InputError for a file that cannot be read.
    """
    if path.suffix.lower() != ".mgs":
        return open_scene(path, device), []
    coded = read_mgs(path)
    return coded.decode(device), list(coded.views or [])


def _names(kinds: Iterable[str]) -> str:
    *most, last = kinds
    return f"{', '.join(most)} or {last}"


def size_of(path: Path) -> int:
    """Return the bytes of a file, or of all files of an unpacked .sog."""
    if path.name != "meta.json" and not path.is_dir():
        return path.stat().st_size
    folder = path if path.is_dir() else path.parent
    files = [folder / "meta.json", *folder.glob("*.webp")]
    return sum(file.stat().st_size for file in files)
