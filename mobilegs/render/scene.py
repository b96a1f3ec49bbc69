"""A scene that can be rendered: Gaussians and how to blend them."""

from dataclasses import dataclass, field

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import NEAR, Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import Rendered, Weighting, render_sorted, render_sortfree, visible_rows
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.view_network import ViewNetwork

BLENDS = ("sortfree", "sorted")


@dataclass
class Scene:
    """Gaussians with all that a renderer needs.

    Attributes:
        gaussians: the Gaussians. In a sort-free scene, their opacity logits are the base to which
            the network adds, or the mean of the lobes over all directions.
        blend: `sorted` for a plain 3DGS scene, `sortfree` for a student. Neither looks right when
            rendered as the other.
        lobes: view-dependent opacity and phi of a sort-free scene, `[n, m, 2]`
            (`render/lobes.py`).
        network: the view network of a sort-free scene without lobes, evaluated in every view.
            Without lobes and network, phi = 1 and the opacity does not depend on the direction.
        weighting: the weights of sort-free blending.
        background: sRGB in [0, 1], `[3]`.
        near: near plane with which the scene was trained, in world units.
    """

    gaussians: Gaussians
    blend: str = "sorted"
    lobes: Float[Tensor, "n m 2"] | None = None
    network: ViewNetwork | None = None
    weighting: Weighting = field(default_factory=Weighting)
    background: Float[Tensor, "3"] = field(default_factory=lambda: torch.zeros(3))
    near: float = NEAR

    def render(self, camera: Camera, *, depth: bool = False) -> Rendered:
        """Render from `camera`, with the camera's near plane. `depth` adds the depth image."""
        gaussians = self.gaussians
        options = {"camera": camera, "background": self.background, "depth": depth}
        shapes = (gaussians.means, gaussians.quats, gaussians.scales)
        if self.blend == "sorted":
            return render_sorted(*shapes, gaussians.opacities, gaussians.sh, **options)
        options["weighting"] = self.weighting
        if self.network is None:
            lobes = self.lobes
            if lobes is None:
                lobes = constant_lobes(gaussians.logit_opacities)
            return render_sortfree(*shapes, lobes, gaussians.sh, **options)
        # the network takes longer than rendering: evaluate it for visible Gaussians only
        rows = visible_rows(*shapes, camera=camera)
        visible = gaussians.select(rows)
        directions = normalize(visible.means - camera.position, dim=1)
        lobes = self.network(visible, directions)
        shapes = (visible.means, visible.quats, visible.scales)
        rendered = render_sortfree(*shapes, lobes, visible.sh, **options)
        radii = torch.zeros_like(gaussians.means[:, 0])
        return rendered._replace(radii=radii.index_copy(0, rows, rendered.radii))
