"""Scenes of other tools: their near planes, and the cameras that come with a .ply."""

import json
import logging
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs import formats
from mobilegs.camera import NEAR, Camera, look_at
from mobilegs.formats.ply import write_ply
from mobilegs.gaussians import Gaussians
from mobilegs.scene_file import near_of, open_scene, read_plain_with_cameras
from mobilegs.synthetic_capture.render import CaptureOptions, render_synthetic_capture
from mobilegs.view.export import export_html
from mobilegs.viewpoints.framing import parsed_framing
from mobilegs.viewpoints.orbit import orbit_cameras
from mobilegs.viewpoints.pose import first_pose
from tests.support.garden import cameras_json, garden
from tests.support.node import javascript
from tests.support.random_scenes import random_scene


def test_every_format_is_in_the_list() -> None:
    folder = Path(formats.__file__).parent
    texts = {path.stem: path.read_text() for path in folder.glob("*.py")}
    read = {name for name, text in texts.items() if f"def read_{name}(" in text}
    written = {name for name, text in texts.items() if f"def write_{name}(" in text}
    assert read == set(formats.READ) and written == set(formats.WRITTEN)


def test_the_near_plane_follows_the_size_of_a_small_scene() -> None:
    corners = torch.cartesian_prod(*[torch.tensor([-1.0, 0.0, 1.0])] * 3)
    assert near_of(corners) == near_of(50 * corners) == NEAR
    assert near_of(0.05 * corners) == pytest.approx(0.05 * NEAR)
    assert near_of(0.05 * corners + 8) == pytest.approx(0.05 * NEAR, rel=1e-4)
    far = torch.cat([0.05 * corners, torch.full((1, 3), 900.0)])
    assert near_of(far) == pytest.approx(0.05 * NEAR)
    assert near_of(torch.zeros(0, 3)) == NEAR and near_of(torch.zeros(1, 3)) > 0


def test_a_scene_of_ten_centimetres_is_drawn_from_nearby(tmp_path: Path) -> None:
    gaussians = random_scene(400, 0)
    size = float((gaussians.means - gaussians.means.median(0).values).abs().amax())
    gaussians.means.mul_(0.05 / size)
    gaussians.log_scales.add_(torch.tensor(0.05 / size).log())
    write_ply(tmp_path / "small.ply", gaussians)
    scene = open_scene(tmp_path / "small.ply")
    eye = gaussians.means.median(0).values + torch.tensor([0.0, 0.0, 0.1])
    viewmat = look_at(eye, gaussians.means.median(0).values, torch.tensor([0.0, 1.0, 0.0]))
    K = torch.tensor([[40.0, 0, 20], [0, 40, 20], [0, 0, 1]])
    drawn = scene.render(Camera(viewmat, K, 40, 40, scene.near))
    assert (drawn.alpha > 0.1).float().mean() > 0.05
    assert (scene.render(Camera(viewmat, K, 40, 40, NEAR)).alpha == 0).all()


# of the sheet below: SHARP's elements, their types and numbers
SHARP: dict[str, tuple[str, str, list[float]]] = {
    "extrinsic": ("float", "<f4", [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]),
    "intrinsic": ("float", "<f4", [150, 0, 80, 0, 150, 60, 0, 0, 1]),
    "image_size": ("uint", "<u4", [160, 120]),
}


def sheet(path: Path, camera: dict[str, tuple[str, str, list[float]]]) -> Path:
    """Write a wall in the plane y = 4, for a camera at the origin with z up, and more elements."""
    places = torch.cartesian_prod(torch.linspace(-2, 2, 40), torch.linspace(-1.5, 1.5, 30))
    count = len(places)
    means = torch.stack([places[:, 0], torch.full((count,), 4.0), places[:, 1]], 1)
    wall = Gaussians(
        means,
        torch.tensor([[1.0, 0, 0, 0]]).expand(count, 4),
        torch.full((count, 3), 0.06).log(),
        torch.full((count,), 3.0),
        torch.rand(count, 1, 3, generator=torch.Generator().manual_seed(0)),
    )
    write_ply(path, wall)
    lines = "".join(
        f"element {name} {len(values)}\nproperty {type_} {name}\n"
        for name, (type_, _, values) in camera.items()
    )
    body = b"".join(np.array(values, kind).tobytes() for _, kind, values in camera.values())
    written = path.read_bytes().replace(b"end_header\n", f"{lines}end_header\n".encode())
    path.write_bytes(written + body)
    return path


READ_START = """
const { readPly } = await import(`${process.argv[1]}/load/ply.js`);
const { readFileSync } = await import("node:fs");
const { up, notes } = readPly(Uint8Array.from(readFileSync(JSON.parse(process.argv[2]))));
console.log(JSON.stringify({ up, start: notes?.start ?? null }));
"""


def test_a_ply_with_the_camera_of_its_photo_starts_there(tmp_path: Path) -> None:
    path = sheet(tmp_path / "photo.ply", SHARP)
    scene, [view] = read_plain_with_cameras(path)
    assert scene.up is not None and scene.up.tolist() == [0, 0, 1]
    assert (view.width, view.height, view.near) == (160, 120, scene.near)
    pose = first_pose(scene, [])
    np.testing.assert_allclose([*pose.eye, *pose.target], [0, 0, 0, 0, 4, 0], atol=1e-5)
    for camera in orbit_cameras(scene, [], 12, width=64, height=48):
        assert camera.position.norm() < 1.1 and camera.viewmat[2, 1] > 0.9
        assert scene.render(camera).alpha.mean() > 0.9
    theirs = javascript(READ_START, str(path))
    assert [float(word) for word in theirs["start"].split()] == pytest.approx(
        [0, 0, 0, 0, 4, 0, 0.4, 0.3]
    )
    assert theirs["up"] == [0, 0, 1]
    export_html(path, tmp_path / "page.html", title="")
    assert ' start="0 0 0 0 4 0 0.4 0.3" up="0.000000 0.000000 1.000000"' in (
        tmp_path / "page.html"
    ).read_text("utf-8")


def test_views_of_a_scene_of_one_photo_lie_near_its_camera(tmp_path: Path) -> None:
    path = sheet(tmp_path / "photo.ply", SHARP)
    scene, views = read_plain_with_cameras(path)
    options = CaptureOptions(views=16, size=64)
    render_synthetic_capture(scene, path, tmp_path / "capture", options, own=views)
    text = (tmp_path / "capture" / "sparse" / "0" / "images.txt").read_text("utf-8")
    rows = [line.split() for line in text.splitlines() if line.endswith(".png")]
    assert len(rows) == 16
    offsets = torch.tensor([[float(word) for word in row[5:8]] for row in rows]).norm(dim=1)
    assert 0.1 < offsets.max() < 3 and len(offsets.unique()) > 10


@pytest.mark.parametrize(
    ("element", "values"),
    [
        ("extrinsic", [0] * 16),
        ("extrinsic", [float("nan")] * 16),
        ("extrinsic", [1, 0, 0, 3e38, 0, 1, 0, 3e38, 0, 0, 1, 3e38, 0, 0, 0, 1]),
        ("extrinsic", [1, 0, 0]),
        ("intrinsic", [0] * 9),
        ("intrinsic", [float("inf")] * 9),
        ("image_size", [0, 120]),
        ("image_size", [4294967295, 120]),
    ],
)
def test_an_impossible_camera_is_not_used_and_said(
    element: str, values: list[float], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    type_, kind, _ = SHARP[element]
    path = sheet(tmp_path / "photo.ply", SHARP | {element: (type_, kind, values)})
    with caplog.at_level(logging.WARNING):
        scene, views = read_plain_with_cameras(path)
    assert (views, scene.notes, scene.up) == ([], {}, None)
    assert "not used" in caplog.text
    assert javascript(READ_START, str(path)) == {"up": None, "start": None}


@pytest.mark.parametrize("folder", ["", "point_cloud/iteration_7000"])
def test_a_cameras_json_of_the_training_gives_the_first_view(folder: str, tmp_path: Path) -> None:
    cameras_json(tmp_path / "cameras.json")
    path = tmp_path / folder / "point_cloud.ply"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_ply(path, garden(600))
    scene, views = read_plain_with_cameras(path)
    assert len(views) == 6 and open_scene(path).notes == scene.notes
    assert scene.up is not None and scene.up @ [0, 0, 1] > 0.999
    start = parsed_framing(scene.notes).start
    assert start is not None
    np.testing.assert_allclose(start.eye, views[0].position.numpy(), atol=1e-4)


@pytest.mark.parametrize("case", ["far", "behind", "malformed", "nested", "a folder"])
def test_a_cameras_json_that_does_not_fit_is_not_used_and_said(
    case: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path, listed = tmp_path / "scene.ply", cameras_json(tmp_path / "cameras.json")
    write_ply(path, garden(600))
    rows = json.loads(listed.read_text("utf-8"))
    for row in rows:
        if case == "far":
            row["position"] = [1000 * x for x in row["position"]]
        elif case == "behind":  # turned around their upward axes
            row["rotation"] = [[-a, b, -c] for a, b, c in row["rotation"]]
    listed.write_text({"malformed": "{", "nested": "[" * 100_000}.get(case, json.dumps(rows)))
    if case == "a folder":
        listed.unlink()
        listed.mkdir()
    with caplog.at_level(logging.WARNING):
        scene, views = read_plain_with_cameras(path)
    assert (views, scene.notes) == ([], {})
    assert ("not used" in caplog.text) == (case != "a folder")
