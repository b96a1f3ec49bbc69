"""`mobilegs edit` and the same options of `mobilegs export`."""

import html
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.cli.main import main
from mobilegs.data.dataset import Dataset
from mobilegs.data.demo.capture import write_capture
from mobilegs.edit.scene_edit import kept_rows
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.mgs.codec import decode_mgs, read_mgs
from mobilegs.mgs.quantized_scene import QuantizedScene, scenes_equal
from mobilegs.viewpoints.framing import parsed_start
from tests.support.viewer_page import MGS

NOTES = [
    *["--title", "A garden", "--credit", "me"],
    *["--start-view", "1 2 3 0 0 0 0.4 0.3", "--start-portrait", "1,2,4,0,0,0"],
    *["--floor", "0 -2 0 1", "--no-limits"],
]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.mgs"
    path.write_bytes(MGS)
    return path


@pytest.fixture
def files(tmp_path: Path) -> list[str]:
    """Options with files: annotations and a camera path."""
    annotations = [{"at": [0, 0, 0], "text": "A tree\nwith <b>leaves</b>", "eye": [0, 0, -2]}]
    (tmp_path / "annotations.json").write_text(json.dumps(annotations))
    (tmp_path / "path.json").write_text(json.dumps([[0, 0, -3, 0, 0, 0], [1, 0, -3, 0, 0, 0]]))
    texts = [str(tmp_path / name) for name in ("annotations.json", "path.json")]
    return ["--annotations", texts[0], "--camera-path", texts[1]]


def cropped(whole: QuantizedScene) -> QuantizedScene:
    means = whole.decode().gaussians.means
    return kept_rows(whole, ((means >= -1) & (means <= 1)).all(1))


def assert_noted(edited: QuantizedScene, whole: QuantizedScene) -> None:
    notes = edited.meta
    assert (notes["title"], notes["credit"], notes["limits"]) == ("A garden", "me", "none")
    assert notes["start"] == "1 2 3 0 0 0 0.4 0.3" and notes["floor"] == "0 -1 0 0.5"
    portrait, view = parsed_start(notes["start_portrait"]), whole.views[0]
    assert portrait is not None and portrait.eye.tolist() == [1, 2, 4]
    field = min(view.width / float(view.K[0, 0]), view.height / float(view.K[1, 1])) / 2
    assert portrait.box == pytest.approx((field, field), rel=1e-4)
    assert json.loads(str(notes["annotations"]))[0]["text"] == "A tree\nwith <b>leaves</b>"
    assert notes["path"] == "0 0 -3 0 0 0;1 0 -3 0 0 0"
    kept = {name: value for name, value in notes.items() if name in whole.meta}
    assert kept == whole.meta


def test_edit_writes_a_copy_with_notes_and_fewer_gaussians(
    scene: Path, files: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["edit", str(scene), "--crop", "-1 -1 -1 1 1 1", *NOTES, *files]) == 0
    told = capsys.readouterr().out
    edited, whole = read_mgs(scene.with_name("scene-edited.mgs")), decode_mgs(MGS)
    assert_noted(edited, whole)
    expected = cropped(whole)
    assert 0 < len(expected) < len(whole)
    assert scenes_equal(replace(edited, meta=whole.meta), expected)
    assert f"{len(whole) - len(expected):,} removed: outside of the box" in told
    assert f"{len(MGS):,} bytes before" in told and "notes set: title, credit" in told
    assert scene.read_bytes() == MGS


def test_settings_survive_an_export(
    scene: Path, tmp_path: Path, files: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["export", str(scene), "--to", "site", "-o", str(tmp_path / "site")]
    assert main([*words, "--crop", "-1 -1 -1 1 1 1", *NOTES, *files]) == 0
    page = (tmp_path / "site" / "index.html").read_text("utf-8")
    data = (tmp_path / "site" / "scene.mgs").read_bytes()
    assert "<title>A garden</title>" in page
    edited, whole = decode_mgs(data), decode_mgs(MGS)
    assert_noted(edited, whole)
    assert scenes_equal(replace(edited, meta=whole.meta), cropped(whole))
    assert scene.read_bytes() == MGS
    # an edited file keeps its title when it is exported without options
    again = tmp_path / "again.html"
    (tmp_path / "noted.mgs").write_bytes(data)
    assert main(["export", str(tmp_path / "noted.mgs"), "--to", "html", "-o", str(again)]) == 0
    assert "<title>A garden</title>" in again.read_text("utf-8")


def test_notes_of_a_ply_are_attributes_of_its_page(
    scene: Path, tmp_path: Path, files: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "plain.ply"
    write_ply(path, decode_mgs(MGS).decode().gaussians)
    words = ["export", str(path), "--to", "site", "-o", str(tmp_path / "site")]
    assert main([*words, *NOTES, *files]) == 0
    (element,) = re.findall(
        r"<mobile-gs[^>]*>", (tmp_path / "site" / "index.html").read_text("utf-8")
    )
    found = {name: html.unescape(text) for name, text in re.findall(r' ([\w-]+)="(.*?)"', element)}
    assert (found["heading"], found["credit"], found["limits"]) == ("A garden", "me", "none")
    assert found["start"] == "1 2 3 0 0 0 0.4 0.3"
    assert found["start-portrait"].startswith("1 2 4 0 0 0 0.42")
    assert json.loads(found["annotations"])[0]["text"] == "A tree\nwith <b>leaves</b>"
    assert found["path"] == "0 0 -3 0 0 0;1 0 -3 0 0 0"
    assert (tmp_path / "site" / "scene.ply").read_bytes() == path.read_bytes()
    words = ["export", str(path), "--to", "glb", "-o", str(tmp_path / "a.glb"), "--credit", "me"]
    assert main(words) == 2
    assert "a .glb has no place for credit" in capsys.readouterr().err


def test_every_region_and_the_rows(scene: Path, tmp_path: Path) -> None:
    whole = decode_mgs(MGS)
    means = whole.decode().gaussians.means.double()
    np.save(tmp_path / "rows.npy", np.array([0, 9]))
    words = ["edit", str(scene), "-o", str(tmp_path / "new.mgs"), "--keep-sphere", "0 0 0 1.5"]
    words += [
        "--remove-box",
        "0 0 0 1 1 1; -1 -1 -1 0 0 0 1 0 0 0",
        "--remove-sphere",
        "0.5 0 0 .2",
    ]
    words += ["--remove-below", "0 0 1 -1", "--remove-rows", str(tmp_path / "rows.npy")]
    assert main(words) == 0
    keep = means.norm(dim=1) <= 1.5
    keep &= ~((means >= 0) & (means <= 1)).all(1) & ~((means >= -1) & (means <= 0)).all(1)
    keep &= (means - torch.tensor([0.5, 0, 0])).norm(dim=1) > 0.2
    keep &= means[:, 2] >= -1
    keep[[0, 9]] = False
    assert scenes_equal(read_mgs(tmp_path / "new.mgs"), kept_rows(whole, keep))


def test_cameras_are_counted_and_named(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["edit", str(scene), "-o", str(tmp_path / "new.mgs"), "--min-cameras", "1"]
    assert main([*words, "--remove-floaters"]) == 0
    told = capsys.readouterr().out
    number = len(decode_mgs(MGS).views)
    source = f"the {number} cameras that the file stores"
    assert f"seen by fewer than 1 of {number} cameras ({source})" in told
    assert f"floaters ({source})" in told


def test_a_view_of_the_viewers_address_is_a_start_view(scene: Path, tmp_path: Path) -> None:
    address = "http://127.0.0.1:9/?url=/scene#eye=1,2,3&at=0,0.5,0&up=0,-1,0"
    words = ["edit", str(scene), "-o", str(tmp_path / "new.mgs"), "--start-view", address]
    assert main(words) == 0
    found = parsed_start(read_mgs(tmp_path / "new.mgs").meta["start"])
    assert found is not None
    assert (found.eye.tolist(), found.target.tolist()) == ([1, 2, 3], [0, 0.5, 0])


@pytest.mark.parametrize(("up", "noted"), [("-y", [0, -1, 0]), ("3 0 4", [0.6, 0, 0.8])])
def test_the_upward_direction_is_noted(
    scene: Path, tmp_path: Path, up: str, noted: list[float]
) -> None:
    assert main(["edit", str(scene), "-o", str(tmp_path / "new.mgs"), f"--up={up}"]) == 0
    assert read_mgs(tmp_path / "new.mgs").up == pytest.approx(noted)


def test_a_ply_is_edited_and_exported(scene: Path, tmp_path: Path) -> None:
    path = tmp_path / "plain.ply"
    write_ply(path, decode_mgs(MGS).decode().gaussians)
    assert main(["edit", str(path), "--crop=-1 -1 -1 1 1 1"]) == 0
    found = read_ply(tmp_path / "plain-edited.ply")
    assert len(found) == len(cropped(decode_mgs(MGS)))
    for to in ("spz", "glb"):
        output = tmp_path / f"new.{to}"
        words = ["export", str(path), "--to", to, "-o", str(output), "--crop=-1 -1 -1 1 1 1"]
        assert main(words) == 0
        assert output.is_file()
    words = ["export", str(path), "--to", "html", "-o", str(tmp_path / "page.html")]
    assert main([*words, "--crop=-1 -1 -1 1 1 1", "--title", "A"]) == 0


def test_the_teacher_of_a_run_is_edited_in_its_scenes_place(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["export", str(scene), "--to", "ply", "-o", str(tmp_path / "new.ply")]
    assert main([*words, "--crop", "-1 -1 -1 1 1 1"]) == 2
    assert "would be refitted" in capsys.readouterr().err
    write_ply(tmp_path / "teacher.ply", decode_mgs(MGS).decode().gaussians)
    (tmp_path / "metrics.json").write_text("{}")
    assert main([*words, "--crop", "-1 -1 -1 1 1 1"]) == 0
    assert len(read_ply(tmp_path / "new.ply")) == len(cropped(decode_mgs(MGS)))


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--crop", "1 2 3"], "--crop needs X0 Y0 Z0 X1 Y1 Z1"),
        (["--start-view", "1 2 3"], "--start-view needs six or eight numbers"),
        (["--start-view", "0 0 0 0 0 0"], "cannot look at its own position"),
        (["--title", "a\nb"], "the title must be one line"),
        (["--up", "w"], "--up needs an axis"),
        (["--min-cameras", "-1"], "--min-cameras must be at least 0"),
        (["--annotations", "missing.json"], "cannot read missing.json"),
        (["--camera-path", __file__], "is not JSON"),
        (["--remove-rows", __file__], "does not hold row numbers"),
        (["--crop", "0 0 0 1 1 1", "--no-browser"], "with editing options no browser opens"),
        (["--title", "A", "--capture", "."], "no cameras are counted: leave out --capture"),
        (["--title", "A", "-o", "new.ply"], "does not end in .mgs"),
        (["--title", "A", "-o", __file__], "overwrites nothing"),
    ],
)
def test_bad_options_are_refused_with_one_sentence(
    scene: Path,
    tmp_path: Path,
    words: list[str],
    sentence: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["edit", str(scene), *words]) == 2
    told = capsys.readouterr().err
    assert re.search(sentence, told) and told.strip().count("\n") == 0
    assert [path.name for path in tmp_path.iterdir()] == ["scene.mgs"]


def test_the_browser_edits_mgs_files_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_ply(tmp_path / "plain.ply", decode_mgs(MGS).decode().gaussians)
    assert main(["edit", str(tmp_path / "plain.ply")]) == 2
    assert "is not a .mgs" in capsys.readouterr().err
    words = ["edit", str(tmp_path / "plain.ply"), "--title", "A"]
    assert main(words) == 2
    assert "holds no notes (title)" in capsys.readouterr().err


def test_a_run_counts_the_cameras_of_its_capture(
    dataset: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, capture = tmp_path / "run", tmp_path / "capture"
    write_capture(capture, dataset)
    run.mkdir()
    (run / "scene.mgs").write_bytes(MGS)
    options = {"options": {"capture": str(capture), "downscale": None}}
    (run / "config.json").write_text(json.dumps(options))
    assert main(["edit", str(run), "--min-cameras", "1"]) == 0
    assert f"of 6 cameras (the training cameras of {capture})" in capsys.readouterr().out
    words = ["edit", str(run / "scene.mgs"), "--min-cameras", "7", "--capture", str(capture)]
    assert main(words) == 2
    assert "there are only 6" in capsys.readouterr().err
