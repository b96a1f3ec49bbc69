"""Virtual views between the training cameras, and distillation on them."""

from collections.abc import Callable
from dataclasses import replace

import pytest
import torch
from scipy.spatial.transform import Rotation

from mobilegs.camera import Camera, look_at
from mobilegs.data.dataset import Dataset
from mobilegs.train.student.trainer import Student
from mobilegs.viewpoints.virtual_views import move_off_path, virtual_cameras
from tests.support.tiny import STUDENT, cameras, changed, train

MakeStudent = Callable[..., Student]
VIRTUAL = changed(STUDENT, loss={"virtual_view_every": 2})
UP = torch.tensor([0.0, 0, 1])


def ring(degrees: list[float], near: float = 0.2) -> list[Camera]:
    """Return cameras on a circle that look at its centre."""
    angles = torch.deg2rad(torch.tensor(degrees))
    eyes = 3 * torch.stack([angles.cos(), angles.sin(), torch.zeros_like(angles)], dim=1)
    K = cameras()[0].K
    return [Camera(look_at(eye, torch.zeros(3), UP), K, 24, 24, near) for eye in eyes]


def test_an_interpolated_camera_is_turned_by_its_share() -> None:
    one, other = ring([0, 60])
    other = replace(other, width=48, near=0.5)
    for share, angle in ((0.0, 0.0), (0.25, 15.0), (1.0, 60.0)):
        found = one.interpolate(other, share)
        [there] = ring([angle])
        torch.testing.assert_close(found.viewmat[:3, :3], there.viewmat[:3, :3], atol=1e-6, rtol=0)
        line = torch.lerp(one.position, other.position, share)
        torch.testing.assert_close(found.position, line, atol=1e-6, rtol=0)
        assert (found.width, found.near) == (24, 0.2) and torch.equal(found.K, one.K)
    turn = torch.tensor([0.0, 0.1, 0.0])
    turned = one.interpolate(other, 0.0, turn=turn)
    to_world = Rotation.from_matrix(one.viewmat[:3, :3].T.double().numpy())
    wanted = (to_world * Rotation.from_rotvec(turn.double().numpy())).as_matrix().T
    assert abs(turned.viewmat[:3, :3].double().numpy() - wanted).max() < 1e-6


def test_neighbours_with_similar_directions_have_virtual_cameras() -> None:
    given = ring([0, 10, 20, 30, 180])
    found = virtual_cameras(given, seed=4)
    assert len(found) == 4 * 60  # none for the camera that looks the other way
    for number, camera in enumerate(found):
        home = given[number // 60]
        reach = [(camera.position - other.position).norm() for other in given]
        assert min(reach) < 0.3 < reach[4]
        assert camera.viewmat[2, :3] @ home.viewmat[2, :3] > 0.9
    same, others = virtual_cameras(given, seed=4), virtual_cameras(given, seed=5)
    assert all(torch.equal(a.viewmat, b.viewmat) for a, b in zip(found, same, strict=True))
    assert any(not torch.equal(a.viewmat, b.viewmat) for a, b in zip(found, others, strict=True))


@pytest.mark.parametrize("degrees", [[0], [0, 90, 180, 270]])
def test_cameras_without_similar_neighbours_have_no_virtual_cameras(degrees: list[float]) -> None:
    assert virtual_cameras(ring(degrees), seed=0) == []


def test_cameras_in_one_place_have_finite_virtual_cameras() -> None:
    found = virtual_cameras([cameras()[0]] * 3, seed=0)
    assert len(found) == 300 and all(camera.viewmat.isfinite().all() for camera in found)


def test_cameras_move_off_the_path_by_the_distance_of_the_scene(
    generator: torch.Generator,
) -> None:
    given = ring(torch.linspace(0, 350, 200).tolist())
    points = 0.3 * torch.randn(500, 3, generator=generator)  # around the centre, 3 units away
    moved = move_off_path(given, points, seed=3)
    pairs = list(zip(given, moved, strict=True))
    shifts = torch.stack([a.viewmat[:3, :3] @ (b.position - a.position) for a, b in pairs])
    assert all(
        torch.equal(a.viewmat[:3, :3], b.viewmat[:3, :3]) for a, b in zip(given, moved, strict=True)
    )
    sideways, forwards = shifts[:, :2], shifts[:, 2]
    assert sideways.std() == pytest.approx(0.12 * 3, rel=0.15)
    assert -0.8 < forwards.min() < -0.6 and 1.0 < forwards.max() < 1.25
    near = [*points, *torch.full((100, 3), 0.5) * torch.tensor([5.0, 0, 0])]  # 0.5 units away
    [close] = move_off_path(given[:1], torch.stack(near), seed=1)
    forth = given[0].viewmat[2, :3] @ (close.position - given[0].position)
    assert forth <= 0.26
    for a, b in zip(moved, move_off_path(given, points, seed=3), strict=True):
        assert torch.equal(a.viewmat, b.viewmat)
    assert move_off_path(given[:3], points + 100, seed=3) == given[:3]  # none in view


def recorded(student: Student, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that records the indices of the teacher's images from now on."""
    found: list[int] = []
    get = student.teacher_images.get
    monkeypatch.setattr(
        student.teacher_images,
        "get",
        lambda index, camera: found.append(index) or get(index, camera),
    )
    return found


def test_virtual_views_are_the_only_targets_of_distillation(
    dataset: Dataset, make_student: MakeStudent, monkeypatch: pytest.MonkeyPatch
) -> None:
    student = make_student(changed(VIRTUAL, loss={"virtual_view_every": 3}))
    student.virtual_cameras = virtual_cameras(ring([0, 20, 40]), seed=0)
    found = recorded(student, monkeypatch)
    train(student, dataset, 24)  # of 40: the second half has none
    assert len(found) == 7 and all(6 <= index < 306 for index in found) and len(set(found)) > 1


def test_without_virtual_cameras_distillation_is_on_photos(
    dataset: Dataset, make_student: MakeStudent, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mobilegs.train.student.trainer.virtual_cameras", lambda *_: [])
    student = make_student(VIRTUAL)
    found = recorded(student, monkeypatch)
    train(student, dataset, 6)
    assert len(found) == 6 and max(found) < 6
    quiet = make_student(changed(VIRTUAL, loss={"distill_weight": 0.0, "depth_weight": 0.0}))
    found = recorded(quiet, monkeypatch)
    train(quiet, dataset, 6)
    assert found == []
