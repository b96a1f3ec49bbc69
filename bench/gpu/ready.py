"""Says what the agenda of bench/gpu/run.sh lacks on this machine; the exit code is 1 if anything.

python bench/gpu/ready.py
"""

import importlib.util
import sys

MODULES = (
    "torch", "numpy", "scipy", "PIL", "safetensors", "tyro", "rich", "jaxtyping", "cuda.core",
    "cuda.bindings", "pytest", "pytest_timeout", "hypothesis", "beartype",
)  # fmt: skip


def lacks(name: str) -> bool:
    """Whether a module is not there."""
    try:
        return importlib.util.find_spec(name) is None
    except ImportError:  # nor what it is in
        return True


def main() -> None:
    missing = [name for name in MODULES if lacks(name)]
    if missing:
        sys.exit(
            f"{sys.executable} has no {', '.join(missing)}: PYTHON=... names another one, "
            "or bring wheels (bench/gpu/README.md)"
        )
    import torch

    if not torch.cuda.is_available():
        sys.exit(f"this machine offers {sys.executable} no CUDA device")


if __name__ == "__main__":
    main()
