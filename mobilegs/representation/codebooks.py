"""Product quantisation: vectors cut into sub-vectors, each the nearest entry of a codebook."""

from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.nn.functional import embedding, normalize

from mobilegs.errors import InputError
from mobilegs.kmeans import kmeans, nearest_centers
from mobilegs.representation.float16 import round_float16

Attribute = Literal["scale", "rotation", "appearance", "opacity", "lobes"]
SIZE_MAX = 4096  # entries of one codebook: indices take 12 bits, coder tables 14


@dataclass(frozen=True)
class Cut:
    """The cut of an attribute: `count` sub-vectors of `length` numbers each."""

    count: int
    length: int


# `lobes` has the scene's own cut; `opacity` and `lobes` may be missing
CUTS: dict[Attribute, Cut] = {
    "scale": Cut(3, 1),  # log-scales
    "rotation": Cut(2, 2),  # (w, x), (y, z) of the canonical quaternion
    "appearance": Cut(3, 2),  # (s0, s1), (s2, v0), (v1, v2) of the static and view latents
    "opacity": Cut(1, 1),  # the base opacity's logit (this project; the paper stores none)
}
# one codebook for all three scales, and one for the quaternion
JOINT_CUTS: dict[Attribute, Cut] = {**CUTS, "scale": Cut(1, 3), "rotation": Cut(1, 4)}


@dataclass(frozen=True)
class CodebookSizes:
    """Number of entries in each codebook of an attribute, 1 to 4096."""

    scale: int = 64
    """Of each of three codebooks, one per log-scale, or of one for all."""
    rotation: int = 512
    """Of each of two codebooks, one per half of the quaternion, or of one for all."""
    appearance: int = 1024
    """Of each of three codebooks, one per pair of the colour's six latents."""
    opacity: int = 64
    """Of the codebook of base opacities."""
    joint_shapes: bool = False
    """One codebook for the three log-scales and one for the quaternion: with the three pairs of
    colour latents they are the paper's five groups. False cuts them into three and two parts, as
    the release does."""

    weight_by_size: bool = True
    """Weight the k-means of scales by the apparent size of the Gaussians. The paper does not."""

    @property
    def cuts(self) -> dict[Attribute, Cut]:
        """The cut of each attribute but `lobes`."""
        return JOINT_CUTS if self.joint_shapes else CUTS

    def __post_init__(self) -> None:
        for name in CUTS:
            if not 1 <= getattr(self, name) <= SIZE_MAX:
                raise InputError(
                    f"the {name} codebook cannot have {getattr(self, name)} entries: "
                    f"choose 1 to {SIZE_MAX}"
                )


def canonical_quats(quats: Float[Tensor, "n 4"]) -> Float[Tensor, "n 4"]:
    """Return the same rotations as unit quaternions (wxyz) with w >= 0; differentiable.

    q and -q are the same rotation: with a fixed sign, codebooks cover half of the sphere.
    """
    unit = normalize(quats, dim=1)
    return torch.where(unit[:, :1] < 0, -unit, unit)


def gather_entries(
    centers: Float[Tensor, "s k length"], indices: Int[Tensor, "n s"]
) -> Float[Tensor, "n d"]:
    """Return the vectors that `indices` stand for, d = s * length; differentiable in `centers`."""
    count, size, length = centers.shape
    starts = torch.arange(count, device=indices.device) * size
    entries, rows = centers.reshape(-1, length), indices.long() + starts
    if centers.is_cuda:
        return embedding(rows, entries).flatten(1)  # its backward pass uses no atomics
    # on the CPU the backward pass of `embedding` takes 14 times as long
    return entries.index_select(0, rows.reshape(-1)).reshape(len(rows), count * length)


class SubVectorCodebooks(nn.Module):
    """An attribute `[n, s * length]` as `s` codebooks and an index per row and codebook.

    Attributes:
        centers: entries of the codebooks, `[s, k, length]`, a parameter.
        indices: entry of each row in each codebook, `[n, s]`, a buffer.
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
        """Return codebooks of `size` entries for `values`, from k-means on each sub-vector.

        `weights` (>= 0) are the importance of each row's error: k-means runs on rows drawn in
        proportion to them.

        Raises:
            InputError: `values` has no rows, or is not finite.
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
        books.reassign(values)  # to the rounded centres
        return books

    @property
    def stored_centers(self) -> Float[Tensor, "s k length"]:
        """The centres rounded to float16; the gradient is the identity's."""
        return round_float16(self.centers)

    def forward(
        self, rows: Bool[Tensor, "n"] | Int[Tensor, "m"] | slice | None = None
    ) -> Float[Tensor, "m d"]:
        """Return the dequantised values of `rows` (None: all), as a file holds them."""
        indices = self.indices if rows is None else self.indices[rows]
        return gather_entries(self.stored_centers, indices)

    @torch.no_grad()
    def reassign(self, values: Float[Tensor, "n d"]) -> None:
        """Assign every row the entries nearest to its new value."""
        parts = values.split(self.centers.shape[2], dim=1)
        columns = [
            nearest_centers(part, centers)
            for part, centers in zip(parts, self.stored_centers, strict=True)
        ]
        self.indices = torch.stack(columns, dim=1)

    def select(self, rows: Bool[Tensor, "n"] | Int[Tensor, "m"]) -> None:
        """Keep only the rows that `rows` picks; the centres stay."""
        self.indices = self.indices[rows]


def apparent_size(log_scales: Float[Tensor, "n 3"]) -> Float[Tensor, "n"]:
    """Return the fourth root of each Gaussian's largest cross-section, relative to the maximum.

    As weights of k-means they protect large Gaussians, which are few and cover many pixels
    (docs/explanation/negative_results.md).
    """
    area = log_scales.sum(1) - log_scales.amin(1)
    return (0.25 * (area - area.max())).exp()
