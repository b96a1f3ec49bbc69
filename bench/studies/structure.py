"""Find the poses of photos whose poses are known: number, error, time.

    python -m bench.studies.structure [--json OUT] [--scenes fern horns bonsai]
    python -m bench.studies.structure --table      # writes into docs/guides/capture.md

The photos are those of fern (20 at 504x378), horns (62 at 499x374) and every third of bonsai (98
at 800x533), from MOBILEGS_DATA, without their poses. Both mappers place each set, from all pairs
(not bonsai) and from pairs that look alike, on OMP_NUM_THREADS threads. The mappers share the
matches.

- `off`: largest and mean distance of a camera from its known position after the best similarity,
  divided by the largest distance of a camera from their mean;
- `seconds`: of each stage;
- `recall`: of the ten photos with the most matches to a photo, the mean share among its first ten
  and its first twenty look-alikes, and among as many neighbours by name.
"""

import argparse
import json
import os
import platform
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import orthogonal_procrustes

from mobilegs.capture import CaptureRun, capture_photos
from mobilegs.capture.matches import read_descriptors, vlad_vectors
from mobilegs.capture.pycolmap_runtime import load_pycolmap
from mobilegs.capture.workspace import Workspace
from mobilegs.data import load_capture

SCENES = {  # folder, every which photo, which pairs
    "fern": ("tiny_fern", 1, ("all", "alike")),
    "horns": ("llff_horns", 1, ("all", "alike")),
    "bonsai": ("bonsai", 3, ("alike",)),
}
BEST = 10
ROOT = Path(__file__).parents[2]
RESULTS, DOCS = ROOT / "bench/results/structure.json", ROOT / "docs/guides/capture.md"
BEGIN, END = "<!-- BEGIN:numbers -->", "<!-- END:numbers -->"


def centers(capture: Path) -> dict[str, np.ndarray]:
    dataset = load_capture(capture)
    frames = [*dataset.train, *dataset.test]
    return {Path(frame.name).stem: frame.camera.position.double().numpy() for frame in frames}


def off(capture: Path, reference: Path) -> dict[str, float]:
    """Return distances of camera positions after a similarity, as shares of the extent."""
    found, known = centers(capture), centers(reference)
    names = sorted(found)
    one, other = (np.array([poses[name] for name in names]) for poses in (found, known))
    one, other = one - one.mean(0), other - other.mean(0)
    turned = one @ orthogonal_procrustes(one, other)[0]
    scale = (turned * other).sum() / (turned * turned).sum()
    errors = np.linalg.norm(scale * turned - other, axis=1) / np.linalg.norm(other, axis=1).max()
    return {"largest": float(errors.max()), "mean": float(errors.mean())}


def recall(database: Path) -> dict[str, float]:
    """Return how well look-alikes predict matches; the database must hold all pairs."""
    with load_pycolmap().Database.open(database) as content:
        names = {image.image_id: image.name for image in content.read_all_images()}
        order = sorted(names, key=lambda number: names[number])
        rank = {number: index for index, number in enumerate(order)}
        strength = np.zeros((len(names), len(names)))
        for pair, inliers in zip(*content.read_two_view_geometry_num_inliers(), strict=True):
            one, two = (rank[number] for number in load_pycolmap().pair_id_to_image_pair(pair))
            strength[one, two] = strength[two, one] = inliers
    looks = vlad_vectors(read_descriptors(database, [names[number] for number in order]))
    away = np.abs(np.subtract.outer(np.arange(len(order)), np.arange(len(order))))
    alike, near = looks @ looks.T, -away.astype(float)
    for table in (strength, alike, near):
        np.fill_diagonal(table, -np.inf)
    best = np.argsort(-strength, axis=1, kind="stable")[:, :BEST]

    def share(table: np.ndarray, first: int) -> float:
        ranked = np.argsort(-table, axis=1, kind="stable")[:, :first]
        return float(np.mean([np.isin(best[i], ranked[i]).mean() for i in range(len(best))]))

    return {
        "alike_10": share(alike, 10),
        "alike_20": share(alike, 20),
        "neighbours_10": share(near, 10),
        "neighbours_20": share(near, 20),
    }


def measure(scene: str, work: Path) -> dict[str, Any]:
    folder, step, chosen = SCENES[scene]
    reference = Path(os.environ["MOBILEGS_DATA"]) / folder
    photos = work / "photos"
    photos.mkdir()
    for path in sorted((reference / "images").iterdir())[::step]:
        shutil.copy(path, photos)
    cells: dict[str, Any] = {}
    for pairs in chosen:
        for mapper in ("incremental", "global"):
            output = work / f"of_{pairs}"
            report = capture_photos(
                CaptureRun(photos, output, pairs=pairs, mapper=mapper, min_placed=0)
            )
            kept = ("photos", "registered", "models", "points", "reprojection_error", "compared")
            cells[f"{pairs}/{mapper}"] = {
                **{name: report[name] for name in kept},
                "off": off(output, reference),
                "seconds": {**report["seconds_of"], "undistortion": report["seconds"]},
            }
            print(scene, pairs, mapper, json.dumps(cells[f"{pairs}/{mapper}"]), flush=True)
        if pairs == "all":
            cells["recall"] = recall(Workspace(output).database)
            print(scene, json.dumps(cells["recall"]), flush=True)
    return cells


def table(results: dict[str, Any]) -> str:
    """Return one row per scene, choice of pairs and mapper."""
    rows = [
        "| photos | pairs | mapper | placed | off, mean / largest | error | points | features, "
        "matches, model |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for scene, cells in results["scenes"].items():
        for name, cell in cells.items():
            if name == "recall":
                continue
            pairs, mapper = name.split("/")
            off, seconds = cell["off"], cell["seconds"]
            times = ", ".join(f"{seconds[stage]:.0f}" for stage in ("features", "matches", "model"))
            rows.append(
                f"| {scene} | {cell['compared']:,} {pairs} | {mapper} "
                f"| {cell['registered']} of {cell['photos']} "
                f"| {off['mean']:.2%} / {off['largest']:.2%} "
                f"| {cell['reprojection_error']:.2f} px | {cell['points']:,} | {times} s |"
            )
    return "\n".join(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", type=Path)
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    if options.table:
        before, rest = DOCS.read_text().split(BEGIN)
        text = table(json.loads(RESULTS.read_text()))
        DOCS.write_text(f"{before}{BEGIN}\n{text}\n{END}{rest.split(END)[1]}")
        return
    results: dict[str, Any] = {
        "machine": platform.machine(),
        "threads": os.environ.get("OMP_NUM_THREADS", "all"),
        "pycolmap": load_pycolmap().__version__,
        "scenes": {},
    }
    for scene in options.scenes:
        with tempfile.TemporaryDirectory() as work:
            results["scenes"][scene] = measure(scene, Path(work))
        if options.json:
            options.json.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
