"""Run the coverage-guided fuzzers: `python -m fuzz [TARGET ...] [--seconds 60]`, see README.md."""

import argparse
import importlib.util
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

from fuzz import captures, compiled
from fuzz.inputs import HERE, KINDS, VIEWER_KINDS, corpus, kind_of, seeds, write

TARGETS = {
    **{f"cpp-{kind}": "clang" for kind in compiled.KINDS},
    **{f"python-{kind}": "atheris" for kind in (*KINDS, *captures.KINDS)},
    **{f"javascript-{kind}": "node" for kind in VIEWER_KINDS},
    "agreement": "node",
}
HELP = {
    "clang": "clang++ is missing: apt-get install clang libclang-rt-dev",
    "atheris": "atheris is missing: .venv/bin/pip install atheris (Linux and macOS)",
}


def run(target: str, output: Path, seconds: int, seed: int) -> int:
    """Run one target, print a line and return the number of findings.

    Its log, corpus and findings are written to a folder in `output`. Coverage is in edges of C++
    and Python, in blocks of JavaScript.
    """
    folder = (output / target).resolve()
    findings = folder / "findings"
    findings.mkdir(parents=True, exist_ok=True)
    language, _, kind = target.partition("-")
    write(corpus(target), folder / "corpus")
    write(list(seeds(kind_of(target)).values()), folder / "seeds")
    options = [f"-max_total_time={seconds}", f"-seed={seed}", "-print_final_stats=1"]
    options.append(f"-artifact_prefix={findings}/")
    places = [folder / "corpus", folder / "seeds"]
    module = [sys.executable, "-m"]
    if language == "cpp":
        command = [compiled.build(kind, folder), *compiled.OPTIONS, *options, *places]
    elif language == "python":
        command = [*module, "fuzz.guided", kind, folder, *options, *places]
    else:
        limits = ["--seconds", str(seconds), "--seed", str(seed)]
        command = [*module, "fuzz.javascript", target, folder, *limits]
    # a large quarantine gives every input new memory, which would take most of the time
    environment = {**os.environ, "ASAN_OPTIONS": "quarantine_size_mb=8", "OMP_NUM_THREADS": "1"}
    begun = time.time()
    with (folder / "log").open("w") as log:
        done = subprocess.run(
            command, stdout=log, stderr=subprocess.STDOUT, cwd=HERE.parent, env=environment
        )
    text = (folder / "log").read_text(errors="replace")
    found = sum(path.name != "findings.txt" for path in findings.iterdir())
    if done.returncode and not found:  # it ended without an input to blame
        raise SystemExit(f"{target} failed, see {folder / 'log'}:\n{text[-2000:]}")
    if language in ("cpp", "python"):
        covered = [int(n) for n in re.findall(r"cov: (\d+)", text)] or [0]
        executions = re.search(r"number_of_executed_units: (\d+)", text)
        number, before, after = int(executions[1]) if executions else 0, covered[0], covered[-1]
    else:
        last = json.loads(text.strip().rpartition("\n")[2])
        number, before, after = last["executions"], last["before"], last["after"]
    took = max(1, round(time.time() - begun))
    print(
        f"{target:<18} {number:>9,} inputs in {took:>4} s ({number / took:>6,.0f}/s)  "
        f"coverage {before:>5} -> {after:>5}  findings {found}",
        flush=True,
    )
    return found


def missing(targets: list[str]) -> list[str]:
    """Return what has to be installed for these targets, one sentence each."""
    needed = {TARGETS[target] for target in targets}
    found = []
    if "clang" in needed and compiled.compiler() is None:
        found.append(HELP["clang"])
    if "atheris" in needed and importlib.util.find_spec("atheris") is None:
        found.append(HELP["atheris"])
    return found


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("--seconds", type=int, default=60, help="for each target")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=Path("build") / "fuzz")
    given = parser.parse_args()
    targets = given.targets or list(TARGETS)
    if unknown := [target for target in targets if target not in TARGETS]:
        parser.error(f"there is no target {unknown[0]}: use one of {', '.join(TARGETS)}")
    if sentences := missing(targets):
        print("\n".join(sentences), file=sys.stderr)
        return 2
    os.nice(max(0, 10 - os.nice(0)))
    found = sum(run(target, given.output, given.seconds, given.seed) for target in targets)
    if found:
        print(f"{found} findings: see the folders `findings` in {given.output}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
