"""A scene's file, whatever its kind: open it, or say what is in it."""

from pathlib import Path
from typing import Any, Literal

import torch

from mobilegs.compress.container import inspect_mgs, read_mgs
from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.spz import read_spz
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene

Device = Literal["auto", "cpu", "cuda"]
PLAIN = {".ply": read_ply, ".spz": read_spz}  # to be blended sorted


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


def open_scene(path: Path, device: torch.device) -> Scene:
    """Read a .mgs, .ply or .spz file onto `device`.

    A .mgs says how it is blended and over which background; the others are blended sorted, and
    background and near plane are the defaults of `Scene`. Raises InputError for any other file,
    or a damaged one.
    """
    kind = path.suffix.lower()
    if kind in PLAIN:
        return Scene(PLAIN[kind](path).to(device), background=torch.zeros(3, device=device))
    if kind == ".mgs":
        return read_mgs(path).decode(device)
    raise InputError(f"{path} is no scene: a .mgs, .ply or .spz file is needed")


def inspect_scene(path: Path) -> dict[str, Any]:
    """What a file holds, as plain data: Gaussians, bytes, and for a .mgs every stream."""
    if path.suffix.lower() == ".mgs":
        return {"file": str(path), **inspect_mgs(path)}
    gaussians = open_scene(path, torch.device("cpu")).gaussians
    size = path.stat().st_size
    return {
        "file": str(path),
        "blend": "sorted",
        "gaussians": len(gaussians),
        "sh_degree": gaussians.sh_degree,
        "file_bytes": size,
        "bytes_per_gaussian": size / max(len(gaussians), 1),
    }
