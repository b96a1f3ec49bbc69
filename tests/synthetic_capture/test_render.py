"""cameras.json, and captures that are rendered from a scene."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.data import load_capture, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.formats.ply import write_ply
from mobilegs.render.scene import Scene
from mobilegs.synthetic_capture.render import CaptureOptions, render_synthetic_capture
from mobilegs.up import Axis, up_of_cameras
from mobilegs.viewpoints.cameras_json import read_cameras_json
from mobilegs.viewpoints.scene_bounds import find_scene_bounds
from tests.support.garden import cameras_json, garden


def test_cameras_json_is_read(tmp_path: Path) -> None:
    cameras = read_cameras_json(cameras_json(tmp_path / "cameras.json"))
    assert len(cameras) == 6
    first = cameras[0]
    assert (first.width, first.height) == (320, 200)
    assert torch.allclose(first.position, torch.tensor([9.0, 6.0, 8.5]), atol=1e-5)
    assert torch.equal(first.K, torch.tensor([[300.0, 0, 160], [0, 310, 100], [0, 0, 1]]))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("[]", "no list of cameras"),
        ('[{"width": 10}]', "camera 0 of .* is incomplete"),
        ("SIDE", "size, focal length, position or rotation"),
        ("FOCAL", "size, focal length, position or rotation"),
        ("TURN", "not a rotation"),
        ("NAN", "not finite"),
    ],
)
def test_an_invalid_cameras_json_raises_an_error(tmp_path: Path, text: str, words: str) -> None:
    path = cameras_json(tmp_path / "cameras.json")
    rows = json.loads(path.read_text())
    if text == "SIDE":
        rows[0]["width"] = 1e30
    elif text == "TURN":
        rows[0]["rotation"][0][0] += 1
    elif text == "FOCAL":
        rows[0] |= {"fx": [1, 2], "fy": [1, 2]}
    elif text == "NAN":
        rows[0]["position"][0] = float("nan")
    path.write_text(json.dumps(rows) if text.isalpha() else text)
    with pytest.raises(InputError, match=words):
        read_cameras_json(path)
    with pytest.raises(InputError, match="No such file"):
        read_cameras_json(tmp_path / "missing.json")


def test_a_rendered_capture_can_be_loaded(tmp_path: Path) -> None:
    scene = garden()
    source, folder = tmp_path / "garden.ply", tmp_path / "capture"
    write_ply(source, scene)
    render_synthetic_capture(Scene(scene), source, folder, CaptureOptions(views=16, size=64))
    capture = load_capture(folder)
    assert (len(capture.train), len(capture.test)) == (14, 2)
    assert (capture.train[0].camera.width, capture.train[0].camera.height) == (64, 48)
    assert 100 < len(capture.points) <= 3000
    view = capture.train[0]
    assert view.camera.near == capture.near == pytest.approx(0.02 * find_scene_bounds(scene).radius)
    drawn = to_bytes(Scene(scene).render(view.camera).image)
    error = drawn.float() - to_bytes(load_view(view).image).float()
    assert error.abs().mean() < 0.1  # poses of the COLMAP model are rounded
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}
    render_synthetic_capture(Scene(scene), source, folder, CaptureOptions(views=16, size=64))
    assert before == {path: path.stat().st_mtime_ns for path in before}
    for other in (CaptureOptions(views=17, size=64), CaptureOptions(views=16, size=65)):
        with pytest.raises(InputError, match="another scene"):
            render_synthetic_capture(Scene(scene), source, folder, other)
    write_ply(source, garden(seed=1))
    with pytest.raises(InputError, match="another scene"):
        render_synthetic_capture(Scene(scene), source, folder, CaptureOptions(views=16, size=64))
    with pytest.raises(InputError, match="something else"):
        render_synthetic_capture(Scene(scene), source, tmp_path, CaptureOptions(views=16, size=64))


def test_cameras_are_placed_upright(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """By the option, by the file, or else by the scene's shape, which is said."""
    source, scene = tmp_path / "garden.ply", garden(600)
    write_ply(source, scene)
    named = Scene(scene, up=np.array([1.0, 0, 0]))
    cases: list[tuple[Scene, Axis | None, list[int]]] = [
        (named, "-y", [0, -1, 0]),
        (named, None, [1, 0, 0]),
        (Scene(scene), None, [0, 0, 1]),
    ]
    for number, (given, option, expected) in enumerate(cases):
        folder, options = tmp_path / str(number), CaptureOptions(views=16, size=64, up=option)
        render_synthetic_capture(given, source, folder, options)
        cameras = [frame.camera for frame in load_capture(folder).train]
        up = up_of_cameras(np.stack([camera.viewmat.numpy() for camera in cameras]))
        assert up @ np.array(expected) > (0.999 if number < 2 else 0.99)
        said = f"{source} does not say which way is up: cameras are placed with (" in caplog.text
        assert said == (number == 2)
        assert ("up" in json.loads((folder / "made_from.json").read_text())) == (option is not None)


def test_an_interrupted_capture_is_completed(tmp_path: Path) -> None:
    scene = garden()
    source, folder = tmp_path / "garden.ply", tmp_path / "capture"
    write_ply(source, scene)
    render_synthetic_capture(Scene(scene), source, folder, CaptureOptions(views=16, size=64))
    model = {path.name: path.read_bytes() for path in (folder / "sparse" / "0").iterdir()}
    (folder / "sparse" / "0" / "cameras.txt").unlink()
    (folder / "images" / "0003.png").unlink()
    render_synthetic_capture(Scene(scene), source, folder, CaptureOptions(views=16, size=64))
    assert (folder / "images" / "0003.png").exists()
    assert model == {path.name: path.read_bytes() for path in (folder / "sparse" / "0").iterdir()}


@pytest.mark.parametrize(("views", "size"), [(15, 64), (16, 9000)])
def test_options_out_of_range_raise_an_error(views: int, size: int) -> None:
    with pytest.raises(InputError, match="must lie between"):
        CaptureOptions(views=views, size=size)
