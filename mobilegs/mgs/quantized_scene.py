"""A scene in its quantised form: the exact content of a `.mgs` file, and its decoder."""

import math
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache, lru_cache
from importlib import import_module
from itertools import accumulate
from typing import Any

import numpy as np
import torch
from jaxtyping import Float, Float16, Int, UInt8
from torch import Tensor

from mobilegs.camera import NEAR, Camera
from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.limits import check_footprint, check_meta, check_ranges, check_views
from mobilegs.mgs.positions import PositionGrid, morton_codes
from mobilegs.render import Footprint, Weighting
from mobilegs.render.project import CLASSIC
from mobilegs.render.scene import Scene
from mobilegs.render.view_network import ViewNetwork
from mobilegs.representation.appearance import LATENTS, ColorShape, color_decoder
from mobilegs.representation.codebooks import (
    CUTS,
    JOINT_CUTS,
    SIZE_MAX,
    Attribute,
    Cut,
    gather_entries,
)
from mobilegs.representation.lobes import LobeDecoder, LobeShape
from mobilegs.representation.rotations import decode_rotations, refinement_bits_of
from mobilegs.representation.uniform_quantizer import CODE_MAX, COLUMNS, column_ranges
from mobilegs.spherical_harmonics import C0
from mobilegs.up import parsed_up, up_of_cameras

COUNT_MAX = 1 << 26
LOD_LEVELS_MAX = 8
SH_DEGREES = (0, 1, 2, 3)
EXPONENT_MAX = 14
LOG_SCALE_MAX = 80.0  # its exponential is finite in float32
ANGLE_MAX = 8.0  # radians; up to there float32 and float64 give the same quaternion
STEP_SIZE_MIN, STEP_SIZE_MAX = 1e-5, 1e3
MetaValue = str | int | float | bool | None


@dataclass(eq=False)
class QuantizedScene:
    """A scene as codes. `scenes_equal` compares two.

    The scene has either `codebooks` (mode `nvq`) or `step_sizes` (mode `sq`), never both.

    Attributes:
        positions: quantised means, float16 numbers in `grid`, `[n, 3]`.
        grid: maps them to world space.
        indices: codes of each attribute. With codebooks, `[n, count]`: the entry of each
            sub-vector. With step sizes, `[n, columns]`: multiples of the step size (for rotations
            see `rotations.py`). `opacity` may be missing if there are lobes; `lobes` exists only
            if the lobe decoder takes latents.
        codebooks: entries of each attribute, `[count, size, length]`.
        step_sizes: step size of each attribute, a float32 value, 1e-5 to 1e3.
        lod_sizes: number of Gaussians of each LOD level, the coarsest level first; empty for a
            scene without LOD levels. See `lod.py`.
        decoder: weights of the colour decoder by parameter name.
        lobe_shape: shape of the lobe decoder, which runs once when the scene is opened; None
            without one.
        lobe_decoder: its weights; empty without one.
        network: weights of the view network, which gives opacity and phi per view; None without
            one. Without lobes and network, phi is 1 and the opacity is the base opacity.
        blend, weighting, footprint, background, near: as in `Scene`; the background lies in
            [0, 1].
        views: cameras for a first look; their near plane becomes `near`.
        meta: notes for people. They hold no times, so that equal scenes are equal files. The note
            `up`, a text `X Y Z`, is the upward direction.
    """

    positions: Float16[Tensor, "n 3"]
    grid: PositionGrid
    indices: dict[Attribute, Int[Tensor, "n _"]]
    codebooks: dict[Attribute, Float16[Tensor, "_ _ _"]]
    decoder: dict[str, Float16[Tensor, "..."]]
    lobe_shape: LobeShape | None
    lobe_decoder: dict[str, Float16[Tensor, "..."]]
    network: dict[str, Float16[Tensor, "..."]] | None
    step_sizes: dict[Attribute, float] = field(default_factory=dict)
    lod_sizes: tuple[int, ...] = ()
    blend: str = "sortfree"
    weighting: Weighting = field(default_factory=Weighting)
    footprint: Footprint = CLASSIC
    background: Float[Tensor, "3"] = field(default_factory=lambda: torch.zeros(3))
    near: float = NEAR
    views: list[Camera] = field(default_factory=list)
    meta: dict[str, MetaValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.near = float(self.near)
        for name, step_size in self.step_sizes.items():
            self.step_sizes[name] = float(np.float32(step_size))
        self.background = self.background.cpu().float()
        self.views = [replace(view.to("cpu", torch.float32), near=self.near) for view in self.views]

    def __len__(self) -> int:
        return self.positions.shape[0]

    def _repr_html_(self) -> str:
        """Return the viewer with the scene, which notebooks show as the output of a cell."""
        return import_module("mobilegs.view.notebook").scene_html(self)  # views are built on scenes

    @property
    def cuts(self) -> dict[Attribute, Cut]:
        """With codebooks, the cut of each attribute, in the file's order."""
        cuts: dict[Attribute, Cut] = {}
        for name, cut in CUTS.items():
            if name in self.codebooks:
                joint = self.codebooks[name].shape[0] == 1
                cuts[name] = JOINT_CUTS[name] if joint else cut
        if "lobes" in self.codebooks:
            count, _, length = self.codebooks["lobes"].shape
            cuts["lobes"] = Cut(count, length)
        return cuts

    @property
    def color(self) -> ColorShape:
        """Shape of the colour decoder, from its weights."""
        view = self.decoder["view2"]
        degree = math.isqrt(len(view) // 3 + 1) - 1
        if "context1" in self.decoder:
            return ColorShape("networks", degree)
        if "both1" in self.decoder:
            return ColorShape("latent_networks", degree)
        return ColorShape("linear", degree, LATENTS + view.shape[1])

    @property
    def up(self) -> Float[np.ndarray, "3"] | None:
        """Upward direction that the note `up` tells, or else the views; None without either."""
        noted = parsed_up(self.meta.get("up"))
        if noted is not None or not self.views:
            return noted
        return up_of_cameras(np.stack([view.viewmat.double().numpy() for view in self.views]))

    def sorted(self) -> "QuantizedScene":
        """Return the scene in the file's order: by Morton code within each LOD level, stable."""
        codes = torch.from_numpy(morton_codes(self.positions).astype("int64"))
        orders = [codes[rows].argsort(stable=True) + rows.start for rows in self.lod_slices()]
        return self.select(torch.cat(orders))

    def lod_slices(self) -> list[slice]:
        """Return the rows of each LOD level."""
        sizes = self.lod_sizes or (len(self),)
        return [slice(end - size, end) for size, end in zip(sizes, accumulate(sizes), strict=True)]

    def select(self, rows: Int[Tensor, "m"] | slice) -> "QuantizedScene":
        """Return the scene with these rows in this order; `lod_sizes` stays as it is."""
        return replace(
            self,
            positions=self.positions[rows],
            indices={name: codes[rows] for name, codes in self.indices.items()},
        )

    def values(self, device: torch.device | str = "cpu") -> dict[Attribute, Tensor]:
        """Return the dequantised values of each attribute, `[n, d]` in float32."""
        values: dict[Attribute, Tensor] = {}
        for name, rows in self.indices.items():
            rows = rows.to(device)
            if not self.step_sizes:
                centers = self.codebooks[name].to(device).float()
                gathered = binding.gather_entries(centers, rows)
                values[name] = gather_entries(centers, rows) if gathered is None else gathered
            elif name == "rotation":
                bits = self.refinement_bits.to(device)
                values[name] = decode_rotations(rows, bits, self.step_sizes[name])
            else:
                # takes two thirds of the time of the product of an integer and a float tensor
                floats = binding.empty(*rows.shape, device=rows.device).copy_(rows)
                values[name] = floats.mul_(self.step_sizes[name])
        return values

    def decode(self, device: torch.device | str = "cpu") -> Scene:
        """Return the scene that these codes stand for.

        Colour and lobe decoders run once, here. A view network stays in the scene.
        """
        positions = self.positions.to(device)
        values = self.values(device)
        decoder = color_decoder(self.color, torch.Generator()).to(device)
        decoder.load_state_dict({name: value.float() for name, value in self.decoder.items()})
        static, view = values["appearance"].tensor_split([LATENTS], dim=1)
        zeros = torch.zeros(len(self), 1, device=device)
        gaussians = Gaussians(
            means=self.grid.world(positions),
            quats=values["rotation"],
            log_scales=values["scale"],
            logit_opacities=values.get("opacity", zeros)[:, 0],
            sh=decoder.decode(self.grid.normalised(positions), static, view),
        )
        lobes = network = None
        if self.lobe_shape is not None:
            lobe_decoder = LobeDecoder(self.lobe_shape, torch.Generator()).to(device)
            lobe_decoder.load_state_dict({name: v.float() for name, v in self.lobe_decoder.items()})
            latents = values.get("lobes", zeros[:, :0])
            lobes = lobe_decoder.decode(latents, gaussians, base="opacity" in values)
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
            footprint=self.footprint,
            background=self.background.to(device),
            near=self.near,
            up=self.up,
            notes=self.meta,
        )

    def check(self) -> None:
        """Raise `InputError` unless a file can hold this scene and a renderer can draw it."""
        if not 1 <= len(self) <= COUNT_MAX:
            raise InputError(f"the scene has {len(self)} Gaussians: 1 to {COUNT_MAX} are allowed")
        if self.lod_sizes and (min(self.lod_sizes) < 1 or sum(self.lod_sizes) != len(self)):
            raise InputError(
                f"the scene's LOD levels {self.lod_sizes} do not add up to {len(self)} Gaussians"
            )
        if len(self.lod_sizes) > LOD_LEVELS_MAX:
            raise InputError(
                f"the scene has {len(self.lod_sizes)} LOD levels: {LOD_LEVELS_MAX} are allowed"
            )
        if not self.positions.isfinite().all():
            raise InputError("the scene has positions that are not finite")
        if not 0 <= self.grid.exponent <= EXPONENT_MAX:
            exponent = self.grid.exponent
            raise InputError(f"the exponent of positions is {exponent}: 0 to 14 are allowed")
        check_ranges(self.grid, self.weighting, self.background, self.near)
        check_footprint(self.footprint, self.blend)
        shape = self.lobe_shape
        needed: list[Attribute] = ["scale", "rotation", "appearance"]
        if shape is None:
            needed.append("opacity")
        elif shape.latents:
            needed.append("lobes")
        if "lobes" in self.indices and "lobes" not in needed:
            raise InputError("the scene has lobe codes, but no decoder for them")
        if bool(self.codebooks) == bool(self.step_sizes):
            raise InputError("the scene needs either codebooks or step sizes")
        needed.extend(name for name in self.indices if name not in needed)
        for name in needed:
            self._check_multiples(name) if self.step_sizes else self._check_indices(name)
        if shape is not None and self.network is not None:
            raise InputError("the scene has both lobes and a view network: remove one of them")
        if "view2" not in self.decoder or self.color.degree not in SH_DEGREES:
            raise InputError("the colour decoder does not give harmonics of degree 0 to 3")
        if not 2 * LATENTS <= self.color.latents <= self.color.latents_max:
            raise InputError(f"colours cannot have {self.color.latents} latents")
        shapes = decoder_shapes(self.color)
        _check_weights("colour decoder", self.decoder, shapes)
        _check_weights("lobe decoder", self.lobe_decoder, lobe_shapes(shape))
        if self.network is not None:
            _check_weights("view network", self.network, network_shapes())
        check_views(self.views)
        check_meta(self.meta)

    def _check_indices(self, name: Attribute) -> None:
        book, rows = self.codebooks.get(name), self.indices.get(name)
        if book is None or rows is None:
            raise InputError(f"the scene has no {name} codes")
        size, cut = book.shape[1], self.cuts[name]
        latents = 0 if self.lobe_shape is None else self.lobe_shape.latents
        if name == "lobes" and cut.count * cut.length != latents:
            raise InputError(
                f"the lobe codebooks {tuple(book.shape)} do not hold {latents} latents"
            )
        if book.shape != (cut.count, size, cut.length) or not 1 <= size <= SIZE_MAX:
            raise InputError(f"the {name} codebooks have the shape {tuple(book.shape)}")
        if rows.shape != (len(self), cut.count):
            raise InputError(f"the {name} indices have the shape {tuple(rows.shape)}")
        if not book.isfinite().all() or (name == "scale" and book.max() > LOG_SCALE_MAX):
            raise InputError(f"the {name} codebooks hold numbers that are out of range")
        if rows.min() < 0 or rows.max() >= size:
            raise InputError(f"the {name} indices point outside of their codebooks")

    def _check_multiples(self, name: Attribute) -> None:
        step_size, rows = self.step_sizes.get(name), self.indices.get(name)
        if step_size is None or rows is None:
            raise InputError(f"the scene has no {name} codes")
        latents = {"appearance": self.color.latents}
        latents["lobes"] = 0 if self.lobe_shape is None else self.lobe_shape.latents
        if rows.shape != (len(self), (COLUMNS | latents)[name]):
            raise InputError(f"the {name} codes have the shape {tuple(rows.shape)}")
        if not STEP_SIZE_MIN <= step_size <= STEP_SIZE_MAX:
            raise InputError(f"the step size {step_size} of the {name} codes is out of range")
        codes = rows if name != "rotation" else self.cells
        least, largest = column_ranges(codes)
        farthest = int(torch.maximum(-least, largest).max())
        if farthest > CODE_MAX or (largest - least >= SIZE_MAX).any():
            raise InputError(f"the {name} codes are too large: increase their step size")
        if name == "scale" and int(largest.max()) * step_size > LOG_SCALE_MAX:
            raise InputError("the scale codes hold numbers that are out of range")
        if name == "rotation" and (farthest + 0.5) * step_size > ANGLE_MAX:
            raise InputError(f"the step size {step_size:g} is too large for the rotation codes")

    @property
    def refinement_bits(self) -> UInt8[Tensor, "n 3"]:
        """With step sizes, the number of refinement bits in each rotation code."""
        return refinement_bits_of(self.indices["scale"], self.step_sizes["scale"])

    @property
    def cells(self) -> Int[Tensor, "n 3"]:
        """With step sizes, the rotation codes without their refinement bits."""
        return self.indices["rotation"].int() >> self.refinement_bits.int()


@cache
def decoder_shapes(shape: ColorShape) -> dict[str, torch.Size]:
    """Return the shapes of the colour decoder's weights by name, in the file's order."""
    decoder = color_decoder(shape, torch.Generator())
    return {name: value.shape for name, value in decoder.named_parameters()}


@lru_cache(maxsize=16)
def lobe_shapes(shape: LobeShape | None) -> dict[str, torch.Size]:
    """Return the shapes of a lobe decoder's weights by name, in the file's order; {} for None."""
    if shape is None:
        return {}
    decoder = LobeDecoder(shape, torch.Generator())
    return {name: value.shape for name, value in decoder.named_parameters()}


@cache
def network_shapes() -> dict[str, torch.Size]:
    """Return the shapes of the view network's weights by name, in the file's order."""
    with torch.device("meta"):
        return {name: value.shape for name, value in ViewNetwork().named_parameters()}


def _check_weights(title: str, weights: dict[str, Tensor], shapes: dict[str, torch.Size]) -> None:
    if {name: value.shape for name, value in weights.items()} != shapes:
        raise InputError(f"the weights of the {title} have wrong shapes")
    if not all(value.isfinite().all() for value in weights.values()):
        raise InputError(f"the {title} has weights that are not finite")


def scenes_equal(a: QuantizedScene, b: QuantizedScene) -> bool:
    """Return True if two scenes are equal to the last bit, including the order of their rows."""
    return _exact(a) == _exact(b)


def _exact(value: Any) -> Any:
    """Return a value that equals another one if their tensors have the same bits."""
    if isinstance(value, Tensor):
        return value.dtype, value.shape, value.numpy().tobytes()
    if isinstance(value, dict):
        return {name: (type(part), _exact(part)) for name, part in value.items()}
    if isinstance(value, list):
        return [_exact(part) for part in value]
    if is_dataclass(value):
        return [_exact(getattr(value, each.name)) for each in fields(value)]
    return value
