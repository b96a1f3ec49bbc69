"""Decode a student's Gaussians once for all views of a step."""

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import Rendered, render_sorted, render_sortfree, visible_rows
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import ALPHA_MIN
from mobilegs.reproducible import sigmoid
from mobilegs.spherical_harmonics import C0
from mobilegs.train.autograd_ops import take_rows
from mobilegs.train.student.model import StudentModel
from mobilegs.train.student.overdraw import overdraw


class SharedDecode:
    """The decoded Gaussians that any camera of a step sees, with the graph cut behind them.

    Views are rendered from `leaves`, where their gradients add up, so that only one view's graph
    exists at a time. `backward` then passes the sums on through quantisers and decoders. A network
    that gives lobes is evaluated per view, so its parameters are leaves too.

    Attributes:
        rows: for each camera, its rows of the decoded Gaussians; None stands for all of them.
        decoded: tensors by name, with the graph.
        detached: the same tensors without the graph, the leaves.
    """

    def __init__(self, model: StudentModel, cameras: list[Camera]) -> None:
        """Decode what `cameras` see."""
        self.model, self.cameras = model, cameras
        union, self.rows = merge_rows(rows_in_view(model, cameras), len(model))
        gaussians, lobe_inputs = model.gaussians(union)
        self.decoded = gaussians.tensors()
        if model.network is None:
            self.decoded["lobes"] = model.lobes(gaussians, lobe_inputs, None)
            del self.decoded["logit_opacities"]  # the lobes contain them
        self.detached = {name: t.detach().requires_grad_() for name, t in self.decoded.items()}

    @property
    def leaves(self) -> list[Tensor]:
        """The tensors at which the views' gradients add up."""
        network = self.model.network
        parameters = network.parameters() if network is not None else ()
        return [*self.detached.values(), *parameters]

    def render(
        self,
        number: int,
        *,
        background: Float[Tensor, "3"],
        depth: bool = False,
        before: float | None = None,
    ) -> Rendered:
        """Render the view of camera `number`, differentiable down to the leaves.

        With `before`, only the Gaussians whose camera-space z is below it are rendered. `radii`
        of the result are those of the rendered Gaussians, not of all.
        """
        rows, camera = self.rows[number], self.cameras[number]
        if before is not None:
            rows = self._rows_before(rows, camera, before)
        picked = {
            name: t if rows is None else take_rows(t, rows) for name, t in self.detached.items()
        }
        model, options = self.model, {"camera": camera, "background": background, "depth": depth}
        options["footprint"] = model.footprint
        shapes = (picked["means"], picked["quats"], picked["log_scales"].exp())
        lobes = picked.get("lobes")
        if lobes is None:
            lobes = model.lobes(Gaussians(**picked), picked["means"][:, :0], camera)
        if model.blend == "sorted":  # without phi
            directions = normalize(picked["means"] - camera.position, dim=1)
            opacities, _ = evaluate_lobes(lobes, directions)
            return render_sorted(*shapes, opacities, picked["sh"], **options)
        options |= {"weighting": model.weighting, "level_sigma": model.level_sigma}
        return render_sortfree(*shapes, lobes, picked["sh"], **options)

    @torch.no_grad()
    def _rows_before(
        self, rows: Int[Tensor, "m"] | None, camera: Camera, z: float
    ) -> Int[Tensor, "k"]:
        """Return those of the rows, or of all, whose camera-space z is below `z`."""
        means = self.detached["means"]
        if rows is None:
            return (camera.depths(means) < z).nonzero()[:, 0]
        return rows[camera.depths(means[rows]) < z]

    def overdraw(self, number: int) -> Float[Tensor, ""]:
        """Return the fragments per pixel of camera `number`, differentiable for the scales.

        It uses opacities without their view dependence, which is accurate enough for an area.
        """
        leaves, model = self.detached, self.model
        alpha_min = ALPHA_MIN if model.blend == "sorted" else model.weighting.alpha_min
        with torch.no_grad():
            if "lobes" in leaves:
                opacities = sigmoid(C0 * leaves["lobes"][:, 0, 0])
            else:
                opacities = sigmoid(leaves["logit_opacities"])
        rows, camera = self.rows[number], self.cameras[number]
        tensors = (leaves["means"], leaves["quats"], leaves["log_scales"], opacities)
        means, quats, log_scales, opacities = (
            t if rows is None else take_rows(t, rows) for t in tensors
        )
        return overdraw(
            *(means, quats, log_scales, opacities),
            camera=camera,
            alpha_min=alpha_min,
            level_sigma=0.0 if model.blend == "sorted" else model.level_sigma,
            blur=model.footprint.blur,
        )

    def backward(self) -> None:
        """Pass the gradients of the leaves on to the model."""
        gradients = [leaf.grad for leaf in self.detached.values()]
        torch.autograd.backward(list(self.decoded.values()), gradients)


@torch.no_grad()
def rows_in_view(model: StudentModel, cameras: list[Camera]) -> list[Int[Tensor, "_"]]:
    """Return for each camera, in rising order, the Gaussians that can touch its image."""
    means, quats, log_scales = model.shapes()
    scales = log_scales.exp()
    shapes, footprint = (means, quats, scales), model.footprint
    return [visible_rows(*shapes, camera=camera, footprint=footprint) for camera in cameras]


def merge_rows(
    rows: list[Int[Tensor, "_"]], count: int
) -> tuple[Int[Tensor, "m"], list[Int[Tensor, "_"] | None]]:
    """Return the union of lists of rows, and for each list its places in the union.

    `count` is the number of all rows. For a single list, its places are None: all of them.
    """
    if len(rows) == 1:
        return rows[0], [None]
    in_any = torch.zeros(count, dtype=torch.bool, device=rows[0].device)
    for each in rows:
        in_any[each] = True
    place = in_any.cumsum(0) - 1
    return in_any.nonzero()[:, 0], [place[each] for each in rows]
