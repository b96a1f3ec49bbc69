"""Devices of PyTorch, as options name them."""

import torch

from mobilegs.errors import InputError

Device = str  # auto, cpu, cuda or cuda:N; see `choose_device`


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
