"""The camera struct that kernels take, and the check of their tensors."""

import ctypes

import torch

from mobilegs.camera import Camera
from mobilegs.device import host_values
from mobilegs.errors import InputError
from mobilegs.render.inputs import MoreHarmonics, RenderSettings
from mobilegs.render.levels import LEVELS, level_sizes
from mobilegs.render.project import ALPHA_MIN, jacobian_limits
from mobilegs.render.sortfree import WEIGHTINGS

BLACK = torch.zeros(3, device="cpu")  # background of views without an image
SPLAT_BYTES = 64
SIZE_MAX = 32767  # pixel boxes are 16-bit


class KernelView(ctypes.Structure):
    """Camera, background and settings; mirrors `View` in csrc/core.h field by field."""

    _fields_ = [
        ("rotation", ctypes.c_float * 9),
        ("translation", ctypes.c_float * 3),
        ("position", ctypes.c_float * 3),
        ("focal", ctypes.c_float * 2),
        ("center", ctypes.c_float * 2),
        ("limits", ctypes.c_float * 4),
        ("near_plane", ctypes.c_float),
        ("far_plane", ctypes.c_float),
        ("background", ctypes.c_float * 3),
        ("exponent_max", ctypes.c_float),
        ("sigma", ctypes.c_float),
        ("background_weight", ctypes.c_float),
        ("alpha_min", ctypes.c_float),
        ("blur", ctypes.c_float),
        ("level_sigma", ctypes.c_float),
        ("width", ctypes.c_int),
        ("height", ctypes.c_int),
        ("weighting", ctypes.c_int),
        ("detached", ctypes.c_int),
        ("sh_size", ctypes.c_int),
        ("lobe_size", ctypes.c_int),
        ("antialiased", ctypes.c_int),
        ("soft_edge", ctypes.c_int),
        ("raw", ctypes.c_int),
        ("more_width", ctypes.c_int),
    ]

    @property
    def depth_pass(self) -> bool:
        """True for the weighting `depth_pass`, which keeps three more numbers of each pixel."""
        return WEIGHTINGS[self.weighting] == "depth_pass"

    @property
    def levels(self) -> int:
        """Number of targets of sort-free blending (`render/levels.py`)."""
        return LEVELS if self.level_sigma > 0 else 1

    @property
    def sizes(self) -> list[tuple[int, int]]:
        """Height and width of all targets, that of the image first."""
        return level_sizes(self.height, self.width)[: self.levels]

    @property
    def pixels(self) -> int:
        """Number of pixels of all targets."""
        return sum(height * width for height, width in self.sizes)


def kernel_view(
    camera: Camera,
    background: torch.Tensor,
    settings: RenderSettings,
    *,
    sh_size: int,
    lobe_size: int,
    raw: bool = False,
    more_width: int = 0,
) -> KernelView:
    """Return the struct for one image.

    `sh_size` and `lobe_size` are coefficients per colour and lobe. `sh_size` is 0 for colours in
    place of harmonics, `lobe_size` is 0 for sorted blending. With `raw`, scales are given as
    logarithms, and opacities as logits. `more_width` is the number of floats
    per row of `MoreHarmonics`, 0 without them. Raises InputError for sizes and weightings that the
    kernels do not support.
    """
    if not (0 < camera.width <= SIZE_MAX and 0 < camera.height <= SIZE_MAX):
        raise InputError(
            f"an image of {camera.width}x{camera.height} pixels cannot be rendered: "
            f"each side must lie between 1 and {SIZE_MAX}"
        )
    if sh_size not in (0, 1, 4, 9, 16):
        raise InputError(f"{sh_size} spherical harmonics per colour: use 1, 4, 9 or 16")
    if lobe_size not in (0, 1, 4, 9, 16):
        raise InputError(f"{lobe_size} spherical harmonics per lobe: use 1, 4, 9 or 16")
    weighting, footprint = settings.weighting, settings.footprint
    pose, k = host_values(camera.viewmat), host_values(camera.K)
    rows, translation = [pose[0:3], pose[4:7], pose[8:11]], [pose[3], pose[7], pose[11]]
    view = KernelView()
    view.rotation[:] = [value for row in rows for value in row]
    view.translation[:] = translation
    view.position[:] = [
        -sum(a * b for a, b in zip(column, translation, strict=True))
        for column in zip(*rows, strict=True)
    ]
    view.focal[:] = [k[0], k[4]]
    view.center[:] = [k[2], k[5]]
    view.limits[:] = jacobian_limits(camera)
    view.near_plane, view.far_plane = camera.near, camera.far
    view.background[:] = host_values(background)
    view.exponent_max = weighting.exponent_max
    view.sigma = weighting.sigma
    view.background_weight = weighting.background_weight
    view.alpha_min = weighting.alpha_min if lobe_size else ALPHA_MIN
    view.blur, view.level_sigma = footprint.blur, settings.level_sigma
    view.antialiased, view.soft_edge = footprint.antialiased, footprint.soft_edge
    view.width, view.height = camera.width, camera.height
    view.weighting, view.detached = weighting.index, weighting.detached
    view.sh_size, view.lobe_size = sh_size, lobe_size
    view.raw, view.more_width = raw, more_width
    return view


def more_floats(view: KernelView) -> int:
    """Return how many floats of a row of `MoreHarmonics` the view's colours have."""
    return 3 * (view.sh_size - 1)


def validate_inputs(
    view: KernelView,
    inputs: list[torch.Tensor | None],
    screen_grads: torch.Tensor | None,
    more: MoreHarmonics | None = None,
) -> None:
    """Raise InputError for tensors whose memory a kernel must not read or write.

    `inputs` lists means, quats, scales, opacities, sh or colours, and lobes; either the opacities
    or the lobes are None. All tensors must be float32 on the device of the means, with one row per
    Gaussian.
    """
    means = inputs[0]
    if means is None or any(inputs[i] is None for i in (1, 2, 4)):
        raise InputError("only the opacities or the lobes may be None")
    count = len(means)
    colors = (count, 1 if more else view.sh_size, 3) if view.sh_size else (count, 3)
    shapes = [(count, 3), (count, 4), (count, 3), (count,), colors]
    shapes += [(count, view.lobe_size, 2), (count, 2)]
    shapes += [(count, view.more_width // 3, 3)] * 2
    if (more is None) != (view.more_width == 0) or (more and view.more_width < more_floats(view)):
        raise InputError("there are more harmonics, or fewer, than the view has")
    if (inputs[3] is None) == (inputs[5] is None) or (inputs[5] is None) == (view.lobe_size > 0):
        raise InputError("sorted blending needs opacities and no lobes, sort-free blending lobes")
    written = [screen_grads, *(more or (None, None))]
    for tensor, shape in zip([*inputs, *written], shapes, strict=True):
        if tensor is None:
            continue
        if tensor.layout != torch.strided or tensor.is_meta:
            raise InputError("an input is sparse, or has no memory")
        if (tensor.device, tensor.dtype) != (means.device, torch.float32):
            raise InputError(
                f"Gaussians on {means.device} cannot be rendered with {tensor.dtype} on "
                f"{tensor.device}: every input must be float32 on one device"
            )
        if tensor.shape != shape:
            raise InputError(
                f"an input has shape {list(tensor.shape)}: {list(shape)} was expected for {count} "
                "Gaussians"
            )
    if any(tensor is not None and not tensor.is_contiguous() for tensor in written):
        raise InputError(
            "screen_grads and more harmonics must be contiguous: kernels write to their memory"
        )
