"""What the cameras of a step see of a student, decoded once for all of their views."""

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import Rendered, render_sorted, render_sortfree, visible_rows
from mobilegs.render.project import ALPHA_MIN
from mobilegs.spherical_harmonics import C0
from mobilegs.train.autograd_ops import take_rows, telling_weighting
from mobilegs.train.student.mask_pruning import fainter
from mobilegs.train.student.model import StudentModel
from mobilegs.train.student.overdraw import overdraw


class Seen:
    """The Gaussians that could touch any of the pictures, with a cut in the graph behind them.

    Views are drawn from `leaves`, which sum up their gradients; only one view's graph is there at
    a time. `backward` then takes the sums through codebooks and decoders. A network that gives
    lobes for every view is asked for every view, so its parameters are leaves, too; so are those
    of a weighting that learns.
    """

    def __init__(
        self,
        model: StudentModel,
        cameras: list[Camera],
        *,
        presence: Float[Tensor, "n"] | None = None,
    ) -> None:
        """`presence`, if given, multiplies the opacities."""
        self.model, self.cameras = model, cameras
        some, self.rows = together(visible(model, cameras), len(model))
        gaussians, for_lobes = model.gaussians(some)
        self.decoded = gaussians.tensors()
        if model.blend == "sorted":
            opacities = gaussians.opacities
            self.decoded["opacities"] = (
                opacities if presence is None else opacities * take_rows(presence, some)
            )
            del self.decoded["logit_opacities"]
        elif model.network is None:
            self.decoded["lobes"] = model.lobes(gaussians, for_lobes, None)
            del self.decoded["logit_opacities"]  # the lobes have them
        if presence is not None and model.blend != "sorted":
            self.decoded["presence"] = take_rows(presence, some)
        self.cut = {name: t.detach().requires_grad_() for name, t in self.decoded.items()}

    @property
    def leaves(self) -> list[Tensor]:
        """What the views' gradients are added up at."""
        network = self.model.network
        parameters = network.parameters() if network is not None else ()
        return [*self.cut.values(), *parameters, *self.model.learned_weighting().values()]

    def draw(
        self,
        number: int,
        *,
        background: Float[Tensor, "3"],
        depth: bool = False,
    ) -> Rendered:
        """The picture from camera `number`, differentiable down to the leaves.

        `radii` are those of the Gaussians drawn, not of all.
        """
        rows, camera = self.rows[number], self.cameras[number]
        of = {name: t if rows is None else take_rows(t, rows) for name, t in self.cut.items()}
        model, options = self.model, {"camera": camera, "background": background, "depth": depth}
        shapes = (of["means"], of["quats"], of["log_scales"].exp())
        if model.blend == "sorted":
            return render_sorted(*shapes, of["opacities"], of["sh"], **options)
        lobes, presence = of.get("lobes"), of.pop("presence", None)
        if lobes is None:
            lobes = model.lobes(Gaussians(**of), of["means"][:, :0], camera)
        if presence is not None:
            lobes = fainter(lobes, presence, of["means"], camera)
        if learned := model.learned_weighting():
            weights = {name: log.exp() for name, log in learned.items()}
            lobes = telling_weighting(lobes, of["means"], camera, **weights)
        return render_sortfree(*shapes, lobes, of["sh"], weighting=model.weighting, **options)

    def overdraw(self, number: int) -> Float[Tensor, ""]:
        """Ellipses over a pixel of camera `number`'s picture, differentiable for the scales.

        Opacities are those from everywhere: the price of an area need not be exact.
        """
        cut, least = self.cut, self.model.weighting.alpha_min
        with torch.no_grad():
            if "opacities" in cut:
                opacities, least = cut["opacities"], ALPHA_MIN
            else:
                logits = C0 * cut["lobes"][:, 0, 0] if "lobes" in cut else cut["logit_opacities"]
                opacities = torch.sigmoid(logits)
        rows, camera = self.rows[number], self.cameras[number]
        of = [cut["means"].detach(), cut["quats"].detach(), cut["log_scales"], opacities.detach()]
        means, quats, log_scales, opacities = (
            t if rows is None else take_rows(t, rows) for t in of
        )
        return overdraw(means, quats, log_scales, opacities, camera=camera, alpha_min=least)

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
