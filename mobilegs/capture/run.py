"""From photos or a video to a capture that can be trained: all stages, and the report."""

import shutil
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import Positional, arg

from mobilegs.capture.coverage import draw_coverage
from mobilegs.capture.engine import SEED, Progress, engine
from mobilegs.capture.features import Lens, extract_features
from mobilegs.capture.mapping import Mapper, map_photos, read_geometry, undistort_photos
from mobilegs.capture.matches import Pairs, forget_matches, match_photos
from mobilegs.capture.photos import FEWEST, HEIC, Prepared, list_photos, prepare_photos
from mobilegs.capture.video import SUFFIXES as VIDEOS
from mobilegs.capture.video import is_video, prepare_video
from mobilegs.capture.workspace import Workspace, digest, file_digest
from mobilegs.data import images
from mobilegs.errors import InputError

VERSION = 1  # of what stages do: another one does them anew
SMALLEST = 64  # pixels of a photo's longer side
NAMED = 5  # photos that were left out and are named in a sentence

Bar = Callable[[str], AbstractContextManager[Progress]]


@dataclass(frozen=True)
class CaptureRun:
    """Find out where photos were taken, or the frames of a video: a capture for training.

    CAPTURE then holds images/ and sparse/0/ (photos without distortion, and their poses, as COLMAP
    leaves them), capture.json with all figures, and coverage.png. Ctrl-C is safe: the same command
    goes on, and does nothing anew that is done. What it works with is in CAPTURE/work, which may
    be deleted in the end.
    """

    source: Annotated[Positional[Path], arg(metavar="PHOTOS|VIDEO")]
    """Folder of the photos (HEIC too), or a video."""
    output: Annotated[Path, arg(aliases=["-o"], metavar="CAPTURE")]
    """Folder for the capture; it is made if it is missing."""
    max_size: Annotated[int, arg(metavar="PIXELS")] = 1600
    """Photos are reduced until their longer side has so many pixels."""
    frames: Annotated[int | None, arg(metavar="N")] = None
    """How many frames of a video to take, the sharpest of each stretch of time. Without it 3 a
    second, and 240 at most."""
    lens: Lens = "simple"
    """How its distortion is modelled: simple with one number, opencv with four, for wide lenses
    and many photos."""
    pairs: Pairs = "auto"
    """Which photos to compare. all: every two. alike: each with those next to it by name, and with
    20 that look like it. auto: all up to 80 photos, alike beyond."""
    mapper: Mapper = "auto"
    """How photos are placed. incremental: one after the other. global: all at once. auto:
    incremental up to 250 photos, global beyond."""
    least: Annotated[float, arg(metavar="SHARE")] = 0.5
    """Stop if a smaller share of the photos can be placed."""


@dataclass(frozen=True)
class Job:
    """What all stages need. `bar` opens a progress bar."""

    run: CaptureRun
    inputs: list[Path]
    space: Workspace
    bar: Bar


def capture_photos(
    run: CaptureRun, *, bar: Bar = lambda what: nullcontext(lambda done, total: None)
) -> dict[str, Any]:
    """Make a capture (`images/`, `sparse/0/`) of photos or a video; returns `capture.json`.

    What an earlier call did with the same input and options is kept: an interrupted capture goes
    on, a finished one is left as it is. `bar` opens a progress bar for a stage. Raises InputError
    for input that cannot be used, where pycolmap is missing, and where too few photos could be
    placed, which leaves neither `images/` nor `sparse/`.
    """
    refuse_options(run)
    engine()
    inputs = input_of(run.source)
    holders = (run.source.resolve(), *(path.resolve().parent for path in inputs))
    if run.output.resolve() in holders:
        raise InputError(f"{run.output} holds the photos: give another folder for the capture")
    job = Job(run, inputs, Workspace(run.output), bar)
    job.space.refuse_foreign()
    with bar("reading") as progress:
        keys = keys_of(run, digests(inputs, progress))
    done = job.space.finished(keys["capture"])
    if done is None:
        done = go_through(job, keys)
    refuse_few(done["registered"], done["left_out"], job)
    return done


def go_through(job: Job, keys: dict[str, str]) -> dict[str, Any]:
    """Do what is left of all stages, and return the record of the last one."""
    space = job.space
    record = space.run("photos", keys["photos"], lambda: prepare(job))
    photos = [Prepared(**photo) for photo in record["photos"]]
    space.run("features", keys["features"], lambda: features(job, photos))
    before = space.read("matches")
    if before is not None and before["key"] != keys["matches"]:
        space.forget("matches")
        forget_matches(space.database)
    space.run("matches", keys["matches"], lambda: matches(job, photos))
    found = space.run("model", keys["model"], lambda: model(job, photos))
    refuse_few(len(found["registered"]), left_out(photos, found), job)
    return space.run("capture", keys["capture"], lambda: finish(job, photos))


def keys_of(run: CaptureRun, inputs: list[tuple[str, str]]) -> dict[str, str]:
    """The key of every stage: of all that decides what it leaves."""
    key, keys = digest(VERSION, SEED, inputs), {}
    for stage, own in (
        ("photos", [run.max_size, run.frames]),
        ("features", run.lens),
        ("matches", run.pairs),
        ("model", run.mapper),
        ("capture", None),
    ):
        keys[stage] = key = digest(key, own)
    return keys


# --- the stages -----------------------------------------------------------------------------------


def prepare(job: Job) -> dict[str, Any]:
    """Upright photos of a size."""
    run, folder = job.run, job.space.photos
    if is_video(run.source):
        with job.bar("sharpest frames") as progress:
            return prepare_video(
                run.source,
                folder,
                frames=run.frames,
                max_size=run.max_size,
                progress=progress,
            )
    if run.frames is not None:
        raise InputError(f"{run.source} is no video: leave out --frames")
    with job.bar("photos") as progress:
        return prepare_photos(job.inputs, folder, max_size=run.max_size, progress=progress)


def features(job: Job, photos: list[Prepared]) -> dict[str, Any]:
    """Their features, in the database."""
    with job.bar("features") as progress:
        return extract_features(
            job.space.database, job.space.photos, photos, lens=job.run.lens, progress=progress
        )


def matches(job: Job, photos: list[Prepared]) -> dict[str, Any]:
    """What photos have in common, in the database."""
    names = [photo.name for photo in photos]
    with job.bar("matching") as progress:
        return match_photos(job.space.database, names, pairs=job.run.pairs, progress=progress)


def model(job: Job, photos: list[Prepared]) -> dict[str, Any]:
    """Poses and points, and a picture of them, also of too few."""
    space = job.space
    with job.bar("placing") as progress:
        found = map_photos(
            space.database,
            space.photos,
            space.models,
            mapper=job.run.mapper,
            total=len(photos),
            progress=progress,
        )
    if found["models"]:
        draw_coverage(
            space.coverage,
            read_geometry(space.models / "best"),
            title=f"{len(found['registered'])} of {len(photos)} photos placed, "
            f"{found['points']:,} points, {found['reprojection_error']:.2f} px reprojection error",
            points_of_photos={
                photo.name: found["points_of_photos"].get(photo.name, 0) for photo in photos
            },
        )
    return found


def finish(job: Job, photos: list[Prepared]) -> dict[str, Any]:
    """`images/` and `sparse/0/` where `load_capture` reads them, the poses last; the report."""
    space = job.space
    with job.bar("undistorting"):
        undistort_photos(space.models / "best", space.photos, space.undistorted)
    space.sparse.mkdir()
    (space.undistorted / "images").replace(space.images)
    (space.undistorted / "sparse").replace(space.sparse / "0")
    shutil.rmtree(space.undistorted)
    records = {name: space.read(name) or {} for name in ("photos", "features", "matches", "model")}
    found, compared = records["model"], records["matches"]
    return {
        "source": job.run.source.name,
        "photos": len(photos),
        "registered": len(found["registered"]),
        "left_out": left_out(photos, found),
        "features_a_photo": records["features"]["features"],
        **{name: compared[name] for name in ("pairs", "compared", "verified")},
        **{name: found[name] for name in ("mapper", "models", "reprojection_error", "points")},
        **{name: found[name] for name in ("photos_a_point", "cameras", "points_of_photos")},
        "misplaced": found["misplaced"],
        "seconds_of": {name: record["seconds"] for name, record in records.items()},
    }


# --- input, and what is refused -------------------------------------------------------------------


def is_source(path: Path) -> bool:
    """Whether `path` is a video, or a folder with photos in it or in its `images/`."""
    return is_video(path) or bool(list_photos(path))


def input_of(source: Path) -> list[Path]:
    """The video, or the photos. InputError where there are none."""
    if is_video(source):
        return [source]
    if not source.exists():
        raise InputError(f"there is nothing at {source}: give a folder of photos, or a video")
    if not source.is_dir():
        raise InputError(
            f"{source} is no video ({', '.join(VIDEOS)}): give one, or a folder of photos"
        )
    found = list_photos(source)
    if not found:
        kinds = ", ".join(images.SUFFIXES + HEIC)
        raise InputError(f"{source} has no photos in it ({kinds})")
    return found


def digests(inputs: list[Path], progress: Progress) -> list[tuple[str, str]]:
    """Name and content of every input."""
    found = []
    for done, path in enumerate(inputs, start=1):
        found.append((path.name, file_digest(path)))
        progress(done, len(inputs))
    return found


def left_out(photos: list[Prepared], found: dict[str, Any]) -> list[str]:
    """The sources of the photos that have no pose."""
    placed = set(found["registered"])
    return [photo.source for photo in photos if photo.name not in placed]


def refuse_options(run: CaptureRun) -> None:
    """InputError for an option outside of its range."""
    if run.max_size < SMALLEST:
        raise InputError(
            f"photos of {run.max_size} pixels show too little: give {SMALLEST} or more"
        )
    if run.frames is not None and run.frames < FEWEST:
        raise InputError(f"{run.frames} frames make no scene: give {FEWEST} or more")
    if not 0 <= run.least <= 1:
        raise InputError(f"a share lies between 0 and 1, not at {run.least}")


def refuse_few(placed: int, missing: list[str], job: Job) -> None:
    """InputError with advice if too few photos were placed."""
    total = placed + len(missing)
    if placed >= max(FEWEST, job.run.least * total):
        return
    named = ", ".join(missing[:NAMED]) + (" ..." if len(missing) > NAMED else "")
    seen = f"; {job.space.coverage} shows what could be" if placed else ""
    raise InputError(
        f"only {placed} of {total} photos could be placed (not {named}): take more of them, with "
        "more overlap (each thing in three photos at least), moving sideways in small steps "
        "rather than turning on the spot, sharp, in even light, of something with texture that "
        f"keeps still{seen}"
    )
