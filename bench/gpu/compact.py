"""Tensors of a training, small enough to travel: what goes on from them goes on nearly as it was.

A Gaussian's numbers become multiples of a step, or halves; its centre stays as it is. Their Adam
begins anew, as it does in Mini-Splatting's own draw and trim. (Of a small teacher, 3,377 Gaussians
with 250 of 1,500 steps left, held-back photos came to 27.67 dB so, to 27.66 with every bit kept.)
Networks, codebooks, their Adam and random states keep every bit. What Mini-Splatting observed
before its draw is left out after it.
"""

import io
import json
import zipfile
from collections.abc import Iterable, Mapping

import numpy as np
import torch
from torch import Tensor

# what a value is rounded to a multiple of
STEPS = {
    "sh0": 1 / 512,
    "sh_rest": 1 / 256,
    "log_scales": 1 / 512,
    "logit_opacities": 1 / 128,
    "quats": 1 / 2048,
    "explicit_lobes": 1 / 128,
}
HALF_MAX = 6e4
NOTHING = np.zeros(0, np.uint8)


class TooLargeError(Exception):
    """There is no room for this."""


def shrunk(tensors: Iterable[tuple[str, Tensor]], rows: int, most: int) -> bytes:
    """An archive of named tensors; those in `rows` or `adam` with so many rows are of Gaussians.

    Raises TooLargeError as soon as it has more than `most` bytes.
    """
    file, about = io.BytesIO(), {}
    with zipfile.ZipFile(file, "w", zipfile.ZIP_BZIP2) as archive:
        for number, (name, tensor) in enumerate(tensors):
            how, numbers = _coded(name, tensor, rows)
            about[name] = {
                "how": how,
                "kind": numbers.dtype.name,
                "shape": list(tensor.shape),
                "dtype": str(tensor.dtype).removeprefix("torch."),
            }
            archive.writestr(str(number), _planes(numbers))
            if file.tell() > most:
                raise TooLargeError
        archive.writestr("about.json", json.dumps(about))
    return file.getvalue()


def grown(content: bytes) -> dict[str, Tensor]:
    """The tensors of an archive that `shrunk` made."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        about = json.loads(archive.read("about.json"))
        return {
            name: _decoded(name, told, archive.read(str(number)))
            for number, (name, told) in enumerate(about.items())
        }


def _coded(name: str, tensor: Tensor, rows: int) -> tuple[str, np.ndarray]:
    """How a tensor is kept, and the numbers that are kept of it."""
    *place, of, what = ("", "", *name.split("/"))
    whole = tensor.dim() > 0 and len(tensor) == rows
    if tensor.numel() == 0 or (of == "strategy" and tensor.dim() and not whole):
        return "zeros", NOTHING
    if place[-1] not in ("adam", "rows"):
        return "exact", tensor.numpy()
    if what != "value":  # the moments, and the count of steps
        return "zeros", NOTHING
    if of == "means" or not bool(tensor.abs().max() < HALF_MAX):
        return "exact", tensor.numpy()
    if of not in STEPS:
        return "half", tensor.half().numpy()
    multiples = (tensor / STEPS[of]).round().int().numpy()
    fits = int(np.abs(multiples).max()) < 1 << 15
    return "steps", multiples.astype(np.int16 if fits else np.int32)


def _decoded(name: str, told: Mapping, content: bytes) -> Tensor:
    dtype = getattr(torch, told["dtype"])
    if told["how"] == "zeros":
        return torch.zeros(told["shape"], dtype=dtype)
    found = torch.from_numpy(_joined(content, np.dtype(told["kind"]), told["shape"]))
    return (found * STEPS[name.split("/")[-2]] if told["how"] == "steps" else found).to(dtype)


def _planes(numbers: np.ndarray) -> bytes:
    """Column after column, of each the first bytes of all numbers, then the second ones, ..."""
    if not numbers.size:
        return b""
    columns = np.ascontiguousarray(numbers.reshape(len(numbers) if numbers.ndim else 1, -1).T)
    pieces = columns.view(np.uint8).reshape(*columns.shape, columns.itemsize)
    return np.ascontiguousarray(pieces.transpose(0, 2, 1)).tobytes()


def _joined(content: bytes, kind: np.dtype, shape: list[int]) -> np.ndarray:
    """Numbers from what `_planes` made of them."""
    count = shape[0] if shape else 1
    pieces = np.frombuffer(bytearray(content), np.uint8).reshape(-1, kind.itemsize, count)
    columns = np.ascontiguousarray(pieces.transpose(0, 2, 1)).view(kind).reshape(-1, count)
    return np.ascontiguousarray(columns.T).reshape(shape)
