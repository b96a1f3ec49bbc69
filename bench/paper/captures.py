"""The captures of the paper's tables: their folders, photo sizes and presets."""

from dataclasses import dataclass, replace
from pathlib import Path

from mobilegs.train.recipes import PresetName


@dataclass(frozen=True)
class BenchCapture:
    """A capture, the folders it may lie in, and how it is trained."""

    group: str
    folders: tuple[str, ...]
    downscale: int | None
    """Divisor of the photo size; None: at most 1600 pixels wide."""
    metric: str = "indoor"
    """Metric of importance in Mini-Splatting's simplification: indoor or outdoor."""
    preset: PresetName = "long"
    settings: tuple[str, ...] = ()
    """Settings that differ from the preset."""
    arc: bool = False
    """True: the photos around one place are held back, not every eighth."""
    settings_3dgs: tuple[str, ...] = ()
    """Further settings where 3DGS is the teacher."""
    protocol: str = "paper"
    """Protocol of the photo size: `paper`, or `standard` where the two sizes differ."""


# start from all points; 3DGS has no limit and makes six million Gaussians of some captures
ALL_POINTS = ("teacher.init_splats=1000000",)
NO_LIMIT = ("teacher.max_splats=20000000",)


def _standard(group: str, parents: tuple[str, ...], scenes: dict[str, tuple[str, int | None]]):
    more = {"settings": ALL_POINTS, "settings_3dgs": NO_LIMIT}
    return {
        name: BenchCapture(
            group, (*(f"{parent}/{name}" for parent in parents), name), downscale, metric, **more
        )
        for name, (metric, downscale) in scenes.items()
    }


def _small_budget(most: int) -> tuple[str, ...]:
    """Return settings for a small budget, half of which Mini-Splatting keeps."""
    return ("teacher.steps=10000", f"teacher.max_splats={most}")


OUTDOOR, INDOOR = ("outdoor", 4), ("indoor", 2)
CAPTURES: dict[str, BenchCapture] = {
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
    # small enough for two cores; full photos with a small budget; full size for a GPU
    "bonsai-400": BenchCapture(
        "small", ("bonsai",), 2, preset="short", settings=_small_budget(100_000)
    ),
    "horns-250": BenchCapture(
        "small", ("llff_horns",), 2, preset="short", settings=_small_budget(60_000)
    ),
    "lego-200": BenchCapture("small", ("lego",), 4, preset="short", settings=_small_budget(60_000)),
    "stitch-359": BenchCapture(
        "small", ("stitch",), 2, preset="short", settings=_small_budget(80_000)
    ),
    "south-604": BenchCapture(
        "small", ("south_building",), 2, "outdoor", preset="short", settings=_small_budget(120_000)
    ),
    "bonsai-800-short": BenchCapture(
        "medium", ("bonsai",), 1, preset="short", settings=_small_budget(100_000)
    ),
    "south-1208-short": BenchCapture(
        "medium", ("south_building",), 1, "outdoor", preset="short", settings=_small_budget(120_000)
    ),
    "bonsai-800": BenchCapture("full", ("bonsai",), 1),
    "horns-499": BenchCapture("full", ("llff_horns",), 1),
    "lego-800": BenchCapture("full", ("lego",), 1),
    "south-1208": BenchCapture("full", ("south_building",), 1, "outdoor"),
}
# what a student shows where no photo was taken
CAPTURES |= {
    f"{name}-arc": replace(CAPTURES[name], group="arcs", arc=True)
    for name in ("bonsai-400", "bonsai-800", "horns-250", "stitch-359", "south-604")
}
TITLES = {"mipnerf360": "Mip-NeRF 360", "tandt": "Tanks and Temples", "db": "Deep Blending"}


def find_capture(data: Path, place: BenchCapture) -> Path | None:
    """Return the first folder of a capture that exists."""
    return next((data / name for name in place.folders if (data / name).is_dir()), None)


def with_protocol(place: BenchCapture, protocol: str) -> BenchCapture:
    """Return the capture at a protocol's photo size; only Mip-NeRF 360 has two sizes."""
    if place.group != "mipnerf360":
        return place
    if protocol == "paper":
        return replace(place, downscale=None)
    return replace(place, protocol=protocol)
