"""The CUDA kernels and their launcher, emulated on the CPU, against the reference.

The emulation shows neither races between blocks or within a warp nor the rounding of a GPU.
"""

from typing import Any

import pytest
import torch

from bench.steps import OperationCount
from mobilegs.errors import InputError
from mobilegs.render import render_sorted
from mobilegs.render.inputs import RenderSettings
from mobilegs.render.kernels import cpu, cuda
from mobilegs.render.kernels.kernel_view import kernel_view
from mobilegs.render.kernels.list_lengths import ROOM_MAX, ListLengths, room_for
from mobilegs.representation.rotations import RotationQuantizer
from mobilegs.representation.uniform_quantizer import UniformQuantizer
from mobilegs.train.student import cuda_terms
from tests.support.contributions import compare_case, kernel_inputs
from tests.support.cuda_on_host import HostLength
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
    check_lists_without_room,
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
from tests.support.selection import few


@pytest.fixture(autouse=True)
def kernels(on_host):
    return on_host


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


def run_terms():
    """Run the terms of the student's loss that need no image."""
    _, inputs = kernel_inputs(as_float32(random_scene(5)), camera())
    values = torch.nn.Parameter(torch.rand(5, 3))
    codes = UniformQuantizer.fit(values.detach(), step_size=0.1)
    quats = inputs[1]
    cuda_terms.add_early_rate_gradients([values], [1.0], share=1.0, least=1.0)
    cuda_terms.add_rate_gradients([codes], [values], 1.0)
    angles = RotationQuantizer.fit(quats, scales=codes, step_size=0.1)
    cuda_terms.log_step_gradient(angles, quats, 1.0)


def test_every_kernel_is_executed(kernels):
    scene, view = as_float32(random_scene(5)), camera()
    for depth in (False, True):
        for renderer in EVERYTHING:
            render, options = RENDERERS[renderer]
            leaves = [scene[name].float().requires_grad_() for name in input_names(renderer)]
            given = {"camera": view.to(dtype=torch.float32), "background": torch.zeros(3)}
            render(*leaves, depth=depth, **given, **options).image.sum().backward()
    contributions_by_cuda(scene, view)
    run_terms()
    _, log = cuda.compile_kernels("sm_90")
    compiled = {line.split("'")[1] for line in log.splitlines() if "Compiling entry" in line}
    others = ("mgs_student", "mgs_adam", "mgs_photo", "mgs_distill")
    training = {name for name in compiled if name.startswith(others)}
    assert len(training) == 11  # tests/train has their tests
    assert set(kernels.launched) == compiled - training


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
            found = project(*arguments)
            touched = found.touched + change(found.touched).int()
            groups = touched.sum(0, keepdim=True).int()  # one, of all Gaussians
            return found._replace(touched=touched, groups=groups)

        monkeypatch.setattr(cuda, "_project", changed)
        return render_all(scene, view, renderer)

    for name, value in counted(lambda touched: touched > 0).items():
        assert torch.equal(value, expected[name]), name
    found = counted(lambda touched: -(touched == touched.max()).int())
    assert all(value.isfinite().all() for value in found.values())
    # only the last tiles of the widest Gaussians lose entries
    assert not torch.equal(found["image"], expected["image"])
    assert torch.equal(found["image"][:16], expected["image"][:16])


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("bits", [1, 5, 8, 12, 17, 32])
def test_items_are_sorted_stably(bits, backward, kernels, monkeypatch):
    monkeypatch.setattr(cuda, "SORT_BLOCKS", 2)
    generator = torch.Generator().manual_seed(bits)
    kernels.reverse(backward)
    for count in (0, 1, 33, 2049, 9000):
        keys = torch.randint(2**bits, (count,), generator=generator)
        found_keys, found = cuda._sort(kernels, keys.to(torch.int32), None, bits)
        expected = torch.sort(keys, stable=True)
        assert torch.equal(found_keys, expected.values.to(torch.int32))
        assert torch.equal(found, expected.indices.to(torch.int32))
        values = torch.randint(2**31, (count,), generator=generator).to(torch.int32)
        for length in (count // 3, count, count + 1):  # the last has no room
            given = keys.to(torch.int32), values, bits, torch.tensor([length])
            found_keys, found = cuda._sort(kernels, *given)
            expected = torch.sort(keys[:length], stable=True)
            if 0 < length <= count:
                assert torch.equal(found_keys[:length], expected.values.to(torch.int32))
                assert torch.equal(found[:length], values[expected.indices])
            assert (found[length:] == torch.iinfo(torch.int32).max).all(), "written past the end"


def lists_of(scene, view, *, depths):
    names = SORTED if depths else SORTFREE
    sizes: dict[str, Any] = {"sh_size": 4, "lobe_size": 0 if depths else 9}
    settings = RenderSettings(level_sigma=0.0 if depths else 0.6)
    struct = kernel_view(view, torch.zeros(3), settings, **sizes)
    inputs = {name: scene[name].float().contiguous() for name in names}
    order = ("means", "quats", "scales", "opacities", "sh", "lobes", "more")
    kernels = cuda.kernels_for(inputs["means"])
    found = cuda._project(kernels, struct, [inputs.get(name) for name in order])
    return found, cuda._Lists(kernels, struct, found)


@pytest.mark.parametrize("depths", [False, True])
@pytest.mark.parametrize(("width", "height"), [(96, 72), (16, 12)])
def test_lists_are_stably_sorted_by_tile(width, height, depths, kernels, monkeypatch):
    monkeypatch.setattr(cuda, "FILL_BLOCKS", 2)
    scene, view = as_float32(random_scene(900, seed=17)), camera(width, height)
    scene["means"][5:9] *= torch.nan  # not visible
    scene["means"][11] = scene["means"][10]  # of one depth
    found, lists = lists_of(scene, view, depths=depths)
    order = torch.arange(900)
    if depths:
        z = found.splats.view(torch.float32)[:, 10].where(found.touched > 0, torch.inf)
        order = torch.sort(z, stable=True).indices
        assert lists.order is not None and lists.ends is not None and lists.slots is not None
        assert torch.equal(lists.order.long(), order)
        assert torch.equal(lists.ends, found.touched[order].cumsum(0))
    again, length = lists.complete()
    starts, ids = lists.starts.long(), lists.ids[:length]
    assert again is lists and length == int(found.touched.sum()) == starts[-1] > 0
    tiles = torch.repeat_interleave(torch.arange(len(starts) - 1), starts.diff())
    ids, first = ids & 0x7FFFFFFF, ids < 0
    # each Gaussian in as many different tiles as were counted, the first one marked
    assert torch.equal(torch.bincount(ids, minlength=900), found.touched.long())
    assert len(torch.stack([tiles, ids]).unique(dim=1)[0]) == length
    assert torch.equal(ids[first].sort().values, found.touched.nonzero()[:, 0])
    lowest = torch.full((900,), len(starts)).scatter_reduce(0, ids.long(), tiles, "amin")
    assert torch.equal(lowest[ids[first]], tiles[first])
    # in each tile in the order of the Gaussians
    places = order.argsort()[ids]
    assert (places.diff()[tiles.diff() == 0] > 0).all()
    if lists.slots is not None:
        slots = lists.slots[:length].long()
        assert torch.equal(slots.sort().values, torch.arange(length))
        owners = torch.repeat_interleave(order, found.touched[order])
        assert torch.equal(owners[slots], ids.long())


@pytest.mark.parametrize("late", [0, 10])
@pytest.mark.parametrize("renderer", EVERYTHING)
def test_lists_without_room_change_neither_image_nor_gradients(renderer, late, kernels):
    def forget():
        kernels.forget()
        kernels.late = late  # questions until a length is known

    check_lists_without_room(renderer, forget)
    # sorted blending makes its lists again in the backward pass; the depth pass has its own
    fills = {"sorted": 2, "depth_pass": 2}.get(renderer, 1)
    assert kernels.launched.count("mgs_fill") == fills
    room = room_for(20)
    for _ in range(11):
        room = kernels.lengths.room(max(kernels.lengths.longest))  # the image has the most tiles
    assert room > 400


def test_contributions_without_room_are_the_same(kernels):
    scene, view = as_float32(random_scene(300, seed=19)), camera(56, 50)
    expected = contributions_by_cuda(scene, view)
    (alike,) = kernels.lengths.longest
    kernels.forget()
    kernels.lengths.learn(alike, 20)
    for name, value in contributions_by_cuda(scene, view)._asdict().items():
        assert torch.equal(value, getattr(expected, name)), name


def test_the_room_follows_the_longest_list_that_is_known(kernels):
    lengths, wide, narrow = ListLengths(), (100, 10), (50, 10)
    assert lengths.room(wide) is None
    lengths.learn(wide, 1000)
    lengths.learn(wide, 10)
    assert lengths.room(wide) == room_for(1000) and lengths.room(narrow) is None
    lengths.coming += [(wide, HostLength(torch.tensor([4000]), 1))]
    assert lengths.room(wide) == room_for(1000) and lengths.room(wide) == room_for(4000)
    assert not lengths.coming
    assert all(1.5 * length < room_for(length) < 1.7 * length for length in range(20, 5000))
    assert room_for(0) == 1 and room_for(2**31) == ROOM_MAX


@pytest.mark.parametrize("renderer", EVERYTHING)
def test_another_view_of_a_known_size_reads_nothing_back(renderer, kernels):
    scene, background = as_float32(random_scene(200, seed=20)), torch.ones(3)
    render, options = RENDERERS[renderer]
    leaves = [scene[name].float().requires_grad_() for name in input_names(renderer)]
    view, other = (
        camera(45, 37, center=c).to(dtype=torch.float32) for c in ((0.5, 0.5), (0.4, 0.6))
    )

    def count(view, background):
        with OperationCount() as counted:
            given = {"camera": view, "background": background}
            render(*leaves, **given, **options).image.backward(torch.ones(37, 45, 3))
        return counted.host_reads, counted.operations["_to_copy"]

    # the list's length, and that of a depth pass; viewmat, K and background
    assert count(view, background) == (2 if renderer == "depth_pass" else 1, 3)
    assert count(other, background) == (0, 2)
    assert count(view, background) == count(other, background) == (0, 0)
    assert count(other, None) == (0, 1)  # of a tensor in main memory


@pytest.mark.parametrize("renderer", EVERYTHING)
@pytest.mark.parametrize("output", ["image", "alpha", "depth"])
def test_losses_of_one_output_have_the_same_gradients(output, renderer, monkeypatch):
    scene, view = as_float32(random_scene(60, seed=22)), camera()
    render, options = RENDERERS[renderer]

    def gradients():
        leaves = [scene[name].float().requires_grad_() for name in input_names(renderer)]
        given = {"camera": view.to(dtype=torch.float32), "background": torch.zeros(3)}
        rendered = render(*leaves, depth=True, **given, **options)
        getattr(rendered, output).square().sum().backward()
        return [leaf.grad for leaf in leaves if leaf.grad is not None]

    found = gradients()
    monkeypatch.undo()
    for value, expected in zip(found, gradients(), strict=True):
        assert (value - expected).norm() <= 1e-3 * expected.norm()


@pytest.mark.parametrize("renderer", EVERYTHING)
def test_gaussians_outside_the_image_leave_the_background(renderer):
    scene, view = as_float32(random_scene(40, seed=23)), camera()
    scene["means"] -= torch.tensor([0.0, 0.0, 50.0])
    found = render_all(scene, view, renderer)
    assert not found["alpha"].any()
    assert all(not found[name].any() for name in input_names(renderer))


def test_inputs_on_different_devices_are_refused():
    scene = {name: value.float() for name, value in as_float32(BASE).items()}
    scene["sh"] = scene["sh"].to("meta")
    with pytest.raises(InputError, match="meta"):
        render_sorted(
            *[scene[n] for n in SORTED],
            camera=camera().to(dtype=torch.float32),
            background=torch.zeros(3),
        )
