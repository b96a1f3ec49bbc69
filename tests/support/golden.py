"""The golden cases, on which kernels, shaders and browsers are compared with the reference.

    python tests/support/golden.py

renders all cases by the reference, in float64, to `golden.png` in this folder. A test compares the
reference with that image, so that it does not change unnoticed.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import read_mgs
from mobilegs.render import Footprint, Weighting, render_sorted, render_sortfree
from mobilegs.render.inputs import RenderSettings
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.rendered import Rendered
from mobilegs.render.scene import Scene
from mobilegs.render.sortfree import WEIGHTINGS
from mobilegs.render.view_network import ViewNetwork
from tests.support.scenes import (
    SORTED,
    SORTFREE,
    as_float32,
    camera,
    near_threshold,
    random_scene,
)

STORED = Path(__file__).with_name("golden.png")
TRAINED = Path(__file__).with_name("trained.mgs")  # the student that `mobilegs demo` makes
Inputs = dict[str, torch.Tensor]
SIDES = ("height", "width")
BACKGROUND = torch.tensor([0.1, 0.2, 0.35])
RENDERERS: dict = {"sorted": (render_sorted, {})}
for _name in WEIGHTINGS:
    _weighting = Weighting(_name, sigma=4.0, background_weight=0.7, exponent_max=1.5)
    RENDERERS[_name] = (render_sortfree, {"weighting": _weighting})
_weighting = Weighting(exponent_max=1.5, alpha_min=1 / 20)
RENDERERS["small ellipses"] = (render_sortfree, {"weighting": _weighting})
_weighting = Weighting(exponent_max=1.5)
_antialiased = Footprint(0.1, antialiased=True)
RENDERERS["sorted, antialiased"] = (render_sorted, {"footprint": _antialiased})
for _name, _footprint, _sigma in (
    ("antialiased", _antialiased, 0.0),
    ("soft edge", Footprint(soft_edge=True), 0.0),
    ("levels", Footprint(), 1.0),
    ("all", Footprint(0.1, antialiased=True, soft_edge=True), 0.8),
):
    _options = {"weighting": _weighting, "footprint": _footprint, "level_sigma": _sigma}
    RENDERERS[_name] = (render_sortfree, _options)
_options = RENDERERS["all"][1]
RENDERERS["all, depth_pass"] = (
    render_sortfree,
    _options | {"weighting": replace(_weighting, name="depth_pass")},
)
# the same images with other gradients
DETACHED = {
    f"{name} detached": (render, {"weighting": replace(options["weighting"], detached=True)})
    for name, (render, options) in RENDERERS.items()
    if name in ("mobile_gs", "sort_free_gs")
}


def input_names(renderer: str) -> tuple[str, ...]:
    """Return the names of a renderer's tensors, in the order of its parameters."""
    return SORTED if renderer.startswith("sorted") else SORTFREE


def settings_of(renderer: str) -> RenderSettings:
    """Return the settings of a renderer."""
    return RenderSettings(**RENDERERS[renderer.removesuffix(" detached")][1])


def isotropic_lobes(opacity: float, phi: float = 1.0) -> torch.Tensor:
    """Return lobes of degree 2 that are the same in every direction."""
    lobes = torch.zeros(9, 2, dtype=torch.float64)
    lobes[:1] = constant_lobes(torch.tensor([opacity], dtype=torch.float64).logit(), phi)[0]
    return lobes


def with_rows(scene: Inputs, **changes: tuple) -> Inputs:
    """Return the scene with rows of some inputs replaced: `name=(rows, value)`."""
    scene = {name: value.clone() for name, value in scene.items()}
    for name, (rows, value) in changes.items():
        scene[name][rows] = torch.as_tensor(value, dtype=torch.float64)
    return scene


BASE = random_scene(60)
# values that are not finite, as changes of `with_rows` for BASE
INVALID = {
    "NaN mean": {"means": ([0, 3], float("nan"))},
    "infinite mean": {"means": ([0, 3], float("inf"))},
    "NaN quaternion": {"quats": ([1], float("nan"))},
    "NaN scale": {"scales": ([1, 2], float("nan"))},
    "infinite scale": {"scales": ([1, 2], float("inf"))},
    "NaN opacity or lobe": {"opacities": ([5], float("nan")), "lobes": ([5], float("nan"))},
    "infinite opacity or lobe": {"opacities": ([5], float("inf")), "lobes": ([5], float("inf"))},
    "NaN colour": {"sh": ([6], float("nan"))},
}


def finite_rows(bad: str) -> torch.Tensor:
    """Return the rows of BASE that keep their values in the case `bad` of INVALID, a mask."""
    rows = torch.ones(60, dtype=torch.bool)
    rows[next(iter(INVALID[bad].values()))[0]] = False
    return rows


CASES = {
    "random, degree 0": (random_scene(70, degree=0, lobe_degree=3, seed=1), camera()),
    "random, degree 1": (random_scene(70, degree=1, lobe_degree=2, seed=2), camera()),
    "random, degree 2": (random_scene(70, degree=2, lobe_degree=1, seed=3), camera()),
    "random, degree 3": (random_scene(70, degree=3, lobe_degree=0, seed=4), camera()),
    "both of degree 0": (random_scene(70, degree=0, lobe_degree=0, seed=11), camera()),
    "both of degree 3": (random_scene(70, degree=3, lobe_degree=3, seed=12), camera()),
    "several tiles": (random_scene(150, seed=5), camera(83, 50)),
    "large": (random_scene(60, seed=15, spread=0.8, size=2.5), camera(83, 50)),
    "one pixel": (random_scene(40, seed=6, spread=0.3), camera(1, 1)),
    "one Gaussian": (random_scene(1, seed=9, spread=0.1), camera()),
    "empty scene": (random_scene(0), camera()),
    "around the camera": (random_scene(120, seed=8, spread=4.0), camera()),
    "nothing in view": (with_rows(BASE, means=(slice(None), [0.0, 0.0, -50.0])), camera()),
    "opaque": (
        with_rows(
            BASE, opacities=(slice(0, 40), 1.0), lobes=(slice(0, 40), isotropic_lobes(1 - 1e-15))
        ),
        camera(),
    ),
    "too faint": (
        with_rows(
            BASE, opacities=(slice(0, 30), 1 / 300), lobes=(slice(0, 30), isotropic_lobes(1 / 300))
        ),
        camera(),
    ),
    "zero size": (with_rows(BASE, scales=(slice(0, 20), 0.0)), camera()),
    "needles": (with_rows(BASE, scales=(slice(0, 20), [0.7, 1e-5, 1e-5])), camera()),
    "huge": (with_rows(BASE, scales=(slice(0, 3), 30.0)), camera()),
    "equal scales": (with_rows(BASE, scales=(slice(None), 0.1)), camera()),
    "equal depths": (with_rows(BASE, means=(slice(0, 20), [0.1, 0.1, 0.2])), camera()),
    "no direction": (with_rows(BASE, quats=(slice(0, 5), 0.0)), camera()),
    "long quaternions": (with_rows(BASE, quats=(slice(0, 5), [30.0, -10.0, 20.0, 5.0])), camera()),
    "phi zero": (with_rows(BASE, lobes=(slice(0, 30), isotropic_lobes(0.4, 0.0))), camera()),
    "phi below zero": (with_rows(BASE, lobes=(slice(0, 30), isotropic_lobes(0.4, -0.5))), camera()),
}


# of renderers that differ in one formula from those that render all cases
EXAMPLES = (
    "random, degree 2",
    "large",
    "around the camera",
    "needles",
    "phi zero",
    "phi below zero",
)


def golden_cases(renderer: str) -> Iterable[str]:
    """Return the cases on which a renderer of shaders is compared with the reference."""
    return CASES if renderer in ("sorted", "mobile_gs", "all") else EXAMPLES


def inputs_of(case: str) -> tuple[dict[str, torch.Tensor], Camera]:
    """Return a case in float64 with numbers that float32 can represent."""
    inputs, view = CASES[case]
    return as_float32(inputs), view.to(dtype=torch.float32).to(dtype=torch.float64)


def render_reference(case: str, renderer: str) -> Rendered:
    """Render a case by the reference."""
    inputs, view = inputs_of(case)
    render, options = RENDERERS[renderer]
    return render(
        *[inputs[name] for name in input_names(renderer)],
        camera=view,
        background=BACKGROUND.double(),
        backend="reference",
        **options,
    )


def as_scene(inputs: dict[str, torch.Tensor], renderer: str) -> Scene:
    """Return the float32 scene with the given inputs of a renderer."""
    inputs = {name: value.float() for name, value in inputs.items()}
    gaussians = Gaussians(
        means=inputs["means"],
        quats=inputs["quats"],
        log_scales=inputs["scales"].log(),
        logit_opacities=inputs["opacities"].double().logit().clamp(-40, 40).float(),
        sh=inputs["sh"],
    )
    settings = settings_of(renderer)
    if renderer.startswith("sorted"):
        return Scene(gaussians, background=BACKGROUND, footprint=settings.footprint)
    return Scene(
        gaussians,
        "sortfree",
        lobes=inputs["lobes"],
        weighting=settings.weighting,
        background=BACKGROUND,
        footprint=settings.footprint,
    )


# a view network on these Gaussians
NETWORK_CASES = {
    **{
        f"degree {degree}": random_scene(90, degree=degree, seed=20 + degree) for degree in range(4)
    },
    "33 Gaussians": random_scene(33, seed=31),
    "no Gaussian": random_scene(0),
    "around the camera": random_scene(300, seed=8, spread=4.0),
    "nothing in view": CASES["nothing in view"][0],
    "zero size": CASES["zero size"][0],
}


def view_network(seed: int = 0) -> ViewNetwork:
    """Return a network whose opacities and phi change much with the direction."""
    generator = torch.Generator().manual_seed(seed)
    network = ViewNetwork(generator).requires_grad_(False)
    for name, value in network.named_parameters():
        if "weight" in name:
            wide = (3 / value.shape[1]) ** 0.5 * (2.0 if value.shape[0] > 1 else 3.0)
            value.copy_((2 * torch.rand(value.shape, generator=generator) - 1) * wide)
    return network


def network_case(case: str) -> tuple[Scene, Camera]:
    """Return a float32 scene with a view network, and a camera."""
    scene = as_scene(as_float32(NETWORK_CASES[case]), "mobile_gs")
    return with_network(scene), camera().to(dtype=torch.float32)


def with_network(scene: Scene) -> Scene:
    """Return the scene with a view network in place of lobes."""
    return replace(scene, lobes=None, network=view_network())


def sure_with_network(case: str) -> torch.Tensor:
    """Return the pixels of a case where no rounding decides what is drawn, `[h, w]`."""
    scene, view = network_case(case)
    gaussians = scene.gaussians
    offsets = gaussians.means - view.position
    lobes = view_network()(gaussians, torch.nn.functional.normalize(offsets, dim=1))
    inputs = {
        "means": gaussians.means,
        "quats": gaussians.quats,
        "scales": gaussians.scales,
        "opacities": gaussians.opacities,
        "lobes": lobes,
        "sh": gaussians.sh,
    }
    inputs = {name: value.double() for name, value in inputs.items()}
    names, settings = input_names("mobile_gs"), settings_of("mobile_gs")
    return ~near_threshold(
        inputs, view.to(dtype=torch.float64), names=names, margin=1e-4, settings=settings
    )


def turned_around(view: Camera, angle: float) -> Camera:
    """Return a camera that looks at the origin after a turn about the vertical axis, in radians."""
    c, s = math.cos(angle), math.sin(angle)
    turn = torch.tensor([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]])
    return replace(view, viewmat=view.viewmat @ turn.to(view.viewmat))


def trained() -> tuple[Scene, Camera]:
    """Return the trained student from its file, and one of its cameras."""
    coded = read_mgs(TRAINED)
    return coded.decode(), coded.views[0].resized(480, 320)


def sheet() -> np.ndarray:
    """Render all cases to one image: a row per case, a column per renderer, RGBA bytes."""
    height, width = (max(getattr(view, s) for _, view in CASES.values()) for s in SIDES)
    found = np.zeros((len(CASES), height + 1, len(RENDERERS), width + 1, 4), np.uint8)
    for row, case in enumerate(CASES):
        for column, renderer in enumerate(RENDERERS):
            rendered = render_reference(case, renderer)
            rgba = torch.cat([rendered.image, rendered.alpha[..., None]], dim=2).clamp(0, 1)
            h, w, _ = rgba.shape
            found[row, :h, column, :w] = (255 * rgba).round().byte().numpy()
    return found.reshape(len(CASES) * (height + 1), -1, 4)


if __name__ == "__main__":
    Image.fromarray(sheet()).save(STORED, optimize=True)
    print(f"{STORED}: {STORED.stat().st_size} bytes; check it by eye")
