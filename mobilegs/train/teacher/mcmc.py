"""A budget of Gaussians that move to where they are needed (3DGS as Markov Chain Monte Carlo,
Kheradmand et al. 2024)."""

from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.gaussians import Gaussians
from mobilegs.render.project import rotation_matrices
from mobilegs.train.optim import NamedAdam
from mobilegs.train.teacher.densify import DensifyConfig, Fixed, Schedule
from mobilegs.validation import FRACTION, NOT_NEGATIVE, check

COPIES_MAX = 51  # of one Gaussian at a time, itself included
GATE = 100.0  # steepness of the noise's gate on opacity


@dataclass(frozen=True)
class McmcConfig:
    """How `mcmc` moves Gaussians; times are fractions of the run."""

    stop: float = 25 / 30
    """When the last ones are moved and added (25,000 of 30,000)."""
    growth: float = 0.05
    """Share by which their number grows each time, up to max_splats."""
    dead_opacity: float = 0.005
    """Gaussians no more opaque than this move to where others are, and noise sets in there."""
    noise: float = 5e5
    """Length of the centres' random steps, in their rates and variances."""
    opacity_weight: float = 0.01
    """What the mean opacity adds to the loss."""
    scale_weight: float = 0.01
    """What the mean scale, in world units, adds to the loss."""

    def __post_init__(self) -> None:
        numbers = ("growth", "noise", "opacity_weight", "scale_weight")
        check(
            self,
            **dict.fromkeys(numbers, NOT_NEGATIVE),
            **dict.fromkeys(("stop", "dead_opacity"), FRACTION),
        )


class Mcmc(Fixed):
    """Relocates the faint, grows up to the budget, lets centres wander."""

    def __init__(
        self, config: DensifyConfig, more: McmcConfig, *, steps: int, max_splats: int
    ) -> None:
        """Schedules are those of a run of `steps`."""
        self.schedule = Schedule.of(config, steps)
        self.more, self.max_splats = more, max_splats
        self.stop = round(more.stop * steps)

    def regulariser(self, gaussians: Gaussians) -> Float[Tensor, ""]:
        """Small and faint is cheap, so that what is not needed dies and can move."""
        opacity = self.more.opacity_weight * gaussians.opacities.mean()
        return opacity + self.more.scale_weight * gaussians.scales.mean()

    @torch.no_grad()
    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Relocate and grow now and then, wander always."""
        when = self.schedule
        if when.start < step < self.stop and step % when.interval == 0:
            self._relocate(adam, generator)
            self._grow(adam, generator)
        self._wander(adam, generator)

    def _relocate(self, adam: NamedAdam, generator: torch.Generator) -> None:
        opacities = adam.tensors["logit_opacities"].sigmoid()
        dead = opacities <= self.more.dead_opacity
        if not dead.any() or dead.all():
            return
        alive = torch.where(dead, 0.0, opacities)
        copies = self._copies(adam, alive, int(dead.sum()), generator)
        for name, tensor in adam.tensors.items():
            tensor[dead] = copies[name]
        adam.forget(dead)

    def _grow(self, adam: NamedAdam, generator: torch.Generator) -> None:
        opacities = adam.tensors["logit_opacities"].sigmoid()
        target = min(self.max_splats, int((1 + self.more.growth) * len(opacities)))
        if target > len(opacities):
            adam.append_rows(self._copies(adam, opacities, target - len(opacities), generator))

    def _copies(
        self,
        adam: NamedAdam,
        opacities: Float[Tensor, "n"],
        number: int,
        generator: torch.Generator,
    ) -> dict[str, Tensor]:
        """Rows for `number` copies of Gaussians drawn by opacity.

        The originals become fainter and smaller with them, so that together they look as one
        did before.
        """
        weights = opacities.double().cpu()
        drawn = torch.multinomial(weights, number, replacement=True, generator=generator)
        counts = torch.bincount(drawn, minlength=len(weights))
        rows = counts.nonzero()[:, 0].to(opacities.device)
        faint, small = shared_out(
            opacities[rows], adam.tensors["log_scales"][rows].exp(), 1 + counts[counts > 0]
        )
        least = self.more.dead_opacity
        faint = faint.clamp(least, 1 - torch.finfo(faint.dtype).eps)
        adam.tensors["logit_opacities"][rows] = faint.logit()
        adam.tensors["log_scales"][rows] = small.log()
        adam.forget(rows)
        drawn = drawn.to(opacities.device)
        return {name: tensor[drawn] for name, tensor in adam.tensors.items()}

    def _wander(self, adam: NamedAdam, generator: torch.Generator) -> None:
        """Noise in the shape of each Gaussian, for those that are about to die."""
        tensors = adam.tensors
        seed = int(torch.randint(2**62, (1,), generator=generator))
        noise = torch.randn(
            tensors["means"].shape,
            generator=torch.Generator(tensors["means"].device).manual_seed(seed),
            device=tensors["means"].device,
        )
        opacities = tensors["logit_opacities"].sigmoid()
        gate = torch.sigmoid(GATE * (self.more.dead_opacity - opacities))
        length = self.more.noise * adam.rate("means") * gate
        turn = rotation_matrices(tensors["quats"])
        variances = (2 * tensors["log_scales"]).exp()[:, :, None]
        inside = variances * (turn.transpose(1, 2) @ noise[:, :, None])
        tensors["means"] += length[:, None] * (turn @ inside)[:, :, 0]


def shared_out(
    opacities: Float[Tensor, "n"], scales: Float[Tensor, "n 3"], copies: Int[Tensor, "n"]
) -> tuple[Float[Tensor, "n"], Float[Tensor, "n 3"]]:
    """Opacities and scales of so many copies that blend to what one was (Eq. 9).

    `o' = 1 - (1 - o)^(1/N)`, and `s' = s o / sum_{i<=N} sum_{k<i} C(i-1, k) (-1)^k
    o'^(k+1) / sqrt(k+1)`, where the sum over i of C(i-1, k) is C(N, k+1).
    """
    number = copies.clamp_max(COPIES_MAX).to(opacities.device).double()
    before = opacities.double()
    after = 1 - (1 - before) ** (1 / number)
    k = torch.arange(1, COPIES_MAX + 1, dtype=torch.float64, device=before.device)
    n = number[:, None]
    choose = torch.lgamma(n + 1) - torch.lgamma(k + 1) - torch.lgamma((n - k).clamp_min(0) + 1)
    signs = torch.where(k % 2 == 1, 1.0, -1.0)
    terms = signs * torch.exp(choose + k * after[:, None].log()) / k.sqrt()
    total = torch.where(k <= n, terms, 0.0).sum(1)
    return after.to(opacities.dtype), (scales.double() * (before / total)[:, None]).to(scales.dtype)
