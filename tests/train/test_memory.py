"""The memory of a training: what is free, and that freed memory stays."""

import platform
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from mobilegs.train import memory
from mobilegs.train.memory import free_memory


def test_a_container_s_limit_counts_and_its_cached_files_do_not(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(memory, "CGROUP", tmp_path)
    free = psutil.virtual_memory().available
    assert free_memory() == pytest.approx(free, rel=0.2)  # no files
    (tmp_path / "memory.max").write_text("max\n")
    (tmp_path / "memory.current").write_text("1000\n")
    (tmp_path / "memory.stat").write_text("anon 900\ninactive_file 100\n")
    assert free_memory() == pytest.approx(free, rel=0.2)
    (tmp_path / "memory.max").write_text("5000\n")
    assert free_memory() == 5000 - 1000 + 100
    (tmp_path / "memory.current").write_text("9000\n")
    assert free_memory() == 0


FAULTS = """
import resource
import sys
import torch
from mobilegs.train.memory import keep_freed_memory
if "keep" in sys.argv:
    assert keep_freed_memory()
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(3):
    torch.zeros(64 << 18)
before = faults()
for _ in range(20):
    torch.zeros(64 << 18)  # 64 MiB
print(faults() - before)
"""


@pytest.mark.thorough
@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="needs glibc")
def test_freed_memory_is_not_fetched_again() -> None:
    def faults(*arguments: str) -> int:
        command = [sys.executable, "-c", FAULTS, *arguments]
        return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    # the kept block may grow once more: then a twentieth is left
    assert faults("keep") < faults() / 10
