"""A video -> its sharpest frames, one from each of many equal parts of its time."""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from mobilegs.atomic import make_folder
from mobilegs.capture.engine import INSTALL, Progress
from mobilegs.capture.photos import FEWEST, Prepared, fitted, reduced, save_photo
from mobilegs.errors import InputError

SUFFIXES = (".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi", ".3gp")
PER_SECOND = 3  # frames taken unless a number is asked for
MOST = 240
SHARPNESS_SIZE = 640  # pixels, longer side: noise is averaged away, motion blur is not


def is_video(path: Path) -> bool:
    """Whether `path` is a file whose name is a video's."""
    return path.suffix.lower() in SUFFIXES and path.is_file()


def prepare_video(
    video: Path, folder: Path, *, frames: int | None, max_size: int, progress: Progress
) -> dict[str, Any]:
    """Write the sharpest frame of each of `frames` equal parts of a video's time into `folder`.

    Without a number, `PER_SECOND` a second and at most `MOST`. Frames are turned as players turn
    them, and at most `max_size` pixels long. Returns the record `{"photos": [Prepared, ...]}`.
    Raises InputError if there is no video in the file, or too little of it.
    """
    first, last = time_span(video)
    count = frames or max(FEWEST, min(MOST, round((last - first) * PER_SECOND)))
    make_folder(folder)
    found: list[dict[str, Any]] = []
    current, sharpest, best = -1, -1.0, None

    def take() -> None:
        if best is not None:
            name = f"frame_{len(found) + 1:04d}.jpg"
            picture = reduced(upright(best), max_size)
            save_photo(picture, folder / name)
            source = f"{video.name} at {best.time:.2f} s"
            found.append(asdict(Prepared(name, source, *picture.size)))

    for frame in decoded(video):
        part = min(count - 1, int((frame.time - first) / max(last - first, 1e-9) * count))
        if part > current:
            take()
            current, sharpest, best = part, -1.0, None
            progress(part, count)
        value = sharpness(small_grey(frame))
        if value > sharpest:
            sharpest, best = value, frame
    take()
    progress(count, count)
    if len(found) < FEWEST:
        raise InputError(
            f"{video} has {len(found)} frames to choose from: a scene needs {FEWEST} at least, and "
            "30 or more to look good"
        )
    return {"photos": found}


def sharpness(grey: UInt8[np.ndarray, "h w"]) -> float:
    """Variance of the Laplacian of a grey picture in 0..255: blur takes it away."""
    g = grey.astype(np.float32)
    inside = g[1:-1, 1:-1]
    laplacian = g[:-2, 1:-1] + g[2:, 1:-1] + g[1:-1, :-2] + g[1:-1, 2:] - 4 * inside
    return float(laplacian.var()) if laplacian.size else 0.0


def time_span(video: Path) -> tuple[float, float]:
    """Seconds at which the first and the last frame are shown, found without decoding any."""
    av = library()
    try:
        with av.open(str(video)) as container:
            if not container.streams.video:
                raise InputError(f"{video} has no video in it, or is damaged")
            times = [
                float(packet.pts * packet.time_base)
                for packet in container.demux(container.streams.video[0])
                if packet.pts is not None and packet.time_base is not None
            ]
    except (av.FFmpegError, OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{video} cannot be read as a video ({error})") from error
    if not times:
        raise InputError(f"{video} has no frames: record it again")
    return min(times), max(times)


def decoded(video: Path) -> Iterator[Any]:
    """The frames of a video in the order in which they are shown, without damaged ones."""
    av = library()
    try:
        with av.open(str(video)) as container:
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            for frame in container.decode(stream):
                if frame.time is not None and not frame.is_corrupt:
                    yield frame
    except av.FFmpegError as error:
        raise InputError(f"{video} cannot be decoded ({error})") from error


def small_grey(frame: Any) -> UInt8[np.ndarray, "h w"]:
    """A frame's brightness at the size at which sharpness is measured."""
    width, height = fitted(frame.width, frame.height, SHARPNESS_SIZE)
    return frame.reformat(width=width, height=height, format="gray").to_ndarray()


def upright(frame: Any) -> Image.Image:
    """A frame as a picture, turned as the video says."""
    picture = frame.to_image()
    turns = {
        90: Image.Transpose.ROTATE_90,
        180: Image.Transpose.ROTATE_180,
        270: Image.Transpose.ROTATE_270,
    }
    turn = turns.get(round(frame.rotation) % 360)
    return picture if turn is None else picture.transpose(turn)


def library() -> Any:
    """The module av; InputError with one sentence where it is missing."""
    try:
        import av
    except ImportError:
        raise InputError(f"reading a video needs PyAV, which is not installed: {INSTALL}") from None
    return av
