"""Renders a capture from a scene: images from placed cameras, and a COLMAP model of the poses."""

import json
import logging
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import torch
from PIL import Image

from mobilegs.atomic import (
    atomic_path,
    atomic_write,
    make_folder,
    read_input,
    read_text,
    refuse_links,
)
from mobilegs.camera import Camera
from mobilegs.data import NEAR_PLANE
from mobilegs.data.colmap_write import write_model
from mobilegs.data.dataset import Color
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.progress_display import Progress, no_progress
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import sh_colors
from mobilegs.up import AXES, Axis, up_text
from mobilegs.viewpoints.cameras_json import read_cameras_json
from mobilegs.viewpoints.placement import interpolate_cameras, place_cameras
from mobilegs.viewpoints.scene_bounds import SceneBounds, find_scene_bounds
from mobilegs.viewpoints.virtual_views import move_off_path
from mobilegs.viewpoints.visibility import validate_visibility

log = logging.getLogger(__name__)

POINTS_MAX = 10_000  # sparse points of the capture
RECORD = "made_from.json"
ASPECT_RATIO = 4 / 3  # width / height of images where no camera is given
DEFAULT_BACKGROUND = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class CaptureOptions:
    """Options of a synthetic capture. Raises InputError for a value out of range."""

    views: int
    """Number of images, 16 to 10,000; every eighth is held back."""
    size: int
    """Longer side of an image in pixels, 64 to 8192."""
    cameras: Path | None = None
    """A cameras.json of 3DGS: images are rendered from its cameras and from between them."""
    seed: int = 0
    """Seed of all random choices."""
    background: Color = DEFAULT_BACKGROUND
    """Background colour, RGB in [0, 1]."""
    up: Axis | None = None
    """Axis that points up. None: the scene's own direction, or else that of `find_scene_bounds`."""

    def __post_init__(self) -> None:
        if not 16 <= self.views <= 10_000:
            raise InputError(f"views must lie between 16 and 10000, got {self.views}")
        if not 64 <= self.size <= 8192:
            raise InputError(f"size must lie between 64 and 8192 pixels, got {self.size}")
        if not all(0 <= channel <= 1 for channel in self.background):
            raise InputError(
                f"the channels of a background must lie in [0, 1], got {self.background}"
            )


@torch.inference_mode()
def render_synthetic_capture(
    scene: Scene,
    source: Path,
    folder: Path,
    options: CaptureOptions,
    *,
    own: Sequence[Camera] = (),
    progress: Progress = no_progress,
) -> None:
    """Write a capture into `folder` that `load_capture` opens: PNGs and a COLMAP model as text.

    Without `cameras` and `up` in the options, the scene's `own` cameras are used if it has some.
    A finished capture is left as it is; an interrupted one is completed. `source` is the file of
    the scene: its name, size and CRC-32 identify the capture.

    Raises InputError if the folder holds something else or a capture made from another scene or
    with other options, or if most of the given cameras see nothing of the scene.
    """
    given = list(own) if options.cameras is None and options.up is None else []
    record = json.dumps(_record(source, options, len(given)), indent=1) + "\n"
    note = folder / RECORD
    if note.exists():
        if read_text(note) != record:
            raise InputError(
                f"{folder} holds images of another scene or with other options: give another "
                "output folder, or the original scene and options"
            )
        if (folder / "sparse" / "0" / "cameras.txt").exists():  # written last
            return
    elif folder.exists() and any(folder.iterdir()):
        raise InputError(f"{folder} holds something else: give another output folder")
    background = torch.tensor(options.background, device=scene.gaussians.means.device)
    scene = replace(scene, background=background)
    generator = torch.Generator().manual_seed(options.seed)
    up = scene.up if options.up is None else AXES[options.up]
    bounds = find_scene_bounds(scene.gaussians, up=up)
    if options.cameras is None and not given and up is None:
        log.warning(
            "%s does not say which way is up: cameras are placed with %s up, as its shape suggests "
            "(--up changes it)",
            source,
            up_text(bounds.up.double().cpu().numpy()),
        )
    if options.cameras is None and not given:
        with progress("placing cameras") as advance:
            cameras = place_cameras(
                scene,
                bounds,
                options.views,
                width=options.size,
                height=round(options.size / ASPECT_RATIO),
                generator=generator,
                progress=advance,
            )
    else:
        described = "own cameras"
        if options.cameras is not None:
            given = read_cameras_json(options.cameras)
            described = f"cameras from {options.cameras}"
        cameras = interpolate_cameras(
            given, bounds, options.views, size=options.size, generator=generator
        )
        if len(given) == 1:  # nothing lies between one camera and itself
            means = scene.gaussians.means.cpu()
            cameras = [cameras[0], *move_off_path(cameras[1:], means, options.seed)]
        validate_visibility(scene, cameras, described, "give the cameras.json of this scene")
    # neighbours in the file are neighbours in space: shuffle, so that held-back views are spread
    order = torch.randperm(len(cameras), generator=generator).tolist()
    named = [(f"{number:04}.png", cameras[i]) for number, i in enumerate(order)]
    make_folder(folder)
    refuse_links(folder / "images", folder / "sparse", folder / "sparse" / "0")
    atomic_write(note, record)
    atomic_write(folder / NEAR_PLANE, f"{named[0][1].near!r}\n")
    with progress("rendering images") as advance:
        for done, (name, camera) in enumerate(named, start=1):
            drawn = scene.render(camera.to(scene.gaussians.means.device)).image
            with atomic_path(folder / "images" / name) as path:
                Image.fromarray(to_bytes(drawn).cpu().numpy()).save(path, format="PNG")
            advance(done, len(named))
    points, colors = _points(scene, bounds, named[0][1], generator)
    write_model(folder, named, points, colors)


def _record(source: Path, options: CaptureOptions, own: int) -> dict[str, Any]:
    how = asdict(options) | {"cameras": None}
    if options.up is None:
        del how["up"]  # captures of earlier versions have none
    if options.cameras is not None:
        how["cameras"] = f"{zlib.crc32(read_input(options.cameras)):08x}"
    if own:
        how["own_cameras"] = own
    data = read_input(source / "meta.json" if source.is_dir() else source)
    return {"scene": source.name, "bytes": len(data), "crc32": f"{zlib.crc32(data):08x}", **how}


def _points(
    scene: Scene, bounds: SceneBounds, camera: Camera, generator: torch.Generator
) -> tuple[torch.Tensor, torch.Tensor]:
    """Sample means [m, 3] by visibility, with their colours [m, 3] as seen from `camera`."""
    count = min(POINTS_MAX, int((bounds.weights > 0).sum()))
    rows = torch.multinomial(bounds.weights.cpu().double(), count, generator=generator)
    some = scene.gaussians.select(rows.to(scene.gaussians.means.device)).to("cpu")
    directions = torch.nn.functional.normalize(some.means - camera.position, dim=1)
    return some.means, sh_colors(some.sh, directions).clamp(0, 1)
