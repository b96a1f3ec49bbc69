"""The reference: gradients by finite differences, values computed by hand, invariants."""

import math
from dataclasses import replace

import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.gaussians import Gaussians
from mobilegs.render import Weighting, render_sorted, render_sortfree, visible_rows
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.scene import Scene
from mobilegs.render.sortfree import WEIGHTINGS
from mobilegs.spherical_harmonics import rgb_to_sh0
from tests.support.golden import view_network
from tests.support.scenes import (
    SORTED,
    SORTFREE,
    camera,
    gradcheck_scene,
    hold_visibility,
    random_scene,
)
from tests.support.selection import few

BACKGROUND = torch.tensor([0.1, 0.2, 0.35], dtype=torch.float64)


@pytest.mark.parametrize("degree", few([0, 1, 3], 1))
def test_sorted_blending_passes_gradcheck(degree):
    inputs, view = gradcheck_scene(SORTED, degree=degree)

    def render(*x):
        rendered = render_sorted(*x, camera=view, background=BACKGROUND, depth=True)
        assert rendered.depth is not None
        return rendered.image, rendered.alpha, rendered.depth

    assert torch.autograd.gradcheck(render, inputs)


@pytest.mark.parametrize("name", few(WEIGHTINGS, "mobile_gs"))
def test_sortfree_blending_passes_gradcheck(name, monkeypatch):
    inputs, view = gradcheck_scene(SORTFREE)
    weighting = Weighting(name, sigma=6.0, background_weight=0.4)
    hold_visibility(monkeypatch)

    def render(*x):
        options = {"camera": view, "background": BACKGROUND, "weighting": weighting}
        rendered = render_sortfree(*x, depth=True, **options)
        assert rendered.depth is not None
        return rendered.image, rendered.alpha, rendered.depth

    assert torch.autograd.gradcheck(render, inputs)


def test_a_detached_weight_is_a_constant_for_depth_and_scale(monkeypatch):
    inputs, view = gradcheck_scene(SORTFREE, lobe_degree=0)  # phi does not depend on positions

    def grads(weighting):
        options = {"camera": view, "background": BACKGROUND, "weighting": weighting}
        image = render_sortfree(*inputs, **options).image
        return torch.autograd.grad((image * image).sum(), inputs)

    attached, found = grads(Weighting()), grads(Weighting(detached=True))
    weights = Weighting.weights
    monkeypatch.setattr(Weighting, "weights", lambda *given: weights(*given).detach())
    expected = grads(Weighting())
    for i in range(3):
        torch.testing.assert_close(found[i], expected[i])
    assert not torch.allclose(found[0], attached[0]) and not torch.allclose(found[2], attached[2])
    torch.testing.assert_close(found[3], attached[3])


@pytest.mark.parametrize("lobe_degree", few([0, 3], 0))
def test_lobes_of_every_degree_pass_gradcheck(lobe_degree):
    inputs, view = gradcheck_scene(SORTFREE, degree=0, lobe_degree=lobe_degree)
    assert torch.autograd.gradcheck(
        lambda *x: render_sortfree(*x, camera=view, background=BACKGROUND).image, inputs
    )


def _on_axis(depths: list[float], opacities: list[float], phi: list[float], colors):
    """Return round Gaussians at the centre of a one-pixel image; the camera looks along +z."""
    n = len(depths)
    view = Camera(
        torch.eye(4, dtype=torch.float64),
        torch.tensor([[10.0, 0, 0.5], [0, 10.0, 0.5], [0, 0, 1]], dtype=torch.float64),
        1,
        1,
    )
    means = torch.zeros(n, 3, dtype=torch.float64)
    means[:, 2] = torch.tensor(depths)
    quats = torch.tensor([[1.0, 0, 0, 0]], dtype=torch.float64).expand(n, 4)
    scales = torch.full((n, 3), 0.5, dtype=torch.float64)
    rest = [torch.tensor(x, dtype=torch.float64) for x in (opacities, colors, phi)]
    lobes = constant_lobes(rest[0].logit(), rest[2])
    return [means, quats, scales, rest[0], rgb_to_sh0(rest[1])[:, None, :]], lobes, view


def test_two_gaussians_blend_by_equations_2_and_3():
    colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    inputs, lobes, view = _on_axis([2.0, 4.0], [0.5, 0.8], [1.5, 0.5], colors)
    inputs[3] = lobes
    image = render_sortfree(*inputs, camera=view, background=BACKGROUND).image[0, 0]
    w = [1.5**2 + 1.5 / 4 + math.exp(0.25), 0.5**2 + 0.5 / 16 + math.exp(0.125)]
    red, green = 0.5 * w[0], 0.8 * w[1]
    light = 0.5 * 0.2
    expected = [0.9 * red / (red + green), 0.9 * green / (red + green), 0.0]
    expected = torch.tensor(expected, dtype=torch.float64) + light * BACKGROUND
    torch.testing.assert_close(image, expected, rtol=1e-12, atol=1e-12)


def test_the_exponent_of_the_weight_is_clamped():
    inputs, lobes, view = _on_axis([0.3, 4.0], [0.5, 0.5], [0.0, 0.0], [[1.0, 0, 0], [0, 1.0, 0]])
    inputs[2] = torch.tensor([[9.0] * 3, [0.1] * 3], dtype=torch.float64)  # s / d = 30
    inputs[3] = lobes
    image = render_sortfree(*inputs, camera=view, background=BACKGROUND).image[0, 0]
    w = [math.exp(4.0), math.exp(0.025)]
    assert image[0].item() == pytest.approx(0.75 * w[0] / sum(w) + 0.25 * 0.1, rel=1e-9)


def test_the_visibility_of_two_gaussians_is_that_of_the_formula():
    colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    inputs, lobes, view = _on_axis([2.0, 4.0], [0.5, 0.8], [1.5, 0.5], colors)
    inputs[3] = lobes
    options = {"camera": view, "background": BACKGROUND, "weighting": Weighting("depth_pass")}
    rendered = render_sortfree(*inputs, **options)
    alphas = []  # of each at the pixel, from the four pixels of the picture around it
    for opacity, z in ((0.5, 2.0), (0.8, 4.0)):
        before = (10 * 0.5 / z) ** 2 + 0.3  # variances in px^2
        after = before + 2.25
        line = 0.375 * math.exp(-(2.5**2) / 2 / after) + 0.625 * math.exp(-(1.5**2) / 2 / after)
        alphas.append(opacity * before / after * line**2)
    total = sum(alphas)
    mean = sum(a * math.log(z) for a, z in zip(alphas, (2.0, 4.0), strict=True)) / total
    square = sum(a * math.log(z) ** 2 for a, z in zip(alphas, (2.0, 4.0), strict=True)) / total
    deviation = math.sqrt(square - mean * mean)
    seen = [
        math.exp(-total * min(1, max(0, 0.5 + 0.4 * (math.log(z) - mean) / (deviation + 0.02))))
        for z in (2.0, 4.0)
    ]
    assert 0 < seen[1] < 0.8 * seen[0] < 0.8
    w = [1.5**2 + 1.5 / 4 + math.exp(0.25), 0.5**2 + 0.5 / 16 + math.exp(0.125)]
    red, green = 0.5 * w[0] * seen[0], 0.8 * w[1] * seen[1]
    expected = [0.9 * red / (red + green), 0.9 * green / (red + green), 0.0]
    expected = torch.tensor(expected, dtype=torch.float64) + 0.1 * BACKGROUND
    torch.testing.assert_close(rendered.image[0, 0], expected, rtol=1e-12, atol=1e-12)


def test_sorted_blending_does_not_depend_on_the_order_of_rows():
    inputs, _, view = _on_axis(
        [4.0, 2.0], [0.8, 0.5], [1.0, 1.0], [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]
    )
    rendered = render_sorted(*inputs, camera=view, background=BACKGROUND, depth=True)
    expected = torch.tensor([0.5, 0.5 * 0.8, 0.0], dtype=torch.float64) + 0.1 * BACKGROUND
    torch.testing.assert_close(rendered.image[0, 0], expected, rtol=1e-12, atol=1e-12)
    assert rendered.depth is not None
    assert rendered.depth[0, 0].item() == pytest.approx(0.5 * 2 + 0.5 * 0.8 * 4)
    assert rendered.alpha[0, 0].item() == pytest.approx(0.9)


def test_look_at_puts_the_target_on_the_axis_and_up_upwards():
    eye, target = torch.tensor([1.0, 2.0, 3.0]), torch.tensor([-1.0, 0.5, 0.0])
    viewmat = look_at(eye, target, torch.tensor([0.0, 0.0, 1.0]))
    seen = viewmat[:3, :3] @ target + viewmat[:3, 3]
    torch.testing.assert_close(seen[:2], torch.zeros(2), atol=1e-5, rtol=0)
    assert seen[2] > 0
    above = viewmat[:3, :3] @ (target + torch.tensor([0.0, 0.0, 0.1])) + viewmat[:3, 3]
    assert above[1] < 0  # camera y points down
    assert torch.linalg.det(viewmat[:3, :3]).item() == pytest.approx(1.0, abs=1e-5)


def test_resizing_a_camera_scales_the_projection():
    view = camera(40, 30)
    half = view.resized(20, 15)
    point = torch.tensor([0.3, -0.2, 3.0], dtype=torch.float64)
    full, small = view.K @ point, half.K @ point
    torch.testing.assert_close(small[:2] / small[2], full[:2] / full[2] / 2)


@pytest.mark.parametrize("blend", ["sorted", "sortfree"])
def test_a_network_is_evaluated_for_visible_gaussians_only(blend):
    scene, view = random_scene(200, spread=3.0, seed=2), camera()
    logits = torch.logit(scene["opacities"])
    shapes = (scene["means"], scene["quats"], scene["scales"].log(), logits, scene["sh"])
    gaussians, network = Gaussians(*shapes), view_network().double()
    background = torch.zeros(3, dtype=torch.float64)
    culled = Scene(gaussians, blend, network=network, background=background)
    directions = torch.nn.functional.normalize(gaussians.means - view.position, dim=1)
    whole = replace(culled, network=None, lobes=network(gaussians, directions))
    rows = visible_rows(scene["means"], scene["quats"], scene["scales"], camera=view)
    assert 0 < len(rows) < 200
    found, expected = (each.render(view, depth=True) for each in (culled, whole))
    for name, value in expected._asdict().items():
        torch.testing.assert_close(getattr(found, name), value, msg=name)
