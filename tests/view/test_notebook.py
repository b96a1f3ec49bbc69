"""Scenes as outputs of a notebook's cells."""

import html
import re
from dataclasses import replace
from pathlib import Path

import pytest

from mobilegs.formats.ply import write_ply
from mobilegs.mgs.codec import decode_mgs
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene
from mobilegs.view import notebook
from mobilegs.view.export import export_html, title_of
from tests.support.browser import Chromium, polled
from tests.support.tiny import blobs
from tests.support.viewer_page import MGS, SETTLED


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scene.mgs"
    path.write_bytes(MGS)
    return path


def page_in(output: str) -> str:
    match = re.fullmatch(r'<iframe srcdoc="([^"]*)" [^>]*></iframe>', output)
    assert match, output[:200]
    return html.unescape(match[1])


def test_a_scene_shows_the_page_that_is_exported(file: Path, tmp_path: Path) -> None:
    export_html(file, tmp_path / "page.html", title=title_of(file))
    page = (tmp_path / "page.html").read_text("utf-8")
    assert page_in(open_scene(file)._repr_html_()) == page
    assert page_in(decode_mgs(MGS)._repr_html_()) == page


def test_a_plain_scene_shows_its_gaussians_as_they_are_now(tmp_path: Path) -> None:
    path = tmp_path / "scene.ply"
    write_ply(path, blobs().select(slice(0, 7)))
    scene = open_scene(path)
    export_html(path, tmp_path / "page.html", title="scene")
    assert page_in(scene._repr_html_()) == (tmp_path / "page.html").read_text("utf-8")
    scene.gaussians.means[:] += 1
    assert page_in(scene._repr_html_()) != (tmp_path / "page.html").read_text("utf-8")
    page_in(Scene(blobs())._repr_html_())


def test_a_sentence_takes_the_place_of_a_page(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    changed = replace(open_scene(file), near=0.3)
    assert changed.file is None  # the file holds another scene
    assert changed._repr_html_() == (
        "<p>a sort-free scene shows itself if open_scene has read it from a file</p>"
    )
    monkeypatch.setattr(notebook, "MEGABYTES_MAX", 0)
    assert "a notebook shows up to 0 MB" in open_scene(file)._repr_html_()


def test_the_frame_shows_the_scene_in_a_browser(chromium: Chromium, file: Path) -> None:
    tab = chromium.tab()
    tab.page.set_content(f"<!doctype html>{open_scene(file)._repr_html_()}")
    frame = tab.page.frames[1]
    assert polled(frame, SETTLED, timeout=60_000).json_value() == "loaded"
    tab.page.close()
