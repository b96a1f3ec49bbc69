"""Where the pictures that `mobilegs render` draws go."""

from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from mobilegs.data.dataset import Dataset, Frame
from mobilegs.errors import InputError


def picture_paths(frames: Sequence[Frame], dataset: Dataset, output: Path) -> list[Path]:
    """A path in `output` for the picture of each of some frames.

    Raises InputError if that is one of the capture's own photos or masks.
    """
    names = png_names([frame.name for frame in frames])
    paths = [output / names[frame.name] for frame in frames]
    kept = set()
    for frame in (*dataset.train, *dataset.test):
        kept |= {path.resolve() for path in (frame.image_path, frame.mask_path) if path}
    for path in paths:
        if path.resolve() in kept:
            raise InputError(f"{path} is a photo of the capture: give another folder for pictures")
    return paths


def png_names(photos: Sequence[str]) -> dict[str, Path]:
    """Where each photo's picture goes, relative to the output folder: its name, but PNG.

    Photos that differ only in their extension keep it: a.jpg, a.png -> a.jpg.png, a.png.png.
    A capture is not trusted to stay inside the folder.
    """
    parts = {
        photo: [p for p in PurePosixPath(photo.replace("\\", "/")).parts if p.strip("/.: ")]
        for photo in photos
    }
    short = {photo: Path(*parts[photo]).with_suffix(".png") for photo in photos}
    counts = list(short.values())
    return {
        photo: name
        if counts.count(name) == 1
        else Path(*parts[photo][:-1], f"{parts[photo][-1]}.png")
        for photo, name in short.items()
    }
