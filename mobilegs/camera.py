"""A pinhole camera, and the conventions of the whole package.

OpenCV axes (x right, y down, z forward), world-to-camera `viewmat`, pixel centres at +0.5 (the
pixel in column 3 covers [3, 4), its centre is 3.5). Depth is the z of camera space, not the
distance to the camera.
"""

import math
from dataclasses import dataclass, replace

import torch
from jaxtyping import Float
from torch import Tensor

NEAR = 0.2  # near plane of 3DGS, in units in which the cameras spread over about 1
MIN_SIDE = 64  # pixels of the shorter side that training keeps when it reduces images


@dataclass(frozen=True)
class Camera:
    """A pinhole camera without distortion.

    Attributes:
        viewmat: world-to-camera transform, `[4, 4]`, OpenCV axes; may require gradients.
        K: intrinsics in pixels, `[3, 3]`: focal lengths on the diagonal, principal point in the
            last column, measured from the image's corner (`cx = width / 2` is the centre).
        width, height: size of the image in pixels.
        near: near plane in world units: Gaussians with a camera-space z of the mean up to it are
            not rendered.
        far: far plane in world units: nor are Gaussians from it on.
    """

    viewmat: Float[Tensor, "4 4"]
    K: Float[Tensor, "3 3"]
    width: int
    height: int
    near: float = NEAR
    far: float = math.inf

    @property
    def position(self) -> Float[Tensor, "3"]:
        """The camera's centre in world space, `[3]`."""
        rotation, translation = self.viewmat[:3, :3], self.viewmat[:3, 3]
        return -(rotation.T @ translation)

    def depths(self, points: Float[Tensor, "n 3"]) -> Float[Tensor, "n"]:
        """Return the camera-space z of points in world space, `[n]`."""
        return points @ self.viewmat[2, :3] + self.viewmat[2, 3]

    def to(
        self, device: torch.device | str | None = None, dtype: torch.dtype | None = None
    ) -> "Camera":
        """Return the camera with its matrices on `device` and in `dtype`."""
        return replace(self, viewmat=self.viewmat.to(device, dtype), K=self.K.to(device, dtype))

    def resized(self, width: int, height: int) -> "Camera":
        """Return the same view with another number of pixels; each axis scales by itself."""
        factor = torch.tensor(
            [width / self.width, height / self.height, 1.0],
            dtype=self.K.dtype,
            device=self.K.device,
        )
        return replace(self, K=self.K * factor[:, None], width=width, height=height)

    def scaled(self, factor: float, least: int = 1) -> "Camera":
        """Return the same view with sides times `factor`, rounded, of at least `least` pixels."""
        sides = (max(least, round(factor * side)) for side in (self.width, self.height))
        return self.resized(*sides)

    def reduced(self, n: int) -> "Camera":
        """Return the view with one pixel in place of n x n, without rows and columns left over."""
        if n == 1:
            return self
        factor = torch.tensor([1 / n, 1 / n, 1.0], dtype=self.K.dtype, device=self.K.device)
        K, (width, height) = self.K * factor[:, None], (self.width // n, self.height // n)
        return replace(self, K=K, width=width, height=height)

    def interpolate(
        self, other: "Camera", share: float, *, turn: Float[Tensor, "3"] | None = None
    ) -> "Camera":
        """Return the camera `share` (0 to 1) of the way from this one to `other`.

        Its position lies on the line between the two, its rotation on the shortest turn; K and the
        size are this camera's. `turn` rotates it further about its own axes (axis times angle in
        radians).
        """
        from scipy.spatial.transform import Rotation, Slerp

        turns = Rotation.from_matrix(
            torch.stack([self.viewmat[:3, :3].T, other.viewmat[:3, :3].T]).double().cpu().numpy()
        )
        between = Slerp([0, 1], turns)(share)
        if turn is not None:
            between = between * Rotation.from_rotvec(turn.double().cpu().numpy())
        rotation = torch.from_numpy(between.as_matrix()).T.to(self.viewmat)
        viewmat = torch.eye(4).to(self.viewmat)
        viewmat[:3, :3] = rotation
        viewmat[:3, 3] = -rotation @ torch.lerp(self.position, other.position, share)
        return replace(self, viewmat=viewmat)


def look_at(
    eye: Float[Tensor, "3"], target: Float[Tensor, "3"], up: Float[Tensor, "3"]
) -> Float[Tensor, "4 4"]:
    """Return the world-to-camera matrix of a camera at `eye` that looks at `target`, `[4, 4]`.

    `up` is the world direction that points up in the image (towards negative camera y). It must not
    be parallel to the viewing direction.
    """
    forward = torch.nn.functional.normalize(target - eye, dim=0)
    right = torch.nn.functional.normalize(torch.linalg.cross(forward, up), dim=0)
    down = torch.linalg.cross(forward, right)
    viewmat = torch.eye(4, dtype=eye.dtype, device=eye.device)
    viewmat[:3, :3] = torch.stack([right, down, forward])
    viewmat[:3, 3] = -(viewmat[:3, :3] @ eye)
    return viewmat
