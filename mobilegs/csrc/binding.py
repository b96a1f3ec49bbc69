"""The C++ library: finds the build for this CPU and loads it with ctypes."""

import ctypes
import sysconfig
from functools import cache
from pathlib import Path

from torch import Tensor

# newest first: (name, flags of /proc/cpuinfo that it needs); as CMakeLists.txt builds them
LEVELS = {
    "v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "v3": {"avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"},
    "v2": {"sse4_2", "ssse3", "popcnt"},
    "portable": set(),
}


def cpu_flags() -> set[str]:
    """Return the CPU's instruction sets by their Linux names; empty where the system hides them."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return set()
    for line in text.splitlines():
        if line.startswith("flags"):
            return set(line.split(":", 1)[1].split())
    return set()


def built_library(level: str) -> Path | None:
    """Return the path of the library for `level`; an editable install keeps it in site-packages."""
    installed = Path(sysconfig.get_path("platlib"), "mobilegs", "csrc")
    for folder in (Path(__file__).parent, installed):
        if (folder / f"libmobilegs_{level}.so").exists():
            return folder / f"libmobilegs_{level}.so"
    return None


def kernel_level() -> str:
    """Return the newest built level that this CPU runs; raises ImportError if none was built."""
    flags = cpu_flags()
    for level, needed in LEVELS.items():
        if needed <= flags and built_library(level):
            return level
    raise ImportError(
        "mobilegs was installed without its CPU kernels: reinstall it where a C++ compiler is "
        "at hand (pip install --force-reinstall mobilegs)"
    )


@cache
def library(level: str | None = None) -> ctypes.CDLL:
    """Load the library for `level`; without it, for the newest level that this CPU runs."""
    level = level or kernel_level()
    path = built_library(level)
    if path is None:
        raise ImportError(f"the kernels of level {level} were not built on this machine")
    loaded = ctypes.CDLL(str(path))
    loaded.mgs_sorted_forward.restype = ctypes.c_void_p
    return loaded


def address(tensor: Tensor | None) -> ctypes.c_void_p:
    """Return the tensor's memory as a C pointer; None becomes a null pointer."""
    return ctypes.c_void_p(None if tensor is None else tensor.data_ptr())
