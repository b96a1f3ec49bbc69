"""Colours and features given in place of harmonics."""

import inspect

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.render import Backend, render_sorted, render_sortfree
from mobilegs.render.lobes import evaluate_lobes
from tests.support.golden import RENDERERS, input_names
from tests.support.kernels import compare_with_reference
from tests.support.numpy_render import alphas_and_depths, sorted_shares, sortfree_shares
from tests.support.scenes import SORTED, SORTFREE, as_float32, camera, gradcheck_scene, random_scene

BACKENDS: list[tuple[Backend, torch.dtype]] = [
    ("reference", torch.float64),
    ("kernel", torch.float32),
]
RENDER = {"sorted": (render_sorted, SORTED[:4]), "sortfree": (render_sortfree, SORTFREE[:4])}


def rendered(kind, scene, view, colors, backend, dtype, **options):
    render, names = RENDER[kind]
    shapes = [scene[name].to(dtype) for name in names]
    given = {"camera": view.to(dtype=dtype), "backend": backend, "colors": colors.to(dtype)}
    return render(*shapes, **given, **options)


@pytest.mark.parametrize(("backend", "dtype"), BACKENDS)
@pytest.mark.parametrize("channels", [1, 3, 7])
@pytest.mark.parametrize("kind", RENDER)
def test_features_blend_as_in_numpy(kind, channels, backend, dtype):
    scene, view = as_float32(random_scene(30, seed=3, spread=0.5)), camera(23, 17)
    view = view.to(dtype=torch.float32).to(dtype=torch.float64)
    generator = torch.Generator().manual_seed(channels)
    colors = (10.0 ** torch.arange(channels)) * torch.randn(30, channels, generator=generator)
    colors, background = colors.double(), torch.linspace(-2, 2, channels).double()
    opacities, phi = scene["opacities"], None
    if kind == "sortfree":
        directions = torch.nn.functional.normalize(scene["means"] - view.position, dim=1)
        opacities, phi = evaluate_lobes(scene["lobes"], directions)
    alphas, depths = alphas_and_depths(scene, opacities, view)
    if phi is None:
        shares, passed = sorted_shares(alphas, depths)
    else:
        shares, passed = sortfree_shares(
            alphas, depths, scene["scales"].amax(1).numpy(), phi.numpy()
        )
    expected = shares @ colors.numpy() + passed[:, None] * background.numpy()
    options = {"background": background.to(dtype), "depth": True}
    found = rendered(kind, scene, view, colors, backend, dtype, **options)
    assert found.image.shape == (17, 23, channels)
    tolerance = 1e-12 if dtype == torch.float64 else 2e-5
    for channel in range(channels):
        error = np.abs(found.image[..., channel].double().numpy().ravel() - expected[:, channel])
        assert error.max() < tolerance * 10**channel, channel
    np.testing.assert_allclose(found.alpha.double().ravel(), 1 - passed, atol=tolerance)
    np.testing.assert_allclose(found.depth.double().ravel(), shares @ depths, atol=5 * tolerance)


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs", "depth_pass"])
@pytest.mark.parametrize(
    ("case", "channels"),
    [("several tiles", 1), ("several tiles", 3), ("opaque", 5), ("empty scene", 5)],
)
def test_the_kernel_agrees_with_the_reference(case, renderer, channels):
    compare_with_reference(case, renderer, channels=channels)


@pytest.mark.parametrize("kind", RENDER)
def test_gradients_of_features_pass_gradcheck(kind):
    (render, names), channels = RENDER[kind], 2
    inputs, view = gradcheck_scene(names)
    colors = torch.linspace(-3, 3, 4 * channels).double().reshape(4, channels)
    inputs.append(colors[torch.randperm(4)].requires_grad_())
    background = torch.full((channels,), -0.5).double()

    def image(*given):
        return render(*given[:4], colors=given[4], camera=view, background=background).image

    assert torch.autograd.gradcheck(image, inputs)


@pytest.mark.parametrize("kind", RENDER)
def test_a_huge_feature_elsewhere_changes_no_bit_of_a_kernels_image(kind):
    scene, view = random_scene(40, seed=2), camera()
    scene["means"][0] = torch.tensor([0.0, 0, -50])  # behind the camera
    colors = torch.randn(40, 4, generator=torch.Generator().manual_seed(0))
    first = rendered(kind, scene, view, colors, "kernel", torch.float32)
    colors[0] = torch.tensor([1e30, -1e30, 1e20, -1e20])
    second = rendered(kind, scene, view, colors, "kernel", torch.float32)
    assert torch.equal(first.image, second.image)


@pytest.mark.parametrize(("backend", "dtype"), BACKENDS)
def test_a_feature_that_is_not_finite_takes_its_gaussian_out_of_all_channels(backend, dtype):
    scene, view = as_float32(random_scene(30, seed=4)), camera()
    rows = torch.arange(30) != 7
    expected = rendered(
        "sorted",
        {name: value[rows] for name, value in scene.items()},
        view,
        torch.ones(29, 5),
        backend,
        dtype,
    )
    colors = torch.ones(30, 5)
    colors[7, 4] = torch.nan
    colors = colors.to(dtype).requires_grad_()
    found = rendered("sorted", scene, view, colors, backend, dtype)
    torch.testing.assert_close(found.image, expected.image)
    found.image.sum().backward()
    assert colors.grad is not None and colors.grad[rows].sum() > 0
    assert (colors.grad[7] == 0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "no colours"),
        ({"sh": torch.zeros(5, 1, 3), "colors": torch.zeros(5, 3)}, "both"),
        ({"colors": torch.zeros(5)}, r"\[5\]: \[n, d\]"),
        ({"colors": torch.zeros(4, 3)}, r"\[4, 3\]"),
        ({"colors": torch.zeros(5, 0)}, r"\[5, 0\]"),
        ({"sh": torch.zeros(5, 3)}, r"evaluated colours as colors="),
        ({"sh": torch.zeros(5, 2, 3)}, "k = 1, 4, 9 or 16"),
        ({"colors": torch.zeros(5, 2), "background": torch.zeros(3)}, r"\[3\]: \[2\]"),
        ({"colors": torch.zeros(5, 4), "screen_grads": torch.zeros(5, 2)}, "three of them"),
        (
            {
                "colors": torch.zeros(5, 3),
                "screen_grads": torch.zeros(5, 2),
                "backend": "reference",
            },
            "screen_grads",
        ),
    ],
)
def test_what_does_not_fit_is_refused_with_its_shape(options, message):
    scene, view = random_scene(5), camera().to(dtype=torch.float32)
    shapes = [scene[name].float() for name in SORTED[:4]]
    with pytest.raises(InputError, match=message):
        # without the tests' own check of annotations
        inspect.unwrap(render_sorted)(*shapes, camera=view, **options)


@pytest.mark.parametrize("backend", ["reference", "kernel"])
@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
def test_a_color_of_zero_has_a_gradient(renderer, backend):
    render, options = RENDERERS[renderer]
    scene, view = random_scene(30, seed=6), camera().to(dtype=torch.float32)
    colors = torch.zeros(30, 3, requires_grad=True)
    shapes = [scene[name].float() for name in input_names(renderer)[:4]]
    found = render(*shapes, colors=colors, camera=view, backend=backend, **options)
    found.image.sum().backward()
    assert colors.grad is not None
    assert (colors.grad >= 0).all() and (colors.grad > 0).sum() > 10
