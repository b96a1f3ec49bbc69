"""Fuzz the Python readers with atheris: `python -m tests.fuzz.guided`, see README.md."""

import random
import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(  # pyright: ignore[reportAttributeAccessIssue]
    include=["mobilegs.mgs", "mobilegs.compress", "mobilegs.formats"]
):
    from tests.fuzz.campaign import SEEDS
    from tests.fuzz.mutate import Mutator
    from tests.fuzz.readers import Reader, quiet
    from tests.support.mgs_parts import parse_parts

SECONDS = 1.0


def main() -> None:
    kind, folder, *options = sys.argv[1:]
    quiet()
    corpus = Path(folder)
    corpus.mkdir(parents=True, exist_ok=True)
    seeds = SEEDS[kind]()
    for i, seed in enumerate(seeds.values()):
        (corpus / f"seed-{i}").write_bytes(seed.data)
    mutator = Mutator(kind, seeds, seed=0)
    reader = Reader(kind, Path(tempfile.mkdtemp()) / f"input.{kind}", SECONDS)

    def change(data: bytes, most: int, seed: int) -> bytes:
        r = random.Random(seed)
        try:
            if kind == "mgs" and r.random() < 0.5:  # mutate a stream with libFuzzer
                parts = parse_parts(data)
                piece = r.choice(parts.pieces)
                piece.data = bytes(atheris.Mutate(piece.data, len(piece.data) + 64))
                return parts.to_bytes()[:most]
            return mutator.make(r, data, mutator.files)[:most]
        except Exception:  # not a file that can be parsed
            return bytes(atheris.Mutate(data, most))

    def one(data: bytes) -> None:
        found = reader.verdict(data, decode=len(data) % 20 == 0)
        if isinstance(found, dict):
            raise AssertionError(found["error"])

    command = [sys.argv[0], folder, "-max_len=30000", "-rss_limit_mb=1024", *options]
    atheris.Setup(command, one, custom_mutator=change)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
