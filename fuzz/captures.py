"""Seeds, mutations and readers of what a capture on disk has: models, `transforms.json`, photos.

An input of the kinds `colmap` and `transforms` is one byte, which chooses a file of a small valid
capture, and the content of that file. An input of the kind `image` is a photo.
"""

import io
import json
import random
import shutil
import struct
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from PIL import Image

from mobilegs.data import load_capture, load_view
from mobilegs.data.dataset import Dataset
from mobilegs.data.images import (
    exposure_of,
    has_alpha,
    image_size,
    open_image,
    read_mask,
    read_pixels,
)
from mobilegs.errors import InputError
from tests.fuzz.mutate_formats import mutated_json
from tests.fuzz.mutate_plain import damaged, mutated_ply
from tests.fuzz.readers import SENTENCE, UNPRINTABLE, Reader, Verdict
from tests.fuzz.seeds import Seed, ply
from tests.support.colmap_capture import (
    PINHOLE,
    POINTS,
    Camera,
    cameras_bin,
    cameras_txt,
    frames_bin,
    frames_txt,
    images_bin,
    images_txt,
    points_bin,
    points_txt,
    random_poses,
    write_capture_of_noise,
)

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
SPECIAL = [
    *(struct.pack("<d", x) for x in (0.0, -1.0, 1e-320, 1e30, 1e300, float("nan"), float("inf"))),
    *(struct.pack("<Q", n) for n in (0, 1, 7, 1 << 16, 1 << 31, 1 << 62, (1 << 64) - 1)),
]


# --- seeds


def _of(kind: str, contents: Iterable[tuple[str, bytes]]) -> dict[str, Seed]:
    files = FILES[kind]
    return {
        f"{number} {name}": Seed(bytes([files.index(name)]) + content)
        for number, (name, content) in enumerate(contents)
    }


def colmap_seeds() -> dict[str, Seed]:
    """Return every file of a model, binary and text, with cameras of every lens model."""
    poses, moments = random_poses(VIEWS), [[0, 1], [2, 3, 4], [5]]
    lenses: list[Camera] = [
        (1, 0, 12, 8, (10.0, 6.0, 4.0)),
        PINHOLE,
        (1, 3, 12, 8, (10.0, 6.0, 4.0, 0.1, -0.02)),
        (1, 4, 12, 8, (10.0, 11.0, 6.0, 4.0, 0.1, -0.1, 0.01, 0.02)),
        (1, 5, 12, 8, (10.0, 11.0, 6.0, 4.0, 0.1, -0.1, 0.01, 0.02)),
        (1, 6, 12, 8, (10.0, 11.0, 6.0, 4.0, 0.1, 0.0, 0.01, 0.02, 0.0, 0.1, 0.0, 0.0)),
        (1, 7, 12, 8, (10.0, 11.0, 6.0, 4.0, 0.9)),
        (1, 10, 12, 8, (10.0, 11.0, 6.0, 4.0, *[0.01] * 8)),
        (1, 11, 12, 8, (10.0, 11.0, 6.0, 4.0, *[0.01] * 12)),
        (1, 14, 12, 8, (10.0, 6.0, 4.0)),
        (1, 15, 12, 8, (10.0, 11.0, 6.0, 4.0)),
        (1, 17, 12, 8, (12.0, 8.0)),
    ]
    contents = [("sparse/0/cameras.bin", cameras_bin(lens)) for lens in lenses]
    contents += [("sparse/0/cameras.txt", cameras_txt(lens)) for lens in lenses[2:8]]
    # georeferenced: far from the origin, and near each other
    far = [
        (name, (1.0, 0.0, 0.0, 0.0, -4e5 - i, -5e6, 0.0), 1) for i, (name, *_) in enumerate(poses)
    ]
    contents += [
        ("sparse/0/images.bin", images_bin(poses, 2)),
        ("sparse/0/images.bin", images_bin(far)),
        ("sparse/0/images.txt", images_txt(poses, "1.0 2.0 -1 4 5 6")),
        ("sparse/0/points3D.bin", points_bin(POINTS)),
        ("sparse/0/points3D.txt", points_txt(POINTS)),
        ("sparse/0/frames.bin", frames_bin(moments)),
        ("sparse/0/frames.txt", frames_txt(moments)),
        ("near_plane.txt", b"0.0125\n"),
        ("capture.json", _made_from(poses[0][0])),
    ]
    return _of("colmap", contents)


def _made_from(name: str) -> bytes:
    return json.dumps({"source": "a/b.mov", "exposures": {name: -3.5}}).encode()


def transforms(names: list[str], **fields: object) -> bytes:
    """Return a `transforms.json` of photos whose cameras stand side by side."""
    frames = [
        {"file_path": name, "transform_matrix": _standing_at(0.5 * i)}
        for i, name in enumerate(names)
    ]
    return json.dumps({"fl_x": 10.0, "cx": 6.0, "cy": 4.0, **fields, "frames": frames}).encode()


def _standing_at(x: float) -> list[list[float]]:
    return [[1, 0, 0, x], [0, 0, -1, 0.1], [0, 1, 0, 0.2], [0, 0, 0, 1]]


def transforms_seeds() -> dict[str, Seed]:
    """Return transforms of all camera models, with masks, lists of photos and points."""
    names = [f"images/p{i:02d}.png" for i in range(3)]
    lists = {"train_filenames": names[:2], "test_filenames": names[2:]}
    fields: list[dict[str, object]] = [
        {},
        {"camera_model": "OPENCV", "k1": 0.1, "p1": 0.01, "w": 12, "h": 8, "fl_y": 11.0},
        {"camera_model": "OPENCV_FISHEYE", "k1": 0.1, "k4": 0.01},
        {"is_fisheye": True, "k2": -0.1},
        {"mask_path": "images/p03.png", "applied_transform": _standing_at(0.0)[:3]},
        {"camera_angle_x": 0.8, "camera_angle_y": 0.5},
        {"ply_file_path": "points.ply", **lists},
    ]
    little, columns = "binary_little_endian", "x y z red green blue".split()
    colored = ("double", "double", "double", "uchar", "uchar", "uchar")
    contents = [("transforms.json", transforms(names, **each)) for each in fields]
    contents += [
        ("transforms.json", transforms(PANORAMAS, camera_model="EQUIRECTANGULAR")),
        ("transforms.json", transforms([name.replace("/", "\\") for name in names])),
        ("points.ply", ply("ascii", columns).replace(b"\n", b"\r\n")),
        ("transforms_test.json", transforms(names[1:])),
        ("points.ply", ply(little, columns, types=colored)),
        ("points.ply", ply("ascii", columns)),
        ("points.ply", ply("binary_big_endian", ["x", "y", "z"], types=("double",))),
        ("capture.json", _made_from("p00.png")),
    ]
    return _of("transforms", contents)


def image_seeds() -> dict[str, Seed]:
    """Return small photos of every kind of file, mode and compression that a capture may have."""
    r = np.random.default_rng(0)
    color = Image.fromarray(r.integers(0, 256, (7, 9, 4), dtype=np.uint8))
    grey16 = Image.fromarray(r.integers(0, 65536, (7, 9), dtype=np.uint16))
    exif = Image.Exif()
    exif.get_ifd(0x8769).update({0x829A: (1, 50), 0x829D: (28, 10), 0x8827: 200})
    ways: list[tuple[Image.Image, str, dict[str, object]]] = [
        (color.convert("RGB"), "JPEG", {"exif": exif}),
        (color.convert("L"), "JPEG", {"progressive": True}),
        (color.convert("RGB").convert("CMYK"), "JPEG", {}),
        *((color.convert(mode), "PNG", {}) for mode in ("RGBA", "RGB", "LA", "L", "P", "1")),
        (color.convert("P"), "PNG", {"transparency": 3}),
        (grey16, "PNG", {}),
        (color, "WEBP", {"lossless": True}),
        (color.convert("RGB"), "WEBP", {"exif": exif}),
        *((color.convert(mode), "BMP", {}) for mode in ("RGB", "RGBA", "P", "1")),
        (color, "TIFF", {}),
        (color.convert("RGB"), "TIFF", {"compression": "tiff_lzw"}),
        (color.convert("RGB"), "TIFF", {"compression": "tiff_adobe_deflate"}),
        (grey16, "TIFF", {}),
        (color.convert("RGB"), "AVIF", {}),
    ]
    files = {}
    for number, (image, kind, options) in enumerate(ways):
        out = io.BytesIO()
        image.save(out, kind, **options)
        files[f"{number} {kind}"] = Seed(out.getvalue())
    return files


SEEDS: dict[str, Callable[[], dict[str, Seed]]] = {
    "colmap": colmap_seeds,
    "transforms": transforms_seeds,
    "image": image_seeds,
}


# --- mutations


def mutated(kind: str, r: random.Random, data: bytes) -> bytes:
    """Return an input that differs from `data`, with knowledge of its format."""
    if kind == "image":
        return _mutated_png(r, data) if data[:8] == PNG else damaged(r, data)
    if not data:
        return b"\0"
    content = data[1:]
    name = FILES[kind][data[0] % len(FILES[kind])]
    if name.endswith(".json"):
        content = mutated_json(r, content)
    elif name.endswith(".ply"):
        content = mutated_ply(r, content, [])
    elif name.endswith(".bin") and len(content) > 16 and r.random() < 0.6:
        at = r.randrange(len(content) - 8)
        content = content[:at] + r.choice(SPECIAL) + content[at + 8 :]
    elif name.endswith(".txt") and r.random() < 0.6:
        words = content.split(b" ")
        words[r.randrange(len(words))] = r.choice([b"nan", b"-1", b"1e300", b"0", b"", b"9" * 30])
        content = b" ".join(words)
    else:
        content = damaged(r, content)
    return data[:1] + content


PNG = b"\x89PNG\r\n\x1a\n"


def _mutated_png(r: random.Random, data: bytes) -> bytes:
    """Change a chunk of a PNG and give it a valid checksum."""
    chunks, at = [], len(PNG)
    while at + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, at)
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + length]))
        at += 12 + length
    if not chunks:
        return damaged(r, data)
    i = r.randrange(len(chunks))
    name, content = chunks[i]
    if name == b"IDAT" and r.random() < 0.5:
        try:
            content = zlib.compress(damaged(r, zlib.decompress(content)))
        except zlib.error:
            content = damaged(r, content)
    else:
        content = damaged(r, content)
    chunks[i] = (r.choice([name] * 9 + [b"tRNS", b"eXIf", b"acTL"]), content)
    if r.random() < 0.1:
        chunks.insert(i, chunks[r.randrange(len(chunks))])
    return PNG + b"".join(
        struct.pack(">I", len(content))
        + name
        + content
        + struct.pack(">I", zlib.crc32(name + content))
        for name, content in chunks
    )


# --- readers


class CaptureReader(Reader):
    """The reader of a capture, one file of which is the input."""

    def __init__(self, kind: str, folder: Path, seconds: float) -> None:
        super().__init__(kind, folder / "photo.png", seconds)
        self.folder = folder / "capture"
        if kind != "image":
            write_capture_of_noise(self.folder, views=VIEWS)
        if kind == "transforms":
            shutil.rmtree(self.folder / "sparse")
            for seed in reversed(transforms_seeds().values()):
                (self.folder / TRANSFORMS_FILES[seed.data[0]]).write_bytes(seed.data[1:])
            (self.folder / "transforms_test.json").unlink()
            for name in PANORAMAS:
                Image.new("RGB", (16, 8), (90, 120, 30)).save(self.folder / name)

    def opened(self, data: bytes, *, decode: bool) -> tuple[int, Verdict]:
        if self.kind == "image":
            self.path.write_bytes(data)
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

    def _refusal(self, read: Callable[[], int]) -> tuple[int, Verdict]:
        try:
            return read(), None
        except InputError as error:
            sentence = str(error).replace(str(self.path.parent), "")
            if 0 < len(sentence) <= 2 * SENTENCE and not UNPRINTABLE.search(sentence):
                return 0, sentence
            return 0, {"error": f"is not refused with one plain sentence: {sentence[:200]!r}"}
        except Exception as error:
            return 0, {"error": f"{type(error).__name__}: {error}", "where": place_of(error)}

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


def place_of(error: BaseException) -> str:
    """Return file and line of the last frame of an exception's traceback that is ours."""
    found, trace = "", error.__traceback__
    while trace is not None:
        code = trace.tb_frame.f_code
        if "mobilegs" in code.co_filename and "site-packages" not in code.co_filename:
            found = f"{Path(code.co_filename).name}:{trace.tb_lineno}"
        trace = trace.tb_next
    return found
