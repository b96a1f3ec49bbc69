"""The benchmark of the paper's tables goes from a capture to its tables, and does nothing twice."""

import json
from collections.abc import Callable
from pathlib import Path

import paper
import paper_report
import pytest
from paper import PLACES, Place

SOME = ("teacher", "ours", "no-codes", "masks-votes", "two-pass")
Bench = Callable[..., dict[str, dict]]


@pytest.fixture
def bench(capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bench:
    """Runs the command on nine small photos; returns the cells by row and seed."""
    monkeypatch.setitem(PLACES, "blobs", Place("small", (capture.name,), 1, preset="cpu"))

    def run(*options: str) -> dict[str, dict]:
        out = tmp_path / "cells.json"
        folders = ("--data", str(capture.parent), "--runs", str(tmp_path / "runs"))
        words = ("paper.py", "--scenes", "blobs", "--steps", "20", "--json", str(out))
        monkeypatch.setattr("sys.argv", [*words, *folders, *options])
        paper.main()
        cells = json.loads(out.read_text())["cells"].values()
        return {f"{cell['row']} {cell['seed']}": cell for cell in cells}

    return run


def test_rows_become_cells_and_cells_a_table(bench: Bench, tmp_path: Path) -> None:
    cells = bench("--rows", *SOME)
    assert set(cells) == {f"{row} 0" for row in SOME}
    for cell in cells.values():
        assert cell["psnr"] > 10 and cell["gaussians"] > 50 and cell["frame_ms"] > 0
    [coded] = tmp_path.glob("runs/blobs/ours-*/scene.mgs")
    assert cells["ours 0"]["bytes"] == coded.stat().st_size < cells["no-codes 0"]["bytes"]

    written = {path: path.stat().st_mtime_ns for path in tmp_path.glob("runs/*/*/cell.json")}
    again = bench("--rows", "teacher", "ours", "--seeds", "0", "1")
    assert again == cells | {name: again[name] for name in ("teacher 1", "ours 1")}
    assert again["ours 1"]["teacher_seed"] == 0 and again["ours 1"] != cells["ours 0"]
    assert all(path.stat().st_mtime_ns == before for path, before in written.items())

    text = "\n".join(paper_report.sections(list(again.values())))
    assert "### blobs, 24x20, 10 + 10 steps" in text
    ours, two_pass = (cells[f"{name} 0"]["psnr"] for name in ("ours", "two-pass"))
    mean = (ours + again["ours 1"]["psnr"]) / 2
    assert f"| {two_pass:.2f} | {two_pass - mean:+.2f} |" in text
