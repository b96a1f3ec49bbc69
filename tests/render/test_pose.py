"""Gradients with respect to the camera's pose."""

from dataclasses import replace

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render import Backend, Weighting, render_sorted, render_sortfree
from mobilegs.render.scene import Scene
from mobilegs.render.sortfree import WEIGHTINGS
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


@pytest.mark.parametrize("name", WEIGHTINGS)
def test_the_pose_of_a_sortfree_image_passes_gradcheck(name):
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


@pytest.mark.parametrize("renderer", ["sorted", "two_pass"])
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


@pytest.mark.parametrize(("backend", "dtype"), BOTH)
def test_a_scene_with_a_network_has_a_gradient_of_the_pose(backend, dtype):
    scene = as_float32(random_scene(40, degree=1, seed=12))
    logits = scene["opacities"].logit()
    parts = (scene["means"], scene["quats"], scene["scales"].log(), logits, scene["sh"])
    gaussians = Gaussians(*parts).to(dtype=dtype)
    network = make_network().to(dtype)
    background = torch.zeros(3, dtype=dtype)
    drawn = Scene(gaussians, "sortfree", network=network, background=background)
    view = camera().to(dtype=torch.float32).to(dtype=dtype)
    target = cotangents(view)["image"].to(dtype)
    twist = torch.zeros(6, dtype=dtype, requires_grad=True)
    (drawn.render(moved(view, twist)).image * target).sum().backward()
    step, at = 1e-5, torch.zeros(6, dtype=torch.float64)
    at[1] = step
    if dtype == torch.float64:
        ends = [
            (drawn.render(moved(view, sign * at)).image * target).sum().item() for sign in (1, -1)
        ]
        assert twist.grad is not None
        assert twist.grad[1].item() == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-2)
    else:
        exact = Scene(
            gaussians.to(dtype=torch.float64),
            "sortfree",
            network=network.double(),
            background=background.double(),
        )
        slow = torch.zeros(6, dtype=torch.float64, requires_grad=True)
        image = exact.render(moved(view.to(dtype=torch.float64), slow)).image
        (image * target.double()).sum().backward()
        assert twist.grad is not None and slow.grad is not None
        assert (twist.grad.double() - slow.grad).norm() < 1e-3 * slow.grad.norm()


@pytest.mark.parametrize(("backend", "dtype"), BOTH)
def test_intrinsics_that_require_gradients_are_refused(backend, dtype):
    scene, view = random_scene(5), camera().to(dtype=dtype)
    view = replace(view, K=view.K.clone().requires_grad_())
    inputs = [scene[name].to(dtype) for name in SORTED]
    with pytest.raises(InputError, match=r"camera\.K"):
        render_sorted(*inputs, camera=view, backend=backend)
    with torch.no_grad():
        render_sorted(*inputs, camera=view, backend=backend)


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
