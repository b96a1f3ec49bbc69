"""A scene that can be rendered: Gaussians and how to blend them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import NEAR, Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import (
    Footprint,
    Rendered,
    Weighting,
    render_sorted,
    render_sortfree,
    visible_rows,
)
from mobilegs.render.lobes import constant_lobes, evaluate_lobes
from mobilegs.render.project import CLASSIC
from mobilegs.render.supersampling import averaged, magnified
from mobilegs.render.view_network import ViewNetwork

Blend = Literal["sortfree", "sorted"]
BLENDS: tuple[Blend, ...] = get_args(Blend)


@dataclass
class Scene:
    """Gaussians with all that a renderer needs.

    Attributes:
        gaussians: the Gaussians. Their opacity logits are the base to which the network adds, or
            the mean of the lobes over all directions.
        blend: `sorted` for a scene blended in the order of depth, as in 3DGS, `sortfree` for one
            without order. Neither looks right when rendered as the other.
        lobes: view-dependent opacity and phi, `[n, m, 2]` (`render/lobes.py`). Sorted blending
            does not use phi.
        network: the view network of a scene without lobes, evaluated in every view. Without lobes
            and network, phi = 1 and the opacity does not depend on the direction.
        weighting: the weights of sort-free blending.
        footprint: how a Gaussian covers pixels; a soft edge has no effect on sorted blending.
        background: sRGB in [0, 1], `[3]`.
        near: near plane with which the scene was trained, in world units.
        up: upward direction that the file tells, length 1; None if it tells none.
        notes: notes of the file by name, such as its first view (`viewpoints.framing`).
        file: from which `open_scene` read the scene; None for a scene made or changed in memory.
    """

    gaussians: Gaussians
    blend: str = "sorted"
    lobes: Float[Tensor, "n m 2"] | None = None
    network: ViewNetwork | None = None
    weighting: Weighting = field(default_factory=Weighting)
    background: Float[Tensor, "3"] = field(default_factory=lambda: torch.zeros(3))
    near: float = NEAR
    footprint: Footprint = CLASSIC
    up: Float[np.ndarray, "3"] | None = None
    notes: Mapping[str, object] = field(default_factory=dict)
    file: Path | None = field(default=None, init=False, compare=False)

    def _repr_html_(self) -> str:
        """Return the viewer with the scene, which notebooks show as the output of a cell."""
        return import_module("mobilegs.view.notebook").scene_html(self)  # views are built on scenes

    @property
    def is_plain(self) -> bool:
        """True for plain 3DGS: blended sorted, with one opacity per Gaussian."""
        return self.blend == "sorted" and self.lobes is None and self.network is None

    def render(
        self,
        camera: Camera,
        *,
        depth: bool = False,
        level_sigma: float = 0.0,
        supersampling: int = 1,
    ) -> Rendered:
        """Render from `camera`, with the camera's near plane.

        `depth` adds the depth image. `level_sigma`, as in `render_sortfree`, has no effect on
        scenes that are blended sorted. `supersampling` n, at least 1, renders n x n pixels in place
        of one, and averages them: for images smaller than those of training (`supersampling_for`).
        """
        if supersampling > 1:
            fine = magnified(camera, supersampling)
            return averaged(self.render(fine, depth=depth, level_sigma=level_sigma), supersampling)
        gaussians, lobes = self.gaussians, self.lobes
        options = {"camera": camera, "depth": depth, "level_sigma": level_sigma}
        if self.network is None:
            return self._blend(gaussians, lobes, **options)
        # the network takes longer than rendering: evaluate it for visible Gaussians only
        shapes = (gaussians.means, gaussians.quats, gaussians.scales)
        rows = visible_rows(*shapes, camera=camera, footprint=self.footprint)
        visible = gaussians.select(rows)
        lobes = self.network(visible, normalize(visible.means - camera.position, dim=1))
        rendered = self._blend(visible, lobes, **options)
        radii = torch.zeros_like(gaussians.means[:, 0])
        return rendered._replace(radii=radii.index_copy(0, rows, rendered.radii))

    def _blend(
        self,
        gaussians: Gaussians,
        lobes: Float[Tensor, "n m 2"] | None,
        *,
        camera: Camera,
        depth: bool,
        level_sigma: float,
    ) -> Rendered:
        options = {"camera": camera, "background": self.background, "depth": depth}
        options["footprint"] = self.footprint.drawn(self.blend)
        shapes = (gaussians.means, gaussians.quats, gaussians.scales)
        if self.blend == "sorted":
            opacities = gaussians.opacities
            if lobes is not None:
                directions = normalize(gaussians.means - camera.position, dim=1)
                opacities, _ = evaluate_lobes(lobes, directions)
            return render_sorted(*shapes, opacities, gaussians.sh, **options)
        if lobes is None:
            lobes = constant_lobes(gaussians.logit_opacities)
        options |= {"weighting": self.weighting, "level_sigma": level_sigma}
        return render_sortfree(*shapes, lobes, gaussians.sh, **options)
