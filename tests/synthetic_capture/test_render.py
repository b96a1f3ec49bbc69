"""Where a scene without photos is photographed from, and the capture that this gives."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from mobilegs.camera import look_at
from mobilegs.data import load_capture, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.formats.ply import write_ply
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.synthetic_capture.cameras_json import read_cameras_json
from mobilegs.synthetic_capture.placement import between_cameras, place_cameras
from mobilegs.synthetic_capture.render import Shoot, photograph
from mobilegs.synthetic_capture.scene_bounds import layout_of

UP = torch.tensor([0.0, 0.0, 1.0])


def garden(count: int = 3000, *, seed: int = 0) -> Gaussians:
    """A round lawn in the plane z = 0 and a post that rises from its middle."""
    random = torch.Generator().manual_seed(seed)
    post = count // 3
    turn, out, high = torch.rand(3, count, generator=random)
    radius = 2 * out.sqrt()
    means = torch.stack([radius * (6.28 * turn).cos(), radius * (6.28 * turn).sin(), 0 * high], 1)
    means[:post, :2] *= 0.1
    means[:post, 2] = 1.5 * high[:post]
    sh = torch.zeros(count, 4, 3)
    sh[:, 0] = 2 * torch.rand(count, 3, generator=random) - 1
    return Gaussians(
        means=means + torch.tensor([5.0, 6.0, 7.0]),
        quats=torch.tensor([[1.0, 0, 0, 0]]).expand(count, 4).clone(),
        log_scales=torch.full((count, 3), 0.05).log(),
        logit_opacities=torch.full((count,), 2.0),
        sh=sh,
    )


def test_a_layout_finds_the_middle_and_up() -> None:
    some = garden()
    found = layout_of(some)
    assert (found.center - torch.tensor([5.0, 6.0, 7.0])).abs().max() < 0.3
    assert 0.5 < found.radius < 2
    assert float(found.up @ UP) > 0.99


def test_a_layout_is_not_led_astray_by_what_is_far_or_not_finite() -> None:
    some, before = garden(), layout_of(garden())
    some.means[:20] = 1e4 * torch.randn(20, 3, generator=torch.Generator().manual_seed(1))
    some.log_scales[:20] = 6.0
    some.means[20] = float("nan")
    found = layout_of(some)
    assert (found.center - before.center).norm() < 0.1
    assert float(found.up @ UP) > 0.99
    assert found.weights[20] == 0


def test_where_nothing_is_flat_up_is_that_of_colmap() -> None:
    some = garden()
    some.means[:] = torch.randn(len(some), 3, generator=torch.Generator().manual_seed(2))
    assert torch.equal(layout_of(some).up, torch.tensor([0.0, -1.0, 0.0]))


def test_an_up_that_is_given_is_believed() -> None:
    given = torch.tensor([0.0, 3.0, 4.0])
    assert torch.allclose(layout_of(garden(), up=given).up, given / 5)


def test_a_scene_without_anything_to_see_is_refused() -> None:
    some = garden()
    some.log_scales[:] = float("-inf")
    with pytest.raises(InputError, match="no Gaussian that can be seen"):
        layout_of(some)
    some = garden()
    some.logit_opacities[:] = -200.0
    with pytest.raises(InputError, match="no Gaussian that can be seen"):
        layout_of(some)


def placed(some: Gaussians, count: int = 24, seed: int = 0):
    generator = torch.Generator().manual_seed(seed)
    layout = layout_of(some)
    return layout, place_cameras(
        Scene(some), layout, count, width=80, height=60, generator=generator
    )


def test_cameras_stand_upright_around_the_scene_and_see_it() -> None:
    some = garden()
    layout, cameras = placed(some)
    assert len(cameras) == 24
    for view in cameras:
        assert float(-view.viewmat[1, :3] @ UP) > 0.2  # the picture's top is up
        assert view.position[2] > 7 - 0.5  # not below the lawn
        drawn = Scene(some).render(view)
        assert drawn.alpha.mean() > 0.15
    away = torch.stack([view.position - layout.center for view in cameras])
    assert torch.atan2(away[:, 1], away[:, 0]).sort().values.diff().max() < 1.7  # all around
    again = placed(some)[1]
    assert all(torch.equal(a.viewmat, b.viewmat) for a, b in zip(cameras, again, strict=True))
    other = placed(some, seed=1)[1]
    assert not torch.equal(cameras[0].viewmat, other[0].viewmat)


def test_cameras_stand_no_nearer_than_where_detail_ends() -> None:
    scene, layout = Scene(garden()), layout_of(garden())
    assert layout.detail == pytest.approx(0.05)
    nearest = []
    for detail in (1e-3, 3e-3, 1.0):
        cameras = place_cameras(
            scene,
            replace(layout, detail=detail * layout.radius),
            24,
            width=80,
            height=60,
            generator=torch.Generator().manual_seed(0),
        )
        away = torch.stack([view.position for view in cameras]) - layout.center
        nearest.append(float(away.norm(dim=1).min()) / layout.radius)
    # a Gaussian is 1/500 of the width at 433 times its size
    assert 0.6 <= nearest[0] < 1.2 and 1.29 <= nearest[1] < 2 and nearest[2] >= 1.999


def test_cameras_stay_out_of_walls() -> None:
    """Around the garden is a wall that hides it from without."""
    some = garden()
    turn = torch.linspace(0, 6.28, 4000)
    wall = garden(4000)
    high = torch.rand(4000, generator=torch.Generator().manual_seed(3))
    wall.means[:] = torch.stack([5 + 4 * turn.cos(), 6 + 4 * turn.sin(), 7 + 5 * high], 1)
    wall.log_scales[:] = torch.tensor(0.15).log()
    both = Gaussians(
        **{name: torch.cat([t, wall.tensors()[name]]) for name, t in some.tensors().items()}
    )
    _, cameras = placed(both)
    for view in cameras:
        away = (view.position - torch.tensor([5.0, 6.0, 7.0]))[:2].norm()
        over = view.position[2] > 7 + 4.5
        assert away < 4 or over


def test_a_scene_that_cannot_be_seen_from_anywhere_is_refused() -> None:
    some = garden()
    some.logit_opacities[:] = -4.0
    some.log_scales[:] = torch.tensor(1e-4).log()
    with pytest.raises(InputError, match="--cameras"):
        placed(some, count=2)


def cameras_json(path: Path, count: int = 6) -> Path:
    rows = []
    for step in range(count):
        turn = torch.tensor(6.28 * step / count)
        eye = torch.tensor([5.0, 6.0, 8.5]) + 4 * torch.stack([turn.cos(), turn.sin(), 0 * turn])
        viewmat = look_at(eye, torch.tensor([5.0, 6.0, 7.3]), UP)
        rows.append(
            {
                "id": step,
                "img_name": f"{step}",
                "width": 320,
                "height": 200,
                "position": eye.tolist(),
                "rotation": viewmat[:3, :3].T.tolist(),
                "fx": 300.0,
                "fy": 310.0,
            }
        )
    path.write_text(json.dumps(rows))
    return path


def test_cameras_json_is_read(tmp_path: Path) -> None:
    cameras = read_cameras_json(cameras_json(tmp_path / "cameras.json"))
    assert len(cameras) == 6
    first = cameras[0]
    assert (first.width, first.height) == (320, 200)
    assert torch.allclose(first.position, torch.tensor([9.0, 6.0, 8.5]), atol=1e-5)
    assert torch.equal(first.K, torch.tensor([[300.0, 0, 160], [0, 310, 100], [0, 0, 1]]))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "no JSON"),
        ("[" * 100_000, "no JSON"),
        ("{}", "no list of cameras"),
        ("[]", "no list of cameras"),
        ("[1]", "camera 0 of .* lacks a number"),
        ('[{"width": 10}]', "camera 0 of .* lacks a number"),
        ("SIDE", "size, focal length, position or rotation"),
        ("FOCAL", "size, focal length, position or rotation"),
        ("FAR", "not finite"),
        ("TURN", "rotation that is none"),
        ("NAN", "not finite"),
    ],
)
def test_a_cameras_json_that_is_none_is_refused(tmp_path: Path, text: str, sentence: str) -> None:
    path = cameras_json(tmp_path / "cameras.json")
    rows = json.loads(path.read_text())
    if text == "SIDE":
        rows[0]["width"] = 1e30
    elif text == "TURN":
        rows[0]["rotation"][0][0] += 1
    elif text == "FOCAL":
        rows[0] |= {"fx": [1, 2], "fy": [1, 2]}
    elif text == "FAR":
        rows[0]["position"][0] = 1e300
    elif text == "NAN":
        rows[0]["position"][0] = float("nan")
    path.write_text(json.dumps(rows) if text.isalpha() else text)
    with pytest.raises(InputError, match=sentence):
        read_cameras_json(path)
    with pytest.raises(InputError, match="no file"):
        read_cameras_json(tmp_path / "missing.json")


def test_cameras_lie_between_those_that_are_given(tmp_path: Path) -> None:
    given = read_cameras_json(cameras_json(tmp_path / "cameras.json"))
    layout = layout_of(garden())
    generator = torch.Generator().manual_seed(0)
    found = between_cameras(given, layout, 40, size=160, generator=generator)
    assert len(found) == 40
    assert {(view.width, view.height) for view in found} == {(160, 100)}
    for one, other in zip(given, found, strict=False):
        assert torch.equal(one.viewmat, other.viewmat)
    eyes = torch.stack([view.position for view in found])
    apart = torch.cdist(eyes, torch.stack([view.position for view in given])).amin(1)
    assert 0.5 < apart.max() < 4
    for view in found[6:]:
        turned = view.viewmat[:3, :3]
        assert torch.allclose(turned @ turned.T, torch.eye(3), atol=1e-5)
    few = between_cameras(given, layout, 3, size=160, generator=generator)
    assert [float(v.position[0]) for v in few] == [float(given[i].position[0]) for i in (0, 2, 5)]


def test_a_capture_is_made_of_a_scene(tmp_path: Path) -> None:
    some = garden()
    source, folder = tmp_path / "garden.ply", tmp_path / "capture"
    write_ply(source, some)
    photograph(Scene(some), source, folder, Shoot(views=16, size=64))
    capture = load_capture(folder)
    assert (len(capture.train), len(capture.test)) == (14, 2)
    assert (capture.train[0].camera.width, capture.train[0].camera.height) == (64, 48)
    assert 100 < len(capture.points) <= 3000
    view = capture.train[0]
    assert view.camera.near == capture.near == pytest.approx(0.02 * layout_of(some).radius)
    drawn = to_bytes(Scene(some).render(view.camera).image)
    error = drawn.float() - to_bytes(load_view(view).image).float()
    assert error.abs().mean() < 0.1  # poses in COLMAP's words are rounded otherwise
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}
    photograph(Scene(some), source, folder, Shoot(views=16, size=64))
    assert before == {path: path.stat().st_mtime_ns for path in before}
    for other in (Shoot(views=17, size=64), Shoot(views=16, size=65)):
        with pytest.raises(InputError, match="another scene"):
            photograph(Scene(some), source, folder, other)
    write_ply(source, garden(seed=1))
    with pytest.raises(InputError, match="another scene"):
        photograph(Scene(some), source, folder, Shoot(views=16, size=64))
    with pytest.raises(InputError, match="something else"):
        photograph(Scene(some), source, tmp_path, Shoot(views=16, size=64))


def test_pictures_that_were_interrupted_are_completed(tmp_path: Path) -> None:
    some = garden()
    source, folder = tmp_path / "garden.ply", tmp_path / "capture"
    write_ply(source, some)
    photograph(Scene(some), source, folder, Shoot(views=16, size=64))
    model = {path.name: path.read_bytes() for path in (folder / "sparse" / "0").iterdir()}
    (folder / "sparse" / "0" / "cameras.txt").unlink()
    (folder / "images" / "0003.png").unlink()
    photograph(Scene(some), source, folder, Shoot(views=16, size=64))
    assert (folder / "images" / "0003.png").exists()
    assert model == {path.name: path.read_bytes() for path in (folder / "sparse" / "0").iterdir()}


@pytest.mark.parametrize(("views", "size"), [(15, 64), (20_000, 64), (16, 63), (16, 9000)])
def test_impossible_numbers_of_pictures_are_refused(views: int, size: int) -> None:
    with pytest.raises(InputError, match="must lie between"):
        Shoot(views=views, size=size)
