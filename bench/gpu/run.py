"""Check, time and train on an NVIDIA GPU; give the same command again to run the missing parts.

    python -m bench.gpu.run --out runs/gpu [--minutes 60] [--parts tests kernels ...]

Needs a CUDA device and `pip install '.[cuda,dev]'`. Every part runs in a process of its
own. A part that succeeded is not repeated. OUT/result.json is written after every part, with the
date and the device. See README.md in this folder for the parts.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.record import Figures, commit
from mobilegs.atomic import atomic_write

INSTALL = "run `pip install '.[cuda,dev]'`"
GRACE_SECONDS = 60  # in which a stopped training writes its checkpoint
TESTS = (
    "tests/render/test_cuda.py",
    "tests/train/test_cuda_losses_on_host.py",
    "tests/train/student/test_program_on_gpu.py",
)
# in this order: the pair that decides what order independence costs comes first
PAPER_ROWS = ("release", "release-sorted", "ours", "ours-sorted")
PAPER_SCENES = ("bonsai-800", "south-1208")


@dataclass(frozen=True)
class Part:
    """A command that runs in its own process."""

    name: str
    words: tuple[str, ...]
    """The words after `python` on the command line."""
    needs: tuple[Path, ...] = ()
    """Files or folders without which the part is left out."""


def module_words(name: str, *words: object) -> tuple[str, ...]:
    """Return the words that run a module."""
    return ("-m", name, *(str(word) for word in words))


def parts_of(out: Path, data: Path | None, minutes: float) -> list[Part]:
    """All parts in their order. `data` holds the captures; without it there is nothing to train.

    The training takes `minutes`.
    """
    capture = (data or Path("MOBILEGS_DATA")) / "bonsai"
    scene, teacher = out / "bonsai" / "scene.mgs", out / "bonsai" / "teacher.ply"
    files = ("--mgs", scene, "--ply", teacher)
    frames = (*files, "--capture", capture, "--json", out / "frames.json")
    kernels = ("--json", out / "kernels.json")
    tests = ("-m", "gpu", "-q", "-W", "default", f"--junitxml={out / 'tests.xml'}")
    on_gpu = ("--device", "cuda")
    length = ("--minutes", minutes, *on_gpu)
    paper = (
        "--scenes",
        *PAPER_SCENES,
        "--rows",
        *PAPER_ROWS,
        "--runs",
        out / "paper",
        "--data",
        data,
    )
    trained = (scene, teacher)
    return [
        Part("tests", module_words("pytest", *tests, *TESTS)),
        Part("kernels", module_words("bench.gpu.kernels", *kernels)),
        Part("kernels-gsplat", module_words("bench.gpu.kernels", *kernels, "--by", "gsplat")),
        Part(
            "train",
            module_words("mobilegs", "train", capture, "-o", scene.parent, "--resume", *length),
            (capture,),
        ),
        Part(
            "steps",
            module_words("bench.steps", capture, teacher, "--json", out / "steps.json", *on_gpu),
            (capture, teacher),
        ),
        Part("frames", module_words("bench.gpu.frames", *frames), (capture, *trained)),
        Part(
            "frames-gsplat",
            module_words("bench.gpu.frames", *frames, "--by", "gsplat"),
            (capture, *trained),
        ),
        Part(
            "paper",
            module_words("bench.paper.run", *paper, "--json", out / "paper.json"),
            (capture,),
        ),
    ]


def run_part(part: Part, log: Path, seconds: float | None) -> int:
    """Run a part for at most `seconds`, print and log its output, and return its exit code.

    A part whose time is up is interrupted, so that a training writes its checkpoint.
    """
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("ab") as file:
        process = subprocess.Popen([sys.executable, *part.words], stdout=file, stderr=file)
        try:
            return process.wait(seconds)
        except (subprocess.TimeoutExpired, KeyboardInterrupt) as error:
            process.terminate()  # programs in the background may ignore SIGINT
            try:
                code = process.wait(GRACE_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                code = process.wait()
            if isinstance(error, KeyboardInterrupt):
                raise
            return code or 1


def run_parts(parts: Sequence[Part], out: Path, minutes: float | None) -> list[str]:
    """Run what is missing until the time is up; return the names of parts that are not done."""
    runs = Figures(out / "parts.json")
    ends = math.inf if minutes is None else time.monotonic() + 60 * minutes
    missing = []
    for part in parts:
        if runs.rows.get(part.name, {}).get("exit") == 0:
            continue
        absent = [str(path) for path in part.needs if not path.exists()]
        left = ends - time.monotonic()
        if absent or left <= 0:
            reason = f"{absent[0]} is missing" if absent else "the time is up"
            print(f"{part.name}: not run, {reason}", flush=True)
            missing.append(part.name)
            continue
        log = out / "logs" / f"{part.name}.log"
        print(f"{part.name}: running, output in {log}", flush=True)
        started = time.monotonic()
        code = run_part(part, log, None if left == math.inf else left)
        runs.add(part.name, exit=code, seconds=round(time.monotonic() - started))
        print(f"{part.name}: {'done' if code == 0 else f'exit code {code}'}", flush=True)
        if code:
            missing.append(part.name)
        write_result(out, runs.rows)
    write_result(out, runs.rows)
    return missing


def write_result(out: Path, runs: dict[str, Any]) -> None:
    """Write OUT/result.json: device, date, parts, and the figures that are there."""
    files = {
        "kernels": "kernels.json",
        "bonsai": "bonsai/metrics.json",
        "frames": "frames.json",
        "steps": "steps.json",
    }
    found = {name: read_json(out / file) for name, file in files.items()}
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "commit": commit(),
        **device(),
        "parts": runs,
        "tests": test_counts(out / "tests.xml"),
        **{name: value for name, value in found.items() if value is not None},
    }
    atomic_write(out / "result.json", json.dumps(result, indent=1) + "\n")


def read_json(path: Path) -> Any:
    """Return a file's contents, None if there is no such file."""
    return json.loads(path.read_text()) if path.exists() else None


def test_counts(path: Path) -> dict[str, Any] | None:
    """Return the counts of pytest's report and the names of tests that failed."""
    suite = ElementTree.parse(path).getroot().find("testsuite") if path.exists() else None
    if suite is None:
        return None
    counts = {name: int(suite.get(name, 0)) for name in ("tests", "failures", "errors", "skipped")}
    failed = [
        case.get("name")
        for case in suite.iter("testcase")
        if case.find("failure") is not None or case.find("error") is not None
    ]
    return {**counts, "failed": failed}


def device() -> dict[str, Any]:
    """Return the GPU's name, capability and memory, and the versions that matter."""
    import torch

    properties = torch.cuda.get_device_properties(0)
    return {
        "device": properties.name,
        "capability": f"{properties.major}.{properties.minor}",
        "memory_gib": round(properties.total_memory / 2**30, 1),
        "torch": torch.__version__,
        "cuda": torch.version.cuda,
    }


def require_gpu() -> None:
    """Exit with one sentence and code 2 where the kernels cannot be compiled or run."""
    problem = None
    try:
        import cuda.bindings.nvrtc
        import cuda.core
        import torch

        cuda.bindings.nvrtc.nvrtcVersion()
        if not torch.cuda.is_available():
            problem = "torch finds no CUDA device on this machine"
    except (ImportError, RuntimeError) as error:  # a package, or the library behind it
        problem = f"the compiler of the kernels is missing ({error}): {INSTALL}"
    if problem:
        print(problem, file=sys.stderr)
        sys.exit(2)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("runs/gpu"), help="folder for everything")
    parser.add_argument("--data", type=Path, default=os.environ.get("MOBILEGS_DATA"))
    parser.add_argument("--minutes", type=float, help="start no part after this time")
    parser.add_argument("--train-minutes", type=float, default=10, help="of the training")
    parser.add_argument("--parts", nargs="+", help="only these; default: all but paper")
    options = parser.parse_args()
    data = None if options.data is None else Path(options.data)
    parts = parts_of(options.out, data, options.train_minutes)
    names = options.parts or [part.name for part in parts if part.name != "paper"]
    unknown = set(names) - {part.name for part in parts}
    if unknown:
        parser.error(f"no part is called {', '.join(sorted(unknown))}")
    require_gpu()
    options.out.mkdir(parents=True, exist_ok=True)
    wanted = [part for part in parts if part.name in names]
    missing = run_parts(wanted, options.out, options.minutes)
    print(f"{options.out / 'result.json'} has the figures", flush=True)
    if missing:
        sys.exit(f"not done: {', '.join(missing)}; give the same command again")


if __name__ == "__main__":
    main()
