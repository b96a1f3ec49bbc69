"""Exposure and white balance of single photos: an affine change of colours for each of them.

The scene learns colours that all photos share. A render becomes `image @ A.T + b` before it is
compared with photo i, with A `[3, 3]` and b `[3]` of that photo. After every step the changes are
moved so that their mean over all photos is no change: the scene takes no tint. They are dropped
when training ends.
"""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.train.optim import NamedAdam, exponential_lr
from mobilegs.validation import NOT_NEGATIVE, POSITIVE, check


@dataclass(frozen=True)
class ExposureConfig:
    """Learned exposure and white balance of each training photo."""

    learned: bool = False
    """Learn an affine change of colours for each photo."""
    lr: float = 3e-3
    """Learning rate at the start, above 0."""
    lr_end: float = 3e-4
    """Learning rate at the end, above 0. In between it falls geometrically."""
    weight: float = 0.1
    """Weight of the squared distance to no change in the loss, at least 0."""

    def __post_init__(self) -> None:
        check(self, lr=POSITIVE, lr_end=POSITIVE, weight=NOT_NEGATIVE)


class Exposures:
    """The changes of colours of all training photos, and the Adam that learns them."""

    def __init__(self, config: ExposureConfig, photos: int, device: torch.device) -> None:
        """Begin with no change."""
        self.config = config
        self.same = torch.eye(3, 4, device=device)
        changes = self.same.repeat(photos, 1, 1)
        self.adam = NamedAdam({"changes": changes}, {"changes": config.lr})

    @property
    def changes(self) -> Float[Tensor, "photos 3 4"]:
        """`(A | b)` of each photo, a leaf."""
        return self.adam.tensors["changes"]

    def apply(self, index: int, image: Float[Tensor, "h w 3"]) -> Float[Tensor, "h w 3"]:
        """Return a render with the colours of photo `index`."""
        change = self.changes[index]
        return image @ change[:, :3].T + change[:, 3]

    def penalty(self, index: int) -> Float[Tensor, ""]:
        """Return the term of the loss that keeps the change of photo `index` small."""
        return self.config.weight * (self.changes[index] - self.same).square().sum()

    @torch.no_grad()
    def step(self, progress: float) -> None:
        """Take an Adam step with the gradients of `changes`; `progress` is the time, 0 to 1."""
        config = self.config
        self.adam.set_lr("changes", exponential_lr(config.lr, config.lr_end, progress))
        self.adam.step()
        self.changes.sub_(self.changes.mean(0) - self.same)

    def state(self) -> dict:
        """Return everything that later steps depend on."""
        return self.adam.state()

    def restore(self, state: dict) -> None:
        """Continue from a result of `state()`."""
        self.adam.restore(state)
