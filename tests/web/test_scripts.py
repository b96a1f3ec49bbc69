"""The JavaScript's own unit tests, by node's runner."""

import subprocess
from pathlib import Path

import pytest

from tests.support.node import node_program

SCRIPTS = sorted(Path(__file__).parent.glob("*.test.js"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_the_javascript_tests_pass(script: Path) -> None:
    command = [node_program(), "--test", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "pass 0\n" not in done.stdout
