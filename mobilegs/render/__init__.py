"""Gaussians + Camera -> image, alpha, depth: two renderers, each with a reference and kernels.

The reference is PyTorch: `project.py`, `sorted.py`, `sortfree.py`, `contributions.py`. The kernels
compute the same in float32: C++ for the CPU and CUDA, both from `csrc/core.h` and `csrc/pairs.h`.
Tests compare every output and every gradient of a kernel with the reference in float64.

The weight w of a Gaussian (paper Eq. 3) is `Weighting.weights` in `sortfree.py`; the kernels and
shaders have it as `weight_of`.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn.functional import pad

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render import contributions as contributions_reference
from mobilegs.render import sorted as sorted_reference
from mobilegs.render import sortfree as sortfree_reference
from mobilegs.render.contributions import Contributions
from mobilegs.render.inputs import (
    MoreHarmonics,
    RenderInputs,
    RenderSettings,
    colors_of,
    shape_of,
    validate_gaussians,
    validate_settings,
)
from mobilegs.render.kernels import cpu, cuda
from mobilegs.render.kernels.kernel_view import BLACK, kernel_view
from mobilegs.render.lobes import lobe_degree, opacity_lobes
from mobilegs.render.pose import carried_by_gaussians, rigid
from mobilegs.render.project import CLASSIC, Footprint, project
from mobilegs.render.rendered import Rendered
from mobilegs.render.sortfree import Weighting
from mobilegs.spherical_harmonics import rgb_to_sh0

__all__ = [
    "Contributions",
    "Footprint",
    "Rendered",
    "Weighting",
    "measure_contributions",
    "render_sorted",
    "render_sortfree",
    "visible_rows",
]

Backend = Literal["auto", "reference", "kernel"]


def _resolve(backend: Backend, means: Tensor) -> Backend:
    if backend != "auto":
        return backend
    return "kernel" if means.dtype == torch.float32 else "reference"


def _raster(means: Tensor) -> type[torch.autograd.Function]:
    if means.dtype != torch.float32 or means.device.type not in ("cpu", "cuda"):
        raise InputError(
            f"the kernels render float32 on the CPU or a GPU, not {means.dtype} on {means.device}: "
            "use backend='reference'"
        )
    return cuda.CudaRaster if cuda.takes(means) else cpu.CpuRaster


def render_sorted(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    sh: Float[Tensor, "n k 3"] | None = None,
    *,
    camera: Camera | Sequence[Camera],
    background: Float[Tensor, "d"] | None = None,
    colors: Float[Tensor, "n d"] | None = None,
    footprint: Footprint = CLASSIC,
    depth: bool = False,
    screen_grads: Float[Tensor, "*c n 2"] | None = None,
    backend: Backend = "auto",
) -> Rendered:
    """Render by sorted alpha blending, as 3DGS does: `C = sum(c a T) + T_end bg`.

    The reference, with the formula's source, is `render/sorted.py`. All tensors of the Gaussians
    have gradients, and so has a camera's `viewmat`: its part along rigid motions
    (`render/pose.py`).

    Args:
        means: world space, `[n, 3]`.
        quats: rotations wxyz of any length but 0, `[n, 4]`.
        scales: standard deviations in world units, `[n, 3]`.
        opacities: in [0, 1], `[n]`.
        sh: spherical harmonics of the colour, `[n, (degree + 1)^2, 3]`, degree 0 to 3.
        camera: the view, or several of one image size, which are rendered one after another: all
            outputs then have a leading dimension c. Sides of at most 32,767 pixels for the kernels.
        background: sRGB in [0, 1], `[3]`, or as many channels as `colors`; black by default.
        colors: colours or features in place of `sh`, `[n, d]` with any d: used as they are, any
            finite number. The image is `[h, w, d]`. The kernels render three channels at a time.
        footprint: how a Gaussian covers pixels: blur and antialiasing; by default that of 3DGS.
        depth: also render the depth image.
        screen_grads: if given, the backward pass overwrites it with the gradient of each mean's
            position in the image, in 1 / px, `[n, 2]` or, for several cameras, `[c, n, 2]`,
            contiguous. Kernels only, up to three channels.
        backend: `kernel` is the float32 kernel of the tensors' device, `reference` the PyTorch
            code in any precision; `auto` takes the kernel for float32, else the reference.

    Raises InputError for shapes, types or devices that do not belong together, for cameras of
    several sizes, for a soft edge, and for a `K` or, with the kernels, a `background` that requires
    gradients: these have none.
    """
    validate_gaussians(means, quats=quats, scales=scales, opacities=opacities)
    inputs = RenderInputs(means, quats, scales, opacities, colors_of(sh, colors, len(means)), None)
    settings = RenderSettings(footprint=footprint)
    validate_settings(settings, sortfree=False)
    return _render(inputs, camera, background, settings, depth, screen_grads, backend)


def render_sortfree(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    lobes: Float[Tensor, "n m 2"] | Float[Tensor, "n"],
    sh: Float[Tensor, "n k 3"] | None = None,
    *,
    camera: Camera | Sequence[Camera],
    background: Float[Tensor, "d"] | None = None,
    colors: Float[Tensor, "n d"] | None = None,
    weighting: Weighting = Weighting(),  # noqa: B008 - frozen
    footprint: Footprint = CLASSIC,
    level_sigma: float = 0.0,
    depth: bool = False,
    screen_grads: Float[Tensor, "*c n 2"] | None = None,
    backend: Backend = "auto",
) -> Rendered:
    """Render by order-independent blending: `C = (1 - T) sum(c a w) / sum(a w) + T bg` (Eq. 2).

    The reference, with all formulas, is `render/sortfree.py`; w is `Weighting.weights` (Eq. 3).
    `lobes` are spherical harmonics of the opacity's logit and of phi before its ReLU,
    `[n, (degree + 1)^2, 2]`, or opacities in [0, 1], `[n]`, with phi = 1: 0 and 1, which have no
    finite logit, count as 1e-7 and 1 - 1e-7. All other arguments are those of `render_sorted`.

    With a `level_sigma` of 0.6 or more, Gaussians that are smooth in the pixels of a target of a
    half, a quarter or an eighth of the image's size are added up there (`render/levels.py`): those
    whose smaller standard deviation is at least `level_sigma` such pixels, or more if their w is
    above 10. The image is nearly the same, from fewer fragments; 1 is a good choice. 0, the
    default, adds up all at full size.

    Raises InputError as `render_sorted` does, for opacities outside [0, 1], and for another
    `level_sigma`.
    """
    validate_gaussians(means, quats=quats, scales=scales)
    count = len(means)
    settings = RenderSettings(weighting, footprint, level_sigma)
    validate_settings(settings, sortfree=True)
    if not isinstance(lobes, Tensor):
        raise InputError("lobes are no tensor: give [n, m, 2], or opacities [n]")
    if lobes.ndim == 1:
        lobes = opacity_lobes(lobes)
    if lobes.ndim != 3 or len(lobes) != count or lobes.shape[2] != 2:
        raise InputError(
            f"lobes have shape {list(lobes.shape)}: [n, m, 2] was expected, for {count} Gaussians "
            "and m = 1, 4, 9 or 16, or opacities [n]"
        )
    lobe_degree(lobes)
    inputs = RenderInputs(means, quats, scales, None, colors_of(sh, colors, count), lobes)
    return _render(inputs, camera, background, settings, depth, screen_grads, backend)


def _render(
    inputs: RenderInputs,
    camera: Camera | Sequence[Camera],
    background: Tensor | None,
    settings: RenderSettings,
    depth: bool,
    screen_grads: Tensor | None,
    backend: Backend,
) -> Rendered:
    """Render one view, or several and stack their outputs; sort-free if there are lobes."""
    channels = inputs.colors.shape[-1]
    if background is None:
        background = inputs.means.new_zeros(channels, device="cpu")
    if not isinstance(background, Tensor) or background.shape != (channels,):
        raise InputError(
            f"the background has shape {shape_of(background)}: [{channels}] was expected, one "
            "number for each channel of the colours"
        )
    for name, tensor in (("colours", inputs.colors), ("lobes", inputs.lobes)):
        means = inputs.means
        if tensor is not None and (tensor.dtype, tensor.device) != (means.dtype, means.device):
            raise InputError(
                f"the {name} are {tensor.dtype} on {tensor.device}, and the means {means.dtype} on "
                f"{means.device}: all must have one type and device"
            )
    if not isinstance(screen_grads, Tensor | None):
        raise InputError("screen_grads are no tensor")
    if screen_grads is not None and channels > 3:
        raise InputError(
            f"screen_grads of {channels} channels: render three of them, with screen_grads, apart "
            "from the others"
        )
    options = (background, settings, bool(depth))
    if isinstance(camera, Camera):
        return _render_view(inputs, camera, *options, screen_grads, backend)
    cameras = list(camera) if isinstance(camera, Sequence) else []
    if not cameras or not all(isinstance(view, Camera) for view in cameras):
        raise InputError(
            "camera is neither a Camera nor a sequence of at least one: make each as "
            "Camera(viewmat, K, width, height)"
        )
    sizes = dict.fromkeys(f"{view.width}x{view.height}" for view in cameras)
    if len(sizes) > 1:
        raise InputError(
            f"cameras of several image sizes ({', '.join(sizes)}): render each size by itself"
        )
    shape = (len(cameras), len(inputs.means), 2)
    if screen_grads is not None and screen_grads.shape != shape:
        raise InputError(
            f"screen_grads have shape {list(screen_grads.shape)}: {list(shape)} was expected for "
            f"{shape[0]} cameras"
        )
    grads = [None] * len(cameras) if screen_grads is None else screen_grads.unbind(0)
    views = [
        _render_view(inputs, view, *options, grad, backend)
        for view, grad in zip(cameras, grads, strict=True)
    ]
    depths = [view.depth for view in views if view.depth is not None]
    return Rendered(
        torch.stack([view.image for view in views]),
        torch.stack([view.alpha for view in views]),
        torch.stack(depths) if depths else None,
        torch.stack([view.radii for view in views]),
    )


def _render_view(
    inputs: RenderInputs,
    camera: Camera,
    background: Tensor,
    settings: RenderSettings,
    depth: bool,
    screen_grads: Tensor | None,
    backend: Backend,
) -> Rendered:
    """Render one view: prepares the gradient of its pose, and splits channels by three."""
    backend = _resolve(backend, inputs.means)
    render = _render_kernel if backend == "kernel" else _render_reference
    if backend == "reference" and screen_grads is not None:
        raise InputError("the reference has no screen_grads: use backend='kernel'")
    if torch.is_grad_enabled():
        if camera.K.requires_grad:
            raise InputError("camera.K requires gradients, which renderers do not have: detach it")
        if backend == "kernel" and background.requires_grad:
            raise InputError(
                "the background requires gradients, which the kernels do not have: detach it, or "
                "render over black and add (1 - alpha) * background"
            )
        if camera.viewmat.requires_grad:
            camera = replace(camera, viewmat=rigid(camera.viewmat))
            if backend == "kernel":
                inputs, camera = carried_by_gaussians(inputs, camera)
    colors = inputs.colors
    options = (camera, settings)
    if colors.ndim == 3 or colors.shape[1] == 3:
        return render(inputs, background, *options, depth, screen_grads)
    channels = colors.shape[1]
    if channels > 3:  # a value that is not finite takes its Gaussian out of all groups
        colors = torch.where(colors.isfinite().all(1, keepdim=True), colors, torch.nan)
    padding = (0, -channels % 3)
    groups = zip(pad(colors, padding).split(3, 1), pad(background, padding).split(3), strict=True)
    parts = [
        render(inputs._replace(colors=three), behind, *options, depth and not i, screen_grads)
        for i, (three, behind) in enumerate(groups)
    ]
    image = torch.cat([part.image for part in parts], dim=2)[..., :channels]
    return parts[0]._replace(image=image)


def _render_kernel(
    inputs: RenderInputs,
    background: Tensor,
    camera: Camera,
    settings: RenderSettings,
    depth: bool,
    screen_grads: Tensor | None,
) -> Rendered:
    means, colors, lobes = inputs.means, inputs.colors, inputs.lobes
    view = kernel_view(
        camera,
        background,
        settings,
        sh_size=colors.shape[1] if colors.ndim == 3 else 0,
        lobe_size=0 if lobes is None else lobes.shape[1],
    )
    return Rendered(*_raster(means).apply(view, screen_grads, None, depth, *inputs))


def render_raw(
    inputs: RenderInputs,
    camera: Camera,
    background: Float[Tensor, "3"],
    settings: RenderSettings,
    *,
    more: MoreHarmonics | None = None,
    sh_degree: int,
    depth: bool = False,
    screen_grads: Float[Tensor, "n 2"] | None = None,
) -> Rendered:
    """Render by the kernels from the values that training optimises, float32.

    `inputs` holds the logarithms of the scales and, for sorted blending, the logits of the
    opacities. With `more`, its colours are the first harmonics of `sh_degree`; the gradients of
    the others do not go through autograd. The camera's have none.
    """
    view = kernel_view(
        camera,
        background,
        settings,
        sh_size=(sh_degree + 1) ** 2,
        lobe_size=0 if inputs.lobes is None else inputs.lobes.shape[1],
        raw=True,
        more_width=0 if more is None else 3 * more.values.shape[1],
    )
    return Rendered(*_raster(inputs.means).apply(view, screen_grads, more, depth, *inputs))


def _render_reference(
    inputs: RenderInputs,
    background: Tensor,
    camera: Camera,
    settings: RenderSettings,
    depth: bool,
    screen_grads: Tensor | None,
) -> Rendered:
    means, quats, scales, opacities, colors, lobes = inputs
    background, shift = background.to(means.device), 0
    if colors.ndim == 2:
        # the references clamp at 0: colours move up, and the image, a mean of them, back down
        known = torch.cat([colors, background[None]]).detach()
        shift = 1 - torch.where(known.isfinite(), known, 0.0).amin(0)
        colors, background = rgb_to_sh0(colors + shift)[:, None, :], background + shift
    options = {"camera": camera, "background": background, "footprint": settings.footprint}
    if lobes is None:
        assert opacities is not None
        rendered = sorted_reference.render_sorted(
            means, quats, scales, opacities, colors, **options
        )
    else:
        rendered = sortfree_reference.render_sortfree(
            means,
            quats,
            scales,
            lobes,
            colors,
            weighting=settings.weighting,
            level_sigma=settings.level_sigma,
            **options,
        )
    image = rendered.image - shift
    return rendered._replace(image=image, depth=rendered.depth if depth else None)


@torch.no_grad()
def measure_contributions(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    *,
    camera: Camera,
    footprint: Footprint = CLASSIC,
    backend: Backend = "auto",
) -> Contributions:
    """Return how much each Gaussian contributes to a sorted image, without gradients.

    The reference is `render/contributions.py`; arguments as in `render_sorted`.
    """
    validate_gaussians(means, quats=quats, scales=scales, opacities=opacities)
    if _resolve(backend, means) == "reference":
        return contributions_reference.measure_contributions(
            means, quats, scales, opacities, camera=camera, footprint=footprint
        )
    black = torch.zeros_like(means[:, None, :])
    settings = RenderSettings(footprint=footprint)
    view = kernel_view(camera, BLACK, settings, sh_size=1, lobe_size=0)
    kernels = cuda if cuda.takes(means) else cpu
    return kernels.measure_contributions(view, means, quats, scales, opacities, black)


@torch.no_grad()
def visible_rows(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    *,
    camera: Camera,
    footprint: Footprint = CLASSIC,
) -> Int[Tensor, "m"]:
    """Return the indices of the Gaussians that could touch the image if they were opaque."""
    validate_gaussians(means, quats=quats, scales=scales)
    ones = torch.ones_like(means[:, 0])
    black = torch.zeros_like(means[:, None, :])
    if _resolve("auto", means) == "reference":
        shapes = (means, quats, scales, ones, black)
        visible = project(*shapes, camera=camera, footprint=footprint).visible
    else:
        settings = RenderSettings(footprint=footprint)
        view = kernel_view(camera, BLACK, settings, sh_size=1, lobe_size=0)
        kernels = cuda if cuda.takes(means) else cpu
        visible = kernels.project_radii(view, means, quats, scales, ones, black) > 0
    return visible.nonzero()[:, 0]
