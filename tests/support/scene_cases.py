"""Random quantized scenes that cover what `.mgs` files can hold."""

from dataclasses import dataclass, replace

import torch

from mobilegs.camera import Camera, look_at
from mobilegs.mgs.encode import Quantizer, encode_scene
from mobilegs.mgs.positions import PositionGrid
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render import Footprint, Weighting
from mobilegs.render.project import ALPHA_MIN, CLASSIC
from mobilegs.render.sortfree import WeightingName
from mobilegs.render.view_network import ViewNetwork
from mobilegs.representation.appearance import ColorShape, color_decoder
from mobilegs.representation.codebooks import CUTS, JOINT_CUTS, Attribute, SubVectorCodebooks
from mobilegs.representation.lobes import LobeDecoder, LobeShape
from mobilegs.representation.rotations import RotationQuantizer
from mobilegs.representation.uniform_quantizer import StepSizes, UniformQuantizer


@dataclass(frozen=True)
class Case:
    """The properties of a random scene."""

    count: int
    shape: LobeShape | None = None
    opacity: bool = True
    network: bool = False
    size: int = 37
    """Entries of each codebook."""
    skewed: bool = False
    """True: some entries are more frequent than others, and Gaussians come in pairs."""
    exponent: int = 11
    spread: float = 1.0
    steps: StepSizes | None = None
    """Of scalars in the place of codebooks."""
    layers: tuple[int, ...] = ()
    alpha_min: float = ALPHA_MIN
    colors: str = "networks"
    color_latents: int = 6
    joint: bool = False
    """One codebook for the three scales, and one for the quaternion."""
    footprint: Footprint = CLASSIC
    weighting: WeightingName = "no_depth"


CASES = {
    "one Gaussian": Case(1),
    "nothing by direction": Case(300, size=64, exponent=0, spread=30.0),
    "network": Case(120, network=True, skewed=True),
    "linear lobes": Case(40, LobeShape(2, 6), size=1, alpha_min=0.02),
    "lobes without latents": Case(90, LobeShape(1, 0, (7, 5)), exponent=14, spread=1e-4),
    "constant lobes": Case(50, LobeShape(0, 0), opacity=False),
    "one hidden layer": Case(500, LobeShape(0, 2, (5,)), size=4096),
    "three hidden layers": Case(333, LobeShape(3, 32, (16, 1, 256)), opacity=False),
    "several lanes": Case(20_000, LobeShape(2, 12, (64,)), size=300, skewed=True),
    "colours of all directions": Case(
        300, LobeShape(1, 2), steps=StepSizes(), colors="linear", color_latents=12
    ),
    "linear colours": Case(700, LobeShape(2, 12, (16,)), size=64, skewed=True, colors="linear"),
    "scalars": Case(9000, LobeShape(2, 12, (64,)), skewed=True, steps=StepSizes()),
    "scalars with lobes": Case(80, LobeShape(1, 2, (4,)), steps=StepSizes(), alpha_min=0.1),
    "one Gaussian of scalars": Case(1, LobeShape(1, 2), opacity=False, steps=StepSizes()),
    "scalars sorted, fine": Case(700, steps=StepSizes(0.01, 0.002, 0.01, 0.01)),
    "scalars, coarse": Case(300, LobeShape(0, 0), steps=StepSizes(3.0, 2.0, 2.0, 9.0)),
    "one place": Case(60, LobeShape(3, 4), skewed=True, spread=0.0),
    "layers": Case(9000, LobeShape(2, 12, (64,)), skewed=True, layers=(700, 1, 8299)),
    "layers of scalars": Case(
        400, LobeShape(1, 2, (4,)), steps=StepSizes(), layers=(390, 10), colors="linear"
    ),
    "one linear colour": Case(1, steps=StepSizes(), colors="linear"),
    "layers of one Gaussian": Case(8, network=True, layers=(1,) * 8),
    "the paper's": Case(600, network=True, size=200, colors="latent_networks", joint=True),
    "networks of latents, scalars": Case(
        300, LobeShape(1, 2), steps=StepSizes(), colors="latent_networks", layers=(40, 260)
    ),
    "antialiased": Case(70, LobeShape(1, 2), footprint=Footprint(0.1, antialiased=True)),
    "depth pass": Case(50, LobeShape(2, 6), weighting="depth_pass"),
    "soft edges, layers": Case(
        90, steps=StepSizes(), layers=(30, 60), footprint=Footprint(soft_edge=True)
    ),
}


def camera() -> Camera:
    viewmat = look_at(torch.tensor([0.3, 0.1, -4.0]), torch.zeros(3), torch.tensor([0.0, -1, 0]))
    K = torch.tensor([[40.1, 0, 16], [0, 41.7, 12], [0, 0, 1]])
    return Camera(viewmat, K, 32, 24)


def scalar_codes(books: dict[Attribute, Quantizer], steps: StepSizes) -> dict[Attribute, Quantizer]:
    """Return the values of codebooks quantized to multiples of step sizes."""
    scales = UniformQuantizer.fit(books["scale"]().detach(), step_size=steps.scale)
    found: dict[Attribute, Quantizer] = {"scale": scales}
    for name, book in books.items():
        step, values = getattr(steps, name), book().detach()
        if name == "rotation":
            found[name] = RotationQuantizer.fit(values, scales=scales, step_size=step)
        elif name != "scale":
            found[name] = UniformQuantizer.fit(values, step_size=step)
    return found


def make_scene(case: Case, seed: int = 0) -> QuantizedScene:
    """Return the scene of a case, the same one for a given seed."""
    g = torch.Generator().manual_seed(seed)
    given = JOINT_CUTS if case.joint else CUTS
    cuts: dict[Attribute, tuple[int, int]] = {n: (c.count, c.length) for n, c in given.items()}
    if not case.opacity:
        del cuts["opacity"]
    colors = color_decoder(ColorShape(case.colors, latents=case.color_latents), g)
    cuts["appearance"] = (case.color_latents // 2, 2)
    if case.colors == "linear":
        for matrix in colors.parameters():
            matrix.data.copy_(torch.randn(matrix.shape, generator=g))
    decoder = None
    if case.shape:
        decoder = LobeDecoder(case.shape, g)
        for parameter in decoder.parameters():
            parameter.data.copy_(0.5 * torch.randn(parameter.shape, generator=g))
        if case.shape.latents:
            cuts["lobes"] = (case.shape.latents // 2, 2)
    books: dict[Attribute, Quantizer] = {}
    for name, (count, length) in cuts.items():
        means = 0.5 * torch.randn(count, case.size, length, generator=g)
        drawn = torch.rand(case.count, count, generator=g) ** (4 if case.skewed else 1)
        indices = (drawn * case.size).long().clamp_max(case.size - 1)
        books[name] = SubVectorCodebooks(means - 1.5 * (name == "scale"), indices)
    if case.steps:
        books = scalar_codes(books, case.steps)
    means = case.spread * torch.randn(case.count, 3, generator=g)
    if case.skewed:
        means[1::2] = means[: len(means) // 2 * 2 : 2] * (1 + 1e-3)
    coded = encode_scene(
        means,
        books,
        PositionGrid(torch.tensor([0.1, -0.2, 0.3]), 1.7, case.exponent),
        colors,
        decoder,
        ViewNetwork(g) if case.network else None,
    )
    return replace(
        coded,
        lod_sizes=case.layers,
        weighting=Weighting(
            case.weighting,
            exponent_max=6.5,
            sigma=0.1,
            background_weight=1.5,
            alpha_min=case.alpha_min,
        ),
        footprint=case.footprint,
        background=torch.tensor([0.1, 0.5, 1.0]),
        near=0.05,
        views=[camera(), camera().resized(64, 48)],
        meta={"generator": "mobilegs 0 \U0001f33f", "psnr": 25.1, "test": True, "notes": None},
    )
