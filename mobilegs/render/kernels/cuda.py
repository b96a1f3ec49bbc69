"""The CUDA kernels: csrc/cuda.cu, compiled by NVRTC at first use; torch sorts and scans.

Users need no CUDA toolkit: cuda-core and NVRTC are Python packages. Compiled kernels are kept in a
cache folder. Where there is no GPU, tests compile every kernel and emulate it thread by thread on a
CPU.
"""

# pyright takes `cuda` for this file
# pyright: reportAttributeAccessIssue=false

import ctypes
import hashlib
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import torch
from torch import Tensor

from mobilegs.atomic import atomic_write
from mobilegs.errors import InputError
from mobilegs.render.contributions import Contributions, count_wins
from mobilegs.render.kernels.kernel_view import SPLAT_BYTES, KernelView, validate_inputs

SOURCES = (
    "cuda.cu",
    "cuda_common.h",
    "cuda_contributions.h",
    "cuda_sorted.h",
    "cuda_sortfree.h",
    "pairs.h",
    "core.h",
    "lanes.h",
)
TILE = 16
THREADS = 256  # of every kernel but the sorted backward walk
CSRC = Path(__file__).parents[2] / "csrc"
WALK_THREADS = 128
PER_WARP = 8  # Gaussians a block takes where each gets a warp
SUMS = 12  # floats of a Gaussian's or an entry's sums


def _missing(error: Exception) -> InputError:
    return InputError(
        f"rendering on a GPU needs the compiler of its kernels ({error}): "
        "run `pip install 'mobilegs[cuda]'`"
    )


def compile_kernels(arch: str, source: str | None = None) -> tuple[bytes, str]:
    """Return machine code for `arch` (such as `sm_90`) and the compiler's report on resources.

    The source is cuda.cu unless given. Needs no GPU and no driver. Raises InputError if the
    compiler is not installed or does not know `arch`.
    """
    try:
        from cuda.core import Program, ProgramOptions
    except ImportError as error:
        raise _missing(error) from error
    folder, log = CSRC, io.StringIO()
    options = ProgramOptions(
        name="cuda.cu",
        arch=arch,
        ftz=True,  # transmittances under dense overlap are full of denormals
        include_path=str(folder),
        ptxas_options=["-v"],
    )
    source = source or (folder / "cuda.cu").read_text()
    try:
        code = Program(source, "c++", options).compile("cubin", logs=log)
    except Exception as error:
        if "--gpu-architecture" not in str(error):
            raise
        raise InputError(
            f"the installed compiler of CUDA kernels does not know this GPU ({arch}): "
            "run on the CPU, or install a release of nvidia-cuda-nvrtc that does"
        ) from error
    return bytes(code.code), log.getvalue()


def cache_folder() -> Path:
    """Return the folder of compiled kernels: `MOBILEGS_CACHE`, or the user's cache folder."""
    named = os.environ.get("MOBILEGS_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mobilegs"


def cubin(arch: str) -> bytes:
    """Return machine code of cuda.cu for `arch`, cached by sources, options and compiler.

    Raises InputError if the compiler is not installed.
    """
    try:
        from cuda.bindings import nvrtc

        version = nvrtc.nvrtcVersion()
    except (ImportError, RuntimeError) as error:  # the binding, or the library behind it
        raise _missing(error) from error
    digest = hashlib.sha256(repr((arch, version)).encode())
    for path in (*(CSRC / name for name in SOURCES), Path(__file__)):  # this file holds the options
        digest.update(path.read_bytes())
    path = cache_folder() / f"kernels-{arch}-{digest.hexdigest()[:24]}.cubin"
    try:
        return path.read_bytes()
    except OSError:
        pass
    code, _ = compile_kernels(arch)
    try:
        atomic_write(path, code)
    except (InputError, OSError):
        pass  # without a cache, each process compiles for two seconds
    return code


class Kernels:
    """The kernels of one GPU, launched on torch's current stream."""

    def __init__(self, device: torch.device) -> None:
        from cuda.core import ObjectCode

        self.device = device
        major, minor = torch.cuda.get_device_capability(device)
        self.code = ObjectCode.from_cubin(cubin(f"sm_{major}{minor}"), name="cuda.cu")
        self.functions = {}

    @contextmanager
    def current(self) -> Iterator[None]:
        """Make the GPU current: autograd's threads may not have a context of it yet."""
        from cuda.core import Device

        with torch.cuda.device(self.device):
            Device(self.device.index).set_current()
            yield

    def launch(self, name: str, blocks: int, threads: int, *arguments) -> None:
        """Start a kernel; arguments are ctypes values, structs included, passed by value."""
        from cuda.bindings import driver

        if blocks == 0:
            return
        if name not in self.functions:
            self.functions[name] = driver.CUfunction(int(self.code.get_kernel(name).handle))
        stream = torch.cuda.current_stream(self.device).cuda_stream
        addresses = argument_addresses(arguments)
        (status,) = driver.cuLaunchKernel(
            self.functions[name],
            *(blocks, 1, 1),
            *(threads, 1, 1),
            0,
            driver.CUstream(stream),
            ctypes.addressof(addresses),
            0,
        )
        if status != driver.CUresult.CUDA_SUCCESS:
            raise RuntimeError(f"the kernel {name} could not be started: {status.name}")


def argument_addresses(arguments: tuple) -> ctypes.Array:
    """Return a kernel's arguments in the driver's form: an array of pointers to them."""
    return (ctypes.c_void_p * len(arguments))(*[ctypes.addressof(a) for a in arguments])


@cache
def _kernels(index: int) -> Kernels:
    return Kernels(torch.device("cuda", index))


def kernels_for(tensor: Tensor) -> Kernels:
    """Return the kernels of the tensor's GPU."""
    return _kernels(tensor.device.index)


def _pointers(*tensors: Tensor | None) -> ctypes.Array:
    """Make a struct of pointers."""
    values = [None if t is None else t.data_ptr() for t in tensors]
    return (ctypes.c_void_p * len(values))(*values)


def _pointer(tensor: Tensor | None) -> ctypes.c_void_p:
    return ctypes.c_void_p(None if tensor is None else tensor.data_ptr())


def _blocks(count: int, per_block: int = THREADS) -> int:
    return (count + per_block - 1) // per_block


def _tiles(view: KernelView) -> int:
    """Return the number of tiles of all levels."""
    return sum(_blocks(height, TILE) * _blocks(width, TILE) for height, width in view.sizes)


def _project(kernels: Kernels, view: KernelView, inputs: list[Tensor | None]) -> tuple[Tensor, ...]:
    """Return splats, radii, number of tiles and tile of the box's centre of every Gaussian."""
    means = inputs[0]
    assert means is not None
    count = len(means)
    splats = means.new_empty(count, SPLAT_BYTES, dtype=torch.uint8)
    radii = means.new_empty(count)
    touched = means.new_empty(count, dtype=torch.int32)
    center_tiles = means.new_empty(count, dtype=torch.int32)
    outputs = [_pointer(t) for t in (splats, radii, touched, center_tiles)]
    kernels.launch(
        "mgs_project",
        _blocks(count),
        THREADS,
        view,
        ctypes.c_int(count),
        _pointers(*inputs),
        *outputs,
    )
    return splats, radii, touched, center_tiles


class _Lists:
    """Tile lists: the Gaussians that each tile visits, by index or (`by_depth`) front first.

    Sorting the Gaussians by depth and then their entries by tile, both stably, moves half the
    bytes of one sort of entries by a 64-bit key.
    """

    def __init__(
        self, kernels: Kernels, view: KernelView, splats: Tensor, touched: Tensor, *, by_depth: bool
    ) -> None:
        self.order = None
        if by_depth:
            depths = splats.view(torch.float32)[:, 10]  # Splat.z
            self.order = torch.sort(depths, stable=True).indices
            touched = touched[self.order]
        self.ends = torch.cumsum(touched, 0)
        self.count = int(self.ends[-1]) if len(touched) else 0
        tiles = touched.new_empty(self.count)
        ids = touched.new_empty(self.count)
        count = len(touched) if self.count else 0
        outputs = [_pointer(t) for t in (splats, self.order, self.ends, tiles, ids)]
        kernels.launch("mgs_fill", _blocks(count), THREADS, view, ctypes.c_int(count), *outputs)
        tiles, self.slots = torch.sort(tiles, stable=True)
        self.ids = ids[self.slots]
        bounds = torch.arange(_tiles(view) + 1, dtype=torch.int32, device=tiles.device)
        self.starts = torch.searchsorted(tiles, bounds)

    def pointers(self) -> ctypes.Array:
        return _pointers(self.starts, self.ids, self.slots)


def _suffixed(name: str, depth: bool) -> str:
    return f"{name}_depth" if depth else name


def _sortfree(view: KernelView, suffix: str) -> str:
    return f"mgs_two_pass_{suffix}" if view.two_pass else f"mgs_sortfree_{suffix}"


class CudaRaster(torch.autograd.Function):
    """Both renderers on a GPU: sorted with `opacities`, sort-free with `lobes`; one is None."""

    @staticmethod
    def forward(ctx, view, screen_grads, depth, means, quats, scales, opacities, sh, lobes):
        inputs = [means, quats, scales, opacities, sh, lobes]
        validate_inputs(view, inputs, screen_grads)
        kernels, shape = kernels_for(means), (view.height, view.width)
        inputs = [None if t is None else t.detach().contiguous() for t in inputs]
        image, alpha = means.new_empty(*shape, 3), means.new_empty(shape)
        depths = means.new_empty(shape) if depth else None
        planes = (4 if lobes is None else 5) + depth + view.two_pass + (view.levels > 1)
        sums = means.new_empty(planes, view.pixels)
        with kernels.current():
            splats, radii, touched, center_tiles = _project(kernels, view, inputs)
            lists = _Lists(kernels, view, splats, touched, by_depth=lobes is None)
            name = "mgs_sorted_forward" if lobes is None else _sortfree(view, "forward")
            common = [view, _pointer(splats), lists.pointers()]
            arguments = [*common, _pointers(sums, image, alpha, depths)]
            if view.two_pass:
                limits = _pointer(sums[-1])
                kernels.launch("mgs_surfaces", _tiles(view), THREADS, *common, limits)
                arguments.append(limits)
            kernels.launch(_suffixed(name, depth), _tiles(view), THREADS, *arguments)
            for level in reversed(range(view.levels - 1)):
                height, width = view.sizes[level]
                arguments = [view, ctypes.c_int(level), _pointers(sums, image, alpha, depths)]
                name = _suffixed("mgs_add_enlarged", depth)
                kernels.launch(name, _blocks(height * width), THREADS, *arguments)
        ctx.lists, ctx.center_tiles = (lists, None) if lobes is None else (None, center_tiles)
        ctx.view, ctx.depth, ctx.screen_grads = view, depth, screen_grads
        ctx.save_for_backward(*inputs, splats, sums)
        ctx.mark_non_differentiable(radii)
        ctx.set_materialize_grads(False)
        return image, alpha, depths, radii

    @staticmethod
    def backward(ctx, *grads):
        *inputs, splats, sums = ctx.saved_tensors
        view, means = ctx.view, inputs[0]
        kernels, count, shape = kernels_for(means), len(means), (view.height, view.width)
        g_image = means.new_zeros(*shape, 3) if grads[0] is None else grads[0].contiguous()
        g_alpha = means.new_zeros(shape) if grads[1] is None else grads[1].contiguous()
        g_depth = None
        if ctx.depth:
            g_depth = means.new_zeros(shape) if grads[2] is None else grads[2].contiguous()
        out = [None if t is None else torch.empty_like(t) for t in inputs]
        if count:
            out_grads = _pointers(g_image, g_alpha, g_depth)
            with kernels.current():
                gather = _gather_sortfree if ctx.lists is None else _gather_sorted
                totals = gather(kernels, ctx, splats, sums, out_grads)
                arguments = [view, ctypes.c_int(count), _pointers(*inputs), _pointer(splats)]
                arguments += [_pointer(totals), _pointers(*out, ctx.screen_grads)]
                sortfree = ctypes.c_int(ctx.lists is None)
                kernels.launch("mgs_write_gradients", _blocks(count), THREADS, *arguments, sortfree)
        return None, None, None, *out


def _gather_sortfree(
    kernels: Kernels, ctx, splats: Tensor, sums: Tensor, out_grads: ctypes.Array
) -> Tensor:
    """Return each Gaussian's sums over its pixels; those of invisible ones are undefined."""
    view, count = ctx.view, len(splats)
    colors, others = sums.new_empty(view.pixels, 4), sums.new_empty(view.pixels, 2)
    totals = sums.new_empty(count, SUMS)
    arguments = [view, _pointer(sums), out_grads, _pointer(colors), _pointer(others)]
    name = _suffixed("mgs_sortfree_pixels", ctx.depth)
    kernels.launch(name, _blocks(view.height * view.width), THREADS, *arguments)
    for level, (height, width) in enumerate(view.sizes[1:]):
        arguments = [view, ctypes.c_int(level), _pointer(sums[-1])]
        arguments += [_pointer(colors), _pointer(others)]
        kernels.launch("mgs_reduce_gradients", _blocks(height * width), THREADS, *arguments)
    if view.levels > 1:
        arguments = [view, _pointer(sums), _pointer(others)]
        kernels.launch("mgs_finish_gradients", _blocks(view.pixels), THREADS, *arguments)
    # neighbours in the image then read the same pixels from the cache
    order = torch.sort(ctx.center_tiles, stable=True).indices
    pixel_grads = _pointers(colors, others, sums[-1] if view.two_pass else None)
    arguments = [view, ctypes.c_int(count), _pointer(splats), _pointer(order), pixel_grads]
    arguments.append(_pointer(totals))
    name = _suffixed(_sortfree(view, "gather"), ctx.depth)
    kernels.launch(name, _blocks(count, PER_WARP), THREADS, *arguments)
    return totals


def _gather_sorted(
    kernels: Kernels, ctx, splats: Tensor, sums: Tensor, out_grads: ctypes.Array
) -> Tensor:
    """Return each Gaussian's sums over its tile entries, after a walk tile by tile."""
    view, lists, count = ctx.view, ctx.lists, len(splats)
    slot_sums = sums.new_empty(lists.count, SUMS)
    reached = sums.new_zeros(lists.count, dtype=torch.uint8)
    totals = sums.new_empty(count, SUMS)
    arguments = [view, _pointer(splats), lists.pointers(), _pointer(sums), out_grads]
    arguments += [_pointer(slot_sums), _pointer(reached)]
    name = _suffixed("mgs_sorted_backward", ctx.depth)
    kernels.launch(name, _tiles(view), WALK_THREADS, *arguments)
    arguments = [_pointer(t) for t in (lists.order, lists.ends, slot_sums, reached, totals)]
    blocks = _blocks(count, PER_WARP)
    kernels.launch("mgs_sorted_gather", blocks, THREADS, ctypes.c_int(count), *arguments)
    return totals


def project_radii(
    view: KernelView, means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, sh: Tensor
) -> Tensor:
    """Return radii in pixels, 0 for Gaussians that the image cannot show, `[n]`."""
    inputs = [t.detach().contiguous() for t in (means, quats, scales, opacities, sh)]
    validate_inputs(view, [*inputs, None], None)
    kernels = kernels_for(means)
    with kernels.current():
        return _project(kernels, view, [*inputs, None])[1]


def measure_contributions(
    view: KernelView, means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, sh: Tensor
) -> Contributions:
    """Return how much each Gaussian contributes to a sorted image; `sh` does not matter."""
    inputs = [t.detach().contiguous() for t in (means, quats, scales, opacities, sh)]
    validate_inputs(view, [*inputs, None], None)
    kernels, count, shape = kernels_for(means), len(means), (view.height, view.width)
    weights, touched = means.new_empty(count), means.new_empty(count, dtype=torch.int32)
    winner, alpha = means.new_empty(shape, dtype=torch.int32), means.new_empty(shape)
    with kernels.current():
        splats, _, tiles, _ = _project(kernels, view, [*inputs, None])
        lists = _Lists(kernels, view, splats, tiles, by_depth=True)
        slots = means.new_zeros(lists.count, 2)
        arguments = [view, _pointer(splats), lists.pointers()]
        arguments += [_pointer(t) for t in (slots, winner, alpha)]
        kernels.launch("mgs_contributions", _tiles(view), THREADS, *arguments)
        arguments = [_pointer(t) for t in (lists.order, lists.ends, slots, weights, touched)]
        blocks = _blocks(count, PER_WARP)
        name = "mgs_contributions_gather"
        kernels.launch(name, blocks, THREADS, ctypes.c_int(count), *arguments)
    return Contributions(weights, touched, count_wins(winner, count), winner, alpha)
