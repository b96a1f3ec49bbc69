"""A video of one turn around a scene."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.camera import look_at
from mobilegs.cli.main import main
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.formats.ply import write_ply
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_with_views
from mobilegs.viewpoints.orbit import orbit_cameras
from tests.support.garden import garden
from tests.support.scene_cases import Case, make_scene

av = pytest.importorskip("av", reason="needs the extra capture")


def read_video(path: Path) -> tuple[list[np.ndarray], float]:
    with av.open(str(path)) as file:
        stream = file.streams.video[0]
        return [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)], float(
            stream.average_rate
        )


def test_a_video_makes_one_turn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, video = tmp_path / "garden.ply", tmp_path / "out.mp4"
    write_ply(source, garden())
    words = ["render", str(source), "--orbit", str(video), "--seconds", "0.8", "--size", "96", "64"]
    assert main(words) == 0
    assert f"{video.stat().st_size:,} bytes" in capsys.readouterr().out
    frames, rate = read_video(video)
    assert (len(frames), rate) == (24, 30.0)
    scene, views = open_with_views(source, torch.device("cpu"))
    cameras = orbit_cameras(scene, views, 24, width=96, height=64)
    for number in (0, 7, 23):
        expected = to_bytes(scene.render(cameras[number]).image).numpy().astype(float)
        error = np.abs(frames[number] - expected).mean()
        assert error < 12  # chroma at half resolution
        assert error < np.abs(frames[(number + 12) % 24] - expected).mean()
    assert not list(tmp_path.glob("*.tmp*"))


def test_cameras_circle_the_target_of_the_training_cameras() -> None:
    up, middle = torch.tensor([0.0, -1.0, 0.0]), torch.tensor([1.0, 2.0, 3.0])
    first, *_ = make_scene(Case(20)).views
    eyes = [middle + torch.tensor([4.0, -1.0, 0.0]), middle + torch.tensor([0.0, -1.0, 4.0])]
    views = [replace(first, viewmat=look_at(eye, middle, up)) for eye in eyes]
    cameras = orbit_cameras(Scene(garden(50)), views, 8, width=64, height=48)
    places = torch.stack([camera.position for camera in cameras])
    away = places - middle
    assert torch.allclose(away.norm(dim=1), torch.tensor(math.sqrt(17.0)), atol=1e-2)
    assert torch.allclose(away[:, 1], torch.tensor(-1.0), atol=0.05)
    assert torch.allclose(places[0], eyes[0], atol=1e-3)
    for camera in cameras:
        ahead = camera.viewmat[:3, :3] @ (middle - camera.position)
        assert torch.allclose(ahead / ahead.norm(), torch.tensor([0.0, 0, 1]), atol=1e-3)


@pytest.mark.parametrize("named", [True, False])
def test_the_video_is_upright(
    named: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, video = tmp_path / "garden.ply", tmp_path / "out.mp4"
    up = np.array([0.0, 0, 1])  # as in the garden
    write_ply(source, garden(), up=up if named else None)
    words = ["render", str(source), "--orbit", str(video), "--seconds", "0.1", "--size", "96", "64"]
    for more in ([], ["--up", "z"]):
        assert main([*words, *more]) == 0
        said = capsys.readouterr().out
        assert ("up is -y, as usual: the file does not say" in said) == (not named and not more)
        scene, views = open_with_views(source)
        cameras = orbit_cameras(scene, views, 3, width=96, height=64, up="z" if more else None)
        for camera in cameras:
            level = -camera.viewmat[1, :3].numpy() @ up
            assert (level > 0.9) == (named or more != [])
        frames, _ = read_video(video)
        expected = to_bytes(scene.render(cameras[0]).image).numpy().astype(float)
        assert np.abs(frames[0] - expected).mean() < 12


def test_impossible_videos_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_ply(tmp_path / "garden.ply", garden(50))
    for words, sentence in (
        ("--orbit out.avi", "out.avi"),
        ("--orbit out.mp4 --seconds 0", "600 seconds"),
        ("--orbit out.mp4 --seconds nan", "600 seconds"),
        ("--orbit out.mp4 --size 95 64", "must be even"),
        ("--orbit out.mp4 --size 96 100000", "must be even"),
        ("--orbit out.mp4 --capture here", "leave out --capture"),
        ("", "--orbit MP4"),
        ("--capture here", "--orbit MP4"),
        ("--capture here -o there --up z", "--up is for --orbit"),
    ):
        assert main(["render", "garden.ply", *words.split()]) == 2, words
        assert sentence in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["garden.ply"]
