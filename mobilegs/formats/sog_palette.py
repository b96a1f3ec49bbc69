"""Codebooks of 256 values and palettes of SH coefficients for `.sog`."""

import numpy as np
import torch
from jaxtyping import Float, Float32, Int, UInt8
from torch import Tensor

from mobilegs.kmeans import kmeans

VALUES = 256
GROUP_ENTRIES = 256  # palette entries per group; a search among all entries is too slow
SAMPLE = 1 << 16  # rows from which the groups' centres are computed
ITERATIONS = 10  # of Lloyd's algorithm
BLOCK = 1 << 14  # rows whose distances are computed at a time


def codebook(
    values: Float32[np.ndarray, "n m"],
) -> tuple[Float32[np.ndarray, "256"], UInt8[np.ndarray, "n m"]]:
    """Return 256 ascending values, and the index of the nearest one for each of `values`."""
    flat = torch.from_numpy(values.reshape(-1, 1))
    if not len(flat):
        return np.zeros(VALUES, np.float32), np.zeros(values.shape, np.uint8)
    centers, _ = kmeans(flat, VALUES, generator=torch.Generator())  # 1D k-means draws nothing
    book = np.sort(centers[:, 0].numpy()).astype(np.float32)
    nearest = np.searchsorted((book[1:] + book[:-1]) / 2, values)
    return book, nearest.astype(np.uint8)


def palette(rows: Float[Tensor, "n d"], size: int) -> tuple[Float[Tensor, "k d"], Int[Tensor, "n"]]:
    """Return a palette of at most `size` entries, and the entry of each of `rows`.

    Up to `size` rows are their own palette. Otherwise k-means runs in two stages: rows are split
    into groups, and each group gets its share of the palette. Deterministic; on the CPU, without
    gradients.
    """
    count = len(rows)
    if count <= size:
        return rows, torch.arange(count)
    order = torch.linspace(0, count - 1, min(count, SAMPLE)).long()
    parts = max(1, size // GROUP_ENTRIES)
    groups = _nearest(rows, _lloyd(rows[order], parts))
    members = groups.argsort(stable=True)
    centers, labels, first, place = [], torch.empty(count, dtype=torch.long), 0, 0
    for number in groups.bincount(minlength=parts).tolist():
        inside = members[first : first + number]
        first += number
        # cumulative shares, so that their sum is at most `size`
        share = size * first // count - place
        if number == 0:
            continue
        entries = _lloyd(rows[inside], min(number, max(1, share)))
        labels[inside] = place + _nearest(rows[inside], entries)
        centers.append(entries)
        place += len(entries)
    return torch.cat(centers), labels


def _lloyd(rows: Tensor, size: int) -> Tensor:
    """Return centres by Lloyd's algorithm, which starts from evenly spaced rows."""
    centers = rows[torch.linspace(0, len(rows) - 1, size).long()]
    for _ in range(ITERATIONS if size < len(rows) else 0):
        nearest = _nearest(rows, centers)
        counts = nearest.bincount(minlength=size)[:, None]
        sums = torch.zeros_like(centers).index_add_(0, nearest, rows)
        centers = torch.where(counts > 0, sums / counts.clamp_min(1), centers)
    return centers


def _nearest(rows: Tensor, centers: Tensor) -> Tensor:
    """Return the index of each row's nearest centre, which maximises r c - |c|^2 / 2."""
    half = (centers**2).sum(1) / 2
    parts = [(block @ centers.T - half).argmax(1) for block in rows.split(BLOCK)]
    return torch.cat(parts) if parts else torch.empty(0, dtype=torch.long)
