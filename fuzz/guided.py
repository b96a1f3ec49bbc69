"""Fuzz a Python reader with atheris, which follows code coverage: `python -m fuzz.guided`.

    python -m fuzz.guided KIND FOLDER [options of libFuzzer]

FOLDER gets the corpus (`corpus`) and the findings (`findings`). A finding does not end the process.
"""

import random
import resource
import sys
import tempfile
from pathlib import Path

import atheris  # pyright: ignore[reportMissingImports]

# the loader of an editable installation passes atheris by: the sources lie in this folder anyway
sys.meta_path[:] = [
    each
    for each in sys.meta_path
    if "Editable" not in type(each).__name__ and "Redirecting" not in type(each).__name__
]
with atheris.instrument_imports(  # pyright: ignore[reportAttributeAccessIssue]
    include=["mobilegs", "PIL"]  # top-level packages: names of modules in them match nothing
):
    from fuzz import captures
    from fuzz.findings import Findings
    from fuzz.inputs import short_seeds
    from fuzz.mutate import mutated
    from fuzz.readers import FREE, quiet
    from tests.support.mgs_parts import parse_parts

SECONDS = 1.0
EVERY = 5  # one of this many scenes is decoded completely
LONGEST = 30_000  # bytes


class Mutator:
    """Changes inputs: half of the time with knowledge of the format, else as libFuzzer does."""

    def __init__(self, kind: str) -> None:
        self.kind, self.files = kind, short_seeds(kind)

    def __call__(self, data: bytes, most: int, seed: int) -> bytes:
        r = random.Random(seed)
        if r.random() < 0.5:
            return mutated(self.kind, r, data, self.files)[:most]
        if self.kind == "mgs" and r.random() < 0.7:  # a stream, under a valid checksum
            try:
                parts = parse_parts(data)
                piece = r.choice(parts.pieces)
                piece.data = bytes(atheris.Mutate(piece.data, len(piece.data) + 64))
                return parts.to_bytes()[:most]
            except Exception:  # not a file that can be taken apart
                pass
        return bytes(atheris.Mutate(data, most))


def main() -> None:
    kind, folder, *options = sys.argv[1:]
    quiet()
    reader = captures.reader_of(kind, Path(tempfile.mkdtemp()), SECONDS)
    findings = Findings(kind, Path(folder) / "findings")
    peak = 0

    def one(data: bytes) -> None:
        nonlocal peak
        _, found = reader.verdict(data, decode=len(data) % EVERY == 0)
        if isinstance(found, dict):
            findings.add(data, found)
        # the most memory so far: only an input that needs more than all before it is measured
        highest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss << 10
        if highest > peak + FREE:
            error = reader.too_much(data, decode=len(data) % EVERY == 0)
            if peak and isinstance(error, dict):
                findings.add(data, error)
            peak = highest

    command = [sys.argv[0], f"-max_len={LONGEST}", "-rss_limit_mb=2048", "-timeout=60", *options]
    atheris.Setup(command, one, custom_mutator=Mutator(kind))
    atheris.Fuzz()


if __name__ == "__main__":
    main()
