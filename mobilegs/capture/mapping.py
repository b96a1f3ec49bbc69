"""Reconstructs poses and points from matches, and undistorts photos."""

import shutil
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from mobilegs.atomic import make_folder
from mobilegs.capture.misplaced_photos import drop_misplaced
from mobilegs.capture.pycolmap_runtime import SEED, Progress, in_background, load_pycolmap, threads

Mapper = Literal["auto", "incremental", "global"]
INCREMENTAL_UP_TO = 250  # photos
MODEL_PHOTOS_MIN = 3
JPEG_QUALITY = 95  # of undistorted photos


def map_photos(
    database: Path,
    photos: Path,
    models: Path,
    *,
    mapper: Mapper,
    total: int,
    progress: Progress,
    enough: int = MODEL_PHOTOS_MIN,
) -> dict[str, Any]:
    """Reconstruct, and write the model with most photos to `models/best`.

    `incremental` adds photo by photo, `global` solves for all at once; `auto` is `incremental` for
    a `total` of up to `INCREMENTAL_UP_TO` photos, and tries the other one if fewer than `enough`
    photos get a pose. Misplaced photos are removed. Returns the record `{"mapper": mapper, "tried":
    mappers, "models": photos of each model, largest first, **figures(best model)}`.
    """
    tried = ["incremental", "global"]
    if mapper == "global" or (mapper == "auto" and total > INCREMENTAL_UP_TO):
        tried.reverse()
    if mapper != "auto":
        tried = tried[:1]
    if models.exists():
        shutil.rmtree(models)
    make_folder(models / "best")
    best: dict[str, Any] = {"mapper": tried[0], "models": [], **_NOTHING}
    for number, name in enumerate(tried, start=1):
        folder = models / name
        make_folder(folder)
        found = (_incremental if name == "incremental" else _global)(
            database, photos, folder, lambda done: progress(min(done, total), total)
        )
        ranked = sorted(found.values(), key=lambda model: -model.num_reg_images())
        if ranked:
            sizes = [model.num_reg_images() for model in ranked]
            misplaced = drop_misplaced(ranked[0], database)
            record = {"mapper": name, "models": sizes, **figures(ranked[0]), "misplaced": misplaced}
            if len(record["registered"]) > len(best["registered"]):
                best = record
                ranked[0].write_binary(models / "best")
        if len(best["registered"]) >= enough:
            tried = tried[:number]
            break
    return {**best, "tried": tried}


_NOTHING = {
    "misplaced": [],
    "registered": [],
    "reprojection_error": None,
    "points": 0,
    "photos_a_point": 0.0,
    "points_of_photos": {},
    "cameras": [],
}


def figures(model: Any) -> dict[str, Any]:
    """Return the figures of a reconstruction: names, error in pixels, points, cameras."""
    placed = sorted((model.image(number) for number in model.reg_image_ids()), key=_name)
    return {
        "registered": [image.name for image in placed],
        "reprojection_error": round(model.compute_mean_reprojection_error(), 4),
        "points": model.num_points3D(),
        "photos_a_point": round(model.compute_mean_track_length(), 2),
        "points_of_photos": {image.name: image.num_points3D for image in placed},
        "cameras": [
            {
                "model": camera.model.name,
                "width": camera.width,
                "height": camera.height,
                "params": [round(x, 6) for x in camera.params.tolist()],
                "photos": sum(image.camera_id == number for image in placed),
            }
            for number, camera in sorted(model.cameras.items())
        ],
    }


class Geometry(NamedTuple):
    """World-to-camera matrices, points (world units), and how many photos see each point."""

    viewmats: Float[np.ndarray, "n 3 4"]
    points: Float[np.ndarray, "m 3"]
    seen: Int[np.ndarray, "m"]


def read_geometry(model: Path) -> Geometry:
    """Read cameras and points of the reconstruction in the folder `model`."""
    found = load_pycolmap().Reconstruction(model)
    placed = sorted((found.image(number) for number in found.reg_image_ids()), key=_name)
    points = list(found.points3D.values())
    return Geometry(
        np.array([image.cam_from_world().matrix() for image in placed]).reshape(-1, 3, 4),
        np.array([point.xyz for point in points]).reshape(-1, 3),
        np.array([point.track.length() for point in points], dtype=np.int64),
    )


def undistort_photos(model: Path, photos: Path, output: Path) -> None:
    """Write `images/` and `sparse/` with pinhole cameras into the new folder `output`."""
    if output.exists():
        shutil.rmtree(output)
    pycolmap = load_pycolmap()
    in_background(
        lambda token: pycolmap.undistort_images(
            output,
            model,
            photos,
            jpeg_quality=JPEG_QUALITY,
            num_threads=threads(),
            cancellation_token=token,
        )
    )


def _incremental(database: Path, photos: Path, models: Path, progress: Any) -> dict[int, Any]:
    pycolmap = load_pycolmap()
    options = pycolmap.IncrementalPipelineOptions(
        num_threads=threads(), random_seed=SEED, min_model_size=MODEL_PHOTOS_MIN
    )
    placed = [0]

    def begun() -> None:
        placed[0] += 2

    def added() -> None:
        placed[0] += 1

    return in_background(
        lambda token: pycolmap.incremental_mapping(
            database,
            photos,
            models,
            options,
            initial_image_pair_callback=begun,
            next_image_callback=added,
            cancellation_token=token,
        ),
        lambda: progress(placed[0]),
    )


def _global(database: Path, photos: Path, models: Path, progress: Any) -> dict[int, Any]:
    """Run global mapping. It needs focal lengths: those missing in EXIF are calibrated first."""
    pycolmap = load_pycolmap()
    calibrated = models / "database.db"  # a copy, because calibration changes it
    with pycolmap.Database.open(database):
        pass  # closing merges a journal that an interruption left
    shutil.copyfile(database, calibrated)
    # one thread: with more, the last digits differ from run to run
    options = pycolmap.GlobalPipelineOptions(
        num_threads=1, random_seed=SEED, min_model_size=MODEL_PHOTOS_MIN
    )

    def work(token: Any) -> Any:
        with pycolmap.Database.open(calibrated) as content:
            known = all(camera.has_prior_focal_length for camera in content.read_all_cameras())
        if not known:
            seeded = pycolmap.ViewGraphCalibrationOptions(random_seed=SEED)
            pycolmap.calibrate_view_graph(calibrated, seeded)
        return pycolmap.global_mapping(calibrated, photos, models, options)

    try:
        return in_background(work)
    finally:
        calibrated.unlink(missing_ok=True)


def _name(image: Any) -> str:
    return image.name
