"""Random points within the silhouettes of an object."""

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.train.teacher.init import initial_gaussians
from mobilegs.train.teacher.silhouettes import Silhouette, read_silhouettes, within
from tests.train.teacher.test_init import dataset

RADIUS = 0.5


def balls(folder: Path, *, photos: int = 8, radius: float = RADIUS) -> Dataset:
    """Photos of a ball at the centre, transparent around it."""
    scene = dataset(torch.zeros(0, 3))
    frames = []
    for index, frame in enumerate(scene.train[:photos]):
        camera = frame.camera
        rows, columns = torch.meshgrid(torch.arange(80), torch.arange(100), indexing="ij")
        rays = torch.stack([columns + 0.5, rows + 0.5, torch.ones(80, 100)], dim=2)
        rays = rays @ torch.linalg.inv(camera.K).T @ camera.viewmat[:3, :3]
        nearest = torch.linalg.cross(rays, -camera.position.expand_as(rays)).norm(dim=2)
        image = np.zeros((80, 100, 4), np.uint8)
        image[..., 3] = 255 * (nearest / rays.norm(dim=2) < radius).numpy()
        path = folder / f"{index}.png"
        Image.fromarray(image).save(path)
        frames.append(replace(frame, image_path=path, alpha="over"))
    return replace(scene, train=frames)


def start(scene: Dataset, count: int = 2000) -> torch.Tensor:
    generator = torch.Generator().manual_seed(0)
    return initial_gaussians(
        scene, count=count, opacity=0.1, sh_degree=0, generator=generator
    ).means


def test_points_lie_within_the_object(tmp_path: Path) -> None:
    """The cameras are on a ring, so the hull of a ball is closed above and below by cones."""
    means = start(balls(tmp_path))
    cell = 8 * 4 / 137  # of a silhouette at the centre, world units
    assert len(means) == 2000
    assert means[:, :2].norm(dim=1).max() < RADIUS + 1.5 * cell
    assert means[:, 2].abs().max() < RADIUS + 2.5 * cell
    assert means.norm(dim=1).median() > 0.3  # all of it is filled
    assert torch.equal(means, start(balls(tmp_path)))


def test_a_transparent_cell_needs_all_its_pixels_transparent(tmp_path: Path) -> None:
    scene = balls(tmp_path, photos=1)
    image = np.zeros((80, 100, 4), np.uint8)
    image[41, 51, 3] = 1  # nearly transparent
    Image.fromarray(image).save(tmp_path / "0.png")
    [silhouette] = read_silhouettes(scene.train)
    camera = silhouette.camera
    assert (camera.width, camera.height) == (13, 10)
    assert silhouette.shown.nonzero().tolist() == [[5, 6]]
    rays = torch.tensor([[51.5, 41.5, 1.0], [20.5, 41.5, 1], [20.5, 41.5, -1], [-5, 41.5, 1]])
    rays[2, :2] *= -1  # behind the camera
    rays = 4 * rays @ torch.linalg.inv(scene.train[0].camera.K).T
    points = rays @ camera.viewmat[:3, :3] + camera.position
    assert torch.equal(within(points, [silhouette]), points[:1])
    turned = replace(camera, viewmat=torch.diag(torch.tensor([-1.0, 1, -1, 1])) @ camera.viewmat)
    behind = Silhouette(turned, torch.ones_like(silhouette.shown))
    assert torch.equal(within(points, [silhouette, behind]), points[[0, 2]])


def test_contradicting_photos_start_everywhere_and_say_so(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    scene = balls(tmp_path)
    Image.fromarray(np.zeros((80, 100, 4), np.uint8)).save(tmp_path / "3.png")
    with caplog.at_level(logging.WARNING):
        means = start(scene)
    assert "transparent pixels leave almost no place for an object" in caplog.text
    assert len(means) == 2000 and means.norm(dim=1).max() > 1.5


def test_photos_that_lie_over_nothing_have_no_silhouettes(tmp_path: Path) -> None:
    scene = balls(tmp_path)
    masked = replace(scene, train=[replace(frame, alpha="mask") for frame in scene.train])
    unread = replace(scene, train=[replace(frame, image_path=None) for frame in scene.train])
    assert read_silhouettes(masked.train) == read_silhouettes(unread.train) == []
    assert torch.equal(start(masked), start(unread))


def test_a_damaged_photo_is_refused(tmp_path: Path) -> None:
    scene = balls(tmp_path)
    content = (tmp_path / "0.png").read_bytes()
    (tmp_path / "0.png").write_bytes(content[: len(content) // 2])
    with pytest.raises(InputError, match=r"0\.png cannot be decoded"):
        start(scene)
