"""The committed WebAssembly of the viewer against a rebuild from its C files."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.node import node_program

TESTS = Path(__file__).resolve().parents[1]
VIEWER = TESTS.parent / "viewer"
WASM = VIEWER / "wasm"
CONFORMANCE = TESTS / "mgs" / "conformance"
SCRIPTS = ("block_memory.test.js", "rans_wasm.test.js")


def compiler_of(kernels: Path) -> str:
    """The version of clang that the first line of a `kernels.js` names."""
    match = re.search(r"with clang ([\d.]+)", kernels.read_text())
    assert match, f"{kernels} does not name its compiler"
    return match[1]


def check_behaviour(kernels: Path, folder: Path) -> None:
    """Run the JavaScript tests of the kernels in a copy of the viewer with other kernels."""
    for part in ("src", "wasm"):
        shutil.copytree(VIEWER / part, folder / "viewer" / part)
    shutil.copytree(TESTS / "web", folder / "tests" / "web")
    shutil.copytree(CONFORMANCE, folder / "tests" / "mgs" / "conformance")
    (folder / "package.json").write_text('{"type": "module"}')
    shutil.copy(kernels, folder / "viewer" / "wasm")
    scripts = [folder / "tests" / "web" / name for name in SCRIPTS]
    command = [node_program(), "--test", *map(str, scripts)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "pass 0\n" not in done.stdout


def test_a_rebuild_gives_the_committed_kernels(tmp_path: Path) -> None:
    """Compilers of the same version build the same bytes; others build kernels that do the same."""
    for program in ("clang", "wasm-ld"):
        if shutil.which(program) is None:
            pytest.skip(f"needs {program} (viewer/wasm/README.md)")
    subprocess.run([WASM / "build.sh", tmp_path], check=True, timeout=120)
    committed, built = WASM / "kernels.js", tmp_path / "kernels.js"
    if compiler_of(built) == compiler_of(committed):
        message = "kernels.js is out of date: run viewer/wasm/build.sh"
        assert built.read_bytes() == committed.read_bytes(), message
    else:
        check_behaviour(built, tmp_path / "copy")


def test_the_kernels_have_no_data_segments() -> None:
    """Data segments would overwrite what JavaScript puts into the memory."""
    digits = re.search(r'"([0-9a-f]+)"', (WASM / "kernels.js").read_text())
    assert digits
    module = bytes.fromhex(digits[1])
    assert module[:8] == b"\0asm\1\0\0\0"
    sections, at = [], 8
    while at < len(module):
        sections.append(module[at])
        size = shift = 0
        at += 1
        while True:
            size |= (module[at] & 127) << shift
            shift += 7
            at += 1
            if module[at - 1] < 128:
                break
        at += size
    assert at == len(module)
    data = 11
    assert data not in sections
