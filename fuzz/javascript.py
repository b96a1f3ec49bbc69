"""Fuzz the viewer's readers in Node.js: a loop that follows the code coverage of V8.

Inputs that reach new blocks are kept and mutated further, with knowledge of the format. jazzer.js
would do this with libFuzzer, but its compiled part needs a newer C library than Debian 12 has, and
it takes no mutator of ours, without which wrong checksums end most inputs early.
"""

import argparse
import contextlib
import json
import random
import struct
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from fuzz.findings import Failure, Findings
from fuzz.seeds import SEEDS
from tests.fuzz.mutate import MAKERS
from tests.fuzz.mutate_plain import damaged
from tests.fuzz.seeds import Seed
from tests.support.node import node_program

KINDS = ("mgs", "ply", "spz")
READERS = Path(__file__).parents[1] / "tests" / "fuzz" / "readers.js"
BATCH = 100
EVERY = 5  # one of this many scenes is decoded completely, or read in pieces
SECONDS = 2.0  # processor time allowed per input

# what a batch gave: numbers of the inputs that reached new code, blocks reached so far, and an
# error for each input, or None
Ran = tuple[list[int], int, Sequence[Failure | None]]
Run = Callable[[list[bytes]], Ran]


class NodeProcess:
    """A program in Node.js that answers lines of JSON with lines of JSON."""

    def __init__(self, script: Path, *arguments: str) -> None:
        command = [node_program(), "--max-old-space-size=512", script, *arguments]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)

    def ask(self, **request: object) -> Any:
        """Return the answer; RuntimeError if the process has ended."""
        stdin, stdout = self.process.stdin, self.process.stdout
        assert stdin is not None and stdout is not None
        stdin.write(json.dumps(request) + "\n")
        stdin.flush()
        answer = stdout.readline()
        if not answer:
            raise RuntimeError(f"Node.js ended with code {self.process.wait()}")
        return json.loads(answer)

    def close(self) -> None:
        self.process.kill()
        self.process.communicate()


def write_rows(path: Path, inputs: list[bytes]) -> None:
    """Write inputs as rows of length and bytes."""
    path.write_bytes(b"".join(struct.pack("<I", len(data)) + data for data in inputs))


def mutated(kind: str, r: random.Random, pool: list[bytes], files: list[bytes]) -> bytes:
    """Return a changed member of the pool; recent members are chosen more often."""
    data = pool[max(r.randrange(len(pool)), r.randrange(len(pool)))]
    if r.random() < 0.9:
        try:
            return MAKERS[kind](r, data, files)
        except Exception:  # not a file that can be taken apart
            pass
    return damaged(r, data)


def loop(
    kind: str, run: Run, findings: Findings, corpus: Path, *, seconds: float, seed: int = 1
) -> None:
    """Run seeds, corpus and mutations for some time; print the result as JSON."""
    seeds: dict[str, Seed] = SEEDS[kind]()
    files = [each.data for each in seeds.values()]
    r, pool, begun = random.Random(seed), list(files), time.time()
    corpus.mkdir(parents=True, exist_ok=True)
    kept = [path.read_bytes() for path in sorted(corpus.iterdir())]
    executions = before = blocks = 0
    while executions == 0 or time.time() - begun < seconds:
        first = executions == 0
        batch = files + kept if first else [mutated(kind, r, pool, files) for _ in range(BATCH)]
        novel, blocks, errors = run(batch)
        executions += len(batch)
        for data, error in zip(batch, errors, strict=True):
            if error is not None:
                findings.add(data, error)
        if first:
            # large seeds have small weights: they are slow, and reach nothing that others do not
            before = blocks
            pool = kept + [each.data for each in seeds.values() for _ in range(round(each.weight))]
            continue
        for i in novel:
            pool.append(batch[i])
            (corpus / f"{executions:09d}-{i}").write_bytes(batch[i])
    print(
        json.dumps(
            {
                "executions": executions,
                "seconds": round(time.time() - begun),
                "before": before,
                "after": blocks,
                "findings": len(findings.known),
            }
        )
    )


class Viewer:
    """Runs the viewer's reader of one kind of file on batches."""

    def __init__(self, kind: str, folder: Path) -> None:
        self.kind, self.batch = kind, folder / "batch"
        self.process = NodeProcess(READERS)

    def __call__(self, batch: list[bytes]) -> Ran:
        write_rows(self.batch, batch)
        asked = {"kind": self.kind, "path": str(self.batch), "every": EVERY, "coverage": True}
        answer = self.process.ask(**asked, seconds=SECONDS)
        errors = [found if isinstance(found, dict) else None for found in answer["verdicts"]]
        return answer["novel"], answer["blocks"], errors

    def close(self) -> None:
        """End the process."""
        self.process.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("folder", type=Path, help="gets the corpus and the findings")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    findings = Findings(f"javascript-{given.kind}", given.folder / "findings")
    corpus = given.folder / "corpus"
    with contextlib.closing(Viewer(given.kind, given.folder)) as viewer:
        loop(given.kind, viewer, findings, corpus, seconds=given.seconds, seed=given.seed)


if __name__ == "__main__":
    main()
