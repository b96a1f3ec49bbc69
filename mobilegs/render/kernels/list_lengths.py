"""Lengths of tile lists on a GPU: room for the next list, without waiting for its length.

The host knows a list's length only when the GPU has counted it. So it reserves room for half as
many entries more than the longest list of earlier renderings that were alike; their lengths arrive
some kernels later. Where nothing is known, it waits for the count.

A list that is longer than its room is never cut: the kernels compare the two on the GPU. Then every
tile visits all Gaussians in the order of the list, which gives the same image, and for sort-free
blending the same gradients, in more time, until the host learns the new length. Sorted blending
keeps sums per entry for its gradients: its backward pass asks for the length of its own list, which
was counted before the image, and makes a list with enough room if it was too long.
"""

from collections import deque
from threading import Lock
from typing import Protocol, runtime_checkable

import torch
from torch import Tensor

ROOM_MAX = 2**31 - 2**12  # entries have 32-bit numbers, and blocks look ahead

Alike = tuple[int, int]  # number of tiles, and of the bits of the number of Gaussians


@runtime_checkable
class Length(Protocol):
    """The length of a list."""

    def known(self) -> bool:
        """Return whether `value` does not wait."""
        ...

    def value(self) -> int:
        """Return the length."""
        ...


class DelayedLength:
    """A length that the GPU may not have counted yet, on its way to the host."""

    def __init__(self, length: Tensor) -> None:
        host = torch.empty(1, dtype=length.dtype, device="cpu", pin_memory=True)
        host.copy_(length, non_blocking=True)
        self.number, self.copied = host.numpy(), torch.cuda.Event()
        self.copied.record()

    def known(self) -> bool:
        return self.copied.query()

    def value(self) -> int:
        self.copied.synchronize()
        return int(self.number[0])


class ListLengths:
    """The longest lists on a GPU that are known, and those on their way."""

    def __init__(self) -> None:
        self.longest: dict[Alike, int] = {}
        self.coming: deque[tuple[Alike, Length]] = deque()
        self.lock = Lock()

    def room(self, alike: Alike) -> int | None:
        """Return how many entries the next list may have, or None if no list was alike."""
        with self.lock:
            while self.coming and self.coming[0][1].known():
                of, length = self.coming.popleft()
                self.learn(of, length.value())
        return room_for(self.longest[alike]) if alike in self.longest else None

    def learn(self, alike: Alike, length: int) -> None:
        self.longest[alike] = max(length, self.longest.get(alike, 0))


def room_for(length: int) -> int:
    """Return a length half as large again, rounded up to one of eight sizes per power of two."""
    wanted = length + length // 2 + 1
    step = 1 << max(0, wanted.bit_length() - 4)
    return min(-(-wanted // step) * step, ROOM_MAX)
