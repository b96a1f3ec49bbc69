"""The report of a run."""

import json
import re
import shutil
from pathlib import Path

import pytest

from mobilegs.errors import InputError
from mobilegs.train.run_dir import RunDir
from mobilegs.view.report import write_report
from tests.support.browser import Tab
from tests.support.viewer_page import SETTLED

CHART = r'<svg [^>]*role="img">'


@pytest.fixture
def run(finished: Path, tmp_path: Path) -> RunDir:
    shutil.copytree(finished, tmp_path / "run")
    return RunDir(tmp_path / "run")


@pytest.mark.thorough
def test_a_report_has_figures_curves_photos_and_settings(run: RunDir) -> None:
    page = write_report(run).read_text()
    metrics = run.load_metrics()
    student = metrics["student"]
    for text in (f"{student['psnr']:.2f}", f"{student['cc_psnr']:.2f}", f"{student['ssim']:.3f}"):
        assert f"<td>{text}</td>" in page
    for view in student["views"]:
        assert view["name"] in page
    assert len(re.findall(CHART, page)) == 2 and page.count("<polyline") == 4
    assert "&quot;recipe&quot;" in page
    without_script = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert "http" not in without_script.replace("http-equiv", "")
    for points in re.findall(r'points="([^"]+)"', page):
        numbers = [float(number) for pair in points.split() for number in pair.split(",")]
        assert all(0 <= number <= 460 for number in numbers)


def test_names_of_photos_are_text_and_not_markup(run: RunDir) -> None:
    metrics = run.load_metrics()
    metrics["student"]["views"][0]["name"] = "<script>alert(1)</script>.png"
    run.metrics.write_text(json.dumps(metrics))
    page = write_report(run).read_text()
    assert "<script>alert" not in page and "&lt;script&gt;alert(1)" in page


def test_a_report_needs_no_log_and_names_a_damaged_file(run: RunDir) -> None:
    run.log.unlink()
    assert not re.search(CHART, write_report(run).read_text())
    run.log.write_text("{")
    with pytest.raises(InputError, match=r"metrics\.jsonl is damaged"):
        write_report(run)
    run.log.unlink()
    run.contact_sheet.write_bytes(b"")
    with pytest.raises(InputError, match=r"contact_sheet\.png is damaged"):
        write_report(run)


def test_a_report_shows_the_scene_without_a_network(tab: Tab, run: RunDir) -> None:
    asked: list[str] = []
    tab.page.on("request", lambda request: asked.append(request.url))
    tab.page.goto(f"{write_report(run).as_uri()}?scale=1&variant=floats")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert all(url.startswith(("file:", "blob:", "data:")) for url in asked), asked
    box = tab.page.locator("mobile-gs").bounding_box()
    assert box is not None and box["height"] > 100
