"""A video of a scene: one turn around the point that its cameras look at."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch

from mobilegs.atomic import atomic_path
from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.extras import extra_module
from mobilegs.progress_display import Advance
from mobilegs.render.scene import Scene
from mobilegs.up import Axis
from mobilegs.viewpoints.orbit import orbit_cameras

RATE = 30  # frames per second
CODECS = ("libx264", "mpeg4")  # the first one available
QUALITY = {"libx264": {"crf": "18", "preset": "medium"}, "mpeg4": {"qscale": "2"}}
SECONDS_MAX = 600.0
SIDE_MAX = 4096


def write_orbit(
    scene: Scene,
    views: list[Camera],
    output: Path,
    *,
    seconds: float,
    width: int,
    height: int,
    up: Axis | None = None,
    draw: Callable[[Camera], Any],
    progress: Advance = lambda done, total: None,
) -> int:
    """Write an MP4 of one turn around a scene. Returns its bytes.

    `up` replaces the scene's upward direction. `draw` renders a camera to an object with an
    `image` `[h, w, 3]`; `progress` gets the number of finished frames and of all. Raises InputError
    for a file name that does not end in .mp4, an odd size or one outside 16 to 4,096 pixels, a
    length outside 1/30 to 600 seconds, and without PyAV.
    """
    av = extra_module("av", "a video needs PyAV", "capture")
    if output.suffix.lower() != ".mp4":
        raise InputError(f"{output} is not an .mp4: give a name that ends in .mp4")
    if not 1 / RATE <= seconds <= SECONDS_MAX:
        raise InputError(f"a video takes 1/{RATE} to {SECONDS_MAX:g} seconds, not {seconds:g}")
    if not all(16 <= side <= SIDE_MAX and side % 2 == 0 for side in (width, height)):
        raise InputError(
            f"a video cannot have {width}x{height} pixels: both sides must be even, and 16 to "
            f"{SIDE_MAX}"
        )
    codec = next(name for name in CODECS if name in av.codecs_available)
    count = round(RATE * seconds)
    cameras = orbit_cameras(scene, views, count, width=width, height=height, up=up)
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
