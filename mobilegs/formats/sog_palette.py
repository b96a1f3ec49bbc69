"""What `.sog` keeps instead of numbers: 256 values for all of a kind, 65,536 sets of harmonics."""

import numpy as np
import torch
from jaxtyping import Float, Float32, Int, UInt8
from torch import Tensor

from mobilegs.kmeans import kmeans

VALUES = 256
GROUP = 256  # sets of a group, into which harmonics are parted: a search among all is too long
SAMPLE = 1 << 16  # harmonics from which the groups' centres are found
STEPS = 10
BLOCK = 1 << 14  # rows whose distances are computed at a time


def codebook(
    values: Float32[np.ndarray, "n m"],
) -> tuple[Float32[np.ndarray, "256"], UInt8[np.ndarray, "n m"]]:
    """256 values, ascending, and the nearest one's number for each of `values`."""
    flat = torch.from_numpy(values.reshape(-1, 1))
    if not len(flat):
        return np.zeros(VALUES, np.float32), np.zeros(values.shape, np.uint8)
    centers, _ = kmeans(flat, VALUES, generator=torch.Generator())  # on a line nothing is drawn
    book = np.sort(centers[:, 0].numpy()).astype(np.float32)
    nearest = np.searchsorted((book[1:] + book[:-1]) / 2, values)
    return book, nearest.astype(np.uint8)


def palette(rows: Float[Tensor, "n d"], size: int) -> tuple[Float[Tensor, "k d"], Int[Tensor, "n"]]:
    """At most `size` rows that stand for all, and which one each of `rows` takes.

    All of them if there are no more. Otherwise k-means in two stages: rows are parted into groups,
    and each group gets its share of the palette. Deterministic; on the CPU, no gradients.
    """
    count = len(rows)
    if count <= size:
        return rows, torch.arange(count)
    order = torch.linspace(0, count - 1, min(count, SAMPLE)).long()
    parts = max(1, size // GROUP)
    groups = _nearest(rows, _lloyd(rows[order], parts))
    members = groups.argsort(stable=True)
    centers, labels, first, place = [], torch.empty(count, dtype=torch.long), 0, 0
    for number in groups.bincount(minlength=parts).tolist():
        inside = members[first : first + number]
        first += number
        # shares of what is left add up to no more than there is
        share = size * first // count - place
        if number == 0:
            continue
        found = _lloyd(rows[inside], min(number, max(1, share)))
        labels[inside] = place + _nearest(rows[inside], found)
        centers.append(found)
        place += len(found)
    return torch.cat(centers), labels


def _lloyd(rows: Tensor, size: int) -> Tensor:
    """Centres by Lloyd's algorithm, which begins with rows at equal distances in their order."""
    centers = rows[torch.linspace(0, len(rows) - 1, size).long()]
    for _ in range(STEPS if size < len(rows) else 0):
        nearest = _nearest(rows, centers)
        counts = nearest.bincount(minlength=size)[:, None]
        sums = torch.zeros_like(centers).index_add_(0, nearest, rows)
        centers = torch.where(counts > 0, sums / counts.clamp_min(1), centers)
    return centers


def _nearest(rows: Tensor, centers: Tensor) -> Tensor:
    """The number of the nearest of `centers`: |r - c|^2 is least where r c - |c|^2 / 2 is most."""
    half = (centers**2).sum(1) / 2
    parts = [(block @ centers.T - half).argmax(1) for block in rows.split(BLOCK)]
    return torch.cat(parts) if parts else torch.empty(0, dtype=torch.long)
