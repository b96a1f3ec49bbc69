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
from collections.abc import Callable, Iterable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from fuzz import captures, compiled
from fuzz.__main__ import TARGETS
from fuzz.inputs import CORPUS, HERE, corpus, files_in, kind_of, seeds, write
from fuzz.readers import quiet
from fuzz.viewer import Viewer

INPUTS_MAX, BYTES_MAX = 60, 16_000  # of the kept inputs of a target
INPUT_MAX = 4_000  # bytes of one input
OURS = str(HERE.parent / "mobilegs")


def traced(kind: str, folder: Path) -> Callable[[bytes], bool]:
    """Return a function that runs an input and tells whether it reaches new instructions."""
    reader = captures.reader_of(kind, folder, 60)
    reached: set[tuple[CodeType, int]] = set()

    def follow(frame: FrameType, event: str, argument: Any) -> Any:
        if not frame.f_code.co_filename.startswith(OURS):
            return None
        frame.f_trace_opcodes = True
        reached.add((frame.f_code, frame.f_lasti))
        return follow

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
        valid = list(seeds(kind).values())
        if language == "python":
            reach = traced(kind, folder)
            for data in valid:
                reach(data)
            return [data for data in smallest(found) if reach(data)]
        with contextlib.closing(Viewer(folder, "--coverage")) as viewer:
            inputs = [*valid, *smallest(found)]
            novel, _, _ = viewer.run(kind, inputs)
            return [inputs[i] for i in novel if i >= len(valid)]


def _merged(target: str, found: list[bytes], folder: Path) -> list[bytes]:
    """Do the same with libFuzzer, which merges a folder into one that has the valid files."""
    kind = kind_of(target)
    write(list(seeds(kind).values()), folder / "merged")
    write(found, folder / "found")
    valid = set(files_in(folder / "merged"))
    command = [compiled.build(kind, folder), "-merge=1", folder / "merged", folder / "found"]
    subprocess.run(command, check=True, capture_output=True)
    new = set(files_in(folder / "merged")) - valid
    return smallest(path.read_bytes() for path in new)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m fuzz.minimise", description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET")
    parser.add_argument("--output", type=Path, default=Path("build") / "fuzz")
    given = parser.parse_args()
    quiet()
    # `agreement` reads the corpora of all targets of `.mgs`
    for target in given.targets or [name for name in TARGETS if name != "agreement"]:
        found = [path.read_bytes() for path in files_in(given.output / target / "corpus")]
        spent, folder = 0, CORPUS / target
        chosen = kept(target, [*found, *corpus(target)])
        for path in files_in(folder):
            if path.name.startswith("auto-"):
                path.unlink()
        folder.mkdir(parents=True, exist_ok=True)
        there = set(corpus(target))
        for data in [data for data in chosen if data not in there][:INPUTS_MAX]:
            if spent + len(data) > BYTES_MAX:
                break
            spent += len(data)
            (folder / f"auto-{hashlib.sha1(data).hexdigest()[:12]}").write_bytes(data)
        print(f"{target}: {len(chosen)} of {len(found)} inputs, {spent:,} bytes", flush=True)


if __name__ == "__main__":
    main()
