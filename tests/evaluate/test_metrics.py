"""Metrics against other implementations, and the report of a run."""

import http.server
import json
import math
import threading
from functools import partial
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest
import torch
from PIL import Image
from torch import Tensor, nn
from torchmetrics.functional.image import lpips as other_lpips
from torchmetrics.functional.image import (
    peak_signal_noise_ratio,
    structural_similarity_index_measure,
)

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, Frame
from mobilegs.errors import InputError
from mobilegs.evaluate.contact_sheet import contact_sheet
from mobilegs.evaluate.lpips import (
    BACKBONES,
    LPIPS_NAMES,
    Lpips,
    LpipsSuite,
    Net,
    expected_shapes,
    fetch_weights,
)
from mobilegs.evaluate.metrics import (
    color_corrected_psnr,
    decibels,
    displayed_colors,
    fitted_color,
    neutral_rms,
    psnr,
    ssim,
    ssim_map,
)
from mobilegs.evaluate.report import (
    SceneMetrics,
    ViewMetrics,
    evaluate,
    evaluate_side_by_side,
    peak_memory_mib,
    to_json,
)
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import rgb_to_sh0


def pictures(generator: torch.Generator, h: int = 48, w: int = 64) -> tuple[Tensor, Tensor]:
    one = torch.rand(h, w, 3, generator=generator)
    return one, (one + 0.1 * torch.randn(h, w, 3, generator=generator)).clamp(0, 1)


def batched(image: Tensor) -> Tensor:
    return image.permute(2, 0, 1)[None]


def test_psnr_agrees_with_torchmetrics(generator: torch.Generator) -> None:
    image, target = pictures(generator)
    assert psnr(image, target) == pytest.approx(
        float(peak_signal_noise_ratio(image, target, data_range=1.0)), abs=1e-4
    )


def test_equal_images_have_infinite_psnr_and_ssim_1(generator: torch.Generator) -> None:
    image, _ = pictures(generator)
    assert psnr(image, image) == math.inf
    assert ssim(image, image) == pytest.approx(1)


def test_ssim_inside_the_border_agrees_with_torchmetrics(generator: torch.Generator) -> None:
    image, target = pictures(generator)
    _, reference = structural_similarity_index_measure(
        batched(image), batched(target), data_range=1.0, return_full_image=True
    )
    ours = batched(ssim_map(image, target))
    assert torch.allclose(ours[..., 5:-5, 5:-5], reference[..., 5:-5, 5:-5], atol=1e-4)


def test_ssim_pads_with_zeros(generator: torch.Generator) -> None:
    image, target = pictures(generator)
    framed = [nn.functional.pad(picture, (0, 0, 5, 5, 5, 5)) for picture in (image, target)]
    assert torch.allclose(ssim_map(*framed)[5:-5, 5:-5], ssim_map(image, target), atol=1e-5)


def test_a_mask_leaves_pixels_out_of_psnr_and_ssim(generator: torch.Generator) -> None:
    image, target = pictures(generator)
    mask = torch.zeros(48, 64, dtype=torch.bool)
    mask[:20] = True
    spoiled = torch.where(mask[..., None], image, 1 - target)
    assert psnr(spoiled, target, mask) == pytest.approx(psnr(image[:20], target[:20]))
    assert ssim(image, target, mask) == pytest.approx(float(ssim_map(image, target)[:20].mean()))


def test_displayed_values_are_clamped_and_rounded_to_8_bits() -> None:
    image = torch.tensor([[[-1.0, 0.5, 7.0], [torch.nan, 0.1, 1.0]]])
    shown = displayed_colors(image) * 255
    assert torch.allclose(shown, torch.tensor([[[0.0, 128.0, 255.0], [0.0, 26.0, 255.0]]]))


# --- LPIPS ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def weights_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Weights of both networks, random but of a size that keeps signals alive."""
    folder = tmp_path_factory.mktemp("lpips")
    rng = np.random.default_rng(0)
    for backbone in BACKBONES.values():
        arrays = {}
        for name, shape in expected_shapes(backbone).items():
            fan_in = math.prod(shape[1:])
            spread = math.sqrt(2 / fan_in) if name.endswith("weight") else 0.1
            values = spread * rng.standard_normal(shape, dtype=np.float32)
            arrays[name] = (np.abs(values) if name.startswith("lin") else values).astype(np.float16)
        np.savez(folder / backbone.file, **arrays)
    return folder


VGG = "C C P C C P C C C P C C C P C C C P".split()
ALEX = "C P C P C C C P".split()


def torchvision_features(net: Net, folder: Path) -> nn.Sequential:
    """The backbone as torchvision would lay it out, with our weights."""
    backbone = BACKBONES[net]
    layers: list[nn.Module] = []
    convolutions = iter(backbone.layers)
    with np.load(folder / backbone.file) as arrays:
        for kind in {"vgg": VGG, "alex": ALEX}[net]:
            if kind == "P":
                layers.append(nn.MaxPool2d({"vgg": 2, "alex": 3}[net], 2))
                continue
            layer = next(convolutions)
            out, into, side = layer.shape
            i = sum(isinstance(module, nn.Conv2d) for module in layers)
            conv = nn.Conv2d(into, out, side, layer.stride, layer.padding)
            conv.weight.data = torch.from_numpy(arrays[f"conv{i}.weight"].astype(np.float32))
            assert conv.bias is not None
            conv.bias.data = torch.from_numpy(arrays[f"conv{i}.bias"].astype(np.float32))
            layers += [conv, nn.ReLU()]
    return nn.Sequential(*layers)


@pytest.mark.parametrize(("net", "rescale"), [("vgg", True), ("alex", False)])
def test_lpips_agrees_with_torchmetrics(
    net: Net,
    rescale: bool,
    weights_dir: Path,
    generator: torch.Generator,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    features = torchvision_features(net, weights_dir)
    monkeypatch.setattr(other_lpips, "_get_tv_model_features", lambda *_: features)
    reference = other_lpips._LPIPS(pretrained=False, net=net, use_dropout=False)
    metric = Lpips(net, weights_dir)
    for layer, head in zip(reference.lins, metric.heads, strict=True):
        layer.model[-1].weight.data = head.view(1, -1, 1, 1)  # pyright: ignore
    target, image = pictures(generator)
    expected = float(reference(batched(target), batched(image), normalize=rescale))
    same, found = metric.distances(target, [target, image], rescale=rescale)
    assert same == 0
    assert expected > 1e-3
    assert found == pytest.approx(expected, rel=1e-4)


def test_an_image_too_small_for_the_networks_has_no_lpips(weights_dir: Path) -> None:
    tiny = torch.zeros(31, 40, 3)
    assert LpipsSuite(weights_dir).distances(tiny, [tiny]) == [dict.fromkeys(LPIPS_NAMES)]


def test_weights_of_another_network_are_refused(weights_dir: Path, tmp_path: Path) -> None:
    (tmp_path / "lpips_vgg16.npz").symlink_to(weights_dir / "lpips_alexnet.npz")
    with pytest.raises(InputError, match="lacks an array"):
        Lpips("vgg", tmp_path)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 no zip", b"{}"])
def test_damaged_weights_are_refused(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "lpips_alexnet.npz").write_bytes(content)
    with pytest.raises(InputError, match="damaged"):
        Lpips("alex", tmp_path)


def test_missing_weights_are_refused_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--lpips-weights"):
        Lpips("alex", tmp_path)


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        pass


def test_weights_are_downloaded_once(
    weights_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    handler = partial(QuietHandler, directory=str(weights_dir))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}/"
        folder = fetch_weights(address)
        server.shutdown()
    assert fetch_weights(address) == folder  # the server is gone
    for backbone in BACKBONES.values():
        assert (folder / backbone.file).read_bytes() == (weights_dir / backbone.file).read_bytes()


def test_a_failed_download_gives_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(InputError, match="cannot download LPIPS weights"):
        fetch_weights("http://127.0.0.1:9/weights")
    assert not list(tmp_path.rglob("*.npz"))


# --- the report ----------------------------------------------------------------------------------

CAMERA = Camera(torch.eye(4), torch.tensor([[40.0, 0, 20], [0, 40, 16], [0, 0, 1]]), 40, 32)


def blob(color: float) -> Scene:
    """One opaque Gaussian in the middle of the picture, on black."""
    return Scene(
        Gaussians(
            torch.tensor([[0.0, 0, 2]]),
            torch.tensor([[1.0, 0, 0, 0]]),
            torch.full((1, 3), -2.0),
            torch.tensor([3.0]),
            rgb_to_sh0(torch.full((1, 3), color))[:, None],
        )
    )


def test_a_change_of_colours_is_found_and_does_not_count(generator: torch.Generator) -> None:
    image = 0.2 + 0.5 * torch.rand(20, 30, 3, generator=generator)
    change = torch.tensor([[1.2, 0.05, 0.0, -0.05], [0.0, 0.9, 0.1, 0.02], [0.03, 0.0, 1.0, 0.0]])
    target = image @ change[:, :3].T + change[:, 3]
    found = fitted_color(image, target)
    torch.testing.assert_close(found.float(), change, atol=1e-3, rtol=0)
    assert psnr(image, target) < 30 < 45 < color_corrected_psnr(image, target)
    noisy = (target + 0.02 * torch.randn(20, 30, 3, generator=generator)).clamp(0.01, 0.99)
    x = np.concatenate([image.reshape(-1, 3).numpy(), np.ones((600, 1))], axis=1)
    expected, *_ = np.linalg.lstsq(x, noisy.reshape(-1, 3).numpy(), rcond=None)
    np.testing.assert_allclose(fitted_color(image, noisy).numpy(), expected.T, atol=1e-3)


def test_only_the_colour_of_whites_and_greys_counts() -> None:
    target = torch.full((20, 20, 3), 0.6)
    target[:, 10:] = torch.tensor([0.9, 0.2, 0.2])  # red
    target[:10, :5] = 0.1  # dark
    image = target + 0.1  # brighter
    image[:, 10:, 1] += 0.3
    image[:10, :5, 2] += 0.3
    assert neutral_rms(image, target) == pytest.approx(0, abs=1e-4)
    image[10:, :10, 0] += 0.03  # 100 of 150 pixels
    # two thirds, one third and one third of the shift from the mean
    expected = 255 * 0.03 * math.sqrt((4 + 1 + 1) / 27 * 100 / 150)
    assert neutral_rms(image, target) == pytest.approx(expected, rel=1e-4)
    mask = torch.zeros(20, 20, dtype=torch.bool)
    mask[:10] = True
    assert neutral_rms(image, target, mask) is None  # 50 pixels


def test_clipped_and_masked_pixels_tell_no_colour(generator: torch.Generator) -> None:
    image = 0.3 + 0.4 * torch.rand(20, 30, 3, generator=generator)
    target = (1.3 * image).clone()
    target[:5], target[5:10] = 1.0, 0.0  # clipped
    target[10:12] = 0.5
    mask = torch.ones(20, 30, dtype=torch.bool)
    mask[10:12] = False
    found = fitted_color(image, target, mask)
    torch.testing.assert_close(found.float(), 1.3 * torch.eye(3, 4), atol=1e-3, rtol=0)
    nothing = torch.zeros(20, 30, dtype=torch.bool)
    assert torch.equal(fitted_color(image, target, nothing).float(), torch.eye(3, 4))
    grey = torch.full((4, 4, 3), 0.5)
    assert fitted_color(grey, 0.8 * grey).isfinite().all()


def capture_of(scene: Scene, *, masked: bool = False) -> Dataset:
    pixels = (scene.render(CAMERA).image * 255).round().to(torch.uint8)
    frames = [Frame(f"photo_{i}.jpg", CAMERA, pixels=pixels) for i in range(3)]
    return Dataset(
        "blob", frames[:1], frames[1:], torch.zeros(0, 3), torch.zeros(0, 3), 1.0, torch.zeros(3),
        torch.zeros(3), 0.2,
    )  # fmt: skip


def test_a_scene_equal_to_the_photo_has_the_best_metrics() -> None:
    dataset = capture_of(blob(0.8))
    results = evaluate_side_by_side({"teacher": blob(0.8), "student": blob(0.4)}, dataset)
    assert results["teacher"]["psnr"] == math.inf
    assert results["teacher"]["ssim"] == pytest.approx(1)
    assert 10 < results["student"]["psnr"] < 40
    assert [view["name"] for view in results["student"]["views"]] == ["photo_1.jpg", "photo_2.jpg"]
    assert results["student"]["lpips_vgg"] is None


def test_masked_pixels_do_not_count(tmp_path: Path) -> None:
    photo = (blob(0.8).render(CAMERA).image * 255).round().to(torch.uint8)
    mask = torch.zeros(32, 40, dtype=torch.uint8)
    mask[:, :30] = 255
    photo[:, 30:] = 200  # spoiled where it does not count
    Image.fromarray(photo.numpy()).save(tmp_path / "photo.png")
    Image.fromarray(mask.numpy()).save(tmp_path / "mask.png")
    frame = Frame("photo.png", CAMERA, tmp_path / "photo.png", tmp_path / "mask.png")
    dataset = capture_of(blob(0.8))
    dataset.test[:] = [frame]
    result = evaluate(blob(0.8), dataset)
    assert result["psnr"] == math.inf
    assert result["ssim"] == pytest.approx(1)


def test_a_view_without_a_pixel_is_left_out_and_counted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    Image.new("L", (40, 32), 0).save(tmp_path / "mask.png")
    Image.new("RGB", (40, 32), (9, 9, 9)).save(tmp_path / "photo.png")
    empty = Frame("photo.png", CAMERA, tmp_path / "photo.png", tmp_path / "mask.png")
    dataset = capture_of(blob(0.8))
    dataset.test.append(empty)
    result = evaluate(blob(0.4), dataset)
    assert 10 < result["psnr"] < 40 and len(result["views"]) == 2
    assert "1 held-back views are masked whole and do not count" in caplog.text
    dataset.test[:] = [empty]
    with pytest.raises(InputError, match="masks leave no pixel"):
        evaluate(blob(0.4), dataset)
    texts = [decibels(value) for value in (math.nan, math.inf, 20.123)]
    assert texts == ["all masked", "no error", "20.12 dB"]


def test_a_capture_without_held_back_views_is_refused() -> None:
    dataset = capture_of(blob(0.8))
    dataset.test.clear()
    with pytest.raises(InputError, match="holds no view back"):
        evaluate(blob(0.8), dataset)


def test_metrics_are_json() -> None:
    results = evaluate_side_by_side({"a": blob(0.8), "b": blob(0.4)}, capture_of(blob(0.8)))
    written = json.loads(to_json(results))
    assert written["a"]["psnr"] is None  # infinite, which JSON cannot say
    assert written["b"]["psnr"] == pytest.approx(results["b"]["psnr"])
    assert written["a"].keys() == {*get_type_hints(SceneMetrics)}
    assert written["a"]["views"][0].keys() == {*get_type_hints(ViewMetrics)}
    assert (peak_memory_mib() or 0) > 50


def test_the_contact_sheet_shows_photo_teacher_student_and_error(tmp_path: Path) -> None:
    contact_sheet(tmp_path / "sheet.png", capture_of(blob(0.8)), blob(0.8), blob(0.4), views=2)
    sheet = np.array(Image.open(tmp_path / "sheet.png"))
    cell, row = sheet.shape[1] // 4, sheet.shape[0] // 2
    center = [tuple(sheet[row // 2 - 10, i * cell + cell // 2].tolist()) for i in range(4)]
    photo, teacher, student, error = center
    assert photo == teacher
    assert max(student) < min(photo)
    assert min(error) > max(student)  # amplified four times
