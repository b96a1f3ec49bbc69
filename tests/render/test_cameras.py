"""Several cameras in one call."""

import inspect
from dataclasses import replace

import pytest
import torch

import mobilegs.render
from mobilegs.errors import InputError
from mobilegs.render import render_sorted, render_sortfree
from tests.support.golden import turned_around
from tests.support.scenes import SORTED, SORTFREE, camera, random_scene

RENDER = {"sorted": (render_sorted, SORTED), "sortfree": (render_sortfree, SORTFREE)}


def views(count: int, dtype: torch.dtype = torch.float32):
    base = camera().to(dtype=dtype)
    return [turned_around(base, 0.4 * i) for i in range(count)]


@pytest.mark.parametrize("backend", ["reference", "kernel"])
@pytest.mark.parametrize("kind", RENDER)
@pytest.mark.parametrize("count", [1, 3])
def test_outputs_are_stacked_and_gradients_add_up(kind, count, backend):
    render, names = RENDER[kind]
    scene, cameras = random_scene(40, seed=1), views(count)
    options = {"depth": True, "backend": backend, "background": torch.tensor([0.1, 0.2, 0.3])}
    outputs, grads = [], []
    for together in (True, False):
        leaves = [scene[name].float().requires_grad_() for name in names]
        posed = [replace(c, viewmat=c.viewmat.clone().requires_grad_()) for c in cameras]
        if together:
            found = render(*leaves, camera=posed, **options)
        else:
            single = [render(*leaves, camera=view, **options) for view in posed]
            found = [torch.stack(parts) for parts in zip(*single, strict=True)]
        image, alpha, depth, radii = found
        (image.square().sum() + depth.sum() + alpha.sum()).backward()
        outputs.append(found)
        grads.append([leaf.grad for leaf in leaves] + [view.viewmat.grad for view in posed])
        assert image.shape == (count, 37, 45, 3) and radii.shape == (count, 40)
        assert alpha.shape == depth.shape == (count, 37, 45)
    for output, expected in zip(*outputs, strict=True):
        assert torch.equal(output, expected)
    for grad, expected in zip(*grads, strict=True):
        torch.testing.assert_close(grad, expected, rtol=1e-4, atol=1e-3)


def test_each_camera_has_its_screen_gradients():
    scene, cameras = random_scene(40, seed=3), views(2)
    leaves = [scene[name].float().requires_grad_() for name in SORTED]
    found = torch.full((2, 40, 2), float("nan"))
    render_sorted(*leaves, camera=cameras, screen_grads=found).image.square().sum().backward()
    for view, of_view in zip(cameras, found, strict=True):
        expected = torch.zeros(40, 2)
        render_sorted(*leaves, camera=view, screen_grads=expected).image.square().sum().backward()
        assert torch.equal(of_view, expected) and (expected != 0).any()


@pytest.mark.parametrize(
    ("cameras", "options", "message"),
    [
        ([], {}, "at least one"),
        (torch.eye(4)[None], {}, r"Camera\(viewmat, K, width, height\)"),
        ([camera(), camera(40, 30)], {}, "45x37, 40x30"),
        ([camera()], {"screen_grads": torch.zeros(5, 2)}, r"\[1, 5, 2\]"),
    ],
)
def test_cameras_that_do_not_fit_are_refused(cameras, options, message, monkeypatch):
    scene = random_scene(5)
    flat = [scene[name].float() for name in SORTED]
    # without the tests' own check of annotations
    monkeypatch.setattr(mobilegs.render, "_render", inspect.unwrap(mobilegs.render._render))
    with pytest.raises(InputError, match=message):
        inspect.unwrap(render_sorted)(*flat, camera=cameras, **options)


@pytest.mark.parametrize("backend", ["reference", "kernel", "cuda"])
@pytest.mark.parametrize("kind", RENDER)
def test_gaussians_from_the_far_plane_on_are_not_rendered(kind, backend, request):
    if backend == "cuda":
        request.getfixturevalue("on_host")
    render, names = RENDER[kind]
    scene, view = random_scene(60, seed=5), camera().to(dtype=torch.float32)
    tensors = [scene[name].float() for name in names]
    depths = view.depths(tensors[0])
    far = float(depths.median()) + 1e-4
    options = {"backend": "reference" if backend == "reference" else "kernel"}
    found = render(*tensors, camera=replace(view, far=far), **options)
    nearer = depths < far
    cut = render(*[tensor[nearer] for tensor in tensors], camera=view, **options)
    torch.testing.assert_close(found.image, cut.image, rtol=1e-5, atol=1e-6)
    assert not found.radii[~nearer].any() and found.radii[nearer].any()
    assert not torch.equal(found.image, render(*tensors, camera=view, **options).image)
