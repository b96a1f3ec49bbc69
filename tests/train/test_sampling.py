"""The lower limit of scales: what the training cameras sample."""

import numpy as np
import pytest
import torch

from mobilegs.csrc import binding
from mobilegs.data.dataset import Dataset
from mobilegs.train import sampling
from mobilegs.train.sampling import LIMIT_EVERY, sampling_intervals
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.support.scenes import camera, random_scene
from tests.support.tiny import STUDENT, blobs, cameras, changed, train


def test_intervals_are_those_of_the_finest_camera_by_numpy() -> None:
    means = random_scene(300, seed=3, spread=2.0)["means"]
    views = [camera(), camera(90, 74), camera(20, 90, center=(0.9, 0.2))]
    found = sampling_intervals(means, views).numpy()
    expected = np.full(len(means), np.inf)
    for view in views:
        viewmat, k = view.viewmat.numpy(), view.K.numpy()
        for i, mean in enumerate(means.numpy()):
            x, y, z = viewmat[:3, :3] @ mean + viewmat[:3, 3]
            if z <= view.near:
                continue
            u, v = k[0, 0] * x / z + k[0, 2], k[1, 1] * y / z + k[1, 2]
            w, h = view.width, view.height
            if -0.15 * w < u < 1.15 * w and -0.15 * h < v < 1.15 * h:
                expected[i] = min(expected[i], z / max(k[0, 0], k[1, 1]))
    assert 20 < np.isinf(expected).sum() < 280
    np.testing.assert_allclose(found, expected)


@pytest.mark.parametrize("build", ["v4", "v3", "v2", "portable"])
def test_every_built_instruction_set_agrees_with_the_reference(build, monkeypatch) -> None:
    if not binding.BUILDS[build] <= binding.cpu_flags() or binding.built_library(build) is None:
        pytest.skip(f"needs a CPU that runs {build}")
    library = binding.library(build)
    monkeypatch.setattr(sampling, "library", lambda: library)
    view = camera()
    eye = -view.viewmat[:3, :3].T @ view.viewmat[:3, 3]
    means = torch.cat([random_scene(3000, seed=5, spread=2.0)["means"], eye[None]]).float()
    means[7] = torch.nan
    means[8, 1] = torch.inf
    several = [view, camera(90, 74), camera(20, 90, center=(0.9, 0.2))]
    for count in (0, 1, 17, 1024, len(means)):
        for views in (several, several[1:2]):
            found = sampling_intervals(means[-count:] if count else means[:0], views)
            with monkeypatch.context() as without:
                without.setattr(sampling, "supports", lambda *tensors: False)
                expected = sampling_intervals(means[-count:] if count else means[:0], views)
            # no mean lies so close to a border that roundings decide whether it is seen
            torch.testing.assert_close(found, expected, rtol=1e-5, atol=0)
    assert expected.isinf().any() and expected.isfinite().any()


def test_a_trained_teacher_keeps_the_limit(dataset: Dataset) -> None:
    config = TeacherConfig(steps=12, least_variance=64.0)
    seen = [frame.camera for frame in dataset.train]
    teacher = Teacher(config, dataset, seed=0, device=torch.device("cpu"))
    before = teacher.gaussians().to("cpu", torch.float64)  # a copy
    train(teacher, dataset, 12)
    found = teacher.gaussians()
    first, least = (
        (8 * sampling_intervals(g.means.float(), seen)).log()[:, None] for g in (before, found)
    )
    assert (before.log_scales < first - 0.1).any()
    assert (found.log_scales >= least - 1e-5).all()


def test_a_trained_student_keeps_the_limit_in_its_file(dataset: Dataset, make_student) -> None:
    assert LIMIT_EVERY > STUDENT.steps  # it is applied in the last step
    config = changed(STUDENT, least_variance=9.0, quantization={"method": "sq"})
    student = make_student(config)
    train(student, dataset, STUDENT.steps)
    coded = student.quantized_scene()
    scene, half = coded.decode().gaussians, coded.step_sizes["scale"] / 2
    first, least = (
        (3 * sampling_intervals(means, cameras()[1:])).log()[:, None]
        for means in (blobs().means, scene.means)
    )
    assert (blobs().log_scales < first - 0.1).any()
    assert half < 0.2
    assert (scene.log_scales >= least - half - 0.01).all()  # means are rounded, too
