"""Refinement of the photos' poses: a small turn and shift of each camera, learned with the scene.

Camera i at `p_i` turns about itself by the vector `w_i` (axis times angle in radians, world axes)
and moves by `s_i` (in extents of the scene). Motions of all cameras together that only move, turn
or scale the whole capture would move the scene, so they are projected out after every step.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.atomic import atomic_write, read_json
from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, Frame, View, load_view
from mobilegs.errors import InputError
from mobilegs.render.scene import Scene
from mobilegs.train.losses import photo_loss
from mobilegs.train.optim import NamedAdam, exponential_lr

START = 0.1  # time at which learning begins
# learning rate at the start and at the end, in radians and extents; it falls geometrically
LRS = (4e-4, 4e-6)
HELD_BACK_STEPS = 100  # that refine the pose of a held-back photo
HELD_BACK_LRS = (3e-3, 3e-5)
ANGLE_EPS = 1e-12  # added to squared angles; smaller than those of any turn in float32


@dataclass(frozen=True)
class PoseConfig:
    """Learned corrections of the training photos' poses."""

    learned: bool = False
    """Learn a turn and a shift for each photo."""


class Poses:
    """The corrections of all training cameras, and the Adam that learns them."""

    def __init__(self, cameras: Sequence[Camera], extent: float, lrs: tuple[float, float]) -> None:
        """Begin without corrections of `cameras`; shifts count in `extent` world units.

        `lrs` are the learning rates at the start and at the end.
        """
        self.extent, self.lrs = extent, lrs
        eyes = torch.stack([camera.position for camera in cameras])
        motions = torch.zeros(len(cameras), 6, device=eyes.device)
        self.adam = NamedAdam({"motions": motions}, {"motions": lrs[0]})
        self.common = common_motions((eyes - eyes.mean(0)) / extent)

    @property
    def motions(self) -> Float[Tensor, "photos 6"]:
        """The turn and the shift of each camera: `(w | s)`."""
        return self.adam.tensors["motions"]

    def camera(self, index: int, camera: Camera) -> Camera:
        """Return the corrected camera of photo `index`, differentiable for the correction."""
        turn, shift = self.motions[index].split(3)
        rotation = camera.viewmat[:3, :3] @ rotation_matrix(turn).T
        position = camera.position + self.extent * shift
        top = torch.cat([rotation, -(rotation @ position)[:, None]], dim=1)
        return replace(camera, viewmat=torch.cat([top, camera.viewmat[3:]]))

    @torch.no_grad()
    def step(self, time: float) -> None:
        """Take an Adam step with the gradients; `time` is 0 to 1."""
        self.adam.set_lr("motions", exponential_lr(*self.lrs, time))
        self.adam.step()
        flat = self.motions.view(-1)
        flat.sub_(self.common @ (self.common.T @ flat))

    def refined(self, dataset: Dataset, scene: Scene) -> Dataset:
        """Return a capture with refined poses; those of held-back photos follow from the scene."""
        device, train, test = scene.gaussians.means.device, [], []
        for index, frame in enumerate(dataset.train):
            with torch.no_grad():
                camera = self.camera(index, frame.camera.to(device))
            train.append(replace(frame, camera=camera.to("cpu")))
        for frame in dataset.test:
            camera = refined_camera(scene, load_view(frame).to(device), self.extent)
            test.append(replace(frame, camera=camera.to("cpu")))
        return replace(dataset, train=train, test=test)

    def state(self) -> dict:
        """Return everything that later steps depend on."""
        return self.adam.state()

    def restore(self, state: dict) -> None:
        """Continue from a result of `state()`."""
        self.adam.restore(state)


def refined_camera(scene: Scene, view: View, extent: float) -> Camera:
    """Return the camera from which a finished scene looks most like a photo that it has not seen.

    Held-back photos have poses as wrong as the others; without this, their errors would count as
    the scene's.
    """
    poses = Poses([view.camera], extent, HELD_BACK_LRS)
    poses.common = poses.common[:, :0]
    for done in range(HELD_BACK_STEPS):
        image = scene.render(poses.camera(0, view.camera)).image
        photo_loss(image, view.image, mask=view.mask).backward()
        poses.step(done / HELD_BACK_STEPS)
    with torch.no_grad():
        return poses.camera(0, view.camera)


def write_poses(path: Path, dataset: Dataset) -> None:
    """Write `{"train" or "test": {name of the photo: viewmat}}` as JSON."""
    content = {
        side: {frame.name: frame.camera.viewmat.tolist() for frame in frames}
        for side, frames in (("train", dataset.train), ("test", dataset.test))
    }
    atomic_write(path, json.dumps(content) + "\n")


def with_poses(dataset: Dataset, path: Path) -> Dataset:
    """Return a dataset with the poses of a file. Raises InputError if the file is damaged."""
    try:
        content = read_json(path)
        train, test = (
            [_posed(frame, content[side][frame.name]) for frame in frames]
            for side, frames in (("train", dataset.train), ("test", dataset.test))
        )
    except (ValueError, TypeError, LookupError, ArithmeticError, RuntimeError) as error:
        raise InputError(f"{path} is damaged ({error}): start the run anew") from error
    return replace(dataset, train=train, test=test)


def _posed(frame: Frame, rows: list[list[float]]) -> Frame:
    viewmat = torch.tensor(rows, dtype=torch.float32)
    if viewmat.shape != (4, 4) or not viewmat.isfinite().all():
        raise ValueError(f"{frame.name} has no matrix of 4 x 4 numbers")
    return replace(frame, camera=replace(frame.camera, viewmat=viewmat))


def rotation_matrix(turn: Float[Tensor, "3"]) -> Float[Tensor, "3 3"]:
    """Return the rotation about the axis `turn` by its length in radians (Rodrigues)."""
    x, y, z = turn.unbind()
    zero = torch.zeros_like(x)
    cross = torch.stack([zero, -z, y, z, zero, -x, -y, x, zero]).view(3, 3)
    squares = turn.square().sum() + ANGLE_EPS
    angle = squares.sqrt()
    first, second = torch.sinc(angle / torch.pi), torch.sinc(angle / (2 * torch.pi)).square() / 2
    return torch.eye(3).to(turn) + first * cross + second * cross @ cross


def common_motions(eyes: Float[Tensor, "photos 3"]) -> Float[Tensor, "n k"]:
    """Return an orthonormal basis of the motions that only move, turn or scale the capture.

    `eyes` are the cameras' positions from their mean, in extents; rows of the basis are the six
    numbers of each camera, one camera after another.
    """
    columns = []
    for axis in torch.eye(3).to(eyes):
        still = axis.expand_as(eyes)
        columns.append(torch.cat([still, torch.linalg.cross(still, eyes)], dim=1))
        columns.append(torch.cat([torch.zeros_like(eyes), still], dim=1))
    columns.append(torch.cat([torch.zeros_like(eyes), eyes], dim=1))
    basis, sizes, _ = torch.linalg.svd(
        torch.stack([column.flatten() for column in columns], dim=1).double(), full_matrices=False
    )
    return basis[:, sizes > 1e-6 * sizes[0]].to(eyes)
