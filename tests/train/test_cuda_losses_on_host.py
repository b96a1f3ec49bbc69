"""The CUDA kernels of losses, emulated on the CPU, against the reference; one test is for GPUs."""

from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.render.kernels import cuda
from mobilegs.train.cuda_losses import CudaPhotoLoss
from mobilegs.train.losses import distillation_loss, front_loss, photo_loss, photo_loss_and_error
from tests.support.cuda_on_host import HostKernels

SIZES = [(1, 1), (5, 7), (33, 17), (64, 48)]
PARTS = ["terms", "finish", "gradient"]
MASKS = ["none", "random", "zeros", "soft"]

Loss = Callable[..., tuple[Tensor, ...]]
Inputs = dict[str, Tensor | None]


@pytest.fixture(autouse=True)
def kernels(on_host: HostKernels) -> HostKernels:
    return on_host


def rand(*size: int, seed: int) -> Tensor:
    """Random numbers in [0, 1) that float32 holds."""
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(*size, generator=generator).double()


def mask_of(kind: str, size: tuple[int, int]) -> Tensor | None:
    if kind == "none":
        return None
    random = rand(*size, seed=9)
    return {"random": (random > 0.4).double(), "zeros": 0 * random, "soft": random}[kind]


def photo_terms(image: Tensor, photo: Tensor, mask: Tensor | None) -> tuple[Tensor, ...]:
    return photo_loss_and_error(image, photo, mask=mask, ssim_weight=0.3)


def distillation(color_weight: float = 0.7, depth_weight: float = 1.3) -> Loss:
    def call(image: Tensor, depth: Tensor, alpha: Tensor, *others: Tensor) -> tuple[Tensor, ...]:
        teacher, teacher_depth, mask = others
        weights = {"color_weight": color_weight, "depth_weight": depth_weight}
        return (
            distillation_loss(image, depth, alpha, teacher, teacher_depth, mask=mask, **weights),
        )

    return call


def results(
    loss: Loss,
    inputs: Inputs,
    trained: list[str],
    dtype: torch.dtype = torch.float32,
    device: str = "cpu",
) -> dict[str, Tensor]:
    """Return what a loss returns, and the gradient of thrice the first, by names of inputs."""
    held = {name: t if t is None else t.to(device, dtype) for name, t in inputs.items()}
    leaves = {name: t.detach().clone() for name in trained if (t := held[name]) is not None}
    values = loss(*(held | {name: leaf.requires_grad_() for name, leaf in leaves.items()}).values())
    gradients = torch.autograd.grad(3 * values[0], list(leaves.values()))
    assert not any(value.requires_grad for value in values[1:])
    found = {f"value {i}": value.detach() for i, value in enumerate(values)}
    found |= dict(zip(leaves, gradients, strict=True))
    return {name: value.cpu() for name, value in found.items()}


def compare(loss: Loss, inputs: Inputs, trained: list[str], *, device: str = "cpu") -> None:
    found = results(loss, inputs, trained, device=device)
    for name, value in results(loss, inputs, trained, torch.float64).items():
        ours = found[name].double()
        assert ours.shape == value.shape, name
        assert torch.equal(ours.isnan(), value.isnan()), name
        error = (ours - value).nan_to_num().norm()
        print(f"{name:10s} {error:.2e} of {value.nan_to_num().norm():.2e}")
        floor = 1e-6 if name.startswith("value") else 1e-7  # a variance is a difference of squares
        assert error <= 5e-6 * value.nan_to_num().norm() + floor, name


def photos(size: tuple[int, int], masked: str = "none") -> Inputs:
    image, photo = rand(*size, 3, seed=1), rand(*size, 3, seed=2)
    return {"image": image, "photo": photo, "mask": mask_of(masked, size)}


def teachers(size: tuple[int, int], masked: str = "none") -> Inputs:
    depth, teacher_depth = (5 * rand(*size, seed=seed) for seed in (3, 4))
    depth[rand(*size, seed=5) > 0.9] = 0
    teacher_depth[rand(*size, seed=6) > 0.8] = 0
    return {
        "image": rand(*size, 3, seed=1),
        "depth": depth,
        "alpha": 0.3 + 0.7 * rand(*size, seed=7),
        "teacher": rand(*size, 3, seed=2),
        "teacher_depth": teacher_depth,
        "mask": mask_of(masked, size),
    }


@pytest.mark.parametrize("masked", MASKS)
@pytest.mark.parametrize("size", SIZES)
def test_the_photo_loss_is_that_of_the_reference(size: tuple[int, int], masked: str) -> None:
    inputs = photos(size, masked)
    compare(photo_terms, inputs, ["image"])
    image, photo, mask = (None if t is None else t.float() for t in inputs.values())
    assert image is not None and photo is not None
    expected = photo_loss_and_error(image, photo, mask=mask)[0]
    assert photo_loss(image, photo, mask=mask) == expected


def test_equal_images_have_no_photo_loss() -> None:
    image = rand(33, 17, 3, seed=1)
    found = results(photo_terms, {"image": image, "photo": image, "mask": None}, ["image"])
    assert abs(found["value 0"]) < 1e-7 and found["value 1"] == 0
    assert found["image"].abs().max() < 1e-6


@pytest.mark.parametrize("masked", ["none", "random"])
def test_colors_outside_of_the_range_have_the_photo_loss_of_the_reference(masked: str) -> None:
    inputs = photos((33, 17), masked)
    assert inputs["image"] is not None
    compare(photo_terms, inputs | {"image": 4 * inputs["image"] - 1.5}, ["image"])


def test_masked_pixels_of_the_photo_loss_may_hold_anything() -> None:
    inputs = photos((33, 17), "random")
    image, mask = inputs["image"], inputs["mask"]
    assert image is not None and mask is not None
    other = image.masked_fill(mask[:, :, None] == 0, torch.nan)
    found = [results(photo_terms, inputs | {"image": x}, ["image"]) for x in (image, other)]
    for name, value in found[0].items():
        assert torch.equal(value, found[1][name]), name


@pytest.mark.parametrize("masked", MASKS)
@pytest.mark.parametrize("size", SIZES)
def test_distillation_is_that_of_the_reference(size: tuple[int, int], masked: str) -> None:
    compare(distillation(), teachers(size, masked), ["image", "depth", "alpha"])


def test_distillation_without_depths_or_colors_is_that_of_the_reference() -> None:
    inputs = teachers((33, 17), "random")
    compare(distillation(), inputs | {"depth": None}, ["image"])
    compare(distillation(depth_weight=0.0), inputs, ["image", "depth", "alpha"])
    compare(distillation(color_weight=0.0), inputs, ["image", "depth", "alpha"])


def test_equal_images_and_depths_have_no_distillation_loss() -> None:
    inputs = teachers((33, 17))
    depth, alpha = inputs["depth"], inputs["alpha"]
    assert depth is not None and alpha is not None
    inputs |= {"teacher": inputs["image"], "teacher_depth": 2 * depth / alpha}
    found = results(distillation(), inputs, ["image", "depth", "alpha"])
    assert abs(found["value 0"]) < 1e-6 and not found["image"].any()
    assert found["depth"].abs().max() < 1e-6 and found["alpha"].abs().max() < 1e-6


@pytest.mark.parametrize("size", SIZES)
def test_the_difference_of_coverages_is_that_of_the_reference(size: tuple[int, int]) -> None:
    inputs: Inputs = {"coverage": rand(*size, seed=1), "target": rand(*size, seed=2)}
    compare(lambda *both: (front_loss(*both),), inputs, ["coverage"])


def test_inputs_of_other_strides_have_the_same_losses() -> None:
    inputs = photos((33, 17), "random")
    turned = {
        name: None if t is None else t.transpose(0, 1).contiguous().transpose(0, 1)
        for name, t in inputs.items()
    }
    found = [results(photo_terms, each, ["image"]) for each in (inputs, turned)]
    for name, value in found[0].items():
        assert torch.equal(value, found[1][name]), name


def test_bits_do_not_depend_on_the_order_of_threads(kernels: HostKernels) -> None:
    for loss, inputs, trained in (
        (photo_terms, photos((64, 48), "random"), ["image"]),
        (distillation(), teachers((64, 48), "random"), ["image", "depth", "alpha"]),
    ):
        found = []
        for turned in (False, True):
            kernels.reverse(turned)
            found.append(results(loss, inputs, trained))
        for name, value in found[0].items():
            assert torch.equal(value, found[1][name]), name


def test_a_loss_and_its_gradient_launch_every_kernel_once(kernels: HostKernels) -> None:
    results(photo_terms, photos((5, 7)), ["image"])
    results(distillation(), teachers((5, 7)), ["image"])
    expected = [f"mgs_{loss}_{part}" for loss in ("photo", "distill") for part in PARTS]
    assert kernels.launched == expected
    _, log = cuda.compile_kernels("sm_90")
    compiled = [line.split("'")[1] for line in log.splitlines() if "Compiling entry" in line]
    ours = [name for name in compiled if name.startswith(("mgs_photo", "mgs_distill"))]
    assert sorted(ours) == sorted(expected)


@pytest.mark.parametrize("bad", [torch.rand(5, 8, 3), torch.rand(5, 7, 3).double()])
def test_a_photo_that_does_not_fit_is_refused(bad: Tensor) -> None:
    with pytest.raises(InputError, match=r"\[5, 7, 3\], torch.float32, on cpu was expected"):
        CudaPhotoLoss.apply(torch.rand(5, 7, 3), bad, None, 0.2)


@pytest.mark.gpu
@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs an NVIDIA GPU")
@pytest.mark.parametrize("masked", ["none", "random"])
def test_losses_on_a_gpu_are_those_of_the_reference(
    masked: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    for loss, inputs, trained in (
        (photo_terms, photos((533, 801), masked), ["image"]),
        (distillation(), teachers((533, 801), masked), ["image", "depth", "alpha"]),
    ):
        compare(loss, inputs, trained, device="cuda")
        found = [results(loss, inputs, trained, device="cuda") for _ in range(2)]
        assert all(torch.equal(value, found[1][name]) for name, value in found[0].items())
