"""Says what the agenda of bench/gpu/run.sh lacks on this machine; the exit code is 1 if anything.

python bench/gpu/ready.py
"""

import importlib.util
import re
import sys
import tomllib
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

MODULES = (
    "torch", "numpy", "scipy", "PIL", "safetensors", "tyro", "rich", "jaxtyping", "cuda.core",
    "cuda.bindings", "pytest", "pytest_timeout", "hypothesis", "beartype",
)  # fmt: skip
# of what draws on a GPU
NEEDED = {
    "cuda.core": ("Device", "ObjectCode", "Program", "ProgramOptions"),
    "cuda.bindings.driver": ("CUfunction", "CUstream", "cuLaunchKernel"),
}
ROOT = Path(__file__).parents[2]


def lacks(name: str) -> bool:
    """Whether a module is not there."""
    try:
        return importlib.util.find_spec(name) is None
    except ImportError:  # nor what it is in
        return True


def too_old() -> list[str]:
    """Packages that are older than pyproject.toml asks for, those for GPUs included."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found = []
    for asked in (*project["dependencies"], *project["optional-dependencies"]["cuda"]):
        name, _, least = asked.partition(">=")
        try:
            there = version(name)
        except PackageNotFoundError:  # whether its modules are there was asked before
            continue
        if numbers(there) < numbers(least):
            found.append(f"{name} {there}, not {least} or later")
    return found


def numbers(text: str) -> list[int]:
    """Those that a version begins with."""
    return [int(part) for part in re.split(r"[^\d.]", text)[0].split(".") if part]


def compiler_trouble() -> str | None:
    """What keeps mobilegs/render/kernels/cuda.py from compiling and starting its kernels."""
    try:
        for module, names in NEEDED.items():
            there = import_module(module)
            if absent := [name for name in names if not hasattr(there, name)]:
                return f"{module} has no {', '.join(absent)}"
        import_module("cuda.bindings.nvrtc").nvrtcVersion()
    except (ImportError, RuntimeError) as error:  # a module, or the library behind it
        return str(error)
    return None


def main() -> None:
    missing = [name for name in MODULES if lacks(name)]
    if missing:
        sys.exit(
            f"{sys.executable} has no {', '.join(missing)}: PYTHON=... names another one, "
            "or bring wheels (bench/gpu/README.md)"
        )
    if old := too_old():
        sys.exit(f"{sys.executable} has {'; '.join(old)}: run `pip install -U '.[cuda,dev]'`")
    if trouble := compiler_trouble():
        sys.exit(
            f"{sys.executable} cannot compile kernels ({trouble}): run `pip install '.[cuda]'`"
        )
    import torch

    if not torch.cuda.is_available():
        sys.exit(f"this machine offers {sys.executable} no CUDA device")


if __name__ == "__main__":
    main()
