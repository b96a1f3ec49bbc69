"""The quantised scene: exactly what a `.mgs` file holds, and what it decodes to."""

import math
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from itertools import accumulate

import numpy as np
import torch
from jaxtyping import Float, Float16, Int, UInt8
from torch import Tensor

from mobilegs.camera import NEAR, Camera
from mobilegs.compress.appearance import LATENTS, ColorShape, color_decoder
from mobilegs.compress.codebooks import (
    CUTS,
    SIZE_MAX,
    Attribute,
    Cut,
    look_up,
)
from mobilegs.compress.lobes import LobeDecoder, LobeShape
from mobilegs.compress.rotations import decode_rotations, finer_bits_of
from mobilegs.compress.uniform_quantizer import CODE_MAX, COLUMNS, reach
from mobilegs.csrc import native
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.limits import check_blend, check_meta, check_ranges, check_views
from mobilegs.mgs.positions import Frame, morton_codes
from mobilegs.render import Weighting
from mobilegs.render.scene import Scene
from mobilegs.render.view_network import ViewNetwork
from mobilegs.spherical_harmonics import C0

COUNT_MAX = 1 << 26
LAYERS_MAX = 8
SH_DEGREES = (0, 1, 2, 3)
EXPONENT_MAX = 14
LOG_SCALE_MAX = 80.0  # exp of it is finite in float32
ANGLE_MAX = 8.0  # radians; up to there float32 and float64 make the same quaternion of it
STEP_MIN, STEP_MAX = 1e-5, 1e3
MetaValue = str | int | float | bool | None


@dataclass(eq=False)
class CodedScene:
    """A scene as codes. Compare two with `same`.

    Attributes:
        positions: centres of the Gaussians as stored in `frame`, `[n, 3]`.
        frame: where they lie in the world.
        indices: per attribute, which codebook entry each sub-vector is, `[n, count]`; or, with
            steps, what multiple of its step each number is (of rotations see `rotations.py`).
            There may be no opacity, and there are `lobes` only if the lobes' decoder takes
            latents.
        codebooks: per attribute, `[count, k, length]`; empty if there are steps.
        steps: per attribute, a float32 value; empty if there are codebooks.
        layers: how many Gaussians each layer has, the most important layer first; none at all
            are one layer. See `layers.py`.
        decoder: the weights of what decodes colours, by the names of its parameters.
        lobe_shape: of the decoder that gives lobes once, when the scene is opened; None means
            that there is none.
        lobe_decoder: its weights; empty if there is none.
        network: the view network's weights, which gives opacity and phi for each view; None
            means that there is none. With neither, phi = 1 and opacity is the base's.
        blend, weighting, background, near: as in `Scene`; the background lies in [0, 1]. A scene
            that is blended sorted has neither lobes nor a network.
        views: cameras from which the scene is worth a first look; they take over `near`.
        meta: who made this and how, for people: scalars only, and no times, so that equal
            scenes are equal files.
    """

    positions: Float16[Tensor, "n 3"]
    frame: Frame
    indices: dict[Attribute, Int[Tensor, "n _"]]
    codebooks: dict[Attribute, Float16[Tensor, "_ _ _"]]
    decoder: dict[str, Float16[Tensor, "..."]]
    lobe_shape: LobeShape | None
    lobe_decoder: dict[str, Float16[Tensor, "..."]]
    network: dict[str, Float16[Tensor, "..."]] | None
    steps: dict[Attribute, float] = field(default_factory=dict)
    layers: tuple[int, ...] = ()
    blend: str = "sortfree"
    weighting: Weighting = field(default_factory=Weighting)
    background: Float[Tensor, "3"] = field(default_factory=lambda: torch.zeros(3))
    near: float = NEAR
    views: list[Camera] = field(default_factory=list)
    meta: dict[str, MetaValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.near = float(self.near)
        for name, step in self.steps.items():
            self.steps[name] = float(np.float32(step))
        self.background = self.background.cpu().float()
        self.views = [replace(view.to("cpu", torch.float32), near=self.near) for view in self.views]

    def __len__(self) -> int:
        return self.positions.shape[0]

    @property
    def cuts(self) -> dict[Attribute, Cut]:
        """How each attribute that there is is cut, in the file's order."""
        cuts: dict[Attribute, Cut] = {
            name: cut for name, cut in CUTS.items() if name in self.codebooks
        }
        if "lobes" in self.codebooks:
            count, _, length = self.codebooks["lobes"].shape
            cuts["lobes"] = Cut(count, length)
        return cuts

    @property
    def color(self) -> ColorShape:
        """What colours are made of, as the decoder's weights have it."""
        view = self.decoder["view2"]
        degree = math.isqrt(len(view) // 3 + 1) - 1
        if "context1" in self.decoder:
            return ColorShape("networks", degree)
        return ColorShape("linear", degree, LATENTS + view.shape[1])

    def sorted(self) -> "CodedScene":
        """The same scene in the order of the file: in each layer by Morton code, then as before."""
        codes = torch.from_numpy(morton_codes(self.positions).astype("int64"))
        orders = [codes[rows].argsort(stable=True) + rows.start for rows in self.parts()]
        return self.pick(torch.cat(orders))

    def parts(self) -> list[slice]:
        """The rows of each layer."""
        sizes = self.layers or (len(self),)
        return [slice(end - size, end) for size, end in zip(sizes, accumulate(sizes), strict=True)]

    def pick(self, rows: Int[Tensor, "m"] | slice) -> "CodedScene":
        """The same scene with these rows in this order; what layers there are stays."""
        return replace(
            self,
            positions=self.positions[rows],
            indices={name: codes[rows] for name, codes in self.indices.items()},
        )

    def values(self, device: torch.device | str = "cpu") -> dict[Attribute, Tensor]:
        """What the codes of each attribute stand for."""
        values: dict[Attribute, Tensor] = {}
        for name, rows in self.indices.items():
            rows = rows.to(device)
            if not self.steps:
                centers = self.codebooks[name].to(device).float()
                found = native.look_up(centers, rows)
                values[name] = look_up(centers, rows) if found is None else found
            elif name == "rotation":
                values[name] = decode_rotations(rows, self.finer.to(device), self.steps[name])
            else:
                # two thirds of the time of a product of whole numbers and a fraction
                floats = native.room(*rows.shape, device=rows.device).copy_(rows)
                values[name] = floats.mul_(self.steps[name])
        return values

    def decode(self, device: torch.device | str = "cpu") -> Scene:
        """The scene that these codes mean; the networks that make its colours run once, here."""
        positions = self.positions.to(device)
        values = self.values(device)
        decoder = color_decoder(self.color, torch.Generator()).to(device)
        decoder.load_state_dict({name: value.float() for name, value in self.decoder.items()})
        static, view = values["appearance"].tensor_split([LATENTS], dim=1)
        empty = torch.zeros(len(self), 1, device=device)
        gaussians = Gaussians(
            means=self.frame.world(positions),
            quats=values["rotation"],
            log_scales=values["scale"],
            logit_opacities=values.get("opacity", empty)[:, 0],
            sh=decoder.decode(self.frame.normalised(positions), static, view),
        )
        lobes = network = None
        if self.lobe_shape is not None:
            opening = LobeDecoder(self.lobe_shape, torch.Generator()).to(device)
            opening.load_state_dict({name: v.float() for name, v in self.lobe_decoder.items()})
            latents = values.get("lobes", empty[:, :0])
            lobes = opening.decode(latents, gaussians, base="opacity" in values)
            gaussians = replace(gaussians, logit_opacities=lobes[:, 0, 0] * C0)
        if self.network is not None:
            with torch.device("meta"):  # no memory, no draws from the global random state
                network = ViewNetwork()
            weights = {name: value.to(device).float() for name, value in self.network.items()}
            network.load_state_dict(weights, assign=True)
            network.requires_grad_(False)
        return Scene(
            gaussians,
            self.blend,
            lobes=lobes,
            network=network,
            weighting=self.weighting,
            background=self.background.to(device),
            near=self.near,
        )

    def check(self) -> None:
        """Raise `InputError` unless a file can hold this scene and a renderer can draw it."""
        if not 1 <= len(self) <= COUNT_MAX:
            raise InputError(f"the scene has {len(self)} Gaussians: 1 to {COUNT_MAX} are allowed")
        if self.layers and (min(self.layers) < 1 or sum(self.layers) != len(self)):
            raise InputError(f"the scene's layers {self.layers} do not make {len(self)} Gaussians")
        if len(self.layers) > LAYERS_MAX:
            raise InputError(f"the scene has {len(self.layers)} layers: {LAYERS_MAX} are allowed")
        if not self.positions.isfinite().all():
            raise InputError("the scene has positions that are not finite")
        if not 0 <= self.frame.exponent <= EXPONENT_MAX:
            exponent = self.frame.exponent
            raise InputError(f"the exponent of positions is {exponent}: 0 to 14 are allowed")
        check_ranges(self.frame, self.weighting, self.background, self.near)
        shape = self.lobe_shape
        needed: list[Attribute] = ["scale", "rotation", "appearance"]
        if shape is None:
            needed.append("opacity")
        elif shape.latents:
            needed.append("lobes")
        if "lobes" in self.indices and "lobes" not in needed:
            raise InputError("the scene has lobe codes that nothing decodes")
        if bool(self.codebooks) == bool(self.steps):
            raise InputError("the scene needs codebooks or steps, and not both")
        needed.extend(name for name in self.indices if name not in needed)
        for name in needed:
            self._check_scalars(name) if self.steps else self._check_attribute(name)
        if shape is not None and self.network is not None:
            raise InputError("the scene has lobes and a view network: one of them must go")
        check_blend(self.blend, by_direction=shape is not None or self.network is not None)
        if "view2" not in self.decoder or self.color.degree not in SH_DEGREES:
            raise InputError("the colour decoder does not make harmonics of degree 0 to 3")
        if not 2 * LATENTS <= self.color.latents <= self.color.latents_max:
            raise InputError(f"colours cannot have {self.color.latents} latents")
        shapes = decoder_shapes(self.color)
        _check_weights("colour decoder", self.decoder, shapes)
        _check_weights("lobe decoder", self.lobe_decoder, lobe_shapes(shape))
        if self.network is not None:
            _check_weights("view network", self.network, network_shapes())
        check_views(self.views)
        check_meta(self.meta)

    def _check_attribute(self, name: Attribute) -> None:
        book, rows = self.codebooks.get(name), self.indices.get(name)
        if book is None or rows is None:
            raise InputError(f"the scene has no {name} codes")
        size, cut = book.shape[1], self.cuts[name]
        latents = 0 if self.lobe_shape is None else self.lobe_shape.latents
        if name == "lobes" and cut.count * cut.length != latents:
            raise InputError(
                f"the lobe codebooks {tuple(book.shape)} do not make {latents} latents"
            )
        if book.shape != (cut.count, size, cut.length) or not 1 <= size <= SIZE_MAX:
            raise InputError(f"the {name} codebooks have the shape {tuple(book.shape)}")
        if rows.shape != (len(self), cut.count):
            raise InputError(f"the {name} indices have the shape {tuple(rows.shape)}")
        if not book.isfinite().all() or (name == "scale" and book.max() > LOG_SCALE_MAX):
            raise InputError(f"the {name} codebooks hold numbers that are out of range")
        if rows.min() < 0 or rows.max() >= size:
            raise InputError(f"the {name} indices point outside of their codebooks")

    def _check_scalars(self, name: Attribute) -> None:
        step, rows = self.steps.get(name), self.indices.get(name)
        if step is None or rows is None:
            raise InputError(f"the scene has no {name} codes")
        latents = {"appearance": self.color.latents}
        latents["lobes"] = 0 if self.lobe_shape is None else self.lobe_shape.latents
        if rows.shape != (len(self), (COLUMNS | latents)[name]):
            raise InputError(f"the {name} codes have the shape {tuple(rows.shape)}")
        if not STEP_MIN <= step <= STEP_MAX:
            raise InputError(f"the step {step} of the {name} codes is out of range")
        codes = rows if name != "rotation" else self.cells
        least, largest = reach(codes)
        farthest = int(torch.maximum(-least, largest).max())
        if farthest > CODE_MAX or (largest - least >= SIZE_MAX).any():
            raise InputError(f"the {name} codes reach too far: their step must be larger")
        if name == "scale" and int(largest.max()) * step > LOG_SCALE_MAX:
            raise InputError("the scale codes hold numbers that are out of range")
        if name == "rotation" and (farthest + 0.5) * step > ANGLE_MAX:
            raise InputError(f"a step of {step:g} between angles is too large for their codes")

    @property
    def finer(self) -> UInt8[Tensor, "n 3"]:
        """With steps, the finer bits of the rotations' codes."""
        return finer_bits_of(self.indices["scale"], self.steps["scale"])

    @property
    def cells(self) -> Int[Tensor, "n 3"]:
        """With steps, the rotations' codes without their finer bits."""
        return self.indices["rotation"].int() >> self.finer.int()


@cache
def decoder_shapes(shape: ColorShape) -> dict[str, torch.Size]:
    """Shapes of the colour decoder's weights by name, in the file's order."""
    decoder = color_decoder(shape, torch.Generator())
    return {name: value.shape for name, value in decoder.named_parameters()}


@lru_cache(maxsize=16)
def lobe_shapes(shape: LobeShape | None) -> dict[str, torch.Size]:
    """Shapes of a lobe decoder's weights by name, in the file's order; none for None."""
    if shape is None:
        return {}
    decoder = LobeDecoder(shape, torch.Generator())
    return {name: value.shape for name, value in decoder.named_parameters()}


@cache
def network_shapes() -> dict[str, torch.Size]:
    """Shapes of the view network's weights by name, in the file's order."""
    with torch.device("meta"):
        return {name: value.shape for name, value in ViewNetwork().named_parameters()}


def _check_weights(title: str, weights: dict[str, Tensor], shapes: dict[str, torch.Size]) -> None:
    if {name: value.shape for name, value in weights.items()} != shapes:
        raise InputError(f"the {title}'s weights do not have the shapes that they should")
    if not all(value.isfinite().all() for value in weights.values()):
        raise InputError(f"the {title} has weights that are not finite")


def same(a: CodedScene, b: CodedScene) -> bool:
    """Whether two coded scenes are equal to the last bit, order included."""

    def bits(coded: CodedScene) -> dict[str, Tensor]:
        parts = {
            "positions": coded.positions,
            "center": coded.frame.center,
            "background": coded.background,
        }
        for group in ("indices", "codebooks", "decoder", "lobe_decoder", "network"):
            parts |= {f"{group}.{k}": v for k, v in (getattr(coded, group) or {}).items()}
        for i, view in enumerate(coded.views):
            parts |= {f"viewmat.{i}": view.viewmat, f"K.{i}": view.K}
        return {
            name: part.view(torch.int16 if part.element_size() == 2 else torch.int32)
            for name, part in parts.items()
        }

    def rest(coded: CodedScene) -> tuple:
        sizes = [(view.width, view.height) for view in coded.views]
        notes = {name: (type(value), value) for name, value in coded.meta.items()}
        frame = coded.frame
        return (
            frame.radius,
            frame.exponent,
            coded.near,
            coded.blend,
            coded.weighting,
            sizes,
            notes,
            coded.lobe_shape,
            coded.network is None,
            coded.steps,
            coded.layers,
        )

    left, right = bits(a), bits(b)
    return (
        rest(a) == rest(b)
        and left.keys() == right.keys()
        and all(torch.equal(left[name], right[name]) for name in left)
    )
