"""Levels of the renderer: the reference against numpy, its gradients, and what the image keeps."""

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render import Weighting, render_sortfree
from mobilegs.render.levels import enlarge, level_sizes
from mobilegs.render.lobes import opacity_lobes
from mobilegs.spherical_harmonics import rgb_to_sh0
from tests.support.golden import BACKGROUND, settings_of
from tests.support.scenes import SORTFREE, camera, near_threshold, random_scene


def test_a_target_enlarged_is_bilinear():
    for height, width in ((50, 83), (7, 6), (1, 1), (2, 9)):
        sizes = level_sizes(height, width)
        for level in range(1, 4):
            fine, coarse = sizes[level - 1], sizes[level]
            generator = np.random.default_rng(level)
            values = generator.normal(size=coarse)
            # centres of pixels, in pixels of the coarse target, which begins one pixel before
            first = 0 if level == 1 else 1
            at = [(np.arange(n) - first + 0.5) / 2 + 1 - 0.5 for n in fine]
            assert all(a[0] >= 0 and a[-1] <= n - 1 for a, n in zip(at, coarse, strict=True))
            expected = np.empty(fine)
            for i, y in enumerate(at[0]):
                for j, x in enumerate(at[1]):
                    y0, x0 = int(y), int(x)
                    u, v = y - y0, x - x0
                    y1, x1 = min(y0 + 1, coarse[0] - 1), min(x0 + 1, coarse[1] - 1)
                    expected[i, j] = (1 - u) * ((1 - v) * values[y0, x0] + v * values[y0, x1])
                    expected[i, j] += u * ((1 - v) * values[y1, x0] + v * values[y1, x1])
            given = torch.from_numpy(values)[..., None]
            found = enlarge(given, fine, to_image=level == 1)[..., 0]
            np.testing.assert_allclose(found.numpy(), expected, atol=1e-14)


def _one_gaussian(sigma: float, size: int = 64) -> tuple[list[torch.Tensor], Camera]:
    """Return a round Gaussian of sigma pixels at (30.3, 33.8), and a camera."""
    k = torch.tensor([[100.0, 0, 32], [0, 100.0, 32], [0, 0, 1]], dtype=torch.float64)
    view = Camera(torch.eye(4, dtype=torch.float64), k, size, size)
    mean = torch.tensor([[-0.017, 0.018, 1.0]], dtype=torch.float64)
    quat = torch.tensor([[1.0, 0, 0, 0]], dtype=torch.float64)
    scale = torch.full((1, 3), sigma / 100, dtype=torch.float64)
    lobes = opacity_lobes(torch.tensor([0.6], dtype=torch.float64))
    sh = rgb_to_sh0(torch.tensor([[0.9, 0.5, 0.1]], dtype=torch.float64))[:, None]
    return [mean, quat, scale, lobes, sh], view


@pytest.mark.parametrize(("sigma", "level"), [(1.9, 0), (2.1, 1), (4.2, 2), (8.4, 3), (20.0, 3)])
def test_one_gaussian_at_each_level_by_numpy(sigma, level):
    inputs, view = _one_gaussian(sigma)
    options = {"camera": view, "background": BACKGROUND.double(), "backend": "reference"}
    found = render_sortfree(*inputs, level_sigma=1.0, **options)
    side, first = 2**level, 1 if level else 0
    sizes = level_sizes(64, 64)
    assert sizes == [(64, 64), (34, 34), (18, 18), (10, 10)]
    # the variance of the enlargement, as the sum of 3/16 h^2 of each doubling
    spread = sum(3 / 16 * 4**step for step in range(1, level + 1))
    variance = (100 * inputs[2][0, 0].item()) ** 2
    mean = np.array([30.3, 33.8])
    # exact covariance of the projection of a ball at (x, y, 1): J J^T s^2
    x, y = inputs[0][0, :2].numpy()
    jacobian = np.array([[100, 0, -100 * x], [0, 100, -100 * y]])
    covariance = jacobian @ jacobian.T * (variance / 100**2) + 0.3 * np.eye(2)
    narrowed = (covariance - spread * np.eye(2)) / side**2
    opacity = 0.6 * np.sqrt(np.linalg.det(covariance) / np.linalg.det(narrowed)) / side**2
    rows, columns = np.mgrid[: sizes[level][0], : sizes[level][1]] + 0.5
    offsets = np.stack([columns, rows], 2) - (mean / side + first)
    q = np.einsum("hwi,ij,hwj->hw", offsets, np.linalg.inv(narrowed), offsets)
    alpha = opacity * np.exp(-q / 2)
    alpha = np.where(alpha >= 1 / 255, np.minimum(alpha, 0.99), 0)
    kept = torch.from_numpy(1 - alpha)[..., None]
    for step in range(level, 0, -1):
        kept = enlarge(kept, sizes[step - 1], to_image=step == 1)
    np.testing.assert_allclose(found.alpha.numpy(), 1 - kept[..., 0].numpy(), atol=1e-12)


@pytest.mark.parametrize("level_sigma", [1.0, 1.5, 2.0])
def test_a_gaussian_keeps_its_shape_at_every_level(level_sigma):
    largest = {1.0: 0.025, 1.5: 0.012, 2.0: 0.007}[level_sigma]  # of the edge at 1/255, too
    for sigma in (2.2, 3.7, 4.5, 9.0, 16.0):
        inputs, view = _one_gaussian(sigma, size=48)
        options = {"camera": view, "background": BACKGROUND.double(), "backend": "reference"}
        exact = render_sortfree(*inputs, **options).alpha
        found = render_sortfree(*inputs, level_sigma=level_sigma, **options).alpha
        assert (found - exact).abs().max() < largest, sigma


def test_a_heavy_gaussian_needs_more_pixels():
    inputs, view = _one_gaussian(4.2)
    options = {"camera": view, "background": BACKGROUND.double(), "backend": "reference"}
    light, exact = Weighting(), render_sortfree(*inputs, **options).image
    assert not torch.equal(render_sortfree(*inputs, level_sigma=1.0, **options).image, exact)
    # w = phi^2 + phi / d^2 + exp(s / d) = 3364 + 58 + 1: (w / 10)^(1/4) = 4.3, above 4.2
    heavy = inputs[3].clone()
    heavy[..., 1] *= 58
    options["weighting"] = light
    given = [*inputs[:3], heavy, inputs[4]]
    found = render_sortfree(*given, level_sigma=1.0, **options).image
    assert torch.equal(found, render_sortfree(*given, **options).image)


@pytest.mark.parametrize("renderer", ["antialiased", "soft edge", "levels", "all"])
def test_gradients_by_finite_differences(renderer):
    settings = settings_of(renderer)
    if settings.level_sigma:
        settings = settings._replace(level_sigma=0.6)
    view = camera(9, 7)
    for seed in range(100):
        scene = random_scene(3, degree=0, lobe_degree=1, seed=seed, spread=0.5, size=6.0)
        if not near_threshold(scene, view, names=SORTFREE, margin=1e-3, settings=settings).any():
            break
    else:
        raise AssertionError("every scene has a value near a threshold")
    inputs = [scene[name].requires_grad_() for name in SORTFREE]

    # projections of all outputs: a gradient of each pixel would take as many passes
    sides = torch.randn(3, 5, 7 * 9, generator=torch.Generator().manual_seed(0)).double()

    def render(*given: torch.Tensor) -> torch.Tensor:
        options = {"camera": view, "background": BACKGROUND.double(), "depth": True}
        rendered = render_sortfree(*given, **options, **settings._asdict())
        assert rendered.depth is not None
        outputs = (*rendered.image.unbind(2), rendered.alpha, rendered.depth)
        return (sides * torch.stack(outputs).flatten(1)).sum((1, 2))

    if settings.level_sigma:
        plain = settings._replace(level_sigma=0.0)._asdict()
        options = {"camera": view, "background": BACKGROUND.double()}
        exact = render_sortfree(*inputs, **options, **plain).image
        found = render_sortfree(*inputs, **options, **settings._asdict()).image
        assert not torch.equal(found, exact)
    assert torch.autograd.gradcheck(render, inputs)


def test_impossible_settings_are_refused():
    inputs, view = _one_gaussian(2.0)
    options = {"camera": view, "background": BACKGROUND.double()}
    for level_sigma in (-1.0, 0.5, 1000.0, float("nan")):
        with pytest.raises(InputError, match="level_sigma must be 0 or lie"):
            render_sortfree(*inputs, level_sigma=level_sigma, **options)
