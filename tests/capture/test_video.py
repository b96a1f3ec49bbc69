"""Frames of videos: selection, rotation, and errors for invalid videos."""

import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mobilegs.capture import CaptureRun, capture_photos, is_capture_source
from mobilegs.capture.video import decoded, find_film, prepare_video, upright
from mobilegs.errors import InputError
from tests.support.layered_photos import blurred, layered_photo

av = pytest.importorskip("av", reason="needs the extra capture")

RATE = 10  # frames per second


def write_video(
    path: Path,
    frames: list[Image.Image],
    *,
    rotation: int = 0,
    shape: Fraction = Fraction(1),
) -> Path:
    """Write a video with `RATE` frames per second, which players rotate counterclockwise."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=RATE, bit_rate=8_000_000)
        stream.width, stream.height = frames[0].size
        stream.pix_fmt = "yuv420p"
        stream.codec_context.sample_aspect_ratio = shape
        if rotation:
            stream.set_display_rotation(rotation)
        for frame in frames:
            container.mux(stream.encode(av.VideoFrame.from_image(frame)))
        container.mux(stream.encode())
    return path


def no_progress(done: int, total: int) -> None:
    pass


def test_the_sharpest_frame_of_each_interval_is_taken(tmp_path: Path) -> None:
    sharp = {2, 9, 10, 17}  # of 20: one in each quarter
    frames = [
        photo if index in sharp else blurred(photo, 1.5 + index % 3)
        for index in range(20)
        for photo in [layered_photo((0.02 * index, 0))]
    ]
    video = write_video(tmp_path / "video.mp4", frames)
    film = find_film(video)
    assert (film.stream, film.first, film.last, film.shape) == (0, 0.0, 1.9, 1)
    found = prepare_video(video, tmp_path / "out", frames=4, max_size=120, progress=no_progress)
    taken = [photo["source"] for photo in found["photos"]]
    assert taken == [f"video.mp4 at {index / RATE:.2f} s" for index in sorted(sharp)]
    names = [f"frame_{number:04d}.jpg" for number in (1, 2, 3, 4)]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == names
    with Image.open(tmp_path / "out" / names[0]) as picture:
        assert picture.size == (120, 90)


def test_frames_are_rotated_as_the_video_says(tmp_path: Path) -> None:
    photo = layered_photo((0, 0))
    for rotation, turn in ((90, Image.Transpose.ROTATE_90), (180, Image.Transpose.ROTATE_180)):
        video = write_video(tmp_path / f"{rotation}.mp4", [photo] * 4, rotation=rotation)
        with av.open(str(video)) as container:
            picture = upright(next(container.decode(video=0)))
        expected = photo.transpose(turn)
        assert picture.size == expected.size
        errors = np.asarray(picture, float) - np.asarray(expected, float)
        assert np.abs(errors).mean() < 12


def film_of(path: Path) -> Image.Image:
    film = find_film(path)
    return upright(next(decoded(path, film)), film.shape)


@pytest.mark.parametrize(
    ("size", "shape", "rotation", "shown"),
    [
        ((96, 72), Fraction(4, 3), 0, (128, 72)),  # as HDV and AVCHD
        ((72, 48), Fraction(8, 9), 0, (72, 54)),  # as DV of 60 Hz
        ((96, 72), Fraction(4, 3), 90, (72, 128)),
        ((96, 72), Fraction(10, 1), 0, (96, 72)),  # damaged
    ],
)
def test_frames_have_their_display_size(
    size: tuple[int, int],
    shape: Fraction,
    rotation: int,
    shown: tuple[int, int],
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    photo = layered_photo((0, 0)).resize(size)
    video = write_video(tmp_path / "video.mp4", [photo] * 3, rotation=rotation, shape=shape)
    assert film_of(video).size == shown
    assert "pixels" in caplog.text


@pytest.mark.parametrize("cover", [True, False])
def test_the_film_is_not_the_cover(
    cover: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    video = tmp_path / "video.mp4"
    with av.open(str(video), "w") as container:
        streams = []
        for size in ((320, 240), (96, 72)):
            stream = container.add_stream("mjpeg" if size[0] == 320 else "mpeg4", rate=RATE)
            stream.width, stream.height = size
            stream.pix_fmt = "yuvj420p" if size[0] == 320 else "yuv420p"
            streams.append(stream)
        if cover:
            streams[0].disposition = av.stream.Disposition.attached_pic
        for number, stream in zip((1, 6), streams, strict=True):
            picture = Image.new("RGB", (stream.width, stream.height), (90, 90, 90))
            for _ in range(number):
                container.mux(stream.encode(av.VideoFrame.from_image(picture)))
            container.mux(stream.encode())
    assert film_of(video).size == (96, 72)
    record = prepare_video(video, tmp_path / "out", frames=3, max_size=200, progress=no_progress)
    assert len(record["photos"]) == 3 and record["converted"] == {}
    assert cover or "the one of 96x72 pixels with 6 frames is used" in caplog.text


RED = (200, 40, 60)


@pytest.mark.parametrize(
    ("size", "matrix", "tag", "color_range"),
    [
        ((1280, 720), "ITU709", 2, 1),
        ((406, 720), "ITU709", 2, 1),
        ((640, 480), "ITU601", 2, 1),
        ((640, 480), "ITU709", 1, 1),
        ((1280, 720), "ITU601", 6, 1),
        ((1280, 720), "ITU709", 2, 2),
    ],
)
def test_frames_have_the_matrix_and_the_range_of_players(
    size: tuple[int, int], matrix: str, tag: int, color_range: int
) -> None:
    frame = av.VideoFrame.from_image(Image.new("RGB", size, RED))
    frame = frame.reformat(format="yuv444p", dst_colorspace=matrix, dst_color_range=color_range)
    frame.colorspace, frame.color_range = tag, color_range
    frame.color_primaries = frame.color_trc = 2
    assert np.abs(np.asarray(upright(frame), int) - RED).max() <= 3


def test_frames_without_hdr_have_the_primaries_of_their_tags() -> None:
    frame = av.VideoFrame.from_image(Image.new("RGB", (64, 48), (207, 74, 34)))
    frame = frame.reformat(format="yuv444p", dst_colorspace="BT2020")
    frame.colorspace, frame.color_primaries, frame.color_trc = 9, 9, 14
    assert np.abs(np.asarray(upright(frame), int) - (255, 0, 0)).max() <= 5


@pytest.mark.thorough
def test_a_video_becomes_a_capture(tmp_path: Path) -> None:
    pytest.importorskip("pycolmap", reason="needs the extra capture")
    frames = [
        blurred(layered_photo((0.05 * index - 0.4, 0.01 * (index % 3))), index % 2 * 3)
        for index in range(16)
    ]
    video = write_video(tmp_path / "walk.mp4", frames)
    assert is_capture_source(video)
    report = capture_photos(CaptureRun(video, tmp_path / "capture", frames=8))
    assert (report["source"], report["photos"]) == ("walk.mp4", 8)
    assert report["registered"] == 8


def test_frames_of_a_panorama_video_become_faces(tmp_path: Path) -> None:
    frames = [photo.resize((128, 64)) for photo in [layered_photo((0, 0))] * 4]
    video = write_video(tmp_path / "sphere.mp4", frames)
    found = prepare_video(
        video, tmp_path / "out", frames=3, max_size=100, panorama=True, progress=no_progress
    )
    assert len(found["photos"]) == 18 and found["photos"][0]["name"] == "front/frame_0001.jpg"
    assert len({photo["source"] for photo in found["photos"]}) == 3
    with Image.open(tmp_path / "out/down/frame_0003.jpg") as face:
        assert face.size == (32, 32)
    with pytest.raises(InputError, match=r"flat\.mp4 is 240x180 pixels"):
        flat = write_video(tmp_path / "flat.mp4", [layered_photo((0, 0))] * 4)
        prepare_video(
            flat, tmp_path / "b", frames=3, max_size=9, panorama=True, progress=no_progress
        )
    with pytest.raises(InputError, match="--rig needs a folder per camera"):
        capture_photos(CaptureRun(video, tmp_path / "c", rig=True))


def test_invalid_videos_raise_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def error_of(path: Path) -> str:
        with pytest.raises(InputError) as caught:
            capture_photos(CaptureRun(path, tmp_path / path.stem))
        return str(caught.value)

    (tmp_path / "damaged.mp4").write_bytes(b"not a video")
    assert "damaged.mp4 cannot be read as a video" in error_of(tmp_path / "damaged.mp4")
    sound = tmp_path / "sound.mkv"
    with av.open(str(sound), "w") as container:
        stream = container.add_stream("pcm_s16le", rate=8000, layout="mono")
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 800), np.int16), layout="mono")
        frame.rate = 8000
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    assert "no video stream" in error_of(sound)
    short = write_video(tmp_path / "short.mp4", [layered_photo((0, 0))] * 2)
    assert "only 2 frames" in error_of(short)
    whole = write_video(tmp_path / "whole.mp4", [layered_photo((0, 0))] * 9).read_bytes()
    (tmp_path / "cut.mp4").write_bytes(whole[: len(whole) // 2])
    assert "cut.mp4" in error_of(tmp_path / "cut.mp4")
    monkeypatch.setitem(sys.modules, "av", None)
    assert "pip install 'mobilegs[capture]'" in error_of(tmp_path / "cut.mp4")
