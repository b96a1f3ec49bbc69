"""Data-parallel training in several processes that torchrun starts.

The processes share the views of a step. Each holds the whole scene and takes every step. They
exchange gradients view by view and add them up in the order of the views, as one process does, so
that all hold the same sums bit by bit. Each process computes everything else (Adam, densification,
pruning, k-means, regressions) itself, with random generators in the same state, instead of
receiving it. Only machines that compute differently can diverge; the step loop therefore compares
the states of all processes (`Team.require_identical`).
"""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta

import torch
import torch.distributed as dist
from torch import Tensor

from mobilegs.device import Device, choose_device
from mobilegs.errors import InputError

TIMEOUT = timedelta(days=1)  # the other processes wait while the main one evaluates


class LostProcessError(RuntimeError):
    """Another process of the team has ended."""


class Team:
    """The processes that train together; a single process is a team of one.

    Attributes:
        device: the device of this process.
        rank: the number of this process, from 0.
        world_size: the number of processes.
    """

    def __init__(self, device: torch.device, rank: int = 0, world_size: int = 1) -> None:
        self.device, self.rank, self.world_size = device, rank, world_size
        self._weights: dict[tuple[float, torch.device, torch.dtype], Tensor] = {}

    @property
    def on_this_machine(self) -> int:
        """Number of the processes that share this machine."""
        return int(os.environ["LOCAL_WORLD_SIZE"]) if self.world_size > 1 else 1

    @property
    def is_main(self) -> bool:
        """True in the process that writes, prints and evaluates."""
        return self.rank == 0

    def all_gather(self, *tensors: Tensor) -> list[tuple[Tensor, ...]]:
        """Return the tensors of every process, by rank; shapes and dtypes must agree."""
        if self.world_size == 1:
            return [tensors]
        gathered = []
        for tensor in tensors:
            own = tensor.detach().contiguous()
            gathered.append([torch.empty_like(own) for _ in range(self.world_size)])
            try:
                dist.all_gather(gathered[-1], own)
            except RuntimeError as error:
                raise LostProcessError(str(error)) from error
        return list(zip(*gathered, strict=True))

    def all_gather_ints(self, *own: int) -> list[list[int]]:
        """Return the numbers of every process, by rank; at least one. Acts as a barrier."""
        if self.world_size == 1:  # avoids a synchronisation with the GPU
            return [list(own)]
        gathered = self.all_gather(torch.tensor(own, dtype=torch.int64, device=self.device))
        return [numbers.tolist() for [numbers] in gathered]

    def interleave(self, own: Sequence[int]) -> list[int]:
        """Return one number per view of the step, given one per view of this process.

        View i of a step belongs to the process of rank `i % world_size`.
        """
        return [number for each in zip(*self.all_gather_ints(*own), strict=True) for number in each]

    def accumulate_gradients(
        self, leaves: Sequence[Tensor], loss: Tensor, *extra: Tensor, weight: float = 1.0
    ) -> list[tuple[Tensor, ...]]:
        """Add the gradients of every process's `loss`, `weight` times, to `leaf.grad`, by rank.

        Returns `(loss, *extra)` of every process, by rank and detached. The backward pass may
        still write to `extra`.
        """
        key = weight, loss.device, loss.dtype
        if key not in self._weights:  # a new tensor in each step is an operation more
            self._weights[key] = loss.new_tensor(weight)
        gradients = torch.autograd.grad(loss, leaves, self._weights[key], materialize_grads=True)
        gathered = self.all_gather(*(g.contiguous() for g in gradients), loss.detach(), *extra)
        for each in gathered:
            _add_gradients(leaves, each[: len(leaves)])
        return [each[len(leaves) :] for each in gathered]

    def barrier(self) -> None:
        """Wait until every process has reached this call."""
        self.all_gather_ints(0)

    def require_identical(self, where: str, *numbers: int) -> None:
        """Raise InputError unless every process passes the same numbers."""
        if any(other != list(numbers) for other in self.all_gather_ints(*numbers)):
            raise InputError(
                f"the processes no longer hold the same scene {where}: run them on machines of "
                "one kind, with the same number of threads"
            )


def _add_gradients(leaves: Sequence[Tensor], gradients: Sequence[Tensor]) -> None:
    """Add to `leaf.grad`; not in place, since autograd may give one tensor to two leaves."""
    before, places = [], []
    for place, (leaf, gradient) in enumerate(zip(leaves, gradients, strict=True)):
        if leaf.grad is None:
            leaf.grad = gradient
        else:
            before.append(leaf.grad)
            places.append(place)
    if places:  # one kernel on a GPU
        added = [gradients[place] for place in places]
        sums = torch._foreach_add(before, added)  # pyright: ignore[reportPrivateImportUsage]
        for place, found in zip(places, sums, strict=True):
            leaves[place].grad = found


SINGLE_PROCESS = Team(torch.device("cpu"))


def is_main_process() -> bool:
    """Return True for a single process, and for rank 0 of those that torchrun started."""
    return "TORCHELASTIC_RUN_ID" not in os.environ or os.environ["RANK"] == "0"


@contextmanager
def join_team(name: Device) -> Iterator[Team]:
    """Join the processes that torchrun started, on the device `name`; one GPU per process.

    Without torchrun, the team is this process. If several processes fail, the first one raises its
    error and the others exit with SystemExit.
    """
    if "TORCHELASTIC_RUN_ID" not in os.environ or os.environ["WORLD_SIZE"] == "1":
        yield Team(choose_device(name))
        return
    # This module takes the default group as a default argument when it is imported. Import it
    # before there is a group: otherwise it keeps the group's threads alive, and these abort the
    # process when Python exits.
    import torch.distributed.nn.functional  # noqa: F401
    from torch.distributed.rendezvous import rendezvous

    store, rank, world_size = next(rendezvous("env://"))
    try:
        device = _own_device(choose_device(name))
        library = "nccl" if device.type == "cuda" else "gloo"
        dist.init_process_group(
            library, store=store, rank=rank, world_size=world_size, timeout=TIMEOUT
        )
        yield Team(device, rank, world_size)
    except BaseException as error:
        if store.add("mobilegs/failed", 1) > 1:
            codes = {InputError: 2, KeyboardInterrupt: 130}
            raise SystemExit(codes.get(type(error), 1)) from None
        if isinstance(error, LostProcessError):
            raise SystemExit(
                f"mobilegs: another process of this training has ended ({error}): add --resume "
                "to continue"
            ) from None
        raise
    dist.destroy_process_group()


def _own_device(device: torch.device) -> torch.device:
    if device.type != "cuda":
        return device
    if device.index is not None:
        raise InputError(f"each process has a GPU of its own: use --device cuda, not {device}")
    local, available = int(os.environ["LOCAL_RANK"]), torch.cuda.device_count()
    if local >= available:
        raise InputError(
            f"{os.environ['LOCAL_WORLD_SIZE']} processes need one GPU each, but there are "
            f"{available}: start {available}, or add --device cpu"
        )
    torch.cuda.set_device(local)
    return torch.device("cuda", local)
