"""Render a scene by WebGPU, with the web viewer's shaders.

A frame has three passes: project (compute, per Gaussian), splat (blended quads, in any order for a
sort-free scene, all levels in one texture; after the depth pass, if there is one) and resolve (per
pixel). The weight w is computed in project.wgsl, alpha and the depth pass's factor in splat.wgsl,
the image in resolve.wgsl; the reference is mobilegs/render. Before them, network.wgsl evaluates the
paper's network in scenes that have one.
"""

import math
import struct
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Float32, UInt32
from torch import Tensor
from torch.nn.functional import pad

from mobilegs.camera import Camera, look_at
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import psnr
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.limits import WORLD_MAX, WORLD_MIN
from mobilegs.render.depth_pass import PASS_LEVEL
from mobilegs.render.inputs import RenderSettings, validate_settings
from mobilegs.render.levels import level_places, level_sizes
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.project import ALPHA_MIN, jacobian_limits, rotation_matrices
from mobilegs.render.scene import Scene
from mobilegs.render.sortfree import Weighting
from mobilegs.render.supersampling import magnified
from mobilegs.render.view_network import ViewNetwork, static_inputs
from mobilegs.view.wgpu_device import (
    FLOAT16_SCALES,
    PASSES,
    REMEDY,
    draws_by_opengl,
    gpus,
    name_of,
    program_of,
    translated_abort,
    translated_errors,
)

BATCH = 128  # as in view.wgsl
GROUP_GAUSSIANS = 32  # of a work group of network.wgsl
LOOK_BYTES = 32  # of wide.wgsl's StoredLook
AGREEMENT = 50.0  # dB, of images in float16 against the reference


class WgpuImage(NamedTuple):
    """A rendered image, on the CPU.

    Attributes:
        image: sRGB, at least 0, `[h, w, 3]`.
        alpha: coverage of the background, in [0, 1], `[h, w]`.
    """

    image: Float[Tensor, "h w 3"]
    alpha: Float[Tensor, "h w"]


@cache
def usable_gpu(blend_sorted: bool, full_precision: bool) -> Any:
    """Return the first of `gpus()` that can render.

    One that is reached by OpenGL must agree with the reference first. Raises InputError, with what
    each GPU lacks, if none can.
    """
    lacking = []
    for gpu in gpus():
        try:
            program_of(gpu, blend_sorted, full_precision)
            if draws_by_opengl(gpu) and (decibels := agreement(gpu)) < AGREEMENT:
                raise InputError(f"{name_of(gpu)} renders wrong images ({decibels:.0f} dB)")
            return gpu
        except InputError as error:
            lacking.append(str(error))
    raise InputError(f"no GPU can render: {'; '.join(lacking)}; {REMEDY}")


@torch.no_grad()
def agreement(gpu: Any) -> float:
    """Return the lowest PSNR in dB of small images that a GPU renders, against `Scene.render`.

    They are sorted, sort-free, and sort-free with levels, without a depth pass and with one, in
    float16; `AGREEMENT` is the least that is right. Raises InputError if the GPU cannot render.
    """
    gaussians, camera = _sample()
    worst = math.inf
    passing = Weighting("depth_pass", sigma=4.0)
    ways = [("sorted", 0.0), ("sortfree", 0.0), ("sortfree", 1.0), ("sortfree", 1.0)]
    for number, (blend, level_sigma) in enumerate(ways):
        scene = Scene(gaussians, blend, weighting=passing if number == 3 else Weighting())
        image = WgpuRenderer(scene, level_sigma=level_sigma, gpu=gpu).render(camera).image
        expected = scene.render(camera, level_sigma=level_sigma).image
        worst = min(worst, psnr(image.nan_to_num(nan=1e3), expected))
    return worst


def _sample() -> tuple[Gaussians, Camera]:
    """Return 200 random Gaussians, small and large ones, and a camera."""
    generator = torch.Generator().manual_seed(0)
    numbers = torch.randn(200, 3 + 4 + 3 + 1 + 12, generator=generator)
    means, quats, scales, logits, sh = numbers.split([3, 4, 3, 1, 12], dim=1)
    gaussians = Gaussians(means, quats, 0.8 * scales - 2, logits[:, 0], sh.reshape(-1, 4, 3))
    K = torch.tensor([[60.0, 0, 32], [0, 60, 24], [0, 0, 1]])
    viewmat = look_at(torch.tensor([1.0, -0.7, -3.8]), torch.zeros(3), torch.tensor([0.0, -1, 0]))
    return gaussians, Camera(viewmat, K, 64, 48)


class _Sums(NamedTuple):
    """Textures of one size."""

    size: tuple[int, int]  # height and width of the image
    views: list[list[Any]]  # of all levels, then of levels 1 and 2 with the coarser ones added
    moments: Any  # the picture of the depth pass, or None
    to_splat: Any  # the pipeline that reads it with its resources, or None


class WgpuRenderer:
    """A scene in the memory of a GPU.

    Attributes:
        scene: the scene.
        program: the device and its pipelines.
        count: number of Gaussians; those with values that are not finite are left out.
        level_sigma: as in `render_sortfree`; 0 for scenes that are blended sorted. Images so large
            that a texture of all levels exceeds the GPU's limit have none.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        full_precision: bool = False,
        level_sigma: float = 0.0,
        gpu: Any = None,
    ) -> None:
        """Upload a scene.

        Sums and images are float16, which every GPU blends, and so are the numbers of a view
        network where the GPU computes with them; float32 with `full_precision`. `gpu` is one of
        `wgpu_device.gpus()`; by default the first one that can render.

        Raises InputError without a GPU, if none can render (with `full_precision`: blend and filter
        32-bit floats) or its memory does not hold the scene, and for a `level_sigma` that
        `render_sortfree` refuses. `render` and `render_into` raise it if the GPU fails or is lost.
        """
        settings = RenderSettings(scene.weighting, scene.footprint.drawn(scene.blend), level_sigma)
        validate_settings(settings, sortfree=scene.blend != "sorted")
        self.scene = scene
        self.level_sigma = 0.0 if scene.blend == "sorted" else level_sigma
        kind = (scene.blend == "sorted", full_precision)
        self.program = program_of(usable_gpu(*kind) if gpu is None else gpu, *kind)
        self._depth_pass = scene.blend != "sorted" and scene.weighting.name == "depth_pass"
        self._weight_scale = 1.0 if full_precision else FLOAT16_SCALES[self._depth_pass]
        self._sums: _Sums | None = None
        with translated_errors(self.program.gpu):
            self._upload(*_rows(scene))

    def render(self, camera: Camera, *, supersampling: int = 1) -> WgpuImage:
        """Render from `camera` and read the image back; `supersampling` as in `Scene.render`.

        Raises InputError for an image that is larger than the GPU's textures.
        """
        import wgpu

        self._validate_size(magnified(camera, supersampling))
        size = (camera.width, camera.height, 1)
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC
        device, target = self.program.device, self.program.target
        number = torch.float32 if target == "rgba32float" else torch.float16
        with translated_errors(self.program.gpu):
            texture = device.create_texture(size=size, format=target, usage=usage)
            self.render_into(texture.create_view(), target, camera, supersampling=supersampling)
            data = device.queue.read_texture(
                {"texture": texture},
                {"bytes_per_row": 4 * number.itemsize * camera.width},
                size,
            )
        pixels = torch.frombuffer(bytearray(data), dtype=number).float()
        pixels = pixels.reshape(camera.height, camera.width, 4)
        return WgpuImage(pixels[..., :3].contiguous(), pixels[..., 3].contiguous())

    def far_first(self, camera: Camera) -> UInt32[np.ndarray, "n"]:
        """Return the indices of the Gaussians from `camera`, the farthest first."""
        depths = self._means @ camera.viewmat[2, :3].double().cpu().numpy()
        return np.argsort(depths, kind="stable")[::-1].astype(np.uint32)

    def milliseconds(self) -> dict[str, float] | None:
        """Return the time of each pass of the last frame; None if the device has no timer."""
        with translated_errors(self.program.gpu):
            return self.program.milliseconds(PASSES if self._network else PASSES[1:])

    def render_into(
        self,
        target: Any,
        target_format: str,
        camera: Camera,
        *,
        order: UInt32[np.ndarray, "n"] | None = None,
        supersampling: int = 1,
    ) -> None:
        """Render into a texture view of the camera's size and of the given format.

        A sorted scene is rendered in `order`, by default that of `far_first`. `supersampling` as in
        `Scene.render`. Raises InputError for an image that is larger than the GPU's textures.
        """
        camera = magnified(camera, supersampling)
        self._validate_size(camera)
        queue = self.program.device.queue
        leveled = self._is_leveled(camera)
        with translated_errors(self.program.gpu):
            queue.write_buffer(self._view, 0, self._packed(camera, supersampling))
            if self.program.sorted:
                order = self.far_first(camera) if order is None else order
                queue.write_buffer(self._order, 0, order)
            queue.write_buffer(self._drawn, 0, _DRAWN.pack(6 * BATCH, 0, 0, 0, 0, 0))
            sums = self._sums_of(camera)
            encoder = self.program.device.create_command_encoder()
            if self._network:
                self._compute(encoder, "network", self._network, GROUP_GAUSSIANS)
            self._compute(encoder, "project", self._to_project, BATCH)
            self._splat(encoder, sums, leveled=leveled)
            self._resolve(encoder, sums.views, target, target_format)
            with translated_abort(self.program.gpu):
                queue.submit([encoder.finish()])

    def _validate_size(self, camera: Camera) -> None:
        most = self.program.device.limits["max-texture-dimension-2d"]
        if not (0 < camera.width <= most and 0 < camera.height <= most):
            raise InputError(
                f"an image of {camera.width}x{camera.height} pixels cannot be rendered: each side "
                f"must lie between 1 and {most}"
            )

    def _upload(
        self,
        shapes: np.ndarray,
        colors: np.ndarray,
        lobes: np.ndarray,
        inputs: np.ndarray | None,
        means: np.ndarray,
    ) -> None:
        import wgpu

        use, device = wgpu.BufferUsage, self.program.device
        self.count, self._means = len(shapes), means
        self._sizes = (colors.shape[1], lobes.shape[1])
        limits = device.limits
        most = min(limits["max-storage-buffer-binding-size"], limits["max-buffer-size"])
        uploaded = [part for part in (shapes, colors, lobes, inputs) if part is not None]
        largest = max(LOOK_BYTES * self.count, *(part.nbytes for part in uploaded))
        if largest > most:
            raise InputError(
                f"{self.count:,} Gaussians need buffers of {largest >> 20} MiB, and this GPU "
                f"takes {most >> 20} MiB: use --renderer kernels"
            )
        scene = [
            device.create_buffer_with_data(data=part, usage=use.STORAGE)
            for part in (shapes, colors, lobes)
        ]
        looks = device.create_buffer(size=LOOK_BYTES * self.count, usage=use.STORAGE)
        self._view = device.create_buffer(size=_VIEW.size, usage=use.UNIFORM | use.COPY_DST)
        self._drawn = device.create_buffer(
            size=_DRAWN.size,
            usage=use.STORAGE | use.INDIRECT | use.COPY_DST | use.COPY_SRC,
        )
        usage = use.STORAGE | use.COPY_DST | use.COPY_SRC
        self._order = device.create_buffer(size=4 * self.count, usage=usage)
        quad = np.array([0, 1, 2, 2, 1, 3], np.uint16)
        quads = (quad + 4 * np.arange(BATCH, dtype=np.uint16)[:, None]).flatten()
        self._corners = device.create_buffer_with_data(data=quads, usage=use.INDEX)
        written = [looks] if self.program.sorted else [looks, self._order, self._drawn]
        self._to_project = self._bind(
            self.program.project, dict(enumerate([self._view, *scene, *written]))
        )
        read = {0: self._view, 1: scene[0], 4: looks, 5: self._order}
        if not self.program.sorted:
            read[6] = self._drawn
        self._read = read
        if self._depth_pass:
            self._to_depths = self._bind(self.program.depths, read)
        else:
            self._to_splat = {False: (self.program.splat, self._bind(self.program.splat, read))}
            if self.level_sigma:
                leveled = self.program.splat_levels
                self._to_splat[True] = (leveled, self._bind(leveled, read))
        self._network = None
        if inputs is not None and self.scene.network is not None:
            number = np.float16 if self.program.number == "f16" else np.float32
            read, weights = (
                device.create_buffer_with_data(data=part, usage=use.STORAGE)
                for part in (inputs, network_matrices(self.scene.network).astype(number))
            )
            self._network = self._bind(
                self.program.network,
                {0: self._view, 1: scene[0], 4: read, 5: weights, 6: scene[2]},
            )

    def _bind(
        self,
        pipeline: Any,
        buffers: dict[int, Any],
        others: dict[int, Any] | None = None,
    ) -> Any:
        """Make a bind group of buffers, and others: textures and samplers."""
        entries: list[dict] = [
            {"binding": i, "resource": {"buffer": buffer, "offset": 0, "size": buffer.size}}
            for i, buffer in buffers.items()
        ]
        entries += [{"binding": i, "resource": view} for i, view in (others or {}).items()]
        return self.program.device.create_bind_group(
            layout=pipeline.get_bind_group_layout(0), entries=entries
        )

    def _is_leveled(self, camera: Camera) -> bool:
        most = self.program.device.limits["max-texture-dimension-2d"]
        return bool(self.level_sigma) and max(level_places(camera.height, camera.width)[1]) <= most

    def _sums_of(self, camera: Camera) -> _Sums:
        """Return the textures of the sums; they are created for each new size."""
        size = camera.height, camera.width
        if self._sums is None or self._sums.size != size:
            sizes = [size]
            if self._is_leveled(camera):
                sizes = [level_places(*size)[1], *level_sizes(*size)[1:3]]
            views = [[self._texture(s, name) for name in self.program.formats] for s in sizes]
            moments = to_splat = None
            if self._depth_pass:
                moments = self._texture(level_sizes(*size)[PASS_LEVEL], self.program.moments)
                others = {2: moments, 3: self.program.bilinear}
                pipeline = self.program.splat_seen[self._is_leveled(camera)]
                to_splat = (pipeline, self._bind(pipeline, self._read, others))
            self._sums = _Sums(size, views, moments, to_splat)
        return self._sums

    def _texture(self, size: tuple[int, int], name: str) -> Any:
        import wgpu

        usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING
        device, (height, width) = self.program.device, size
        texture = device.create_texture(size=(width, height, 1), format=name, usage=usage)
        return texture.create_view()

    def _packed(self, camera: Camera, supersampling: int) -> bytes:
        viewmat, k = camera.viewmat.double().cpu(), camera.K.double().cpu()
        rotation, translation = viewmat[:3, :3], viewmat[:3, 3]
        weighting, footprint = self.scene.weighting, self.scene.footprint.drawn(self.scene.blend)
        return _VIEW.pack(
            *viewmat[:3].flatten().tolist(),
            *(-(rotation.T @ translation)).tolist(),
            camera.near,
            *(float(k[0, 0]), float(k[1, 1]), float(k[0, 2]), float(k[1, 2])),
            *jacobian_limits(camera),
            *self.scene.background.tolist(),
            weighting.exponent_max,
            *(camera.width, camera.height),
            min(max(weighting.sigma, WORLD_MIN), WORLD_MAX),
            weighting.background_weight,
            self._weight_scale,
            *(self.count, *self._sizes, weighting.index),
            ALPHA_MIN if self.program.sorted else weighting.alpha_min,
            *(footprint.blur, footprint.antialiased, footprint.soft_edge),
            self.level_sigma if self._is_leveled(camera) else 0.0,
            supersampling,
            *_regions(camera),
        )

    def _compute(self, encoder: Any, name: str, resources: Any, group_size: int) -> None:
        groups = -(-self.count // group_size)
        across = min(groups, 65535)
        work = encoder.begin_compute_pass(timestamp_writes=self.program.stamps(name))
        work.set_pipeline(getattr(self.program, name))
        work.set_bind_group(0, resources)
        work.dispatch_workgroups(across, -(-groups // across))
        work.end()

    def _splat(self, encoder: Any, sums: _Sums, *, leveled: bool) -> None:
        # sort-free: T = 1 in the alpha channel; sorted: alpha = 0
        nothing = (0, 0, 0, 0)
        clear = [nothing if self.program.sorted else (0, 0, 0, 1), nothing]
        passes = []
        if self._depth_pass:
            passes.append((self.program.depths, self._to_depths, [sums.moments], [nothing]))
            passes.append((*sums.to_splat, sums.views[0], clear))
        else:
            passes.append((*self._to_splat[leveled], sums.views[0], clear))
        for number, (pipeline, resources, written, colors) in enumerate(passes):
            last = number == len(passes) - 1
            work = encoder.begin_render_pass(
                color_attachments=[
                    {"view": view, "load_op": "clear", "store_op": "store", "clear_value": color}
                    for view, color in zip(written, colors, strict=False)
                ],
                timestamp_writes=self.program.stamps("splat", begin=number == 0, end=last),
            )
            work.set_pipeline(pipeline)
            work.set_bind_group(0, resources)
            work.set_index_buffer(self._corners, "uint16")
            if self.program.sorted:
                work.draw_indexed(6 * BATCH, -(-self.count // BATCH))
            else:
                work.draw_indexed_indirect(self._drawn, 0)
            work.end()

    def _resolve(
        self, encoder: Any, sums: list[list[Any]], target: Any, target_format: str
    ) -> None:
        leveled = len(sums) > 1
        pipeline = self.program.resolve(target_format, levels=leveled)
        passes = [(pipeline, [*sums[0], *(sums[1] if leveled else [])], [target])]
        if leveled:  # level 2 with 3, then level 1 with both
            enlarge = self.program.enlarge
            passes.insert(0, (enlarge[1], [*sums[0], *sums[2]], sums[1]))
            passes.insert(0, (enlarge[2], [*sums[0], *sums[0]], sums[2]))
        for number, (pipeline, read, written) in enumerate(passes):
            last = number == len(passes) - 1
            resources = dict(enumerate(read, start=1))
            if len(read) == 4:
                resources[5] = self.program.bilinear
            work = encoder.begin_render_pass(
                color_attachments=[
                    {"view": view, "load_op": "clear", "store_op": "store"} for view in written
                ],
                timestamp_writes=self.program.stamps("resolve", begin=number == 0, end=last),
            )
            work.set_pipeline(pipeline)
            work.set_bind_group(0, self._bind(pipeline, {0: self._view}, resources))
            work.draw(3)
            work.end()


# view.wgsl's View: rows, position and near, focal and centre, limits, background and exponent_max,
# size, sigma and background_weight, weight_scale, the integers, zeros for packed scenes, alpha_min,
# the footprint, level_sigma, supersampling, the levels' regions and the size of all, zeros for a
# depth, a fading, a grade and a crop
_VIEW = struct.Struct("<12f 4f 4f 4f 4f 4f f 4I 36x f f 2I f I 16f 2f 88x")
_DRAWN = struct.Struct("<6I")  # project.wgsl's Drawn


def _regions(camera: Camera) -> list[int]:
    """Return first column and row and their ends of each level in one texture, and its size."""
    size = camera.height, camera.width
    places, (rows, columns) = level_places(*size)
    regions = []
    for (y, x), (height, width) in zip(places, level_sizes(*size), strict=True):
        regions += [x, y, x + width, y + height]
    return [*regions, columns, rows]


@torch.no_grad()
def _rows(
    scene: Scene,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None, np.ndarray]:
    """Return arrays for the GPU by Gaussian: half axes with mean, harmonics, lobes; its mean.

    With a view network, the fourth array holds its inputs, and the lobes are those that it
    replaces in each frame. Leaves out Gaussians with values that are not finite: shader compilers
    may assume that all numbers are.
    """
    gaussians = scene.gaussians.to("cpu")
    constant = constant_lobes(gaussians.logit_opacities)
    lobes = constant if scene.lobes is None else scene.lobes.detach().cpu()
    # columns are half axes
    axes = rotation_matrices(gaussians.quats) * gaussians.scales[:, None, :]
    shapes = torch.cat([axes.mT, gaussians.means[:, :, None]], dim=2)  # [n, 3, 4]
    values = torch.cat([shapes.flatten(1), gaussians.sh.flatten(1), lobes.flatten(1)], dim=1)
    valid = values.isfinite().all(1) & (gaussians.quats.square().sum(1) > 0)

    def rows(tensor: Tensor) -> np.ndarray:
        kept = tensor[valid].float()
        if not len(kept):  # buffers cannot be empty: one invisible Gaussian
            kept = torch.full((1, *tensor.shape[1:]), -100.0)
        return kept.contiguous().numpy()

    inputs = None
    if scene.network is not None:
        inputs = rows(torch.cat([static_inputs(gaussians), constant[:, 0, :1]], dim=1))
    means = rows(gaussians.means).astype(np.float64)
    return rows(shapes), rows(gaussians.sh), rows(lobes), inputs, means


@torch.no_grad()
def network_matrices(network: ViewNetwork) -> Float32[np.ndarray, "2497 4 4"]:
    """Return the weights of a view network as network.wgsl reads them: `[matrix, output, input]`.

    The 64-wide layer has no activation, so the two heads and it are one layer.
    """
    heads = torch.cat([network.opacity.weight, network.phi.weight]).double()  # [2, 64]
    offsets = torch.cat([network.opacity.bias, network.phi.bias]).double()
    offsets = offsets + heads @ network.hidden3.bias.double()
    heads = heads @ network.hidden3.weight.double()  # [2, 128]
    first = torch.cat([network.hidden1.weight, network.hidden1.bias[:, None]], dim=1)
    layers = [
        _blocks(pad(first, (0, 1))),
        _blocks(pad(network.hidden2.bias[:, None], (0, 3))),
        _blocks(network.hidden2.weight).transpose(0, 1),
        _blocks(pad(heads, (0, 0, 0, 2))),
        _blocks(pad(offsets[:, None], (0, 3, 0, 2))),
    ]
    return torch.cat([layer.reshape(-1, 4, 4).float() for layer in layers]).cpu().numpy()


def _blocks(matrix: Float[Tensor, "o i"]) -> Float[Tensor, "a b 4 4"]:
    """Cut a matrix of outputs by inputs into blocks of 4 by 4."""
    outputs, inputs = matrix.shape
    return matrix.reshape(outputs // 4, 4, inputs // 4, 4).transpose(1, 2)
