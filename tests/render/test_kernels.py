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
    INVALID,
    RENDERERS,
    input_names,
    settings_of,
)
from tests.support.kernels import (
    CASES_OF_OTHERS,
    EVERYTHING,
    OTHERS,
    check_invalid_values,
    compare_with_reference,
    render_all,
)
from tests.support.scenes import (
    SORTED,
    SORTFREE,
    as_float32,
    camera,
    cotangents,
    near_threshold,
    random_scene,
)


@pytest.mark.parametrize("renderer", EVERYTHING)
@pytest.mark.parametrize("case", CASES)
def test_the_kernel_agrees_with_the_reference(case, renderer):
    compare_with_reference(case, renderer)


@pytest.mark.parametrize("renderer", OTHERS)
@pytest.mark.parametrize("case", CASES_OF_OTHERS)
def test_every_weighting_and_footprint_agrees_with_the_reference(case, renderer):
    compare_with_reference(case, renderer)


@pytest.mark.parametrize("level", ["v4", "v3", "v2", "portable"])
def test_every_built_instruction_set_agrees(level, monkeypatch):
    if not binding.BUILDS[level] <= binding.cpu_flags() or binding.built_library(level) is None:
        pytest.skip(f"needs a CPU that runs {level}")
    library = cpu.library(level)
    monkeypatch.setattr(cpu, "library", lambda: library)
    for renderer in EVERYTHING:
        compare_with_reference("random, degree 3", renderer)
        compare_with_reference("several tiles", renderer, channels=3)
        compare_with_reference("around the camera", renderer, pose=True)


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs", "depth_pass"])
@pytest.mark.parametrize("bad", INVALID)
def test_a_gaussian_with_a_value_that_is_not_finite_is_left_out(bad, renderer):
    check_invalid_values(bad, renderer, pose=True, dtype=torch.float64, backend="reference")
    check_invalid_values(bad, renderer, pose=True)


def test_permuting_the_gaussians_leaves_the_sortfree_image_unchanged():
    scene, view = CASES["several tiles"]
    scene, view = {k: v.float() for k, v in scene.items()}, view.to(dtype=torch.float32)
    order = torch.randperm(150, generator=torch.Generator().manual_seed(0))
    options = {"camera": view, "background": torch.zeros(3)}
    first = render_sortfree(*[scene[n] for n in SORTFREE], **options)
    second = render_sortfree(*[scene[n][order] for n in SORTFREE], **options)
    torch.testing.assert_close(first.image, second.image, rtol=0, atol=2e-6)
    torch.testing.assert_close(first.alpha, second.alpha, rtol=0, atol=2e-6)


@pytest.mark.parametrize("renderer", EVERYTHING)
def test_results_do_not_depend_on_the_number_of_threads(renderer):
    scene, view = random_scene(3000, seed=3), camera(160, 120)
    results = []
    before = torch.get_num_threads()
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        results.append(render_all(scene, view, renderer))
    torch.set_num_threads(before)
    for other in results[1:]:
        for name, value in other.items():
            assert torch.equal(value, results[0][name]), name


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
        cpu.CpuRaster.apply(view, None, None, False, *[scene[name] for name in names])
