"""Keep the inputs that reach new code: `python -m fuzz.minimise [TARGET ...]`.

It runs after `python -m fuzz`. Of the inputs that a target has found, the smallest that reach code
which neither the valid files nor smaller inputs reach are written to `fuzz/corpus/TARGET`, up to
`INPUTS_MAX` and `BYTES_MAX`.
"""

import argparse
import contextlib
import hashlib
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from types import FrameType
from typing import Any

from fuzz import captures, compiled, javascript
from fuzz.__main__ import HERE, TARGETS, corpus, write_seeds
from fuzz.seeds import SEEDS
from tests.fuzz.readers import Reader, quiet

INPUTS_MAX, BYTES_MAX = 60, 16_000  # of the kept inputs of a target
INPUT_MAX = 4_000  # bytes of one input
OURS = str(HERE.parent / "mobilegs")

Reach = Callable[[bytes], bool]  # runs an input: does it reach code that none before did?


def traced(kind: str, folder: Path) -> Reach:
    """Return a function that tells whether an input reaches new steps from line to line."""
    if kind in captures.KINDS:
        reader: Reader = captures.CaptureReader(kind, folder, 60)
    else:
        reader = Reader(kind, folder / f"input.{kind}", 60)
    reached: set[tuple[str, int, int]] = set()

    def follow(frame: FrameType, event: str, argument: Any) -> Any:
        name = frame.f_code.co_filename
        if not name.startswith(OURS):
            return None
        before = 0

        def line(frame: FrameType, event: str, argument: Any) -> Any:
            nonlocal before
            if event == "line":
                reached.add((name, before, frame.f_lineno))
                before = frame.f_lineno
            return line

        return line

    def reach(data: bytes) -> bool:
        size = len(reached)
        sys.settrace(follow)
        try:
            reader.opened(data, decode=True)
        finally:
            sys.settrace(None)
        return len(reached) > size

    return reach


def smallest(inputs: Iterable[bytes]) -> list[bytes]:
    """Return different inputs that are short enough, the shortest first."""
    found = {data for data in inputs if 0 < len(data) <= INPUT_MAX}
    return sorted(found, key=lambda data: (len(data), data))


def kept(target: str, found: list[bytes]) -> list[bytes]:
    """Return the inputs of a target to keep."""
    language, _, kind = target.partition("-")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if language == "cpp":
            return _merged(target, found, folder)
        seeds = [seed.data for seed in SEEDS[kind]().values()]
        if language == "python":
            reach = traced(kind, folder)
            for data in seeds:
                reach(data)
            return [data for data in smallest(found) if reach(data)]
        with contextlib.closing(javascript.Viewer(kind, folder)) as viewer:
            inputs = [*seeds, *smallest(found)]
            novel, _, _ = viewer(inputs)
            return [inputs[i] for i in novel if i >= len(seeds)]


def _merged(target: str, found: list[bytes], folder: Path) -> list[bytes]:
    """Do the same with libFuzzer, which merges a folder into one that has the valid files."""
    kind = target.partition("-")[2]
    write_seeds(target, folder / "merged")
    seeds = {path.name for path in (folder / "merged").iterdir()}
    (folder / "found").mkdir()
    for number, data in enumerate(found):
        (folder / "found" / f"{number}").write_bytes(data)
    command = [compiled.build(kind, folder), "-merge=1", folder / "merged", folder / "found"]
    subprocess.run(command, check=True, capture_output=True)
    new = [path for path in (folder / "merged").iterdir() if path.name not in seeds]
    return smallest(path.read_bytes() for path in new)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m fuzz.minimise", description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET")
    parser.add_argument("--output", type=Path, default=Path("build") / "fuzz")
    given = parser.parse_args()
    quiet()
    warnings.simplefilter("ignore")
    # `agreement` reads the corpora of all targets of `.mgs`
    for target in given.targets or [name for name in TARGETS if name != "agreement"]:
        found = [path.read_bytes() for path in sorted((given.output / target / "corpus").iterdir())]
        named = [path for path in _files(target) if not path.name.startswith("auto-")]
        spent, folder = 0, HERE / "corpus" / target
        chosen = kept(target, [*found, *corpus(target)])
        for path in _files(target):
            if path not in named:
                path.unlink()
        folder.mkdir(parents=True, exist_ok=True)
        there = {path.read_bytes() for path in named}
        for data in [data for data in chosen if data not in there][:INPUTS_MAX]:
            if spent + len(data) > BYTES_MAX:
                break
            spent += len(data)
            (folder / f"auto-{hashlib.sha1(data).hexdigest()[:12]}").write_bytes(data)
        print(f"{target}: {len(chosen)} of {len(found)} inputs, {spent:,} bytes", flush=True)


def _files(target: str) -> list[Path]:
    folder = HERE / "corpus" / target
    return sorted(folder.iterdir()) if folder.is_dir() else []


if __name__ == "__main__":
    main()
