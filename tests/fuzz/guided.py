"""Our readers under atheris, which goes on from inputs that reach new code: see README.md."""

import random
import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["mobilegs.compress", "mobilegs.formats"]):
    from tests.fuzz.campaign import SEEDS
    from tests.fuzz.envelope import take_apart
    from tests.fuzz.mutate import Mutator
    from tests.fuzz.readers import Reader, quiet

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
            if kind == "mgs" and r.random() < 0.5:  # a stream, in libFuzzer's own ways
                parts = take_apart(data)
                piece = r.choice(parts.pieces)
                piece.data = bytes(atheris.Mutate(piece.data, len(piece.data) + 64))
                return parts.sealed()[:most]
            return mutator.make(r, data, mutator.files)[:most]
        except Exception:  # no file that could be taken apart
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
