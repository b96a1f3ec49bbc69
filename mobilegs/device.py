"""Devices of PyTorch, as options name them, and numbers that a program needs from them."""

import torch
from torch import Tensor
from torch.utils.weak import WeakIdKeyDictionary

from mobilegs.errors import InputError

Device = str  # auto, cpu, cuda or cuda:N; see `choose_device`

_read = WeakIdKeyDictionary()  # version and numbers of each tensor that was read


def host_values(tensor: Tensor) -> list[float]:
    """Return the numbers of a small tensor, row by row.

    They are read once, until an operation changes the tensor in place: on a GPU each reading waits
    for all that was started before.
    """
    if tensor.is_inference():  # has no version
        return tensor.double().flatten().tolist()
    known = _read.get(tensor)
    if known is None or known[0] != tensor._version:
        known = _read[tensor] = (tensor._version, tensor.detach().double().flatten().tolist())
    return known[1]


def free_bytes(device: torch.device) -> int:
    """Return the free memory of a GPU in bytes."""
    return torch.cuda.mem_get_info(device)[0]


def choose_device(name: Device) -> torch.device:
    """Return the device of an option: `cpu`, `cuda`, or `cuda:N` for GPU number N from 0.

    `auto` is the GPU if there is one. Raises InputError for any other name, and for a GPU that this
    machine does not have.
    """
    count = torch.cuda.device_count() if torch.cuda.is_available() else 0
    if name == "auto":
        name = "cuda" if count else "cpu"
    kind, colon, number = name.partition(":")
    if name != "cpu" and (kind != "cuda" or (colon and not number.isdecimal())):
        raise InputError(f"there is no device '{name}': use auto, cpu, cuda or cuda:N")
    if kind == "cuda" and not count:
        raise InputError("this machine has no CUDA device: see `mobilegs doctor`")
    if colon and int(number) >= count:
        raise InputError(
            f"there is no device '{name}': this machine has {count} GPUs, from cuda:0 on"
        )
    return torch.device(name)
