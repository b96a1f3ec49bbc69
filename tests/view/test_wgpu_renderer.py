"""The WebGPU renderer against the reference, on any device (Mesa's lavapipe included)."""

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
import torch

from mobilegs.cli import doctor
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import psnr
from mobilegs.formats.ply import read_ply
from mobilegs.render.scene import Scene
from mobilegs.view import wgpu_check, wgpu_device, wgpu_renderer
from mobilegs.view.wgpu_renderer import WgpuRenderer
from tests.support.golden import (
    BACKGROUND,
    BASE,
    INVALID,
    NETWORK_CASES,
    RENDERERS,
    as_scene,
    golden_cases,
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
from tests.support.gpus import GPU, GPU_FLOAT32, precisions
from tests.support.placed_scenes import Placed, sums_of
from tests.support.scenes import (
    as_float32,
    camera,
    camera_from_json,
    near_threshold,
    random_scene,
)

pytestmark = GPU
LEAST = {False: 50, True: 75}  # dB that images of trained scenes reach, by full_precision


@pytest.mark.parametrize("renderer", RENDERERS)
def test_the_gpu_agrees_with_the_reference(renderer: str, subtests: pytest.Subtests) -> None:
    settings = settings_of(renderer)
    # with full precision, the GPU has no early stop at T = 1e-4; in float16, each Gaussian rounds
    least = {False: 40, True: 75 if renderer.startswith("sorted") else 90}
    for case in golden_cases(renderer):
        inputs, view = inputs_of(case)
        expected, scene = render_reference(case, renderer), as_scene(inputs, renderer)
        names = input_names(renderer)
        keep = ~near_threshold(inputs, view, names=names, margin=1e-4, settings=settings)
        for full_precision in precisions():
            options = {"full_precision": full_precision, "level_sigma": settings.level_sigma}
            rendered = WgpuRenderer(scene, **options).render(view)
            for name, found in {"image": rendered.image, "alpha": rendered.alpha}.items():
                with subtests.test(case=case, full_precision=full_precision, output=name):
                    error = (found.double() - getattr(expected, name))[keep]
                    decibels = -10 * torch.log10(error.square().mean().clamp_min(1e-30)).item()
                    print(f"{decibels:.1f} dB, max {error.abs().max().item():.1e}")
                    assert decibels >= least[full_precision]


def test_settings_that_no_renderer_has_are_refused() -> None:
    scene = as_scene(as_float32(BASE), "mobile_gs")
    with pytest.raises(InputError, match="level_sigma must be 0 or lie"):
        WgpuRenderer(scene, level_sigma=0.5)
    renderer = WgpuRenderer(scene)
    for width in (0, 100_000):
        with pytest.raises(InputError, match="each side"):
            renderer.render(replace(camera(), width=width, height=20))


@GPU_FLOAT32
def test_images_whose_levels_do_not_fit_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = as_scene(random_scene(3000, seed=21, size=0.8), "mobile_gs")
    view = camera(200, 160).to(dtype=torch.float32)
    places = (wgpu_renderer.level_places(160, 200)[0], (160, 1 << 20))
    monkeypatch.setattr(wgpu_renderer, "level_places", lambda height, width: places)
    found = WgpuRenderer(scene, full_precision=True, level_sigma=0.8).render(view).image
    assert psnr(found, scene.render(view).image) > 90


@GPU_FLOAT32
@pytest.mark.parametrize("renderer", ["sorted", "mobile_gs"])
def test_a_gaussian_with_a_value_that_is_not_finite_is_left_out(
    renderer: str, subtests: pytest.Subtests
) -> None:
    view, inputs = camera(), as_float32(BASE)
    for bad, values in INVALID.items():
        changes = {name: values[name] for name in values if name in input_names(renderer)}
        broken = as_scene(with_rows(inputs, **changes), renderer)
        rows = torch.ones(60, dtype=torch.bool)
        rows[next(iter(values.values()))[0]] = False
        rest = as_scene({name: value[rows] for name, value in inputs.items()}, renderer)
        found, expected = (WgpuRenderer(each, full_precision=True) for each in (broken, rest))
        with subtests.test(bad):
            assert found.count == int(rows.sum())
            images = [each.render(view).image for each in (found, expected)]
            torch.testing.assert_close(*images, rtol=0, atol=2e-6)


@GPU_FLOAT32
@pytest.mark.parametrize("by", ["lobes", "network"])
def test_a_sorted_scene_has_the_opacities_of_its_lobes_or_network(by: str) -> None:
    scene = replace(as_scene(as_float32(BASE), "mobile_gs"), blend="sorted")
    scene = with_network(scene) if by == "network" else scene
    view = camera().to(dtype=torch.float32)
    found = WgpuRenderer(scene, full_precision=True).render(view).image
    assert psnr(found, scene.render(view).image) > 75
    assert psnr(found, replace(scene, lobes=None, network=None).render(view).image) < 40


def test_sums_with_a_depth_pass_stay_in_the_range_of_float16() -> None:
    scene, view = trained()
    scene = replace(scene, weighting=replace(scene.weighting, name="depth_pass"))
    sums = sums_of([Placed(scene, torch.eye(4))], view.resized(96, 64)).weight
    print(f"largest sum {sums.max():.3g}")
    assert sums.max() * wgpu_device.FLOAT16_SCALES[True] < 65504 / 8


def test_a_trained_student_renders_the_same() -> None:
    scene, view = trained()
    reference = scene.render(view)
    for full_precision in precisions():
        rendered = WgpuRenderer(scene, full_precision=full_precision).render(view)
        decibels = psnr(rendered.image, reference.image)
        print(f"{'float32' if full_precision else 'float16'} {decibels:.1f} dB")
        assert decibels > LEAST[full_precision]


@pytest.mark.parametrize("name", ["flowers_lod1", "playbot_125k_sh3pad"])
def test_a_trained_teacher_renders_the_same(data_dir: Path, name: str) -> None:
    scene = Scene(read_ply(data_dir / "splats" / f"{name}.ply"), background=BACKGROUND)
    cameras = data_dir / "splats" / f"{name.split('_')[0]}_cameras.json"
    view = camera_from_json(json.loads(cameras.read_text())[3]).resized(480, 270)
    reference = scene.render(view)
    assert reference.alpha.mean() > 0.1
    for full_precision in precisions():
        rendered = WgpuRenderer(scene, full_precision=full_precision).render(view)
        decibels = psnr(rendered.image, reference.image)
        print(f"{'float32' if full_precision else 'float16'} {decibels:.1f} dB")
        assert decibels > LEAST[full_precision]


@GPU_FLOAT32
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


@GPU_FLOAT32
def test_a_view_network_agrees_with_the_reference(subtests: pytest.Subtests) -> None:
    passes = {"network", "project", "splat", "resolve"}
    for case in NETWORK_CASES:
        scene, view = network_case(case)
        expected, keep = scene.render(view), sure_with_network(case)
        renderer = WgpuRenderer(scene, full_precision=True)
        rendered = renderer.render(view)
        assert renderer.program.number == "f32"
        for name in ("image", "alpha"):
            with subtests.test(case=case, output=name):
                error = (getattr(rendered, name).double() - getattr(expected, name).double())[keep]
                decibels = -10 * torch.log10(error.square().mean().clamp_min(1e-30)).item()
                print(f"{decibels:.1f} dB, max {error.abs().max().item():.1e}")
                assert decibels >= 90
        milliseconds = renderer.milliseconds()
        assert milliseconds is None or set(milliseconds) == passes
    scene, view = network_case("degree 1")
    renderer = WgpuRenderer(scene, full_precision=True)
    for angle in (0.7, 2.5):  # it follows the camera
        turned = turned_around(view, angle)
        assert psnr(renderer.render(turned).image, scene.render(turned).image) > 60


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


def test_the_network_compiles_in_both_precisions() -> None:
    program = WgpuRenderer(network_case("degree 1")[0]).program
    for number in ("f16", "f32") if program.number == "f16" else ("f32",):
        assert all(program.network_of(number, rows) for rows in ("wide", "packed"))


@dataclass
class Adapter:
    """A stand-in for an adapter of wgpu, which opens no device."""

    device: str
    backend_type: str = "Vulkan"
    adapter_type: str = "DiscreteGPU"
    features: tuple[str, ...] = ()
    limits: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(
            ["max-buffer-size", "max-storage-buffer-binding-size"], 1
        )
    )

    @property
    def info(self) -> dict[str, str]:
        names = ("device", "backend_type", "adapter_type")
        return {name: getattr(self, name) for name in names}

    @property
    def summary(self) -> str:
        return f"{self.device} via {self.backend_type}"

    def request_device_sync(self, **_: object) -> None:
        raise RuntimeError("Request device failed:\n\nlimit is too low")

    __hash__ = object.__hash__


def adapters(monkeypatch: pytest.MonkeyPatch, *found: Any) -> None:
    import wgpu

    monkeypatch.setattr(wgpu.gpu, "enumerate_adapters_sync", lambda: list(found))


def test_the_best_gpu_comes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ["discrete", "integrated", "old", "virtual", "GL only", "lavapipe", "llvmpipe"]
    discrete, integrated, old, virtual, gl, lavapipe, llvmpipe = expected = [
        Adapter(names[0]),
        Adapter(names[1], "D3D12", "IntegratedGPU"),
        Adapter(names[2], "Metal", "IntegratedGPU"),
        Adapter(names[3], "Vulkan", "unknown"),
        Adapter(names[4], "OpenGLES"),
        Adapter(names[5], "Vulkan", "CPU"),
        Adapter(names[6], "OpenGL", "CPU"),
    ]
    adapters(monkeypatch, llvmpipe, gl, lavapipe, virtual, integrated, old, discrete)
    assert [gpu.device for gpu in wgpu_device.gpus()] == names
    assert wgpu_device.name_of(expected[-1]) == "llvmpipe, OpenGL, software"
    monkeypatch.setenv("WGPUPY_WGPU_ADAPTER_NAME", "via Vulkan")
    assert [gpu.device for gpu in wgpu_device.gpus()] == ["discrete", "virtual", "lavapipe"]


@pytest.fixture
def no_choice_yet() -> Iterator[None]:
    """Forget the GPU that was chosen, before and after a test."""
    wgpu_renderer.usable_gpu.cache_clear()
    yield
    wgpu_renderer.usable_gpu.cache_clear()


@pytest.mark.usefixtures("no_choice_yet")
def test_a_gpu_that_cannot_render_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = as_scene(as_float32(BASE), "mobile_gs")
    real = wgpu_device.gpus()
    adapters(monkeypatch, Adapter("weak"), *real)
    assert WgpuRenderer(scene).program.gpu == wgpu_device.name_of(
        wgpu_renderer.usable_gpu(False, False)
    )
    assert "weak" not in WgpuRenderer(scene).program.gpu
    adapters(monkeypatch, Adapter("weak"), Adapter("old", "OpenGL"))
    wgpu_renderer.usable_gpu.cache_clear()
    with pytest.raises(InputError, match=r"weak, Vulkan cannot run .*limit is too low.*; old, "):
        WgpuRenderer(scene)
    with pytest.raises(InputError, match=r"weak, Vulkan cannot blend and filter 32-bit.*mesa-vulk"):
        WgpuRenderer(scene, full_precision=True)


@pytest.mark.usefixtures("no_choice_yet")
def test_opengl_is_used_only_if_it_agrees_with_the_reference(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = as_scene(as_float32(BASE), "mobile_gs")
    gpu = WgpuRenderer(scene).program.gpu
    monkeypatch.setattr(wgpu_renderer, "draws_by_opengl", lambda _: True)
    wgpu_renderer.usable_gpu.cache_clear()
    assert WgpuRenderer(scene).program.gpu == gpu
    monkeypatch.setattr(wgpu_renderer, "agreement", lambda _: 12.0)
    wgpu_renderer.usable_gpu.cache_clear()
    with pytest.raises(InputError, match=r"renders wrong images \(12 dB\)"):
        WgpuRenderer(scene)


def test_without_a_gpu_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    adapters(monkeypatch)
    with pytest.raises(InputError, match="Vulkan driver"):
        wgpu_device.gpus()


def test_a_lost_gpu_is_reported_and_opened_again() -> None:
    scene, view = as_scene(as_float32(BASE), "mobile_gs"), camera().to(dtype=torch.float32)
    renderer = WgpuRenderer(scene)
    before = renderer.render(view).image
    renderer.program.device.destroy()
    for use in (lambda: WgpuRenderer(scene), lambda: renderer.render(view), renderer.milliseconds):
        with pytest.raises(InputError, match=r"failed \(Parent device is lost\): install or"):
            use()
    torch.testing.assert_close(WgpuRenderer(scene).render(view).image, before, rtol=0, atol=2e-3)


LOST = """
from mobilegs.view import wgpu_device
program = wgpu_device.program_of(wgpu_device.gpus()[0], False, False)
program.device.destroy()
with wgpu_device.translated_abort(program.gpu):
    program.device.queue.submit([])
"""


def test_a_gpu_that_is_lost_while_it_draws_ends_the_program_with_a_sentence() -> None:
    done = subprocess.run([sys.executable, "-c", LOST], capture_output=True, text=True)
    assert done.returncode == 2, done.stderr
    assert done.stderr.splitlines()[-1].startswith("mobilegs: the GPU ")
    assert "was lost while it drew: install or" in done.stderr


# --- the check of `mobilegs doctor`


def test_each_gpu_is_compared_with_the_reference() -> None:
    checks = wgpu_check.check_gpus()
    assert len(checks) == len(wgpu_device.gpus())
    assert any(not check.problem and (check.decibels or 0) >= 50 for check in checks)


def test_doctor_believes_only_images_that_are_right(monkeypatch: pytest.MonkeyPatch) -> None:
    gpu = wgpu_device.gpus()[0]
    monkeypatch.setattr(wgpu_check, "agreement", lambda _: 20.0)
    wrong = wgpu_check.check(gpu)
    assert wrong.problem == "its images are wrong (20 dB)"
    weak = wgpu_check.Check("weak", None, "weak cannot run the renderer")
    right = wgpu_check.Check("right", 60.0, "")
    for found, state in (([wrong, weak], "no"), ([weak, right], "yes"), ([right], "yes")):
        monkeypatch.setattr(wgpu_check, "check_gpus", lambda found=found: found)
        finding = doctor.gpu_renderer()
        assert finding.state == state and bool(finding.remedy) == (state == "no")
        assert all(one.gpu in finding.found for one in found)
        monkeypatch.setenv("DISPLAY", ":0")
        assert doctor.window(finding).state == state


@pytest.mark.parametrize(
    ("program", "sentence"),
    [
        ("import os; os.abort()", "driver crashed while it drew"),
        ("print('\"no GPU was found: install\"'); raise SystemExit(2)", "^no GPU was found"),
        ("import time; time.sleep(60)", "took more than 1 s"),
    ],
)
def test_a_driver_that_crashes_or_hangs_does_not_end_doctor(
    program: str, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = subprocess.run
    monkeypatch.setattr(wgpu_check, "SECONDS_MAX", 1.0 if "sleep" in program else 60.0)
    monkeypatch.setattr(
        subprocess, "run", lambda _, **options: run([sys.executable, "-c", program], **options)
    )
    with pytest.raises(InputError, match=sentence):
        wgpu_check.check_gpus()
    assert doctor.gpu_renderer().state == "no"
