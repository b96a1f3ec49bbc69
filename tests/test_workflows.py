"""Workflows pin actions to commits and build tools to hashes: only a commit changes a release."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PINNED = re.compile(r"[\w-]+/[\w/-]+@[0-9a-f]{40}  # v\d+\.\d+\.\d+")


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_actions_are_pinned_to_commits_and_may_only_read(path: Path) -> None:
    text = path.read_text("utf-8")
    used = re.findall(r"\buses: *(.*)", text)
    assert used and not [action for action in used if not PINNED.fullmatch(action)]
    assert "\npermissions:\n  contents: read\n\n" in text
    jobs = re.split(r"\n  (?=\w+:\n)", text.partition("\njobs:\n")[2])
    for job in jobs:  # a token to publish with, only where nothing is built
        assert "id-token: write" not in job or ("run: make" not in job and "npm ci" not in job)


def test_every_tool_that_builds_wheels_has_hashes() -> None:
    text = (ROOT / "tools" / "build_requirements.txt").read_text("utf-8")
    tools = re.findall(r"^([\w-]+)==\S+((?: \\\n    --hash=sha256:[0-9a-f]{64})+)$", text, re.M)
    assert {"cmake", "lief", "ninja", "scikit-build-core", "ziglang"} <= {name for name, _ in tools}
    assert len(tools) == len(re.findall("==", text))
    assert "--require-hashes -r tools/build_requirements.txt" in (ROOT / "Makefile").read_text(
        "utf-8"
    )
