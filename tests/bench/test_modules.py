"""Every benchmark can be imported as the commands of its page run it."""

import importlib
from pathlib import Path

import pytest

import bench

FOLDER = Path(bench.__path__[0])
MODULES = sorted(
    ".".join(("bench", *path.relative_to(FOLDER).with_suffix("").parts))
    for path in FOLDER.rglob("*.py")
    if path.stem != "__init__"
)


@pytest.mark.parametrize("name", MODULES)
def test_a_benchmark_imports_and_says_how_it_is_run(name: str) -> None:
    module = importlib.import_module(name)
    assert module.__doc__
    if hasattr(module, "main"):
        assert f"python -m {name}" in module.__doc__
