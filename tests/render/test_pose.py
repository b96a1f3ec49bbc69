"""Gradients with respect to the camera's pose."""

from dataclasses import replace

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render import Backend, Weighting, render_sorted, render_sortfree
from mobilegs.render.scene import Scene
from tests.support.golden import CASES, DETACHED, RENDERERS
from tests.support.golden import view_network as make_network
from tests.support.kernels import compare_with_reference
from tests.support.scenes import (
    SORTED,
    SORTFREE,
    as_float32,
    camera,
    cotangents,
    gradcheck_scene,
    hold_visibility,
    random_scene,
    render_with_grads,
)

BOTH: list[tuple[Backend, torch.dtype]] = [("reference", torch.float64), ("kernel", torch.float32)]


def moved(view, twist):
    """Return the camera after a rigid motion: six numbers, a translation and a rotation vector."""
    zero = twist.new_zeros(())
    x, y, z, a, b, c = twist
    rows = [[zero, -c, b, x], [c, zero, -a, y], [-b, a, zero, z], [zero] * 4]
    generator = torch.stack([torch.stack(row) for row in rows])
    return replace(view, viewmat=torch.linalg.matrix_exp(generator) @ view.viewmat.to(twist))


def test_the_pose_of_a_sorted_image_passes_gradcheck():
    inputs, view = gradcheck_scene(SORTED, degree=3)
    inputs = [t.detach() for t in inputs]

    def outputs(twist):
        found = render_sorted(*inputs, camera=moved(view, twist), depth=True)
        assert found.depth is not None
        return found.image, found.alpha, found.depth

    twist = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(outputs, twist)


@pytest.mark.parametrize("name", ["mobile_gs", "depth_pass"])
def test_the_pose_of_a_sortfree_image_passes_gradcheck(name, monkeypatch):
    hold_visibility(monkeypatch)
    inputs, view = gradcheck_scene(SORTFREE, lobe_degree=2)
    inputs = [t.detach() for t in inputs]
    options = {"weighting": Weighting(name, sigma=6.0, background_weight=0.4), "depth": True}

    def outputs(twist):
        found = render_sortfree(*inputs, camera=moved(view, twist), **options)
        assert found.depth is not None
        return found.image, found.alpha, found.depth

    twist = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(outputs, twist)


@pytest.mark.parametrize("renderer", [*RENDERERS, *DETACHED])
def test_the_kernel_agrees_with_the_reference(renderer):
    compare_with_reference("both of degree 3", renderer, pose=True)


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
@pytest.mark.parametrize("case", CASES)
def test_the_kernel_agrees_in_every_case(case, renderer):
    compare_with_reference(case, renderer, pose=True)


@pytest.mark.parametrize("renderer", ["sorted", "depth_pass"])
def test_the_pose_has_a_gradient_with_features(renderer):
    compare_with_reference("several tiles", renderer, channels=5, pose=True)


@pytest.mark.parametrize(("backend", "dtype"), BOTH)
def test_the_gradient_points_along_rigid_motions(backend, dtype):
    scene, view = as_float32(random_scene(40, seed=11)), camera()
    given = {"cotangents": cotangents(view), "dtype": dtype, "backend": backend, "pose": True}
    grad = render_with_grads(render_sorted, scene, view, **given)[1]["viewmat"]
    along = view.viewmat[:3, :3].T @ grad[:3, :3]
    torch.testing.assert_close(along, -along.T, rtol=1e-4, atol=1e-4 * grad.abs().max().item())
    assert (grad[3] == 0).all() and (grad[:3, 3] != 0).all()


def test_a_scene_with_a_network_has_a_gradient_of_the_pose():
    scene = as_float32(random_scene(40, degree=1, seed=12))
    logits = scene["opacities"].logit()
    gaussians = Gaussians(
        scene["means"], scene["quats"], scene["scales"].log(), logits, scene["sh"]
    )
    view = camera().to(dtype=torch.float32)
    target = cotangents(view)["image"]

    def loss(twist):
        dtype = twist.dtype
        parts = {"network": make_network().to(dtype), "background": torch.zeros(3, dtype=dtype)}
        drawn = Scene(gaussians.to(dtype=dtype), "sortfree", **parts)
        return (drawn.render(moved(view.to(dtype=dtype), twist)).image * target.to(dtype)).sum()

    kernel, exact = (torch.zeros(6, dtype=dtype, requires_grad=True) for _, dtype in BOTH[::-1])
    (grad,), (expected,) = (torch.autograd.grad(loss(twist), twist) for twist in (kernel, exact))
    assert (grad.double() - expected).norm() < 1e-3 * expected.norm()
    at = 1e-5 * torch.eye(6, dtype=torch.float64)[1]
    with torch.no_grad():
        difference = (loss(at) - loss(-at)) / 2e-5
    assert expected[1].item() == pytest.approx(difference.item(), rel=1e-2)


def test_intrinsics_that_require_gradients_are_refused():
    scene, view = random_scene(5), camera().to(dtype=torch.float32)
    view = replace(view, K=view.K.clone().requires_grad_())
    inputs = [scene[name].float() for name in SORTED]
    with pytest.raises(InputError, match=r"camera\.K"):
        render_sorted(*inputs, camera=view)
    with torch.no_grad():
        render_sorted(*inputs, camera=view)


def test_a_background_that_requires_gradients_is_refused_by_the_kernels():
    scene, view = random_scene(5), camera()
    background = torch.zeros(3, dtype=torch.float64, requires_grad=True)
    render_sorted(
        *[scene[name] for name in SORTED], camera=view, background=background
    ).image.sum().backward()
    assert background.grad is not None and (background.grad > 0).all()
    flat = [scene[name].float() for name in SORTED]
    with pytest.raises(InputError, match="background"):
        render_sorted(
            *flat,
            camera=view.to(dtype=torch.float32),
            background=background.detach().float().requires_grad_(),
        )
