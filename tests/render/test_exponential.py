"""The weighting `exponential`, the paper's Eq. 1 as printed."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.errors import InputError
from mobilegs.mgs.codec import pack
from mobilegs.render import Weighting, render_sortfree
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.scene import Scene
from mobilegs.render.sortfree import exponential_lobes, exponential_weights
from mobilegs.render.view_network import ViewNetwork
from mobilegs.train.autograd_ops import with_weighting_gradients
from tests.support.scene_cases import Case, make_scene
from tests.support.scenes import SORTFREE, gradcheck_scene
from tests.support.tiny import blobs, cameras

EQUATION_1 = Weighting("exponential", background_weight=0.3)
SIDEWAYS = [[0, 0, -1.0, 0], [0, 1, 0, 0], [1, 0, 0, 0.5], [0, 0, 0, 1]]  # d = x + 0.5
DEPTHS, OPACITIES = np.array([0.7, 2.0, 5.0]), np.array([0.5, 0.8, 0.3])
SIGMA, BETA = np.array([0.2, 1.5, 0.05]), np.array([1.0, 0.4, 2.5])
COLORS = np.array([[1.0, 0.1, 0.0], [0.2, 0.9, 0.3], [0.0, 0.4, 1.0]])
BACKGROUND = np.array([0.1, 0.2, 0.35])


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])  # the reference, the kernel
def test_a_pixel_is_equation_1_in_numpy(dtype: torch.dtype) -> None:
    w = np.exp(-SIGMA * DEPTHS**BETA)
    aw = OPACITIES * w
    expected = (0.3 * BACKGROUND + aw @ COLORS) / (0.3 + aw.sum())

    def tensor(values) -> torch.Tensor:
        return torch.tensor(values, dtype=dtype)

    attenuation = tensor(np.log(np.stack([SIGMA, BETA], axis=1)))
    torch.testing.assert_close(exponential_weights(tensor(DEPTHS), attenuation), tensor(w))
    view = Camera(tensor(SIDEWAYS), tensor([[10.0, 0, 0.5], [0, 10, 0.5], [0, 0, 1]]), 1, 1, 0.1)
    means = torch.zeros(3, 3, dtype=dtype)
    means[:, 0] = tensor(DEPTHS - 0.5)
    lobes = constant_lobes(tensor(np.log(OPACITIES / (1 - OPACITIES))), tensor([9.0, 0, -2]))
    lobes, weighting = exponential_lobes(lobes, means, attenuation, EQUATION_1, camera=view)
    quats = tensor([[1.0, 0, 0, 0]] * 3)
    shapes = (means, quats, torch.full_like(means, 0.5))
    rendered = render_sortfree(
        *shapes,
        lobes,
        colors=tensor(COLORS),
        camera=view,
        background=tensor(BACKGROUND),
        weighting=weighting,
    )
    tolerance = 1e-12 if dtype == torch.float64 else 1e-5
    found = rendered.image[0, 0].double()
    torch.testing.assert_close(found, torch.tensor(expected), rtol=tolerance, atol=tolerance)


def test_gradients_of_all_parameters_match_finite_differences() -> None:
    """float64; `with_weighting_gradients` gives that of the background's weight."""
    (means, quats, scales, lobes, sh), view = gradcheck_scene(SORTFREE)
    generator = torch.Generator().manual_seed(2)
    noise = torch.randn(len(means), 2, generator=generator, dtype=torch.float64)
    attenuation = (torch.tensor([-1.0, 0.0]) + 0.3 * noise).requires_grad_()
    behind = torch.tensor(0.4, dtype=torch.float64, requires_grad=True)
    background = torch.tensor(BACKGROUND)

    def image(means, lobes, attenuation, behind) -> torch.Tensor:
        weighting = replace(EQUATION_1, background_weight=float(behind.detach()))
        lobes, weighting = exponential_lobes(lobes, means, attenuation, weighting, camera=view)
        lobes = with_weighting_gradients(lobes, means, view, background_weight=behind)
        options = {"camera": view, "background": background, "weighting": weighting}
        return render_sortfree(means, quats, scales, lobes, sh, **options).image

    assert torch.autograd.gradcheck(image, (means, lobes, attenuation, behind))
    grads = torch.autograd.grad(image(means, lobes, attenuation, behind).square().sum(), behind)
    assert grads[0] != 0


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_weights_and_gradients_are_finite_at_every_depth(dtype: torch.dtype) -> None:
    depths = torch.tensor([-3.0, 0, 1e-30, 1e-6, 1, 1e3, 1e30], dtype=dtype, requires_grad=True)
    for sigma, beta in ((1e-3, 0.1), (1.0, 1.0), (1e3, 8.0)):
        attenuation = torch.tensor([sigma, beta], dtype=dtype).log().repeat(7, 1).requires_grad_()
        w = exponential_weights(depths, attenuation)
        assert ((w >= 0) & (w <= 1)).all() and (w.diff() <= 0).all()
        assert w[1] == 1 or beta == 0.1  # 0^0.1 is slow to reach 0
        grads = torch.autograd.grad(w.sum(), (depths, attenuation))
        assert all(grad.isfinite().all() for grad in grads)
    assert w[-1] == 0


def test_a_detached_weight_is_a_constant_for_means() -> None:
    (means, _, _, lobes, _), view = gradcheck_scene(SORTFREE)
    attenuation = torch.zeros(len(means), 2, dtype=torch.float64, requires_grad=True)
    weighting = replace(EQUATION_1, detached=True)
    given, _ = exponential_lobes(lobes.detach(), means, attenuation, weighting, camera=view)
    found, learned = torch.autograd.grad(
        given.square().sum(), (means, attenuation), allow_unused=True
    )
    assert found is None and learned.any()


def test_a_scene_with_a_network_gives_visible_gaussians_their_own_weights() -> None:
    gaussians, generator = blobs(), torch.Generator().manual_seed(4)
    network = ViewNetwork(generator)
    attenuation = torch.randn(50, 2, generator=generator)
    scene = Scene(
        gaussians, "sortfree", network=network, weighting=EQUATION_1, attenuation=attenuation
    )
    up, eye = torch.tensor([0.0, 0, 1]), torch.tensor([0.1, 0.4, 0.0])
    view = Camera(look_at(eye, torch.zeros(3), up), cameras()[0].K, 24, 24)  # inside: some behind
    depths = gaussians.means @ view.viewmat[2, :3] + view.viewmat[2, 3]
    assert 5 < (depths < 0).sum() < 45
    with torch.no_grad():
        directions = torch.nn.functional.normalize(gaussians.means - view.position, dim=1)
        lobes = network(gaussians, directions)
        expected = replace(scene, network=None, lobes=lobes).render(view).image
        torch.testing.assert_close(scene.render(view).image, expected, rtol=1e-5, atol=1e-6)
        others = replace(scene, attenuation=attenuation.flip(0)).render(view).image
    assert (others - expected).abs().max() > 0.01


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
def test_renderers_refuse_it_without_its_parameters(dtype: torch.dtype) -> None:
    inputs, view = gradcheck_scene(SORTFREE)
    inputs, view = [t.to(dtype) for t in inputs], view.to(torch.device("cpu"), dtype)
    with pytest.raises(InputError, match="exponential_lobes"):
        render_sortfree(*inputs, camera=view, weighting=EQUATION_1)
    with pytest.raises(InputError, match="attenuation"):
        Scene(blobs(), "sortfree", weighting=EQUATION_1).render(cameras()[0])


def test_a_file_cannot_hold_it() -> None:
    with pytest.raises(InputError, match="cannot hold the weighting 'exponential'"):
        pack(replace(make_scene(Case(20)), weighting=EQUATION_1))


def test_an_infinite_sigma_of_the_linear_form_leaves_phi() -> None:
    phi = torch.tensor([0.0, 0.3, 2.0])
    weighting = Weighting("sort_free_gs", sigma=math.inf)
    assert torch.equal(weighting.weights(torch.tensor([0.1, 1, 1e9]), phi, phi), phi)
