"""mobilegs as a method of NerfBaselines, by datasets of the same shapes, without that package."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.data.dataset import Dataset, load_view
from mobilegs.errors import InputError
from mobilegs.mgs.codec import read_mgs
from mobilegs.nerfbaselines import SCENE, MobileGS, camera_of, capture_of, pixels_of
from mobilegs.render.levels import usual_level_sigma

STEPS = 24  # of teacher and student together
SETTINGS = {"preset": "short", "steps": STEPS, "device": "cpu", "teacher.max_splats": 60}


def arrays(dataset: Dataset) -> dict[str, Any]:
    """Return training photos as NerfBaselines gives them."""
    views = [load_view(frame) for frame in dataset.train]
    cameras = [view.camera for view in views]
    names = [f"/data/images/{view.name}" for view in views]
    poses = [torch.linalg.inv(camera.viewmat.double())[:3].numpy() for camera in cameras]
    intrinsics = [camera.K[[0, 1, 0, 1], [0, 1, 2, 2]].numpy() for camera in cameras]
    return {
        "cameras": SimpleNamespace(
            poses=np.stack(poses).astype(np.float32),
            intrinsics=np.stack(intrinsics),
            image_sizes=np.array([(camera.width, camera.height) for camera in cameras]),
        ),
        "image_paths": names,
        "image_paths_root": "/data/images",
        "images": [(255 * view.image).round().byte().numpy() for view in views],
        "masks": None,
        "points3D_xyz": dataset.points.numpy(),
        "points3D_rgb": (255 * dataset.colors).round().byte().numpy(),
        "metadata": {"scene": "blobs", "background_color": None},
    }


def one(cameras: Any, index: int) -> Any:
    """Return a camera as NerfBaselines passes it to `render`: arrays without their first axis."""
    return SimpleNamespace(**{name: array[index] for name, array in vars(cameras).items()})


@pytest.fixture
def data(dataset: Dataset) -> dict[str, Any]:
    return arrays(dataset)


@pytest.fixture
def trained(data: dict[str, Any]) -> Iterator[MobileGS]:
    method = MobileGS(train_dataset=data, config_overrides=SETTINGS)
    for step in range(method.get_info()["num_iterations"]):
        found = method.train_iteration(step)
        assert found["psnr"] > 3 and found["num_gaussians"] > 10
    yield method
    method.close()


def test_a_dataset_has_the_cameras_and_photos_of_the_capture(
    data: dict[str, Any], dataset: Dataset
) -> None:
    found = capture_of(data)
    assert [frame.name for frame in found.train] == [frame.name for frame in dataset.train]
    for ours, theirs in zip(found.train, dataset.train, strict=True):
        torch.testing.assert_close(ours.camera.viewmat, theirs.camera.viewmat, atol=1e-5, rtol=0)
        torch.testing.assert_close(ours.camera.K, theirs.camera.K)
        assert (load_view(ours).image - load_view(theirs).image).abs().max() < 1 / 254
    assert torch.equal(found.points, dataset.points) and found.near == pytest.approx(dataset.near)
    with pytest.raises(InputError, match="masks"):
        capture_of(data | {"masks": [np.ones((20, 24))]})


def test_transparent_photos_lie_over_the_background() -> None:
    image = np.array([[[255, 0, 0, 255], [255, 0, 0, 0], [0, 0, 0, 51]]], dtype=np.uint8)
    found = pixels_of(image, np.array([255.0, 255, 255]))
    assert found.tolist() == [[[255, 0, 0], [255, 255, 255], [204, 204, 204]]]
    assert pixels_of(np.full((1, 1, 3), 0.5, np.float32), np.zeros(3)).tolist() == [[[128] * 3]]


def test_the_finished_training_shows_its_file(
    trained: MobileGS, data: dict[str, Any], tmp_path: Path
) -> None:
    trained.save(str(tmp_path))
    camera = one(data["cameras"], 2)
    shown = trained.render(camera)["color"]
    scene = read_mgs(tmp_path / SCENE).decode()
    level_sigma = usual_level_sigma(soft_edge=scene.footprint.soft_edge)
    file = scene.render(camera_of(camera), level_sigma=level_sigma).image
    assert shown.shape == (24, 24, 3) and shown.dtype == np.float32
    np.testing.assert_allclose(shown, file.clamp(0, 1).numpy(), atol=1 / 254)


@pytest.mark.thorough
@pytest.mark.parametrize("steps", [7, 17, 23])  # of the teacher, of the student, once quantised
def test_a_checkpoint_renders_the_same_and_goes_on_to_the_same_file(
    steps: int, trained: MobileGS, data: dict[str, Any], tmp_path: Path
) -> None:
    method = MobileGS(train_dataset=data, config_overrides=SETTINGS)
    for step in range(steps):
        method.train_iteration(step)
    method.save(str(tmp_path / "one"))
    method.close()
    camera = one(data["cameras"], 1)
    expected = method.render(camera)["color"]

    alone = MobileGS(checkpoint=str(tmp_path / "one"))
    assert alone.get_info()["loaded_step"] == steps
    np.testing.assert_array_equal(alone.render(camera)["color"], expected)
    with pytest.raises(InputError, match="without photos"):
        alone.train_iteration(steps)
    alone.save(str(tmp_path / "two"))
    files = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert files == sorted(path.name for path in (tmp_path / "two").iterdir())
    for name in files:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()

    again = MobileGS(
        checkpoint=str(tmp_path / "two"), train_dataset=data, config_overrides=SETTINGS
    )
    for step in range(steps, STEPS):
        again.train_iteration(step)
    again.close()
    again.save(str(tmp_path / "three"))
    trained.save(str(tmp_path / "four"))
    made, whole = ((tmp_path / name / SCENE).read_bytes() for name in ("three", "four"))
    assert made == whole


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"preset": "fast"}, "there is no preset 'fast'"),
        ({"student.stepz": 3}, "names no setting"),
        ({"steps": 1}, "too few"),
    ],
)
def test_wrong_settings_are_refused(
    settings: dict[str, Any], told: str, data: dict[str, Any]
) -> None:
    with pytest.raises(InputError, match=told):
        MobileGS(train_dataset=data, config_overrides=settings)


def test_settings_may_be_texts_as_on_a_command_line(data: dict[str, Any]) -> None:
    texts = {name: str(value) for name, value in (SETTINGS | {"seed": 3}).items()}
    method = MobileGS(train_dataset=data, config_overrides=texts)
    assert method.get_info()["num_iterations"] == STEPS and method.seed == 3
    assert method.recipe.teacher.max_splats == 60
    method.close()


def test_steps_come_in_their_order(data: dict[str, Any]) -> None:
    method = MobileGS(train_dataset=data, config_overrides=SETTINGS)
    with pytest.raises(InputError, match="step 3 is not the next one, 0"):
        method.train_iteration(3)
    with pytest.raises(InputError, match="a training dataset or a checkpoint"):
        MobileGS()
    method.close()
