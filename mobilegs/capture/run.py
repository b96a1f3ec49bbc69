"""From photos or a video to a capture that can be trained: all stages, and the report."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mobilegs.capture.coverage import draw_coverage
from mobilegs.capture.engine import SEED, Progress, engine
from mobilegs.capture.features import Lens, extract_features
from mobilegs.capture.mapping import Mapper, map_photos, read_geometry, undistort_photos
from mobilegs.capture.matches import Pairs, forget_matches, match_photos
from mobilegs.capture.photos import HEIC, Prepared, list_photos, prepare_photos
from mobilegs.capture.video import SUFFIXES as VIDEOS
from mobilegs.capture.video import is_video, prepare_video
from mobilegs.capture.workspace import Workspace, digest, file_digest
from mobilegs.data import images
from mobilegs.errors import InputError

VERSION = 1  # of what stages do: another one does them anew
FEWEST = 3  # photos that must be placed, whatever share that is
NAMED = 5  # photos that were left out and are named in a sentence

Bar = Callable[[str], AbstractContextManager[Progress]]


@dataclass(frozen=True)
class CaptureOptions:
    """How photos become a capture; `mobilegs capture --help` has the words.

    Attributes:
        max_size: longest side of the photos, in pixels, 64 or more.
        frames: taken from a video; None for 3 a second and at most 240.
        lens: how distortion is modelled: `simple` by one number, `opencv` by four.
        pairs: which photos are compared: `all`, `alike`, or `auto` by their number.
        mapper: `incremental`, `global`, or `auto` by their number.
        least: share of the photos that must be placed, 0 to 1.
    """

    max_size: int = 1600
    frames: int | None = None
    lens: Lens = "simple"
    pairs: Pairs = "auto"
    mapper: Mapper = "auto"
    least: float = 0.5


def capture_photos(
    source: Path,
    output: Path,
    options: CaptureOptions | None = None,
    *,
    bar: Bar = lambda what: nullcontext(lambda done, total: None),
) -> dict[str, Any]:
    """Make a capture (`images/`, `sparse/0/`) of photos or a video; returns `capture.json`.

    What an earlier call did with the same input and options is kept: an interrupted capture goes
    on, a finished one is left as it is. `bar` opens a progress bar for a stage. Raises InputError
    for input that cannot be used, where pycolmap is missing, and where too few photos could be
    placed; then neither `images/` nor `sparse/` is there.
    """
    options = options or CaptureOptions()
    refuse_options(options)
    engine()
    space, inputs = Workspace(output), input_of(source)
    if output.resolve() in (source.resolve(), *(path.resolve().parent for path in inputs)):
        raise InputError(f"{output} holds the photos: give another folder for the capture")
    space.open()
    with bar("reading") as progress:
        key = digest(VERSION, options.max_size, options.frames, *digests(inputs, progress))
    record = space.run("photos", key, lambda: prepare(source, inputs, space, options, bar))
    photos = [Prepared(**photo) for photo in record["photos"]]
    names = [photo.name for photo in photos]

    def features() -> dict[str, Any]:
        with bar("features") as progress:
            return extract_features(
                space.database, space.photos, photos, lens=options.lens, progress=progress
            )

    def matches() -> dict[str, Any]:
        with bar("matching") as progress:
            return match_photos(space.database, names, pairs=options.pairs, progress=progress)

    def model() -> dict[str, Any]:
        with bar("placing") as progress:
            found = map_photos(
                space.database,
                space.photos,
                space.models,
                mapper=options.mapper,
                total=len(names),
                progress=progress,
            )
        if found["models"]:
            draw(space, names, found)
        return found

    def finish() -> dict[str, Any]:
        with bar("undistorting"):
            undistort_photos(space.models / "best", space.photos, space.undistorted)
        install(space)
        return report(source, space, photos)

    key = digest(key, SEED, options.lens)
    space.run("features", key, features)
    key = digest(key, options.pairs)
    if (before := space.read("matches")) is not None and before["key"] != key:
        space.forget("matches")
        forget_matches(space.database)
    space.run("matches", key, matches)
    key = digest(key, options.mapper)
    found = space.run("model", key, model)
    refuse_few(found, photos, options.least, space)
    return space.run("capture", key, finish)


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


def prepare(
    source: Path, inputs: list[Path], space: Workspace, options: CaptureOptions, bar: Bar
) -> dict[str, Any]:
    """The record of the first stage."""
    if is_video(source):
        with bar("sharpest frames") as progress:
            return prepare_video(
                source,
                space.photos,
                frames=options.frames,
                max_size=options.max_size,
                progress=progress,
            )
    if options.frames is not None:
        raise InputError(f"{source} is no video: leave out --frames")
    with bar("photos") as progress:
        return prepare_photos(inputs, space.photos, max_size=options.max_size, progress=progress)


def draw(space: Workspace, names: list[str], found: dict[str, Any]) -> None:
    """Leave `coverage.png`, also where too few photos were placed."""
    title = (
        f"{len(found['registered'])} of {len(names)} photos placed, {found['points']:,} points, "
        f"{found['reprojection_error']:.2f} px reprojection error"
    )
    draw_coverage(
        space.coverage,
        read_geometry(space.models / "best"),
        title=title,
        points_of_photos={name: found["points_of_photos"].get(name, 0) for name in names},
    )


def install(space: Workspace) -> None:
    """Move what undistortion made to where `load_capture` reads it; the poses come last."""
    space.sparse.mkdir()
    (space.undistorted / "images").replace(space.images)
    (space.undistorted / "sparse").replace(space.sparse / "0")


def report(source: Path, space: Workspace, photos: list[Prepared]) -> dict[str, Any]:
    """What `capture.json` holds: the figures of all stages, and how long each took."""
    records = {stage: space.read(stage) or {} for stage in ("photos", "features", "matches")}
    model = space.read("model") or {}
    of = {photo.name: photo.source for photo in photos}
    placed = set(model["registered"])
    return {
        "source": source.name,
        "photos": len(photos),
        "registered": len(placed),
        "left_out": [of[name] for name in of if name not in placed],
        "features_a_photo": records["features"]["features"],
        **{name: model[name] for name in ("reprojection_error", "points", "photos_a_point")},
        **{name: records["matches"][name] for name in ("pairs", "compared", "verified")},
        **{name: model[name] for name in ("mapper", "models", "cameras", "points_of_photos")},
        "seconds_of": {
            stage: record["seconds"] for stage, record in {**records, "model": model}.items()
        },
    }


def refuse_options(options: CaptureOptions) -> None:
    """InputError for an option outside of its range."""
    if options.max_size < 64:
        raise InputError(f"photos of {options.max_size} pixels show nothing: give 64 or more")
    if options.frames is not None and options.frames < FEWEST:
        raise InputError(f"{options.frames} frames make no scene: give {FEWEST} or more")
    if not 0 <= options.least <= 1:
        raise InputError(f"a share lies between 0 and 1, not at {options.least}")


def refuse_few(
    found: dict[str, Any], photos: list[Prepared], least: float, space: Workspace
) -> None:
    """InputError with advice if too few photos were placed."""
    placed = set(found["registered"])
    if len(placed) >= max(FEWEST, least * len(photos)):
        return
    missing = [photo.source for photo in photos if photo.name not in placed]
    named = ", ".join(missing[:NAMED]) + (" ..." if len(missing) > NAMED else "")
    seen = f"; {space.coverage} shows what could be" if placed else ""
    raise InputError(
        f"only {len(placed)} of {len(photos)} photos could be placed (not {named}): take more, with "
        "more overlap (each thing in three photos at least), moving sideways in small steps rather "
        "than turning on the spot, sharp, in even light, of something with texture that keeps still"
        f"{seen}"
    )


