"""The JavaScript's own unit tests, by node's runner."""

import subprocess
from pathlib import Path

from tests.support.node import node_program

SCRIPTS = sorted(Path(__file__).parent.glob("*.test.js"))


def test_the_javascript_tests_pass() -> None:
    command = [node_program(), "--test", "--test-concurrency=2", *map(str, SCRIPTS)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(SCRIPTS) > 10 and "pass 0\n" not in done.stdout
