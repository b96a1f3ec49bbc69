"""The structs that cross the C interface, mirrored field by field from core.h."""

import ctypes

import torch

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.project import ALPHA_MIN, jacobian_limits
from mobilegs.render.sortfree import WEIGHTINGS, Weighting

SPLAT_BYTES = 64
SIZE_MAX = 32767  # pixel boxes are 16-bit


class KernelView(ctypes.Structure):
    """Camera, background and weighting, as core.h's View."""

    _fields_ = [
        ("rotation", ctypes.c_float * 9),
        ("translation", ctypes.c_float * 3),
        ("position", ctypes.c_float * 3),
        ("focal", ctypes.c_float * 2),
        ("center", ctypes.c_float * 2),
        ("limits", ctypes.c_float * 4),
        ("near_plane", ctypes.c_float),
        ("background", ctypes.c_float * 3),
        ("exponent_max", ctypes.c_float),
        ("sigma", ctypes.c_float),
        ("background_weight", ctypes.c_float),
        ("alpha_min", ctypes.c_float),
        ("width", ctypes.c_int),
        ("height", ctypes.c_int),
        ("weighting", ctypes.c_int),
        ("detached", ctypes.c_int),
        ("sh_size", ctypes.c_int),
        ("lobe_size", ctypes.c_int),
    ]

    @property
    def two_pass(self) -> bool:
        """Whether each pixel's surface is looked for first, and kept as one more sum."""
        return WEIGHTINGS[self.weighting] == "two_pass"


def kernel_view(
    camera: Camera,
    background: torch.Tensor,
    weighting: Weighting,
    *,
    sh_size: int,
    lobe_size: int,
) -> KernelView:
    """The struct for one picture; refuses pictures and harmonics that the kernels cannot draw.

    `lobe_size` is 0 for sorted blending.
    """
    if not (0 < camera.width <= SIZE_MAX and 0 < camera.height <= SIZE_MAX):
        raise InputError(
            f"a picture of {camera.width}x{camera.height} pixels cannot be drawn: "
            f"each side must lie between 1 and {SIZE_MAX}"
        )
    if sh_size not in (1, 4, 9, 16):
        raise InputError(f"{sh_size} spherical harmonics per colour: use 1, 4, 9 or 16")
    if lobe_size not in (0, 1, 4, 9, 16):
        raise InputError(f"{lobe_size} spherical harmonics per lobe: use 1, 4, 9 or 16")
    viewmat, k = camera.viewmat.double().cpu(), camera.K.double().cpu()
    rotation, translation = viewmat[:3, :3], viewmat[:3, 3]
    view = KernelView()
    view.rotation[:] = rotation.flatten().tolist()
    view.translation[:] = translation.tolist()
    view.position[:] = (-(rotation.T @ translation)).tolist()
    view.focal[:] = [float(k[0, 0]), float(k[1, 1])]
    view.center[:] = [float(k[0, 2]), float(k[1, 2])]
    view.limits[:] = jacobian_limits(camera)
    view.near_plane = camera.near
    view.background[:] = background.detach().tolist()
    view.exponent_max = weighting.exponent_max
    view.sigma = weighting.sigma
    view.background_weight = weighting.background_weight
    view.alpha_min = weighting.alpha_min if lobe_size else ALPHA_MIN
    view.width, view.height = camera.width, camera.height
    view.weighting, view.detached = WEIGHTINGS.index(weighting.name), weighting.detached
    view.sh_size, view.lobe_size = sh_size, lobe_size
    return view


def refuse_strays(
    view: KernelView, held: list[torch.Tensor | None], extra: torch.Tensor | None
) -> None:
    """Raise InputError for tensors that a kernel, which follows any pointer, must not be given.

    `held` lists means, quats, scales, opacities, sh and lobes, of which either the opacities or
    the lobes are None; `extra` is where screen gradients go, or None. All must be float32 on the
    device of the means, with one row per Gaussian.
    """
    means = held[0]
    assert means is not None
    count = len(means)
    shapes = [(count, 3), (count, 4), (count, 3), (count,), (count, view.sh_size, 3)]
    shapes += [(count, view.lobe_size, 2), (count, 2)]
    if (held[3] is None) == (held[5] is None) or (held[5] is None) == (view.lobe_size > 0):
        raise InputError("sorted blending needs opacities and no lobes, sort-free blending lobes")
    for tensor, shape in zip([*held, extra], shapes, strict=True):
        if tensor is None:
            continue
        if (tensor.device, tensor.dtype) != (means.device, torch.float32):
            raise InputError(
                f"Gaussians on {means.device} cannot be drawn with {tensor.dtype} on "
                f"{tensor.device}: every input must be float32 on one device"
            )
        if tensor.shape != shape:
            raise InputError(
                f"an input of shape {list(tensor.shape)} does not belong to {count} Gaussians: "
                f"{list(shape)} was expected"
            )
    if extra is not None and not extra.is_contiguous():
        raise InputError("screen_grads must be contiguous: it is written where it lies")
