"""A scene's file, whatever its kind: open it, say what is in it, write one of another kind."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import torch

from mobilegs.errors import InputError
from mobilegs.formats.glb import read_glb, write_glb
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.formats.sog import read_sog, write_sog
from mobilegs.formats.splat import read_splat
from mobilegs.formats.spz import read_spz, write_spz
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import inspect_mgs, read_mgs
from mobilegs.render.scene import Scene

Device = Literal["auto", "cpu", "cuda"]
Kind = Literal["ply", "spz", "sog", "glb"]
PLAIN = {  # to be blended sorted
    ".ply": read_ply,
    ".spz": read_spz,
    ".sog": read_sog,
    ".splat": read_splat,
    ".glb": read_glb,
}
NOTED = {"ply": write_ply, "sog": write_sog, "glb": write_glb}  # whose headers take a note
WRITERS = {**NOTED, "spz": write_spz}


def choose_device(name: Device) -> torch.device:
    """The device that an option names; `auto` is the GPU if there is one."""
    if name == "cuda" and not torch.cuda.is_available():
        raise InputError("this machine offers no CUDA device: see `mobilegs doctor`")
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    return torch.device(name)


def read_gaussians(path: Path) -> Gaussians:
    """The Gaussians of a plain 3DGS scene, whatever its format.

    Raises InputError for a .mgs, which is no such scene, any other file, or a damaged one.
    """
    if path.suffix.lower() == ".mgs":
        raise InputError(f"{path} is a finished .mgs: a plain 3DGS scene is needed, like a .ply")
    gaussians = open_scene(path, torch.device("cpu")).gaussians
    if not len(gaussians):
        raise InputError(f"{path} has no Gaussians: there is nothing to learn from")
    return gaussians


def open_scene(path: Path | str, device: torch.device | str = "cpu") -> Scene:
    """Read a file of a scene onto `device`: .mgs, .ply, .spz, .sog (or its folder), .splat, .glb.

    A .mgs says how it is blended and over which background; the others are blended sorted, and
    background and near plane are the defaults of `Scene`. Raises InputError for any other file,
    or a damaged one.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind == ".mgs":
        return read_mgs(path).decode(device)
    if path.name == "meta.json" or (path / "meta.json").is_file():  # a .sog that was unpacked
        kind = ".sog"
    if kind not in PLAIN:
        raise InputError(f"{path} is no scene: a .mgs, {_names(PLAIN)} file is needed")
    return Scene(PLAIN[kind](path).to(device), background=torch.zeros(3, device=device))


def inspect_scene(path: Path) -> dict[str, Any]:
    """What a file holds, as plain data: Gaussians, bytes, and for a .mgs every stream."""
    if path.suffix.lower() == ".mgs":
        return {"file": str(path), **inspect_mgs(path)}
    gaussians = open_scene(path, torch.device("cpu")).gaussians
    size = size_of(path)
    return {
        "file": str(path),
        "blend": "sorted",
        "gaussians": len(gaussians),
        "sh_degree": gaussians.sh_degree,
        "file_bytes": size,
        "bytes_per_gaussian": size / max(len(gaussians), 1),
    }


def write_gaussians(output: Path, gaussians: Gaussians, kind: Kind, *, note: str = "") -> int:
    """Write a scene for sorted blending as a file of a kind, whole or not at all.

    `note`, of one line, goes into the file's header; a .spz has no place for it. Returns the bytes.
    Raises InputError if the kind cannot hold the scene.
    """
    if kind in NOTED:
        NOTED[kind](output, gaussians, note=note)
    else:
        WRITERS[kind](output, gaussians)
    return output.stat().st_size


def teacher_of(student: Path) -> Path | None:
    """The sorted scene that a student in a run's folder learned from, if it is there."""
    teacher = student.with_name("teacher.ply")
    if teacher.is_file() and student.with_name("metrics.json").is_file():
        return teacher
    return None


def _names(kinds: Iterable[str]) -> str:
    *most, last = kinds
    return f"{', '.join(most)} or {last}"


def size_of(path: Path) -> int:
    """Bytes of a file, or of the files of a .sog that was unpacked."""
    if path.name != "meta.json" and not path.is_dir():
        return path.stat().st_size
    folder = path if path.is_dir() else path.parent
    files = [folder / "meta.json", *folder.glob("*.webp")]
    return sum(file.stat().st_size for file in files)
