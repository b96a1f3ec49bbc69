"""Find where a student loses against a sorted scene: squared error by depth, detail, novelty.

    python -m bench.studies.where_loss_sits CAPTURE SORTED.ply STUDENT.mgs [--downscale N]
        [--json OUT]

Pixels of the held-back photos are split into quarters by the depth of the sorted scene, by local
contrast (the largest difference of brightness within 5x5 pixels of the photo), and by the angle
between the line of sight and that of the nearest training camera. Each quarter has the mean
squared error of both scenes.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

import torch
from torch.nn.functional import max_pool2d

from mobilegs.data import Dataset, load_capture, load_view
from mobilegs.evaluate.metrics import as_displayed
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene


def local_contrast(image: torch.Tensor) -> torch.Tensor:
    gray = image.mean(2)[None, None]
    return (max_pool2d(gray, 5, 1, 2) + max_pool2d(-gray, 5, 1, 2))[0, 0]


def novelty(dataset: Dataset, index: int) -> float:
    """Return the angle in degrees between a held-back view and its nearest training view."""
    sights = torch.stack([frame.camera.viewmat[2, :3] for frame in dataset.train])
    own = dataset.test[index].camera.viewmat[2, :3]
    return float(torch.rad2deg(torch.arccos((sights @ own).clamp(-1, 1))).min())


@torch.inference_mode()
def measured(dataset: Dataset, bar: Scene, student: Scene) -> dict[str, list[torch.Tensor]]:
    """Return both errors and the split values of every pixel of all held-back views."""
    found: dict[str, list[torch.Tensor]] = {}
    for index, frame in enumerate(dataset.test):
        view = load_view(frame)
        drawn = bar.render(view.camera, depth=True)
        assert drawn.depth is not None
        errors = [
            (as_displayed(image) - view.image).square().mean(2)
            for image in (drawn.image, student.render(view.camera).image)
        ]
        row = {
            "sorted": errors[0],
            "student": errors[1],
            "depth": drawn.depth / drawn.alpha.clamp_min(1e-6),
            "contrast": local_contrast(view.image),
            "angle to the nearest training view": torch.full_like(
                errors[0], novelty(dataset, index)
            ),
        }
        for name, values in row.items():
            found.setdefault(name, []).append(values.flatten())
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("capture", type=Path)
    parser.add_argument("bar", type=Path)
    parser.add_argument("student", type=Path)
    parser.add_argument("--downscale", type=int)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    dataset = load_capture(options.capture, downscale=options.downscale)
    bar = open_scene(options.bar, torch.device("cpu"))
    bar = replace(bar, background=dataset.background, near=dataset.near)
    pixels = measured(dataset, bar, open_scene(options.student, torch.device("cpu")))
    flat = {name: torch.cat(values) for name, values in pixels.items()}
    lost = flat["student"] - flat["sorted"]
    result = {"mse": {who: float(flat[who].mean()) for who in ("sorted", "student")}}
    for name in ("depth", "contrast", "angle to the nearest training view"):
        order = torch.argsort(flat[name], stable=True)
        rows = []
        for quarter in order.tensor_split(4):
            rows.append(
                {
                    "from": round(float(flat[name][quarter[0]]), 4),
                    "to": round(float(flat[name][quarter[-1]]), 4),
                    "sorted_mse": float(flat["sorted"][quarter].mean()),
                    "student_mse": float(flat["student"][quarter].mean()),
                    "lost": float(lost[quarter].mean()),
                }
            )
        result[name] = rows
        print(name)
        for row in rows:
            ratio = row["student_mse"] / row["sorted_mse"]
            print(f"  {row['from']:9.3f} to {row['to']:9.3f}: {ratio:.3f} of the sorted error")
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
