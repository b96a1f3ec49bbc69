"""The frame of every benchmark: rows with date, machine and commit, and tables in pages."""

import json
import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mobilegs.atomic import atomic_write
from mobilegs.csrc.binding import kernel_build

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "bench/results"
DOCS = ROOT / "docs/explanation/benchmarks.md"
# of the builds of the kernels
INSTRUCTIONS = {"v4": "AVX-512", "v3": "AVX2", "v2": "SSE4.2", "portable": "no extensions"}


def machine() -> str:
    """Return the processor, its cores and the instructions that the kernels use."""
    listed = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    names = [line.partition(":")[2].strip() for line in listed.splitlines() if "model name" in line]
    name = names[0] if names else platform.machine()
    return f"{name}, {os.cpu_count()} cores, {INSTRUCTIONS[kernel_build()]}"


def commit() -> str:
    """Return the commit of the checkout, with `-dirty` after it if files differ from it.

    It is `unknown` where Git or the repository is missing.
    """
    if shutil.which("git") is None:
        return "unknown"
    command = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--exclude", "*"]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.stdout.strip() or "unknown"


def data_folder() -> Path:
    """Return the folder of the captures, which MOBILEGS_DATA names."""
    return Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA"))


class Figures:
    """Rows by name in a JSON file, which is written after every row.

    Rows of an earlier run stay, so that a script resumes. Each has its date, machine and commit.
    `about` is what all rows share.
    """

    def __init__(self, path: Path | None, **about: object) -> None:
        self.path = path
        found = json.loads(path.read_text()) if path is not None and path.exists() else {}
        self.rows: dict[str, dict[str, Any]] = found.get("rows", {})
        self.about = about

    def add(self, name: str, **values: object) -> None:
        """Add values to a row, print them, and write the file."""
        origin = {"date": time.strftime("%Y-%m-%d"), "machine": machine(), "commit": commit()}
        self.rows.setdefault(name, {}).update(values | origin)
        print(name, json.dumps(values), flush=True)
        if self.path is not None:
            content = {**self.about, "rows": self.rows}
            atomic_write(self.path, json.dumps(content, indent=1) + "\n")


def origin_of(rows: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the dates, machines and commits of rows, for the line above their table."""
    found = [dict.fromkeys(row[key] for row in rows.values()) for key in ("date", "machine")]
    commits = dict.fromkeys(row["commit"] for row in rows.values())
    return ", ".join([*(" and ".join(values) for values in found), f"at {' and '.join(commits)}"])


def table(head: str, rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table; `head` has its titles between ` | `."""
    lines = [f"| {head} |", "|---" * (head.count(" | ") + 1) + "|"]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def filled(page: str, name: str, content: str) -> str:
    """Return the page with `content` between two of its markers.

    The markers are `<!-- BEGIN:name -->` and `<!-- END:name -->`. Raises ValueError if the page
    lacks one of them.
    """
    begin, end = f"<!-- BEGIN:{name} -->", f"<!-- END:{name} -->"
    if begin not in page or end not in page:
        raise ValueError(f"the page has no markers '{name}'")
    head, _, rest = page.partition(begin)
    return f"{head}{begin}\n\n{content}\n\n{end}{rest.partition(end)[2]}"
