"""Writes cameras and SIFT features of photos into COLMAP's database."""

from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from mobilegs.capture.photos import PreparedPhoto
from mobilegs.capture.pycolmap_runtime import load_pycolmap, threads
from mobilegs.capture.rigs import camera_of, set_rig_of_faces
from mobilegs.progress_display import Advance

Lens = Literal["simple", "opencv", "fisheye", "panorama"]
MODELS = {  # of COLMAP; the last one is of a panorama's faces
    "simple": "SIMPLE_RADIAL",
    "opencv": "OPENCV",
    "fisheye": "OPENCV_FISHEYE",
    "panorama": "PINHOLE",
}
BATCH = 16  # photos between two progress updates
GUESSED_FOCAL = 1.2  # times the longer side, without EXIF: the default of COLMAP
GUESSED_FISHEYE = 0.45  # the same; 0.38 is a lens of 180 degrees from corner to corner


def extract_features(
    database: Path,
    folder: Path,
    photos: list[PreparedPhoto],
    *,
    lens: Lens,
    masks: Path,
    progress: Advance,
) -> dict[str, Any]:
    """Write cameras, photos and their features into `database`; existing entries stay.

    Photos of the same lens and size share a camera, whose focal length starts at the EXIF value.
    Those of a rig have one camera per folder. The faces of panoramas become a rig. There are no
    features where a mask is black; the folder `masks` has a.jpg.png for a.jpg, if any.
    Returns the record `{"cameras": number, "features": mean per photo}`.
    """
    import_cameras(database, folder, photos, lens)
    if lens == "panorama":
        set_rig_of_faces(database)
    pycolmap = load_pycolmap()
    options = pycolmap.FeatureExtractionOptions(num_threads=threads(), use_gpu=False)

    def masked(photo: PreparedPhoto) -> bool:
        return (masks / f"{photo.name}.png").exists()

    for start in range(0, len(photos), BATCH):
        progress(start, len(photos))
        batch = sorted(photos[start : start + BATCH], key=masked)
        for with_mask, group in groupby(batch, key=masked):  # a missing mask is an error
            reader = pycolmap.ImageReaderOptions(mask_path=masks if with_mask else "")
            pycolmap.extract_features(
                database,
                folder,
                image_names=[photo.name for photo in group],
                reader_options=reader,
                extraction_options=options,
                device=pycolmap.Device.cpu,
            )
    progress(len(photos), len(photos))
    with pycolmap.Database.open(database) as content:
        return {
            "cameras": content.num_cameras(),
            "features": round(content.num_keypoints() / len(photos)),
        }


def import_cameras(database: Path, folder: Path, photos: list[PreparedPhoto], lens: Lens) -> None:
    """Add photos in the order of names and one camera per folder, lens and size.

    Done before extraction, so that the order of ids does not depend on threads.
    """
    pycolmap = load_pycolmap()
    with pycolmap.Database.open(database) as content:
        if content.num_images() == len(photos):
            return
        content.clear_all_tables()

    def shared(photo: PreparedPhoto) -> tuple[str, str, int, int]:
        return camera_of(photo.name), photo.lens, photo.width, photo.height

    for _, group in groupby(sorted(photos, key=lambda p: (*shared(p), p.name)), key=shared):
        members = list(group)
        one = members[0]
        options = pycolmap.ImageReaderOptions(
            camera_model=MODELS[lens], default_focal_length_factor=GUESSED_FOCAL
        )
        focal = one.focal
        if focal is None and lens == "fisheye":
            # parameters make COLMAP estimate motion from rays; a fundamental matrix fits no fisheye
            focal = GUESSED_FISHEYE * max(one.width, one.height)
        if focal is not None:
            options.camera_params = camera_params(one, focal, lens)
        pycolmap.import_images(
            database,
            folder,
            camera_mode=pycolmap.CameraMode.SINGLE,
            image_names=[photo.name for photo in members],
            options=options,
        )


def camera_params(photo: PreparedPhoto, focal: float, lens: Lens) -> str:
    """Return COLMAP camera parameters: focal length(s), principal point, no distortion."""
    focals = [focal] if lens == "simple" else [focal, focal]
    distortion = {"simple": 1, "opencv": 4, "fisheye": 4, "panorama": 0}[lens]
    values = [*focals, photo.width / 2, photo.height / 2, *[0] * distortion]
    return ",".join(map(str, values))
