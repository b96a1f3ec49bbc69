"""Kill a training at random moments and compare its files with those of an undisturbed one.

    python -m bench.soak.training [--kills 100] [--seed 0] [--json OUT]

Each life of the process ends by SIGKILL after a random time, at most that of a whole run, and the
next one resumes. When a run is complete, another one begins, until the kills are used up. Every run
must leave the same scene.mgs and teacher.ply, to the byte, and no other files.
"""

import argparse
import hashlib
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.soak.record import add_record
from mobilegs.data.demo.capture import demo_capture, write_capture

COMPARED = ("scene.mgs", "teacher.ply")
STEPS = 400
SOONEST = 0.2  # seconds after which a process can be killed


class SoakError(Exception):
    """Something that must not happen did."""


@dataclass
class Training:
    """A training that is started again and again."""

    capture: Path
    steps: int = STEPS

    def command(self, run: Path) -> list[str]:
        """The command line that begins or resumes the run."""
        return [
            *(sys.executable, "-m", "mobilegs", "train", str(self.capture), "-o", str(run)),
            *("--preset", "demo", "--steps", str(self.steps), "--device", "cpu", "--resume"),
            *("--checkpoint-seconds", "0.3"),
        ]

    def complete(self, run: Path, *, within: float | None = None) -> bool:
        """Run until the end, or kill it `within` seconds; return whether it ended by itself.

        Raises SoakError if it ends with an error.
        """
        process = subprocess.Popen(
            self.command(run), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        )
        try:
            _, errors = process.communicate(timeout=within)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return False
        if process.returncode:
            raise SoakError(f"{run} ended with {process.returncode}: {errors.decode()[-2000:]}")
        return True


def place_of(run: Path) -> str:
    """Return the progress of a killed run, by the files that it left."""
    for name in ("metrics.json", "scene.mgs", "teacher.ply", "checkpoint.safetensors"):
        if (run / name).exists():
            return f"after {name}"
    return "before the first checkpoint"


def digests(run: Path) -> dict[str, str]:
    """The hashes of the files that must be the same."""
    return {name: hashlib.sha256((run / name).read_bytes()).hexdigest() for name in COMPARED}


@dataclass
class Tally:
    """Kills and completed runs so far."""

    kills: int = 0
    runs: int = 0
    places: Counter[str] = field(default_factory=Counter)


def soak(folder: Path, kills: int, seed: int, steps: int = STEPS) -> dict[str, Any]:
    """Kill a training `kills` times in FOLDER and return the tally as JSON data.

    Raises SoakError if a run ends with an error, or with other files than the undisturbed one.
    """
    rng = random.Random(seed)
    capture = folder / "capture"
    write_capture(capture, demo_capture(views=16, width=96, height=64, points=800))
    training = Training(capture, steps)
    started = time.monotonic()
    training.complete(folder / "whole")
    whole = time.monotonic() - started
    expected, files = digests(folder / "whole"), sorted(os.listdir(folder / "whole"))
    tally = Tally()
    while tally.kills < kills:
        run = folder / f"run-{tally.runs}"
        # the last kill used up: the run may end
        while not training.complete(
            run, within=rng.uniform(SOONEST, whole) if tally.kills < kills else None
        ):
            tally.kills += 1
            tally.places[place_of(run)] += 1
            print(f"kill {tally.kills}: {place_of(run)}", flush=True)
        tally.runs += 1
        if digests(run) != expected:
            raise SoakError(f"{run} differs from {folder / 'whole'}")
        if sorted(os.listdir(run)) != files:
            raise SoakError(f"{run} holds {sorted(os.listdir(run))}, not {files}")
    return {
        "kills": tally.kills,
        "runs": tally.runs,
        "killed": dict(tally.places),
        "seconds_of_a_run": round(whole, 1),
        "seed": seed,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = soak(Path(folder), options.kills, options.seed)
        except SoakError as error:
            sys.exit(str(error))
    print(json.dumps(found, indent=1))
    add_record(options.json, "training", found)


if __name__ == "__main__":
    main()
