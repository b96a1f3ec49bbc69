"""Vectors cut into short sub-vectors, each one replaced by the nearest entry of a codebook."""

from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.nn.functional import embedding, normalize

from mobilegs.compress.float16 import round_half
from mobilegs.errors import InputError
from mobilegs.kmeans import kmeans, nearest_centers

Attribute = Literal["scale", "rotation", "appearance", "opacity", "lobes"]
SIZE_MAX = 4096  # entries of one codebook: indices take 12 bits, coder tables 14


@dataclass(frozen=True)
class Cut:
    """How an attribute is cut: `count` sub-vectors of `length` numbers each."""

    count: int
    length: int


# the cut of the lobes' latents is the scene's own, and the last two need not be there
CUTS: dict[Attribute, Cut] = {
    "scale": Cut(3, 1),  # log-scales
    "rotation": Cut(2, 2),  # (w, x), (y, z) of the canonical quaternion
    "appearance": Cut(3, 2),  # (s0, s1), (s2, v0), (v1, v2) of the static and view latents
    "opacity": Cut(1, 1),  # the base opacity's logit; the paper stores none
}


@dataclass(frozen=True)
class CodebookSizes:
    """Entries of each attribute's codebooks, at most 4096."""

    scale: int = 64
    """For each of the three log-scales."""
    rotation: int = 512
    """For each half of the quaternion."""
    appearance: int = 1024
    """For each of three pairs of the six latent numbers of the colour."""
    opacity: int = 64
    """For the base opacity, which all lobes start from."""

    def __post_init__(self) -> None:
        for name in CUTS:
            if not 1 <= getattr(self, name) <= SIZE_MAX:
                raise InputError(
                    f"the {name} codebook cannot have {getattr(self, name)} entries: "
                    f"choose 1 to {SIZE_MAX}"
                )


def canonical_quats(quats: Float[Tensor, "n 4"]) -> Float[Tensor, "n 4"]:
    """The same rotations as unit quaternions (wxyz) with w >= 0; differentiable.

    q and -q are one rotation: with the sign fixed, codebook entries serve half a sphere.
    """
    unit = normalize(quats, dim=1)
    return torch.where(unit[:, :1] < 0, -unit, unit)


def look_up(
    centers: Float[Tensor, "s k length"], indices: Int[Tensor, "n s"]
) -> Float[Tensor, "n d"]:
    """The vectors that `indices` stand for, d = s * length; differentiable to the centres."""
    count, size, length = centers.shape
    starts = torch.arange(count, device=indices.device) * size
    entries, rows = centers.reshape(-1, length), indices.long() + starts
    if centers.is_cuda:
        return embedding(rows, entries).flatten(1)  # its backward pass sorts: no atomics
    # on the CPU its backward pass takes fourteen times as long as this one's
    return entries.index_select(0, rows.reshape(-1)).reshape(len(rows), count * length)


class SubVectorCodebooks(nn.Module):
    """An attribute `[n, s * length]` held as `s` codebooks and one index per row in each.

    Attributes:
        centers: the codebooks' entries, `[s, k, length]`, a parameter.
        indices: which entry each row takes from each book, `[n, s]`, a buffer.
    """

    indices: Tensor

    def __init__(self, centers: Float[Tensor, "s k length"], indices: Int[Tensor, "n s"]) -> None:
        super().__init__()
        self.centers = nn.Parameter(centers.detach().clone())
        self.register_buffer("indices", indices.detach().long())

    @classmethod
    def fit(
        cls,
        values: Float[Tensor, "n d"],
        *,
        length: int,
        size: int,
        generator: torch.Generator,
        weights: Float[Tensor, "n"] | None = None,
    ) -> "SubVectorCodebooks":
        """Codebooks of `size` entries for `values`, by k-means on each sub-vector.

        `weights` (>= 0) say how much an error of each row matters: the rows that k-means sees
        are drawn by them.

        Raises:
            InputError: `values` has no rows, or some that are not finite.
        """
        seen = values
        if weights is not None:
            chances = weights.double().cpu().cumsum(0)
            draws = torch.rand(len(values), generator=generator, dtype=torch.float64)
            rows = torch.searchsorted(chances, draws * chances[-1]).clamp_max(len(values) - 1)
            seen = values[rows.to(values.device)]
        pairs = [kmeans(part, size, generator=generator) for part in seen.split(length, dim=1)]
        books = cls(
            torch.stack([centers for centers, _ in pairs]),
            torch.zeros(len(values), len(pairs), dtype=torch.long, device=values.device),
        )
        books.reassign(values)  # to the centres as they are stored
        return books

    @property
    def stored_centers(self) -> Float[Tensor, "s k length"]:
        """The centres rounded to half precision, with the gradient of the unrounded ones."""
        return round_half(self.centers)

    def forward(
        self, rows: Bool[Tensor, "n"] | Int[Tensor, "m"] | slice | None = None
    ) -> Float[Tensor, "m d"]:
        """The values as the file will hold them, of all rows or of those that `rows` picks."""
        indices = self.indices if rows is None else self.indices[rows]
        return look_up(self.stored_centers, indices)

    @torch.no_grad()
    def reassign(self, values: Float[Tensor, "n d"]) -> None:
        """Give every row the entries nearest to its new value."""
        parts = values.split(self.centers.shape[2], dim=1)
        found = [
            nearest_centers(part, centers)
            for part, centers in zip(parts, self.stored_centers, strict=True)
        ]
        self.indices = torch.stack(found, dim=1)

    def select(self, rows: Bool[Tensor, "n"] | Int[Tensor, "m"]) -> None:
        """Keep only the rows that `rows` picks; the centres stay."""
        self.indices = self.indices[rows]


def apparent_size(log_scales: Float[Tensor, "n 3"]) -> Float[Tensor, "n"]:
    """Fourth root of each Gaussian's largest cross-section, relative to the largest of all.

    Large Gaussians are few, and an error of theirs covers the picture (docs/negative_results.md).
    """
    area = log_scales.sum(1) - log_scales.amin(1)
    return (0.25 * (area - area.max())).exp()
