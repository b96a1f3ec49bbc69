"""Train real captures with the preset short, compress scenes, and collect their metrics.

    python -m bench.captures [--json OUT] [--runs FOLDER]
                             [--only bonsai horns lego demo playbot flowers]

Captures and scenes come from MOBILEGS_DATA. A finished run under FOLDER is not repeated. Nothing
else may run on the machine: `compress` plans its steps by their time.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

from bench.record import RESULTS, Figures, data_folder

# name: (folder of the data, options of `mobilegs train`)
CAPTURES = {
    "bonsai": ("bonsai", ["--downscale", "2"]),
    "horns": ("llff_horns", ["--downscale", "2", "--max-splats", "30000"]),
    "lego": ("tiny_lego", ["--max-splats", "20000"]),
}
SCENES = {"playbot": "splats/playbot_125k_sh3pad.ply", "flowers": "splats/flowers_lod1.ply"}


def command(name: str, output: Path) -> list[str]:
    """Return the command line that a user would give."""
    if name == "demo":
        return ["demo", "--output", str(output)]
    data = data_folder()
    if name in SCENES:
        return ["compress", str(data / SCENES[name]), "-o", str(output), "--resume"]
    folder, options = CAPTURES[name]
    words = ["train", str(data / folder), "-o", str(output), "--preset", "short", "--resume"]
    weights = ["--lpips-weights", str(data / "lpips")] if (data / "lpips").exists() else []
    return [*words, *options, *weights]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=RESULTS / "captures.json")
    parser.add_argument("--runs", type=Path, default=Path("runs"), help="where runs are kept")
    parser.add_argument("--only", nargs="+", default=[*CAPTURES, "demo", *SCENES])
    options = parser.parse_args()
    figures = Figures(options.json)
    for name in options.only:
        start, output = time.perf_counter(), options.runs / name
        finished = (output / "metrics.json").exists()
        program = [sys.executable, "-m", "mobilegs", *command(name, output)]
        subprocess.run(program, check=True)
        found = json.loads((output / "metrics.json").read_text())
        for who in ("teacher", "student"):
            views = found[who].pop("views")  # metrics.json keeps them
            found[who]["worst_psnr"] = min(
                (view["psnr"] for view in views if view["psnr"] is not None), default=None
            )
        if not finished:
            found["wall_seconds"] = round(time.perf_counter() - start)
        figures.add(name, **found)


if __name__ == "__main__":
    main()
