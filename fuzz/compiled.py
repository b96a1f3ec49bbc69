"""Build the libFuzzer targets of the C++ decoders with AddressSanitizer and UBSan."""

import platform
import shutil
import subprocess
from pathlib import Path

HERE = Path(__file__).parent
CSRC = HERE.parent / "mobilegs" / "csrc"
KINDS = ("decode", "networks")
SANITIZE = ["-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=undefined"]
# the library's lanes on a CPU with AVX2; others have 4, in portable code
LANES = ["-DLANES=8", "-march=x86-64-v3"] if platform.machine() == "x86_64" else ["-DLANES=4"]
# 557,056 positions are 3.2 MiB, and tables take 3 MiB; matrices of networks are smaller
OPTIONS = ["-malloc_limit_mb=4", "-rss_limit_mb=1024", "-timeout=20", "-max_len=20000"]


def sources(kind: str) -> list[Path]:
    """Return the files of C++ that a target and what it calls consist of."""
    return [HERE / "cpp" / f"{kind}.cpp", CSRC / "decode.cpp", CSRC / "parallel.cpp"]


def compiler() -> str | None:
    """Return the path of clang++, or None."""
    return shutil.which("clang++")


def build(kind: str, folder: Path) -> Path:
    """Compile a target into `folder` and return its path."""
    target = folder / kind
    flags = ["-std=c++17", "-O2", "-g", "-pthread", "-Wno-psabi", *LANES, *SANITIZE]
    subprocess.run([compiler() or "clang++", *flags, *sources(kind), "-o", target], check=True)
    return target
