"""The file of a state: one safetensors file with JSON in its header."""

import json
import zlib
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from mobilegs.atomic import atomic_path, file_size
from mobilegs.errors import InputError

VERSION = 1
# the errors of a state that lacks something, or has something of another type
STATE_ERRORS = (
    ArithmeticError, AssertionError, AttributeError, LookupError, RecursionError, TypeError,
    ValueError,
)  # fmt: skip
UNUSABLE = "delete the run's folder and start a new run"
TENSOR = "$tensor"  # in the JSON, {"$tensor": name} stands for a tensor


def write_state(path: Path | str, state: dict[str, Any]) -> None:
    """Write `state`, nested dicts and lists of tensors and JSON values, to `path` atomically.

    Keys are strings. Floats keep every bit. If the process is killed, either the previous file or
    the new one is there.
    """
    tensors: dict[str, torch.Tensor] = {}
    tree = _without_tensors({"version": VERSION, "state": state}, "", tensors)
    with atomic_path(path) as temporary:
        save_file(tensors, temporary, metadata={"checkpoint": json.dumps(tree)})


def digest(state: dict[str, Any]) -> int:
    """Return a CRC-32 of all tensors and values in `state`, to compare states bit by bit."""
    tensors: dict[str, torch.Tensor] = {}
    crc = zlib.crc32(json.dumps(_without_tensors(state, "", tensors)).encode())
    for tensor in tensors.values():
        crc = zlib.crc32(tensor.numpy().tobytes(), crc)
    return crc


def read_state(path: Path | str) -> dict[str, Any]:
    """Return the state that `write_state` wrote, with its tensors on the CPU.

    Raises InputError if the file is missing, damaged, or of another version.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"there is no checkpoint at {path}: start a new run")
    try:
        file_size(path)  # raises for a pipe, at which the library would wait
        with safe_open(str(path), framework="pt") as file:
            tree = json.loads((file.metadata() or {})["checkpoint"])
            if tree["version"] != VERSION:
                raise InputError(
                    f"{path} is a checkpoint of version {tree['version']}, but this program reads "
                    f"version {VERSION}: resume with the program that started the run"
                )
            names = set(file.keys())
            return _with_tensors(tree["state"], {name: file.get_tensor(name) for name in names})
    except InputError:
        raise
    except (*STATE_ERRORS, SafetensorError, OSError) as error:
        raise InputError(f"{path} is not a complete checkpoint ({error}): {UNUSABLE}") from error


def _without_tensors(value: Any, place: str, tensors: dict[str, torch.Tensor]) -> Any:
    if isinstance(value, torch.Tensor):
        tensors[place] = value.detach().cpu().contiguous().clone()
        return {TENSOR: place}
    if isinstance(value, dict):
        return {key: _without_tensors(v, f"{place}/{key}", tensors) for key, v in value.items()}
    if isinstance(value, list | tuple):
        return [_without_tensors(v, f"{place}/{i}", tensors) for i, v in enumerate(value)]
    return value


def _with_tensors(value: Any, tensors: dict[str, torch.Tensor]) -> Any:
    if isinstance(value, dict):
        if TENSOR in value:
            return tensors[value[TENSOR]]
        return {key: _with_tensors(v, tensors) for key, v in value.items()}
    if isinstance(value, list):
        return [_with_tensors(v, tensors) for v in value]
    return value
