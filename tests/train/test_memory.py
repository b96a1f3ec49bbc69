"""The memory of a training: what is reckoned, and what is free."""

import platform
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from mobilegs.train import memory
from mobilegs.train.memory import (
    BYTES_PER_PIXEL,
    BYTES_PER_SPLAT,
    CACHE_RATIO,
    PHOTO_BYTES,
    TARGET_BYTES,
    free_memory,
    needed_memory,
)
from mobilegs.train.student.config import LossConfig, StudentConfig

GIB = 1 << 30


def test_memory_grows_with_gaussians_pixels_and_photos_up_to_the_caches() -> None:
    config = StudentConfig(cache_mib=1024)

    def needed(photos: int = 300, pixels: int = 100_000, splats: int = 1000) -> int:
        return needed_memory(config, photos=photos, pixels=pixels, splats=splats)

    assert needed(splats=2000) - needed() == 1000 * BYTES_PER_SPLAT
    images = 300 * (PHOTO_BYTES + 2 * TARGET_BYTES // 4)  # two virtual views of half the size
    assert needed(pixels=200_000) - needed() == 100_000 * (BYTES_PER_PIXEL + CACHE_RATIO * images)
    many = needed(photos=1_000_000)
    assert many == needed(photos=2_000_000) and many - needed() < CACHE_RATIO * 3 * GIB
    assert (
        many
        - needed_memory(replace(config, cache_mib=0), photos=1_000_000, pixels=100_000, splats=1000)
        == CACHE_RATIO * GIB
    )


def test_without_virtual_views_the_teacher_s_images_are_those_of_the_photos() -> None:
    virtual = StudentConfig()
    photos = replace(virtual, loss=LossConfig(virtual_view_every=0))
    given = {"photos": 150, "pixels": 10_000, "splats": 0}
    difference = needed_memory(photos, **given) - needed_memory(virtual, **given)
    assert difference == CACHE_RATIO * 150 * 10_000 * (TARGET_BYTES - 2 * TARGET_BYTES // 4)


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


def test_few_photos_have_many_virtual_views() -> None:
    without = StudentConfig(cache_mib=0)
    given = {"photos": 30, "pixels": 10_000, "splats": 0}
    images = needed_memory(StudentConfig(), **given) - needed_memory(without, **given)
    assert images == CACHE_RATIO * 300 * TARGET_BYTES * 10_000 // 4


FAULTS = """
import resource
import torch
from mobilegs.train.memory import keep_freed_memory
print(keep_freed_memory())
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
    command = [sys.executable, "-c", FAULTS]
    found = subprocess.run(command, check=True, capture_output=True, text=True)
    told, faults = found.stdout.split()
    assert told == "True"
    assert int(faults) < 100  # of 640 with huge pages, and 327,680 with small ones
