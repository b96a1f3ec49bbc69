"""Fuzz the viewer's readers, or all decoders at once, in a loop that follows V8's code coverage.

Inputs that reach new blocks are kept and mutated further.
"""

import argparse
import contextlib
import json
import random
import time
from functools import partial
from pathlib import Path

import numpy as np

from fuzz.agreement import Agreement
from fuzz.findings import Findings
from fuzz.inputs import files_in, kind_of, seeds, short_seeds
from fuzz.mutate import mutated
from fuzz.readers import quiet
from fuzz.viewer import Run, Viewer

BATCH = 100


def loop(
    kind: str, run: Run, findings: Findings, corpus: Path, *, seconds: float, seed: int = 1
) -> None:
    """Run seeds, corpus and mutations for some time; print the result as JSON."""
    files, short = list(seeds(kind).values()), short_seeds(kind)
    r, begun = random.Random(seed), time.time()
    corpus.mkdir(parents=True, exist_ok=True)
    kept = [path.read_bytes() for path in files_in(corpus)]
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
    parser.add_argument("target")
    parser.add_argument("folder", type=Path, help="gets the corpus and the findings")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    quiet()
    np.seterr(all="ignore")  # the independent decoder meets numbers that overflow
    kind, findings = kind_of(given.target), Findings(given.target, given.folder / "findings")
    if given.target == "agreement":
        run = program = Agreement(given.folder)
    else:
        program = Viewer(given.folder, "--coverage")
        run = partial(program.run, kind)
    with contextlib.closing(program):
        limits = {"seconds": given.seconds, "seed": given.seed}
        loop(kind, run, findings, given.folder / "corpus", **limits)


if __name__ == "__main__":
    main()
