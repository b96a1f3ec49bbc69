"""What the cameras of a step see of a student, decoded once for all of their views."""

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import Rendered, Weighting, render_sortfree, visible_rows
from mobilegs.train.student_model import StudentModel, take_rows


class Seen:
    """The Gaussians that could touch any of the pictures, with a cut in the graph behind them.

    Views are drawn from `leaves`, which sum up their gradients; only one view's graph is there at
    a time. `backward` then takes the sums through codebooks and decoders. A network that gives
    lobes for every view is asked for every view, so its parameters are leaves, too.
    """

    def __init__(self, model: StudentModel, cameras: list[Camera]) -> None:
        self.model, self.cameras = model, cameras
        some, self.rows = together(visible(model, cameras), len(model))
        gaussians, for_lobes = model.gaussians(some)
        self.decoded = gaussians.tensors()
        if model.network is None:
            self.decoded["lobes"] = model.lobes(gaussians, for_lobes, None)
            del self.decoded["logit_opacities"]  # the lobes have them
        self.cut = {name: t.detach().requires_grad_() for name, t in self.decoded.items()}

    @property
    def leaves(self) -> list[Tensor]:
        """What the views' gradients are added up at."""
        network = self.model.network
        return [*self.cut.values(), *(network.parameters() if network is not None else ())]

    def draw(
        self,
        number: int,
        *,
        background: Float[Tensor, "3"],
        weighting: Weighting,
        depth: bool = False,
    ) -> Rendered:
        """The picture from camera `number`, differentiable down to the leaves.

        `radii` are those of the Gaussians drawn, not of all.
        """
        rows, camera = self.rows[number], self.cameras[number]
        of = {name: t if rows is None else take_rows(t, rows) for name, t in self.cut.items()}
        if self.model.network is not None:
            of["lobes"] = self.model.lobes(Gaussians(**of), of["means"][:, :0], camera)
        return render_sortfree(
            of["means"],
            of["quats"],
            of["log_scales"].exp(),
            of["lobes"],
            of["sh"],
            camera=camera,
            background=background,
            weighting=weighting,
            depth=depth,
        )

    def backward(self) -> None:
        """Give the model the gradients that the leaves have received."""
        gradients = [leaf.grad for leaf in self.cut.values()]
        torch.autograd.backward(list(self.decoded.values()), gradients)


@torch.no_grad()
def visible(model: StudentModel, cameras: list[Camera]) -> list[Int[Tensor, "_"]]:
    """For each camera, in rising order, the Gaussians that could touch its picture."""
    means, quats, log_scales = model.shapes()
    scales = log_scales.exp()
    return [visible_rows(means, quats, scales, camera=camera) for camera in cameras]


def together(
    rows: list[Int[Tensor, "_"]], count: int
) -> tuple[Int[Tensor, "m"], list[Int[Tensor, "_"] | None]]:
    """All rows that are in any of the lists, of `count`; and where in them those of each list are.

    None stands for all of them: a single list is just itself.
    """
    if len(rows) == 1:
        return rows[0], [None]
    anywhere = torch.zeros(count, dtype=torch.bool, device=rows[0].device)
    for each in rows:
        anywhere[each] = True
    place = anywhere.cumsum(0) - 1
    return anywhere.nonzero()[:, 0], [place[each] for each in rows]
