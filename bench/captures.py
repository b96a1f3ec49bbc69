"""Train real captures with the preset short and collect their metrics.

    python -m bench.captures [--json OUT] [--runs FOLDER] [--only bonsai horns lego demo]

Captures come from MOBILEGS_DATA. A finished run under FOLDER is not repeated.
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


def command(name: str, output: Path) -> list[str]:
    """Return the command line that a user would give."""
    if name == "demo":
        return ["demo", "--output", str(output)]
    data = data_folder()
    folder, options = CAPTURES[name]
    words = ["train", str(data / folder), "-o", str(output), "--preset", "short", "--resume"]
    weights = ["--lpips-weights", str(data / "lpips")] if (data / "lpips").exists() else []
    return [*words, *options, *weights]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=RESULTS / "captures.json")
    parser.add_argument("--runs", type=Path, default=Path("runs"), help="where runs are kept")
    parser.add_argument("--only", nargs="+", default=[*CAPTURES, "demo"])
    options = parser.parse_args()
    figures = Figures(options.json)
    for name in options.only:
        start, output = time.perf_counter(), options.runs / name
        program = [sys.executable, "-m", "mobilegs", *command(name, output)]
        subprocess.run(program, check=True)
        found = json.loads((output / "metrics.json").read_text())
        for who in ("teacher", "student"):
            found[who].pop("views")  # the means are enough here; metrics.json keeps each view's
        figures.add(name, **found, wall_seconds=round(time.perf_counter() - start))


if __name__ == "__main__":
    main()
