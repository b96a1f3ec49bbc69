"""The CPU kernels against the float64 reference: every output and every gradient."""

import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.render import render_sorted, render_sortfree
from mobilegs.render.inputs import RenderSettings
from mobilegs.render.kernels import cpu
from mobilegs.render.kernels.kernel_view import kernel_view
from tests.support.golden import (
    BASE,
    CASES,
    DETACHED,
    INVALID,
    RENDERERS,
    input_names,
    settings_of,
    with_rows,
)
from tests.support.kernels import compare_with_reference
from tests.support.scenes import (
    SORTED,
    SORTFREE,
    as_float32,
    camera,
    cotangents,
    near_threshold,
    random_scene,
    render_with_grads,
)


@pytest.mark.parametrize("renderer", [*RENDERERS, *DETACHED])
@pytest.mark.parametrize("case", CASES)
def test_the_kernel_agrees_with_the_reference(case, renderer):
    compare_with_reference(case, renderer)


@pytest.mark.parametrize("build", ["v4", "v3", "v2", "portable"])
def test_every_built_instruction_set_agrees(build, monkeypatch):
    if not binding.BUILDS[build] <= binding.cpu_flags():
        pytest.skip(f"needs a CPU that runs {build}")
    if binding.built_library(build) is None:
        pytest.skip(f"needs a CPU that runs {build}")
    library = cpu.library(build)
    monkeypatch.setattr(cpu, "library", lambda: library)
    for case in ("random, degree 3", "several tiles", "around the camera"):
        for renderer in ("sorted", "mobile_gs", "two_pass", "all"):
            compare_with_reference(case, renderer)
            compare_with_reference(case, renderer, channels=3)


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs", "two_pass"])
@pytest.mark.parametrize("bad", INVALID)
def test_a_gaussian_with_a_value_that_is_not_finite_is_left_out(bad, renderer):
    render, options = RENDERERS[renderer]
    view, scene = camera(), as_float32(BASE)
    broken = with_rows(scene, **INVALID[bad])
    rows = torch.ones(60, dtype=torch.bool)
    rows[next(iter(INVALID[bad].values()))[0]] = False
    rest = {name: value[rows] for name, value in scene.items()}
    given = {"cotangents": cotangents(view), **options}
    for dtype, backend in ((torch.float64, "reference"), (torch.float32, "kernel")):
        expected = render_with_grads(render, rest, view, dtype=dtype, backend=backend, **given)
        found = render_with_grads(render, broken, view, dtype=dtype, backend=backend, **given)
        for name, value in expected[0].items():
            torch.testing.assert_close(found[0][name], value, rtol=1e-5, atol=1e-6)
        for name, value in expected[1].items():
            torch.testing.assert_close(found[1][name][rows], value, rtol=1e-5, atol=1e-6)
            assert (found[1][name][~rows] == 0).all(), name


@pytest.mark.parametrize("backend", ["reference", "kernel"])
def test_a_pixel_without_gaussians_shows_the_background(backend):
    scene, view = (
        {k: v.float() for k, v in CASES["nothing in view"][0].items()},
        camera().to(dtype=torch.float32),
    )
    background = torch.tensor([0.3, 0.5, 0.7])
    options = {"camera": view, "background": background, "backend": backend, "depth": True}
    for rendered in (
        render_sorted(*[scene[name] for name in SORTED], **options),
        render_sortfree(*[scene[name] for name in SORTFREE], **options),
    ):
        assert torch.equal(rendered.image, background.expand(view.height, view.width, 3))
        assert (
            (rendered.alpha == 0).all()
            and (rendered.depth == 0).all()
            and (rendered.radii == 0).all()
        )


def test_permuting_the_gaussians_leaves_the_sortfree_image_unchanged():
    scene, view = CASES["several tiles"]
    scene, view = {k: v.float() for k, v in scene.items()}, view.to(dtype=torch.float32)
    order = torch.randperm(150, generator=torch.Generator().manual_seed(0))
    options = {"camera": view, "background": torch.zeros(3)}
    first = render_sortfree(*[scene[n] for n in SORTFREE], **options)
    second = render_sortfree(*[scene[n][order] for n in SORTFREE], **options)
    torch.testing.assert_close(first.image, second.image, rtol=0, atol=2e-6)
    torch.testing.assert_close(first.alpha, second.alpha, rtol=0, atol=2e-6)


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs", "two_pass", "all"])
def test_results_do_not_depend_on_the_number_of_threads(renderer):
    scene, view = random_scene(3000, seed=3), camera(160, 120)
    render, options = RENDERERS[renderer]
    given = {"cotangents": cotangents(view), **options}
    results = []
    before = torch.get_num_threads()
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        results.append(
            render_with_grads(render, scene, view, dtype=torch.float32, backend="kernel", **given)
        )
    torch.set_num_threads(before)
    for outputs, grads in results[1:]:
        for name, value in (*outputs.items(), *grads.items()):
            assert torch.equal(value, {**results[0][0], **results[0][1]}[name]), name


def test_screen_gradients_are_those_of_the_projected_means():
    scene, view = as_float32(random_scene(50, seed=4)), camera()
    for renderer in ("sorted", "mobile_gs", "all"):
        render, options = RENDERERS[renderer]
        names = input_names(renderer)
        tangents = cotangents(
            view, avoid=near_threshold(scene, view, names=names, settings=settings_of(renderer))
        )
        leaves = {name: scene[name].float().requires_grad_() for name in names}
        screen = torch.full((50, 2), float("nan"))
        rendered = render(
            *leaves.values(),
            camera=view.to(dtype=torch.float32),
            background=torch.zeros(3),
            screen_grads=screen,
            **options,
        )
        (rendered.image * tangents["image"].float()).sum().backward()
        # moving the principal point moves every mean: the sum of all must agree
        step, totals = 1e-4, []
        for axis in range(2):
            values = []
            for sign in (1, -1):
                k = view.K.clone()
                k[axis, 2] += sign * step
                shifted = Camera(view.viewmat, k, view.width, view.height)
                moved = render(
                    *[scene[name] for name in names],
                    camera=shifted,
                    background=torch.zeros(3, dtype=torch.float64),
                    **options,
                )
                values.append((moved.image * tangents["image"]).sum().item())
            totals.append((values[0] - values[1]) / (2 * step))
        torch.testing.assert_close(screen.sum(0), torch.tensor(totals), rtol=5e-3, atol=5e-3)


def test_an_image_too_large_for_the_kernels_is_refused():
    scene, view = {k: v.float() for k, v in BASE.items()}, camera(40000, 2)
    with pytest.raises(InputError, match="40000x2"):
        render_sorted(
            *[scene[n] for n in SORTED],
            camera=view.to(dtype=torch.float32),
            background=torch.zeros(3),
        )


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("quats", lambda t: t.double(), "float32"),
        ("sh", lambda t: t[:, :2], "expected"),
        ("lobes", lambda t: t[:-1], "expected"),
        ("lobes", lambda t: None, "lobes"),
    ],
)
def test_inputs_of_the_wrong_shape_or_type_are_refused(name, change, message):
    scene: dict = {k: v.float() for k, v in BASE.items()}
    view = kernel_view(camera(), torch.zeros(3), RenderSettings(), sh_size=4, lobe_size=9)
    scene[name] = change(scene[name])
    scene["opacities"] = None
    with pytest.raises(InputError, match=message):
        names = (*SORTED, "lobes")
        cpu.CpuRaster.apply(view, None, False, *[scene[name] for name in names])
