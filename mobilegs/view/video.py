"""A video of a scene: once around what its cameras look at."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch

from mobilegs.atomic import atomic_path
from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.mgs.codec import read_mgs
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene
from mobilegs.view.orbit import Pose, camera_of

RATE = 30  # pictures a second
CODECS = ("libx264", "mpeg4")  # the first that is there
QUALITY = {"libx264": {"crf": "18", "preset": "medium"}, "mpeg4": {"qscale": "2"}}
INSTALL = "pip install 'mobilegs[capture]'"
SECONDS_MAX = 600.0
SIDE_MAX = 4096

Progress = Callable[[int, int], None]


def open_with_views(path: Path, device: torch.device) -> tuple[Scene, list[Camera]]:
    """A scene's file, and the cameras that it brings for a first look: none but in a .mgs."""
    if path.suffix.lower() != ".mgs":
        return open_scene(path, device), []
    coded = read_mgs(path)
    return coded.decode(device), list(coded.views or [])


def orbit_cameras(
    scene: Scene, views: list[Camera], count: int, *, width: int, height: int
) -> list[Camera]:
    """`count` cameras once around what `views` look at, or else the scene's middle, each as far
    from it and as high as the first of them."""
    centers = scene.gaussians.means[scene.gaussians.means.isfinite().all(1)]
    pose = Pose.from_views(views) if views else Pose.around(centers.cpu().numpy())
    cameras = []
    for _ in range(count):
        cameras.append(camera_of(pose, views[0] if views else None, width, height, scene.near))
        pose.orbit(math.tau / count, 0.0)
    return cameras


def write_orbit(
    scene: Scene,
    views: list[Camera],
    output: Path,
    *,
    seconds: float,
    width: int,
    height: int,
    draw: Callable[[Camera], Any],
    progress: Progress = lambda done, total: None,
) -> int:
    """Write an MP4 of one turn around a scene; returns its bytes.

    `draw` gives what has an `image` `[h, w, 3]` for a camera. Raises InputError for sizes and times
    that no video has, or where PyAV is missing.
    """
    try:
        import av
    except ImportError:
        raise InputError(f"a video needs PyAV, which is not installed: {INSTALL}") from None
    if output.suffix.lower() != ".mp4":
        raise InputError(f"{output} would be an .mp4 file: give it a name that ends so")
    if not 1 / RATE <= seconds <= SECONDS_MAX:
        raise InputError(f"a video takes up to {SECONDS_MAX:g} seconds, not {seconds:g}")
    if not all(16 <= side <= SIDE_MAX and side % 2 == 0 for side in (width, height)):
        raise InputError(
            f"{width}x{height} pixels are no video's: sides are even, and 16 to {SIDE_MAX} long"
        )
    codec = next(name for name in CODECS if name in av.codecs_available)
    cameras = orbit_cameras(scene, views, round(RATE * seconds), width=width, height=height)
    device = scene.gaussians.means.device
    with (
        atomic_path(output) as temporary,
        av.open(str(temporary), "w", format="mp4", options={"movflags": "faststart"}) as file,
        torch.inference_mode(),
    ):
        stream: Any = file.add_stream(codec, rate=RATE, options=QUALITY[codec])
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for done, camera in enumerate(cameras, start=1):
            pixels = to_bytes(draw(camera.to(device)).image).cpu().numpy()
            file.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
            progress(done, len(cameras))
        file.mux(stream.encode())
    return output.stat().st_size
