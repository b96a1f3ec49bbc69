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
from functools import partial
from pathlib import Path
from typing import Any

from fuzz.findings import Failure, Findings
from fuzz.inputs import VIEWER_KINDS, seeds, short_seeds
from fuzz.mutate import mutated
from tests.support.node import node_program

READERS = Path(__file__).parent / "js" / "readers.js"
BATCH = 100
EVERY = 5  # one of this many scenes is decoded completely, or read in pieces
SECONDS = 2.0  # processor time allowed per input

# the outcome of a batch: numbers of the inputs that reached new code, blocks reached so far, and an
# error for each input, or None
Ran = tuple[list[int], int, Sequence[Failure | None]]
Run = Callable[[list[bytes]], Ran]


class Viewer:
    """The viewer's readers in a process of Node.js, to which files in `folder` pass the inputs.

    `options` are those of `js/readers.js`.
    """

    def __init__(self, folder: Path, *options: str, seconds: float = SECONDS) -> None:
        self.batch, self.seconds = folder / "-".join(["batch", *options]), seconds
        command = [node_program(), "--max-old-space-size=512", READERS, *options]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)

    def ask(self, kind: str, inputs: list[bytes], **more: object) -> Any:
        """Return `{verdicts, novel, blocks}`; RuntimeError if the process has ended."""
        stdin, stdout = self.process.stdin, self.process.stdout
        assert stdin is not None and stdout is not None
        self.batch.write_bytes(b"".join(struct.pack("<I", len(data)) + data for data in inputs))
        asked = {"kind": kind, "path": str(self.batch), "every": EVERY, "seconds": self.seconds}
        stdin.write(json.dumps({**asked, **more}) + "\n")
        stdin.flush()
        answer = stdout.readline()
        if not answer:
            raise RuntimeError(f"Node.js ended with code {self.process.wait()}")
        return json.loads(answer)

    def run(self, kind: str, batch: list[bytes]) -> Ran:
        """Run the reader of one kind of file on a batch."""
        answer = self.ask(kind, batch)
        errors = [found if isinstance(found, dict) else None for found in answer["verdicts"]]
        return answer["novel"], answer["blocks"], errors

    def close(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.communicate()


def loop(
    kind: str, run: Run, findings: Findings, corpus: Path, *, seconds: float, seed: int = 1
) -> None:
    """Run seeds, corpus and mutations for some time; print the result as JSON."""
    files, short = list(seeds(kind).values()), short_seeds(kind)
    r, begun = random.Random(seed), time.time()
    corpus.mkdir(parents=True, exist_ok=True)
    kept = [path.read_bytes() for path in sorted(corpus.iterdir())]
    pool, batch, executions, before = kept + short, files + kept, 0, None
    while True:
        novel, blocks, errors = run(batch)
        executions += len(batch)
        for data, error in zip(batch, errors, strict=True):
            if error is not None:
                findings.add(data, error)
        if before is None:
            before = blocks
        else:
            for i in novel:
                pool.append(batch[i])
                (corpus / f"{executions:09d}-{i}").write_bytes(batch[i])
        if time.time() - begun >= seconds:
            break
        # recent members of the pool are chosen more often
        chosen = [max(r.randrange(len(pool)), r.randrange(len(pool))) for _ in range(BATCH)]
        batch = [mutated(kind, r, pool[i], files) for i in chosen]
    result = {"executions": executions, "before": before, "after": blocks}
    print(json.dumps({**result, "findings": len(findings.known)}))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=VIEWER_KINDS)
    parser.add_argument("folder", type=Path, help="gets the corpus and the findings")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    findings = Findings(f"javascript-{given.kind}", given.folder / "findings")
    limits = {"seconds": given.seconds, "seed": given.seed}
    with contextlib.closing(Viewer(given.folder, "--coverage")) as viewer:
        run = partial(viewer.run, given.kind)
        loop(given.kind, run, findings, given.folder / "corpus", **limits)


if __name__ == "__main__":
    main()
