"""Refinement of poses: corrections of the cameras, learned with the teacher."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, load_view
from mobilegs.errors import InputError
from mobilegs.train.poses import (
    PoseConfig,
    Poses,
    refined_camera,
    rotation_matrix,
    with_poses,
    write_poses,
)
from mobilegs.train.teacher import trainer
from mobilegs.train.teacher.trainer import Teacher
from tests.support.tiny import CPU, TEACHER, train

LRS = (3e-3, 1e-4)


def moved(camera: Camera, turn: np.ndarray, shift: np.ndarray) -> Camera:
    """Turn a camera about itself and move it, in numpy."""
    viewmat = camera.viewmat.double().numpy()
    rotation = viewmat[:3, :3] @ Rotation.from_rotvec(turn).as_matrix().T
    position = camera.position.double().numpy() + shift
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = rotation, -rotation @ position
    return replace(camera, viewmat=torch.from_numpy(found).float())


@pytest.mark.parametrize("angle", [0.0, 1e-5, 0.3, 2.0])
def test_a_turn_is_a_rotation_about_its_axis(angle: float) -> None:
    turn = angle * torch.tensor([0.6, 0.0, -0.8], dtype=torch.float64)
    expected = Rotation.from_rotvec(turn.numpy()).as_matrix()
    np.testing.assert_allclose(rotation_matrix(turn).numpy(), expected, atol=1e-9)
    assert torch.autograd.gradcheck(rotation_matrix, turn.clone().requires_grad_())


def test_a_camera_turns_about_itself_and_moves(dataset: Dataset) -> None:
    cameras = [frame.camera for frame in dataset.train]
    poses = Poses(cameras, 2.0, LRS)
    for index, camera in enumerate(cameras):
        torch.testing.assert_close(poses.camera(index, camera).viewmat, camera.viewmat)
    motion = torch.tensor([0.1, -0.2, 0.05, 0.3, 0.0, -0.1])
    with torch.no_grad():
        poses.motions[2] = motion
    expected = moved(cameras[2], motion[:3].numpy(), 2.0 * motion[3:].numpy())
    torch.testing.assert_close(poses.camera(2, cameras[2]).viewmat, expected.viewmat)


def perturbed(dataset: Dataset) -> Dataset:
    """The capture with wrong poses, by about a pixel."""
    random, frames = np.random.default_rng(0), []
    for frame in dataset.train:
        turn, shift = 0.03 * random.normal(size=3), 0.05 * random.normal(size=3)
        frames.append(replace(frame, camera=moved(frame.camera, turn, shift)))
    return replace(dataset, train=frames)


def distance(cameras: list[Camera], true: list[Camera], points: torch.Tensor) -> float:
    """Return the root mean square distance in pixels between projections of points."""

    def pixels(camera: Camera) -> torch.Tensor:
        inside = points @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]
        return (inside[:, :2] / inside[:, 2:]) * camera.K[0, 0]

    squares = [
        (pixels(one) - pixels(other)).square().sum(1)
        for one, other in zip(cameras, true, strict=True)
    ]
    return float(torch.stack(squares).mean().sqrt().detach())


@pytest.mark.thorough
def test_a_teacher_corrects_wrong_poses(dataset: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trainer, "POSE_LRS", LRS)
    monkeypatch.setattr(trainer, "POSE_START", 0.2)
    wrong = perturbed(dataset)
    pose = PoseConfig(learned=True)
    config = replace(TEACHER, steps=300, max_splats=200, init_splats=100, pose=pose)

    teacher = Teacher(config, wrong, seed=0, device=CPU)
    train(teacher, wrong, 300)
    assert teacher.poses is not None
    refined = [teacher.poses.camera(i, f.camera) for i, f in enumerate(wrong.train)]
    true, given = ([f.camera for f in each.train] for each in (dataset, wrong))
    before, after = (distance(each, true, dataset.points) for each in (given, refined))
    assert after < 0.7 * before


def test_a_held_back_photo_finds_its_pose_in_a_finished_scene(dataset: Dataset) -> None:
    teacher = Teacher(TEACHER, dataset, seed=0, device=CPU)
    train(teacher, dataset, TEACHER.steps)
    scene, view = teacher.scene(), load_view(dataset.train[0])
    view = replace(view, image=scene.render(view.camera).image)
    wrong = moved(view.camera, np.array([0.0, 0.02, 0.01]), np.zeros(3))
    found = refined_camera(scene, replace(view, camera=wrong), dataset.extent)
    before, after = (
        distance([camera], [view.camera], scene.gaussians.means) for camera in (wrong, found)
    )
    assert after < 0.2 * before


def test_poses_are_written_and_read(dataset: Dataset, tmp_path: Path) -> None:
    path, wrong = tmp_path / "poses.json", perturbed(dataset)
    write_poses(path, wrong)
    found = with_poses(dataset, path)
    for one, other in zip([*found.train, *found.test], [*wrong.train, *wrong.test], strict=True):
        torch.testing.assert_close(one.camera.viewmat, other.camera.viewmat)
    for damage in (
        "",
        "[]",
        '{"train": {}, "test": {}}',
        path.read_text().replace("[[", "[[NaN, "),
    ):
        path.write_text(damage)
        with pytest.raises(InputError, match="is damaged"):
            with_poses(dataset, path)
