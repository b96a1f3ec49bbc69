"""Matches -> poses and points, and photos as pinhole cameras would have taken them."""

import shutil
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from mobilegs.atomic import make_folder
from mobilegs.capture.agreement import drop_misplaced
from mobilegs.capture.engine import SEED, Progress, engine, in_background, threads

Mapper = Literal["auto", "incremental", "global"]
INCREMENTAL_UP_TO = 250  # photos
SMALLEST = 3  # photos of a model
QUALITY = 95  # of the undistorted JPEG


def map_photos(
    database: Path, photos: Path, models: Path, *, mapper: Mapper, total: int, progress: Progress
) -> dict[str, Any]:
    """Reconstruct, and leave the model with most photos, without misplaced ones, in `models/best`.

    `incremental` adds photo by photo, `global` solves for all at once; `auto` is `incremental` up
    to `INCREMENTAL_UP_TO` of the `total` photos. Returns the record
    `{"mapper": which, "models": sizes, largest first, **figures of the best}`.
    """
    chosen = mapper if mapper != "auto" else "incremental"
    if mapper == "auto" and total > INCREMENTAL_UP_TO:
        chosen = "global"
    if models.exists():
        shutil.rmtree(models)
    make_folder(models)
    found = (_incremental if chosen == "incremental" else _global)(
        database, photos, models, lambda done: progress(min(done, total), total)
    )
    ranked = sorted(found.values(), key=lambda model: -model.num_reg_images())
    record = {"mapper": chosen, "models": [model.num_reg_images() for model in ranked]}
    if not ranked:
        return {**record, **_NOTHING}
    misplaced = drop_misplaced(ranked[0], database)
    make_folder(models / "best")
    ranked[0].write_binary(models / "best")
    return {**record, **figures(ranked[0]), "misplaced": misplaced}


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
    """What a reconstruction holds: names, pixels of error, points, cameras."""
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
    """A reconstruction in world units: world-to-camera matrices, points, and who sees a point."""

    viewmats: Float[np.ndarray, "n 3 4"]
    points: Float[np.ndarray, "m 3"]
    seen: Int[np.ndarray, "m"]


def read_geometry(model: Path) -> Geometry:
    """Where cameras and points of the reconstruction in a folder are."""
    found = engine().Reconstruction(model)
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
    pycolmap = engine()
    in_background(
        lambda token: pycolmap.undistort_images(
            output,
            model,
            photos,
            jpeg_quality=QUALITY,
            num_threads=threads(),
            cancellation_token=token,
        )
    )


def _incremental(database: Path, photos: Path, models: Path, progress: Any) -> dict[int, Any]:
    pycolmap = engine()
    options = pycolmap.IncrementalPipelineOptions(
        num_threads=threads(), random_seed=SEED, min_model_size=SMALLEST
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
    """Global mapping wants focal lengths; where EXIF gave none, pairs of photos tell them first."""
    pycolmap = engine()
    calibrated = models / "database.db"  # a copy: the mapper's guesses are not for others
    with pycolmap.Database.open(database):
        pass  # what an interruption has left beside the file is in it once it is closed
    shutil.copyfile(database, calibrated)
    # one thread: with more of them the last digits differ from run to run, whatever the seed
    options = pycolmap.GlobalPipelineOptions(
        num_threads=1, random_seed=SEED, min_model_size=SMALLEST
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
