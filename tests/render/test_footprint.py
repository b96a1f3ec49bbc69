"""Footprints: compensated opacity and soft edges, the reference against numpy."""

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.render import Footprint, measure_contributions, render_sorted, render_sortfree
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import pair_alphas, project
from tests.support.golden import BACKGROUND, inputs_of
from tests.support.numpy_render import alphas_and_depths
from tests.support.scenes import SORTED, SORTFREE


@pytest.mark.parametrize(
    "footprint",
    [
        Footprint(0.1, antialiased=True),
        Footprint(1.0, soft_edge=True),
        Footprint(0.3, antialiased=True, soft_edge=True),
    ],
    ids=str,
)
@pytest.mark.parametrize("case", ["several tiles", "around the camera"])
def test_alpha_by_numpy(case, footprint):
    scene, view = inputs_of(case)
    directions = torch.nn.functional.normalize(scene["means"] - view.position, dim=1)
    opacities = evaluate_lobes(scene["lobes"], directions)[0]
    shapes = [scene[name] for name in SORTED[:3]]
    options = {"camera": view, "alpha_min": 1 / 64, "footprint": footprint}
    projected = project(*[*shapes, opacities, scene["sh"]], **options)
    size, soft = (view.height, view.width), footprint.soft_edge
    found = pair_alphas(projected, opacities, size, 1 / 64, soft_edge=soft)
    expected, _ = alphas_and_depths(scene, opacities, view, footprint, 1 / 64)
    np.testing.assert_allclose(found.numpy(), expected, atol=1e-10)


@pytest.mark.thorough
def test_an_antialiased_scene_keeps_its_coverage_at_every_size():
    scene, view = inputs_of("random, degree 1")
    scene["scales"] = scene["scales"] * 0.3  # most are smaller than a pixel
    inputs = [scene[name] for name in SORTFREE]
    coverages = {}
    for antialiased in (False, True):
        footprint = Footprint(0.1, antialiased=antialiased)
        options = {"background": BACKGROUND.double(), "footprint": footprint}
        coverages[antialiased] = [
            render_sortfree(*inputs, camera=view.resized(*size), **options).alpha.mean().item()
            for size in ((360, 296), (45, 37), (15, 12))
        ]
    exact, *others = coverages[True]
    assert all(abs(other / exact - 1) < 0.06 for other in others), coverages
    assert coverages[False][2] > 1.5 * exact, coverages


@pytest.mark.parametrize("backend", ["reference", "kernel"])
def test_a_gaussian_without_area_is_left_out_where_antialiased(backend):
    scene, view = inputs_of("zero size")
    dtype = torch.float32 if backend == "kernel" else torch.float64
    scene = {name: value.to(dtype) for name, value in scene.items()}
    options = {"camera": view.to(dtype=dtype), "background": BACKGROUND.to(dtype)}
    options |= {"footprint": Footprint(antialiased=True), "backend": backend}
    for render, names in ((render_sorted, SORTED), (render_sortfree, SORTFREE)):
        everything = render(*[scene[name] for name in names], **options)
        rest = render(*[scene[name][20:] for name in names], **options)
        torch.testing.assert_close(everything.image, rest.image)
        assert (everything.radii[:20] == 0).all()


def test_contributions_follow_the_footprint():
    scene, view = inputs_of("several tiles")
    given = [scene[name] for name in SORTED[:4]]
    footprint = Footprint(0.1, antialiased=True)
    exact = measure_contributions(*given, camera=view, footprint=footprint, backend="reference")
    assert not torch.equal(exact.weights, measure_contributions(*given, camera=view).weights)
    given = [value.float() for value in given]
    view = view.to(dtype=torch.float32)
    found = measure_contributions(*given, camera=view, footprint=footprint)
    torch.testing.assert_close(found.weights.double(), exact.weights, rtol=1e-3, atol=1e-3)


def test_impossible_footprints_are_refused():
    for blur in (0.0, -0.1, 5.0, float("nan")):
        with pytest.raises(InputError, match="blur must lie in"):
            Footprint(blur)
    scene, view = inputs_of("one Gaussian")
    with pytest.raises(InputError, match="sorted blending has no soft edge"):
        render_sorted(
            *[scene[name] for name in SORTED], camera=view, footprint=Footprint(soft_edge=True)
        )
