"""Supersampling: means of larger renders, and how many pixels there are in place of one."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from mobilegs.render.supersampling import supersampling_for
from tests.support.golden import as_scene
from tests.support.scenes import camera, random_scene


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
def test_pixels_are_means_of_a_larger_render(renderer: str) -> None:
    scene = as_scene(random_scene(300, seed=2), renderer)
    view = camera(32, 24).to(dtype=torch.float32)
    found = scene.render(view, depth=True, supersampling=3)
    large = scene.render(view.resized(96, 72), depth=True)
    for name in ("image", "alpha", "depth"):
        pixels = getattr(large, name).numpy()
        rows = [
            [pixels[3 * y : 3 * y + 3, 3 * x : 3 * x + 3] for x in range(32)] for y in range(24)
        ]
        expected = np.array(rows).reshape(24, 32, 3, 3, -1).mean((2, 3))
        drawn = getattr(found, name).numpy().reshape(24, 32, -1)
        np.testing.assert_allclose(drawn, expected, atol=1e-5)
    torch.testing.assert_close(found.radii, large.radii / 3)


@pytest.mark.parametrize(
    ("size", "expected"),
    [(200, 1), (100, 1), (75, 1), (60, 2), (50, 2), (33, 3), (25, 4), (10, 4), (5, 4)],
)
def test_small_images_are_rendered_at_about_the_size_of_training(size: int, expected: int) -> None:
    trained = camera(100, 100)
    view = trained.resized(size, size)
    assert supersampling_for(view, [trained]) == expected
    assert supersampling_for(view, []) == 1


def test_the_larger_image_is_not_too_large_for_a_gpu() -> None:
    trained = camera(100, 100)
    wide = replace(trained.resized(25, 25), width=1500)
    assert supersampling_for(wide, [trained]) == 2
    assert supersampling_for(replace(wide, width=5000), [trained]) == 1
