"""View dependence: opacity and weight of a Gaussian as functions of the viewing direction."""

from dataclasses import dataclass
from typing import Literal, get_args

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import pad

from mobilegs.render.lobes import constant_lobes
from mobilegs.representation.codebooks import Cut
from mobilegs.representation.lobes import LATENTS_MAX, LobeDecoder, LobeShape
from mobilegs.spherical_harmonics import C0
from mobilegs.validation import DEGREE, Range, check, check_choice

ViewKind = Literal["constant", "network", "latent"]
KINDS: tuple[ViewKind, ...] = get_args(ViewKind)
HIDDEN = 16  # width of the network of `latent`
SUBVECTOR_LENGTH = 2  # latents that share a codebook entry, with `nvq`
CODEBOOK_SIZE = 64  # entries of each of these codebooks
LOGIT_MAX = 8.0  # larger logits of a teacher would only stretch the codebook


@dataclass(frozen=True)
class ViewDependence:
    """Representation of opacity and phi, which are functions of the viewing direction.

    | kind | opacity and phi |
    |---|---|
    | `constant` | one opacity per Gaussian, phi = 1 |
    | `network` | the paper's network, evaluated for every view |
    | `latent` | lobes, decoded once from latents and the Gaussian's other attributes |

    Lobes are spherical harmonics of the direction. With `blend=sorted` phi is not used and learns
    nothing.
    """

    kind: ViewKind = "latent"
    """`constant`, `network` or `latent`."""
    degree: int = 2
    """Degree of the lobes, 0 to 3."""
    latents: int = 13
    """Values stored per Gaussian with `latent`, 1 to 32. One is the base opacity. The others are at
    most as many as a lobe has, rounded up to an even number."""
    start_opacity: float = 0.0
    """Opacity of all Gaussians at the start, below 1; 0 keeps the teacher's. (The paper: 0.5. With
    `lr.opacities=0` only the network makes opacities differ, as in the paper.)"""

    def __post_init__(self) -> None:
        check_choice("kind", self.kind, ViewKind)
        check(
            self,
            degree=DEGREE,
            latents=Range(1, LATENTS_MAX),
            start_opacity=Range(high=1.0, below=True),
        )

    @property
    def shape(self) -> LobeShape | None:
        """Shape of the lobe decoder; None for `constant` and `network`, which have none."""
        if self.kind != "latent":
            return None
        count = min(self.latents - 1, 2 * (self.degree + 1) ** 2 - 1)
        count = -(-count // SUBVECTOR_LENGTH) * SUBVECTOR_LENGTH
        return LobeShape(self.degree, count, (HIDDEN,))

    @property
    def cut(self) -> Cut | None:
        """Sub-vectors of the latents' codebooks; None without latents."""
        count = self.shape.latents if self.shape else 0
        return Cut(count // SUBVECTOR_LENGTH, SUBVECTOR_LENGTH) if count else None


@torch.no_grad()
def constant_decoder(
    shape: LobeShape, logits: Float[Tensor, "n"], generator: torch.Generator
) -> tuple[LobeDecoder, Float[Tensor, "n"]]:
    """Return a decoder of lobes that are the same in every direction, and its base logits.

    With latents of 0 it gives the opacities of `logits`, and phi = 1. Its basis is random.
    """
    lobes = constant_lobes(logits)
    decoder = LobeDecoder(shape, generator).to(logits.device)
    # the mean of equal numbers, and a product with 1 / C0 and C0, so that runs of before have
    # the same bits
    rows = pad(lobes, (0, 0, 0, shape.outputs // 2 - 1)).flatten(1)
    decoder.bias[1:].copy_(rows.mean(0)[1:])
    return decoder, C0 * lobes[:, 0, 0]
