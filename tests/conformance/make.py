"""Makes the conformance files of docs/format.md, and what a decoder must find in each.

    python tests/conformance/make.py

A new version of the format adds files; those that are there stay as they are.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from test_web_decoder import Case, make_scene  # noqa: E402

from mobilegs.camera import look_at  # noqa: E402
from mobilegs.compress.codes import CodedScene  # noqa: E402
from mobilegs.compress.container import pack, unpack  # noqa: E402
from mobilegs.compress.layers import layered  # noqa: E402
from mobilegs.compress.lobes import LobeShape  # noqa: E402
from mobilegs.compress.positions import from_morton, morton_codes  # noqa: E402
from mobilegs.compress.scalars import ScalarSteps  # noqa: E402
from mobilegs.render.lobes import constant_lobes  # noqa: E402

ROWS = 12  # of each file that are written down
FILES = {
    "nvq_constant": Case(40, size=5),
    "nvq_ends": Case(25, size=4, alpha_min=1 / 64),
    "nvq_one": Case(1, LobeShape(0, 2, (3,)), size=2),
    "nvq_linear_lobes": Case(60, LobeShape(2, 6), size=16, skewed=True),
    "nvq_hidden_lobes": Case(300, LobeShape(1, 4, (8, 5)), opacity=False, size=64, exponent=0),
    "nvq_network": Case(30, network=True, size=9, spread=30.0),
    "nvq_lanes": Case(5000, LobeShape(0, 0), size=7, skewed=True, exponent=14, spread=1e-3),
    "sq_constant": Case(80, steps=ScalarSteps(0.01, 0.002, 0.01, 0.01)),
    "sq_lobes": Case(400, LobeShape(3, 8, (6,)), steps=ScalarSteps()),
    "sq_coarse": Case(50, LobeShape(2, 2), opacity=False, steps=ScalarSteps(3.0, 2.0, 2.0, 9.0)),
    "sq_layers": Case(500, LobeShape(1, 2), steps=ScalarSteps()),
    "nvq_layers": Case(200, LobeShape(2, 4), size=20, skewed=True),
    "sq_sorted": Case(70, steps=ScalarSteps()),
    "nvq_linear_colors": Case(60, LobeShape(2, 4, (5,)), size=16, colors="linear"),
    "sq_linear_colors": Case(90, LobeShape(1, 2), steps=ScalarSteps(), colors="linear"),
    "sq_color_latents": Case(
        64, LobeShape(1, 2), steps=ScalarSteps(), colors="linear", color_latents=8
    ),
    "nvq_contexts": Case(3000, LobeShape(0, 0), size=1, colors="linear"),
    "sq_ends_layers": Case(90, LobeShape(1, 2), steps=ScalarSteps(), alpha_min=1 / 64),
    "nvq_linear_layers": Case(70, LobeShape(1, 2), size=8, colors="linear"),
    "sq_latents_layers": Case(
        80, LobeShape(1, 2), steps=ScalarSteps(), colors="linear", color_latents=8
    ),
    "nvq_weights": Case(20, LobeShape(2, 6, (64,)), size=8),  # as trained ones: nothing repeats
}
# the others have no_depth
WEIGHTINGS = {
    "nvq_contexts": "mobile_gs",
    "sq_ends_layers": "no_scale",
    "nvq_linear_layers": "sort_free_gs",
}


def made(name: str) -> CodedScene:
    scene = make_scene(FILES[name], seed=len(name))
    if name != "nvq_weights":  # few different weights: they take little room
        for weights in (scene.decoder, scene.lobe_decoder, scene.network or {}):
            for part, value in weights.items():
                weights[part] = (2 * value.float()).round().clamp(-1, 1).half() / 2
    if name in WEIGHTINGS:
        scene = replace(scene, weighting=replace(scene.weighting, name=WEIGHTINGS[name]))
    if name == "nvq_contexts":  # in pairs of neighbours: small differences follow large ones
        codes = morton_codes(scene.positions)[::2] & ~np.uint64(1)
        pairs = np.sort(np.concatenate([codes, codes + np.uint64(1)]))
        scene = replace(scene, positions=from_morton(pairs))
    if name == "sq_sorted":
        scene = replace(scene, blend="sorted")
    if name.endswith("layers"):
        views = [view for view in scene.views for view in (view, view.resized(90, 60))]
        eye = torch.tensor([2.5, 1.0, 3.0], dtype=torch.float64)
        up = torch.tensor([0.0, -1.0, 0.0], dtype=torch.float64)
        turned = look_at(eye, torch.zeros(3, dtype=torch.float64), up).float()
        scene = layered(scene, 3, [*views, replace(views[0], viewmat=turned)])
    return scene


def expected(coded: CodedScene) -> dict:
    """What is in some rows, float32 values as the shortest decimals that lead back to them."""
    scene, count = coded.decode(), len(coded)
    lobes = scene.lobes
    if lobes is None:
        lobes = constant_lobes(scene.gaussians.logit_opacities)
    rows = sorted({round(i * (count - 1) / (ROWS - 1)) for i in range(ROWS)})
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
    return {"count": count, "layers": list(coded.layers or [count]), "rows": rows, **listed}


def main() -> None:
    for name in FILES:
        path = HERE / f"{name}.mgs"
        if path.exists():
            continue
        data = pack(made(name))
        path.write_bytes(data)
        text = json.dumps(expected(unpack(data)), separators=(",", ":"))
        path.with_suffix(".json").write_text(text.replace('],"', '],\n"') + "\n")


if __name__ == "__main__":
    main()
