"""A batch on a Ray cluster of two nodes, one of which is killed."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROWS = 3
# a dead node is noticed after two seconds, not fifteen
HEALTH = {"RAY_health_check_period_ms": "500"}


@pytest.mark.thorough
@pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="needs Ray (the extra batch)")
@pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")
def test_all_rows_are_made_with_the_same_bytes_although_a_node_dies(tmp_path: Path) -> None:
    """Runs the benchmark on small captures: it makes the scenes by single commands, too."""
    command = [sys.executable, "-m", "bench.batch", "--rows", str(ROWS), "--nodes", "2"]
    command += ["--steps", "300", "--size", "48", "32", "--json", str(tmp_path / "found.json")]
    done = subprocess.run(
        [*command, "--folder", str(tmp_path / "work")],
        cwd=Path(__file__).parents[2],
        env=os.environ | HEALTH,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["exit_code"] == 0, done.stdout
    assert found["done"] == found["same_bytes"] == ROWS
    killed = found["killed"]
    assert killed is not None, done.stdout
    assert found["tries"][killed["row"]] == 3  # two trainings and an export
    assert f"{killed['row']}: training was lost (its machine" in done.stdout
