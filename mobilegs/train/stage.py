"""The interface of a training stage, teacher or student, to the step loop."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.data.dataset import View
from mobilegs.render.scene import Scene
from mobilegs.train.exposure import Exposures


class StepResult(NamedTuple):
    """Results of one step.

    Attributes:
        loss: of the step's images, the mean.
        mse: mean squared error of the step's images; NaN if their masks leave no pixel.
        spread: of the photos' exposures (`train/exposure.py`), in the step that measured it.
    """

    loss: Float[Tensor, ""]
    mse: Float[Tensor, ""]
    spread: float | None = None

    @classmethod
    def of(
        cls, losses: Sequence[Tensor], errors: Sequence[Tensor], spread: float | None = None
    ) -> "StepResult":
        """Return the result of a step with these losses and squared errors of its views."""
        if len(losses) == 1:
            return cls(losses[0], errors[0], spread)
        return cls(torch.stack([*losses]).mean(), torch.stack([*errors]).nanmean(), spread)


@runtime_checkable
class Stage(Protocol):
    """A training of a fixed number of steps that can stop and resume after any of them."""

    name: str
    """`teacher` or `student`."""
    done: int
    """Number of steps taken so far."""
    views_per_step: int
    """Views in a step, over all processes."""
    exposures: Exposures | None
    """Colours of single photos; None while they are not learned."""

    @property
    def steps(self) -> int:
        """Number of steps in total."""
        ...

    @property
    def runs_kernels(self) -> bool:
        """True if kernels of the library do the work of a step, so that torch needs no threads."""
        ...

    @property
    def phase(self) -> str:
        """One word for the part of the stage that the next step belongs to."""
        ...

    @property
    def count(self) -> int:
        """Number of Gaussians."""
        ...

    def set_steps(self, steps: int, at: int) -> None:
        """Change the number of steps in total, to more than `at`, when `at` of them are done.

        The steps left divide the time left of all schedules. Changes come in rising order of `at`,
        which may lie before `done`: a resumed run repeats them.
        """
        ...

    def advance(self, views: list[tuple[int, View]]) -> StepResult:
        """Take one step on `views`, each with its index among the training views.

        `views` are this process's share: views `rank`, `rank + world_size`, ... of the step.
        """
        ...

    def scene(self) -> Scene:
        """Return the current scene, for previews."""
        ...

    def state(self) -> dict:
        """Return everything that the remaining steps depend on."""
        ...

    def restore(self, state: dict) -> None:
        """Continue from a result of `state()`."""
        ...


def view_order(count: int, first: int, number: int, seed: int) -> list[int]:
    """Return the indices of the views that draws `first` to `first + number - 1` show.

    Each pass over the `count` views is a random permutation that depends only on `seed` and the
    number of the pass. The order therefore needs no state in a checkpoint, and coming views are
    known in advance.
    """
    shown = []
    for epoch in range(first // count, (first + number - 1) // count + 1):
        generator = torch.Generator().manual_seed(seed * 1_000_003 + epoch)
        shown += torch.randperm(count, generator=generator).tolist()
    return shown[first % count : first % count + number]
