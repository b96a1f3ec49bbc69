"""Readers of what a capture on disk has: models, `transforms.json`, photos.

An input of the kinds `colmap` and `transforms` is one byte, which chooses a file of a small valid
capture, and the content of that file. An input of the kind `image` is a photo.
"""

import shutil
import warnings
from pathlib import Path

import numpy as np
from PIL import Image

from fuzz.inputs import seeds
from fuzz.readers import SENTENCE, Reader, Verdict
from mobilegs.data import load_capture, load_view
from mobilegs.data.dataset import Dataset
from mobilegs.data.images import (
    exposure_of,
    has_alpha,
    image_size,
    open_image,
    read_pixels,
)
from mobilegs.data.masks import read_mask
from tests.support.colmap_capture import write_capture_of_noise

COLMAP_FILES = [
    *(f"sparse/0/{noun}.bin" for noun in ("cameras", "images", "points3D", "frames")),
    *(f"sparse/0/{noun}.txt" for noun in ("cameras", "images", "points3D", "frames")),
    "near_plane.txt",
    "capture.json",
]
TRANSFORMS_FILES = ["transforms.json", "transforms_test.json", "points.ply", "capture.json"]
FILES = {"colmap": COLMAP_FILES, "transforms": TRANSFORMS_FILES}
KINDS = ("colmap", "transforms", "image")
PIXELS_MAX = 1 << 20  # larger photos take time and memory by their size, which is not a defect
VIEWS = 9
PANORAMAS = ["wide 1.png", "wide 2.png"]


class CaptureReader(Reader):
    """The reader of a capture, one file of which is the input."""

    sentence_max = 2 * SENTENCE

    def __init__(self, kind: str, folder: Path, seconds: float) -> None:
        super().__init__(kind, folder, seconds)
        self.path, self.folder = folder / "photo.png", folder / "capture"
        if kind != "image":
            write_capture_of_noise(self.folder, views=VIEWS)
        if kind == "transforms":
            shutil.rmtree(self.folder / "sparse")
            for data in reversed(seeds("transforms").values()):
                (self.folder / TRANSFORMS_FILES[data[0]]).write_bytes(data[1:])
            (self.folder / "transforms_test.json").unlink()
            for name in PANORAMAS:
                Image.new("RGB", (16, 8), (90, 120, 30)).save(self.folder / name)

    def opened(self, data: bytes, *, decode: bool) -> tuple[int, Verdict]:
        if self.kind == "image":
            self.path.write_bytes(data)
            with warnings.catch_warnings(action="ignore"):  # Pillow's, of photos that it reads
                return self._refusal(self._read_photo)
        if not data:
            return 0, None
        files = FILES[self.kind]
        path = self.folder / files[data[0] % len(files)]
        before = path.read_bytes() if path.exists() else None
        twin = path.with_suffix(".bin") if path.suffix == ".txt" else path
        hidden = twin.with_suffix(".hidden")
        if twin != path and twin.exists():
            twin.rename(hidden)
        path.write_bytes(data[1:])
        try:
            return self._refusal(self._read_capture)
        finally:
            path.unlink() if before is None else path.write_bytes(before)
            if hidden.exists():
                hidden.rename(twin)

    def _read_capture(self) -> int:
        dataset = load_capture(self.folder)
        _check_numbers(dataset)
        size = 0
        for frame in (*dataset.train[:1], *dataset.test[:1]):
            if frame.camera.width * frame.camera.height <= PIXELS_MAX:
                view = load_view(frame)
                size += view.image.nbytes
                if not view.image.isfinite().all():
                    raise ArithmeticError(f"{frame.name} has pixels that are not finite")
        return size

    def _read_photo(self) -> int:
        width, height = image_size(self.path)
        if width * height > PIXELS_MAX:
            return 0
        has_alpha(self.path)
        with open_image(self.path) as image:
            exposure_of(image)
        size = 0
        for w, h, over in ((width, height, None), (5, 3, (0.1, 0.5, 1.0)), (4, 7, None)):
            w, h = min(w, width), min(h, height)
            pixels, _ = read_pixels(self.path, w, h, over=over)
            if pixels.shape != (h, w, 3) or pixels.dtype != np.uint8:
                raise ArithmeticError(f"pixels have the shape {pixels.shape}")
            size += 16 * width * height
        read_mask(self.path, min(3, width), min(3, height))
        return size


def _check_numbers(dataset: Dataset) -> None:
    cameras = [frame.camera for frame in (*dataset.train, *dataset.test)]
    tensors = [dataset.points, dataset.colors, dataset.center]
    tensors += [matrix for camera in cameras for matrix in (camera.viewmat, camera.K)]
    if not all(bool(tensor.isfinite().all()) for tensor in tensors):
        raise ArithmeticError("the capture has numbers that are not finite")
    if not all(0 < number < float("inf") for number in (dataset.extent, dataset.near)):
        raise ArithmeticError("the extent or the near plane is not a positive number")
    exposures = [frame.exposure for frame in (*dataset.train, *dataset.test)]
    if not all(each is None or abs(each) < float("inf") for each in exposures):
        raise ArithmeticError("an exposure is not a finite number")


def reader_of(kind: str, folder: Path, seconds: float) -> Reader:
    """Return the reader of a kind of file; its files are written to `folder`."""
    return (CaptureReader if kind in KINDS else Reader)(kind, folder, seconds)
