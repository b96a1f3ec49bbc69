"""The CUDA kernels of terms without an image, emulated on the CPU, against the references."""

import math
from collections.abc import Callable
from typing import Any

import pytest
import torch
from torch import Tensor
from torch.nn import Parameter
from torch.testing import assert_close

from mobilegs.csrc import binding
from mobilegs.representation.rotations import RotationQuantizer
from mobilegs.representation.uniform_quantizer import CODE_LIMIT, UniformQuantizer
from mobilegs.train.student import cuda_terms, quantization
from tests.support.cuda_on_host import HostKernels

ALPHA_MIN = 1 / 64
COUNT = 700  # three blocks, the last one not full


@pytest.fixture(autouse=True)
def kernels(on_host: HostKernels) -> HostKernels:
    return on_host


def difference(found: Tensor, expected: Tensor) -> float:
    """Return the norm of the difference as a share of that of `expected`."""
    error, size = float((found - expected).norm()), float(expected.norm())
    return error if size == 0 else error / size


def leaves(**shapes: tuple[int, ...]) -> dict[str, Parameter]:
    """Return columns of several means and spreads, some with gradients."""
    generator, made = torch.Generator().manual_seed(0), {}
    for name, shape in shapes.items():
        spreads = torch.logspace(-2, 1, math.prod(shape[1:])).view(shape[1:])
        made[name] = Parameter(5 * spreads + spreads * torch.randn(shape, generator=generator))
        if len(made) % 2:
            made[name].grad = torch.randn(shape, generator=generator)
    return made


def copied(tensors: dict[str, Parameter], dtype: torch.dtype) -> dict[str, Parameter]:
    found = {name: Parameter(values.detach().to(dtype)) for name, values in tensors.items()}
    for name, values in tensors.items():
        found[name].grad = None if values.grad is None else values.grad.to(dtype)
    return found


def early_case(kind: str) -> dict[str, Parameter]:
    count = {"none": 0, "one": 1}.get(kind, COUNT)
    shapes: dict[str, tuple[int, ...]] = {"log_scales": (count, 3), "quats": (count, 4)}
    shapes |= {"logit_opacities": (count,), "lobe_latents": (count, 32), "static": (count, 3)}
    found = leaves(**shapes, view=(count, 0 if kind == "empty" else 9))
    if kind == "constant":
        for values in found.values():
            values.data[:] = 3.75  # whose mean has no rounding error
    return found


@pytest.mark.parametrize("kind", ["random", "constant", "none", "one", "empty"])
def test_early_rate_gradients_agree_with_the_reference(
    kind: str,
    kernels: HostKernels,
) -> None:
    found = early_case(kind)
    expected = copied(found, torch.float64)
    quantization.add_early_rate_gradients(found, 300.0)
    assert kernels.launched == ["mgs_early_rate_sums", "mgs_early_rate"]
    if kind == "empty":
        grad = found.pop("view").grad
        assert grad is not None and grad.shape == (COUNT, 0)
        # the reference has no means of no columns
        del expected["view"]
    quantization.add_early_rate_gradients(expected, 300.0)
    for name, values in found.items():
        grad, reference = values.grad, expected[name].grad
        assert grad is not None and reference is not None
        assert difference(grad, reference) <= 2e-6, name


def rate_case(kind: str) -> tuple[dict[Any, UniformQuantizer], dict[str, Parameter]]:
    count = 1 if kind == "one" else COUNT
    tensors = leaves(scale=(count, 3), appearance=(count, 12), opacity=(count, 1), lobes=(count, 5))
    if kind == "constant":
        for values in tensors.values():
            values.data[:] = 3.75  # whose mean has no rounding error
    quantizers = {}
    for name, values in tensors.items():
        generator = torch.Generator().manual_seed(1)
        if kind == "limits":  # codes and values on both sides of the range
            values.data[:, 0] = 1e3 * torch.randn(count, generator=generator)
        quantizers[name] = UniformQuantizer.fit(values.detach(), step_size=0.3)
        quantizers[name].log_step_offset.data.fill_(0.1)
    if kind == "limits":
        assert all(codes.indices.abs().max() == CODE_LIMIT for codes in quantizers.values())
    return quantizers, tensors


@pytest.mark.parametrize("kind", ["random", "limits", "constant", "one"])
def test_rate_gradients_agree_with_the_reference(
    kind: str,
    kernels: HostKernels,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    quantizers, found = rate_case(kind)
    offsets = [codes.log_step_offset for codes in quantizers.values()]
    expected = copied(found, torch.float32)
    with monkeypatch.context() as patch:
        for module in (cuda_terms, binding):
            patch.setattr(module, "supports", lambda *tensors: False)
        quantization.add_rate_gradients(quantizers, expected, 300.0)
    of_steps = [offset.grad for offset in offsets]
    assert not kernels.launched
    for offset in offsets:
        offset.grad = None
    quantization.add_rate_gradients(quantizers, found, 300.0)
    assert kernels.launched == ["mgs_count_codes", "mgs_rate", "mgs_rate_total"]
    for name, values in found.items():
        grad, reference = values.grad, expected[name].grad
        assert grad is not None and reference is not None
        assert difference(grad, reference) <= 2e-6, name
    for offset, reference in zip(offsets, of_steps, strict=True):
        assert offset.grad is not None and reference is not None
        assert_close(offset.grad.double(), reference.double(), rtol=1e-5, atol=1e-4)
        before = offset.grad.clone()
        (2 * offset).backward()  # that of a loss is added
        assert offset.grad == before + 2


def test_the_rate_of_values_that_are_not_numbers_ends() -> None:
    quantizers, tensors = rate_case("random")
    tensors["scale"].data[3, 1], tensors["scale"].data[5, 0] = math.nan, -math.inf
    quantization.add_rate_gradients(quantizers, tensors, 1.0)
    assert all(t.grad is not None and bool(t.grad.isfinite().all()) for t in tensors.values())


def rotation_case() -> tuple[dict[Any, RotationQuantizer], dict[str, Parameter]]:
    generator = torch.Generator().manual_seed(2)
    quats = torch.randn(COUNT, 4, generator=generator)
    scales = UniformQuantizer.fit(torch.randn(COUNT, 3, generator=generator), step_size=0.2)
    codes = RotationQuantizer.fit(quats, scales=scales, step_size=0.003)
    return {"rotation": codes}, {"rotation": Parameter(quats)}


def test_the_rate_of_rotations_agrees_with_the_reference(
    kernels: HostKernels,
) -> None:
    quantizers, tensors = rotation_case()
    offset = quantizers["rotation"].log_step_offset
    expected = 7 * quantizers["rotation"].log_step_gradient(tensors["rotation"])
    offset.grad = torch.tensor(1.5)
    quantization.add_rate_gradients(quantizers, tensors, 7.0)
    assert kernels.launched == ["mgs_count_angles", "mgs_angle_bits"]
    assert offset.grad.item() == pytest.approx(1.5 + expected, rel=1e-4)
    assert abs(expected) > 0.1
    assert tensors["rotation"].grad is None


def early_results() -> list[Tensor | None]:
    tensors = early_case("random")
    quantization.add_early_rate_gradients(tensors, 1.0)
    return [values.grad for values in tensors.values()]


def rate_results() -> list[Tensor | None]:
    quantizers, tensors = rate_case("random")
    rotation, quats = rotation_case()
    quantization.add_rate_gradients(quantizers | rotation, tensors | quats, 1.0)
    offsets = [codes.log_step_offset for codes in (quantizers | rotation).values()]
    return [leaf.grad for leaf in (*offsets, *tensors.values())]


@pytest.mark.parametrize("results", [early_results, rate_results])
def test_results_do_not_depend_on_the_order_of_threads(
    results: Callable[[], list[Tensor | None]],
    kernels: HostKernels,
) -> None:
    first = results()
    kernels.reverse(True)
    for one, other in zip(first, results(), strict=True):
        assert one is not None and other is not None and torch.equal(one, other)
