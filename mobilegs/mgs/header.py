"""The fields of a scene that the header of a `.mgs` file holds as JSON."""

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.mgs.limits import (
    SIDE_MAX,
    VIEWS_MAX,
    check_footprint,
    check_meta,
    check_ranges,
    check_views,
)
from mobilegs.mgs.positions import PositionGrid
from mobilegs.mgs.quantized_scene import (
    ANGLE_MAX,
    COUNT_MAX,
    EXPONENT_MAX,
    LOD_LEVELS_MAX,
    LOG_SCALE_MAX,
    SH_DEGREES,
    STEP_SIZE_MAX,
    STEP_SIZE_MIN,
    MetaValue,
    QuantizedScene,
)
from mobilegs.mgs.uniform_streams import AttributeCoding, Column, attribute_codings
from mobilegs.render import Footprint, Weighting
from mobilegs.render.project import ALPHA_MIN, CLASSIC
from mobilegs.render.scene import BLENDS
from mobilegs.render.sortfree import WEIGHTINGS
from mobilegs.representation.appearance import COLORS, ColorShape
from mobilegs.representation.codebooks import CUTS, JOINT_CUTS, SIZE_MAX, Attribute, Cut
from mobilegs.representation.lobes import HIDDEN_LAYERS, HIDDEN_MAX, LATENTS_MAX, LobeShape
from mobilegs.representation.uniform_quantizer import CODE_MAX, COLUMNS

MODES = ("nvq", "sq")


@dataclass(frozen=True)
class Header:
    """The fields that a decoder needs before it reads the streams, named as in `QuantizedScene`.

    Mode `nvq` has `cuts` and `sizes` of codebooks, mode `sq` has `codings`.
    """

    count: int
    lod_sizes: tuple[int, ...]
    cuts: dict[Attribute, Cut]
    sizes: dict[Attribute, int]
    codings: dict[Attribute, AttributeCoding]
    grid: PositionGrid
    lobes: LobeShape | None
    network: bool
    color: ColorShape
    blend: str
    weighting: Weighting
    footprint: Footprint
    background: Tensor
    near: float
    views: list[Camera]
    meta: dict[str, MetaValue]


def header_fields(scene: QuantizedScene) -> dict[str, Any]:
    """Return the header of a scene, ready for JSON."""
    return {
        "background": _listed(scene.background),
        "blend": scene.blend,
        # versions before 2.3 and 3.2 have networks only, and no such field
        **({"colors": scene.color.colors} if scene.color.colors != "networks" else {}),
        **_code_fields(scene),
        "count": len(scene),
        **({"footprint": asdict(scene.footprint)} if scene.footprint != CLASSIC else {}),
        **({"layers": list(scene.lod_sizes)} if scene.lod_sizes else {}),
        "lobes": lobe_fields(scene.lobe_shape),
        "meta": scene.meta,
        "mode": "sq" if scene.step_sizes else "nvq",
        "near": scene.near,
        "network": scene.network is not None,
        "positions": {
            "center": _listed(scene.grid.center),
            "exponent": scene.grid.exponent,
            "radius": _listed(torch.tensor([scene.grid.radius]))[0],
        },
        "sh_degree": scene.color.degree,
        "views": [
            {
                "K": _listed(view.K),
                "height": view.height,
                "viewmat": _listed(view.viewmat),
                "width": view.width,
            }
            for view in scene.views
        ],
        "weighting": weighting_fields(scene.weighting),
    }


def lobe_fields(shape: LobeShape | None) -> dict[str, Any] | None:
    return None if shape is None else {**asdict(shape), "hidden": list(shape.hidden)}


def weighting_fields(weighting: Weighting) -> dict[str, Any]:
    return {
        "background_weight": weighting.background_weight,
        "exponent_max": weighting.exponent_max,
        "name": weighting.name,
        "sigma": weighting.sigma,
        # versions before 2.2 and 3.1 have no such field
        **({"alpha_min": weighting.alpha_min} if weighting.alpha_min != ALPHA_MIN else {}),
    }


def parse_header(fields: dict[str, Any]) -> Header:
    """Parse what `header_fields` wrote; unknown fields are ignored.

    Raises InputError if a field is missing, has a wrong type, is out of range, or names something
    that this program does not support.
    """
    colors = fields.get("colors", "networks")
    for name, value, known in (
        ("mode", fields.get("mode"), MODES),
        ("blend", fields.get("blend"), BLENDS),
        ("sh_degree", _whole(fields.get("sh_degree")), SH_DEGREES),
        ("colors", colors, COLORS),
    ):
        if type(value) is not type(known[0]) or value not in known:  # True == 1
            raise InputError(
                f"the .mgs file has {name} {str(value)[:40]!r}, which this program "
                "does not know: a newer mobilegs may"
            )
    near = _number(fields, "near")
    places = _object(fields, "positions")
    views = _field(fields, "views", list)
    if len(views) > VIEWS_MAX:
        raise _broken("views")
    meta = _object(fields, "meta")
    check_meta(meta)
    lobes, network = _parse_lobes(fields), _field(fields, "network", bool)
    color = ColorShape(colors, _integer(fields, "sh_degree", min(SH_DEGREES), max(SH_DEGREES)))
    cuts: dict[Attribute, Cut] = {}
    sizes: dict[Attribute, int] = {}
    codings: dict[Attribute, AttributeCoding] = {}
    if fields["mode"] == "sq":
        color, codings = _parse_codings(_object(fields, "scalars"), color, lobes)
    else:
        books = _object(fields, "codebooks")
        cuts = _parse_cuts(books, lobes)
        sizes = {name: _integer(books[name], "size", 1, SIZE_MAX) for name in cuts}
    if network and lobes is not None:
        raise InputError(
            "the .mgs file has both lobes and a view network: only one of them is allowed"
        )
    count = _integer(fields, "count", 1, COUNT_MAX)
    header = Header(
        count=count,
        lod_sizes=_parse_lod_sizes(fields, count),
        cuts=cuts,
        sizes=sizes,
        codings=codings,
        grid=PositionGrid(
            _floats(places, "center", 3),
            _number(places, "radius"),
            _integer(places, "exponent", 0, EXPONENT_MAX),
        ),
        lobes=lobes,
        network=network,
        color=color,
        blend=fields["blend"],
        weighting=_parse_weighting(_object(fields, "weighting")),
        footprint=_parse_footprint(fields),
        background=_floats(fields, "background", 3),
        near=near,
        views=[_parse_view(view, near) for view in views],
        meta=meta,
    )
    check_ranges(header.grid, header.weighting, header.background, header.near)
    check_footprint(header.footprint, header.blend)
    check_views(header.views)
    return header


def _parse_lod_sizes(fields: dict[str, Any], count: int) -> tuple[int, ...]:
    if fields["layers"] is None:
        return ()
    listed = _field(fields, "layers", list)
    if not 1 <= len(listed) <= LOD_LEVELS_MAX:
        raise _broken("layers")
    sizes = tuple(_integer({"layers": size}, "layers", 1, count) for size in listed)
    if sum(sizes) != count:
        raise _broken("layers")
    return sizes


def _parse_cuts(fields: dict[str, Any], lobes: LobeShape | None) -> dict[Attribute, Cut]:
    cuts: dict[Attribute, Cut] = {}
    for name, cut in CUTS.items():
        if name == "opacity" and name not in fields and lobes is not None:
            continue
        book = _object(fields, name)
        numbers = cut.count * cut.length
        given = Cut(*(_integer(book, part, 1, numbers) for part in ("count", "length")))
        if given not in (cut, JOINT_CUTS[name]):
            raise _broken(name)
        cuts[name] = given
    latents = 0 if lobes is None else lobes.latents
    if "lobes" in fields:
        book = _object(fields, "lobes")
        count, length = (_integer(book, part, 1, LATENTS_MAX) for part in ("count", "length"))
        cuts["lobes"] = Cut(count, length)
    if latents != (cuts["lobes"].count * cuts["lobes"].length if "lobes" in cuts else 0):
        raise _broken("codebooks.lobes")
    return cuts


def _code_fields(scene: QuantizedScene) -> dict[str, Any]:
    if scene.step_sizes:
        return {
            "scalars": {
                name: {
                    **{
                        key: [getattr(column, key) for column in coding.columns]
                        for key in Column._fields
                    },
                    "step": _listed(torch.tensor([coding.step_size]))[0],
                }
                for name, coding in attribute_codings(scene).items()
            }
        }
    return {
        "codebooks": {
            name: {"count": cut.count, "length": cut.length, "size": scene.codebooks[name].shape[1]}
            for name, cut in scene.cuts.items()
        }
    }


def _parse_codings(
    fields: dict[str, Any], color: ColorShape, lobes: LobeShape | None
) -> tuple[ColorShape, dict[Attribute, AttributeCoding]]:
    """Parse the field `scalars`; returns `color` with its number of latents, and the codings."""
    latents = 0 if lobes is None else lobes.latents
    of_color = len(_field(_object(fields, "appearance"), "least", list))
    if not color.latents <= of_color <= color.latents_max:
        raise _broken("scalars.appearance")
    counts = COLUMNS | {"appearance": of_color, "lobes": latents}
    codings: dict[Attribute, AttributeCoding] = {}
    for name in (*COLUMNS, "lobes"):
        if name == "opacity" and name not in fields and lobes is not None:
            continue
        if name == "lobes" and not latents:
            continue
        part, count = _object(fields, name), counts[name]
        lists = [_field(part, key, list) for key in Column._fields]
        if any(len(values) != count for values in lists):
            raise _broken(f"scalars.{name}")
        columns = []
        for values in zip(*lists, strict=True):
            column = dict(zip(Column._fields, values, strict=True))
            least = _integer(column, "least", -CODE_MAX, CODE_MAX)
            size = _integer(column, "size", 1, SIZE_MAX)
            largest = _integer({"size": least + size - 1}, "size", least, CODE_MAX)
            middle = _integer(column, "middle", least, largest)
            columns.append(Column(least, size, middle))
        step_size = float(np.float32(_number(part, "step")))
        if not STEP_SIZE_MIN <= step_size <= STEP_SIZE_MAX:
            raise _broken(f"scalars.{name}.step")
        # exact in float64: a float32 value times an integer of at most 15 bits
        if name == "scale" and max(a + b - 1 for a, b, _ in columns) * step_size > LOG_SCALE_MAX:
            raise _broken("scalars.scale")
        farthest = max(max(-a, a + b - 1) for a, b, _ in columns)
        if name == "rotation" and (farthest + 0.5) * step_size > ANGLE_MAX:
            raise _broken("scalars.rotation")
        codings[name] = AttributeCoding(step_size, tuple(columns))
    if "lobes" in fields and not latents:
        raise _broken("scalars.lobes")
    return color._replace(latents=of_color), codings


def _parse_lobes(fields: dict[str, Any]) -> LobeShape | None:
    if "lobes" in fields and fields["lobes"] is None:
        return None
    shape = _object(fields, "lobes")
    widths = _field(shape, "hidden", list)
    if len(widths) > HIDDEN_LAYERS:
        raise _broken("lobes.hidden")
    return LobeShape(
        _integer(shape, "degree", 0, 3),
        _integer(shape, "latents", 0, LATENTS_MAX),
        tuple(_integer({"hidden": width}, "hidden", 1, HIDDEN_MAX) for width in widths),
    )


def _parse_weighting(fields: dict[str, Any]) -> Weighting:
    name = _field(fields, "name", str)
    if name not in WEIGHTINGS:
        raise InputError(
            f"the .mgs file has the unknown weighting {name[:40]!r}: use {', '.join(WEIGHTINGS)}"
        )
    return Weighting(
        name=name,
        exponent_max=_number(fields, "exponent_max"),
        sigma=_number(fields, "sigma"),
        background_weight=_number(fields, "background_weight"),
        alpha_min=_number(fields, "alpha_min") if "alpha_min" in fields else ALPHA_MIN,
    )


def _parse_footprint(fields: dict[str, Any]) -> Footprint:
    if fields["footprint"] is None:
        return CLASSIC
    given = _object(fields, "footprint")
    return Footprint(
        _number(given, "blur"),
        antialiased=_field(given, "antialiased", bool),
        soft_edge=_field(given, "soft_edge", bool),
    )


def _parse_view(fields: Any, near: float) -> Camera:
    if not isinstance(fields, dict):
        raise _broken("views")
    return Camera(
        _floats(fields, "viewmat", 16).reshape(4, 4),
        _floats(fields, "K", 9).reshape(3, 3),
        _integer(fields, "width", 1, SIDE_MAX),
        _integer(fields, "height", 1, SIDE_MAX),
        near,
    )


def _listed(values: Tensor) -> list[float]:
    """Return float32 values as the shortest decimals that parse to the same values."""
    exact = values.detach().cpu().float().reshape(-1).numpy()
    short = [float(str(value)) for value in exact]
    return [s if np.float32(s) == e else float(e) for s, e in zip(short, exact, strict=True)]


def _field(fields: dict[str, Any], name: str, kind: type) -> Any:
    value = fields.get(name)
    if type(value) is not kind:
        raise _broken(name)
    return value


def _object(fields: dict[str, Any], name: str) -> dict[str, Any]:
    return _field(fields, name, dict)


def _integer(fields: dict[str, Any], name: str, smallest: int, largest: int) -> int:
    value = _whole(fields.get(name))
    if type(value) is not int or not smallest <= value <= largest:
        raise _broken(name)
    return value


def _whole(value: Any) -> Any:
    """Return 1 for 1.0: JSON has one type of number, and JavaScript cannot tell them apart."""
    return int(value) if type(value) is float and value.is_integer() else value


def _number(fields: dict[str, Any], name: str) -> float:
    return _finite(fields.get(name), name)


def _floats(fields: dict[str, Any], name: str, count: int) -> Tensor:
    values = _field(fields, name, list)
    if len(values) != count:
        raise _broken(name)
    return torch.tensor([_finite(value, name) for value in values], dtype=torch.float32)


def _finite(value: Any, name: str) -> float:
    # about the largest float32: a larger number would become infinite
    if type(value) not in (int, float) or not abs(value) <= 3e38 or not math.isfinite(value):
        raise _broken(name)
    return float(value)


def _broken(name: str) -> InputError:
    return InputError(f"the field '{name}' in the header of the .mgs file is missing or invalid")
