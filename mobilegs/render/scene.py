"""A scene that can be drawn: Gaussians, and how they are meant to be blended."""

from dataclasses import dataclass, field
from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import NEAR, Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import Rendered, Weighting, render_sorted, render_sortfree, visible_rows
from mobilegs.render.view_network import ViewNetwork


@dataclass
class Scene:
    """Gaussians with everything that a renderer must know about them.

    Attributes:
        gaussians: the Gaussians; in a sort-free scene their opacity logits are the base to
            which the network adds.
        blend: `sorted` for a plain 3DGS scene, `sortfree` for a student. One shown as the
            other looks wrong, so nothing converts between them silently.
        network: the view-dependence network of a sort-free scene; None means phi = 1 and the
            base opacity from everywhere.
        weighting: the weights of sort-free blending.
        background: sRGB in [0, 1], `[3]`.
        near: near plane the scene was trained with, in world units.
    """

    gaussians: Gaussians
    blend: Literal["sorted", "sortfree"] = "sorted"
    network: ViewNetwork | None = None
    weighting: Weighting = field(default_factory=Weighting)
    background: Float[Tensor, "3"] = field(default_factory=lambda: torch.zeros(3))
    near: float = NEAR

    def render(self, camera: Camera, *, depth: bool = False) -> Rendered:
        """The picture from `camera`, at the camera's own near plane."""
        everything = self.gaussians
        if self.blend == "sorted":
            return render_sorted(
                everything.means,
                everything.quats,
                everything.scales,
                everything.opacities,
                everything.sh,
                camera=camera,
                background=self.background,
                depth=depth,
            )
        # the network costs more than the picture: ask it only about what can be seen
        rows = visible_rows(everything.means, everything.quats, everything.scales, camera=camera)
        seen = everything.select(rows)
        logits = seen.logit_opacities
        if self.network is None:
            phi = torch.ones_like(logits)
        else:
            directions = normalize(seen.means - camera.position, dim=1)
            phi, change = self.network(seen.sh, directions, seen.scales, seen.quats)
            logits = logits + change
        drawn = render_sortfree(
            seen.means,
            seen.quats,
            seen.scales,
            logits.sigmoid(),
            seen.sh,
            phi,
            camera=camera,
            background=self.background,
            weighting=self.weighting,
            depth=depth,
        )
        radii = torch.zeros_like(everything.means[:, 0])
        return drawn._replace(radii=radii.index_copy(0, rows, drawn.radii))
