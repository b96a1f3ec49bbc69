"""Extracts the sharpest frame of each of many equal intervals of a video."""

from collections.abc import Iterator
from dataclasses import asdict, replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from mobilegs.atomic import file_size, make_folder
from mobilegs.capture.hdr import hdr_kind, sdr_pixels
from mobilegs.capture.photos import (
    PHOTOS_MIN,
    PreparedPhoto,
    fitted,
    reduced,
    save_faces,
    save_photo,
)
from mobilegs.errors import InputError
from mobilegs.extras import extra_module
from mobilegs.progress_display import Advance

SUFFIXES = (".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi", ".3gp")
FRAMES_PER_SECOND = 3  # if no number is given
FRAMES_MAX = 240  # if no number is given
SHARPNESS_SIZE = 640  # pixels, longer side: averages noise away, but not motion blur


def is_video(path: Path) -> bool:
    """Return whether `path` is a file with the suffix of a video."""
    return path.suffix.lower() in SUFFIXES and path.is_file()


def prepare_video(
    video: Path,
    folder: Path,
    *,
    frames: int | None,
    max_size: int,
    progress: Advance,
    panorama: bool = False,
) -> dict[str, Any]:
    """Write the sharpest frame of each of `frames` equal intervals of a video to `folder`.

    With `frames` None there are `FRAMES_PER_SECOND` per second and at most `FRAMES_MAX`. Frames
    are rotated as the video says, converted from HDR to sRGB, and reduced to at most `max_size`
    pixels on the longer side; with `panorama` their faces are written instead. Returns the record
    `{"photos": [PreparedPhoto as a dict, ...], "hdr": "HLG", "PQ" or ""}`. Raises InputError if the
    file has no video, or too few frames.
    """
    first, last = time_span(video)
    count = frames or max(PHOTOS_MIN, min(FRAMES_MAX, round((last - first) * FRAMES_PER_SECOND)))
    make_folder(folder)
    photos: list[dict[str, Any]] = []
    saved, kind = 0, ""

    def interval_of(frame: Any) -> int:
        return min(count - 1, int((frame.time - first) / max(last - first, 1e-9) * count))

    for interval, frames_of_interval in groupby(decoded(video), interval_of):
        progress(interval, count)
        best = max(frames_of_interval, key=lambda frame: sharpness(small_grey(frame)))
        saved, kind = saved + 1, kind or hdr_kind(best)
        name, source = f"frame_{saved:04d}.jpg", f"{video.name} at {best.time:.2f} s"
        picture = upright(best)
        if panorama:
            faces = save_faces(picture, folder, name, source=video, max_size=max_size)
            photos += [asdict(replace(face, source=source)) for face in faces]
        else:
            picture = reduced(picture, max_size)
            save_photo(picture, folder / name)
            photos.append(asdict(PreparedPhoto(name, source, *picture.size)))
    progress(count, count)
    if saved < PHOTOS_MIN:
        raise InputError(
            f"{video} has only {saved} frames: a scene needs at least {PHOTOS_MIN}, and 30 or "
            "more to look good"
        )
    return {"photos": photos, "hdr": kind}


def sharpness(grey: UInt8[np.ndarray, "h w"]) -> float:
    """Return the variance of the Laplacian of a grey image in 0..255; blur lowers it."""
    g = grey.astype(np.float32)
    inside = g[1:-1, 1:-1]
    laplacian = g[:-2, 1:-1] + g[2:, 1:-1] + g[1:-1, :-2] + g[1:-1, 2:] - 4 * inside
    return float(laplacian.var()) if laplacian.size else 0.0


def time_span(video: Path) -> tuple[float, float]:
    """Return the times of the first and last frame in seconds, without decoding.

    Raises InputError if the file has no video.
    """
    av = library()
    file_size(video)  # raises for a pipe
    try:
        with av.open(str(video)) as container:
            if not container.streams.video:
                raise InputError(f"{video} has no video stream, or is damaged")
            times = [
                float(packet.pts * packet.time_base)
                for packet in container.demux(container.streams.video[0])
                if packet.pts is not None and packet.time_base is not None
            ]
    except InputError:
        raise
    except (av.FFmpegError, OSError, ValueError) as error:
        raise InputError(f"{video} cannot be read as a video ({error})") from error
    if not times:
        raise InputError(f"{video} has no frames; record it again")
    return min(times), max(times)


def decoded(video: Path) -> Iterator[Any]:
    """Yield the undamaged frames of a video in display order."""
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
    """Return a frame in grey, reduced to `SHARPNESS_SIZE`."""
    width, height = fitted(frame.width, frame.height, SHARPNESS_SIZE)
    return frame.reformat(width=width, height=height, format="gray").to_ndarray()


def upright(frame: Any) -> Image.Image:
    """Return a frame as an image in sRGB, rotated as the video says."""
    picture = Image.fromarray(sdr_pixels(frame)) if hdr_kind(frame) else frame.to_image()
    turns = {
        90: Image.Transpose.ROTATE_90,
        180: Image.Transpose.ROTATE_180,
        270: Image.Transpose.ROTATE_270,
    }
    turn = turns.get(round(frame.rotation) % 360)
    return picture if turn is None else picture.transpose(turn)


def library() -> Any:
    """Return the module av (PyAV). Raises InputError if it is not installed."""
    return extra_module("av", "reading videos needs PyAV", "capture")
