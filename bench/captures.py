"""Train real captures with the CPU preset and collect their metrics.

    python -m bench.captures [--json OUT] [--runs FOLDER] [--only bonsai horns lego demo]

Captures come from MOBILEGS_DATA. A finished run under FOLDER is not repeated, so the script
resumes.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

from mobilegs.csrc.binding import kernel_level

# name: (folder of the data, options of `mobilegs train`)
CAPTURES = {
    "bonsai": ("bonsai", ["--downscale", "2"]),
    "horns": ("llff_horns", ["--downscale", "2", "--max-splats", "30000"]),
    "lego": ("tiny_lego", ["--max-splats", "20000"]),
}


def train(name: str, data: Path, runs: Path) -> dict:
    """Train through the command line, as a user would, and return the metrics."""
    folder, options = CAPTURES[name]
    output = runs / name
    command = [sys.executable, "-m", "mobilegs", "train", str(data / folder)]
    command += ["-o", str(output), "--preset", "cpu", "--resume", *options]
    if (data / "lpips").exists():
        command += ["--lpips-weights", str(data / "lpips")]
    subprocess.run(command, check=True)
    return json.loads((output / "metrics.json").read_text())


def demo(runs: Path) -> dict:
    """Run the demo in a folder of its own."""
    command = [sys.executable, "-m", "mobilegs", "demo", "--output", str(runs / "demo")]
    subprocess.run(command, check=True)
    return json.loads((runs / "demo" / "metrics.json").read_text())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--runs", type=Path, default=Path("runs"), help="where runs are kept")
    parser.add_argument("--only", nargs="+", default=[*CAPTURES, "demo"])
    options = parser.parse_args()
    data = os.environ.get("MOBILEGS_DATA")
    if not data:
        sys.exit("set MOBILEGS_DATA to the folder that holds bonsai, llff_horns and tiny_lego")
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "runs": {},
    }
    if options.json and options.json.exists():  # figures of runs not asked for again stay
        result["runs"] = json.loads(options.json.read_text())["runs"]
    for name in options.only:
        start = time.perf_counter()
        found = demo(options.runs) if name == "demo" else train(name, Path(data), options.runs)
        for who in ("teacher", "student"):
            found[who].pop("views")  # the means are enough here; metrics.json keeps each view's
        result["runs"][name] = {**found, "wall_seconds": round(time.perf_counter() - start)}
        if options.json:
            options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
