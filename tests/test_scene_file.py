"""Scenes of other tools: the near plane follows their size."""

from pathlib import Path

import pytest
import torch

from mobilegs import formats
from mobilegs.camera import NEAR, Camera, look_at
from mobilegs.formats.ply import write_ply
from mobilegs.scene_file import near_of, open_scene
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
