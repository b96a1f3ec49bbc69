"""NamedAdam: rows change together with their moments."""

import pytest
import torch
from torch import Tensor

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


def test_gradients_get_the_strides_that_adam_asks_for_on_a_gpu() -> None:
    sh = torch.zeros(5, 16, 3)
    tensors = {"sh0": sh[:, :1], "sh_rest": sh[:, 1:1], "square": torch.zeros(4, 4)}
    adam = NamedAdam(tensors, dict.fromkeys(tensors, 0.1))
    strides = []

    def note(*_: object) -> None:
        strides.extend(
            (t.stride(), t.grad.stride()) for t in adam.tensors.values() if t.grad is not None
        )

    adam.adam.register_step_pre_hook(note)
    adam.tensors["sh0"].grad = torch.ones(5, 1, 3)
    adam.tensors["sh_rest"].grad = torch.ones(5, 16, 3)[:, 1:1]
    adam.tensors["square"].grad = torch.ones(4, 4).T
    adam.step()
    assert strides == [((3, 3, 1),) * 2, ((3, 3, 1),) * 2, ((4, 1),) * 2]
