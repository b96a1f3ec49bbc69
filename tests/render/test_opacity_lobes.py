"""Opacities in place of lobes."""

import inspect

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.render import Backend, render_sortfree
from tests.support.numpy_render import alphas_and_depths, sortfree_shares
from tests.support.scenes import as_float32, camera, random_scene

BOTH: list[tuple[Backend, torch.dtype]] = [("reference", torch.float64), ("kernel", torch.float32)]


def scene_with_extremes() -> dict[str, torch.Tensor]:
    scene = as_float32(random_scene(30, seed=3, spread=0.5))
    scene["opacities"][:4], scene["opacities"][4:8] = 0.0, 1.0
    return scene


@pytest.mark.parametrize(("backend", "dtype"), BOTH)
def test_opacities_blend_as_in_numpy_with_phi_1(backend, dtype):
    scene, view = scene_with_extremes(), camera(23, 17)
    view = view.to(dtype=torch.float32).to(dtype=torch.float64)
    alphas, depths = alphas_and_depths(scene, scene["opacities"], view)
    largest = scene["scales"].amax(1).numpy()
    shares, passed = sortfree_shares(alphas, depths, largest, np.ones(30))
    colors = torch.rand(30, 3, generator=torch.Generator().manual_seed(0))
    inputs = [scene[name].to(dtype) for name in ("means", "quats", "scales", "opacities")]
    given = {"colors": colors.to(dtype), "camera": view.to(dtype=dtype), "backend": backend}
    found = render_sortfree(*inputs, **given)
    tolerance = 2e-7 if dtype == torch.float64 else 1e-5  # an opacity of 1 moves by 1e-7
    expected = shares @ colors.double().numpy()
    np.testing.assert_allclose(found.image.double().reshape(-1, 3), expected, atol=tolerance)
    np.testing.assert_allclose(found.alpha.double().ravel(), 1 - passed, atol=tolerance)


def test_gradients_of_opacities_agree_with_the_reference():
    scene, view = scene_with_extremes(), camera()
    found = []
    for backend, dtype in BOTH:
        means, quats, scales = (scene[name].to(dtype) for name in ("means", "quats", "scales"))
        leaf = scene["opacities"].to(dtype, copy=True).requires_grad_()
        options = {"camera": view.to(dtype=dtype), "backend": backend}
        sh = scene["sh"].to(dtype)
        render_sortfree(means, quats, scales, leaf, sh, **options).image.sum().backward()
        assert leaf.grad is not None
        found.append(leaf.grad.double())
    assert (found[0][4:8] != 0).any() and (found[0][:4] == 0).all()
    assert (found[1] - found[0]).norm() < 1e-3 * found[0].norm()


@pytest.mark.parametrize(("backend", "dtype"), BOTH)
def test_an_opacity_of_nan_leaves_its_gaussian_out(backend, dtype):
    scene, view = scene_with_extremes(), camera().to(dtype=dtype)
    inputs = [scene[name].to(dtype) for name in ("means", "quats", "scales", "opacities", "sh")]
    inputs[3][9] = torch.nan
    broken = render_sortfree(*inputs, camera=view, backend=backend)
    inputs[3][9] = 0.0
    expected = render_sortfree(*inputs, camera=view, backend=backend)
    assert torch.equal(broken.image, expected.image) and broken.radii[9] == 0


@pytest.mark.parametrize(
    ("lobes", "message"),
    [
        (torch.full((5,), 1.5), "between 1.5 and 1.5"),
        (torch.linspace(-2, 0.5, 5), "between -2 and 0.5.*sigmoid"),
        (torch.zeros(4), r"\[4, 1, 2\]"),
        (torch.zeros(5, 2), r"\[5, 2\]: \[n, m, 2\]"),
        (torch.zeros(5, 1, 3), r"\[5, 1, 3\]"),
        (torch.zeros(4, 1, 2), r"\[4, 1, 2\]"),
        (torch.zeros(5, 3, 2), "1, 4, 9 or 16"),
    ],
)
def test_other_lobes_are_refused(lobes, message):
    scene, view = random_scene(5), camera().to(dtype=torch.float32)
    shapes = [scene[name].float() for name in ("means", "quats", "scales")]
    with pytest.raises(InputError, match=message):
        # without the tests' own check of annotations
        inspect.unwrap(render_sortfree)(*shapes, lobes, scene["sh"].float(), camera=view)
