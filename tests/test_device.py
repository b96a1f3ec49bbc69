"""Numbers that a program reads from a device: once, and anew when the tensor changes."""

import pytest
import torch

from mobilegs.device import host_values


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_numbers_follow_changes_in_place(dtype: torch.dtype) -> None:
    tensor = torch.arange(6, dtype=dtype).view(2, 3)
    assert host_values(tensor) == [0, 1, 2, 3, 4, 5]
    assert host_values(tensor) is host_values(tensor)
    tensor[1, 1] = 7
    assert host_values(tensor) == [0, 1, 2, 3, 7, 5]
    assert host_values(tensor.clone()) == host_values(tensor)


def test_numbers_of_leaves_and_of_inference() -> None:
    leaf = torch.ones(2, requires_grad=True)
    assert host_values(leaf) == [1, 1]
    with torch.no_grad():
        leaf += 1
    assert host_values(leaf) == [2, 2]
    with torch.inference_mode():
        frozen = torch.ones(2)
    assert host_values(frozen) == [1, 1]
