"""Losses of other formats: found, named, and refused if they are too much."""

import logging
import math
from pathlib import Path

import pytest
import torch

from mobilegs.cli.main import main
from mobilegs.errors import InputError
from mobilegs.formats.fidelity import measure_fidelity
from mobilegs.formats.ply import write_ply
from mobilegs.gaussians import Gaussians
from mobilegs.scene_file import PLAIN, Kind, write_gaussians
from tests.support.random_scenes import matched, random_scene

KINDS: list[Kind] = ["spz", "sog", "glb", "ply"]


def resized(scene: Gaussians, factor: float) -> Gaussians:
    """Return a scene in another unit."""
    scene.means[:] = scene.means * factor
    scene.log_scales += math.log(factor)
    return scene


def written(
    folder: Path, scene: Gaussians, kind: Kind, caplog: pytest.LogCaptureFixture
) -> tuple[Gaussians | None, str]:
    """Return what is read back, or None, and the warning or error."""
    caplog.clear()
    path = folder / f"scene.{kind}"
    try:
        with caplog.at_level(logging.WARNING):
            write_gaussians(path, scene, kind)
    except InputError as error:
        assert not list(folder.iterdir())
        return None, str(error)
    found = PLAIN[path.suffix](path)
    path.unlink()
    return found, caplog.text


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [1e-4, 1.0, 1e5])
def test_a_scene_of_any_size_is_kept_or_refused(
    kind: Kind, size: float, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made = resized(random_scene(500, 1), size)
    found, said = written(tmp_path, made, kind, caplog)
    if kind == "spz" and size in (1e-4, 1e5):  # sizes from 4.5e-5 to 357
        assert found is None
        assert "a .spz cannot hold this scene: sizes of" in said
        assert "out of 500 Gaussians; write a .ply or .glb" in said
        return
    assert found is not None and not said
    moved = (matched(found, made).means - made.means).norm(dim=1)
    assert (moved < made.scales.amax(1)).all()


@pytest.mark.parametrize("kind", ["spz", "sog"])
def test_distant_outliers_are_named_if_they_cost_the_others_their_places(
    kind: Kind, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made = random_scene(500, 0)
    made.log_scales[:450] += 3  # 50 small ones
    made.means[0] = torch.tensor([4e5, 0, 0])
    found, said = written(tmp_path, made, kind, caplog)
    assert found is not None
    if kind == "sog":  # whose steps are relative
        assert not said
        return
    number = int(((found.means - made.means).norm(dim=1) > made.scales.amax(1)).sum())
    assert number > 10
    assert f"the .spz does not hold all of the scene: positions of {number} move by more" in said


def test_sizes_and_colours_out_of_range_are_counted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made = random_scene(300, 1)
    made.log_scales[:7] = 7.0
    made.sh[7:20, 0] = 9.0
    made.sh[20:25, 1:] = 3.0
    _, said = written(tmp_path, made, "spz", caplog)
    assert "sizes of 7 change by more than a quarter, colours of 18 change" in said
    assert "positions" not in said and "out of 300 Gaussians" in said
    for kind in ("sog", "glb", "ply"):
        assert not written(tmp_path, made, kind, caplog)[1], kind


def test_flat_and_very_small_gaussians_do_not_count_as_lost() -> None:
    made = random_scene(100, 0)
    made.log_scales[:, 2] = -60.0
    made.log_scales[:10] = -60.0
    clipped = Gaussians(**made.tensors() | {"log_scales": made.log_scales.clamp_min(-10)})
    loss = measure_fidelity(made, clipped)
    assert (loss.resized, loss.lost) == (0, 0) and not str(loss)


def test_the_command_says_what_is_lost_and_keeps_the_previous_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    there = tmp_path / "there.spz"
    there.write_bytes(b"before")
    write_ply(tmp_path / "tiny.ply", resized(random_scene(200, 0), 1e-4))
    assert main(["export", str(tmp_path / "tiny.ply"), "--to", "spz", "-o", str(there)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "write a .ply or .glb" in said
    assert there.read_bytes() == b"before"
    assert {path.name for path in tmp_path.iterdir()} == {"tiny.ply", "there.spz"}
