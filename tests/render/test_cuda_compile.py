"""The CUDA kernels compile for two generations of GPUs without spilling registers; needs no GPU."""

import re
import sys

import pytest

from mobilegs.errors import InputError
from mobilegs.render.kernels import cuda
from tests.support.selection import few

ARCHITECTURES = ["sm_80", "sm_90"]
REPORT = re.compile(
    r"Compiling entry function '(\w+)'.*?"
    r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+) bytes spill loads.*?"
    r"Used (\d+) registers",
    re.DOTALL,
)
KERNELS = 48
# bytes of those that index arrays at run time, and of one that spills two registers
STACKS = {"mgs_student_decode": 1700, "mgs_student_update": 2800, "mgs_write_gradients": 8}
SPILLS = {"mgs_write_gradients": 8}


def resources(log: str) -> dict[str, dict[str, int]]:
    """Return bytes of stack and spills, and number of registers, by kernel."""
    found = {}
    for match in REPORT.finditer(log):
        name, *values = match.groups()
        keys = ("stack", "stores", "loads", "registers")
        found[name] = dict(zip(keys, map(int, values), strict=True))
    return found


def spilling(found: dict[str, dict[str, int]]) -> set[str]:
    """Return the kernels that use more local memory than is known, or spill registers."""
    return {
        name
        for name, of in found.items()
        if of["stack"] > STACKS.get(name, 0) or max(of["stores"], of["loads"]) > SPILLS.get(name, 0)
    }


@pytest.mark.parametrize("arch", few(ARCHITECTURES, "sm_80"))
def test_every_kernel_compiles_and_spills_little(arch):
    code, log = cuda.compile_kernels(arch)
    found = resources(log)
    for name, of in sorted(found.items()):
        print(f"{arch} {name:28s} {of['registers']:3d} registers")
    assert code[:4] == b"\x7fELF"
    assert len(found) == log.count("Compiling entry function") == KERNELS
    assert not spilling(found)
    assert "warning" not in log


def test_the_sources_use_no_atomics_but_to_count():
    folder, counting = cuda.CSRC, "void add_count(int* count, int many) { atomicAdd(count, many); }"
    for name in cuda.SOURCES:
        text = (folder / name).read_text().replace(counting, "")
        assert not re.search(r"atomic[A-Z]\w*\(|\bred\.|__reduce_add", text)


def test_compiled_kernels_are_kept_and_reused(tmp_path, monkeypatch):
    monkeypatch.setenv("MOBILEGS_CACHE", str(tmp_path / "new"))
    first = cuda.cubin("sm_90")
    (kept,) = (tmp_path / "new").iterdir()
    assert kept.read_bytes() == first and kept.suffix == ".cubin"
    monkeypatch.setattr(cuda, "compile_kernels", lambda arch: pytest.fail("compiled again"))
    assert cuda.cubin("sm_90") == first


def test_kernels_compile_without_a_writable_cache(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("MOBILEGS_CACHE", str(tmp_path / "file"))
    monkeypatch.setattr(cuda, "compile_kernels", lambda arch: (b"code", ""))
    assert cuda.cubin("sm_90") == b"code"


def test_an_unknown_gpu_architecture_is_refused():
    with pytest.raises(InputError, match="sm_61"):
        cuda.compile_kernels("sm_61")


@pytest.mark.parametrize(
    "call", [lambda: cuda.cubin("sm_90"), lambda: cuda.compile_kernels("sm_90")]
)
def test_a_missing_compiler_is_reported_with_the_command_to_install_it(call, monkeypatch):
    for name in ("cuda.core", "cuda.bindings"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(InputError, match=r"pip install 'mobilegs\[cuda\]'"):
        call()


def test_importing_the_renderers_does_not_import_cuda():
    for path in cuda.CSRC.parent.rglob("*.py"):
        assert not re.search(r"^(import|from) cuda\b", path.read_text(), re.MULTILINE), path
