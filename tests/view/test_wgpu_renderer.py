"""The GPU renderer against the definition, on any device (Mesa's lavapipe will do)."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import psnr
from mobilegs.formats.ply import read_ply
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.render.view_network import ViewNetwork
from mobilegs.view import wgpu_device
from mobilegs.view.wgpu_renderer import GpuRenderer
from tests.render.test_kernels import BAD
from tests.support.golden import (
    BACKGROUND,
    BASE,
    CASES,
    RENDERERS,
    SHADED,
    defined,
    inputs_of,
    least_alpha,
    names_of,
    trained,
    with_rows,
)
from tests.support.scenes import as_float32, camera, near_threshold, no_gpu, random_scene


def inria_camera(row: dict) -> Camera:
    """A camera as 3DGS lists them in cameras.json: `rotation` is camera to world."""
    viewmat = torch.eye(4)
    viewmat[:3, :3] = torch.tensor(row["rotation"]).T
    viewmat[:3, 3] = -viewmat[:3, :3] @ torch.tensor(row["position"])
    k = torch.tensor(
        [[row["fx"], 0, row["width"] / 2], [0, row["fy"], row["height"] / 2], [0, 0, 1.0]]
    )
    return Camera(viewmat, k, row["width"], row["height"])


pytestmark = pytest.mark.skipif(bool(no_gpu()), reason=no_gpu())


def as_scene(inputs: dict[str, torch.Tensor], renderer: str) -> Scene:
    """The scene that raw inputs of a renderer describe, float32."""
    some = {name: value.float() for name, value in inputs.items()}
    gaussians = Gaussians(
        means=some["means"],
        quats=some["quats"],
        log_scales=some["scales"].log(),
        logit_opacities=some["opacities"].double().logit().clamp(-40, 40).float(),
        sh=some["sh"],
    )
    if renderer == "sorted":
        return Scene(gaussians, background=BACKGROUND)
    weighting = RENDERERS[renderer][1]["weighting"]
    return Scene(
        gaussians, "sortfree", lobes=some["lobes"], weighting=weighting, background=BACKGROUND
    )


@pytest.mark.parametrize("renderer", SHADED)
@pytest.mark.parametrize("case", CASES)
def test_the_gpu_agrees_with_the_definition(case: str, renderer: str) -> None:
    inputs, view = inputs_of(case)
    drawn = GpuRenderer(as_scene(inputs, renderer), full_precision=True).draw(view)
    expected = defined(case, renderer)
    keep = ~near_threshold(
        inputs, view, names=names_of(renderer), margin=1e-4, least=least_alpha(renderer)
    )
    for name, found in {"image": drawn.image, "alpha": drawn.alpha}.items():
        error = (found.double() - getattr(expected, name))[keep]
        decibels = -10 * torch.log10(error.square().mean().clamp_min(1e-30)).item()
        worst = error.abs().max().item()
        print(f"{name} {decibels:.1f} dB, max {worst:.1e}")
        # where sorted blending stops at T = 1e-4, the GPU goes on
        assert decibels >= (75 if renderer == "sorted" else 90), name


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
@pytest.mark.parametrize("bad", BAD)
def test_a_gaussian_that_is_not_finite_is_left_out(bad: str, renderer: str) -> None:
    view, inputs = camera(), as_float32(BASE)
    changes = {name: BAD[bad][name] for name in BAD[bad] if name in names_of(renderer)}
    broken = GpuRenderer(as_scene(with_rows(inputs, **changes), renderer), full_precision=True)
    rows = torch.ones(60, dtype=torch.bool)
    rows[next(iter(BAD[bad].values()))[0]] = False
    rest = {name: value[rows] for name, value in inputs.items()}
    expected = GpuRenderer(as_scene(rest, renderer), full_precision=True)
    assert broken.count == int(rows.sum())
    torch.testing.assert_close(
        broken.draw(view).image, expected.draw(view).image, rtol=0, atol=2e-6
    )


@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
def test_halves_are_enough_for_a_picture(renderer: str) -> None:
    scene = as_scene(random_scene(20_000, seed=3, spread=1.5), renderer)
    scene.gaussians.log_scales -= 1.5
    view = camera(320, 213).to(dtype=torch.float32)
    reference = scene.render(view).image
    decibels = psnr(GpuRenderer(scene).draw(view).image, reference)
    exact = psnr(GpuRenderer(scene, full_precision=True).draw(view).image, reference)
    print(f"halves {decibels:.1f} dB, floats {exact:.1f} dB")
    assert decibels >= 50 and exact >= 80


@pytest.mark.parametrize("full_precision", [False, True])
def test_huge_gaussians_near_the_eye_leave_numbers(full_precision: bool) -> None:
    inputs = random_scene(3000, seed=4)
    inputs["scales"][::50] = 40.0
    view = camera(160, 120).to(dtype=torch.float32)
    inputs["means"][::50] = view.position.double() + 0.3 * torch.randn(60, 3).double()
    scene = as_scene(inputs, "mobile_gs")
    for ceiling in (4.0, 8.0):
        scene.weighting = replace(scene.weighting, exponent_max=ceiling)
        found = GpuRenderer(scene, full_precision=full_precision).draw(view)
        assert found.image.isfinite().all() and found.alpha.isfinite().all()
        decibels = psnr(found.image.clamp(0, 1), scene.render(view).image.clamp(0, 1))
        print(f"ceiling {ceiling}: {decibels:.1f} dB")
        assert decibels > 45


def test_a_trained_student_looks_the_same() -> None:
    scene, view = trained()
    reference = scene.render(view)
    for full_precision, least in ((True, 75), (False, 50)):
        drawn = GpuRenderer(scene, full_precision=full_precision).draw(view)
        decibels = psnr(drawn.image, reference.image)
        print(f"{'floats' if full_precision else 'halves'} {decibels:.1f} dB")
        assert decibels > least


@pytest.mark.parametrize("name", ["flowers_lod1", "playbot_125k_sh3pad"])
def test_a_trained_scene_looks_the_same(data_dir: Path, name: str) -> None:
    scene = Scene(read_ply(data_dir / "splats" / f"{name}.ply"), background=BACKGROUND)
    cameras = data_dir / "splats" / f"{name.split('_')[0]}_cameras.json"
    view = inria_camera(json.loads(cameras.read_text())[3]).resized(480, 270)
    reference = scene.render(view)
    assert reference.alpha.mean() > 0.1
    for full_precision, least in ((True, 75), (False, 50)):
        drawn = GpuRenderer(scene, full_precision=full_precision).draw(view)
        decibels = psnr(drawn.image, reference.image)
        print(f"{'floats' if full_precision else 'halves'} {decibels:.1f} dB")
        assert decibels > least


def test_a_scene_can_be_drawn_at_several_sizes() -> None:
    scene = as_scene(as_float32(BASE), "mobile_gs")
    renderer = GpuRenderer(scene, full_precision=True)
    view = camera().to(dtype=torch.float32)
    first = renderer.draw(view)
    small = renderer.draw(view.resized(20, 16))
    assert first.image.shape == (37, 45, 3) and small.image.shape == (16, 20, 3)
    torch.testing.assert_close(renderer.draw(view).image, first.image, rtol=0, atol=2e-6)
    milliseconds = renderer.program.milliseconds()
    if milliseconds is not None:
        assert set(milliseconds) == {"project", "splat", "resolve"}
        assert all(value >= 0 for value in milliseconds.values())


@pytest.mark.parametrize("size", [(0, 20), (100_000, 20)])
def test_an_impossible_picture_is_refused(size: tuple[int, int]) -> None:
    renderer = GpuRenderer(as_scene(as_float32(BASE), "mobile_gs"))
    view = replace(camera(), width=size[0], height=size[1])
    with pytest.raises(InputError, match="cannot be drawn: each side"):
        renderer.draw(view)


def test_a_view_network_is_refused() -> None:
    scene = as_scene(as_float32(BASE), "mobile_gs")
    scene.lobes, scene.network = None, ViewNetwork(torch.Generator())
    with pytest.raises(InputError, match="view network"):
        GpuRenderer(scene)


def test_a_weighting_that_takes_two_passes_is_refused() -> None:
    with pytest.raises(InputError, match="two_pass"):
        GpuRenderer(as_scene(as_float32(BASE), "two_pass"))


def test_a_machine_without_a_gpu_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import wgpu

    def nothing(**_: object) -> None:
        raise RuntimeError("no adapter")

    monkeypatch.setattr(wgpu.gpu, "request_adapter_sync", nothing)
    with pytest.raises(InputError, match="Vulkan driver"):
        wgpu_device.adapter.__wrapped__()
