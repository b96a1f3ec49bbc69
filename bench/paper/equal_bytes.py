"""Compare the default with sorted students whose files have as many bytes: pictures, then motion.

    python -m bench.paper.equal_bytes --runs RUNS --scenes horns-250 lego-200

Cells come from bench/paper/run.py: row `default` as it ships, and the same row and the sorted ones
with another `teacher.max_splats`, `student.quantization.target_mb` or `.quality`. Of each the best
one counts whose file has at most 2 % more and 10 % fewer bytes than the default's.
`default-no-depth-pass` has the default's settings, and may have more bytes. This script opens their
files:

- *frame*: the time of a frame of our viewer in headless Chromium, as bench/viewers/compare.py has
  it, at 800 pixels of width; viewers do not draw harmonics of degree 2.
- *stale*: frames of two turns, by 6 degrees a frame and by 90 degrees a second, that are less than
  50 dB from the viewer's own settled picture: their order comes too late.
- *pops*: pixels of 100,000 that jump by more than 8 levels, and by that much more than a frame
  before and after, while the camera turns by 0.01 degrees a frame; drawn by the kernels in exact
  order.
"""

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import torch

from bench.paper.captures import CAPTURES, find_capture
from bench.paper.cells import CELL
from bench.record import RESULTS, Figures, data_folder
from bench.viewers.compare import Variant, measure, ring_of
from mobilegs.camera import Camera
from mobilegs.data import load_capture
from mobilegs.scene_file import open_scene

LEAST, MOST = 0.9, 1.02  # bytes of a file, of those that it is compared with
BASE, WITHOUT = "default", "default-no-depth-pass"
OTHERS = BASE, "default-sorted", "default-sorted-sh-2", "default-sorted-lobes"
VIEWS = "student.views_per_step"
# settings that decide how many bytes a file of the others has
AIMED = {
    "teacher.max_splats",
    "student.quantization.target_mb",
    "student.quantization.quality",
}
WIDTH = 800  # pixels
FINE, FRAMES = 0.01, 60  # degrees between two frames (an eighth of a pixel), and their number
JUMP = 8.0  # levels of 255
MOTION = RESULTS / "equal_bytes.json"


def equal_cells(cells: list[dict]) -> dict[str, list[dict]]:
    """Return the cells of each scene: the longest default, then the best of each other row."""
    found: dict[str, list[dict]] = {}
    for scene in CAPTURES:
        of_scene = [cell for cell in cells if cell["scene"] == scene]
        bases = [cell for cell in of_scene if cell["row"] == BASE and _ships(cell)]
        if not bases:
            continue
        base = max(bases, key=lambda cell: (cell["student_steps"], -cell["seed"]))
        found[scene] = [base]
        for row in (WITHOUT, *OTHERS):
            told = _ships if row == WITHOUT else _is_aimed
            near = [cell for cell in of_scene if cell["row"] == row and told(cell)]
            if near := [cell for cell in near if _is_equal(cell, base)]:
                found[scene].append(max(near, key=lambda cell: cell["psnr"]))
    return {scene: some for scene, some in found.items() if len(some) > 1}


def _ships(cell: Mapping) -> bool:
    return set(cell.get("settings", ())) <= {VIEWS}


def _is_aimed(cell: Mapping) -> bool:
    return set() < set(cell.get("settings", ())) - {VIEWS} <= AIMED


def _is_equal(cell: Mapping, base: Mapping) -> bool:
    of = ("teacher_steps", "student_steps", "seed")
    same = all(cell[name] == base[name] for name in of)
    return same and (cell["row"] == WITHOUT or LEAST <= cell["bytes"] / base["bytes"] <= MOST)


def name_of(cell: Mapping) -> str:
    """Return the name of a cell in the table: the row, and what else is not as it ships."""
    more = cell["row"] == BASE and _is_aimed(cell)
    return f"{cell['row']}, more Gaussians" if more else cell["row"]


def key_of_motion(cell: Mapping) -> str:
    """Return the name of a cell's figures in motion."""
    return f"{cell['scene']}, {name_of(cell)}"


def equal_table(cells: list[dict], motion: Mapping[str, Mapping]) -> tuple[list[str], list[list]]:
    """Return the headings and rows of the table."""
    rows = []
    for scene, some in equal_cells(cells).items():
        width, height = some[0]["image_size"]
        for cell in some:
            moved = motion.get(key_of_motion(cell))
            told = ["-"] * 3
            if moved is not None:
                told = [f"{moved['frame_ms']:.0f}", f"{moved['stale']} of {moved['frames']}"]
                told.append(f"{moved['pops']:.1f}")
            rows.append(
                [
                    f"{scene.split('-')[0]} {width}x{height}",
                    name_of(cell),
                    f"{cell['psnr']:.2f}",
                    f"{cell['ssim']:.4f}",
                    f"{cell['lpips_vgg']:.4f}",
                    f"{cell['bytes'] / 1000:.0f}",
                    f"{cell['gaussians']:,}",
                    *told,
                ]
            )
    headings = ["capture", "row", "PSNR", "SSIM", "LPIPS", "kB", "Gaussians"]
    headings += ["frame, ms", "stale frames", "pops of 100,000"]
    return headings, rows


def summary(cells: list[dict]) -> str:
    """Return what the README says: the default against the best sorted student of each scene."""
    scenes = []
    for scene, (base, *others) in equal_cells(cells).items():
        sorted_ones = [cell for cell in others if cell["row"] not in (BASE, WITHOUT)]
        if sorted_ones:
            pair = base, max(sorted_ones, key=lambda cell: cell["psnr"])
            decibels = " and ".join(f"{cell['psnr']:.2f}" for cell in pair)
            lpips = " and ".join(f"{cell['lpips_vgg']:.4f}" for cell in pair)
            scenes.append(f"{scene.split('-')[0]} {decibels} dB, LPIPS {lpips}")
    return (
        "At equal bytes, the default and the best sorted student have: "
        f"{'; '.join(scenes)} ([table](docs/explanation/paper.md))."
    )


def popping(drawn: np.ndarray) -> float:
    """Return the pixels of 100,000 that pop between two frames, the mean over the frames.

    A pixel pops where its largest change is above the changes of the frames before and after by
    JUMP. `drawn` is `[frames, h, w, 3]`, 0 to 255.
    """
    change = np.abs(np.diff(drawn, axis=0)).max(-1)
    beside = np.maximum(change[:-2], change[2:])
    return float(1e5 * (change[1:-1] - beside > JUMP).mean())


def pops(path: Path, cameras: list[Camera]) -> float:
    """Return the popping of a scene along a path, drawn by the kernels."""
    scene = open_scene(path, torch.device("cpu"))
    with torch.no_grad():
        frames = (255 * scene.render(camera).image.clamp(0, 1) for camera in cameras)
        return popping(np.stack([frame.round().numpy() for frame in frames]))


def motion_of(
    options: argparse.Namespace, some: list[tuple[dict, Path]], known: Mapping[str, Mapping]
) -> Iterator[tuple]:
    """Yield the name and the figures in motion of each cell of a scene that is not known yet."""
    base = some[0][0]
    place = CAPTURES[base["scene"]]
    capture = find_capture(data_folder(), place)
    assert capture is not None, f"MOBILEGS_DATA has no {place.folders[0]}"
    dataset = load_capture(capture, downscale=place.downscale)
    views = [frame.camera for frame in dataset.train]
    width, height = base["image_size"]
    size = WIDTH, round(WIDTH * height / width)
    fine = ring_of(views, *size, step=FINE)[:FRAMES]
    for cell, path in some:
        if known.get(key_of_motion(cell), {}).get("bytes") == cell["bytes"]:
            continue
        scene = {"mgs": path, "ply": path, "size": f"{size[0]}x{size[1]}"}
        more = {"warm": 3, "pictures": None, "loads": 0}
        wanted = argparse.Namespace(**vars(options) | scene | more)
        variant = Variant("ours", "mgs", {"api": "webgpu"})
        measured = measure(wanted, views, {"WebGPU": variant})
        if not measured:  # viewers draw harmonics of degree 1 alone
            continue
        row = measured["WebGPU"]
        turns = [row[turn] for turn in ("turn", "timed")]
        yield (
            key_of_motion(cell),
            {
                "size": list(size),
                "frame_ms": row["frame_ms"]["median"],
                "stale": sum(turn["stale"] for turn in turns),
                "frames": sum(turn["frames"] for turn in turns),
                "least_db": min(turn["moving_settled"]["min"] for turn in turns),
                "pops": round(pops(path, fine), 2),
                "bytes": cell["bytes"],
            },
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=Path, default=Path("runs/paper"))
    parser.add_argument("--scenes", nargs="+", required=True, choices=CAPTURES, metavar="SCENE")
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--turn-frames", type=int, default=10)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--json", type=Path, default=MOTION)
    options = parser.parse_args()
    figures = Figures(options.json)
    paths = [path for name in options.scenes for path in options.runs.glob(f"{name}/*/{CELL}")]
    folders = [(json.loads(path.read_text()), path.parent) for path in sorted(paths)]
    for some in equal_cells([cell for cell, _ in folders]).values():
        files = [next(f for c, f in folders if c is cell) / "scene.mgs" for cell in some]
        for name, found in motion_of(options, list(zip(some, files, strict=True)), figures.rows):
            figures.add(name, **found)


if __name__ == "__main__":
    main()
