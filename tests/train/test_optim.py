"""NamedAdam: rows change together with their moments."""

import pytest
import torch
from torch import Tensor

from mobilegs.train import optim
from mobilegs.train.optim import NamedAdam


@pytest.fixture
def adam(generator: torch.Generator) -> NamedAdam:
    """Five rows of two tensors, after three steps in which every row has its own gradient."""
    tensors = {"a": torch.zeros(5, 2), "b": torch.zeros(5)}
    adam = NamedAdam(tensors, {"a": 0.1, "b": 0.2})
    for _ in range(3):
        pull(adam, generator)
    return adam


def pull(adam: NamedAdam, generator: torch.Generator, rows: Tensor | None = None) -> None:
    """A step with random gradients, those of `rows` if given."""
    for tensor in adam.tensors.values():
        full = torch.randn(5, *tensor.shape[1:], generator=generator)
        tensor.grad = full[: len(tensor)] if rows is None else full[rows]
    adam.step()


def test_kept_rows_move_as_before(adam: NamedAdam) -> None:
    rows = torch.tensor([True, False, True, True, False])
    other = NamedAdam({"a": torch.zeros(5, 2), "b": torch.zeros(5)}, {"a": 0.1, "b": 0.2})
    other.restore(adam.state())
    adam.keep_rows(rows)
    pull(adam, torch.Generator().manual_seed(1), rows)
    pull(other, torch.Generator().manual_seed(1))
    for name, tensor in adam.tensors.items():
        torch.testing.assert_close(tensor, other.tensors[name][rows], atol=0, rtol=0)


def test_a_reset_clears_the_moments_of_one_tensor_only(adam: NamedAdam) -> None:
    adam.reset("b", torch.full((5,), 7.0))
    assert adam.tensors["b"].tolist() == [7] * 5
    assert (adam.adam.state[adam.tensors["b"]]["exp_avg"] == 0).all()
    assert (adam.adam.state[adam.tensors["a"]]["exp_avg"] != 0).all()


def test_a_restored_optimiser_continues_the_same(adam: NamedAdam) -> None:
    adam.drop("b")
    adam.add("c", torch.ones(5), 0.3)
    other = NamedAdam({"a": torch.zeros(2, 2), "b": torch.zeros(2)}, {"a": 0.9, "b": 0.9})
    other.restore(adam.state())
    for each in (adam, other):
        pull(each, torch.Generator().manual_seed(2))
    assert adam.tensors.keys() == other.tensors.keys()
    for name, tensor in adam.tensors.items():
        assert torch.equal(tensor, other.tensors[name])


@pytest.fixture(params=["cpu", "gpu", "torch"])
def kind(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Take steps by the C++ library, by the emulated CUDA kernel, or by torch."""
    if request.param != "cpu":
        monkeypatch.setattr(optim, "_is_native", lambda tensor: False)
    if request.param == "gpu":
        request.getfixturevalue("on_host")


@pytest.mark.usefixtures("kind")
@pytest.mark.parametrize("cut", [False, True])
def test_a_step_is_that_of_torch(cut: bool, generator: torch.Generator) -> None:
    start = {"a": torch.randn(1300, 4, 3, generator=generator), "b": torch.ones(3)}
    start["c"] = torch.ones(())
    start |= {f"more {i}": torch.ones(3, i) for i in range(9)}  # a tensor without numbers, too
    ours = NamedAdam(start, dict.fromkeys(start, 0.1))
    copies = [value.clone().requires_grad_() for value in start.values()]
    torchs = torch.optim.Adam(copies, lr=0.1, eps=1e-15)
    for _ in range(5):
        for tensor, copy in zip(ours.tensors.values(), copies, strict=True):
            grad = torch.randn(tensor.shape, generator=generator)
            if cut and tensor.ndim == 3:  # as slices of one tensor have them
                grad = torch.cat([grad, grad], dim=1)[:, : tensor.shape[1]]
            tensor.grad, copy.grad = grad, grad.clone()
        ours.step()
        torchs.step()
        assert all(tensor.grad is None for tensor in ours.tensors.values())
    for tensor, copy in zip(ours.tensors.values(), copies, strict=True):
        torch.testing.assert_close(tensor, copy, atol=1e-6, rtol=1e-5)
        assert ours.adam.state[tensor]["step"] == 5


def test_a_step_without_a_tensor_leaves_its_gradient_to_later_steps(
    generator: torch.Generator,
) -> None:
    start = {name: torch.randn(6, 2, generator=generator) for name in ("kept", "other")}
    adam, plain = (NamedAdam(start, dict.fromkeys(start, 0.1)) for _ in range(2))
    grads = [torch.randn(6, 2, generator=generator) for _ in range(2)]
    for tensor in adam.tensors.values():
        tensor.grad = grads[0].clone()
    adam.step(without=("kept",))
    assert torch.equal(adam.tensors["kept"], start["kept"])
    assert not torch.equal(adam.tensors["other"], start["other"])
    other = NamedAdam(start, dict.fromkeys(start, 0.9))
    other.restore(adam.state())
    for each in (adam, other):
        rows = torch.tensor([True, False, True, True, False, True])
        each.keep_rows(rows)
        each.append_rows({name: torch.ones(1, 2) for name in start})
        kept = each.tensors["kept"]
        assert kept.grad is not None
        assert torch.equal(kept.grad, torch.cat([grads[0][rows], torch.zeros(1, 2)]))
        kept.grad += torch.cat([grads[1][rows], torch.zeros(1, 2)])
        each.step()
    plain.keep_rows(rows)
    plain.append_rows({name: torch.ones(1, 2) for name in start})
    plain.tensors["kept"].grad = torch.cat([(grads[0] + grads[1])[rows], torch.zeros(1, 2)])
    plain.step()
    for each in (adam, other):
        torch.testing.assert_close(each.tensors["kept"], plain.tensors["kept"])
    assert torch.equal(adam.tensors["other"], other.tensors["other"])
