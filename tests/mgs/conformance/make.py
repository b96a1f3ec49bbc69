"""Make the conformance files of docs/reference/format.md, and the numbers a decoder must find.

    python -m tests.mgs.conformance.make

Run it in the root of the repository. A new version of the format adds files to `FILES`; existing
files are not changed. This file at commit d6b2d39 has the scenes of those before.
"""

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import torch

from mobilegs.camera import Camera
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render import Footprint
from mobilegs.render.lobes import constant_lobes, evaluate_lobes
from mobilegs.render.scene import Scene
from mobilegs.representation.lobes import LobeShape
from mobilegs.representation.uniform_quantizer import StepSizes
from tests.support.scene_cases import Case, make_scene

HERE = Path(__file__).parent
ROWS = 12  # rows of each file that are listed
# scenes of files to add, by name; a name that ends in `picture` lists pixels, too
FILES: dict[str, Case] = {
    "nvq_depth_pass_picture": Case(60, LobeShape(2, 6), weighting="depth_pass"),
    "sq_depth_pass_layers": Case(
        50, LobeShape(1, 2), steps=StepSizes(), layers=(20, 30), weighting="depth_pass"
    ),
    "sq_depth_pass_footprint_picture": Case(
        60,
        LobeShape(2, 6),
        steps=StepSizes(),
        footprint=Footprint(0.1, antialiased=True, soft_edge=True),
        weighting="depth_pass",
    ),
}
DIRECTIONS = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.48, -0.6, 0.64]]
PIXELS = [[16, 12], [12, 9], [19, 14], [15, 16], [10, 13], [22, 11], [0, 0]]  # x, y


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
    exact = in_double(scene)
    with torch.no_grad():
        listed |= seen(exact, rows) | (drawn(exact, coded.views[0]) if picture else {})
    return {"count": count, "layers": list(coded.lod_sizes or [count]), "rows": rows, **listed}


def main() -> None:
    for name, case in FILES.items():
        path = HERE / f"{name}.mgs"
        if path.exists():
            continue
        data = encode_mgs(make_scene(case, seed=len(name)))
        path.write_bytes(data)
        found = expected(decode_mgs(data), picture=name.endswith("picture"))
        text = json.dumps(found, separators=(",", ":"))
        path.with_suffix(".json").write_text(text.replace('],"', '],\n"') + "\n")


if __name__ == "__main__":
    main()
