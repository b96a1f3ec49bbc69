"""Writes a COLMAP model as text, with all digits of every number."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from jaxtyping import Float
from scipy.spatial.transform import Rotation
from torch import Tensor

from mobilegs.atomic import atomic_write
from mobilegs.camera import Camera


def write_model(
    capture: Path,
    cameras: Sequence[tuple[str, Camera]],
    points: Float[Tensor, "m 3"],
    colors: Float[Tensor, "m 3"],
) -> None:
    """Write `sparse/0` of a capture; `cameras.txt` comes last and marks it as complete.

    `cameras` are the names of the photos and their pinhole cameras. Points are in world units,
    their colours in [0, 1].
    """
    rows, images = ["# CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY"], []
    images.append("# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of observations")
    for number, (name, camera) in enumerate(cameras, start=1):
        K, pose = camera.K.double(), camera.viewmat.double().numpy()
        intrinsics = (K[0, 0], K[1, 1], K[0, 2], K[1, 2])
        rows.append(f"{number} PINHOLE {camera.width} {camera.height} {_digits(intrinsics)}")
        x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat()
        images.append(f"{number} {_digits((w, x, y, z, *pose[:3, 3]))} {number} {name}\n")
    stars = ["# POINT3D_ID X Y Z R G B ERROR TRACK..."]
    bytes_of = (colors * 255).round().int().tolist()
    for number, (xyz, (r, g, b)) in enumerate(zip(points.tolist(), bytes_of, strict=True)):
        stars.append(f"{number + 1} {_digits(xyz)} {r} {g} {b} 0")
    for noun, lines in (("points3D", stars), ("images", images), ("cameras", rows)):
        atomic_write(capture / "sparse" / "0" / f"{noun}.txt", "\n".join(lines) + "\n")


def _digits(values: Iterable) -> str:
    return " ".join(repr(float(value)) for value in values)
