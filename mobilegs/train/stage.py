"""What the loop asks of a stage of training: the teacher's and the student's look alike to it."""

from typing import NamedTuple, Protocol, runtime_checkable

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.data.dataset import View
from mobilegs.render.scene import Scene


class StepResult(NamedTuple):
    """What one step tells: `loss`, and the squared error `mse` of the picture before it."""

    loss: Float[Tensor, ""]
    mse: Float[Tensor, ""]


@runtime_checkable
class Stage(Protocol):
    """A training that goes on for a known number of steps and can be stopped after any."""

    name: str
    steps: int
    done: int
    """Steps taken so far."""
    views_per_step: int
    """Of all processes together."""

    @property
    def phase(self) -> str:
        """What the step to come belongs to, in a word."""
        ...

    @property
    def count(self) -> int:
        """Number of Gaussians."""
        ...

    def advance(self, views: list[tuple[int, View]]) -> StepResult:
        """Take one step; each view comes with its index among the training views.

        `views` are this process's share: of the step's views every so many-th as there are
        processes, from its rank on.
        """
        ...

    def scene(self) -> Scene:
        """What there is now, to be looked at."""
        ...

    def state(self) -> dict:
        """Everything the rest of the stage depends on."""
        ...

    def restore(self, state: dict) -> None:
        """Continue from what `state()` gave."""
        ...


def view_order(count: int, first: int, number: int, seed: int) -> list[int]:
    """Which of `count` views draws `first`, `first + 1`, ... of a training show, `number` in all.

    Each pass over the views is a random permutation, drawn from `seed` and the number of the
    pass alone: where a training is in its order follows from its step, so nothing needs to be
    stored, and views to come are known ahead.
    """
    shown = []
    for epoch in range(first // count, (first + number - 1) // count + 1):
        generator = torch.Generator().manual_seed(seed * 1_000_003 + epoch)
        shown += torch.randperm(count, generator=generator).tolist()
    return shown[first % count : first % count + number]
