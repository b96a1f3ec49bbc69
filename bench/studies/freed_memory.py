"""Time a teacher's steps while the process keeps freed memory, and while it returns it.

    python -m bench.studies.freed_memory --teacher SCENE [--json OUT] [--steps 40] [--rounds 2]

SCENE is a plain 3DGS scene of bonsai, which the steps train further at 800x533. Every round is a
new process for each of both. Nothing else may run on the machine.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

import psutil
import torch

from mobilegs.atomic import atomic_write
from mobilegs.csrc.binding import kernel_level
from mobilegs.data import load_capture
from mobilegs.data.dataset import ViewLoader
from mobilegs.formats.ply import read_ply
from mobilegs.train.memory import keep_freed_memory
from mobilegs.train.recipes import cpu_recipe, with_settings
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.trainer import Teacher

ROOT = Path(__file__).parents[2]
WARM_UP = 5  # steps


def measure(scene: Path, steps: int, keep: bool) -> dict:
    """Train for a few steps; return milliseconds of a step, the loss and the memory."""
    if keep and not keep_freed_memory():
        sys.exit("the C library is not glibc")
    data = Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA"))
    dataset, gaussians = load_capture(data / "bonsai"), read_ply(scene)
    config = with_settings(
        replace(cpu_recipe(), teacher=replace(cpu_recipe().teacher, max_splats=len(gaussians))),
        ["teacher.first_divisor=1", "teacher.densify.strategy=fixed"],
    ).teacher
    stage = Teacher(config, dataset, seed=0, device=torch.device("cpu"), start=gaussians)
    with ViewLoader(dataset.train) as loader:
        order = view_order(len(loader), 0, WARM_UP + steps, 0)
        views = [(index, loader.get(index)) for index in order]
    for view in views[:WARM_UP]:
        stage.advance([view])
    started, loss = time.perf_counter(), 0.0
    for view in views[WARM_UP:]:
        loss += float(stage.advance([view]).loss)
    seconds = time.perf_counter() - started
    memory = psutil.Process().memory_info().rss >> 20
    return {"ms": 1000 * seconds / steps, "loss": loss, "mib": memory, "gaussians": len(gaussians)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--teacher", type=Path, required=True)
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/freed_memory.json")
    parser.add_argument("--steps", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--one", choices=("kept", "returned"), help="measure in this process")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.teacher, options.steps, options.one == "kept")))
        return
    rows: dict[str, list[dict]] = {"returned": [], "kept": []}
    for _ in range(options.rounds):
        for name, found in rows.items():
            command = [sys.executable, "-m", "bench.studies.freed_memory", "--one", name]
            command += ["--teacher", str(options.teacher), "--steps", str(options.steps)]
            output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
            found.append(json.loads(output.splitlines()[-1]))
            print(name, found[-1], flush=True)
    result = {
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "date": time.strftime("%Y-%m-%d"),
        "steps": options.steps,
        "same_losses": len({row["loss"] for found in rows.values() for row in found}) == 1,
        "ms": {name: median(row["ms"] for row in found) for name, found in rows.items()},
        "mib": {name: max(row["mib"] for row in found) for name, found in rows.items()},
        "runs": rows,
    }
    atomic_write(options.json, json.dumps(result, indent=1) + "\n")
    print(json.dumps({name: result[name] for name in ("ms", "mib", "same_losses")}))


if __name__ == "__main__":
    main()
