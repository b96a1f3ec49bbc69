"""The page of a batch, in a browser."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

from mobilegs.batch.page import write_page
from mobilegs.batch.results import Entry
from tests.support.browser import Chromium

ENTRIES = [
    Entry("b10", "/c/b10", "capture", {}, "done", psnr=25.0, file_bytes=2_000_000, gaussians=900),
    Entry("b9", "/c/b9", "capture", {}, "done", psnr=31.5, file_bytes=900_000, gaussians=70_000),
    Entry("bad", "/c/bad", "photos", {}, "failed", "finding poses: <b>no</b> photo has a pose"),
    Entry("exact", "/c/exact", "scene", {}, "done", psnr=None, file_bytes=10_000_000),
    Entry("later", "/c/later", "capture", {}, "waiting"),
]
NAMES = "[...document.querySelectorAll('tbody tr .name')].map((e) => e.textContent)"


@pytest.fixture
def page(tmp_path: Path) -> Path:
    entries = []
    for each in ENTRIES:
        if each.state == "done":
            (tmp_path / each.name).mkdir()
            (tmp_path / each.name / "page.html").write_text("<title>scene</title>")
            Image.new("RGB", (80, 42), "teal").save(tmp_path / each.name / "poster.jpg")
            files = {"page": f"{each.name}/page.html", "poster": f"{each.name}/poster.jpg"}
            each = replace(each, seconds={"train": 60.0 * len(each.name)}, **files)
        entries.append(each)
    write_page(tmp_path / "index.html", entries, "3 of 5 done")
    return tmp_path / "index.html"


def test_the_page_sorts_by_every_column(chromium: Chromium, page: Path) -> None:
    opened = chromium.foreign()
    errors = []
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.goto(page.as_uri())
    assert opened.evaluate(NAMES) == ["b10", "b9", "bad", "exact", "later"]
    orders = {
        "Scene": [["b9", "b10", "bad", "exact", "later"], ["later", "exact", "bad", "b10", "b9"]],
        "MB": [["b9", "b10", "exact"], ["exact", "b10", "b9"]],
        "PSNR, dB": [["b9", "b10"], ["b10", "b9"]],
        "Gaussians": [["b9", "b10"], ["b10", "b9"]],
        "Minutes": [["b9", "b10", "exact"], ["exact", "b10", "b9"]],
    }
    for name, both in orders.items():
        for order in both:
            opened.get_by_role("button", name=name, exact=True).click()
            assert opened.evaluate(NAMES)[: len(order)] == order
            # rows without a figure come last in both directions
            rest = {entry.name for entry in ENTRIES} - set(order)
            assert set(opened.evaluate(NAMES)[len(order) :]) == rest
        sorted_by = opened.locator("th[aria-sort]")
        assert sorted_by.count() == 1 and sorted_by.inner_text().startswith(name)
    for width in (1200, 390):
        opened.set_viewport_size({"width": width, "height": 800})
        assert opened.evaluate("document.documentElement.scrollWidth") == width
    assert opened.get_by_role("row").count() == 1 + len(ENTRIES)
    assert opened.get_by_text("<b>no</b> photo has a pose").is_visible()
    pictures = "[...document.images].map((e) => e.naturalWidth)"
    opened.wait_for_function(f"{pictures}.every((width) => width === 80)")
    opened.get_by_role("link", name="b10").click()
    assert opened.title() == "scene" and not errors
    opened.close()


def test_the_page_has_totals_of_what_is_done(page: Path) -> None:
    text = page.read_text()
    for figure in ("<dd>3 of 5</dd>", "<dd>12.90</dd>", "<dd>28.25</dd>"):
        assert figure in text
    assert "http" not in text.replace("http-equiv", "")  # nothing is loaded from elsewhere
    assert json.dumps("/c/b10")[1:-1] in text
