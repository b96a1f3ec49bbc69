"""One training in several processes, which torchrun starts: they share the views of a step.

Every process holds the whole scene and takes every step. Gradients are exchanged view by view and
added up in the order of the views, as a process alone adds them up, so all hold the same sums to
the last bit. What follows from these (Adam, densification, pruning, k-means, regressions) is
computed by all of them, with generators that stand alike, instead of being sent around: that needs
no second way for a stage's state. Only machines that compute differently could come apart by it,
and the loop compares what the processes hold (`Team.refuse_difference`).
"""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta

import torch
import torch.distributed as dist
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.scene_file import Device, choose_device

PATIENCE = timedelta(days=1)  # the others wait while the first one evaluates


class PartedError(RuntimeError):
    """Another process of the team has ended."""


class Team:
    """The processes that train together, which may be one alone.

    Attributes:
        device: where this process computes.
        rank, world: which of how many it is.
    """

    def __init__(self, device: torch.device, rank: int = 0, world: int = 1) -> None:
        self.device, self.rank, self.world = device, rank, world

    @property
    def first(self) -> bool:
        """Whether this process is the one that writes, prints and evaluates."""
        return self.rank == 0

    def gather(self, *tensors: Tensor) -> list[tuple[Tensor, ...]]:
        """What every process gave, by rank; all give tensors of the same shapes and kinds."""
        if self.world == 1:
            return [tensors]
        found = []
        for tensor in tensors:
            own = tensor.detach().contiguous()
            found.append([torch.empty_like(own) for _ in range(self.world)])
            try:
                dist.all_gather(found[-1], own)
            except RuntimeError as error:
                raise PartedError(str(error)) from error
        return list(zip(*found, strict=True))

    def numbers(self, *own: int) -> list[list[int]]:
        """The same for numbers, at least one. Nobody goes on before all have come here."""
        if self.world == 1:  # without waiting for a GPU
            return [list(own)]
        told = self.gather(torch.tensor(own, dtype=torch.int64, device=self.device))
        return [numbers.tolist() for [numbers] in told]

    def in_order(self, own: Sequence[int]) -> list[int]:
        """A number for each view of a step, from a number for each of this process's views."""
        return [number for each in zip(*self.numbers(*own), strict=True) for number in each]

    def add_gradients(
        self, leaves: Sequence[Tensor], loss: Tensor, *beside: Tensor
    ) -> list[tuple[Tensor, ...]]:
        """Add to the leaves' `grad` what every process's `loss` gives, by rank.

        Returns loss and `beside` of every process, by rank, without graphs. `beside` may be
        filled in by the backward pass.
        """
        gradients = torch.autograd.grad(loss, leaves, materialize_grads=True)
        found = self.gather(*(g.contiguous() for g in gradients), loss.detach(), *beside)
        for each in found:
            for leaf, gradient in zip(leaves, each, strict=False):
                # not in place: autograd may give one tensor to two leaves
                leaf.grad = gradient if leaf.grad is None else leaf.grad + gradient
        return [each[len(leaves) :] for each in found]

    def wait(self) -> None:
        """Go on once every process has come here."""
        self.numbers(0)

    def refuse_difference(self, where: str, *numbers: int) -> None:
        """Raise InputError unless every process has the same numbers."""
        if any(other != list(numbers) for other in self.numbers(*numbers)):
            raise InputError(
                f"the processes no longer hold the same scene {where}: run them on machines of "
                "one kind, with the same number of threads"
            )


ALONE = Team(torch.device("cpu"))


def is_first() -> bool:
    """Whether this process is alone, or the first one of those that torchrun started."""
    return "TORCHELASTIC_RUN_ID" not in os.environ or os.environ["RANK"] == "0"


@contextmanager
def joined(name: Device) -> Iterator[Team]:
    """The team of this process, on the device that an option names: on GPUs, one for each.

    Without torchrun it is alone. If several fail, only the first that does says why; the others
    leave with SystemExit.
    """
    if "TORCHELASTIC_RUN_ID" not in os.environ or os.environ["WORLD_SIZE"] == "1":
        yield Team(choose_device(name))
        return
    # Arguments of its functions have as their default what group there is when it is imported. That
    # shall be none: the group's threads would outlive it, and abort the process when Python ends.
    import torch.distributed.nn.functional  # noqa: F401
    from torch.distributed.rendezvous import rendezvous

    store, rank, world = next(rendezvous("env://"))
    try:
        device = _own_device(choose_device(name))
        backend = "nccl" if device.type == "cuda" else "gloo"
        dist.init_process_group(backend, store=store, rank=rank, world_size=world, timeout=PATIENCE)
        yield Team(device, rank, world)
    except BaseException as error:
        if store.add("mobilegs/failed", 1) > 1:
            codes = {InputError: 2, KeyboardInterrupt: 130}
            raise SystemExit(codes.get(type(error), 1)) from None
        if isinstance(error, PartedError):
            raise SystemExit(
                f"mobilegs: another process of this training has ended ({error}): add --resume "
                "to continue"
            ) from None
        raise
    dist.destroy_process_group()


def _own_device(device: torch.device) -> torch.device:
    if device.type != "cuda":
        return device
    local, there = int(os.environ["LOCAL_RANK"]), torch.cuda.device_count()
    if local >= there:
        raise InputError(
            f"{os.environ['LOCAL_WORLD_SIZE']} processes cannot have a GPU each of the {there} "
            f"there are: start {there}, or add --device cpu"
        )
    torch.cuda.set_device(local)
    return torch.device("cuda", local)
