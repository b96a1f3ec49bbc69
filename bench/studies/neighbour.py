"""Measure how much slower a training is beside a busy program, for several ways to wait.

    python -m bench.studies.neighbour [--json OUT] [--rounds 3] [--spins usual 300000 3000 0]

A training of `llff_horns` at half size, 700 + 700 steps, runs alone and beside a program that keeps
one core busy. Threads of OpenMP wait for each other by spinning, GOMP_SPINCOUNT times, and then
sleep; `usual` does not set it. OUT has the medians of the seconds that metrics.json gives, and the
number of different scenes. Nothing else may run.
"""

import argparse
import hashlib
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mobilegs.atomic import atomic_write
from mobilegs.csrc.binding import kernel_level

ROOT = Path(__file__).parents[2]
STEPS = 700
BUSY = "while True: pass"
STAGES = ("teacher", "student")


def train(capture: Path, output: Path, spin: str) -> dict:
    """Train once; return the seconds of both stages and the scene's digest."""
    environment = {key: value for key, value in os.environ.items() if key != "GOMP_SPINCOUNT"}
    if spin != "usual":
        environment["GOMP_SPINCOUNT"] = spin
    command = [sys.executable, "-m", "mobilegs", "train", str(capture), "-o", str(output)]
    command += ["--preset", "cpu", "--steps", str(2 * STEPS), "--downscale", "2"]
    command += ["--max-splats", "30000", "--device", "cpu"]
    subprocess.run(command, check=True, env=environment, stderr=subprocess.DEVNULL)
    seconds = json.loads((output / "metrics.json").read_text())["seconds"]
    digest = hashlib.sha256((output / "scene.mgs").read_bytes()).hexdigest()
    return {**{stage: seconds[stage] for stage in STAGES}, "digest": digest}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/neighbour.json")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--spins", nargs="+", default=["usual", "300000", "3000", "0"])
    options = parser.parse_args()
    data = Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA"))
    rows: dict[str, dict[str, list[dict]]] = {
        spin: {"alone": [], "busy": []} for spin in options.spins
    }
    with tempfile.TemporaryDirectory() as folder:
        for index in range(options.rounds):
            for spin in options.spins:
                for beside in ("alone", "busy"):
                    other = None
                    if beside == "busy":
                        other = subprocess.Popen([sys.executable, "-c", BUSY])
                    try:
                        run = Path(folder) / f"{index}-{spin}-{beside}"
                        found = train(data / "llff_horns", run, spin)
                    finally:
                        if other:
                            other.kill()
                            other.wait()
                    rows[spin][beside].append(found)
                    print(spin, beside, found, flush=True)
    digests = {each["digest"] for row in rows.values() for runs in row.values() for each in runs}
    result = {
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "date": time.strftime("%Y-%m-%d"),
        "rounds": options.rounds,
        "steps": STEPS,
        "scenes": len(digests),
        "medians": {
            spin: {
                beside: {stage: statistics.median(r[stage] for r in runs) for stage in STAGES}
                for beside, runs in row.items()
            }
            for spin, row in rows.items()
        },
        "runs": rows,
    }
    atomic_write(options.json, json.dumps(result, indent=1) + "\n")
    print(json.dumps(result["medians"], indent=1), f"{len(digests)} different scenes")


if __name__ == "__main__":
    main()
