"""Run a long fuzzing campaign: `python -m tests.fuzz.campaign`, see README.md."""

import argparse
import faulthandler
import json
import os
import re
import select
import struct
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from tests.fuzz.mutate import Mutator
from tests.fuzz.readers import EVERY, Verdict, quiet, verdicts
from tests.fuzz.seeds import Seed, mgs_seeds, ply_seeds, spz_seeds
from tests.fuzz.seeds_formats import compressed_seeds, glb_seeds, sog_seeds, splat_seeds
from tests.support.mgs_parts import parse_parts
from tests.support.node import node_program

SEEDS = {
    "mgs": mgs_seeds,
    "ply": ply_seeds,
    "spz": spz_seeds,
    "compressed": compressed_seeds,
    "splat": splat_seeds,
    "sog": sog_seeds,
    "glb": glb_seeds,
}
THERE = ("mgs", "ply", "spz")  # what the viewer reads
BATCH = 500
SECONDS = 1.0  # processor time allowed per input
PATIENCE = 300  # seconds for a batch
CUT_MAX = 30_000  # largest file that is cut at every byte
# messages of the viewer about scenes that only Python opens
ONLY_THERE = re.compile(r"has sh_degree '[023]'|has the weighting 'two_pass'")


class Node:
    """A process that runs readers.js; inputs are passed in a file in `folder`."""

    def __init__(self, folder: Path, *, seconds: float) -> None:
        self.batch, self.seconds = folder / "batch", seconds
        self.process: subprocess.Popen[str] | None = None

    def verdicts(self, kind: str, inputs: list[bytes]) -> list[Verdict]:
        """Return verdicts like `readers.verdicts`."""
        if self.process is None:
            script = Path(__file__).with_name("readers.js")
            pipe = subprocess.PIPE
            command = [node_program(), "--max-old-space-size=512", script]
            self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)
        stdin, stdout = self.process.stdin, self.process.stdout
        assert stdin is not None and stdout is not None
        self.batch.write_bytes(b"".join(struct.pack("<I", len(data)) + data for data in inputs))
        asked = {"kind": kind, "path": str(self.batch), "every": EVERY, "seconds": self.seconds}
        stdin.write(json.dumps(asked) + "\n")
        stdin.flush()
        if select.select([stdout], [], [], PATIENCE)[0]:
            answer = stdout.readline()
            if answer:
                return json.loads(answer)
        self.close()
        return [{"error": "node ended, or did not answer"}] * len(inputs)

    def close(self) -> None:
        """End the process; the next batch starts another one."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None


def cuts(kind: str, seeds: dict[str, Seed]) -> Iterator[bytes]:
    """Yield files cut at every byte; of a `.mgs` also cut streams with valid checksums."""
    for seed in seeds.values():
        if len(seed.data) > CUT_MAX:
            continue
        for end in range(len(seed.data)):
            yield seed.data[:end]
        if kind != "mgs":
            continue
        for i, piece in enumerate(parse_parts(seed.data).pieces):
            ends = range(len(piece.data))
            for end in ends if len(ends) < 300 else [*ends[:100], *ends[-100:]]:
                parts = parse_parts(seed.data)
                parts.pieces[i].data = piece.data[:end]
                yield parts.to_bytes()


def run(kind: str, inputs: Iterator[bytes], node: Node, folder: Path, title: str) -> None:
    """Run all inputs; findings go to `folder`, counts to the standard output."""
    counts: Counter[str] = Counter()
    begun, first = time.time(), 0
    while batch := list(islice(inputs, BATCH)):
        faulthandler.dump_traceback_later(PATIENCE, exit=True)
        ours = verdicts(kind, batch, folder, seconds=SECONDS)
        faulthandler.cancel_dump_traceback_later()
        theirs = node.verdicts(kind, batch) if kind in THERE else ours
        for i, (data, our, their) in enumerate(zip(batch, ours, theirs, strict=True)):
            for found in _findings(kind, our, their):
                counts[found[:60]] += 1
                _keep(folder, f"{title}-{first + i}", data, found)
            counts["scenes" if our is None else "refusals"] += 1
            if kind in THERE:
                counts["scenes in node" if their is None else "refusals in node"] += 1
        first += len(batch)
        if first % (20 * BATCH) == 0:
            print(f"{title} {first} {time.time() - begun:.0f} s {json.dumps(counts)}", flush=True)
    print(f"{title}: all {first}, {time.time() - begun:.0f} s, {json.dumps(counts)}", flush=True)


def _findings(kind: str, ours: Verdict, theirs: Verdict) -> Iterator[str]:
    both = (("python", ours), ("node", theirs)) if kind in THERE else (("python", ours),)
    for reader, found in both:
        if isinstance(found, dict):
            yield f"{reader}: {found['error']}"
    if kind == "mgs" and not isinstance(ours, dict) and not isinstance(theirs, dict):
        known = ours is None and theirs is not None and ONLY_THERE.search(theirs)
        if (ours is None) != (theirs is None) and not known:
            yield f"differ: python '{ours}', node '{theirs}'"


def _keep(folder: Path, name: str, data: bytes, found: str) -> None:
    with (folder / "findings.txt").open("a") as log:
        log.write(f"{name}\t{len(data)}\t{found[:1000]!r}\n")
    kept = folder / "findings"
    kept.mkdir(exist_ok=True)
    if sum(1 for _ in kept.iterdir()) < 2000:
        (kept / name).write_bytes(data)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="+", choices=SEEDS)
    parser.add_argument("--count", type=int, default=1_000_000, help="mutated inputs of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first")
    parser.add_argument("--cuts", action="store_true", help="also cut every file at every byte")
    parser.add_argument("--output", type=Path, default=Path(tempfile.gettempdir()) / "fuzz-mgs")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    quiet()
    os.nice(10)
    node = Node(options.output, seconds=SECONDS)
    for kind in options.kinds:
        seeds = SEEDS[kind]()
        mutator = Mutator(kind, seeds, options.seed)
        numbers = range(options.first, options.first + options.count)
        if options.cuts:
            run(kind, cuts(kind, seeds), node, options.output, f"{kind} cuts")
        title = f"{kind} seed {options.seed} from {options.first}"
        run(kind, map(mutator.input, numbers), node, options.output, title)
    node.close()


if __name__ == "__main__":
    main()
