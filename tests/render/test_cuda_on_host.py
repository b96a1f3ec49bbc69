"""The CUDA kernels and their launcher, emulated on the CPU, against the reference.

The emulation shows neither races between blocks or within a warp nor the rounding of a GPU.
"""

import pytest
import torch

import mobilegs.render
from mobilegs.errors import InputError
from mobilegs.render import render_sorted
from mobilegs.render.inputs import RenderSettings
from mobilegs.render.kernels import cpu, cuda
from mobilegs.render.kernels.kernel_view import kernel_view
from tests.support.contributions import compare_case, kernel_inputs
from tests.support.cuda_on_host import COMPILER, HostKernels
from tests.support.golden import (
    BASE,
    CASES,
    INVALID,
    RENDERERS,
    input_names,
    isotropic_lobes,
    settings_of,
)
from tests.support.kernels import (
    EVERYTHING,
    OTHERS,
    check_invalid_values,
    compare_with_reference,
    render_all,
)
from tests.support.scenes import (
    SORTED,
    as_float32,
    camera,
    cotangents,
    near_threshold,
    random_scene,
)
from tests.support.selection import few


@pytest.fixture(scope="session")
def built(tmp_path_factory) -> HostKernels:
    if COMPILER is None:
        pytest.skip("needs Linux and a C++ compiler")
    return HostKernels(tmp_path_factory.mktemp("cuda_on_host"))


@pytest.fixture(autouse=True)
def kernels(built, monkeypatch):
    """Render with the emulated kernels; memory that is not written holds NaN or huge numbers."""
    monkeypatch.setattr(mobilegs.render, "_raster", lambda means: cuda.CudaRaster)
    monkeypatch.setattr(cuda, "kernels_for", lambda tensor: built)
    torch.use_deterministic_algorithms(True)
    built.launched.clear()
    yield built
    built.reverse(False)
    torch.use_deterministic_algorithms(False)


@pytest.mark.parametrize("renderer", EVERYTHING)
@pytest.mark.parametrize("case", CASES)
def test_the_cuda_kernel_agrees_with_the_reference(case, renderer):
    compare_with_reference(case, renderer)


@pytest.mark.parametrize("renderer", OTHERS)
def test_the_cuda_kernel_agrees_for_every_weighting(renderer):
    compare_with_reference("several tiles", renderer)


@pytest.mark.parametrize("renderer", EVERYTHING)
@pytest.mark.parametrize(
    ("case", "channels"), [("several tiles", 3), ("several tiles", 4), ("empty scene", 4)]
)
def test_colors_in_place_of_harmonics_agree(case, channels, renderer):
    compare_with_reference(case, renderer, channels=channels)


@pytest.mark.parametrize("renderer", EVERYTHING)
@pytest.mark.parametrize("case", ["both of degree 3", "around the camera"])
def test_gradients_of_the_pose_agree(case, renderer):
    compare_with_reference(case, renderer, pose=True)


@pytest.mark.parametrize("renderer", few(EVERYTHING, "mobile_gs"))
def test_long_lists_agree_with_the_cpu_kernels(renderer, monkeypatch):
    # several batches per tile, boxes for a whole block, tiles that finish before their lists end
    scene, view = as_float32(random_scene(1500, seed=11)), camera(96, 72)
    scene["scales"][:3] = 3.0
    scene["opacities"][3:60] = 1.0
    scene["lobes"][3:60] = isotropic_lobes(1 - 1e-15)
    unsure = near_threshold(
        scene, view, names=input_names(renderer), settings=settings_of(renderer)
    )
    tangents = cotangents(view, avoid=unsure)
    found = render_all(scene, view, renderer, cotangents=tangents)
    monkeypatch.undo()
    expected = render_all(scene, view, renderer, cotangents=tangents)
    assert not torch.equal(found["sh"], expected["sh"]), "compared with itself"
    for name, value in expected.items():
        error = found[name] - value
        if name not in input_names(renderer):
            error[unsure] = 0
        error = error.norm() / value.norm()
        print(f"{name:10s} relative L2 {error:.2e}")
        assert error < 2e-4, name


@pytest.mark.parametrize("renderer", EVERYTHING)
def test_results_do_not_depend_on_the_order_of_threads(renderer, kernels):
    scene, view = as_float32(random_scene(900, seed=12)), camera(104, 80)
    scene["scales"][:3] = 3.0
    first = render_all(scene, view, renderer)
    kernels.reverse(True)
    second = render_all(scene, view, renderer)
    for name, value in first.items():
        assert torch.equal(value, second[name]), name


@pytest.mark.parametrize("renderer", ["sorted", "all"])
@pytest.mark.parametrize("bad", INVALID)
def test_a_gaussian_with_a_value_that_is_not_finite_is_left_out(bad, renderer):
    check_invalid_values(bad, renderer)


@pytest.mark.parametrize("renderer", EVERYTHING)
def test_leaving_out_depth_does_not_change_other_results(renderer):
    scene, view = as_float32(random_scene(80, seed=13)), camera()
    render, options = RENDERERS[renderer]
    names = input_names(renderer)
    found = []
    for depth in (False, True):
        leaves = [scene[name].float().requires_grad_() for name in names]
        screen = torch.full((80, 2), float("nan"))
        given = {"camera": view.to(dtype=torch.float32), "background": torch.ones(3), **options}
        rendered = render(*leaves, depth=depth, screen_grads=screen, **given)
        assert (rendered.depth is not None) == depth
        rendered.image.square().sum().backward()
        found.append([rendered.image, rendered.alpha, screen, *[leaf.grad for leaf in leaves]])
    for without, with_depth in zip(*found, strict=True):
        torch.testing.assert_close(without, with_depth, rtol=1e-5, atol=1e-6)


def contributions_by_cuda(scene, view):
    struct, inputs = kernel_inputs(scene, view)
    return cuda.measure_contributions(struct, *inputs)


@pytest.mark.parametrize("case", CASES)
def test_contributions_agree_with_the_reference(case):
    compare_case(case, cuda.measure_contributions)


def test_contributions_of_long_lists_do_not_depend_on_the_order_of_threads(kernels):
    scene, view = as_float32(random_scene(1500, seed=16)), camera(120, 90)
    scene["scales"][:3] = 3.0
    scene["opacities"][3:60] = 1.0
    found = contributions_by_cuda(scene, view)
    kernels.reverse(True)
    for name, value in contributions_by_cuda(scene, view)._asdict().items():
        assert torch.equal(value, getattr(found, name)), name
    struct, inputs = kernel_inputs(scene, view)
    expected = cpu.measure_contributions(struct, *inputs)
    torch.testing.assert_close(found.weights, expected.weights, rtol=1e-4, atol=1e-3)
    assert (found.touched - expected.touched).abs().sum() <= 1e-4 * expected.touched.sum()
    assert (found.winner != expected.winner).float().mean() < 1e-3


def test_every_kernel_is_executed(kernels):
    scene, view = as_float32(random_scene(5)), camera()
    for depth in (False, True):
        for renderer in EVERYTHING:
            render, options = RENDERERS[renderer]
            leaves = [scene[name].float().requires_grad_() for name in input_names(renderer)]
            given = {"camera": view.to(dtype=torch.float32), "background": torch.zeros(3)}
            render(*leaves, depth=depth, **given, **options).image.sum().backward()
    contributions_by_cuda(scene, view)
    _, log = cuda.compile_kernels("sm_90")
    compiled = {line.split("'")[1] for line in log.splitlines() if "Compiling entry" in line}
    assert set(kernels.launched) == compiled


def test_radii_are_the_same_as_on_the_cpu():
    scene, view = as_float32(random_scene(300, seed=14, spread=4.0)), camera()
    flat = [scene[name].float() for name in SORTED]
    given = kernel_view(view, torch.zeros(3), RenderSettings(), sh_size=4, lobe_size=0)
    expected = cpu.project_radii(given, *flat)
    assert (expected == 0).any() and (expected > 0).any()
    torch.testing.assert_close(cuda.project_radii(given, *flat), expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("renderer", EVERYTHING)
def test_counting_a_tile_too_many_or_too_few_writes_no_other_slots(renderer, monkeypatch):
    scene, view = as_float32(random_scene(80, seed=15)), camera()
    expected = render_all(scene, view, renderer)
    project = cuda._project

    def counted(change):
        def changed(*arguments):
            splats, radii, touched, center_tiles = project(*arguments)
            return splats, radii, touched + change(touched).int(), center_tiles

        monkeypatch.setattr(cuda, "_project", changed)
        return render_all(scene, view, renderer)

    for name, value in counted(lambda touched: touched > 0).items():
        assert torch.equal(value, expected[name]), name
    found = counted(lambda touched: -(touched == touched.max()).int())
    assert all(value.isfinite().all() for value in found.values())
    # only the last tiles of the widest Gaussians lose entries
    assert not torch.equal(found["image"], expected["image"])
    assert torch.equal(found["image"][:16], expected["image"][:16])


def test_inputs_on_different_devices_are_refused():
    scene = {name: value.float() for name, value in as_float32(BASE).items()}
    scene["sh"] = scene["sh"].to("meta")
    with pytest.raises(InputError, match="meta"):
        render_sorted(
            *[scene[n] for n in SORTED],
            camera=camera().to(dtype=torch.float32),
            background=torch.zeros(3),
        )
