"""Exports to other formats, and the formats that can be opened."""

import json
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.cli.main import main
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.mgs.codec import encode_mgs, read_mgs
from mobilegs.representation.lobes import LobeShape
from mobilegs.scene_file import PLAIN, inspect_scene, open_scene, teacher_of
from mobilegs.spherical_harmonics import sh_colors
from tests.support.random_scenes import matched, max_error, random_scene
from tests.support.scene_cases import Case, make_scene

OTHERS = Path(__file__).parents[1] / "formats" / "other_tools"
CPU = torch.device("cpu")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    write_ply(tmp_path / "scene.ply", random_scene(60, 2))
    return tmp_path / "scene.ply"


def refusal(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    assert main([str(word) for word in words]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    return said


@pytest.mark.parametrize("kind", ["spz", "sog", "glb", "ply"])
def test_a_scene_converts_to_another_format_and_back(
    kind: str, scene: Path, tmp_path: Path
) -> None:
    there, back = tmp_path / f"there.{kind}", tmp_path / "back.ply"
    assert main(["export", str(scene), "--to", kind, "-o", str(there)]) == 0
    assert main(["export", str(there), "--to", "ply", "-o", str(back)]) == 0
    made = read_ply(scene)
    found = matched(read_ply(back), made)
    assert max_error(found.means, made.means) < 1e-3
    assert max_error(found.opacities, made.opacities) < 3e-3
    assert max_error(found.log_scales, made.log_scales) < 0.04
    assert max_error(found.sh, made.sh) < 0.07


def test_a_mgs_that_is_blended_sorted_is_exported(tmp_path: Path) -> None:
    path, there = tmp_path / "scene.mgs", tmp_path / "scene.ply"
    path.write_bytes(encode_mgs(replace(make_scene(Case(20)), blend="sorted")))
    assert main(["export", str(path), "--to", "ply", "-o", str(there)]) == 0
    found, made = read_ply(there), read_mgs(path).decode(CPU).gaussians
    for name, value in found.tensors().items():
        assert torch.equal(value, made.tensors()[name]), name


def test_a_sorted_mgs_with_opacities_by_direction_is_not_converted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, there = tmp_path / "scene.mgs", tmp_path / "there.ply"
    for case in (Case(20, LobeShape(1, 2)), Case(20, network=True)):
        path.write_bytes(encode_mgs(replace(make_scene(case), blend="sorted")))
        said = refusal(capsys, "export", path, "--to", "ply", "-o", there)
        assert "opacities that depend on the view" in said and "teacher.ply" in said
        assert not there.exists()


def up_of(path: Path) -> list[float]:
    scene = open_scene(path)
    return [0, -1, 0] if scene.up is None else scene.up.tolist()


@pytest.mark.parametrize("kind", ["spz", "sog", "glb"])
@pytest.mark.parametrize("named", ["by the file", "by the option"])
def test_a_scene_is_turned_so_that_the_file_opens_upright(
    kind: str, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made, there = random_scene(60, 3), tmp_path / f"there.{kind}"
    up = np.array([0.0, 0, 1]) if named == "by the file" else None
    write_ply(tmp_path / "scene.ply", made, up=up)
    words = ["export", str(tmp_path / "scene.ply"), "--to", kind, "-o", str(there)]
    assert main([*words, *(["--up", "z"] if up is None else [])]) == 0
    assert "turned to be upright: up was 0 0 1" in capsys.readouterr().out
    # a quarter of a turn around x takes z to -y
    turn = torch.tensor([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    found = open_scene(there).gaussians
    expected = made.means @ turn.T
    rows = torch.cdist(expected, found.means).argmin(1)
    found = found.select(rows)
    assert max_error(found.means, expected) < 1e-3
    directions = torch.nn.functional.normalize(made.means, dim=1)
    colors = sh_colors(made.sh, directions)
    assert max_error(sh_colors(found.sh, directions @ turn.T), colors) < 0.2
    assert up_of(there) == [0, -1, 0]
    if kind != "spz":  # which has no place for a note
        assert b"up was 0 0 1" in there.read_bytes()


def test_a_ply_keeps_its_positions_and_names_what_is_up(scene: Path, tmp_path: Path) -> None:
    there, back = tmp_path / "there.ply", tmp_path / "back.ply"
    assert main(["export", str(scene), "--to", "ply", "-o", str(there), "--up", "-x"]) == 0
    assert torch.equal(read_ply(there).means, read_ply(scene).means)
    assert up_of(there) == pytest.approx([-1, 0, 0])
    assert main(["export", str(there), "--to", "ply", "-o", str(back)]) == 0
    assert up_of(back) == pytest.approx([-1, 0, 0])


def test_a_scene_that_names_nothing_and_a_glb_are_not_turned(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for source, kind in ((scene, "glb"), (tmp_path / "scene.glb", "sog")):
        words = ["export", str(source), "--to", kind, "-o", str(tmp_path / f"scene.{kind}")]
        assert main(words) == 0
        assert "turned" not in capsys.readouterr().out
    assert torch.equal(read_ply(scene).means, open_scene(tmp_path / "scene.glb").gaussians.means)


def test_the_teacher_is_exported_for_a_student_in_its_run(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, there = tmp_path / "scene.mgs", tmp_path / "there.ply"
    path.write_bytes(encode_mgs(make_scene(Case(20))))
    teacher = tmp_path / "teacher.ply"
    teacher.write_bytes(scene.read_bytes())
    words = ["export", str(path), "--to", "ply", "-o"]
    assert teacher_of(path) is None  # any .ply could be called so
    (tmp_path / "metrics.json").write_text("{}")
    assert main([*words, str(there)]) == 0
    assert f"wrote {teacher} instead" in capsys.readouterr().out
    assert torch.equal(read_ply(there).means, read_ply(teacher).means)
    assert up_of(there) == pytest.approx(open_scene(path).up, abs=1e-5)  # of the run's cameras
    assert main([*words, str(teacher)]) == 2
    assert teacher.read_bytes() == scene.read_bytes()


def test_the_scene_itself_is_never_overwritten(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = scene.read_bytes()
    link = scene.with_name("link.ply")
    link.hardlink_to(scene)
    for name in (scene, link, scene.parent / ".." / scene.parent.name / scene.name):
        assert "the scene itself" in refusal(capsys, "export", scene, "--to", "ply", "-o", name)
    assert scene.read_bytes() == before


def test_formats_without_a_web_viewer_get_no_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    for name, words in (("theirs.sog", "a .mgs, .ply or .spz"), ("theirs.compressed.ply", "shows")):
        for to in ("html", "site"):
            said = refusal(capsys, "export", OTHERS / name, "--to", to, "-o", page)
            assert "export --to ply" in said or words in said
    assert not page.exists()


@pytest.mark.parametrize(
    "name",
    ["theirs.compressed.ply", "theirs.spz", "theirs.sog", "theirs.glb", "rows.splat", "scene.ply"],
)
def test_every_format_is_opened_and_inspected(name: str) -> None:
    opened = open_scene(OTHERS / name, CPU)
    assert opened.blend == "sorted" and len(opened.gaussians) == 12
    found = inspect_scene(OTHERS / name)
    assert found["gaussians"] == 12
    assert found["file_bytes"] == (OTHERS / name).stat().st_size


def test_an_unpacked_sog_is_opened_and_inspected(
    scene: Path, capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there, folder = tmp_path / "there.sog", tmp_path / "folder"
    assert main(["export", str(scene), "--to", "sog", "-o", str(there)]) == 0
    with zipfile.ZipFile(there) as archive:
        archive.extractall(folder)
    for path in (folder, folder / "meta.json"):
        assert inspect_scene(path)["gaussians"] == 60
        assert inspect_scene(path)["file_bytes"] == sum(f.stat().st_size for f in folder.iterdir())
        capsys.readouterr()
        assert main(["eval", str(path), "--capture", str(capture), "--json"]) == 0
        said = json.loads(capsys.readouterr().out)
        assert said["file_bytes"] == inspect_scene(path)["file_bytes"]


def test_the_error_message_names_every_format(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "scene.obj").touch()
    said = refusal(capsys, "info", tmp_path / "scene.obj")
    assert all(kind in said for kind in (".mgs", *PLAIN))
