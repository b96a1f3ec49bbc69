"""The C++ library: finds the build for this CPU, loads it with ctypes, and wraps its decoders.

The functions that decode a `.mgs` (decode.cpp, networks.cpp) have a reference in `rans`, `bits`,
`positions`, `codebooks`, `rotations`, `appearance` and `lobes`, which runs if the package was
installed without the library. The renderers' functions are called by `render/kernels/cpu.py`, the
loss by `train/losses.py`.
"""

import ctypes
import sys
import sysconfig
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float, Int, Int32, Integer, UInt8, UInt16, UInt32
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians

CPU = torch.device("cpu")
INTERFACE = 10  # MGS_INTERFACE of decode.h

# newest first: (name, flags of /proc/cpuinfo that it needs); as CMakeLists.txt builds them
BUILDS = {
    "v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "v3": {"avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"},
    "v2": {"sse4_2", "ssse3", "popcnt"},
    "portable": set(),
}

# messages of the error codes of decode.h, as the references have them
MESSAGES = {
    2: "a rANS stream's frequency tables end early",
    3: "a rANS stream's frequency table holds a number out of range",
    4: "a rANS stream's frequencies do not sum to 16384",
    5: "a rANS stream's frequency tables are longer than they should be",
    6: "a rANS stream starts in an impossible state",
    7: "a rANS stream ends early: the file is damaged",
    8: "a rANS stream leads to an impossible state",
    9: "a rANS stream does not end where it should: the file is damaged",
    10: "packed bits take more or fewer bytes than they should",
    11: "packed bits end in bits that are not zero",
    12: "the stream of positions leaves its 48-bit grid",
    13: "the stream of positions holds numbers that are not finite",
}
NO_MEMORY = 14
ALPHABET_MAX, WIDTH_MAX = 4096, 16  # of decode.h


class LibraryMissingError(ImportError):
    """The package was installed without its C++ library."""


def cpu_flags() -> set[str]:
    """Return the CPU's instruction sets by their Linux names; empty where the system hides them."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return set()
    for line in text.splitlines():
        if line.startswith("flags"):
            return set(line.split(":", 1)[1].split())
    return set()


def built_library(build: str) -> Path | None:
    """Return the path of a build; an editable install keeps it in site-packages."""
    installed = Path(sysconfig.get_path("platlib"), "mobilegs", "csrc")
    for folder in (Path(__file__).parent, installed):
        if (folder / f"libmobilegs_{build}.so").exists():
            return folder / f"libmobilegs_{build}.so"
    return None


def kernel_build() -> str:
    """Return the newest build that this CPU runs; raises ImportError if there is none."""
    flags = cpu_flags()
    for build, needed in BUILDS.items():
        if needed <= flags and built_library(build):
            return build
    raise LibraryMissingError(
        "mobilegs was installed without its CPU kernels: reinstall it where a C++ compiler is "
        "at hand (pip install --force-reinstall mobilegs)"
    )


@cache
def library(build: str | None = None) -> ctypes.CDLL:
    """Load a build of the library, by default the newest that this CPU runs.

    Raises:
        LibraryMissingError: it was not built.
        ImportError: it belongs to another version of the package.
    """
    build = build or kernel_build()
    path = built_library(build)
    if path is None:
        raise LibraryMissingError(f"the build {build} of the kernels is not installed")
    loaded = ctypes.CDLL(str(path))
    if not hasattr(loaded, "mgs_interface") or loaded.mgs_interface() != INTERFACE:
        raise ImportError(
            f"the C++ library {path} belongs to another version of mobilegs: reinstall mobilegs"
        )
    loaded.mgs_sorted_forward.restype = ctypes.c_void_p
    if (threads := openmp_threads()) is not None:
        loaded.mgs_follow_threads(threads)
    return loaded


def openmp_threads() -> Any:
    """Return the function of torch's OpenMP runtime that gives its number of threads, or None.

    The kernels have threads of their own, as many as torch: they follow `torch.set_num_threads`.
    """
    try:
        if sys.platform == "win32":
            runtime = ctypes.CDLL(str(Path(torch.__file__).parent / "lib" / "libiomp5md.dll"))
        else:  # the system searches the libraries that this one needs, too
            runtime = ctypes.CDLL(torch._C.__file__)
        return runtime.omp_get_max_threads
    except (OSError, AttributeError):
        return None  # one thread


@cache
def decoders() -> ctypes.CDLL | None:
    """Load the library for the functions below; None if it was not built."""
    try:
        return library()
    except LibraryMissingError:
        return None


def supports(*tensors: Tensor) -> bool:
    """Return True if `decode_colors` and `decode_lobes` take these: float32 tensors on the CPU."""
    plain = all(t.device.type == "cpu" and t.dtype == torch.float32 for t in tensors)
    return plain and decoders() is not None


def validate(
    tensor: Tensor | np.ndarray,
    *shape: int,
    dtype: torch.dtype | type = torch.float32,
    device: torch.device = CPU,
) -> None:
    """Raise InputError unless a kernel can read or write these numbers: shape, type, and device."""
    place = CPU if isinstance(tensor, np.ndarray) else tensor.device
    if (place, tuple(tensor.shape), tensor.dtype) != (device, shape, dtype):
        raise InputError(
            f"numbers of shape {list(tensor.shape)}, {tensor.dtype}, on {place} were given: "
            f"{list(shape)}, {dtype}, on {device} was expected"
        )


def address(tensor: Tensor | None) -> ctypes.c_void_p:
    """Return the tensor's memory as a C pointer; None becomes a null pointer."""
    return ctypes.c_void_p(None if tensor is None else tensor.data_ptr())


def empty(
    *shape: int, dtype: torch.dtype = torch.float32, device: torch.device | str = "cpu"
) -> Tensor:
    """Return an uninitialised tensor; on the CPU numpy's memory, whose huge pages fill faster."""
    if torch.device(device).type != "cpu":
        return torch.empty(shape, dtype=dtype, device=device)
    return torch.from_numpy(np.empty(shape, dtype=str(dtype).removeprefix("torch.")))


def decode_rans(
    data: bytes | memoryview, count: int, alphabet: int
) -> UInt16[np.ndarray, "n"] | None:
    """Decode `count` symbols below `alphabet` (1 to 4096); None without the library.

    The caller has checked the stream's header (`rans.check_header`).

    Raises:
        InputError: the stream is damaged; the message is that of the reference.
    """
    if not 1 <= alphabet <= ALPHABET_MAX:
        raise InputError(f"an alphabet has 1 to {ALPHABET_MAX} symbols, not {alphabet}")
    if decoders() is None:
        return None
    symbols = np.empty(count, dtype=np.uint16)
    _decode("mgs_decode_rans", data, ctypes.c_int64(count), alphabet, _pointer(symbols))
    return symbols


def encode_rans(
    entries: Int32[np.ndarray, "rounds lanes"],
    frequencies: UInt32[np.ndarray, "entries"],
    starts: UInt32[np.ndarray, "entries"],
    count: int,
) -> tuple[UInt16[np.ndarray, "w"], UInt32[np.ndarray, "lanes"]] | None:
    """Run `rans.encode_rounds` on `count` symbols; None without the library."""
    if decoders() is None:
        return None
    words, states = np.empty(count, dtype=np.uint16), np.empty(entries.shape[1], dtype=np.uint32)
    encode = _library().mgs_encode_rans
    encode.restype = ctypes.c_int64
    tables = (np.ascontiguousarray(each) for each in (entries, frequencies, starts))
    arguments = [_pointer(each) for each in (*tables, words, states)]
    number = encode(ctypes.c_int64(count), *arguments)
    return words[count - number :], states


def unpack_short(
    data: bytes | memoryview, widths: Integer[np.ndarray, "n"]
) -> UInt16[np.ndarray, "n"] | None:
    """Unpack numbers of `widths` bits (0 to 16) each; None and errors as in `decode_rans`."""
    if decoders() is None:
        return None
    if len(widths) and not 0 <= int(widths.min()) <= int(widths.max()) <= WIDTH_MAX:
        raise InputError(f"a packed number has 0 to {WIDTH_MAX} bits")
    narrow = np.ascontiguousarray(widths, dtype=np.uint8)
    numbers = np.empty(len(narrow), dtype=np.uint16)
    outputs = (_pointer(narrow), ctypes.c_int64(len(narrow)), _pointer(numbers))
    _decode("mgs_unpack_short", data, *outputs)
    return numbers


def join_columns(
    columns: list[UInt16[np.ndarray, "n"]], least: list[int], out: Int32[np.ndarray, "n c"]
) -> bool:
    """Run `uniform_streams.join_columns`; False, with `out` unchanged, if that is not possible."""
    if decoders() is None or not out.flags.c_contiguous:
        return False
    columns = [np.ascontiguousarray(column) for column in columns]
    for column in columns:
        validate(column, len(out), dtype=np.uint16)
    validate(out, len(out), len(least), dtype=np.int32)
    assert len(least) == len(columns)
    _library().mgs_join_columns(
        ctypes.c_int64(len(out)),
        len(columns),
        (ctypes.c_void_p * len(columns))(*(column.ctypes.data for column in columns)),
        _pointer(np.array(least, dtype=np.int32)),
        _pointer(out),
    )
    return True


def decode_positions(data: bytes | memoryview, count: int) -> UInt16[np.ndarray, "n 3"] | None:
    """Decode the float16 patterns of `count` positions; None and errors as in `decode_rans`."""
    if decoders() is None:
        return None
    patterns = np.empty((count, 3), dtype=np.uint16)
    _decode("mgs_decode_positions", data, ctypes.c_int64(count), _pointer(patterns))
    return patterns


def refinement_bits(
    codes: Int[Tensor, "n 3"], step_size: float, table: UInt8[Tensor, "m"]
) -> UInt8[Tensor, "n 3"] | None:
    """Run `rotations.refinement_bits_of` with its `table`; None for what C++ does not take."""
    if codes.dtype != torch.int32 or codes.device.type != "cpu" or decoders() is None:
        return None
    validate(codes, len(codes), 3, dtype=torch.int32)
    validate(table, len(table), dtype=torch.uint8)
    held, bits = codes.contiguous(), empty(*codes.shape, dtype=torch.uint8)
    _library().mgs_refinement_bits(
        address(held),
        ctypes.c_int64(len(held)),
        ctypes.c_float(step_size),
        address(table),
        len(table) - 1,
        address(bits),
    )
    return bits


def gather_entries(
    centers: Float[Tensor, "s k length"], indices: Int[Tensor, "n s"]
) -> Float[Tensor, "n d"] | None:
    """Run `codebooks.gather_entries` without gradients.

    None for what C++ does not take, and for indices out of range.
    """
    books, size, length = centers.shape
    if indices.dtype != torch.int16 or not supports(centers):
        return None
    validate(indices, len(indices), books, dtype=torch.int16)
    held, codes = centers.detach().contiguous(), indices.contiguous()
    values = empty(len(codes), books * length)
    out_of_range = _library().mgs_gather_entries(
        ctypes.c_int64(len(codes)),
        address(codes),
        address(held),
        books,
        size,
        length,
        address(values),
    )
    return None if out_of_range else values


def decode_colors(
    positions: Float[Tensor, "n 3"],
    static: Float[Tensor, "n 3"],
    view: Float[Tensor, "n 3"],
    *,
    weights: list[Tensor],
) -> Float[Tensor, "n k 3"]:
    """Return the harmonics of `AppearanceDecoder`; `weights` are its six matrices in order."""
    for part in (positions, static, view):
        validate(part, len(positions), 3)
    rest, numbers = len(weights[-1]), _joined(weights)
    sh = empty(len(positions), 1 + rest // 3, 3)
    rows = positions.contiguous()
    # slices of one tensor, the usual case, need no copy
    static, view = (part if part.stride(1) == 1 else part.contiguous() for part in (static, view))
    _library().mgs_decode_colors(
        ctypes.c_int64(len(rows)),
        address(rows),
        address(static),
        ctypes.c_int64(static.stride(0)),
        address(view),
        ctypes.c_int64(view.stride(0)),
        address(numbers),
        rest,
        address(sh),
    )
    return sh


def decode_lobes(
    latents: Float[Tensor, "n l"],
    gaussians: Gaussians,
    *,
    base: bool,
    hidden: list[tuple[Tensor, Tensor]],
    bias: Float[Tensor, "o"],
    last: Float[Tensor, "o _"],
) -> Float[Tensor, "n m 2"]:
    """Return the lobes of `LobeDecoder`: `bias + last @ inputs`.

    The inputs are the last hidden units, the latents and, with `base`, the logits of the
    opacities. `hidden` has an offset `[width]` and a matrix `[width, inputs]` for each layer.
    """
    for part in (latents, *gaussians.tensors().values()):
        validate(part, len(gaussians), *part.shape[1:])
    numbers = _joined([part for layer in hidden for part in layer] + [bias, last])
    widths = np.array([len(offset) for offset, _ in hidden], dtype=np.int32)
    lobes = empty(len(latents), len(bias) // 2, 2)
    held = [
        part.detach().contiguous()
        for part in (
            latents,
            gaussians.logit_opacities,
            gaussians.sh,
            gaussians.log_scales,
            gaussians.quats,
        )
    ]
    rows, logits, sh, log_scales, quats = map(address, held)
    _library().mgs_decode_lobes(
        ctypes.c_int64(len(latents)),
        rows,
        latents.shape[1],
        logits if base else None,
        sh,
        held[2][0].numel(),
        log_scales,
        quats,
        address(numbers),
        _pointer(widths),
        len(widths),
        len(bias),
        address(lobes),
    )
    return lobes


def _library() -> ctypes.CDLL:
    loaded = decoders()
    assert loaded is not None
    return loaded


def _joined(parts: list[Tensor]) -> Float[Tensor, "w"]:
    return torch.cat([part.detach().reshape(-1) for part in parts])


def _decode(name: str, data: bytes | memoryview, *arguments) -> None:
    """Call a decoder of decode.h; raises InputError for a damaged stream."""
    stream = np.frombuffer(data, dtype=np.uint8)
    decode = getattr(_library(), name)
    code = decode(_pointer(stream), ctypes.c_int64(len(stream)), *arguments)
    if code == NO_MEMORY:
        raise MemoryError
    if code:
        raise InputError(MESSAGES[code])


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
