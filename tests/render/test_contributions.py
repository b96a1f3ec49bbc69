"""Contributions: the reference on cases with known results, the kernel against the reference."""

import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.render import Backend, measure_contributions, render_sorted
from mobilegs.render.kernels import cpu
from tests.support.contributions import assert_agrees, compare_case, kernel_inputs
from tests.support.golden import BASE, CASES, INVALID, finite_rows, with_rows
from tests.support.scenes import SORTED, as_float32, camera, random_scene

BOTH = ["reference", "kernel"]


def measured(scene, view, backend: Backend = "reference"):
    dtype = torch.float64 if backend == "reference" else torch.float32
    flat = [scene[name].to(dtype) for name in SORTED[:4]]
    return measure_contributions(*flat, camera=view.to(dtype=dtype), backend=backend)


def row_of_two(first: float, second: float) -> tuple[dict, Camera]:
    """Return two flat Gaussians in a camera of one pixel, the first (index 1) in front."""
    view = Camera(torch.eye(4).double(), torch.eye(3).double() * 0.5, 1, 1)
    scene = {
        "means": torch.tensor([[0.0, 0, 3], [0, 0, 2]]).double(),
        "quats": torch.tensor([[1.0, 0, 0, 0]]).double().expand(2, 4),
        "scales": torch.full((2, 3), 50.0).double(),
        "opacities": torch.tensor([second, first], dtype=torch.float64),
    }
    k = view.K.clone()
    k[:2, 2], k[2, 2] = 0.5, 1
    return scene, Camera(view.viewmat, k, 1, 1)


@pytest.mark.parametrize("case", CASES)
def test_the_kernel_agrees_with_the_reference(case):
    compare_case(case, cpu.measure_contributions)


@pytest.mark.parametrize("backend", BOTH)
def test_two_gaussians_in_a_pixel_have_the_expected_shares(backend):
    found = measured(*row_of_two(0.25, 0.5), backend)
    torch.testing.assert_close(found.weights.double(), torch.tensor([0.375, 0.25]).double())
    assert found.touched.tolist() == [1, 1] and found.largest.tolist() == [1, 0]
    assert found.winner.tolist() == [[0]]
    torch.testing.assert_close(found.alpha.double(), torch.tensor([[0.625]]).double())


def test_the_nearer_of_two_equal_shares_wins():
    pairs = [(a / 97, a / (97 - a)) for a in range(10, 40)]
    scene, view = row_of_two(*next((a, b) for a, b in pairs if b * (1 - a) == a))
    found = measured(scene, view)
    assert found.weights[0] == found.weights[1] and found.winner.tolist() == [[1]]


@pytest.mark.parametrize("backend", BOTH)
@pytest.mark.parametrize("bad", [name for name in INVALID if name != "NaN colour"])
def test_a_gaussian_with_a_value_that_is_not_finite_has_no_share(bad, backend):
    scene, view = as_float32(BASE), camera()
    rows = finite_rows(bad)
    expected = measured({name: value[rows] for name, value in scene.items()}, view, backend)
    found = measured(with_rows(scene, **INVALID[bad]), view, backend)
    torch.testing.assert_close(found.weights[rows], expected.weights)
    assert torch.equal(found.touched[rows], expected.touched)
    assert (found.weights[~rows] == 0).all() and (found.largest[~rows] == 0).all()


@pytest.mark.parametrize("backend", BOTH)
def test_shares_add_up_to_the_alpha_of_the_image(backend):
    scene, view = as_float32(random_scene(80, seed=2)), camera()
    found = measured(scene, view, backend)
    dtype = found.alpha.dtype
    flat = [scene[name].to(dtype) for name in SORTED]
    given = {"camera": view.to(dtype=dtype), "background": torch.zeros(3, dtype=dtype)}
    torch.testing.assert_close(found.alpha, render_sorted(*flat, **given).alpha)
    torch.testing.assert_close(found.weights.sum(), found.alpha.sum())
    assert found.largest.sum() == (found.winner >= 0).sum()
    assert (found.largest <= found.touched).all()


def test_results_do_not_depend_on_the_number_of_threads():
    scene, view = random_scene(3000, seed=3), camera(160, 120)
    before, found = torch.get_num_threads(), []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        found.append(measured(scene, view, "kernel"))
    torch.set_num_threads(before)
    for other in found[1:]:
        assert all(torch.equal(a, b) for a, b in zip(found[0], other, strict=True))


@pytest.mark.parametrize("build", ["v4", "v3", "v2", "portable"])
def test_every_built_instruction_set_agrees(build, monkeypatch):
    if not binding.BUILDS[build] <= binding.cpu_flags() or binding.built_library(build) is None:
        pytest.skip(f"needs a CPU that runs {build}")
    library = cpu.library(build)
    monkeypatch.setattr(cpu, "library", lambda: library)
    for case in ("several tiles", "around the camera", "opaque"):
        compare_case(case, cpu.measure_contributions)


def test_long_lists_agree():
    scene, view = as_float32(random_scene(400, seed=5)), camera(61, 47)
    scene["scales"][:3] = 3.0
    view = view.to(dtype=torch.float32).to(dtype=torch.float64)
    struct, inputs = kernel_inputs(scene, view)
    assert_agrees(cpu.measure_contributions(struct, *inputs), scene, view)


def test_inputs_of_the_wrong_shape_are_refused():
    struct, inputs = kernel_inputs(BASE, camera())
    inputs[3] = inputs[3][:-1]
    with pytest.raises(InputError, match="expected"):
        cpu.measure_contributions(struct, *inputs)
