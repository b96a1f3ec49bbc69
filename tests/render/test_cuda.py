"""The CUDA kernels on a GPU, against the float64 reference on the CPU."""

import pytest
import torch

from mobilegs.render import measure_contributions, render_sorted, visible_rows
from mobilegs.render.kernels import cuda
from mobilegs.render.kernels.list_lengths import ListLengths
from tests.support.contributions import compare_case
from tests.support.golden import CASES, INVALID, RENDERERS, input_names
from tests.support.kernels import (
    CASES_OF_OTHERS,
    EVERYTHING,
    OTHERS,
    check_invalid_values,
    check_lists_without_room,
    compare_with_reference,
    render_all,
)
from tests.support.scenes import (
    SORTED,
    as_float32,
    camera,
    random_scene,
)

pytestmark = [
    pytest.mark.gpu,
    pytest.mark.skipif(not torch.cuda.is_available(), reason="needs an NVIDIA GPU"),
]
BOTH = ["sorted", "mobile_gs"]


@pytest.mark.parametrize("renderer", EVERYTHING)
@pytest.mark.parametrize("case", CASES)
def test_the_cuda_kernel_agrees_with_the_reference(case, renderer):
    compare_with_reference(case, renderer, device="cuda")


@pytest.mark.parametrize("renderer", OTHERS)
@pytest.mark.parametrize("case", CASES_OF_OTHERS)
def test_every_weighting_and_footprint_agrees_with_the_reference(case, renderer):
    compare_with_reference(case, renderer, device="cuda")


@pytest.mark.parametrize("renderer", BOTH)
@pytest.mark.parametrize("channels", [1, 3, 5])
def test_colors_in_place_of_harmonics_agree(channels, renderer):
    compare_with_reference("several tiles", renderer, device="cuda", channels=channels)


@pytest.mark.parametrize("renderer", BOTH)
@pytest.mark.parametrize("case", ["both of degree 3", "around the camera"])
def test_gradients_of_the_pose_agree(case, renderer):
    compare_with_reference(case, renderer, device="cuda", pose=True)


@pytest.mark.parametrize("renderer", BOTH)
@pytest.mark.parametrize("bad", INVALID)
def test_a_gaussian_with_a_value_that_is_not_finite_is_left_out(bad, renderer):
    check_invalid_values(bad, renderer, device="cuda")


@pytest.mark.parametrize("renderer", BOTH)
def test_a_large_scene_agrees_with_the_cpu_kernels(renderer):
    scene, view = as_float32(random_scene(30_000, seed=21)), camera(640, 427)
    scene["scales"][:5] = 3.0  # boxes large enough for a whole block
    scene["scales"][5:] *= 0.3
    found, expected = (render_all(scene, view, renderer, device=d) for d in ("cuda", "cpu"))
    for name, value in expected.items():
        error = (found[name] - value).norm() / value.norm()
        print(f"{name:10s} relative L2 {error:.2e}")
        assert error < 1e-3, name


@pytest.mark.parametrize("renderer", [*BOTH, "depth_pass"])
def test_two_runs_give_the_same_bits(renderer):
    scene, view = as_float32(random_scene(30_000, seed=22)), camera(640, 427)
    scene["scales"][:5] = 3.0
    first = render_all(scene, view, renderer, device="cuda")
    for _ in range(3):
        for name, value in render_all(scene, view, renderer, device="cuda").items():
            assert torch.equal(value, first[name]), name


@pytest.mark.parametrize("renderer", EVERYTHING)
def test_lists_without_room_change_neither_image_nor_gradients(renderer):
    kernels = cuda.kernels_for(torch.empty(0, device="cuda"))
    check_lists_without_room(renderer, lambda: setattr(kernels, "lengths", ListLengths()), "cuda")


@pytest.mark.parametrize("renderer", BOTH)
def test_a_known_view_waits_for_nothing(renderer):
    scene = {name: value.float().to("cuda") for name, value in random_scene(3000, seed=27).items()}
    render, options = RENDERERS[renderer]
    leaves = [scene[name].requires_grad_() for name in input_names(renderer)]
    view, grad = camera().to("cuda", torch.float32), torch.ones(37, 45, 3, device="cuda")
    for waits in ("default", "error"):
        torch.cuda.set_sync_debug_mode(waits)
        try:
            render(*leaves, camera=view, **options).image.backward(grad)
        finally:
            torch.cuda.set_sync_debug_mode("default")


@pytest.mark.parametrize("renderer", BOTH)
def test_another_stream_gives_the_same_image(renderer):
    scene, view = as_float32(random_scene(3000, seed=23)), camera(160, 120)
    first = render_all(scene, view, renderer, device="cuda")
    stream = torch.cuda.Stream()
    stream.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(stream):
        second = render_all(scene, view, renderer, device="cuda")
    stream.synchronize()
    for name, value in first.items():
        assert torch.equal(value, second[name]), name


def test_visible_rows_are_the_same_as_on_the_cpu():
    scene = {n: v.float() for n, v in random_scene(3000, seed=24, spread=4.0).items()}
    flat, view = [scene[n] for n in SORTED[:3]], camera().to(dtype=torch.float32)
    found = visible_rows(*[t.to("cuda") for t in flat], camera=view)
    assert torch.equal(found.cpu(), visible_rows(*flat, camera=view))


def test_a_camera_on_the_gpu_gives_the_same_image():
    scene = {n: v.float().to("cuda") for n, v in random_scene(300, seed=25).items()}
    flat, view = [scene[n] for n in SORTED], camera().to(dtype=torch.float32)
    background = torch.zeros(3, device="cuda")
    first = render_sorted(*flat, camera=view, background=background)
    second = render_sorted(*flat, camera=view.to("cuda"), background=background)
    assert torch.equal(first.image, second.image)


@pytest.mark.parametrize("case", CASES)
def test_contributions_agree_with_the_reference(case):
    compare_case(case, cuda.measure_contributions, device="cuda")


def test_contributions_are_reproducible_and_close_to_those_of_the_cpu():
    scene = {n: v.float() for n, v in random_scene(30_000, seed=26).items()}
    scene["scales"] *= 0.3
    flat, view = [scene[n] for n in SORTED[:4]], camera(640, 427).to(dtype=torch.float32)
    on_gpu = [t.to("cuda") for t in flat]
    first, again = (measure_contributions(*on_gpu, camera=view) for _ in range(2))
    assert all(torch.equal(a, b) for a, b in zip(first, again, strict=True))
    expected = measure_contributions(*flat, camera=view)
    torch.testing.assert_close(first.weights.cpu(), expected.weights, rtol=1e-3, atol=1e-2)
    assert (first.winner.cpu() != expected.winner).float().mean() < 1e-3
