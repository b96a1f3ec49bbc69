"""The CUDA kernels: cuda.cu, compiled by NVRTC at first use, between torch's sorts and scans.

Needs no toolkit and no compiler of the user's: cuda-core and NVRTC come as Python packages. The
result is kept in a cache folder. What has been checked: every kernel compiles, and computes the
right thing when executed thread by thread on a CPU. None of it has run on a GPU yet.
"""

# pyright takes `cuda` for this very file
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
from mobilegs.render.contributions import Contributions, pixels_won
from mobilegs.render.kernels.kernel_view import SPLAT_BYTES, KernelView, refuse_strays

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
WALKERS = 128
PER_WARP = 8  # Gaussians a block takes where each gets a warp
SUMS = 12  # floats of a Gaussian's or an entry's sums


def _missing(error: Exception) -> InputError:
    return InputError(
        f"drawing on a GPU needs the compiler of its kernels ({error}): "
        "run `pip install 'mobilegs[cuda]'`"
    )


def compile_kernels(arch: str, source: str | None = None) -> tuple[bytes, str]:
    """Machine code for `arch` (such as `sm_90`), and what the compiler says of registers, stack
    and spills, of `source` (cuda.cu if not given). Needs no GPU and no driver.

    Raises InputError where the compiler is not installed or does not know `arch`.
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
    """Where compiled kernels are kept: `MOBILEGS_CACHE`, or the user's cache folder."""
    named = os.environ.get("MOBILEGS_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mobilegs"


def cubin(arch: str) -> bytes:
    """Machine code of cuda.cu for `arch`, from the cache if sources and compiler are the same."""
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
        pass  # a read-only home costs two seconds a process, no more
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
        """Makes the GPU current: autograd's threads may not have a context of it yet."""
        from cuda.core import Device

        with torch.cuda.device(self.device):
            Device(self.device.index).set_current()
            yield

    def launch(self, name: str, blocks: int, threads: int, *arguments) -> None:
        """Starts a kernel; the arguments are ctypes values, structs included, passed by value."""
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
    """The driver's form of a kernel's arguments: an array of pointers to them."""
    return (ctypes.c_void_p * len(arguments))(*[ctypes.addressof(a) for a in arguments])


@cache
def _kernels(index: int) -> Kernels:
    return Kernels(torch.device("cuda", index))


def kernels_for(tensor: Tensor) -> Kernels:
    """The kernels of the tensor's GPU."""
    return _kernels(tensor.device.index)


def _pointers(*tensors: Tensor | None) -> ctypes.Array:
    """A struct of pointers."""
    values = [None if t is None else t.data_ptr() for t in tensors]
    return (ctypes.c_void_p * len(values))(*values)


def _pointer(tensor: Tensor | None) -> ctypes.c_void_p:
    return ctypes.c_void_p(None if tensor is None else tensor.data_ptr())


def _blocks(count: int, per_block: int = THREADS) -> int:
    return (count + per_block - 1) // per_block


def _tiles(view: KernelView) -> int:
    return _blocks(view.width, TILE) * _blocks(view.height, TILE)


def _project(kernels: Kernels, view: KernelView, held: list[Tensor | None]) -> tuple[Tensor, ...]:
    """(splats, radii, tiles touched, tile of the centre) of every Gaussian."""
    means = held[0]
    assert means is not None
    count = len(means)
    splats = means.new_empty(count, SPLAT_BYTES, dtype=torch.uint8)
    radii = means.new_empty(count)
    touched = means.new_empty(count, dtype=torch.int32)
    homes = means.new_empty(count, dtype=torch.int32)
    outputs = [_pointer(t) for t in (splats, radii, touched, homes)]
    kernels.launch(
        "mgs_project",
        _blocks(count),
        THREADS,
        view,
        ctypes.c_int(count),
        _pointers(*held),
        *outputs,
    )
    return splats, radii, touched, homes


class _Lists:
    """Tile lists: the Gaussians that each tile must visit, by index or (`by_depth`) front first.

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


def _sortfree(view: KernelView, what: str) -> str:
    return f"mgs_two_pass_{what}" if view.two_pass else f"mgs_sortfree_{what}"


class CudaRaster(torch.autograd.Function):
    """Both renderers on a GPU: opacities or `lobes`, the other is None."""

    @staticmethod
    def forward(ctx, view, screen_grads, depth, means, quats, scales, opacities, sh, lobes):
        held = [means, quats, scales, opacities, sh, lobes]
        refuse_strays(view, held, screen_grads)
        kernels, shape = kernels_for(means), (view.height, view.width)
        held = [None if t is None else t.detach().contiguous() for t in held]
        image, alpha = means.new_empty(*shape, 3), means.new_empty(shape)
        depths = means.new_empty(shape) if depth else None
        sums = means.new_empty((4 if lobes is None else 5) + depth + view.two_pass, *shape)
        with kernels.current():
            splats, radii, touched, homes = _project(kernels, view, held)
            lists = _Lists(kernels, view, splats, touched, by_depth=lobes is None)
            name = "mgs_sorted_forward" if lobes is None else _sortfree(view, "forward")
            given = [view, _pointer(splats), lists.pointers()]
            arguments = [*given, _pointers(sums, image, alpha, depths)]
            if view.two_pass:
                limits = _pointer(sums[-1])
                kernels.launch("mgs_surfaces", _tiles(view), THREADS, *given, limits)
                arguments.append(limits)
            kernels.launch(_suffixed(name, depth), _tiles(view), THREADS, *arguments)
        ctx.lists, ctx.homes = (lists, None) if lobes is None else (None, homes)
        ctx.view, ctx.depth, ctx.screen_grads = view, depth, screen_grads
        ctx.save_for_backward(*held, splats, sums)
        ctx.mark_non_differentiable(radii)
        ctx.set_materialize_grads(False)
        return image, alpha, depths, radii

    @staticmethod
    def backward(ctx, *grads):
        *held, splats, sums = ctx.saved_tensors
        view, means = ctx.view, held[0]
        kernels, count, shape = kernels_for(means), len(means), (view.height, view.width)
        g_image = means.new_zeros(*shape, 3) if grads[0] is None else grads[0].contiguous()
        g_alpha = means.new_zeros(shape) if grads[1] is None else grads[1].contiguous()
        g_depth = None
        if ctx.depth:
            g_depth = means.new_zeros(shape) if grads[2] is None else grads[2].contiguous()
        out = [None if t is None else torch.empty_like(t) for t in held]
        if count:
            given = _pointers(g_image, g_alpha, g_depth)
            with kernels.current():
                gather = _gather_sortfree if ctx.lists is None else _gather_sorted
                totals = gather(kernels, ctx, splats, sums, given)
                arguments = [view, ctypes.c_int(count), _pointers(*held), _pointer(splats)]
                arguments += [_pointer(totals), _pointers(*out, ctx.screen_grads)]
                sortfree = ctypes.c_int(ctx.lists is None)
                kernels.launch("mgs_finish", _blocks(count), THREADS, *arguments, sortfree)
        return None, None, None, *out


def _gather_sortfree(
    kernels: Kernels, ctx, splats: Tensor, sums: Tensor, given: ctypes.Array
) -> Tensor:
    """Each Gaussian's sums over its own pixels; those of unseen ones are left undefined."""
    view, count = ctx.view, len(splats)
    pixels = view.height * view.width
    colors, others = sums.new_empty(pixels, 4), sums.new_empty(pixels, 2)
    totals = sums.new_empty(count, SUMS)
    arguments = [view, _pointer(sums), given, _pointer(colors), _pointer(others)]
    name = _suffixed("mgs_sortfree_pixels", ctx.depth)
    kernels.launch(name, _blocks(pixels), THREADS, *arguments)
    # neighbours in the picture then read the same pixels from the cache
    order = torch.sort(ctx.homes, stable=True).indices
    asked = _pointers(colors, others, sums[-1] if view.two_pass else None)
    arguments = [view, ctypes.c_int(count), _pointer(splats), _pointer(order), asked]
    arguments.append(_pointer(totals))
    name = _suffixed(_sortfree(view, "gather"), ctx.depth)
    kernels.launch(name, _blocks(count, PER_WARP), THREADS, *arguments)
    return totals


def _gather_sorted(
    kernels: Kernels, ctx, splats: Tensor, sums: Tensor, given: ctypes.Array
) -> Tensor:
    """Each Gaussian's sums over its entries, which are first walked tile by tile."""
    view, lists, count = ctx.view, ctx.lists, len(splats)
    slot_sums = sums.new_empty(lists.count, SUMS)
    reached = sums.new_zeros(lists.count, dtype=torch.uint8)
    totals = sums.new_empty(count, SUMS)
    arguments = [view, _pointer(splats), lists.pointers(), _pointer(sums), given]
    arguments += [_pointer(slot_sums), _pointer(reached)]
    name = _suffixed("mgs_sorted_backward", ctx.depth)
    kernels.launch(name, _tiles(view), WALKERS, *arguments)
    arguments = [_pointer(t) for t in (lists.order, lists.ends, slot_sums, reached, totals)]
    blocks = _blocks(count, PER_WARP)
    kernels.launch("mgs_sorted_gather", blocks, THREADS, ctypes.c_int(count), *arguments)
    return totals


def project_radii(
    view: KernelView, means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, sh: Tensor
) -> Tensor:
    """Radii in pixels, 0 for what the picture cannot show."""
    held = [t.detach().contiguous() for t in (means, quats, scales, opacities, sh)]
    refuse_strays(view, [*held, None], None)
    kernels = kernels_for(means)
    with kernels.current():
        return _project(kernels, view, [*held, None])[1]


def measure_contributions(
    view: KernelView, means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, sh: Tensor
) -> Contributions:
    """What each Gaussian gives to a sorted picture; the colours do not matter."""
    held = [t.detach().contiguous() for t in (means, quats, scales, opacities, sh)]
    refuse_strays(view, [*held, None], None)
    kernels, count, shape = kernels_for(means), len(means), (view.height, view.width)
    weights, touched = means.new_empty(count), means.new_empty(count, dtype=torch.int32)
    winner, alpha = means.new_empty(shape, dtype=torch.int32), means.new_empty(shape)
    with kernels.current():
        splats, _, tiles, _ = _project(kernels, view, [*held, None])
        lists = _Lists(kernels, view, splats, tiles, by_depth=True)
        slots = means.new_zeros(lists.count, 2)
        arguments = [view, _pointer(splats), lists.pointers()]
        arguments += [_pointer(t) for t in (slots, winner, alpha)]
        kernels.launch("mgs_contributions", _tiles(view), THREADS, *arguments)
        arguments = [_pointer(t) for t in (lists.order, lists.ends, slots, weights, touched)]
        blocks = _blocks(count, PER_WARP)
        name = "mgs_contributions_gather"
        kernels.launch(name, blocks, THREADS, ctypes.c_int(count), *arguments)
    return Contributions(weights, touched, pixels_won(winner, count), winner, alpha)
