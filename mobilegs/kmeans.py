"""K-means for codebooks: many points in one or two dimensions, up to some thousand centres."""

import numpy as np
import torch
from jaxtyping import Float, Float64, Int
from scipy.spatial import KDTree
from torch import Tensor

from mobilegs.errors import InputError

LLOYD_POINTS = 65536  # sample size of Lloyd's algorithm
SEED_POINTS = 16384  # sample size of k-means++
SAMPLE_ITERATIONS, FULL_ITERATIONS = 25, 2  # on the sample, then on all points
LINE_ITERATIONS = 200  # an iteration on a line takes microseconds: usually runs to convergence
BINS = 4096
CHUNK = 16384  # points per matrix of distances
BIN_POINTS = 64  # least points per bin: halves the error of 10,000 points and 256 centres


def kmeans(
    points: Float[Tensor, "n d"],
    k: int,
    *,
    generator: torch.Generator,
) -> tuple[Float[Tensor, "k d"], Int[Tensor, "n"]]:
    """Return `k` centres that minimise the mean squared distance, and each point's nearest centre.

    With fewer than `k` distinct points, the other centres are copies without points. Computed on
    the CPU in float64, in tenths of a second for half a million points. The result depends only
    on the values and the generator, a CPU one. No gradients.

    Raises:
        InputError: there are no points, or some are not finite.
    """
    values = points.detach().cpu().double().numpy()
    if len(values) == 0:
        raise InputError("k-means was given no points: the scene has no Gaussians left")
    if not np.isfinite(values).all():
        raise InputError("k-means was given values that are not finite: training has diverged")
    if values.shape[1] == 1:
        places = _kmeans_line(np.sort(values[:, 0]), k)[:, None]
    else:
        places = _kmeans_space(values, k, generator)
    centers = torch.from_numpy(places).to(points)
    return centers, nearest_centers(points, centers)


def nearest_centers(
    points: Float[Tensor, "n d"], centers: Float[Tensor, "k d"]
) -> Int[Tensor, "n"]:
    """Return the index of the centre nearest to each point, in float64, without gradients.

    CPU and GPU may choose differently between centres at equal distances.
    """
    if points.is_cuda:
        return _nearest_of_all(points, centers)
    values = points.detach().cpu().double().numpy()
    places = centers.detach().cpu().double().numpy()
    return torch.from_numpy(_assign(values, places)[1]).to(points.device)


@torch.no_grad()
def _nearest_of_all(
    points: Float[Tensor, "n d"], centers: Float[Tensor, "k d"]
) -> Int[Tensor, "n"]:
    places = centers.double()
    nearest = [
        torch.cdist(some.double(), places, compute_mode="donot_use_mm_for_euclid_dist").argmin(1)
        for some in points.split(CHUNK)
    ]
    return torch.cat(nearest)


def _assign(
    points: Float64[np.ndarray, "n d"], centers: Float64[np.ndarray, "k d"]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance to the nearest centre, and its index."""
    if points.shape[1] > 1:
        # in two dimensions and with 1024 centres a tree is ten times as fast as all distances
        distances, nearest = KDTree(centers).query(points, workers=-1)
        return np.asarray(distances), np.asarray(nearest, dtype=np.int64)
    order = np.argsort(centers[:, 0], kind="stable")
    line = centers[order, 0]
    place = np.searchsorted((line[1:] + line[:-1]) / 2, points[:, 0])
    return np.abs(points[:, 0] - line[place]), order[place]


def _kmeans_line(ordered: Float64[np.ndarray, "n"], k: int) -> Float64[np.ndarray, "k"]:
    """Run k-means on a line, over all points: clusters are ranges of the sorted values."""
    sums = np.concatenate([[0.0], np.cumsum(ordered)])
    centers = _seed_line(ordered, k)
    for _ in range(LINE_ITERATIONS):
        cuts = np.searchsorted(ordered, (centers[1:] + centers[:-1]) / 2)
        first, last = np.append(0, cuts), np.append(cuts, len(ordered))
        counts = last - first
        full = counts > 0
        moved = np.where(full, (sums[last] - sums[first]) / np.maximum(counts, 1), centers)
        # prefix sums have rounding errors: keep each mean within its cluster
        low, high = ordered[np.minimum(first, len(ordered) - 1)], ordered[np.maximum(last - 1, 0)]
        moved = np.where(full, np.clip(moved, low, high), moved)
        if not full.all():  # unused centres go to the points farthest from theirs
            ends = np.concatenate([low[full], high[full]])
            distances = np.abs(ends - np.tile(moved[full], 2))
            worst = np.argsort(-distances, kind="stable")[: (~full).sum()]
            worst = worst[distances[worst] > 0]
            moved[np.flatnonzero(~full)[: len(worst)]] = ends[worst]
        moved = np.sort(moved)
        if np.array_equal(moved, centers):
            break
        centers = moved
    return centers


def _seed_line(ordered: Float64[np.ndarray, "n"], k: int) -> Float64[np.ndarray, "k"]:
    """Return centres spread with the cube root of the density: optimal for many centres.

    (Panter and Dite 1951)
    """
    if ordered[0] == ordered[-1]:
        return np.full(k, ordered[0])
    bins = min(BINS, max(k, len(ordered) // BIN_POINTS))
    counts, edges = np.histogram(ordered, bins=bins)
    share = np.concatenate([[0.0], np.cumsum(np.cbrt(counts))])
    return np.interp((np.arange(k) + 0.5) / k * share[-1], share, edges)


def _kmeans_space(
    points: Float64[np.ndarray, "n d"], k: int, generator: torch.Generator
) -> Float64[np.ndarray, "k d"]:
    """Run Lloyd's algorithm on a sample, then a few iterations on all points."""
    order = torch.randperm(len(points), generator=generator).numpy()
    sample = points[order[:LLOYD_POINTS]]
    centers = _seed_space(sample[:SEED_POINTS], k, generator)
    for iteration in range(SAMPLE_ITERATIONS + FULL_ITERATIONS):
        seen = sample if iteration < SAMPLE_ITERATIONS else points
        distances, nearest = _assign(seen, centers)
        counts = np.bincount(nearest, minlength=k)
        sums = np.stack(
            [np.bincount(nearest, weights=column, minlength=k) for column in seen.T], axis=1
        )
        moved = np.where(counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], centers)
        empty = np.flatnonzero(counts == 0)
        if len(empty):  # unused centres go to the points farthest from theirs
            worst = np.argsort(-distances, kind="stable")[: len(empty)]
            worst = worst[distances[worst] > 0]
            moved[empty[: len(worst)]] = seen[worst]
        if np.array_equal(moved, centers) and seen is points:
            break
        centers = moved
    return centers


def _seed_space(
    points: Float64[np.ndarray, "n d"], k: int, generator: torch.Generator
) -> Float64[np.ndarray, "k d"]:
    """Seed by k-means++ (Arthur and Vassilvitskii 2007); copies once every point is a centre."""
    draws = torch.rand(k, generator=generator, dtype=torch.float64).numpy()
    centers = np.repeat(points[:1], k, axis=0)
    distances = np.full(len(points), np.inf)
    for i in range(1, k):
        distances = np.minimum(distances, ((points - centers[i - 1]) ** 2).sum(1))
        total = np.cumsum(distances)
        if total[-1] == 0:
            break
        chosen = np.searchsorted(total, draws[i] * total[-1], side="right")
        centers[i] = points[min(chosen, len(points) - 1)]
    return centers
