"""Compare trainings of this version with those of the first one, in the same time.

    python -m bench.studies.first_version --program MOBILEGS [--json OUT] [--runs FOLDER]
                                          [--only bonsai-15 horns-15]
    python -m bench.studies.first_version --table [--json OUT]

MOBILEGS is the command of an installation of commit d7492bf of 2026-11-24, the last one before
budgets of time. There, a person chose photo size, Gaussians and steps; `BY_HAND` has such choices,
which take about the minutes on two cores. Each run resumes in FOLDER. Its file is compared with the
held-back photos as in bench/quality_per_minute.py, whose figures are this version's rows of the
table. Captures come from MOBILEGS_DATA. Nothing else may run on the machine.
"""

import argparse
import json
import os
import sys
from pathlib import Path
from typing import NamedTuple

from bench.pages import between
from bench.quality_per_minute import CAPTURES, DOCS, ROOT, RUN_HEAD, measure, run_values, timed
from mobilegs.atomic import atomic_write


class Choice(NamedTuple):
    """A person's choices for a run of the first version, and the run that it is compared with."""

    beside: str
    downscale: int
    max_splats: int
    steps: int


BY_HAND = {
    "bonsai-preset": Choice("bonsai-2", 2, 60_000, 10_000),  # the preset `cpu` as it was
    "bonsai-15": Choice("bonsai-15", 1, 90_000, 8000),
    "horns-15": Choice("horns-15", 1, 60_000, 12_000),
    "stitch-15": Choice("stitch-15", 1, 90_000, 8800),
    "bonsai-30": Choice("bonsai-30", 1, 160_000, 14_000),
}


def table(first: dict, now: dict) -> str:
    """Return the pairs of rows that are from one machine, as a Markdown table."""
    head = f"capture | version | {RUN_HEAD}"
    lines = [f"| {head} |", "|---|---" + "|---:" * RUN_HEAD.count("|") + "|---:|"]
    for key, found in first.items():
        beside = now[BY_HAND[key].beside]
        if beside["machine"] != found["machine"]:
            continue
        for version, row in (("first", found), ("now", beside)):
            values = [key.split("-")[0], version, *run_values(row)]
            lines.append("| " + " | ".join(values) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, help="the command of the first version")
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/first_version.json")
    parser.add_argument("--runs", type=Path, default=Path("runs/first"))
    parser.add_argument("--only", nargs="+", choices=BY_HAND, default=list(BY_HAND))
    parser.add_argument("--table", action="store_true", help="only write the table")
    options = parser.parse_args()
    rows = json.loads(options.json.read_text()) if options.json.exists() else {}
    if options.table:
        now = json.loads((ROOT / "bench/results/quality_per_minute.json").read_text())
        atomic_write(DOCS, between(DOCS.read_text(), "first_version", table(rows, now)))
        return
    data = Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA"))
    if options.program is None:
        parser.error("--program is missing")
    for key in options.only:
        if key in rows:
            continue
        choice, capture = BY_HAND[key], data / CAPTURES[key.split("-")[0]]
        run = options.runs / key
        command = [str(options.program), "train", str(capture), "-o", str(run), "--preset", "cpu"]
        command += ["--downscale", str(choice.downscale), "--max-splats", str(choice.max_splats)]
        command += ["--steps", str(choice.steps), "--device", "cpu", "--resume"]
        seconds = timed(command, run.with_suffix(".seconds.json"))
        metrics = json.loads((run / "metrics.json").read_text())
        rows[key] = {
            "taken": seconds / 60,
            "trained_at": metrics["image_size"],
            "max_splats": choice.max_splats,
            "steps": dict.fromkeys(("teacher", "student"), choice.steps // 2),
            **measure(run / "scene.mgs", capture, data),
        }
        atomic_write(options.json, json.dumps(rows, indent=1) + "\n")
        print(json.dumps({key: rows[key]}))


if __name__ == "__main__":
    main()
