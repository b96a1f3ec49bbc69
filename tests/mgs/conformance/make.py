"""Make the conformance files of docs/reference/format.md, and the numbers a decoder must find.

    python -m tests.mgs.conformance.make

Run it in the root of the repository. A new version of the format adds files; existing files are
not changed.
"""

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from mobilegs.camera import Camera, look_at
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.lod import with_lod_levels
from mobilegs.mgs.positions import morton_codes, positions_from_morton
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.mgs.rans import lane_count
from mobilegs.render import Footprint
from mobilegs.render.lobes import constant_lobes, evaluate_lobes
from mobilegs.render.scene import Scene
from mobilegs.representation.appearance import color_decoder
from mobilegs.representation.lobes import LobeShape
from mobilegs.representation.uniform_quantizer import StepSizes
from tests.support.scene_cases import Case, make_scene

HERE = Path(__file__).parent
ROWS = 12  # rows of each file that are listed
FILES = {
    "nvq_constant": Case(40, size=5),
    "nvq_ends": Case(25, size=4, alpha_min=1 / 64),
    "nvq_one": Case(1, LobeShape(0, 2, (3,)), size=2),
    "nvq_linear_lobes": Case(60, LobeShape(2, 6), size=16, skewed=True),
    "nvq_hidden_lobes": Case(300, LobeShape(1, 4, (8, 5)), opacity=False, size=64, exponent=0),
    "nvq_network": Case(30, network=True, size=9, spread=30.0),
    "nvq_lanes": Case(5000, LobeShape(0, 0), size=7, skewed=True, exponent=14, spread=1e-3),
    "sq_constant": Case(80, steps=StepSizes(0.01, 0.002, 0.01, 0.01)),
    "sq_lobes": Case(400, LobeShape(3, 8, (6,)), steps=StepSizes()),
    "sq_coarse": Case(50, LobeShape(2, 2), opacity=False, steps=StepSizes(3.0, 2.0, 2.0, 9.0)),
    "sq_layers": Case(500, LobeShape(1, 2), steps=StepSizes()),
    "nvq_layers": Case(200, LobeShape(2, 4), size=20, skewed=True),
    "sq_sorted": Case(70, steps=StepSizes()),
    "nvq_linear_colors": Case(60, LobeShape(2, 4, (5,)), size=16, colors="linear"),
    "sq_linear_colors": Case(90, LobeShape(1, 2), steps=StepSizes(), colors="linear"),
    "sq_color_latents": Case(
        64, LobeShape(1, 2), steps=StepSizes(), colors="linear", color_latents=8
    ),
    "nvq_contexts": Case(3000, LobeShape(0, 0), size=1, colors="linear"),
    "sq_ends_layers": Case(90, LobeShape(1, 2), steps=StepSizes(), alpha_min=1 / 64),
    "nvq_linear_layers": Case(70, LobeShape(1, 2), size=8, colors="linear"),
    "sq_latents_layers": Case(
        80, LobeShape(1, 2), steps=StepSizes(), colors="linear", color_latents=8
    ),
    "nvq_weights": Case(20, LobeShape(2, 6, (64,)), size=8),  # as trained ones: nothing repeats
    "sq_trained": Case(
        1 << 14, LobeShape(2, 12, (16,)), steps=StepSizes(), colors="linear", alpha_min=1 / 64
    ),
    "sq_degree_0": Case(30, LobeShape(1, 2, (4,)), steps=StepSizes(), colors="linear"),
    "nvq_degree_2": Case(30, LobeShape(1, 2, (4,)), size=6),
    "sq_degree_3": Case(30, steps=StepSizes(), colors="linear", color_latents=12),
    "nvq_network_picture": Case(60, network=True, size=9, colors="linear"),
    "sq_picture": Case(60, LobeShape(2, 4), steps=StepSizes(lobes=0.3), colors="linear"),
    "sq_sorted_picture": Case(60, steps=StepSizes(), colors="linear"),
    "sq_sorted_lobes_picture": Case(
        60, LobeShape(2, 4), steps=StepSizes(lobes=0.3), colors="linear"
    ),
    "nvq_latent_networks": Case(40, size=12, colors="latent_networks", joint=True, network=True),
    "sq_latent_networks_layers": Case(
        70, LobeShape(1, 2), steps=StepSizes(), colors="latent_networks"
    ),
    "sq_footprint_picture": Case(
        60,
        LobeShape(2, 4),
        steps=StepSizes(lobes=0.3),
        colors="linear",
        footprint=Footprint(0.1, antialiased=True, soft_edge=True),
    ),
    "sq_sorted_footprint_picture": Case(
        60, steps=StepSizes(), colors="linear", footprint=Footprint(0.2, antialiased=True)
    ),
    "nvq_footprint_layers": Case(
        70, LobeShape(1, 2), size=8, colors="linear", footprint=Footprint(soft_edge=True)
    ),
}
DEGREES = {"sq_degree_0": 0, "nvq_degree_2": 2, "sq_degree_3": 3}
# all other files have no_depth
WEIGHTINGS = {
    "nvq_contexts": "mobile_gs",
    "sq_ends_layers": "no_scale",
    "nvq_linear_layers": "sort_free_gs",
    "sq_trained": "mobile_gs",
    "sq_picture": "mobile_gs",
    "sq_footprint_picture": "mobile_gs",
    "nvq_network_picture": "no_scale",
}
ALIKE = 0.97  # share of equal Gaussians in the large file; the others are of one of `KINDS`
KINDS = 24
DIRECTIONS = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.48, -0.6, 0.64]]
PIXELS = [[16, 12], [12, 9], [19, 14], [15, 16], [10, 13], [22, 11], [0, 0]]  # x, y


def made(name: str) -> QuantizedScene:
    scene = make_scene(FILES[name], seed=len(name))
    if name != "nvq_weights":  # few different weights make small files
        for weights in (scene.decoder, scene.lobe_decoder, scene.network or {}):
            for part, value in weights.items():
                weights[part] = (2 * value.float()).round().clamp(-1, 1).half() / 2
    if name in DEGREES:
        scene = of_degree(scene, DEGREES[name])
    if name == "sq_trained":
        scene = with_many_alike(scene)
    if scene.network is not None and name.endswith("picture"):
        scene = replace(scene, network=thin(scene.network))
    if name in WEIGHTINGS:
        scene = replace(scene, weighting=replace(scene.weighting, name=WEIGHTINGS[name]))
    if name == "nvq_contexts":  # pairs of neighbours: small differences follow large ones
        codes = morton_codes(scene.positions)[::2] & ~np.uint64(1)
        pairs = np.sort(np.concatenate([codes, codes + np.uint64(1)]))
        scene = replace(scene, positions=positions_from_morton(pairs))
    if name.startswith("sq_sorted") or name == "sq_degree_3":
        scene = replace(scene, blend="sorted")
    if name.endswith("layers"):
        views = [view for view in scene.views for view in (view, view.resized(90, 60))]
        eye = torch.tensor([2.5, 1.0, 3.0], dtype=torch.float64)
        up = torch.tensor([0.0, -1.0, 0.0], dtype=torch.float64)
        turned = look_at(eye, torch.zeros(3, dtype=torch.float64), up).float()
        scene = with_lod_levels(scene, 3, [*views, replace(views[0], viewmat=turned)])
    return scene


def of_degree(scene: QuantizedScene, degree: int) -> QuantizedScene:
    """Return the scene with another colour decoder, which has few different weights."""
    g, codes = torch.Generator().manual_seed(degree), scene.indices["appearance"]
    if degree == 3:  # more latents than degree 1 can have
        codes = torch.cat([codes, codes.flip(1)], dim=1)
    latents = codes.shape[1] if scene.step_sizes else scene.color.latents
    shape = scene.color._replace(degree=degree, latents=latents)
    weights = color_decoder(shape, g).named_parameters()
    return replace(
        scene,
        indices=scene.indices | {"appearance": codes},
        decoder={n: torch.randint(-1, 2, w.shape, generator=g).half() / 2 for n, w in weights},
    )


def with_many_alike(scene: QuantizedScene) -> QuantizedScene:
    """Return the scene with mostly equal Gaussians in clusters, which makes a small file."""
    g, count = torch.Generator().manual_seed(0), len(scene)
    kinds = torch.randint(1, KINDS, (count,), generator=g)
    kinds[torch.rand(count, generator=g) < ALIKE] = 0
    steps = np.random.default_rng(0).integers(0, 4, (32, count // 32), dtype=np.uint64)
    clouds = morton_codes(scene.positions[:: count // 32]).reshape(32, 1)
    return replace(
        scene,
        positions=positions_from_morton(
            np.sort((clouds + steps.cumsum(1, dtype=np.uint64)).ravel())
        ),
        indices={name: codes[kinds] for name, codes in scene.indices.items()},
    )


def thin(network: dict[str, Tensor]) -> dict[str, Tensor]:
    """Return sparse weights of a view network: 0, 1/2 and -1/2."""
    g = torch.Generator().manual_seed(0)
    drawn = {name: torch.rand(value.shape, generator=g) for name, value in network.items()}
    return {n: ((x < 0.05).half() - (x > 0.95).half()) / 2 for n, x in drawn.items()}


def rows_of(coded: QuantizedScene) -> list[int]:
    """Return the listed rows: evenly spread, or unequal ones of each lane of a large file."""
    count = len(coded)
    if count < 1 << 14:
        return sorted({round(i * (count - 1) / (ROWS - 1)) for i in range(ROWS)})
    codes = coded.indices["appearance"]
    odd = (codes != codes.mode(0).values).any(1)
    lanes = np.split(np.arange(count), lane_count(count))
    return sorted(int(lane[odd[lane]][i]) for lane in lanes for i in (0, -1))


def seen(scene: Scene, rows: list[int]) -> dict:
    """Return opacity and phi of these rows from every direction."""
    some, lobes = scene.gaussians.select(torch.tensor(rows)), scene.lobes
    if lobes is None:
        lobes = constant_lobes(scene.gaussians.logit_opacities)
    found = []
    for direction in torch.tensor(DIRECTIONS, dtype=torch.float64):
        directions = direction.expand(len(rows), 3)
        now = lobes[rows] if scene.network is None else scene.network(some, directions)
        found.append(torch.stack(evaluate_lobes(now, directions)))
    opacity, phi = torch.stack(found, 2).tolist()
    return {"directions": DIRECTIONS, "opacity": shortened(opacity), "phi": shortened(phi)}


def drawn(scene: Scene, camera: Camera) -> dict:
    """Return some pixels of the image from a camera."""
    image = scene.render(camera.to("cpu", torch.float64)).image
    x, y = torch.tensor(PIXELS).T
    return {"pixels": PIXELS, "picture": shortened(image[y, x].tolist())}


def shortened(rows: list[list[float]]) -> list[list[float]]:
    return [[round(value, 8) for value in row] for row in rows]


def in_double(scene: Scene) -> Scene:
    """Return the scene in float64."""
    return replace(
        scene,
        gaussians=scene.gaussians.to(dtype=torch.float64),
        lobes=None if scene.lobes is None else scene.lobes.double(),
        network=None if scene.network is None else deepcopy(scene.network).double(),
        background=scene.background.double(),
    )


def expected(coded: QuantizedScene, *, picture: bool) -> dict:
    """Return the values of some rows, their opacity and phi by direction, and pixels on demand.

    float32 values are the shortest decimals that parse to them.
    """
    scene, count = coded.decode(), len(coded)
    lobes = scene.lobes
    if lobes is None:
        lobes = constant_lobes(scene.gaussians.logit_opacities)
    rows = rows_of(coded)
    parts = {
        "means": scene.gaussians.means,
        "log_scales": scene.gaussians.log_scales,
        "quats": torch.nn.functional.normalize(scene.gaussians.quats, dim=1),
        "sh": scene.gaussians.sh.flatten(1),
        "lobes": lobes.flatten(1),
    }
    listed = {
        name: [[float(str(x)) for x in row] for row in part[rows].numpy()]
        for name, part in parts.items()
    }
    exact = in_double(scene)
    with torch.no_grad():
        listed |= seen(exact, rows) | (drawn(exact, coded.views[0]) if picture else {})
    return {"count": count, "layers": list(coded.lod_sizes or [count]), "rows": rows, **listed}


def main() -> None:
    for name in FILES:
        path = HERE / f"{name}.mgs"
        if path.exists():
            continue
        data = encode_mgs(made(name))
        path.write_bytes(data)
        found = expected(decode_mgs(data), picture=name.endswith("picture"))
        text = json.dumps(found, separators=(",", ":"))
        path.with_suffix(".json").write_text(text.replace('],"', '],\n"') + "\n")


if __name__ == "__main__":
    main()
