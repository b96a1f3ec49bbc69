"""The types of what `mgs.codec.inspect` reports about a file."""

from typing import Any, NotRequired, TypedDict

from mobilegs.mgs.quantized_scene import MetaValue

PARTS = {
    "positions": "positions",
    "scale": "scales",
    "rotation": "rotations",
    "rotation-finer": "rotations",
    "appearance": "colour",
    "opacity": "opacity",
    "lobes": "view-dependent opacity and weight",
    "color-matrices": "networks and matrices",
    "color-networks": "networks and matrices",
    "appearance-decoder": "networks and matrices",
    "lobe-decoder": "networks and matrices",
    "view-network": "networks and matrices",
    "codebooks": "codebooks",
}
UNUSED = "unused streams"


class StreamContents(TypedDict):
    """A stream of a `.mgs`.

    Attributes:
        name: of the stream, which ends with `@LEVEL` if the file has LOD levels.
        codec: name of its coding.
        bytes: its size in the file.
        bytes_per_gaussian: the same, divided by the file's Gaussians.
        used: False for a stream that the header does not need.
        raw_bytes: size without an entropy coder; None if the stream is not used.
    """

    name: str
    codec: str
    bytes: int
    bytes_per_gaussian: float
    used: bool
    raw_bytes: int | None


class MgsContents(TypedDict):
    """The content of a `.mgs`, as JSON values, by the names of docs/reference/format.md.

    Attributes:
        version: of the format, `MAJOR.MINOR`.
        blend: `sortfree` or `sorted`.
        gaussians: their number.
        file_bytes: the sum of `header_bytes`, `padding_bytes` and the bytes of all `streams`.
        layers: Gaussians of each LOD level, the coarsest first; missing without LOD levels.
        mode: `sq` with `step_sizes`, `nvq` with `codebook_sizes`.
        lobes: degree, latents and hidden layers of the lobe decoder; None without one.
        network: True if a network is evaluated for every view.
        views: number of cameras for a first look.
        near: near plane, in world units.
        footprint: missing for that of 3DGS.
        meta: notes for people.
    """

    version: str
    blend: str
    sh_degree: int
    colors: str
    color_latents: int
    file_bytes: int
    gaussians: int
    bytes_per_gaussian: float
    header_bytes: int
    padding_bytes: int
    streams: list[StreamContents]
    layers: NotRequired[list[int]]
    mode: str
    step_sizes: NotRequired[dict[str, float]]
    codebook_sizes: NotRequired[dict[str, int]]
    lobes: dict[str, Any] | None
    network: bool
    views: int
    near: float
    weighting: dict[str, Any]
    footprint: NotRequired[dict[str, Any]]
    meta: dict[str, MetaValue]


def bytes_by_part(contents: MgsContents) -> dict[str, int]:
    """Return the bytes of each part of a scene, of all LOD levels together, by names for people."""
    parts: dict[str, int] = {}
    for stream in contents["streams"]:
        name = stream["name"].split("@")[0].split(".")[0]
        part = PARTS[name] if stream["used"] else UNUSED
        parts[part] = parts.get(part, 0) + stream["bytes"]
    parts["header"] = contents["header_bytes"] + contents["padding_bytes"]
    return parts
