"""The losses against their formulas, their masks, and their gradients."""

import pytest
import torch
from torch import Tensor

from mobilegs.evaluate import metrics
from mobilegs.train.losses import (
    color_distillation_loss,
    depth_distillation_loss,
    photo_loss,
    photo_loss_and_error,
    raw_depth_loss,
    ssim_map,
)


@pytest.fixture
def pictures(generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """An image and a photo, 13 x 17, float64, in [0, 1]."""
    shape = (13, 17, 3)
    first = torch.rand(shape, generator=generator, dtype=torch.float64)
    return first, (first + 0.3 * torch.rand(shape, generator=generator)).clamp(0, 1)


@pytest.fixture
def mask() -> Tensor:
    """1 on the left, 0 on the right of column 9."""
    mask = torch.zeros(13, 17, dtype=torch.float64)
    mask[:, :9] = 1
    return mask


def test_training_and_evaluation_have_the_same_ssim(pictures: tuple[Tensor, Tensor]) -> None:
    ours = ssim_map(*pictures)
    torch.testing.assert_close(ours, metrics.ssim_map(*pictures), atol=1e-12, rtol=0)


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize("size", [(1, 1), (3, 40), (13, 17), (100, 7)])
def test_the_kernel_of_the_photo_loss_agrees_with_the_reference(
    size: tuple[int, int], masked: bool, generator: torch.Generator
) -> None:
    image, photo = torch.rand(2, *size, 3, generator=generator, dtype=torch.float64)
    mask = (torch.rand(*size, generator=generator) > 0.5).double() if masked else None
    results = []
    for dtype in (torch.float32, torch.float64):
        leaf = image.to(dtype).requires_grad_()
        weights = None if mask is None else mask.to(dtype)
        loss, error = photo_loss_and_error(leaf, photo.to(dtype), mask=weights, ssim_weight=0.3)
        assert not error.requires_grad
        assert loss == photo_loss(leaf, photo.to(dtype), mask=weights, ssim_weight=0.3)
        (3 * loss).backward()
        assert leaf.grad is not None
        results.append((loss.detach().double(), error.double(), leaf.grad.double()))
    for kernel, definition in zip(*results, strict=True):
        assert bool((kernel.isnan() == definition.isnan()).all())
        assert (kernel - definition).nan_to_num().norm() <= 1e-4 * definition.nan_to_num().norm()


def test_the_adjoint_of_ssim_passes_gradcheck(pictures: tuple[Tensor, Tensor]) -> None:
    image, photo = (picture[:6, :5] for picture in pictures)
    assert torch.autograd.gradcheck(
        lambda x: ssim_map(x, photo).sum(2), image.clone().requires_grad_()
    )


def test_photo_loss_is_the_weighted_sum_of_l1_and_ssim(pictures: tuple[Tensor, Tensor]) -> None:
    image, photo = pictures
    expected = 0.8 * (image - photo).abs().mean() + 0.2 * (1 - metrics.ssim(image, photo))
    torch.testing.assert_close(photo_loss(image, photo), expected)


@pytest.mark.parametrize("loss", [photo_loss, color_distillation_loss])
def test_masked_pixels_neither_count_nor_receive_a_gradient(loss, pictures, mask) -> None:
    image, photo = pictures
    image = image.clone().requires_grad_()
    value = loss(image, photo, mask=mask)
    [gradient] = torch.autograd.grad(value, image)
    assert (gradient[:, 9:] == 0).all()
    assert (gradient[:, :9] != 0).any()
    other = image.detach().clone()
    other[:, 9:] = 7
    assert loss(other, photo, mask=mask) == value


@pytest.mark.parametrize("loss", [photo_loss, color_distillation_loss])
def test_a_mask_without_a_pixel_gives_zero(loss, pictures) -> None:
    assert loss(*pictures, mask=torch.zeros(13, 17, dtype=torch.float64)) == 0


def test_depth_loss_counts_only_pixels_that_both_cover() -> None:
    alpha = torch.tensor([[0.9, 0.9, 0.9, 0.4]], requires_grad=True)
    teacher = torch.tensor([[1.0, 2.0, 0.0, 5.0]])
    depth = torch.tensor([[0.9, 3.6, 0.1, 0.1]], requires_grad=True)
    loss = depth_distillation_loss(depth, alpha, teacher)
    loss.backward()
    errors = torch.tensor([1.0, 2.0]).log()  # 0.9 / 0.9 over 1, 3.6 / 0.9 over 2
    torch.testing.assert_close(loss.detach(), errors.var(correction=0))
    assert depth.grad is not None and alpha.grad is not None
    assert depth.grad[0, 2:].tolist() == [0, 0]
    assert alpha.grad.isfinite().all()


def test_raw_depth_loss_covers_all_pixels() -> None:
    depth = torch.tensor([[1.0, 0.9, 0.0, 0.2]], requires_grad=True)
    teacher = torch.tensor([[1.0, 0.0, 2.0, 0.4]])
    loss = raw_depth_loss(depth, teacher)
    loss.backward()
    errors = torch.tensor([1.0, 0.9e8, 0.5e-8, 0.5]).log()  # nothing counts as 1e-8
    torch.testing.assert_close(loss.detach(), errors.var(correction=0))
    assert depth.grad is not None and (depth.grad[0, [0, 1, 3]] != 0).all()
    mask = torch.tensor([[1.0, 0.0, 0.0, 1.0]])
    expected = errors[[0, 3]].var(correction=0)
    torch.testing.assert_close(raw_depth_loss(depth.detach(), teacher, mask=mask), expected)


def test_depth_loss_without_a_common_pixel_is_zero_with_finite_gradients() -> None:
    depth = torch.zeros(2, 2, requires_grad=True)
    loss = depth_distillation_loss(depth, torch.zeros(2, 2), torch.zeros(2, 2))
    loss.backward()
    assert loss == 0 and depth.grad is not None and (depth.grad == 0).all()
