"""A scene that can be drawn: Gaussians, and how they are meant to be blended."""

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
    """Gaussians with everything that a renderer must know about them.

    Attributes:
        gaussians: the Gaussians. In a sort-free scene with a network their opacity logits are
            the base to which it adds; with lobes they are the mean of those over all directions.
        blend: `sorted` for a plain 3DGS scene, `sortfree` for a student. One shown as the
            other looks wrong, so nothing converts between them silently.
        lobes: of a sort-free scene, `[n, m, 2]` as `render/lobes.py` has them.
        network: the view network of a sort-free scene that has no lobes; it is asked again for
            every view. With neither, phi = 1 and opacity is the same from everywhere.
        weighting: the weights of sort-free blending.
        background: sRGB in [0, 1], `[3]`.
        near: near plane the scene was trained with, in world units.
    """

    gaussians: Gaussians
    blend: str = "sorted"
    lobes: Float[Tensor, "n m 2"] | None = None
    network: ViewNetwork | None = None
    weighting: Weighting = field(default_factory=Weighting)
    background: Float[Tensor, "3"] = field(default_factory=lambda: torch.zeros(3))
    near: float = NEAR

    def render(self, camera: Camera, *, depth: bool = False) -> Rendered:
        """The picture from `camera`, at the camera's own near plane."""
        everything = self.gaussians
        options = {"camera": camera, "background": self.background, "depth": depth}
        shapes = (everything.means, everything.quats, everything.scales)
        if self.blend == "sorted":
            return render_sorted(*shapes, everything.opacities, everything.sh, **options)
        options["weighting"] = self.weighting
        if self.network is None:
            lobes = self.lobes
            if lobes is None:
                lobes = constant_lobes(everything.logit_opacities)
            return render_sortfree(*shapes, lobes, everything.sh, **options)
        # the network costs more than the picture: ask it only about what can be seen
        rows = visible_rows(*shapes, camera=camera)
        seen = everything.select(rows)
        directions = normalize(seen.means - camera.position, dim=1)
        lobes = self.network(seen, directions)
        drawn = render_sortfree(seen.means, seen.quats, seen.scales, lobes, seen.sh, **options)
        radii = torch.zeros_like(everything.means[:, 0])
        return drawn._replace(radii=radii.index_copy(0, rows, drawn.radii))
