"""Posters: images of a scene's first view, which pages show until the scene appears."""

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import torch
from PIL import Image

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.render.scene import Scene
from mobilegs.render.supersampling import supersampling_for
from mobilegs.scene_file import open_with_views
from mobilegs.up import Axis, written_up
from mobilegs.viewpoints.pose import Pose, camera_of, first_pose

SIZE = (1200, 630)  # pixels, the size that services which preview links expect
INLINE_SIDE = 440  # pixels of the longer side of posters inside of a page
ASPECT_MAX = 2.3  # width over height of screens that a poster fills; as high in portrait
QUALITY = 40  # of WebP
PAGE_COLOR = "#0d0f12"  # colour of the page around posters


@dataclass(frozen=True)
class Posters:
    """Images of a scene's first view.

    Attributes:
        preview: 1200 x 630 pixels, for previews of links.
        notes: attributes of `<mobile-gs>` that its viewer does not find in the file.
        style: CSS that shows a poster behind `<mobile-gs>`, exactly where the viewer will show the
            first view, or nothing if the file notes no first view.
    """

    preview: Image.Image
    style: str
    notes: Mapping[str, str]


@torch.inference_mode()
def posters_of(
    path: Path, up: Axis | None = None, notes: Mapping[str, str] | None = None
) -> Posters:
    """Render the posters of a scene file. Reads the whole file.

    `up` replaces the scene's upward direction, and `notes` its first views, if there are any.
    Raises InputError for a scene that the web viewer does not show, or without Gaussians.
    """
    scene, views = open_with_views(path)
    found = {} if path.suffix.lower() == ".mgs" else camera_notes(scene, up)
    if notes:
        scene = replace(scene, notes=notes)
    if not len(scene.gaussians):
        raise InputError(f"{path} has no Gaussians: there is nothing to show")
    pose = first_pose(scene, views, up, size=SIZE)
    camera = camera_of(pose, views[0] if views else None, *SIZE, scene.near)
    preview = _render(scene, camera, views)
    if pose.box is None:
        return Posters(preview, "", found)
    upright = first_pose(scene, views, up, size=(1, 2))
    wide = _rule(scene, views, pose, ASPECT_MAX)
    high = _rule(scene, views, upright, 1 / ASPECT_MAX)
    return Posters(preview, f"{wide}\n@media (orientation: portrait) {{ {high} }}", found)


def camera_notes(scene: Scene, up: Axis | None = None) -> dict[str, str]:
    """Return `start` and `up` of a .ply with cameras, which the web viewer does not read.

    Empty for other scenes, and if `up` replaces the scene's direction.
    """
    start = scene.notes.get("start")
    if up is not None or scene.up is None or not isinstance(start, str):
        return {}
    return {"start": start, "up": written_up(scene.up + 0.0)}


def _rule(scene: Scene, views: list[Camera], pose: Pose, shape: float) -> str:
    """Return the CSS of a poster that fills screens from square to `shape`, width over height."""
    assert pose.box is not None
    x, y = pose.box
    shapes = (1.0, shape)
    width = max(max(x, y * each) for each in shapes)  # tangents of half the poster
    height = max(max(y, x / each) for each in shapes)
    share = INLINE_SIDE / max(width, height)
    size = max(16, round(share * width)), max(16, round(share * height))
    whole = pose.copy()
    whole.box = (width, height)
    image = _render(scene, camera_of(whole, None, *size, scene.near), views)
    poster = data_url(encoded(image, "webp", quality=QUALITY, method=6), "image/webp")
    # the viewer's focal length, twice: min(width / x, height / y)
    sizes = "".join(
        f"background-size: calc(min(100vw / {x:.5f}, 100{unit} / {y:.5f}) * {width:.5f}) auto; "
        for unit in ("vh", "dvh")  # browsers that do not know the second keep the first
    )
    place = f"background: {PAGE_COLOR} url({poster}) center no-repeat; {sizes}"
    return f"mobile-gs {{ {place}}}"


def _render(scene: Scene, camera: Camera, views: list[Camera]) -> Image.Image:
    rendered = scene.render(camera, supersampling=supersampling_for(camera, views))
    return Image.fromarray(to_bytes(rendered.image).numpy())


def jpeg(image: Image.Image, quality: int = 80) -> bytes:
    return encoded(image, "jpeg", quality=quality, optimize=True)


def encoded(image: Image.Image, kind: str, **options: Any) -> bytes:
    out = io.BytesIO()
    image.save(out, format=kind, **options)
    return out.getvalue()


def data_url(data: bytes, kind: str) -> str:
    """Return an address that holds the data itself, of a media type."""
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
