"""Writes cameras and SIFT features of photos into COLMAP's database."""

from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from mobilegs.capture.photos import PreparedPhoto
from mobilegs.capture.pycolmap_runtime import Progress, in_background, load_pycolmap, threads

Lens = Literal["simple", "opencv"]
MODELS = {"simple": "SIMPLE_RADIAL", "opencv": "OPENCV"}
BATCH = 16  # photos between two progress updates
GUESSED_FOCAL = 1.2  # times the longer side, without EXIF: the default of COLMAP


def extract_features(
    database: Path, folder: Path, photos: list[PreparedPhoto], *, lens: Lens, progress: Progress
) -> dict[str, Any]:
    """Write cameras, photos and their features into `database`; existing entries stay.

    Photos of the same lens and size share a camera, whose focal length starts at the EXIF value.
    Returns the record `{"cameras": number, "features": mean per photo}`.
    """
    import_cameras(database, folder, photos, lens)
    pycolmap = load_pycolmap()
    options = pycolmap.FeatureExtractionOptions(num_threads=threads(), use_gpu=False)
    for start in range(0, len(photos), BATCH):
        progress(start, len(photos))
        batch = [photo.name for photo in photos[start : start + BATCH]]
        in_background(
            lambda token, batch=batch: pycolmap.extract_features(
                database,
                folder,
                image_names=batch,
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


def import_cameras(database: Path, folder: Path, photos: list[PreparedPhoto], lens: Lens) -> None:
    """Add photos in the order of names and one camera per lens and size.

    Done before extraction, so that the order of ids does not depend on threads.
    """
    pycolmap = load_pycolmap()
    with pycolmap.Database.open(database) as content:
        if content.num_images() == len(photos):
            return
        content.clear_all_tables()

    def shared(photo: PreparedPhoto) -> tuple[str, int, int]:
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


def camera_params(photo: PreparedPhoto, lens: Lens) -> str:
    """Return COLMAP camera parameters: focal length(s), principal point, no distortion."""
    focal = [photo.focal] if lens == "simple" else [photo.focal, photo.focal]
    center = [photo.width / 2, photo.height / 2]
    return ",".join(str(x) for x in (*focal, *center, *([0] if lens == "simple" else [0] * 4)))
