"""Photos of several cameras on a rig: the names `camera/moment.jpg`, and COLMAP's rigs.

A panorama is a rig, too: its faces are photos of six cameras in one place.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mobilegs.capture.pycolmap_runtime import load_pycolmap
from mobilegs.data.pinhole_views import FACES
from mobilegs.errors import InputError

MOMENTS_MIN = 3  # at which two cameras of a rig have photos


def camera_of(name: str) -> str:
    """Return the folder in a photo's name, which is its camera on a rig."""
    return name.rpartition("/")[0]


def moment_of(name: str) -> str:
    """Return a photo's name without its folder: photos of one moment share it."""
    return name.rpartition("/")[2]


def validate_rig(names: Sequence[str], source: Path) -> None:
    """Raise InputError unless several folders have photos of the same names."""
    cameras: dict[str, set[str]] = {}
    for name in names:
        cameras.setdefault(camera_of(name), set()).add(moment_of(name))
    if len(cameras) < 2:
        raise InputError(f"--rig needs a folder of photos for each camera: {source} has one")
    for camera, moments in cameras.items():
        common = (len(moments & other) for one, other in cameras.items() if one != camera)
        if max(common) < MOMENTS_MIN:
            raise InputError(
                "--rig needs the same file name for photos of one moment: fewer than "
                f"{MOMENTS_MIN} names in the folder {camera} of {source} are in another folder, too"
            )


def set_rig_of_faces(database: Path) -> None:
    """Write the rig of six cameras that took the faces of panoramas into COLMAP's database."""
    cameras = []
    for face, rotation in FACES.items():
        place = {}
        if cameras:  # the first one is the reference
            turn = load_pycolmap().Rotation3d(np.array(rotation).T)
            place = {"cam_from_rig": load_pycolmap().Rigid3d(turn, np.zeros(3))}
        cameras.append(_rig_camera(face, ref_sensor=not cameras, **place))
    _apply(database, cameras)


def set_rig_of_model(database: Path, model: Any) -> bool:
    """Write the rig of all cameras into COLMAP's database, as a reconstruction shows it.

    A camera's place on the rig is its mean over all moments of `model`, a pycolmap Reconstruction,
    which is changed. Returns False, and writes nothing, if a camera has no photo of a moment at
    which the first camera has one.
    """
    moments: dict[str, set[str]] = {}
    for number in model.reg_image_ids():
        name = model.image(number).name
        moments.setdefault(camera_of(name), set()).add(moment_of(name))
    with load_pycolmap().Database.open(database) as content:
        folders = sorted({camera_of(image.name) for image in content.read_all_images()})
    first = moments.get(folders[0], set())
    if not all(first & moments.get(folder, set()) for folder in folders):
        return False
    _apply(database, [_rig_camera(f, ref_sensor=f == folders[0]) for f in folders], model)
    return True


def _rig_camera(folder: str, **options: Any) -> Any:
    return load_pycolmap().RigConfigCamera(image_prefix=f"{folder}/", **options)


def _apply(database: Path, cameras: list[Any], model: Any = None) -> None:
    pycolmap = load_pycolmap()
    with pycolmap.Database.open(database) as content:
        pycolmap.apply_rig_config([pycolmap.RigConfig(cameras=cameras)], content, model)
