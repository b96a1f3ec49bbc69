"""Time of a frame of scenes in three.js, beside the viewer: headless Chromium.

    python -m bench.viewers.three_meshes --mgs RUN/scene.mgs --ply RUN/teacher.ply [--json OUT]

`MobileGSMesh` and the viewer draw the student's `.mgs`. Spark's `SplatMesh` and three's own
`GaussianSplat` draw the `.ply` of its teacher. Cameras, rounds and frames are those of
`bench/viewers/compare.py`: an orbit of 1 degree per frame, all viewers in turns. The scene of three
has nothing else in it.
"""

import argparse
import json
import os
import platform
import time
from pathlib import Path
from typing import Any

from bench.viewers.chromium import launched
from bench.viewers.compare import (
    FOLDERS,
    Plan,
    Variant,
    install,
    median,
    plan_of,
    ring_of,
    rotated,
    visit,
)
from bench.viewers.serve import Server

VIEWER = "the viewer"
VARIANTS = {
    f"{VIEWER}, WebGL2": Variant("ours", "mgs", {"api": "webgl"}),
    "MobileGSMesh, WebGL2": Variant("three-mesh", "mgs", {"api": "webgl"}),
    "Spark 2.2.0 SplatMesh, WebGL2": Variant("spark", "ply"),
    f"{VIEWER}, WebGPU": Variant("ours", "mgs", {"api": "webgpu"}),
    "MobileGSMesh, WebGPU": Variant("three-mesh", "mgs", {"api": "webgpu"}),
    "three.js 0.187.0 GaussianSplat, WebGPU": Variant("three-splat", "ply"),
}


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Return the times of all viewers by name."""
    from playwright.sync_api import sync_playwright

    install()
    width, height = map(int, options.size.split("x"))
    server = Server(FOLDERS, {"mgs": options.mgs, "ply": options.ply})
    server.plan = plan_of(ring_of(options.mgs, width, height))
    plan = Plan(width, height, options.frames, options.warm, 0)
    visits: dict[str, list[dict[str, Any]]] = {name: [] for name in VARIANTS}
    with sync_playwright() as playwright:
        first = launched(playwright)  # whose files come from the disk
        first.new_page()
        first.close()
        for number in range(options.rounds):
            for name, variant in rotated(VARIANTS, number / options.rounds):
                found = visit(playwright, server, variant, plan)
                visits[name].append(found)
                print(f"{name}: {median(found['frame_ms'])} ms", flush=True)
    rows = {}
    for name, seen in visits.items():
        times = [milliseconds for found in seen for milliseconds in found["frame_ms"]]
        rows[name] = {
            "frame_ms": {"median": median(times), "min": round(min(times), 2)},
            "cpu_ms": median([found["cpu_ms"] for found in seen]),
            "complaints": sorted({text for found in seen for text in found["complaints"]}),
        }
    for name, row in rows.items():
        own = rows[f"{VIEWER}, {name.rsplit(', ', 1)[1]}"]["frame_ms"]
        row["share_of_the_viewer"] = round(row["frame_ms"]["min"] / own["min"], 2)
    return {
        "browser": f"Chromium {visits[next(iter(visits))][0]['browser']}, headless",
        "rows": rows,
    }


def table(rows: dict[str, Any]) -> str:
    """Return the rows as a table in Markdown."""
    lines = ["| scene in | ms of a frame, median | least | of the viewer's |", "|---|---|---|---|"]
    for name, row in rows.items():
        times, share = row["frame_ms"], row["share_of_the_viewer"]
        lines.append(f"| {name} | {times['median']:.0f} | {times['min']:.0f} | {share:.2f} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mgs", type=Path, required=True, help="the student")
    parser.add_argument("--ply", type=Path, required=True, help="its teacher")
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--name", default="bonsai", help="of the scene, in the results")
    parser.add_argument("--size", default="800x533")
    parser.add_argument("--frames", type=int, default=10, help="of the orbit, in a round")
    parser.add_argument("--warm", type=int, default=3, help="frames before it, not counted")
    parser.add_argument("--rounds", type=int, default=2)
    options = parser.parse_args()
    found = measure(options)
    print(table(found["rows"]))
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, no GPU: SwiftShader",
        "scene": {"mgs": options.mgs.name, "ply": options.ply.name, "name": options.name},
        "plan": {"size": options.size, "frames": options.frames, "rounds": options.rounds},
        **found,
    }
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
