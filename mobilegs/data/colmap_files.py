"""Reads the files of a COLMAP model, binary or text: cameras, images, points3D, frames.

The layouts are those of https://colmap.github.io/format.html. The bytes are not trusted: every
count is compared with the size of the file before memory is allocated.
"""

import math
import re
import struct
from collections.abc import Container, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, UInt8

from mobilegs.atomic import FILE_MAX, open_input, read_input, read_text
from mobilegs.data.distortion import Distortion
from mobilegs.data.pinhole_views import EQUIRECTANGULAR, sphere_intrinsics
from mobilegs.errors import InputError, quoted

MODELS = {  # id: (name, number of parameters)
    0: ("SIMPLE_PINHOLE", 3),
    1: ("PINHOLE", 4),
    2: ("SIMPLE_RADIAL", 4),
    3: ("RADIAL", 5),
    4: ("OPENCV", 8),
    5: ("OPENCV_FISHEYE", 8),
    6: ("FULL_OPENCV", 12),
    7: ("FOV", 5),
    8: ("SIMPLE_RADIAL_FISHEYE", 4),
    9: ("RADIAL_FISHEYE", 5),
    10: ("THIN_PRISM_FISHEYE", 12),
    11: ("RAD_TAN_THIN_PRISM_FISHEYE", 16),
    12: ("SIMPLE_DIVISION", 4),
    13: ("DIVISION", 5),
    14: ("SIMPLE_FISHEYE", 3),
    15: ("FISHEYE", 4),
    16: ("EUCM", 6),
    17: ("EQUIRECTANGULAR", 2),
}
ONE_FOCAL_LENGTH = (
    "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "SIMPLE_FISHEYE", "SIMPLE_RADIAL_FISHEYE",
    "RADIAL_FISHEYE",
)  # fmt: skip
OTHER_NAMES = {
    "PERSPECTIVE": "PINHOLE",  # nerfstudio, OpenSfM
    "FRAME": "PINHOLE",  # Metashape
    "BROWN": "OPENCV",  # OpenSfM
    "RADTAN": "OPENCV",  # Kalibr
    "FISHEYEOPENCV": "OPENCV_FISHEYE",  # OpenSfM
    "KANNALABRANDT": "OPENCV_FISHEYE",
    "KB4": "OPENCV_FISHEYE",
    "SPHERICAL": "EQUIRECTANGULAR",  # Metashape, OpenSfM
}
SPELLINGS = {name.replace("_", ""): name for name, _ in MODELS.values()} | OTHER_NAMES
CAMERA_SENSOR = 0  # type of a rig's sensor; others are no cameras
SIDE_MAX = 1 << 16  # pixels


class ColmapCamera(NamedTuple):
    """A camera: size in pixels, (fx, fy, cx, cy) in pixels, and lens distortion."""

    width: int
    height: int
    intrinsics: tuple[float, float, float, float]
    distortion: Distortion


class ColmapImage(NamedTuple):
    """A registered photo: world-to-camera rotation (quaternion wxyz) and translation."""

    number: int
    name: str
    camera_id: int
    quat: tuple[float, ...]
    translation: tuple[float, ...]


class ColmapPoints(NamedTuple):
    """Sparse points: `xyz [m, 3]` in world units, `rgb [m, 3]` in 0..255."""

    xyz: Float[np.ndarray, "m 3"]
    rgb: UInt8[np.ndarray, "m 3"]


@dataclass
class _BinaryReader:
    """A binary file that is read from front to back."""

    path: Path
    data: bytes
    offset: int = 0

    @classmethod
    def of(cls, path: Path) -> "_BinaryReader":
        return cls(path, read_input(path))

    @property
    def left(self) -> int:
        return len(self.data) - self.offset

    def take(self, layout: struct.Struct) -> tuple:
        if self.left < layout.size:
            raise self.damaged(f"ends at byte {len(self.data)} in the middle of a record")
        values = layout.unpack_from(self.data, self.offset)
        self.offset += layout.size
        return values

    def count(self, smallest: int, noun: str) -> int:
        """Read a number of records, which must fit in the file at `smallest` bytes each or more."""
        (count,) = self.take(_COUNT)
        if count * smallest > self.left:
            raise self.damaged(
                f"announces {count} {noun} at byte {self.offset - 8}, "
                f"but only {self.left} bytes follow"
            )
        return count

    def finish(self) -> None:
        if self.left:
            raise self.damaged(f"has {self.left} bytes after its last record")

    def damaged(self, what: str) -> InputError:
        return InputError(f"{self.path} {what}; copy it again or rebuild the model")


_COUNT = struct.Struct("<Q")
_CAMERA = struct.Struct("<IiQQ")
_IMAGE = struct.Struct("<I7dI")
_FRAME = struct.Struct("<2I7dI")
_DATUM = struct.Struct("<iIQ")
_OBSERVATION_BYTES = 24
_POINT = np.dtype(
    [("id", "<u8"), ("xyz", "<f8", 3), ("rgb", "u1", 3), ("error", "<f8"), ("track", "<u8")]
)  # packed, 51 bytes


def lens_model(name: str) -> str:
    """Return COLMAP's name of a lens model that another program spells its own way.

    A name that is not known is returned as it is.
    """
    plain = re.sub(r"[^A-Z0-9]", "", name.upper().rpartition(".")[2])
    known = MODELS.get(int(plain)) if re.fullmatch("[0-9]{1,2}", plain) else None
    return known[0] if known else SPELLINGS.get(plain, name)


def read_cameras(path: Path, used: Container[int] | None = None) -> dict[int, ColmapCamera]:
    """Read `cameras.bin` or `cameras.txt` into cameras by id: those of `used`, or all.

    Raises `InputError` for a damaged file, and for a lens model that is not supported.
    """
    cameras = {}
    lengths = dict(MODELS.values())
    for number, model, width, height, parameters in (
        _binary_cameras(path) if path.suffix == ".bin" else _text_cameras(path)
    ):
        if used is not None and number not in used:
            continue
        where = f"{path}: camera {number}"
        if model not in lengths:
            raise InputError(
                f"{where} has the unknown lens model {quoted(model)}; "
                "export with SIMPLE_PINHOLE, PINHOLE or OPENCV cameras"
            )
        if len(parameters) != lengths[model]:
            raise InputError(
                f"{where} has {len(parameters)} parameters instead of the {lengths[model]} of "
                f"{model}; copy or export it again"
            )
        if not (0 < width <= SIDE_MAX and 0 < height <= SIDE_MAX):
            raise InputError(f"{where} has an impossible size of {width}x{height} pixels")
        cameras[number] = _camera(where, model, width, height, parameters)
    return cameras


def read_images(path: Path) -> list[ColmapImage]:
    """Read the registered photos of `images.bin` or `images.txt`, without 2D observations.

    Raises `InputError` for a damaged file.
    """
    images = list(_binary_images(path) if path.suffix == ".bin" else _text_images(path))
    for image in images:
        if not image.name.isprintable() or not image.name:
            raise InputError(
                f"{path} has the file name {quoted(image.name)}, which is empty or not printable"
            )
        if not np.isfinite([*image.quat, *image.translation]).all() or not any(image.quat):
            raise InputError(f"{path}: the pose of {image.name} is not finite, or has no rotation")
    return images


def count_images(path: Path) -> int:
    """Return the number of photos in `images.bin` or `images.txt`; 0 for a damaged file."""
    try:
        if path.suffix == ".txt":
            return len(read_images(path))
        with open_input(path) as file:
            return _COUNT.unpack(file.read(_COUNT.size))[0]
    except (InputError, OSError, struct.error):
        return 0


def read_moments(path: Path) -> list[list[int]]:
    """Read the numbers of the images that a rig of cameras took at each moment.

    COLMAP calls a moment a frame: `frames.bin` or `frames.txt`. Poses are not read: `images` has
    them, too. Raises `InputError` for a damaged file.
    """
    return list(_binary_moments(path) if path.suffix == ".bin" else _text_moments(path))


def read_points(path: Path) -> ColmapPoints:
    """Read `points3D.bin` or `points3D.txt`. Raises `InputError` for a damaged file."""
    return _binary_points(path) if path.suffix == ".bin" else _text_points(path)


def _camera(
    where: str, model: str, width: int, height: int, parameters: tuple[float, ...]
) -> ColmapCamera:
    if not np.isfinite(parameters).all():
        raise InputError(f"{where} has parameters that are not finite numbers")
    if model in ONE_FOCAL_LENGTH:
        parameters = (parameters[0], *parameters)
    intrinsics, p = parameters[:4], (*parameters[4:], *(0.0,) * 8)
    match model:
        case "SIMPLE_PINHOLE" | "PINHOLE" | "SIMPLE_RADIAL" | "RADIAL":
            lens = Distortion((p[0], p[1], 0.0, 0.0))
        case "OPENCV" | "FULL_OPENCV":
            lens = Distortion((p[0], p[1], p[4], 0.0), (p[5], p[6], p[7]), (p[2], p[3]))
        case (
            "SIMPLE_FISHEYE"
            | "SIMPLE_RADIAL_FISHEYE"
            | "RADIAL_FISHEYE"
            | "FISHEYE"
            | "OPENCV_FISHEYE"
        ):
            lens = Distortion((p[0], p[1], p[2], p[3]), projection="equidistant")
        case "THIN_PRISM_FISHEYE":
            lens = Distortion(
                (p[0], p[1], p[4], p[5]),
                tangential=(p[2], p[3]),
                prism=(p[6], p[7]),
                projection="equidistant",
            )
        case "FOV":
            if not 0 < p[0] < math.pi:
                raise InputError(f"{where} has a field of view that is not between 0 and pi")
            lens = Distortion(projection="fov", omega=p[0])
        case "EQUIRECTANGULAR":
            if (round(parameters[0]), round(parameters[1])) != (width, height):
                raise InputError(f"{where} is a panorama of another size than its photos")
            intrinsics, lens = sphere_intrinsics(width, height), EQUIRECTANGULAR
        case _:
            raise InputError(
                f"{where} has the lens model {model}, which is not supported; run `colmap "
                "image_undistorter --image_path images --input_path sparse/0 --output_path DIR` "
                "in the capture's folder and give DIR"
            )
    fx, fy, cx, cy = intrinsics
    if min(fx, fy) <= 0:
        raise InputError(f"{where} has a focal length that is not positive")
    return ColmapCamera(width, height, (fx, fy, cx, cy), lens)


_RawCamera = tuple[int, str, int, int, tuple[float, ...]]


def _binary_cameras(path: Path) -> Iterator[_RawCamera]:
    file = _BinaryReader.of(path)
    for _ in range(file.count(_CAMERA.size, "cameras")):
        number, model, width, height = file.take(_CAMERA)
        if model not in MODELS:  # the length of its record is not known
            yield number, str(model), width, height, ()
            return
        name, parameters = MODELS[model]
        yield number, name, width, height, file.take(struct.Struct(f"<{parameters}d"))
    file.finish()


def _binary_images(path: Path) -> Iterator[ColmapImage]:
    file = _BinaryReader.of(path)
    for _ in range(file.count(_IMAGE.size + 1 + _COUNT.size, "images")):
        number, *pose, camera_id = file.take(_IMAGE)
        end = file.data.find(b"\0", file.offset)
        if end < 0:
            raise file.damaged(f"ends inside the file name that begins at byte {file.offset}")
        try:
            name = file.data[file.offset : end].decode()
        except UnicodeDecodeError as error:
            raise file.damaged(
                f"has a file name at byte {file.offset} that is not UTF-8"
            ) from error
        file.offset = end + 1
        observations = file.count(_OBSERVATION_BYTES, "observations")
        file.offset += observations * _OBSERVATION_BYTES
        yield ColmapImage(number, name, camera_id, tuple(pose[:4]), tuple(pose[4:]))
    file.finish()


def _binary_moments(path: Path) -> Iterator[list[int]]:
    file = _BinaryReader.of(path)
    for _ in range(file.count(_FRAME.size, "frames")):
        *_, count = file.take(_FRAME)
        if count * _DATUM.size > file.left:
            raise file.damaged(f"announces {count} photos at byte {file.offset - 4}")
        data = [file.take(_DATUM) for _ in range(count)]
        yield [photo for kind, _, photo in data if kind == CAMERA_SENSOR]
    file.finish()


def _binary_points(path: Path) -> ColmapPoints:
    file = _BinaryReader.of(path)
    count = file.count(_POINT.itemsize, "points")
    data, size, at = file.data, len(file.data), file.offset
    length = _COUNT.unpack_from
    starts = []  # records differ in length: find all starts first, then read all at once
    for _ in range(count):
        starts.append(at)
        at += _POINT.itemsize
        if at > size:
            break
        at += 8 * length(data, at - 8)[0]
    if at > size:
        raise file.damaged(f"ends at byte {size} inside the point that begins at byte {starts[-1]}")
    file.offset = at
    file.finish()
    if not starts:
        return ColmapPoints(np.zeros((0, 3)), np.zeros((0, 3), np.uint8))
    rows = np.lib.stride_tricks.sliding_window_view(np.frombuffer(data, np.uint8), _POINT.itemsize)
    records = rows[np.array(starts)].view(_POINT)[:, 0]
    return ColmapPoints(records["xyz"].copy(), records["rgb"].copy())


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield (line number, text) of each line that is not a comment."""
    for number, line in enumerate(read_text(path, FILE_MAX).split("\n"), start=1):
        if not line.startswith("#"):
            yield number, line.strip()


def _bad_line(path: Path, number: int, layout: str) -> InputError:
    return InputError(f"{path}, line {number} should read `{layout}`; copy or export it again")


def _text_cameras(path: Path) -> Iterator[_RawCamera]:
    for line_number, line in _lines(path):
        if not line:
            continue
        try:
            number, model, width, height, *values = line.split()
            parameters = tuple(map(float, values))
            yield int(number), lens_model(model), int(width), int(height), parameters
        except ValueError as error:
            layout = "CAMERA_ID MODEL WIDTH HEIGHT PARAMS..."
            raise _bad_line(path, line_number, layout) from error


def _text_images(path: Path) -> Iterator[ColmapImage]:
    layout = "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME"
    for line_number, line in _lines(path):
        if not line or _are_observations(line):  # some tools write no observations
            continue
        try:
            number, *pose, camera_id, name = line.split(maxsplit=9)
            w, x, y, z, *translation = map(float, pose)
            tx, ty, tz = translation
            image = ColmapImage(int(number), name, int(camera_id), (w, x, y, z), (tx, ty, tz))
        except ValueError as error:
            raise _bad_line(path, line_number, layout) from error
        yield image


def _are_observations(line: str) -> bool:
    """Return True for a line of `X Y POINT3D_ID` triples, which follows that of a photo."""
    fields = line.split()
    if len(fields) % 3:
        return False
    try:
        return all(map(math.isfinite, map(float, fields)))
    except ValueError:
        return False


def _text_moments(path: Path) -> Iterator[list[int]]:
    for number, line in _lines(path):
        if not line:
            continue
        fields = line.split()
        kinds, photos = fields[10::3], fields[12::3]
        try:
            if len(fields) != 10 + 3 * int(fields[9]):
                raise ValueError
            cameras = [
                int(photo) for kind, photo in zip(kinds, photos, strict=True) if kind == "CAMERA"
            ]
        except (ValueError, IndexError) as error:
            layout = "FRAME_ID RIG_ID QW QX QY QZ TX TY TZ NUM_DATA_IDS (TYPE SENSOR_ID DATA_ID)..."
            raise _bad_line(path, number, layout) from error
        yield cameras


def _text_points(path: Path) -> ColmapPoints:
    xyz, rgb = [], []
    for number, line in _lines(path):
        if not line:
            continue
        fields = line.split(maxsplit=8)
        try:
            red, green, blue = bytes(map(int, fields[4:7]))
            xyz.append([float(value) for value in fields[1:4]])
        except ValueError as error:
            raise _bad_line(path, number, "POINT3D_ID X Y Z R G B ERROR TRACK...") from error
        rgb.append((red, green, blue))
    return ColmapPoints(
        np.array(xyz, np.float64).reshape(-1, 3), np.array(rgb, np.uint8).reshape(-1, 3)
    )
