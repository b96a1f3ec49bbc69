"""Makes a capture from photos or a video: runs all stages and writes the report."""

import logging
import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from os.path import commonpath
from pathlib import Path
from typing import Annotated, Any, TypedDict, cast

from tyro.conf import Positional, arg

from mobilegs.atomic import refuse_links
from mobilegs.capture.coverage import draw_coverage
from mobilegs.capture.features import Lens, extract_features
from mobilegs.capture.mapping import (
    Mapper,
    keep_photos,
    map_photos,
    read_geometry,
    undistort_photos,
)
from mobilegs.capture.matches import Pairs, forget_matches, match_photos
from mobilegs.capture.photos import (
    PHOTOS,
    PHOTOS_MIN,
    PreparedPhoto,
    list_files,
    list_photos,
    other_files,
    other_poses,
    prepare_photos,
    prepared_names,
    relative_names,
)
from mobilegs.capture.pycolmap_runtime import (
    SEED,
    PycolmapProcess,
    validate_pycolmap,
)
from mobilegs.capture.rigs import validate_rig
from mobilegs.capture.video import SUFFIXES as VIDEOS
from mobilegs.capture.video import is_video, prepare_video
from mobilegs.capture.workspace import Workspace, digest, file_digest
from mobilegs.data.masks import find_masks
from mobilegs.errors import InputError
from mobilegs.progress_display import Advance, Progress, no_progress

VERSION = 2  # of the stages; a change makes them run again
SIZE_MIN = 64  # pixels, longer side of a photo
REPORTED = (  # of the record of the stage `model`
    "mapper", "models", "reprojection_error", "points", "photos_a_point", "cameras",
    "points_of_photos", "misplaced",
)  # fmt: skip
NAMES_MAX = 5  # photos that an error message names

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class CaptureRun:
    """Compute the camera poses of photos or of a video, to make a capture.

    CAPTURE receives the undistorted photos in images/, their masks in masks/, their poses in
    sparse/0/ (the layout of COLMAP), all figures in capture.json, and coverage.png, which shows
    where photos are missing. After Ctrl-C the same command continues and does not repeat finished
    stages. CAPTURE/work holds intermediate files; it may be deleted afterwards.
    """

    source: Annotated[Positional[Path], arg(metavar="PHOTOS|VIDEO")]
    """Folder of photos (also HEIC), or a video."""
    output: Annotated[Path, arg(aliases=["-o"], metavar="CAPTURE")]
    """Folder for the capture; created if missing."""
    max_size: Annotated[int, arg(metavar="PIXELS")] = 1600
    """Reduce photos to at most this many pixels on the longer side."""
    frames: Annotated[int | None, arg(metavar="N")] = None
    """Number of frames to take from a video: the sharpest one of each time interval. Default: 3 per
    second, at most 240."""
    lens: Lens = "simple"
    """Model of the lens. simple: one parameter of distortion. opencv: four parameters, for wide
    lenses and many photos. fisheye: a fisheye lens; the photos stay as they are. panorama: the
    photos are panoramas of the whole sphere, twice as wide as high; each becomes six photos."""
    rig: bool = False
    """The photos are of several cameras on a rig that fired together: a folder for each camera,
    and the same file name for the photos of one moment."""
    pairs: Pairs = "auto"
    """Pairs of photos to match. all: every pair. alike: each photo with its neighbours by name and
    with the 20 photos most similar to it. auto: all for up to 80 photos, otherwise alike."""
    mapper: Mapper = "auto"
    """Method that computes poses. incremental: photo by photo. global: all at once. auto:
    incremental for up to 250 photos, otherwise global; and the other one if too few photos get a
    pose."""
    min_placed: Annotated[float, arg(metavar="SHARE")] = 0.5
    """Stop if fewer photos than this share of all, 0 to 1, get a pose."""


class CaptureReport(TypedDict):
    """The content of `capture.json`.

    Attributes:
        source: name of the folder of photos or of the video.
        photos: number of photos.
        registered: number of photos that got a pose.
        left_out: names of the others.
        converted: number of photos or frames that were converted to sRGB, by the name of their
            colours.
        unreadable: a sentence for each photo that cannot be read.
        other_files: number of files beside the photos that are none, by kind.
        features_a_photo: mean number of features.
        pairs: `all` or `alike`, of which `compared` were matched and `verified` have matches.
        tried: mappers, the last of which may have placed fewer photos than another one.
        mapper: the one that computed the poses.
        models: photos of each unconnected model, the largest first.
        points: number of sparse points.
        photos_a_point: mean number of photos in which a point is seen.
        points_of_photos: number of points in each photo.
        reprojection_error: mean, in pixels.
        cameras: model, size, parameters and number of photos of each camera.
        exposures: of each photo, by its EXIF.
        rig: True if the places of the cameras on the rig were used.
        misplaced: names of photos that got a wrong pose and were left out.
        seconds_of: time of each stage.
    """

    source: str
    photos: int
    registered: int
    left_out: list[str]
    converted: dict[str, int]
    unreadable: list[str]
    other_files: dict[str, int]
    features_a_photo: int
    pairs: str
    compared: int
    verified: int
    tried: list[str]
    mapper: str
    models: list[int]
    points: int
    photos_a_point: float
    points_of_photos: dict[str, int]
    reprojection_error: float
    cameras: list[dict[str, Any]]
    exposures: dict[str, float]
    rig: bool
    misplaced: list[str]
    seconds_of: dict[str, float]


@dataclass(frozen=True)
class StageInputs:
    """The arguments of all stages. `progress` opens a stage by its title."""

    run: CaptureRun
    inputs: list[Path]
    workspace: Workspace
    progress: Progress
    process: PycolmapProcess
    masks: dict[Path, Path]

    def call(
        self, doing: str, function: Callable[..., Any], *arguments: Any, **options: Any
    ) -> Any:
        """Return the result of a function in the process of pycolmap, and show its progress."""
        with self.progress(doing) as advance:
            return self.process.call(doing, function, *arguments, progress=advance, **options)


def capture_photos(run: CaptureRun, *, progress: Progress = no_progress) -> CaptureReport:
    """Make a capture (`images/`, `sparse/0/`) from photos or a video.

    Results of an earlier call with the same input and options are kept: an interrupted capture
    continues, a finished one stays. `progress` opens a stage by its title. Returns the content of
    `capture.json`. Raises InputError if the input or an option is not valid, pycolmap is not
    installed or crashes, or too few photos get a pose; then neither `images/` nor `sparse/` is
    written.
    """
    validate_options(run)
    validate_pycolmap()
    inputs = list_inputs(run.source, rig=run.rig)
    photo_folders = (run.source.resolve(), *(path.resolve().parent for path in inputs))
    if run.output.resolve() in photo_folders:
        raise InputError(f"{run.output} holds the photos: give another folder for the capture")
    workspace = Workspace(run.output)
    workspace.validate_not_foreign()
    with progress("reading files") as advance:
        masks = masks_of_inputs(run.source, inputs)
        keys = stage_keys(run, digest_inputs([*inputs, *masks.values()], advance))
    with PycolmapProcess(workspace.log) as process:
        given = StageInputs(run, inputs, workspace, progress, process, masks)
        report = workspace.finished(keys["capture"])
        if report is None:
            report = run_stages(given, keys)
    validate_placed(report["registered"], report["left_out"], given)
    return cast(CaptureReport, report)


def run_stages(given: StageInputs, keys: dict[str, str]) -> dict[str, Any]:
    """Run all stages that are not done, and return the record of the last one."""
    workspace = given.workspace
    refuse_links(workspace.images, workspace.sparse, workspace.work, *workspace.work.rglob("*"))
    record = workspace.run("photos", keys["photos"], lambda: prepare(given))
    try:
        photos = [PreparedPhoto(**photo) for photo in record["photos"]]
    except (LookupError, TypeError) as error:
        raise InputError(f"{workspace.work} is damaged: delete it, and start again") from error
    workspace.run("features", keys["features"], lambda: features(given, photos))
    before = workspace.read("matches")
    if before is not None and before["key"] != keys["matches"]:
        workspace.forget("matches")
        given.process.call("forgetting matches", forget_matches, workspace.database)
    workspace.run("matches", keys["matches"], lambda: matches(given, photos))
    mapped = workspace.run("model", keys["model"], lambda: model(given, photos))
    validate_placed(len(placed(photos, mapped)), left_out(photos, mapped), given)
    return workspace.run("capture", keys["capture"], lambda: finish(given, photos))


def stage_keys(run: CaptureRun, inputs: list[tuple[str, str]]) -> dict[str, str]:
    """Return the key of every stage: a digest of everything that decides its result."""
    key, keys = digest(VERSION, SEED, inputs), {}
    arranged = [run.lens == "panorama", run.rig]
    for stage, own in (
        ("photos", [run.max_size, run.frames, *(arranged if any(arranged) else [])]),
        ("features", run.lens),
        ("matches", run.pairs),
        ("model", run.mapper),
        ("capture", None),
    ):
        keys[stage] = key = digest(key, own)
    return keys


# --- the stages -----------------------------------------------------------------------------------


def prepare(given: StageInputs) -> dict[str, Any]:
    """Write upright photos or frames of a limited size."""
    run, folder = given.run, given.workspace.photos
    panorama = run.lens == "panorama"
    if is_video(given.inputs[0]):
        if run.rig:
            raise InputError(f"--rig needs a folder per camera, and {given.inputs[0]} is a video")
        with given.progress("choosing the sharpest frames") as advance:
            return prepare_video(
                given.inputs[0],
                folder,
                frames=run.frames,
                max_size=run.max_size,
                panorama=panorama,
                progress=advance,
            )
    if run.frames is not None:
        raise InputError(f"--frames needs a video, and {run.source} is not one: leave it out")
    if run.rig:
        validate_rig(list(prepared_names(given.inputs, rig=True).values()), run.source)
    with given.progress("preparing photos") as advance:
        prepared = prepare_photos(
            given.inputs,
            folder,
            max_size=run.max_size,
            rig=run.rig,
            panorama=panorama,
            masks_of=given.masks,
            progress=advance,
        )
    spheres = [photo["source"] for photo in prepared["photos"] if photo["sphere"]]
    if spheres:
        raise InputError(
            f"{spheres[0]} in {run.source} is a panorama by its metadata: add --lens panorama to "
            "`mobilegs capture` if all photos are, or take it out"
        )
    return prepared


def features(given: StageInputs, photos: list[PreparedPhoto]) -> dict[str, Any]:
    """Write features of the photos into the database."""
    workspace = given.workspace
    arguments = (workspace.database, workspace.photos, photos)
    options = {"lens": given.run.lens, "masks": workspace.photo_masks}
    return given.call("finding features", extract_features, *arguments, **options)


def matches(given: StageInputs, photos: list[PreparedPhoto]) -> dict[str, Any]:
    """Write matches of the photos into the database."""
    names = [photo.name for photo in photos]
    return given.call(
        "matching photos",
        match_photos,
        given.workspace.database,
        names,
        pairs=given.run.pairs,
        apart=given.run.lens == "panorama",
    )


def model(given: StageInputs, photos: list[PreparedPhoto]) -> dict[str, Any]:
    """Compute poses and points, and draw their coverage even if they are too few."""
    workspace, panorama = given.workspace, given.run.lens == "panorama"
    mapped = given.call(
        "computing poses",
        map_photos,
        workspace.database,
        workspace.photos,
        workspace.models,
        mapper=given.run.mapper,
        total=len(sources(photos)),
        enough=enough_photos(given.run, len(photos)),
        rig="faces" if panorama else "cameras" if given.run.rig else "none",
    )
    if given.run.rig and not mapped["rig"]:
        log.warning(
            "the photos do not show how the cameras sit on the rig: they are placed one by one"
        )
    if mapped["models"]:
        draw_coverage(
            workspace.coverage,
            given.process.call("reading poses", read_geometry, workspace.models / "best"),
            title=f"poses for {len(placed(photos, mapped))} of {len(sources(photos))} photos, "
            f"{mapped['points']:,} points, "
            f"{mapped['reprojection_error']:.2f} px reprojection error",
            points_of_photos={
                photo.name: mapped["points_of_photos"].get(photo.name, 0) for photo in photos
            },
        )
    return mapped


def finish(given: StageInputs, photos: list[PreparedPhoto]) -> dict[str, Any]:
    """Write `images/`, `masks/` if any, and `sparse/0/`, poses last, and return the report."""
    workspace = given.workspace
    given_files = workspace.models / "best", workspace.photos, workspace.photo_masks
    output = workspace.undistorted
    with given.progress("undistorting photos"):
        if given.run.lens == "fisheye":  # a pinhole photo shows no more than its middle
            names = (workspace.read("model") or {})["registered"]
            keep_photos(*given_files, output, names)
        else:
            doing = "undistorting photos"
            given.process.call(doing, undistort_photos, *given_files, output)
    workspace.sparse.mkdir()
    for folder in (workspace.images, workspace.masks):
        if (output / folder.name).exists():
            (output / folder.name).replace(folder)
    (workspace.undistorted / "sparse").replace(workspace.sparse / "0")
    shutil.rmtree(workspace.undistorted)
    records = {
        name: workspace.read(name) or {} for name in ("photos", "features", "matches", "model")
    }
    mapped, compared = records["model"], records["matches"]
    return {
        "source": given.run.source.name,
        "photos": len(sources(photos)),
        "registered": len(placed(photos, mapped)),
        "left_out": left_out(photos, mapped),
        "converted": records["photos"].get("converted", {}),
        "unreadable": records["photos"].get("unreadable", []),
        "other_files": {} if is_video(given.inputs[0]) else other_files(given.inputs),
        "features_a_photo": records["features"]["features"],
        **{name: compared[name] for name in ("pairs", "compared", "verified")},
        "tried": mapped.get("tried", [mapped["mapper"]]),
        **{name: mapped[name] for name in REPORTED},
        "exposures": {photo.name: photo.exposure for photo in photos if photo.exposure is not None},
        "rig": mapped.get("rig", False),
        "seconds_of": {name: record["seconds"] for name, record in records.items()},
    }


# --- inputs and checks ----------------------------------------------------------------------------


def is_capture_source(path: Path) -> bool:
    """Return whether `path` is a video, or a folder with photos or a video in it."""
    files = [path] if path.is_file() else list_files(path)
    return any(is_video(file) or (file != path and file.suffix.lower() in PHOTOS) for file in files)


def list_inputs(source: Path, *, rig: bool = False) -> list[Path]:
    """Return the video or the photos at `source`, and log what else lies there.

    Raises InputError if there are too few photos, or several videos to choose from.
    """
    if is_video(source):
        return [source]
    if not source.exists():
        raise InputError(f"{source} does not exist: give a folder of photos, or a video")
    if not source.is_dir():
        raise InputError(
            f"{source} is not a video ({', '.join(VIDEOS)}): give one, or a folder of photos"
        )
    photos = list_photos(source, rig=rig)
    if poses := other_poses(source):
        log.warning("%s", poses)
    videos = [file for file in list_files(source) if is_video(file)]
    if len(photos) < PHOTOS_MIN and videos:
        return [only_video(source, videos)]
    if not photos:
        raise InputError(f"{source} has no photos in it ({', '.join(PHOTOS)})")
    if len(photos) < PHOTOS_MIN:
        raise InputError(
            f"{source} holds {len(photos)} photo{'s' * (len(photos) > 1)}: a scene needs at least "
            f"{PHOTOS_MIN}, and 30 or more to look good"
        )
    if videos:
        log.warning("%s: its photos are used, not its videos: %s", source, named(videos))
    return photos


def only_video(source: Path, videos: list[Path]) -> Path:
    """Return the one video of a folder, or the one ten times larger than each other, and log it."""
    *others, largest = sorted(videos, key=lambda video: video.stat().st_size)
    if others and others[-1].stat().st_size * 10 > largest.stat().st_size:
        raise InputError(f"{source} holds {len(videos)} videos ({named(videos)}): give one of them")
    rest = f", not {named(others)}" if others else ""
    log.warning("%s holds too few photos: its video %s is used%s", source, largest.name, rest)
    return largest


def named(files: list[Path]) -> str:
    """Return the names of the first files."""
    names = ", ".join(file.name for file in files[:NAMES_MAX])
    return names + f" and {len(files) - NAMES_MAX} more" * (len(files) > NAMES_MAX)


def masks_of_inputs(source: Path, inputs: list[Path]) -> dict[Path, Path]:
    """Return the masks of photos that have one: in or beside the folder that all photos share."""
    if is_video(inputs[0]):
        return {}
    root = Path(commonpath([path.resolve().parent for path in inputs]))
    photos = {path.parent.resolve() / path.name: path for path in inputs}
    found = find_masks(list(photos), root.parent)
    outside = [mask for mask in found.values() if source.resolve() not in mask.parents]
    if outside:
        log.warning("%d masks are used from %s", len(outside), outside[0].parent)
    return {photos[photo]: mask for photo, mask in found.items()}


def digest_inputs(inputs: list[Path], progress: Advance) -> list[tuple[str, str]]:
    """Return (name, SHA-256) of every input."""
    digests = []
    for done, (path, name) in enumerate(zip(inputs, relative_names(inputs), strict=True), start=1):
        digests.append((name, file_digest(path)))
        progress(done, len(inputs))
    return digests


def sources(photos: list[PreparedPhoto]) -> list[str]:
    """Return the original names, each once: the faces of a panorama have one."""
    return list(dict.fromkeys(photo.source for photo in photos))


def placed(photos: list[PreparedPhoto], mapped: dict[str, Any]) -> list[str]:
    """Return the original names of photos with a pose."""
    names = set(mapped["registered"])
    return sources([photo for photo in photos if photo.name in names])


def left_out(photos: list[PreparedPhoto], mapped: dict[str, Any]) -> list[str]:
    """Return the original names of photos without a pose."""
    names = set(placed(photos, mapped))
    return [source for source in sources(photos) if source not in names]


def validate_options(run: CaptureRun) -> None:
    if run.max_size < SIZE_MIN:
        raise InputError(f"--max-size must be {SIZE_MIN} pixels or more, got {run.max_size}")
    if run.frames is not None and run.frames < PHOTOS_MIN:
        raise InputError(f"--frames must be {PHOTOS_MIN} or more, got {run.frames}")
    if not 0 <= run.min_placed <= 1:
        raise InputError(f"--min-placed must lie between 0 and 1, got {run.min_placed}")
    if run.rig and run.lens == "panorama":
        raise InputError("the faces of a panorama are a rig of their own: leave out --rig")


def enough_photos(run: CaptureRun, total: int) -> int:
    """Return the number of photos with a pose, of `total`, below which there is no capture."""
    return max(PHOTOS_MIN, math.ceil(run.min_placed * total))


def validate_placed(placed: int, missing: list[str], given: StageInputs) -> None:
    """Raise InputError with advice if too few photos have a pose."""
    total = placed + len(missing)
    if placed >= enough_photos(given.run, total):
        return
    named = ", ".join(missing[:NAMES_MAX]) + (" ..." if len(missing) > NAMES_MAX else "")
    hint = f"; {given.workspace.coverage} shows where photos are missing" if placed else ""
    raise InputError(
        f"found poses for only {placed} of {total} photos (not for {named}): take more photos, "
        "with more overlap (everything in at least three photos), step sideways instead of turning "
        "on the spot, keep photos sharp and the light even, and choose a scene that has texture "
        f"and does not move{hint}"
    )
