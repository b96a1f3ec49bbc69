"""Fragments per pixel against a count of the pairs that the reference evaluates."""

import pytest
import torch

from mobilegs.evaluate.fragments import fragments_per_pixel
from mobilegs.render.inputs import RenderSettings
from mobilegs.render.levels import at_level, choose_levels, level_sizes
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import pair_alphas, project
from tests.support.golden import as_scene, inputs_of, settings_of, trained


def _counted(scene, view, settings: RenderSettings) -> list[float]:
    """Count the pixels of each level's target in which a Gaussian's alpha is above 0."""
    gaussians, least = scene.gaussians, settings.weighting.alpha_min
    directions = torch.nn.functional.normalize(gaussians.means - view.position, dim=1)
    opacities, phi = evaluate_lobes(scene.lobes, directions)
    shapes = (gaussians.means, gaussians.quats, gaussians.scales, opacities, gaussians.sh)
    drawn = project(*shapes, camera=view, alpha_min=least, footprint=settings.footprint)
    weights = settings.weighting.weights(drawn.depths, gaussians.scales.amax(1), phi)
    levels = choose_levels(drawn, weights, settings.level_sigma)
    found = []
    for level, size in enumerate(level_sizes(view.height, view.width)):
        part, faded = at_level(drawn, opacities, level, levels == level, size=size, alpha_min=least)
        found.append(float((pair_alphas(part, faded, size, least) > 0).sum()))
    return [count / (view.height * view.width) for count in found]


@pytest.mark.parametrize("renderer", ["mobile_gs", "levels", "all"])
@pytest.mark.parametrize("case", ["several tiles", "large"])
def test_areas_are_near_the_number_of_pixels(case: str, renderer: str) -> None:
    inputs, view = inputs_of(case)
    settings = settings_of(renderer)
    scene, view = as_scene(inputs, renderer), view.to(dtype=torch.float32)
    found = fragments_per_pixel(scene, view, level_sigma=settings.level_sigma)
    expected = _counted(scene, view, settings)
    assert len(found) == (4 if settings.level_sigma else 1)
    assert found == pytest.approx(expected[: len(found)], rel=0.2, abs=0.15)
    assert sum(expected) > 5 if renderer == "mobile_gs" else expected[2] > 0


def test_levels_have_fewer_fragments() -> None:
    scene, view = trained()
    plain, leveled = (fragments_per_pixel(scene, view, level_sigma=k) for k in (0.0, 1.0))
    assert len(plain) == 1 and len(leveled) == 4
    assert sum(leveled) < 0.5 * plain[0]


def test_sorted_scenes_have_one_level() -> None:
    inputs, view = inputs_of("several tiles")
    scene, view = as_scene(inputs, "sorted"), view.to(dtype=torch.float32)
    assert len(fragments_per_pixel(scene, view, level_sigma=1.0)) == 1
