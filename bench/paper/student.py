"""The student of rows that change the method: its weights, its votes, or its network's Adam."""

from dataclasses import dataclass, replace
from typing import Any, Literal

from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.render import Weighting
from mobilegs.render.sortfree import WeightingName
from mobilegs.train.optim import EPS
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.vote_pruning import below_quantile

Criterion = Literal["both", "opacity", "scale"]


@dataclass(frozen=True)
class Method:
    """Choices that only the paper's tables need; they are no settings."""

    weighting: WeightingName | None = None
    """The weights of blending, if not the configured ones; those of `sort_free_gs` would not learn
    here."""
    criterion: Criterion = "both"
    """Values that must lie below the quantile for a vote: opacity and largest scale, or one."""
    network_eps: float = EPS
    """Epsilon of Adam for the network of opacity and phi."""


PAPER_METHOD = Method()


class RowStudent(Student):
    """A student with another weighting, other votes, or another epsilon."""

    method = PAPER_METHOD

    def __init__(self, *args: Any, **more: Any) -> None:
        super().__init__(*args, **more)
        if (network := self.model.network) is not None and self.method.network_eps != EPS:
            # m / (sqrt(v) + eps) is the same for k m, k^2 v and k eps
            factor = EPS / self.method.network_eps
            for parameter in network.parameters():
                parameter.register_hook(lambda grad: factor * grad)

    @property
    def weighting(self) -> Weighting:
        """The configured weighting, with the formula of the row."""
        configured = super().weighting
        return replace(configured, name=self.method.weighting or configured.name)

    def candidates(
        self, opacities: Float[Tensor, "n"], scales: Float[Tensor, "n 3"]
    ) -> Bool[Tensor, "n"]:
        """Return the Gaussians that a vote goes against."""
        if self.method.criterion == "both":
            return super().candidates(opacities, scales)
        values = opacities if self.method.criterion == "opacity" else scales.amax(1)
        return below_quantile(values, self.config.pruning.quantile)


def student_class(method: Method) -> type[RowStudent]:
    """Return the students of a method."""
    return type("RowStudent", (RowStudent,), {"method": method})
