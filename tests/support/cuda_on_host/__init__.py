"""Emulate the CUDA kernels on a CPU: a host compiler builds cuda.cu, threads run as fibers."""

import ctypes
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import torch

import mobilegs.render.kernels.cuda as cuda
from mobilegs.render.kernels.list_lengths import ListLengths

HERE = Path(__file__).parent
# fibers need ucontext, as Linux has it
COMPILER = (shutil.which("g++") or shutil.which("c++")) if sys.platform == "linux" else None


class HostLength:
    """The length of a list, which counts as known once `late` questions have been asked."""

    def __init__(self, length: torch.Tensor, late: int) -> None:
        self.number = ctypes.c_int64.from_address(length.data_ptr()).value
        self.late = late

    def known(self) -> bool:
        self.late -= 1
        return self.late < 0

    def value(self) -> int:
        return self.number


class HostKernels(cuda.Kernels):
    """Emulated kernels, in the place of `cuda.Kernels`, for tensors in main memory."""

    def __init__(self, folder: Path) -> None:
        built = folder / "cuda_on_host.so"
        flags = "-std=c++20 -O2 -fno-math-errno -fPIC -shared -U_FORTIFY_SOURCE -Wall -Wextra"
        flags += " -Wno-unknown-pragmas"
        source = [f"-I{HERE}", f"-I{cuda.CSRC}", "-x", "c++", str(HERE / "emulate.cpp")]
        with _alone(folder):
            if not built.exists():
                part = built.with_suffix(".part")
                command = [str(COMPILER), *flags.split(), *source, "-o", str(part)]
                subprocess.run(command, check=True)
                part.rename(built)
        self.library = ctypes.CDLL(str(built))
        self.library.launch.restype = ctypes.c_char_p
        self.launched: list[str] = []
        self.forget()

    def forget(self) -> None:
        """Forget the lengths of earlier lists and the names of kernels that were launched."""
        self.lengths, self.late = ListLengths(), 0
        self.launched.clear()

    def read_later(self, length: torch.Tensor) -> HostLength:
        return HostLength(length, self.late)

    @contextmanager
    def current(self) -> Iterator[None]:
        yield

    def launch(self, name: str, blocks: int, threads: int, *arguments) -> None:
        addresses = cuda.argument_addresses(arguments)
        problem = self.library.launch(name.encode(), blocks, threads, addresses).decode()
        assert not problem, f"{name}: {problem}"
        self.launched.append(name)

    def reverse(self, reversed_turns: bool) -> None:
        """Run the threads of a block last to first, or first to last again."""
        self.library.set_reversed(int(reversed_turns))


@pytest.fixture(scope="session")
def host_kernels(tmp_path_factory: pytest.TempPathFactory) -> HostKernels:
    """The emulated kernels."""
    if COMPILER is None:
        pytest.skip("needs Linux and a C++ compiler")
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID")
    if run is None:
        return HostKernels(tmp_path_factory.mktemp("cuda_on_host"))
    folder = tmp_path_factory.getbasetemp().parent / f"cuda_on_host-{run}"  # of all processes
    folder.mkdir(exist_ok=True)
    return HostKernels(folder)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Let other processes that build in the folder wait."""
    import fcntl

    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.fixture
def on_host(host_kernels: HostKernels, monkeypatch: pytest.MonkeyPatch) -> Iterator[HostKernels]:
    """Take float32 tensors as those of a GPU, with the emulated kernels.

    Memory that is not written holds NaN or huge numbers.
    """
    monkeypatch.setattr(cuda, "takes", lambda *ts: all(t.dtype == torch.float32 for t in ts))
    monkeypatch.setattr(cuda, "kernels_for", lambda tensor: host_kernels)
    torch.use_deterministic_algorithms(True)
    host_kernels.forget()
    yield host_kernels
    host_kernels.reverse(False)
    torch.use_deterministic_algorithms(False)
