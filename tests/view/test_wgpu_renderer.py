"""The WebGPU renderer against the reference, on any device (Mesa's lavapipe included)."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import psnr
from mobilegs.formats.ply import read_ply
from mobilegs.render import Footprint, Weighting
from mobilegs.render.scene import Scene
from mobilegs.view import wgpu_device, wgpu_renderer
from mobilegs.view.wgpu_renderer import WgpuRenderer
from tests.support.golden import (
    BACKGROUND,
    BASE,
    CASES,
    INVALID,
    NETWORK_CASES,
    SHADER_RENDERERS,
    as_scene,
    input_names,
    inputs_of,
    network_case,
    render_reference,
    settings_of,
    sure_with_network,
    trained,
    turned_around,
    with_network,
    with_rows,
)
from tests.support.scenes import (
    as_float32,
    camera,
    camera_from_json,
    near_threshold,
    no_gpu,
    random_scene,
)

pytestmark = pytest.mark.skipif(bool(no_gpu()), reason=no_gpu())


@pytest.mark.parametrize("renderer", SHADER_RENDERERS)
@pytest.mark.parametrize("case", CASES)
def test_the_gpu_agrees_with_the_reference(case: str, renderer: str) -> None:
    (inputs, view), sigma = inputs_of(case), settings_of(renderer).level_sigma
    scene = as_scene(inputs, renderer)
    rendered = WgpuRenderer(scene, full_precision=True, level_sigma=sigma).render(view)
    expected = render_reference(case, renderer)
    keep = ~near_threshold(
        inputs, view, names=input_names(renderer), margin=1e-4, settings=settings_of(renderer)
    )
    for name, found in {"image": rendered.image, "alpha": rendered.alpha}.items():
        error = (found.double() - getattr(expected, name))[keep]
        decibels = -10 * torch.log10(error.square().mean().clamp_min(1e-30)).item()
        worst = error.abs().max().item()
        print(f"{name} {decibels:.1f} dB, max {worst:.1e}")
        # the GPU has no early stop at T = 1e-4
        assert decibels >= (75 if renderer.startswith("sorted") else 90), name


@pytest.mark.parametrize("level_sigma", [0.0, 1.0])
@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
def test_small_images_are_means_of_larger_ones(renderer: str, level_sigma: float) -> None:
    scene = as_scene(random_scene(500, seed=5, spread=1.5), renderer)
    view = camera(53, 31).to(dtype=torch.float32)
    gpu = WgpuRenderer(scene, full_precision=True, level_sigma=level_sigma)
    found = gpu.render(view, supersampling=3)
    expected = scene.render(view, level_sigma=level_sigma, supersampling=3)
    for name in ("image", "alpha"):
        error = getattr(found, name) - getattr(expected, name)
        decibels = float(-10 * error.square().mean().log10())
        print(f"{name} {decibels:.1f} dB")
        assert decibels >= (75 if renderer == "sorted" else 90), name


@pytest.mark.parametrize("level_sigma", [0.8, 1.0, 1.4])
def test_levels_of_a_trained_scene_agree_with_the_kernels(level_sigma: float) -> None:
    scene, view = trained()
    for full_precision, least in ((True, 75), (False, 50)):
        renderer = WgpuRenderer(scene, full_precision=full_precision, level_sigma=level_sigma)
        for angle in (0.0, 0.3):
            turned = turned_around(view, angle)
            found = renderer.render(turned).image
            exact = scene.render(turned, level_sigma=level_sigma).image
            decibels = psnr(found, exact)
            print(f"{decibels:.1f} dB")
            assert decibels >= least
            assert psnr(exact, scene.render(turned).image) < 75  # levels differ from none


def test_settings_that_renderers_refuse_are_refused() -> None:
    scene = as_scene(as_float32(BASE), "mobile_gs")
    with pytest.raises(InputError, match="level_sigma must be 0 or lie"):
        WgpuRenderer(scene, level_sigma=0.5)


def test_sorted_scenes_have_no_soft_edges() -> None:
    hard, view = as_scene(as_float32(BASE), "sorted"), camera().to(dtype=torch.float32)
    soft = replace(hard, footprint=Footprint(soft_edge=True))
    assert torch.equal(soft.render(view).image, hard.render(view).image)
    drawn = [WgpuRenderer(scene, full_precision=True).render(view).image for scene in (soft, hard)]
    assert torch.equal(*drawn)


def test_images_whose_levels_do_not_fit_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = as_scene(random_scene(3000, seed=21, size=0.8), "mobile_gs")
    view = camera(200, 160).to(dtype=torch.float32)
    places = (wgpu_renderer.level_places(160, 200)[0], (160, 1 << 20))
    monkeypatch.setattr(wgpu_renderer, "level_places", lambda height, width: places)
    found = WgpuRenderer(scene, full_precision=True, level_sigma=0.8).render(view).image
    assert psnr(found, scene.render(view).image) > 90


def test_each_visible_gaussian_is_listed_once_with_its_level() -> None:
    scene = as_scene(random_scene(3000, seed=21, size=0.8), "mobile_gs")
    view = camera(200, 160).to(dtype=torch.float32)
    renderer = WgpuRenderer(scene, full_precision=True, level_sigma=0.8)
    renderer.render(view)
    visible = set((scene.render(view).radii > 0).nonzero()[:, 0].tolist())
    queue = renderer.program.device.queue
    drawn = np.frombuffer(queue.read_buffer(renderer._drawn), np.int32)
    instances, count = drawn[1], drawn[5]
    assert instances == -(-count // 128)
    found = np.frombuffer(queue.read_buffer(renderer._order), np.uint32)[:count]
    rows, levels = found & (2**30 - 1), found >> 30
    assert len(np.unique(rows)) == count
    assert len(visible ^ set(rows.tolist())) <= 2  # of rounding at the image's border
    assert (np.bincount(levels, minlength=4) > 80).all()


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
@pytest.mark.parametrize("bad", INVALID)
def test_a_gaussian_with_a_value_that_is_not_finite_is_left_out(bad: str, renderer: str) -> None:
    view, inputs = camera(), as_float32(BASE)
    changes = {name: INVALID[bad][name] for name in INVALID[bad] if name in input_names(renderer)}
    broken = WgpuRenderer(as_scene(with_rows(inputs, **changes), renderer), full_precision=True)
    rows = torch.ones(60, dtype=torch.bool)
    rows[next(iter(INVALID[bad].values()))[0]] = False
    rest = {name: value[rows] for name, value in inputs.items()}
    expected = WgpuRenderer(as_scene(rest, renderer), full_precision=True)
    assert broken.count == int(rows.sum())
    torch.testing.assert_close(
        broken.render(view).image, expected.render(view).image, rtol=0, atol=2e-6
    )


@pytest.mark.parametrize("by", ["lobes", "network"])
def test_a_sorted_scene_has_the_opacities_of_its_lobes_or_network(by: str) -> None:
    scene = replace(as_scene(as_float32(BASE), "mobile_gs"), blend="sorted")
    scene = with_network(scene) if by == "network" else scene
    view = camera().to(dtype=torch.float32)
    found = WgpuRenderer(scene, full_precision=True).render(view).image
    assert psnr(found, scene.render(view).image) > 75
    assert psnr(found, replace(scene, lobes=None, network=None).render(view).image) < 40


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
def test_float16_is_accurate_enough(renderer: str) -> None:
    scene = as_scene(random_scene(20_000, seed=3, spread=1.5), renderer)
    scene.gaussians.log_scales -= 1.5
    view = camera(320, 213).to(dtype=torch.float32)
    reference = scene.render(view).image
    decibels = psnr(WgpuRenderer(scene).render(view).image, reference)
    exact = psnr(WgpuRenderer(scene, full_precision=True).render(view).image, reference)
    print(f"float16 {decibels:.1f} dB, float32 {exact:.1f} dB")
    assert decibels >= 50 and exact >= 80


@pytest.mark.parametrize("full_precision", [False, True])
def test_huge_gaussians_near_the_camera_do_not_overflow(full_precision: bool) -> None:
    inputs = random_scene(3000, seed=4)
    inputs["scales"][::50] = 40.0
    view = camera(160, 120).to(dtype=torch.float32)
    inputs["means"][::50] = view.position.double() + 0.3 * torch.randn(60, 3).double()
    scene = as_scene(inputs, "mobile_gs")
    for ceiling in (4.0, 8.0):
        scene.weighting = replace(scene.weighting, exponent_max=ceiling)
        found = WgpuRenderer(scene, full_precision=full_precision).render(view)
        assert found.image.isfinite().all() and found.alpha.isfinite().all()
        decibels = psnr(found.image.clamp(0, 1), scene.render(view).image.clamp(0, 1))
        print(f"ceiling {ceiling}: {decibels:.1f} dB")
        assert decibels > 45


def test_a_trained_student_renders_the_same() -> None:
    scene, view = trained()
    reference = scene.render(view)
    for full_precision, least in ((True, 75), (False, 50)):
        rendered = WgpuRenderer(scene, full_precision=full_precision).render(view)
        decibels = psnr(rendered.image, reference.image)
        print(f"{'float32' if full_precision else 'float16'} {decibels:.1f} dB")
        assert decibels > least


@pytest.mark.parametrize("name", ["flowers_lod1", "playbot_125k_sh3pad"])
def test_a_trained_teacher_renders_the_same(data_dir: Path, name: str) -> None:
    scene = Scene(read_ply(data_dir / "splats" / f"{name}.ply"), background=BACKGROUND)
    cameras = data_dir / "splats" / f"{name.split('_')[0]}_cameras.json"
    view = camera_from_json(json.loads(cameras.read_text())[3]).resized(480, 270)
    reference = scene.render(view)
    assert reference.alpha.mean() > 0.1
    for full_precision, least in ((True, 75), (False, 50)):
        rendered = WgpuRenderer(scene, full_precision=full_precision).render(view)
        decibels = psnr(rendered.image, reference.image)
        print(f"{'float32' if full_precision else 'float16'} {decibels:.1f} dB")
        assert decibels > least


def test_a_scene_renders_at_several_sizes() -> None:
    scene = as_scene(as_float32(BASE), "mobile_gs")
    renderer = WgpuRenderer(scene, full_precision=True)
    view = camera().to(dtype=torch.float32)
    first = renderer.render(view)
    small = renderer.render(view.resized(20, 16))
    assert first.image.shape == (37, 45, 3) and small.image.shape == (16, 20, 3)
    torch.testing.assert_close(renderer.render(view).image, first.image, rtol=0, atol=2e-6)
    milliseconds = renderer.milliseconds()
    if milliseconds is not None:
        assert set(milliseconds) == {"project", "splat", "resolve"}
        assert all(value >= 0 for value in milliseconds.values())


@pytest.mark.parametrize("size", [(0, 20), (100_000, 20)])
def test_an_impossible_image_size_is_refused(size: tuple[int, int]) -> None:
    renderer = WgpuRenderer(as_scene(as_float32(BASE), "mobile_gs"))
    view = replace(camera(), width=size[0], height=size[1])
    with pytest.raises(InputError, match="each side"):
        renderer.render(view)


@pytest.mark.parametrize("case", NETWORK_CASES)
def test_a_view_network_agrees_with_the_reference(case: str) -> None:
    scene, view = network_case(case)
    expected, keep = scene.render(view), sure_with_network(case)
    renderer = WgpuRenderer(scene, full_precision=True)
    rendered = renderer.render(view)
    assert renderer.program.number == "f32"
    for name in ("image", "alpha"):
        error = (getattr(rendered, name).double() - getattr(expected, name).double())[keep]
        decibels = -10 * torch.log10(error.square().mean().clamp_min(1e-30)).item()
        print(f"{name} {decibels:.1f} dB, max {error.abs().max().item():.1e}")
        assert decibels >= 90, name
    milliseconds = renderer.milliseconds()
    assert milliseconds is None or set(milliseconds) == {"network", "project", "splat", "resolve"}


def test_a_view_network_in_float16_is_accurate_enough() -> None:
    scene = with_network(as_scene(random_scene(20_000, seed=3, spread=1.5), "mobile_gs"))
    scene.gaussians.log_scales -= 1.5
    view = camera(160, 107).to(dtype=torch.float32)
    expected = scene.render(view).image
    renderer = WgpuRenderer(scene)
    decibels = psnr(renderer.render(view).image, expected)
    print(f"{renderer.program.number} {decibels:.1f} dB")
    assert decibels >= 50
    constant = replace(scene, network=None)  # else the network could be left out unnoticed
    assert psnr(WgpuRenderer(constant).render(view).image, expected) < 30


@pytest.mark.parametrize("rows", ["wide", "packed"])
@pytest.mark.parametrize("number", ["f16", "f32"])
def test_the_network_compiles_in_both_precisions(number: str, rows: str) -> None:
    program = WgpuRenderer(network_case("degree 1")[0]).program
    if number == "f16" and program.number != "f16":
        pytest.skip("this GPU does not compute in float16")
    assert program.network_of(number, rows) is not None


def test_a_view_network_follows_the_camera() -> None:
    scene, view = network_case("degree 1")
    renderer = WgpuRenderer(scene, full_precision=True)
    for angle in (0.0, 0.7, 2.5):
        turned = turned_around(view, angle)
        found, expected = renderer.render(turned).image, scene.render(turned).image
        assert psnr(found, expected) > 60


def test_the_weighting_two_pass_is_refused() -> None:
    with pytest.raises(InputError, match="two_pass"):
        WgpuRenderer(as_scene(as_float32(BASE), "two_pass"))


def test_the_weighting_exponential_is_refused() -> None:
    scene = replace(as_scene(as_float32(BASE), "mobile_gs"), weighting=Weighting("exponential"))
    with pytest.raises(InputError, match="exponential"):
        WgpuRenderer(scene)


def test_without_a_gpu_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import wgpu

    def nothing(**_: object) -> None:
        raise RuntimeError("no adapter")

    monkeypatch.setattr(wgpu.gpu, "request_adapter_sync", nothing)
    with pytest.raises(InputError, match="Vulkan driver"):
        wgpu_device.adapter.__wrapped__()
