"""Emulate the CUDA kernels on a CPU: a host compiler builds cuda.cu, threads run as fibers."""

import ctypes
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mobilegs.render.kernels.cuda as cuda

HERE = Path(__file__).parent
# fibers need ucontext, as Linux has it
COMPILER = (shutil.which("g++") or shutil.which("c++")) if sys.platform == "linux" else None


class HostKernels(cuda.Kernels):
    """Emulated kernels, in the place of `cuda.Kernels`, for tensors in main memory."""

    def __init__(self, folder: Path) -> None:
        built = folder / "cuda_on_host.so"
        flags = "-std=c++20 -O2 -fno-math-errno -fPIC -shared -U_FORTIFY_SOURCE -Wall -Wextra"
        flags += " -Wno-unknown-pragmas"
        source = [f"-I{HERE}", f"-I{cuda.CSRC}", "-x", "c++", str(HERE / "emulate.cpp")]
        subprocess.run([str(COMPILER), *flags.split(), *source, "-o", str(built)], check=True)
        self.library = ctypes.CDLL(str(built))
        self.library.launch.restype = ctypes.c_char_p
        self.launched: list[str] = []

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
