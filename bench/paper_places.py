"""The captures that bench/paper.py trains: where they may lie, and how each is used."""

from dataclasses import dataclass, replace
from pathlib import Path

from mobilegs.train.recipes import PresetName


@dataclass(frozen=True)
class Place:
    """A capture, where it may lie, and how it is used."""

    group: str
    folders: tuple[str, ...]
    downscale: int | None
    """What the photos' size is divided by; None: at most 1600 pixels wide."""
    metric: str = "indoor"
    """Of the importance that simplification goes by."""
    preset: PresetName = "gpu"
    settings: tuple[str, ...] = ()
    """What differs from the preset."""
    of_3dgs: tuple[str, ...] = ()
    """What else does where 3DGS is the teacher."""
    protocol: str = "paper"
    """Of the photos' size; `standard` only where that is another one."""


# all points to begin with; 3DGS knows no limit, and makes six million Gaussians of some captures
ALL_POINTS = ("teacher.init_splats=1000000",)
NO_LIMIT = ("teacher.max_splats=20000000",)


def _standard(group: str, parents: tuple[str, ...], scenes: dict[str, tuple[str, int | None]]):
    more = {"settings": ALL_POINTS, "of_3dgs": NO_LIMIT}
    return {
        name: Place(
            group, (*(f"{parent}/{name}" for parent in parents), name), downscale, metric, **more
        )
        for name, (metric, downscale) in scenes.items()
    }


def _small(most: int) -> tuple[str, ...]:
    """Mini-Splatting leaves half of its budget, and 5,000 steps are too few for it."""
    return ("teacher.steps=10000", f"teacher.max_splats={most}")


OUTDOOR, INDOOR = ("outdoor", 4), ("indoor", 2)
PLACES: dict[str, Place] = {
    **_standard(
        "mipnerf360",
        ("mipnerf360", "360_v2", "360"),
        {
            **dict.fromkeys(("bicycle", "flowers", "garden", "stump", "treehill"), OUTDOOR),
            **dict.fromkeys(("room", "counter", "kitchen", "bonsai"), INDOOR),
        },
    ),
    **_standard(
        "tandt",
        ("tandt", "tanks_and_temples", "tandt_db/tandt"),
        dict.fromkeys(("train", "truck"), ("outdoor", None)),
    ),
    **_standard(
        "db",
        ("db", "deep_blending", "tandt_db/db"),
        dict.fromkeys(("drjohnson", "playroom"), ("indoor", None)),
    ),
    # what two cores can do, and the same captures at their full size for a GPU
    "bonsai-400": Place("small", ("bonsai",), 2, preset="cpu", settings=_small(100_000)),
    "horns-250": Place("small", ("llff_horns",), 2, preset="cpu", settings=_small(60_000)),
    "lego-200": Place("small", ("lego",), 4, preset="cpu", settings=_small(60_000)),
    "bonsai-800": Place("full", ("bonsai",), 1),
    "horns-499": Place("full", ("llff_horns",), 1),
    "lego-800": Place("full", ("lego",), 1),
}
TITLES = {"mipnerf360": "Mip-NeRF 360", "tandt": "Tanks and Temples", "db": "Deep Blending"}


def found_in(data: Path, place: Place) -> Path | None:
    """The first of a place's folders that is there."""
    return next((data / name for name in place.folders if (data / name).is_dir()), None)


def shown_as(place: Place, protocol: str) -> Place:
    """The place with the photos' size of a protocol: only Mip-NeRF 360 knows two."""
    if place.group != "mipnerf360":
        return place
    if protocol == "paper":
        return replace(place, downscale=None)
    return replace(place, protocol=protocol)
