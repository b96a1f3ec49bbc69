"""Reconstructs poses and points from matches, and undistorts photos."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int
from PIL import Image

from mobilegs.atomic import make_folder
from mobilegs.capture.misplaced_photos import drop_misplaced
from mobilegs.capture.pycolmap_runtime import SEED, load_pycolmap, threads
from mobilegs.capture.rigs import set_rig_of_model
from mobilegs.data.file_names import leads_out
from mobilegs.errors import InputError, quoted
from mobilegs.progress_display import Advance

Mapper = Literal["auto", "incremental", "global"]
Rig = Literal["none", "cameras", "faces"]
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
    progress: Advance,
    enough: int = MODEL_PHOTOS_MIN,
    rig: Rig = "none",
) -> dict[str, Any]:
    """Reconstruct, and write the model with most photos to `models/best`.

    `incremental` adds photo by photo, `global` solves for all at once; `auto` is `incremental` for
    a `total` of up to `INCREMENTAL_UP_TO` photos or panoramas, and tries the other one if fewer
    than `enough` photos get a pose. `faces` are those of panoramas, whose rig the database has. Of
    `cameras` the rig is measured in the largest model, and mapping is repeated with it. Misplaced
    photos are removed. Returns the record `{"mapper": mapper, "tried": mappers, "models": photos
    of each model, largest first, "rig": whether it was used, **figures(best model)}`.
    """
    tried = ["incremental", "global"]
    if mapper == "global" or (mapper == "auto" and total > INCREMENTAL_UP_TO):
        tried.reverse()
    if mapper != "auto":
        tried = tried[:1]
    if models.exists():
        shutil.rmtree(models)
    make_folder(models / "best")
    best: dict[str, Any] = {"mapper": tried[0], "models": [], "rig": rig == "faces", **_NOTHING}
    for number, name in enumerate(tried, start=1):
        progress(0, total)
        record = _mapped(name, database, photos, models / name, rig, _limited(progress, total))
        if rig == "cameras" and record["registered"]:
            record = _with_rig(record, database, photos, models / name, _limited(progress, total))
        if len(record["registered"]) > len(best["registered"]):
            best = record
            shutil.copytree(models / name / "kept", models / "best", dirs_exist_ok=True)
        if len(best["registered"]) >= enough:
            tried = tried[:number]
            break
    return {**best, "tried": tried}


def _limited(progress: Advance, total: int) -> Callable[[int], None]:
    return lambda done: progress(min(done, total), total)


def _mapped(
    mapper: str, database: Path, photos: Path, folder: Path, rig: Rig, progress: Any
) -> dict[str, Any]:
    """Reconstruct into `folder`, and write the largest model to `kept` in it."""
    make_folder(folder)
    run = _incremental if mapper == "incremental" else _global
    faces = rig == "faces"
    models = run(database, photos, folder, faces, progress)
    ranked = sorted(models.values(), key=lambda model: -model.num_reg_images())
    if not ranked:
        return {"mapper": mapper, "models": [], "rig": False, **_NOTHING}
    sizes = [model.num_reg_frames() if faces else model.num_reg_images() for model in ranked]
    misplaced = drop_misplaced(ranked[0], database)
    make_folder(folder / "kept")
    ranked[0].write_binary(folder / "kept")
    record = {"mapper": mapper, "models": sizes, "rig": faces}
    return {**record, **figures(ranked[0]), "misplaced": misplaced}


def _with_rig(
    record: dict[str, Any], database: Path, photos: Path, folder: Path, progress: Any
) -> dict[str, Any]:
    """Map again with the cameras at the places on the rig that `kept` in `folder` gives them.

    Returns `record` if that model does not connect the cameras, or if fewer photos get a pose.
    """
    with_rig = folder / "rig.db"
    shutil.copyfile(database, with_rig)
    if not set_rig_of_model(with_rig, load_pycolmap().Reconstruction(folder / "kept")):
        return record
    progress(0)
    repeated = _mapped(record["mapper"], with_rig, photos, folder / "rig", "cameras", progress)
    with_rig.unlink()
    if len(repeated["registered"]) < len(record["registered"]):
        return record
    shutil.copytree(folder / "rig" / "kept", folder / "kept", dirs_exist_ok=True)
    return {**repeated, "rig": True}


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
    reconstruction = load_pycolmap().Reconstruction(model)
    placed = sorted(
        (reconstruction.image(number) for number in reconstruction.reg_image_ids()), key=_name
    )
    points = list(reconstruction.points3D.values())
    return Geometry(
        np.array([image.cam_from_world().matrix() for image in placed]).reshape(-1, 3, 4),
        np.array([point.xyz for point in points]).reshape(-1, 3),
        np.array([point.track.length() for point in points], dtype=np.int64),
    )


def keep_photos(model: Path, photos: Path, masks: Path, output: Path, names: Sequence[str]) -> None:
    """Write `images/`, `masks/` and `sparse/` into the new folder `output`, all as they are."""
    if output.exists():
        shutil.rmtree(output)
    validate_names(names)
    shutil.copytree(model, output / "sparse")
    if masks.exists():
        shutil.copytree(masks, output / "masks")
    for name in names:
        make_folder((output / "images" / name).parent)
        shutil.copyfile(photos / name, output / "images" / name)


def validate_names(names: Sequence[str]) -> None:
    """Raise InputError for the name of a photo that leads out of a folder."""
    for name in names:
        if leads_out(name):
            raise InputError(f"a model names the photo {quoted(name)}, outside of its capture")


def undistort_photos(model: Path, photos: Path, masks: Path, output: Path) -> None:
    """Write `images/`, `masks/` and `sparse/` with pinhole cameras into the new folder `output`.

    A pixel of a mask is white if all those of the photo are from which it is made.
    """
    if output.exists():
        shutil.rmtree(output)
    pycolmap, options = load_pycolmap(), load_pycolmap().UndistortCameraOptions()
    reconstruction = pycolmap.Reconstruction(model)
    placed = [reconstruction.image(number) for number in reconstruction.reg_image_ids()]
    validate_names([image.name for image in placed])
    pycolmap.undistort_images(
        output,
        model,
        photos,
        undistort_options=options,
        jpeg_quality=JPEG_QUALITY,
        num_threads=threads(),
    )
    for image in placed:
        mask = masks / f"{image.name}.png"
        if mask.exists():
            bitmap = pycolmap.Bitmap.read(mask, as_rgb=False)
            bitmap, _ = pycolmap.undistort_image(options, bitmap, image.camera)
            make_folder((output / "masks" / mask.relative_to(masks)).parent)
            white = np.where(bitmap.to_array() == 255, np.uint8(255), np.uint8(0))
            Image.fromarray(white).save(output / "masks" / mask.relative_to(masks))


def _incremental(
    database: Path, photos: Path, models: Path, calibrated: bool, progress: Any
) -> dict[int, Any]:
    """Run incremental mapping. `calibrated` keeps intrinsics and rigs as they are."""
    pycolmap = load_pycolmap()
    options = pycolmap.IncrementalPipelineOptions(
        num_threads=threads(), random_seed=SEED, min_model_size=MODEL_PHOTOS_MIN
    )
    if calibrated:
        options.ba_refine_focal_length = options.ba_refine_sensor_from_rig = False
    placed = 0

    def add(number: int) -> None:
        nonlocal placed
        placed += number
        progress(placed)

    return pycolmap.incremental_mapping(
        database,
        photos,
        models,
        options,
        initial_image_pair_callback=lambda: add(2),
        next_image_callback=lambda: add(1),
    )


def _global(
    database: Path, photos: Path, models: Path, calibrated: bool, progress: Any
) -> dict[int, Any]:
    """Run global mapping. It needs focal lengths: those missing in EXIF are calibrated first.

    `calibrated` keeps intrinsics and rigs as they are.
    """
    pycolmap = load_pycolmap()
    copy = models / "database.db"  # because calibration changes it
    with pycolmap.Database.open(database):
        pass  # closing merges a journal that an interruption left
    shutil.copyfile(database, copy)
    # one thread: with more, the last digits differ from run to run
    options = pycolmap.GlobalPipelineOptions(
        num_threads=1, random_seed=SEED, min_model_size=MODEL_PHOTOS_MIN
    )
    if calibrated:
        options.mapper.refine_sensor_from_rig = False
        options.mapper.bundle_adjustment.refine_focal_length = False
    with pycolmap.Database.open(copy) as content:
        known = all(camera.has_prior_focal_length for camera in content.read_all_cameras())
    if not known:
        seeded = pycolmap.ViewGraphCalibrationOptions(random_seed=SEED)
        pycolmap.calibrate_view_graph(copy, seeded)
    mapped = pycolmap.global_mapping(copy, photos, models, options)
    copy.unlink()
    return mapped


def _name(image: Any) -> str:
    return image.name
