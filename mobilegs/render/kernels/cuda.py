"""The CUDA kernels: csrc/cuda.cu, compiled by NVRTC at first use.

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
from typing import NamedTuple

import torch
from torch import Tensor

from mobilegs.atomic import atomic_write
from mobilegs.errors import InputError
from mobilegs.render.contributions import Contributions, count_wins
from mobilegs.render.depth_pass import PASS_LEVEL
from mobilegs.render.kernels.kernel_view import SPLAT_BYTES, KernelView, validate_inputs
from mobilegs.render.kernels.list_lengths import (
    ROOM_MAX,
    DelayedLength,
    Length,
    ListLengths,
    room_for,
)
from mobilegs.render.levels import level_sizes

SOURCES = (
    "cuda.cu",
    "cuda_common.h",
    "cuda_contributions.h",
    "cuda_lists.h",
    "cuda_loss.h",
    "cuda_sorted.h",
    "cuda_sortfree.h",
    "cuda_student.h",
    "cuda_terms.h",
    "depth_pass.h",
    "student.h",
    "group.h",
    "pairs.h",
    "photo_loss.h",
    "terms.h",
    "core.h",
    "lanes.h",
)
TILE = 16
THREADS = 256  # of every kernel but the sorted backward walk
CSRC = Path(__file__).parents[2] / "csrc"
WALK_THREADS = 128
PER_WARP = 8  # Gaussians a block takes where each gets a warp
COARSE = 4  # side of the pixels of the coarsest target that a block takes in the backward pass
GATHERED = 128  # entries whose Gaussians a block of the sort-free backward pass takes
SUMS = 12  # floats of a Gaussian's or an entry's sums
SORT_PART = 2048  # items that a block sorts at a time
SORT_BLOCKS, FILL_BLOCKS = 256, 1024  # at most


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
        self.lengths = ListLengths()

    def read_later(self, length: Tensor) -> Length:
        """Return the length of a list, which is read once the GPU has counted it."""
        return DelayedLength(length)

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


def takes(*tensors: Tensor) -> bool:
    """Return whether the kernels take tensors: all are float32 on a GPU."""
    return all(t.is_cuda and t.dtype == torch.float32 for t in tensors)


def kernels_for(tensor: Tensor) -> Kernels:
    """Return the kernels of the tensor's GPU."""
    return _kernels(tensor.device.index)


def _address(tensor: Tensor | None) -> int | None:
    return None if tensor is None else tensor.data_ptr()


def _pointers(*tensors: Tensor | None) -> ctypes.Array:
    """Make a struct of pointers."""
    return (ctypes.c_void_p * len(tensors))(*map(_address, tensors))


def _pointer(tensor: Tensor | None) -> ctypes.c_void_p:
    return ctypes.c_void_p(_address(tensor))


def _blocks(count: int, per_block: int = THREADS) -> int:
    return (count + per_block - 1) // per_block


def _tiles_of(height: int, width: int, side: int) -> int:
    return _blocks(height, side) * _blocks(width, side)


def _tiles(view: KernelView) -> int:
    """Return the number of tiles of all levels."""
    return sum(_tiles_of(height, width, TILE) for height, width in view.sizes)


class _Projected(NamedTuple):
    """The numbers of each Gaussian after projection, and in `groups` of each group of THREADS."""

    splats: Tensor
    radii: Tensor
    touched: Tensor  # number of tiles
    groups: Tensor  # sums of these
    depths: Tensor | None  # of sorted blending: integers in the order of the depths


def _project(kernels: Kernels, view: KernelView, inputs: list[Tensor | None]) -> _Projected:
    means = inputs[0]
    assert means is not None
    count = len(means)
    found = _Projected(
        means.new_empty(count, SPLAT_BYTES, dtype=torch.uint8),
        means.new_empty(count),
        means.new_empty(count, dtype=torch.int32),
        means.new_empty(_blocks(count), dtype=torch.int32),
        None if view.lobe_size else means.new_empty(count, dtype=torch.int32),
    )
    arguments = [view, ctypes.c_int(count), _pointers(*inputs), *map(_pointer, found)]
    kernels.launch("mgs_project", _blocks(count), THREADS, *arguments)
    return found


class _SortPass(ctypes.Structure):
    """One pass of a sort; mirrors `SortPass` in csrc/cuda_lists.h field by field."""

    _fields_ = [
        ("keys", ctypes.c_void_p),
        ("values", ctypes.c_void_p),
        ("sorted_keys", ctypes.c_void_p),
        ("sorted_values", ctypes.c_void_p),
        ("counts", ctypes.c_void_p),
        ("length", ctypes.c_void_p),
        ("room", ctypes.c_int),
        ("shift", ctypes.c_int),
        ("bits", ctypes.c_int),
    ]


def _sort(
    kernels: Kernels, keys: Tensor, values: Tensor | None, bits: int, length: Tensor | None = None
) -> tuple[Tensor, Tensor]:
    """Return keys of `bits` bits in rising order, and their values, by a stable sort.

    Without `values`, these are the items' numbers. A `length` on the device is the number of items,
    if it is not larger than that of the keys; else nothing is sorted.
    """
    blocks, passes = min(_blocks(len(keys), SORT_PART), SORT_BLOCKS), _blocks(bits, 8)
    size = _blocks(bits, passes)
    counts = keys.new_empty(blocks << size)
    for shift in range(0, bits, size):
        after = (torch.empty_like(keys), torch.empty_like(keys))
        tensors = (keys, values, *after, counts, length)
        one = _SortPass(*map(_address, tensors), len(keys), shift, size)
        kernels.launch("mgs_count_digits", blocks, THREADS, one)
        kernels.launch("mgs_scatter", blocks, THREADS, one)
        keys, values = after
    assert values is not None
    return keys, values


class _ListPointers(ctypes.Structure):
    """Tile lists; mirrors `Lists` in csrc/cuda_common.h field by field."""

    _fields_ = [
        ("starts", ctypes.c_void_p),
        ("ids", ctypes.c_void_p),
        ("slots", ctypes.c_void_p),
        ("order", ctypes.c_void_p),
        ("length", ctypes.c_void_p),
        ("room", ctypes.c_int),
        ("count", ctypes.c_int),
    ]


class _Lists:
    """Tile lists: the Gaussians that each tile visits, by index or (with depths) front first.

    Sorting the Gaussians by depth and then their entries by tile, both stably, moves half the
    bytes of one sort of entries by a 64-bit key. Lists may be longer than their `room`:
    list_lengths.py says what happens then. Lists of a `known` length have room.
    """

    def __init__(
        self, kernels: Kernels, view: KernelView, projected: _Projected, known: int | None = None
    ) -> None:
        self.kernels, self.view, self.projected = kernels, view, projected
        count, tiles = len(projected.touched), _tiles(view)
        alike = (tiles, count.bit_length())
        room = kernels.lengths.room(alike) if known is None else known
        if room is None:
            known = int(projected.groups.sum())
            kernels.lengths.learn(alike, known)
            room = room_for(known)
        self.room, self.known, self.coming = room, known, None
        self.order = self.ends = self.slots = None
        self.length = projected.touched.new_empty(1, dtype=torch.int64)
        keys, ids = self._fill()
        if known is None:
            self.coming = kernels.read_later(self.length)
            kernels.lengths.coming.append((alike, self.coming))
        values = ids if self.order is None else None
        keys, values = _sort(kernels, keys, values, tiles.bit_length(), self.length)
        self.starts = keys.new_empty(tiles + 1)
        blocks = _blocks(tiles + 1)
        if self.order is None:
            self.ids = values
        else:
            self.ids, self.slots = torch.empty_like(ids), values
            blocks = max(blocks, min(_blocks(room), FILL_BLOCKS))
        arguments = [ctypes.c_int(tiles), ctypes.c_int(room)]
        tensors = (keys, self.length, self.slots, ids, self.starts, self.ids)
        kernels.launch("mgs_find_starts", blocks, THREADS, *arguments, *map(_pointer, tensors))
        tensors = (self.starts, self.ids, self.slots, self.order, self.length)
        self.pointers = _ListPointers(*map(_address, tensors), room, count)

    def _fill(self) -> tuple[Tensor, Tensor]:
        """Return tiles and ids of all entries, Gaussian by Gaussian, and sort these by depth."""
        splats, _, touched, groups, depths = self.projected
        count = ctypes.c_int(len(touched))
        if depths is not None:
            self.order = _sort(self.kernels, depths, None, 32)[1]
            self.ends = touched.new_empty(len(touched), dtype=torch.int64)
            groups = torch.empty_like(groups)
            arguments = [count, *map(_pointer, (self.order, touched, groups))]
            self.kernels.launch("mgs_total", _blocks(len(touched)), THREADS, *arguments)
        tiles, ids = touched.new_empty(self.room), touched.new_empty(self.room)
        tensors = (splats, self.order, touched, groups, self.length, self.ends, tiles, ids)
        arguments = [self.view, count, ctypes.c_int(self.room), *map(_pointer, tensors)]
        blocks = max(
            1, min(_blocks(len(touched)), FILL_BLOCKS)
        )  # also without Gaussians: the length
        self.kernels.launch("mgs_fill", blocks, THREADS, *arguments)
        return tiles, ids

    def complete(self) -> tuple["_Lists", int]:
        """Return lists that have room, and their length, once it is counted."""
        length = self.known if self.coming is None else self.coming.value()
        assert length is not None
        if length <= self.room:
            return self, length
        if length > ROOM_MAX:
            raise InputError(
                f"the Gaussians touch {length:,} tiles, more than can be listed: render fewer, "
                "or a smaller image"
            )
        return _Lists(self.kernels, self.view, self.projected, length), length


def _suffixed(name: str, depth: bool) -> str:
    return f"{name}_depth" if depth else name


def _sortfree(view: KernelView, suffix: str) -> str:
    return f"mgs_depth_pass_{suffix}" if view.depth_pass else f"mgs_sortfree_{suffix}"


def _depth_moments(kernels: Kernels, view: KernelView, splats: Tensor) -> Tensor:
    """Return the picture of the depth pass (`render/depth_pass.py`), `[3, h, w]`."""
    height, width = level_sizes(view.height, view.width)[PASS_LEVEL]
    small = KernelView.from_buffer_copy(view)
    small.height, small.width, small.level_sigma = height, width, 0.0
    count = len(splats)
    touched = splats.new_empty(count, dtype=torch.int32)
    groups = splats.new_empty(_blocks(count), dtype=torch.int32)
    coarse = torch.empty_like(splats)
    arguments = [small, ctypes.c_int(count), *map(_pointer, (splats, coarse, touched, groups))]
    kernels.launch("mgs_depth_splats", _blocks(count), THREADS, *arguments)
    lists = _Lists(kernels, small, _Projected(coarse, touched, touched, groups, None))
    moments = splats.new_empty(3, height, width, dtype=torch.float32)
    arguments = [small, _pointer(coarse), lists.pointers, _pointer(moments)]
    kernels.launch("mgs_depth_moments", _tiles(small), THREADS, *arguments)
    return moments


class CudaRaster(torch.autograd.Function):
    """Both renderers on a GPU: sorted with `opacities`, sort-free with `lobes`; one is None."""

    @staticmethod
    def forward(ctx, view, screen_grads, more, depth, means, quats, scales, opacities, sh, lobes):
        inputs = [means, quats, scales, opacities, sh, lobes]
        validate_inputs(view, inputs, screen_grads, more)
        kernels, shape = kernels_for(means), (view.height, view.width)
        inputs = [None if t is None else t.detach().contiguous() for t in inputs]
        image, alpha = means.new_empty(*shape, 3), means.new_empty(shape)
        depths = means.new_empty(shape) if depth else None
        planes = (4 if lobes is None else 5) + depth + 3 * view.depth_pass + (view.levels > 1)
        sums = means.new_empty(planes, view.pixels)
        with kernels.current():
            read = [*inputs, more and more.values]
            projected = _project(kernels, view, read)
            splats, lists = projected.splats, _Lists(kernels, view, projected)
            name = "mgs_sorted_forward" if lobes is None else _sortfree(view, "forward")
            common = [view, _pointer(splats), lists.pointers]
            arguments = [*common, _pointers(sums, image, alpha, depths)]
            if view.depth_pass:
                moments = _depth_moments(kernels, view, splats)
                arguments.append(_pointer(moments))
            kernels.launch(_suffixed(name, depth), _tiles(view), THREADS, *arguments)
            if view.levels > 1:
                arguments = [view, _pointers(sums, image, alpha, depths)]
                blocks = _tiles_of(view.height, view.width, TILE)
                kernels.launch(_suffixed("mgs_add_levels", depth), blocks, THREADS, *arguments)
        ctx.lists, ctx.view, ctx.depth = lists, view, depth
        ctx.screen_grads, ctx.more = screen_grads, more
        ctx.save_for_backward(*inputs, splats, sums)
        ctx.mark_non_differentiable(projected.radii)
        ctx.set_materialize_grads(False)
        return image, alpha, depths, projected.radii

    @staticmethod
    def backward(ctx, *grads):
        *inputs, splats, sums = ctx.saved_tensors
        view, means = ctx.view, inputs[0]
        kernels, count = kernels_for(means), len(means)
        given = [None if grad is None else grad.contiguous() for grad in grads[:3]]
        out = [None if t is None else torch.empty_like(t) for t in inputs]
        if count:
            out_grads = _pointers(*given)
            with kernels.current():
                gather = _gather_sortfree if view.lobe_size else _gather_sorted
                totals = gather(kernels, ctx, splats, sums, out_grads)
                more, more_grads = ctx.more or (None, None)
                arguments = [view, ctypes.c_int(count), _pointers(*inputs, more), _pointer(splats)]
                arguments += [_pointer(totals), _pointers(*out, more_grads, ctx.screen_grads)]
                sortfree = ctypes.c_int(view.lobe_size > 0)
                kernels.launch("mgs_write_gradients", _blocks(count), THREADS, *arguments, sortfree)
        return None, None, None, None, *out


def _gather_sortfree(
    kernels: Kernels, ctx, splats: Tensor, sums: Tensor, out_grads: ctypes.Array
) -> Tensor:
    """Return each Gaussian's sums over its pixels; those of invisible ones are undefined."""
    view, lists = ctx.view, ctx.lists
    colors, others = sums.new_empty(view.pixels, 4), sums.new_empty(view.pixels, 2)
    carried = sums.new_empty(view.height * view.width) if view.levels > 1 else None
    totals = sums.new_empty(len(splats), SUMS)
    pixel_grads = _pointers(colors, others, carried, sums[-3] if view.depth_pass else None)
    arguments = [view, _pointer(sums), out_grads, pixel_grads]
    name = _suffixed("mgs_sortfree_pixels", ctx.depth)
    kernels.launch(name, _blocks(view.height * view.width), THREADS, *arguments)
    if view.levels > 1:
        height, width = view.sizes[-1]
        name, blocks = _suffixed("mgs_reduce_levels", ctx.depth), _tiles_of(height, width, COARSE)
        kernels.launch(name, blocks, THREADS, view, _pointer(sums), pixel_grads)
    arguments = [view, _pointer(splats), lists.pointers, pixel_grads, _pointer(totals)]
    name = _suffixed(_sortfree(view, "gather"), ctx.depth)
    kernels.launch(name, _blocks(lists.room, GATHERED), THREADS, *arguments)
    return totals


def _gather_sorted(
    kernels: Kernels, ctx, splats: Tensor, sums: Tensor, out_grads: ctypes.Array
) -> Tensor:
    """Return each Gaussian's sums over its tile entries, after a walk tile by tile."""
    view, count = ctx.view, len(splats)
    lists, length = ctx.lists.complete()
    slot_sums = sums.new_empty(length, SUMS)
    reached = sums.new_zeros(length, dtype=torch.uint8)
    totals = sums.new_empty(count, SUMS)
    arguments = [view, _pointer(splats), lists.pointers, _pointer(sums), out_grads]
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
        return _project(kernels, view, [*inputs, None, None]).radii


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
        projected = _project(kernels, view, [*inputs, None, None])
        lists, length = _Lists(kernels, view, projected).complete()
        slots = means.new_zeros(length, 2)
        arguments = [view, _pointer(projected.splats), lists.pointers]
        arguments += [_pointer(t) for t in (slots, winner, alpha)]
        kernels.launch("mgs_contributions", _tiles(view), THREADS, *arguments)
        arguments = [_pointer(t) for t in (lists.order, lists.ends, slots, weights, touched)]
        blocks = _blocks(count, PER_WARP)
        name = "mgs_contributions_gather"
        kernels.launch(name, blocks, THREADS, ctypes.c_int(count), *arguments)
    return Contributions(weights, touched, count_wins(winner, count), winner, alpha)
