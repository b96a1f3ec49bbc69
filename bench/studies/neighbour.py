"""Measure how much slower a training is beside a busy program.

    python -m bench.studies.neighbour [--json OUT] [--rounds 3]

A training of `llff_horns` at half size, 700 + 700 steps, runs alone and beside a program that keeps
one core busy: with the number of threads that it begins with (`fixed`), and with as many as there
are cores that other programs leave (`fair`, mobilegs/train/threads.py). OUT has the medians of the
seconds that metrics.json gives, and the number of different scenes. Nothing else may run.
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
FAIR = "import sys; from mobilegs.__main__ import run; sys.exit(run())"
FIXED = "from mobilegs.train.threads import FairThreads; FairThreads.adapt = lambda self: None; "
PROGRAMS = {"fixed": FIXED + FAIR, "fair": FAIR}


def train(capture: Path, output: Path, kind: str) -> dict:
    """Train once; return the seconds of both stages and the scene's digest."""
    command = [sys.executable, "-c", PROGRAMS[kind], "train", str(capture), "-o", str(output)]
    command += ["--preset", "cpu", "--steps", str(2 * STEPS), "--downscale", "2"]
    command += ["--max-splats", "30000", "--device", "cpu"]
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    seconds = json.loads((output / "metrics.json").read_text())["seconds"]
    digest = hashlib.sha256((output / "scene.mgs").read_bytes()).hexdigest()
    return {**{stage: seconds[stage] for stage in STAGES}, "digest": digest}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/neighbour.json")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    data = Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA"))
    rows: dict[str, dict[str, list[dict]]] = {kind: {"alone": [], "busy": []} for kind in PROGRAMS}
    with tempfile.TemporaryDirectory() as folder:
        for index in range(options.rounds):
            for kind in PROGRAMS:
                for beside in ("alone", "busy"):
                    other = None
                    if beside == "busy":
                        other = subprocess.Popen([sys.executable, "-c", BUSY])
                    try:
                        run = Path(folder) / f"{index}-{kind}-{beside}"
                        found = train(data / "llff_horns", run, kind)
                    finally:
                        if other:
                            other.kill()
                            other.wait()
                    rows[kind][beside].append(found)
                    print(kind, beside, found, flush=True)
    digests = {each["digest"] for row in rows.values() for runs in row.values() for each in runs}
    result = {
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "date": time.strftime("%Y-%m-%d"),
        "rounds": options.rounds,
        "steps": STEPS,
        "scenes": len(digests),
        "medians": {
            kind: {
                beside: {stage: statistics.median(r[stage] for r in runs) for stage in STAGES}
                for beside, runs in row.items()
            }
            for kind, row in rows.items()
        },
        "runs": rows,
    }
    atomic_write(options.json, json.dumps(result, indent=1) + "\n")
    print(json.dumps(result["medians"], indent=1), f"{len(digests)} different scenes")


if __name__ == "__main__":
    main()
