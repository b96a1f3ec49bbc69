"""Layers: the same scene in an order of which every beginning is a whole, coarser scene."""

from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.mgs.quantized_scene import LAYERS_MAX, CodedScene
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import C0

GROWTH = 4  # so many times as many Gaussians with every layer, all that came before included
FEWEST = 10_000  # in the first layer of those that are chosen by themselves
CAMERAS_MAX = 64  # that are asked


def layers_for(count: int) -> int:
    """How many layers a scene of `count` Gaussians deserves: 1 below 40,000, 2 from there on."""
    layers = 1
    while layers < LAYERS_MAX and count >= FEWEST * GROWTH**layers:
        layers += 1
    return layers


def layered(coded: CodedScene, count: int, cameras: list[Camera]) -> CodedScene:
    """The scene in `count` layers, 1 to 8, the Gaussians first that `cameras` see most of.

    The first of `k` layers has every 4^(k - 1)th Gaussian, and each further one makes four
    times as many. The device that draws is the cameras'.

    Raises:
        InputError: there are fewer Gaussians than layers, or the number of layers is out of range.
    """
    if not 1 <= count <= min(LAYERS_MAX, len(coded)):
        raise InputError(
            f"{len(coded)} Gaussians cannot be {count} layers: 1 to {LAYERS_MAX} are possible"
        )
    if count == 1:
        return replace(coded, layers=()).sorted()
    every = -(-len(cameras) // CAMERAS_MAX)
    scene = coded.decode(cameras[0].viewmat.device)
    order = seen_of_each(scene, cameras[::every]).argsort(descending=True, stable=True).cpu()
    ends = [max(len(coded) // GROWTH ** (count - i), i) for i in range(1, count + 1)]
    sizes = [end - start for start, end in zip([0, *ends], ends, strict=False)]
    return replace(coded.pick(order), layers=tuple(sizes)).sorted()


def seen_of_each(scene: Scene, cameras: list[Camera]) -> Float[Tensor, "n"]:
    """How many pixels' worth of each Gaussian is in the pictures that `cameras` take.

    A pixel's colour is a mean of the Gaussians' colours. These are the sums of their shares, found
    as what the sum of all pixels owes to each colour.
    """
    sh = scene.gaussians.sh.detach()
    # gray, which no clamp holds back; but a view network looks at colours
    sh = torch.zeros_like(sh[:, :1]) if scene.network is None else sh.clone()
    sh.requires_grad_()
    shown = replace(scene, gaussians=replace(scene.gaussians, sh=sh))
    for camera in cameras:
        shown.render(camera).image.sum().backward()
    assert sh.grad is not None
    return sh.grad[:, 0].mean(1) / C0
