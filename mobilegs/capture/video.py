"""Extracts the sharpest frame of each of many equal intervals of a video."""

import logging
from collections.abc import Iterator
from dataclasses import asdict, replace
from fractions import Fraction
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image

from mobilegs.atomic import file_size, make_folder
from mobilegs.capture.photos import (
    PHOTOS_MIN,
    PreparedPhoto,
    count_colors,
    fitted,
    reduced,
    save_faces,
    save_photo,
)
from mobilegs.data.color import Colors, h273_colors, name_of, sdr_pixels, to_srgb
from mobilegs.errors import InputError
from mobilegs.extras import extra_module
from mobilegs.progress_display import Advance

SUFFIXES = (".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi", ".3gp")
FRAMES_PER_SECOND = 3  # if no number is given
FRAMES_MAX = 240  # if no number is given
SHARPNESS_SIZE = 640  # pixels, longer side: averages noise away, but not motion blur
SHAPE_MAX = 8  # width of a pixel divided by its height, or the inverse: more is damaged
UNSPECIFIED = 2  # matrix of H.273

log = logging.getLogger(__name__)


class Film(NamedTuple):
    """The stream of a video file that is the film.

    Attributes:
        stream: index in the file.
        first, last: times of its first and last frame, seconds.
        shape: width of a pixel divided by its height.
    """

    stream: int
    first: float
    last: float
    shape: Fraction = Fraction(1)


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
    are rotated as the video says, converted to sRGB, with square pixels, and reduced to at most
    `max_size` pixels on the longer side; with `panorama` their faces are written instead. Returns
    the record `{"photos": [PreparedPhoto as a dict, ...], "converted": count_colors}`. Raises
    InputError if the file has no video, or too few frames.
    """
    film = find_film(video)
    first, last = film.first, film.last
    count = frames or max(PHOTOS_MIN, min(FRAMES_MAX, round((last - first) * FRAMES_PER_SECOND)))
    make_folder(folder)
    photos: list[dict[str, Any]] = []
    saved = 0

    def interval_of(frame: Any) -> int:
        return min(count - 1, int((frame.time - first) / max(last - first, 1e-9) * count))

    for interval, frames_of_interval in groupby(decoded(video, film), interval_of):
        progress(interval, count)
        best = max(frames_of_interval, key=lambda frame: sharpness(small_grey(frame)))
        saved += 1
        name, source = f"frame_{saved:04d}.jpg", f"{video.name} at {best.time:.2f} s"
        picture = upright(best, film.shape)
        if panorama:
            faces = save_faces(picture, folder, name, source=video, max_size=max_size)
            made = [replace(face, source=source) for face in faces]
        else:
            picture = reduced(picture, max_size)
            save_photo(picture, folder / name)
            made = [PreparedPhoto(name, source, *picture.size)]
        named = name_of("RGB", frame_colors(best))
        photos += [asdict(replace(photo, colors=named)) for photo in made]
    progress(count, count)
    if saved < PHOTOS_MIN:
        raise InputError(
            f"{video} has only {saved} frames: a scene needs at least {PHOTOS_MIN}, and 30 or "
            "more to look good"
        )
    return {"photos": photos, "converted": count_colors(photos)}


def sharpness(grey: UInt8[np.ndarray, "h w"]) -> float:
    """Return the variance of the Laplacian of a grey image in 0..255; blur lowers it."""
    g = grey.astype(np.float32)
    inside = g[1:-1, 1:-1]
    laplacian = g[:-2, 1:-1] + g[2:, 1:-1] + g[1:-1, :-2] + g[1:-1, 2:] - 4 * inside
    return float(laplacian.var()) if laplacian.size else 0.0


def find_film(video: Path) -> Film:
    """Return the film in a video file, without decoding.

    Attached pictures and thumbnails are none. Of several streams it is the one with the most
    frames, and of those with nearly as many the largest. Raises InputError if the file has no
    video.
    """
    av = library()
    file_size(video)  # raises for a pipe
    try:
        with av.open(str(video)) as container:
            if not container.streams.video:
                raise InputError(f"{video} has no video stream, or is damaged")
            films = [each for each in container.streams.video if not each.disposition & pictures()]
            streams = films or list(container.streams.video)
            times: dict[int, list[float]] = {each.index: [] for each in streams}
            for packet in container.demux(streams):
                if packet.pts is not None and packet.time_base is not None:
                    times[packet.stream_index].append(float(packet.pts * packet.time_base))
            longest = max(len(found) for found in times.values())
            film = max(
                (each for each in streams if len(times[each.index]) >= 0.9 * longest),
                key=lambda each: (each.width * each.height, len(times[each.index])),
            )
            shape = Fraction(film.sample_aspect_ratio or 1)
            index, size = film.index, (film.width, film.height)
    except InputError:
        raise
    except (av.FFmpegError, OSError, ValueError) as error:
        raise InputError(f"{video} cannot be read as a video ({error})") from error
    found = times.pop(index)
    if not found:
        raise InputError(f"{video} has no frames; record it again")
    if any(times.values()):
        log.warning(
            "%s has %d video streams: the one of %dx%d pixels with %d frames is used",
            *(video, len(times) + 1, *size, len(found)),
        )
    if not 1 / SHAPE_MAX <= shape <= SHAPE_MAX:
        log.warning("%s says that its pixels are %s as wide as high: ignored", video, shape)
        shape = Fraction(1)
    if shape != 1:
        width, height = display_size(*size, shape)
        log.warning("%s has pixels that are not square: frames of %dx%d", video, width, height)
    return Film(index, min(found), max(found), shape)


def pictures() -> int:
    """Return the dispositions of streams that are no films."""
    kinds = library().stream.Disposition
    return kinds.attached_pic | kinds.timed_thumbnails | kinds.still_image


def display_size(width: int, height: int, shape: Fraction) -> tuple[int, int]:
    """Return the size at which players show a frame; the side that is too short grows."""
    if shape >= 1:
        return round(width * shape), height
    return width, round(height / shape)


def decoded(video: Path, film: Film) -> Iterator[Any]:
    """Yield the undamaged frames of a video in display order."""
    av = library()
    try:
        with av.open(str(video)) as container:
            stream = container.streams[film.stream]
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


def frame_colors(frame: Any) -> Colors | None:
    """Return the colours that a frame is tagged with; None for sRGB, and if it has no tags."""
    return h273_colors(int(frame.color_primaries or 0), int(frame.color_trc or 0))


def upright(frame: Any, shape: Fraction = Fraction(1)) -> Image.Image:
    """Return a frame as an image in sRGB, at its display size, rotated as the video says.

    `shape` is the width of a pixel divided by its height.
    """
    colors = frame_colors(frame)
    if colors is not None and colors.hdr:
        picture = Image.fromarray(sdr_pixels(hdr_signal(frame), colors))
    else:
        picture = to_srgb(frame.to_image(src_colorspace=matrix_of(frame)), colors)
    if shape != 1:
        size = display_size(*picture.size, shape)
        picture = picture.resize(size, Image.Resampling.LANCZOS)
    turns = {
        90: Image.Transpose.ROTATE_90,
        180: Image.Transpose.ROTATE_180,
        270: Image.Transpose.ROTATE_270,
    }
    turn = turns.get(round(frame.rotation) % 360)
    return picture if turn is None else picture.transpose(turn)


def matrix_of(frame: Any) -> str | None:
    """Return the matrix from YUV to RGB of a frame without a tag, as players choose it.

    It is that of BT.709 from 720 lines or 1280 columns on, else that of BT.601. None if the frame
    says which.
    """
    if int(frame.colorspace) != UNSPECIFIED or frame.format.is_rgb:
        return None
    return "ITU709" if frame.height >= 720 or frame.width >= 1280 else "ITU601"


def hdr_signal(frame: Any) -> Float[np.ndarray, "h w 3"]:
    """Return a frame of HDR, in the YUV of BT.2020, as R'G'B' in [0, 1], not rotated."""
    planes = frame.reformat(format="yuv444p16le").to_ndarray().astype(np.float64)
    if planes.shape[0] != 3:
        planes = np.moveaxis(planes, -1, 0)
    luma, blue, red = planes / (1 << 16)
    if int(frame.color_range or 0) == 2:  # full range
        luma, blue, red = luma, blue - 0.5, red - 0.5
    else:
        luma = (luma - 16 / 256) * 256 / 219
        blue, red = ((chroma - 0.5) * 256 / 224 for chroma in (blue, red))
    return np.stack(
        [luma + 1.4746 * red, luma - 0.164553 * blue - 0.571353 * red, luma + 1.8814 * blue], axis=2
    ).clip(0, 1)


def library() -> Any:
    """Return the module av (PyAV). Raises InputError if it is not installed."""
    return extra_module("av", "reading videos needs PyAV", "capture")
