"""What takes long when a scene is opened, in C++: decode.cpp and networks.cpp.

Nothing is defined here. `rans`, `bits`, `positions`, `codebooks`, `appearance` and `lobes` say what
comes out, and compute it themselves where the package was installed without its C++ library.
"""

import ctypes
from functools import cache

import numpy as np
import torch
from jaxtyping import Float, Int, Int32, Integer, UInt8, UInt16
from torch import Tensor

from mobilegs.csrc import binding
from mobilegs.csrc.binding import address
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians

# what the definitions say where decode.h gives these numbers
SENTENCES = {
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


@cache
def library() -> ctypes.CDLL | None:
    """The C++ library for this CPU; None where there is none."""
    try:
        return binding.library()
    except ImportError:
        return None


def room(
    *shape: int, dtype: torch.dtype = torch.float32, device: torch.device | str = "cpu"
) -> Tensor:
    """Room for numbers: on the CPU numpy's, whose large pages take less time to fill."""
    if torch.device(device).type != "cpu":
        return torch.empty(shape, dtype=dtype, device=device)
    return torch.from_numpy(np.empty(shape, dtype=str(dtype).removeprefix("torch.")))


def decode_rans(
    data: bytes | memoryview, count: int, alphabet: int
) -> UInt16[np.ndarray, "n"] | None:
    """`count` symbols below `alphabet` (1 to 4096); None if there is no library.

    The stream's header has been looked at (`rans.read_head`).

    Raises:
        InputError: the stream is damaged; the sentence is that of the definition.
    """
    if library() is None:
        return None
    symbols = np.empty(count, dtype=np.uint16)
    _decode("mgs_decode_rans", data, ctypes.c_int64(count), alphabet, _pointer(symbols))
    return symbols


def unpack_short(
    data: bytes | memoryview, widths: Integer[np.ndarray, "n"]
) -> UInt16[np.ndarray, "n"] | None:
    """Numbers of `widths` bits (0 to 16) each; None and errors as in `decode_rans`."""
    if library() is None:
        return None
    narrow = np.ascontiguousarray(widths, dtype=np.uint8)
    numbers = np.empty(len(narrow), dtype=np.uint16)
    outputs = (_pointer(narrow), ctypes.c_int64(len(narrow)), _pointer(numbers))
    _decode("mgs_unpack_short", data, *outputs)
    return numbers


def joined(
    columns: list[UInt16[np.ndarray, "n"]], least: list[int], out: Int32[np.ndarray, "n c"]
) -> bool:
    """`scalar_streams.join`; False, and nothing done, if there is no library."""
    if library() is None or not out.flags.c_contiguous:
        return False
    _library().mgs_join(
        ctypes.c_int64(len(out)),
        len(columns),
        (ctypes.c_void_p * len(columns))(*(column.ctypes.data for column in columns)),
        _pointer(np.array(least, dtype=np.int32)),
        _pointer(out),
    )
    return True


def decode_positions(data: bytes | memoryview, count: int) -> UInt16[np.ndarray, "n 3"] | None:
    """The bits of `count` positions; None and errors as in `decode_rans`."""
    if library() is None:
        return None
    halves = np.empty((count, 3), dtype=np.uint16)
    _decode("mgs_decode_positions", data, ctypes.c_int64(count), _pointer(halves))
    return halves


def finer_bits(
    codes: Int[Tensor, "n 3"], step: float, table: UInt8[Tensor, "m"]
) -> UInt8[Tensor, "n 3"] | None:
    """`rotations.finer_bits_of`, with its `table` of bits; None as in `look_up`."""
    if codes.dtype != torch.int32 or codes.device.type != "cpu" or library() is None:
        return None
    held, bits = codes.contiguous(), room(*codes.shape, dtype=torch.uint8)
    _library().mgs_finer_bits(
        address(held),
        ctypes.c_int64(len(held)),
        ctypes.c_float(step),
        address(table),
        len(table) - 1,
        address(bits),
    )
    return bits


def look_up(
    centers: Float[Tensor, "s k length"], indices: Int[Tensor, "n s"]
) -> Float[Tensor, "n d"] | None:
    """`codebooks.look_up` without gradients; None for what it does not know or cannot find."""
    books, size, length = centers.shape
    if indices.dtype != torch.int16 or not takes(centers):
        return None
    held, codes = centers.detach().contiguous(), indices.contiguous()
    values = room(len(codes), books * length)
    strays = _library().mgs_look_up(
        ctypes.c_int64(len(codes)),
        address(codes),
        address(held),
        books,
        size,
        length,
        address(values),
    )
    return None if strays else values


def takes(*tensors: Tensor) -> bool:
    """Whether the functions below can be asked for these: float32 on the CPU, no other."""
    plain = all(t.device.type == "cpu" and t.dtype == torch.float32 for t in tensors)
    return plain and library() is not None


def decode_colors(
    positions: Float[Tensor, "n 3"],
    static: Float[Tensor, "n 3"],
    view: Float[Tensor, "n 3"],
    *,
    weights: list[Tensor],
) -> Float[Tensor, "n k 3"]:
    """Harmonics; `weights` are the six matrices of an `AppearanceDecoder` in their order."""
    rest, numbers = len(weights[-1]), _joined(weights)
    sh = room(len(positions), 1 + rest // 3, 3)
    rows = positions.contiguous()
    # halves of one tensor, as they mostly are, need not be copied
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
    """Lobes: `bias + last @ inputs`.

    The inputs are what the `hidden` layers (offset `[width]` and matrix `[width, inputs]` each)
    make of the Gaussians' attributes and the latents, then the latents, then the logits of the
    opacities if they are the `base`.
    """
    numbers = _joined([part for layer in hidden for part in layer] + [bias, last])
    widths = np.array([len(offset) for offset, _ in hidden], dtype=np.int32)
    lobes = room(len(latents), len(bias) // 2, 2)
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
    native = library()
    assert native is not None, "asked for what `takes` says cannot be had"
    return native


def _joined(parts: list[Tensor]) -> Float[Tensor, "w"]:
    return torch.cat([part.detach().reshape(-1) for part in parts])


def _decode(name: str, data: bytes | memoryview, *arguments) -> None:
    """Call a function of decode.h; raises InputError if it does not find the stream sound."""
    stream = np.frombuffer(data, dtype=np.uint8)
    decode = getattr(_library(), name)
    wrong = decode(_pointer(stream), ctypes.c_int64(len(stream)), *arguments)
    if wrong == NO_MEMORY:
        raise MemoryError
    if wrong:
        raise InputError(SENTENCES[wrong])


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
