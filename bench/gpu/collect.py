"""Puts together what bench/gpu/run.sh left in a folder: one JSON with date, device and all figures.

python bench/gpu/collect.py FOLDER --json OUT
"""

import argparse
import json
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import torch

from mobilegs.atomic import atomic_write


def tests_of(path: Path) -> dict | None:
    """Counts of pytest's report, and the names of what failed."""
    if not path.exists():
        return None
    suite = ElementTree.parse(path).getroot().find("testsuite")
    if suite is None:
        return None
    counts = {name: int(suite.get(name, 0)) for name in ("tests", "failures", "errors", "skipped")}
    failed = [
        case.get("name")
        for case in suite.iter("testcase")
        if case.find("failure") is not None or case.find("error") is not None
    ]
    return {**counts, "failed": failed}


def parts_of(path: Path) -> list[dict]:
    """Name, exit code and seconds of each part, again for each call, from lines of run.sh."""
    if not path.exists():
        return []
    rows = [line.split() for line in path.read_text().splitlines()]
    return [{"name": name, "exit": int(code), "seconds": int(s)} for name, code, s in rows]


def figures_of(path: Path) -> dict | None:
    return json.loads(path.read_text()) if path.exists() else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--json", type=Path, required=True)
    options = parser.parse_args()
    properties = torch.cuda.get_device_properties(0)
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "device": properties.name,
        "capability": f"{properties.major}.{properties.minor}",
        "memory_gib": round(properties.total_memory / 2**30, 1),
        "torch": torch.__version__,
        "cuda": torch.version.cuda,
        "parts": parts_of(options.folder / "logs" / "parts.txt"),
        "tests": tests_of(options.folder / "tests.xml"),
        "kernels": figures_of(options.folder / "kernels.json"),
        "bonsai": figures_of(options.folder / "scene" / "bonsai" / "metrics.json"),
        "frames": figures_of(options.folder / "frames.json"),
        "native": figures_of(options.folder / "native.json"),
        "travelled": figures_of(options.folder / "travelled.json"),
    }
    atomic_write(options.json, json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
