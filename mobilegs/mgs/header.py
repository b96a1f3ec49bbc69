"""The numbers of a scene that the header of a `.mgs` carries as JSON."""

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.compress.appearance import COLORS, ColorShape
from mobilegs.compress.codebooks import CUTS, SIZE_MAX, Attribute, Cut
from mobilegs.compress.lobes import HIDDEN_LAYERS, HIDDEN_MAX, LATENTS_MAX, LobeShape
from mobilegs.compress.uniform_quantizer import CODE_MAX, COLUMNS
from mobilegs.errors import InputError
from mobilegs.mgs.limits import (
    SIDE_MAX,
    VIEWS_MAX,
    check_blend,
    check_meta,
    check_ranges,
    check_views,
)
from mobilegs.mgs.positions import Frame
from mobilegs.mgs.quantized_scene import (
    ANGLE_MAX,
    COUNT_MAX,
    EXPONENT_MAX,
    LAYERS_MAX,
    LOG_SCALE_MAX,
    SH_DEGREES,
    STEP_MAX,
    STEP_MIN,
    CodedScene,
    MetaValue,
)
from mobilegs.mgs.uniform_streams import Column, Scalar, scalars_of
from mobilegs.render import Weighting
from mobilegs.render.project import ALPHA_MIN
from mobilegs.render.scene import BLENDS
from mobilegs.render.sortfree import WEIGHTINGS

MODES = ("nvq", "sq")


@dataclass(frozen=True)
class Header:
    """What a decoder must know before it reads the streams; fields as in `CodedScene`.

    Of the mode `nvq` there are cuts and sizes of codebooks, of `sq` there are scalars.
    """

    count: int
    layers: tuple[int, ...]
    cuts: dict[Attribute, Cut]
    sizes: dict[Attribute, int]
    scalars: dict[Attribute, Scalar]
    frame: Frame
    lobes: LobeShape | None
    network: bool
    color: ColorShape
    blend: str
    weighting: Weighting
    background: Tensor
    near: float
    views: list[Camera]
    meta: dict[str, MetaValue]


def describe(coded: CodedScene) -> dict[str, Any]:
    """The header of a scene, ready for JSON."""
    return {
        "background": _listed(coded.background),
        "blend": coded.blend,
        # earlier versions knew networks alone, and did not name them
        **({"colors": coded.color.colors} if coded.color.colors != "networks" else {}),
        **_describe_codes(coded),
        "count": len(coded),
        **({"layers": list(coded.layers)} if coded.layers else {}),
        "lobes": describe_lobes(coded.lobe_shape),
        "meta": coded.meta,
        "mode": "sq" if coded.steps else "nvq",
        "near": coded.near,
        "network": coded.network is not None,
        "positions": {
            "center": _listed(coded.frame.center),
            "exponent": coded.frame.exponent,
            "radius": _listed(torch.tensor([coded.frame.radius]))[0],
        },
        "sh_degree": coded.color.degree,
        "views": [
            {
                "K": _listed(view.K),
                "height": view.height,
                "viewmat": _listed(view.viewmat),
                "width": view.width,
            }
            for view in coded.views
        ],
        "weighting": describe_weighting(coded.weighting),
    }


def describe_lobes(shape: LobeShape | None) -> dict[str, Any] | None:
    """The header's field `lobes`."""
    return None if shape is None else {**asdict(shape), "hidden": list(shape.hidden)}


def describe_weighting(weighting: Weighting) -> dict[str, Any]:
    """The header's field `weighting`."""
    return {
        "background_weight": weighting.background_weight,
        "exponent_max": weighting.exponent_max,
        "name": weighting.name,
        "sigma": weighting.sigma,
        # what earlier versions did not name
        **({"alpha_min": weighting.alpha_min} if weighting.alpha_min != ALPHA_MIN else {}),
    }


def parse(fields: dict[str, Any]) -> Header:
    """What `describe` wrote; fields that are not known are ignored.

    Raises:
        InputError: a field is missing, of another type, out of range, or asks for something
            that this program cannot do.
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
    scalars: dict[Attribute, Scalar] = {}
    if fields["mode"] == "sq":
        color, scalars = _parse_scalars(_object(fields, "scalars"), color, lobes)
    else:
        books = _object(fields, "codebooks")
        cuts = _parse_cuts(books, lobes)
        sizes = {name: _integer(books[name], "size", 1, SIZE_MAX) for name in cuts}
    if network and lobes is not None:
        raise InputError("the .mgs file has lobes and a view network: it can have one of them")
    check_blend(fields["blend"], by_direction=network or lobes is not None)
    count = _integer(fields, "count", 1, COUNT_MAX)
    header = Header(
        count=count,
        layers=_parse_layers(fields, count),
        cuts=cuts,
        sizes=sizes,
        scalars=scalars,
        frame=Frame(
            _floats(places, "center", 3),
            _number(places, "radius"),
            _integer(places, "exponent", 0, EXPONENT_MAX),
        ),
        lobes=lobes,
        network=network,
        color=color,
        blend=fields["blend"],
        weighting=_parse_weighting(_object(fields, "weighting")),
        background=_floats(fields, "background", 3),
        near=near,
        views=[_parse_view(view, near) for view in views],
        meta=meta,
    )
    check_ranges(header.frame, header.weighting, header.background, header.near)
    check_views(header.views)
    return header


def _parse_layers(fields: dict[str, Any], count: int) -> tuple[int, ...]:
    if fields["layers"] is None:
        return ()
    layers = _field(fields, "layers", list)
    if not 1 <= len(layers) <= LAYERS_MAX:
        raise _broken("layers")
    sizes = tuple(_integer({"layers": size}, "layers", 1, count) for size in layers)
    if sum(sizes) != count:
        raise _broken("layers")
    return sizes


def _parse_cuts(fields: dict[str, Any], lobes: LobeShape | None) -> dict[Attribute, Cut]:
    cuts: dict[Attribute, Cut] = {}
    for name, cut in CUTS.items():
        if name == "opacity" and name not in fields and lobes is not None:
            continue
        book = _object(fields, name)
        for part, value in (("count", cut.count), ("length", cut.length)):
            _integer(book, part, value, value)
        cuts[name] = cut
    latents = 0 if lobes is None else lobes.latents
    if "lobes" in fields:
        book = _object(fields, "lobes")
        count, length = (_integer(book, part, 1, LATENTS_MAX) for part in ("count", "length"))
        cuts["lobes"] = Cut(count, length)
    if latents != (cuts["lobes"].count * cuts["lobes"].length if "lobes" in cuts else 0):
        raise _broken("codebooks.lobes")
    return cuts


def _describe_codes(coded: CodedScene) -> dict[str, Any]:
    if coded.steps:
        return {
            "scalars": {
                name: {
                    **{
                        key: [getattr(column, key) for column in scalar.columns]
                        for key in Column._fields
                    },
                    "step": _listed(torch.tensor([scalar.step]))[0],
                }
                for name, scalar in scalars_of(coded).items()
            }
        }
    return {
        "codebooks": {
            name: {"count": cut.count, "length": cut.length, "size": coded.codebooks[name].shape[1]}
            for name, cut in coded.cuts.items()
        }
    }


def _parse_scalars(
    fields: dict[str, Any], color: ColorShape, lobes: LobeShape | None
) -> tuple[ColorShape, dict[Attribute, Scalar]]:
    """What scalars there are, and the colour with as many latents as it has of them."""
    latents = 0 if lobes is None else lobes.latents
    of_color = len(_field(_object(fields, "appearance"), "least", list))
    if not color.latents <= of_color <= color.latents_max:
        raise _broken("scalars.appearance")
    counts = COLUMNS | {"appearance": of_color, "lobes": latents}
    found: dict[Attribute, Scalar] = {}
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
        step = float(np.float32(_number(part, "step")))
        if not STEP_MIN <= step <= STEP_MAX:
            raise _broken(f"scalars.{name}.step")
        # products of a float32 value and a short number: exact
        if name == "scale" and max(a + b - 1 for a, b, _ in columns) * step > LOG_SCALE_MAX:
            raise _broken("scalars.scale")
        farthest = max(max(-a, a + b - 1) for a, b, _ in columns)
        if name == "rotation" and (farthest + 0.5) * step > ANGLE_MAX:
            raise _broken("scalars.rotation")
        found[name] = Scalar(step, tuple(columns))
    if "lobes" in fields and not latents:
        raise _broken("scalars.lobes")
    return color._replace(latents=of_color), found


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
            f"the .mgs file has the weighting {name[:40]!r}: known are {', '.join(WEIGHTINGS)}"
        )
    return Weighting(
        name=name,
        exponent_max=_number(fields, "exponent_max"),
        sigma=_number(fields, "sigma"),
        background_weight=_number(fields, "background_weight"),
        alpha_min=_number(fields, "alpha_min") if "alpha_min" in fields else ALPHA_MIN,
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
    """float32 values as the shortest decimals that lead back to them."""
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
    """JSON has one kind of number: 1.0 is 1, as JavaScript cannot tell them apart."""
    return int(value) if type(value) is float and value.is_integer() else value


def _number(fields: dict[str, Any], name: str) -> float:
    return _finite(fields.get(name), name)


def _floats(fields: dict[str, Any], name: str, count: int) -> Tensor:
    values = _field(fields, name, list)
    if len(values) != count:
        raise _broken(name)
    return torch.tensor([_finite(value, name) for value in values], dtype=torch.float32)


def _finite(value: Any, name: str) -> float:
    # 3e38 is about the largest float32; beyond it a double would become infinite
    if type(value) not in (int, float) or not abs(value) <= 3e38 or not math.isfinite(value):
        raise _broken(name)
    return float(value)


def _broken(name: str) -> InputError:
    return InputError(f"the field '{name}' in the header of the .mgs file is missing or invalid")
