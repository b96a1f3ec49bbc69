"""A capture made of a scene: its pictures from placed cameras, and where they were taken from."""

import json
import zlib
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import torch
from PIL import Image

from mobilegs.atomic import atomic_path, atomic_write
from mobilegs.camera import Camera
from mobilegs.data import NEAR_PLANE
from mobilegs.data.colmap_write import write_model
from mobilegs.data.dataset import Color
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import sh_colors
from mobilegs.synthetic_capture.cameras_json import read_cameras_json
from mobilegs.synthetic_capture.placement import between_cameras, place_cameras
from mobilegs.synthetic_capture.scene_bounds import Layout, layout_of
from mobilegs.synthetic_capture.visibility import refuse_blind

POINTS = 10_000  # of the capture, at most
RECORD = "made_from.json"
SHAPE = 4 / 3  # of pictures, where no camera tells
BLACK = (0.0, 0.0, 0.0)

# told what begins, gives what is told how far it is
Progress = Callable[[str], AbstractContextManager[Callable[[int, int], None]]]


def silent(what: str) -> AbstractContextManager[Callable[[int, int], None]]:
    """Progress that nobody sees."""
    return nullcontext(lambda done, total: None)


@dataclass(frozen=True)
class Shoot:
    """How a scene is photographed."""

    views: int
    """Pictures, at least 16; every eighth is held back."""
    size: int
    """Their longer side, in pixels."""
    cameras: Path | None = None
    """A cameras.json of 3DGS: pictures are taken from there and from in between."""
    seed: int = 0
    """Start of all random choices."""
    background: Color = BLACK
    """Colour behind everything, in [0, 1]."""

    def __post_init__(self) -> None:
        if not 16 <= self.views <= 10_000:
            raise InputError(f"views must lie between 16 and 10000, not at {self.views}")
        if not 64 <= self.size <= 8192:
            raise InputError(f"size must lie between 64 and 8192 pixels, not at {self.size}")
        if not all(0 <= channel <= 1 for channel in self.background):
            raise InputError(f"the background {self.background} is outside of 0..1")


@torch.inference_mode()
def photograph(
    scene: Scene,
    source: Path,
    folder: Path,
    shoot: Shoot,
    *,
    progress: Progress = silent,
) -> None:
    """Leave a capture in `folder` that `load_capture` opens: PNGs and a COLMAP model as text.

    A folder that holds it already stays as it is, and one that is not complete is completed.
    `source` is the file that the scene came from.

    Raises InputError if the folder holds pictures of another scene, or taken in another way, or
    if there is nothing to see from the cameras that are given.
    """
    record = json.dumps(_record(source, shoot), indent=1) + "\n"
    note = folder / RECORD
    if note.exists():
        if note.read_text() != record:
            raise InputError(
                f"{folder} holds pictures of another scene, or taken in another way: give another "
                "output folder, or the options that it was begun with"
            )
        if (folder / "sparse" / "0" / "cameras.txt").exists():  # what is written last
            return
    elif folder.exists() and any(folder.iterdir()):
        raise InputError(f"{folder} holds something else: give another output folder")
    behind = torch.tensor(shoot.background, device=scene.gaussians.means.device)
    scene = replace(scene, background=behind)
    generator = torch.Generator().manual_seed(shoot.seed)
    layout = layout_of(scene.gaussians)
    if shoot.cameras is None:
        with progress("finding places") as advance:
            cameras = place_cameras(
                scene,
                layout,
                shoot.views,
                width=shoot.size,
                height=round(shoot.size / SHAPE),
                generator=generator,
                progress=advance,
            )
    else:
        given = read_cameras_json(shoot.cameras)
        cameras = between_cameras(given, layout, shoot.views, size=shoot.size, generator=generator)
        whose = f"places at and between the cameras of {shoot.cameras}"
        refuse_blind(scene, cameras, whose, "give the cameras.json that lies beside it")
    # neighbours in the file's order are neighbours in space; what is held back shall be anywhere
    order = torch.randperm(len(cameras), generator=generator).tolist()
    named = [(f"{number:04}.png", cameras[i]) for number, i in enumerate(order)]
    folder.mkdir(parents=True, exist_ok=True)
    atomic_write(note, record)
    atomic_write(folder / NEAR_PLANE, f"{named[0][1].near!r}\n")
    with progress("taking pictures") as advance:
        for done, (name, camera) in enumerate(named, start=1):
            drawn = scene.render(camera.to(scene.gaussians.means.device)).image
            with atomic_path(folder / "images" / name) as path:
                Image.fromarray(to_bytes(drawn).cpu().numpy()).save(path, format="PNG")
            advance(done, len(named))
    points, colors = _points(scene, layout, named[0][1], generator)
    write_model(folder, named, points, colors)


def _record(source: Path, shoot: Shoot) -> dict[str, Any]:
    how = asdict(shoot) | {"cameras": None}
    if shoot.cameras is not None:
        how["cameras"] = f"{zlib.crc32(shoot.cameras.read_bytes()):08x}"
    data = (source / "meta.json" if source.is_dir() else source).read_bytes()
    return {"scene": source.name, "bytes": len(data), "crc32": f"{zlib.crc32(data):08x}", **how}


def _points(
    scene: Scene, layout: Layout, camera: Camera, generator: torch.Generator
) -> tuple[torch.Tensor, torch.Tensor]:
    """Some of the Gaussians' centres, and what colour they have from `camera`."""
    count = min(POINTS, int((layout.weights > 0).sum()))
    rows = torch.multinomial(layout.weights.cpu().double(), count, generator=generator)
    some = scene.gaussians.select(rows.to(scene.gaussians.means.device)).to("cpu")
    directions = torch.nn.functional.normalize(some.means - camera.position, dim=1)
    return some.means, sh_colors(some.sh, directions).clamp(0, 1)
