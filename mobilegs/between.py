"""Cameras on the way from one to another."""

import torch
from jaxtyping import Float
from scipy.spatial.transform import Rotation, Slerp
from torch import Tensor

from mobilegs.camera import Camera


def blended(
    one: Camera, other: Camera, share: float, *, turn: Float[Tensor, "3"] | None = None
) -> Camera:
    """The camera `share` (0 to 1) of the way from `one` to `other`; its lens is that of `one`.

    Its centre lies on the line between theirs, and it is turned by that share of the shortest turn.
    `turn` turns it further about its own axes: an axis times an angle in radians.
    """
    turns = Rotation.from_matrix(
        torch.stack([one.viewmat[:3, :3].T, other.viewmat[:3, :3].T]).double().cpu().numpy()
    )
    found = Slerp([0, 1], turns)(share)
    if turn is not None:
        found = found * Rotation.from_rotvec(turn.double().cpu().numpy())
    rotation = torch.from_numpy(found.as_matrix()).T.to(one.viewmat)
    viewmat = torch.eye(4).to(one.viewmat)
    viewmat[:3, :3] = rotation
    viewmat[:3, 3] = -rotation @ torch.lerp(one.position, other.position, share)
    return Camera(viewmat, one.K, one.width, one.height, one.near)
