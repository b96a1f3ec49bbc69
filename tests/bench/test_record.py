"""The frame of the benchmarks: rows that stay, their origin, and tables in pages."""

import json
from pathlib import Path

import pytest

from bench.record import RESULTS, ROOT, Figures, filled, origin_of, table

# whose rows come from runs of other kinds
OTHERS = {"paper", "antialiased", "gpu_h100", "gpu_h200"}


def test_rows_of_an_earlier_run_stay(tmp_path: Path) -> None:
    path = tmp_path / "figures.json"
    Figures(path, torch="2").add("a", ms=1)
    again = Figures(path, torch="2")
    again.add("a", gsplat_ms=2)
    again.add("b", ms=3)
    content = json.loads(path.read_text())
    assert content["torch"] == "2" and list(content["rows"]) == ["a", "b"]
    row = content["rows"]["a"]
    assert (row["ms"], row["gsplat_ms"]) == (1, 2) and row["date"] and row["machine"]


def test_a_table_stands_between_its_markers() -> None:
    page = "x <!-- BEGIN:a --> old <!-- END:a --> y"
    content = table("name | ms", [["b", "3"]])
    assert content == "| name | ms |\n|---|---|\n| b | 3 |"
    assert filled(page, "a", content) == f"x <!-- BEGIN:a -->\n\n{content}\n\n<!-- END:a --> y"
    with pytest.raises(ValueError, match="'b'"):
        filled(page, "b", content)


@pytest.mark.parametrize("path", sorted(RESULTS.glob("*.json")), ids=lambda path: path.stem)
def test_every_result_names_its_origin_and_belongs_to_a_page(path: Path) -> None:
    content = json.loads(path.read_text())
    if path.stem in OTHERS:
        assert path.stem == "paper" or content["commit"]
    else:
        assert all(word in origin_of(content["rows"]) for word in ("2026", "cores", " at "))
    writers = [ROOT / "bench/readme.py", ROOT / "bench/paper/report.py"]
    texts = [page.read_text() for page in [*writers, *(ROOT / "docs").rglob("*.md")]]
    names = (f'"{path.stem}"', path.name)
    assert any(name in text for text in texts for name in names)
