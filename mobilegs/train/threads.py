"""Threads of a training: those of the kernels, which do not wait for each other, and torch's."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager

import torch

from mobilegs.csrc import binding

_kernel_threads: list[int] = []  # of the open `torch_on_one_thread`


@contextmanager
def torch_on_one_thread(*, wanted: bool = True) -> Iterator[None]:
    """While it is open, torch uses one thread, and the kernels as many as torch did before.

    The threads of torch divide an operation evenly and wait for the slowest one: beside other
    programs a step takes a multiple of its time. Those of the kernels take small parts, and wait
    for none that has not begun (csrc/parallel.h). With `wanted=False` nothing changes.
    """
    library = binding.decoders()
    if not wanted or library is None or _kernel_threads:
        yield
        return
    number = torch.get_num_threads()
    _kernel_threads.append(number)
    library.mgs_use_threads(number)
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(number)
        library.mgs_use_threads(0)
        _kernel_threads.clear()


@contextmanager
def _threads(number: int) -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(number)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def all_threads() -> AbstractContextManager[None]:
    """Use all threads of torch again within `torch_on_one_thread`: for long work between steps."""
    return _threads(_kernel_threads[0] if _kernel_threads else torch.get_num_threads())


def one_thread() -> AbstractContextManager[None]:
    """Use one thread of torch, for sums whose bits must not depend on the number of threads."""
    return _threads(1)
