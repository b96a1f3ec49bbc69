"""The library's own threads: loops of several callers at once, and of forked processes."""

import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
import torch

from mobilegs.csrc import binding
from mobilegs.representation.codebooks import gather_entries

CENTERS = torch.randn(3, 16, 2, generator=torch.Generator().manual_seed(1))
INDICES = torch.randint(16, (10_000, 3), generator=torch.Generator().manual_seed(2)).short()
EXPECTED = gather_entries(CENTERS, INDICES)

FORK = """
import os, torch
from tests.csrc.test_parallel import gathers
torch.set_num_threads(4)
gathers()
child = os.fork()
gathers()
if not child:
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
print("ended")
"""


@pytest.fixture
def five_threads() -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(5)
    yield
    torch.set_num_threads(before)


def gathers() -> None:
    """Run a hundred loops of the library, and compare each result with the reference."""
    for _ in range(100):
        found = binding.gather_entries(CENTERS, INDICES)
        assert found is not None
        assert bytes(found.numpy()) == bytes(EXPECTED.numpy())  # torch's own threads hang there


def test_callers_at_once_get_their_own_results(five_threads: None) -> None:
    with ThreadPoolExecutor(8) as callers:
        for ended in [callers.submit(gathers) for _ in range(8)]:
            ended.result(timeout=60)


@pytest.mark.skipif(sys.platform == "win32", reason="needs fork")
def test_a_forked_process_has_threads_of_its_own() -> None:
    command = [sys.executable, "-W", "ignore", "-c", FORK]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.stdout == "ended\n", done.stderr


def test_threads_are_chosen_apart_from_those_of_torch(five_threads: None) -> None:
    library = binding.library()
    try:
        for number in (1, 2, 17, 3):
            library.mgs_use_threads(number)
            gathers()
    finally:
        library.mgs_use_threads(0)
