"""Photos -> cameras and SIFT features in COLMAP's database."""

from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from mobilegs.capture.engine import Progress, engine, in_background, threads
from mobilegs.capture.photos import Prepared

Lens = Literal["simple", "opencv"]
MODELS = {"simple": "SIMPLE_RADIAL", "opencv": "OPENCV"}
AT_ONCE = 16  # photos between two reports of progress
GUESSED_FOCAL = 1.2  # of the longer side, where EXIF says nothing: COLMAP's own guess


def extract_features(
    database: Path, folder: Path, photos: list[Prepared], *, lens: Lens, progress: Progress
) -> dict[str, Any]:
    """Write cameras, photos and their features into `database`; what is there already stays.

    Photos of the same lens and size share a camera, whose focal length begins at what EXIF says.
    Returns the record `{"cameras": number, "features": mean a photo}`.
    """
    import_cameras(database, folder, photos, lens)
    pycolmap = engine()
    options = pycolmap.FeatureExtractionOptions(num_threads=threads(), use_gpu=False)
    for start in range(0, len(photos), AT_ONCE):
        progress(start, len(photos))
        some = [photo.name for photo in photos[start : start + AT_ONCE]]
        in_background(
            lambda token, some=some: pycolmap.extract_features(
                database,
                folder,
                image_names=some,
                extraction_options=options,
                device=pycolmap.Device.cpu,
                cancellation_token=token,
            )
        )
    progress(len(photos), len(photos))
    with pycolmap.Database.open(database) as content:
        return {
            "cameras": content.num_cameras(),
            "features": round(content.num_keypoints() / len(photos)),
        }


def import_cameras(database: Path, folder: Path, photos: list[Prepared], lens: Lens) -> None:
    """Number photos by name and cameras by lens and size, so that threads do not decide it."""
    pycolmap = engine()
    with pycolmap.Database.open(database) as content:
        if content.num_images() == len(photos):
            return
        content.clear_all_tables()

    def shared(photo: Prepared) -> tuple[str, int, int]:
        return photo.lens, photo.width, photo.height

    for _, group in groupby(sorted(photos, key=lambda p: (*shared(p), p.name)), key=shared):
        members = list(group)
        one = members[0]
        options = pycolmap.ImageReaderOptions(
            camera_model=MODELS[lens], default_focal_length_factor=GUESSED_FOCAL
        )
        if one.focal is not None:
            options.camera_params = camera_params(one, lens)
        pycolmap.import_images(
            database,
            folder,
            camera_mode=pycolmap.CameraMode.SINGLE,
            image_names=[photo.name for photo in members],
            options=options,
        )


def camera_params(photo: Prepared, lens: Lens) -> str:
    """A camera as COLMAP's options have it: focal length(s), middle, and no distortion."""
    focal = [photo.focal] if lens == "simple" else [photo.focal, photo.focal]
    middle = [photo.width / 2, photo.height / 2]
    return ",".join(str(x) for x in (*focal, *middle, *([0] if lens == "simple" else [0] * 4)))
