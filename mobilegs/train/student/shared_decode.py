"""Decode a student's Gaussians once for all views of a step."""

import math
from dataclasses import replace

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import Rendered, render_raw, render_sorted, visible_rows
from mobilegs.render.inputs import RenderInputs, RenderSettings
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
        before: float = math.inf,
    ) -> Rendered:
        """Render the view of camera `number`, differentiable down to the leaves.

        `before` is the far plane. `radii` of the result are those of the Gaussians that the camera
        may see, not of all.
        """
        rows, camera = self.rows[number], replace(self.cameras[number], far=before)
        picked = {
            name: t if rows is None else take_rows(t, rows) for name, t in self.detached.items()
        }
        model = self.model
        shapes = (picked["means"], picked["quats"], picked["log_scales"])
        lobes = picked.get("lobes")
        if lobes is None:
            lobes = model.lobes(Gaussians(**picked), picked["means"][:, :0], camera)
        options = {"camera": camera, "background": background, "depth": depth}
        if model.blend == "sorted":  # without phi
            directions = normalize(shapes[0] - camera.position, dim=1)
            opacities, _ = evaluate_lobes(lobes, directions)
            options["footprint"] = model.footprint
            return render_sorted(
                *(shapes[0], shapes[1], shapes[2].exp(), opacities, picked["sh"]), **options
            )
        return render_raw(
            RenderInputs(*shapes, None, picked["sh"], lobes),
            settings=RenderSettings(model.weighting, model.footprint, model.level_sigma),
            sh_degree=model.color.degree,
            **options,
        )

    def overdraw(self) -> Float[Tensor, ""]:
        """Return the fragments per pixel of the first camera, differentiable for the scales.

        It uses opacities without their view dependence, which is accurate enough for an area.
        """
        leaves, model = self.detached, self.model
        alpha_min, level_sigma = overdraw_limits(model)
        with torch.no_grad():
            if "lobes" in leaves:
                opacities = sigmoid(C0 * leaves["lobes"][:, 0, 0])
            else:
                opacities = sigmoid(leaves["logit_opacities"])
        rows, camera = self.rows[0], self.cameras[0]
        tensors = (leaves["means"], leaves["quats"], leaves["log_scales"], opacities)
        means, quats, log_scales, opacities = (
            t if rows is None else take_rows(t, rows) for t in tensors
        )
        return overdraw(
            *(means, quats, log_scales, opacities),
            camera=camera,
            alpha_min=alpha_min,
            level_sigma=level_sigma,
            blur=model.footprint.blur,
        )

    def step(self, overdraw_weight: float = 0.0) -> None:
        """Pass the gradients of the leaves on to the model, and take a step of Adam.

        They receive `overdraw_weight` times that of the first camera's overdraw, too.
        """
        if overdraw_weight:
            (overdraw_weight * self.overdraw()).backward()
        gradients = [leaf.grad for leaf in self.detached.values()]
        torch.autograd.backward(list(self.decoded.values()), gradients)
        self.model.step()


def overdraw_limits(model: StudentModel) -> tuple[float, float]:
    """Return the alpha at which ellipses end for the overdraw term, and its `level_sigma`."""
    if model.blend == "sorted":
        return ALPHA_MIN, 0.0
    return model.weighting.alpha_min, model.level_sigma


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
