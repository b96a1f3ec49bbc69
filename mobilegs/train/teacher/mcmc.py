"""3DGS as Markov Chain Monte Carlo (Kheradmand et al. 2024): a budget of moving Gaussians."""

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.gaussians import Gaussians
from mobilegs.render.project import rotation_matrices
from mobilegs.reproducible import sigmoid
from mobilegs.train.optim import NamedAdam
from mobilegs.train.teacher.densify import DensifyConfig, Fixed, Schedule

COPIES_MAX = 51  # of one Gaussian at a time, the original included
STOP = 25 / 30  # time at which Gaussians are moved and added for the last time
GROWTH = 0.05  # share by which the number of Gaussians grows each time, up to max_splats
DEAD_OPACITY = 0.005  # Gaussians of at most this opacity are relocated; noise acts below it
NOISE = 5e5  # of the means, relative to their learning rate and covariance
OPACITY_WEIGHT, SCALE_WEIGHT = 0.01, 0.01  # of the mean opacity and scale, in the loss
SIGMOID_SLOPE = 100.0  # of the sigmoid that limits noise to faint Gaussians


class Mcmc(Fixed):
    """Relocates faint Gaussians, grows up to the budget and adds noise to the means."""

    def __init__(self, config: DensifyConfig, *, steps: int, max_splats: int) -> None:
        """Take the schedules of a run of `steps`."""
        self.schedule = Schedule.of(config, steps)
        self.max_splats = max_splats
        self.stop = self.last_event = round(STOP * steps)

    def shorten(self, steps: int) -> None:
        """End relocation where a run of `steps` does, if that is sooner."""
        self.stop = self.last_event = min(self.stop, round(STOP * steps))

    def regularizer(self, gaussians: Gaussians) -> Float[Tensor, ""]:
        """Penalise opacity and size, so that unneeded Gaussians fade and are relocated."""
        opacity = OPACITY_WEIGHT * gaussians.opacities.mean()
        return opacity + SCALE_WEIGHT * gaussians.scales.mean()

    @torch.no_grad()
    def after_step(self, step: int, adam: NamedAdam, generator: torch.Generator) -> None:
        """Relocate and grow by the schedule, and add noise."""
        schedule = self.schedule
        if schedule.start < step < self.stop and step % schedule.interval == 0:
            self._relocate(adam, generator)
            self._grow(adam, generator)
        self._add_noise(adam, generator)

    def _relocate(self, adam: NamedAdam, generator: torch.Generator) -> None:
        opacities = sigmoid(adam.tensors["logit_opacities"])
        dead = opacities <= DEAD_OPACITY
        if not dead.any() or dead.all():
            return
        alive = torch.where(dead, 0.0, opacities)
        copies = self._duplicate(adam, alive, int(dead.sum()), generator)
        for name, tensor in adam.tensors.items():
            tensor[dead] = copies[name]
        adam.reset_moments(dead)

    def _grow(self, adam: NamedAdam, generator: torch.Generator) -> None:
        opacities = sigmoid(adam.tensors["logit_opacities"])
        target = min(self.max_splats, int((1 + GROWTH) * len(opacities)))
        if target > len(opacities):
            adam.append_rows(self._duplicate(adam, opacities, target - len(opacities), generator))

    def _duplicate(
        self,
        adam: NamedAdam,
        opacities: Float[Tensor, "n"],
        number: int,
        generator: torch.Generator,
    ) -> dict[str, Tensor]:
        """Return rows for `number` copies of Gaussians, sampled in proportion to `opacities`.

        Originals and copies become fainter and smaller, so that together they render like the
        original did.
        """
        weights = opacities.double().cpu()
        drawn = torch.multinomial(weights, number, replacement=True, generator=generator)
        counts = torch.bincount(drawn, minlength=len(weights))
        rows = counts.nonzero()[:, 0].to(opacities.device)
        faint, small = split_copies(
            opacities[rows], adam.tensors["log_scales"][rows].exp(), 1 + counts[counts > 0]
        )
        least = DEAD_OPACITY
        faint = faint.clamp(least, 1 - torch.finfo(faint.dtype).eps)
        adam.tensors["logit_opacities"][rows] = faint.logit()
        adam.tensors["log_scales"][rows] = small.log()
        adam.reset_moments(rows)
        drawn = drawn.to(opacities.device)
        return {name: tensor[drawn] for name, tensor in adam.tensors.items()}

    def _add_noise(self, adam: NamedAdam, generator: torch.Generator) -> None:
        """Move faint Gaussians at random, in proportion to their covariance."""
        tensors = adam.tensors
        seed = int(torch.randint(2**62, (1,), generator=generator))
        noise = torch.randn(
            tensors["means"].shape,
            generator=torch.Generator(tensors["means"].device).manual_seed(seed),
            device=tensors["means"].device,
        )
        opacities = sigmoid(tensors["logit_opacities"])
        gate = sigmoid(SIGMOID_SLOPE * (DEAD_OPACITY - opacities))
        length = NOISE * adam.lr("means") * gate
        turn = rotation_matrices(tensors["quats"])
        variances = (2 * tensors["log_scales"]).exp()[:, :, None]
        inside = variances * (turn.transpose(1, 2) @ noise[:, :, None])
        tensors["means"] += length[:, None] * (turn @ inside)[:, :, 0]


def split_copies(
    opacities: Float[Tensor, "n"], scales: Float[Tensor, "n 3"], copies: Int[Tensor, "n"]
) -> tuple[Float[Tensor, "n"], Float[Tensor, "n 3"]]:
    """Return opacities and scales at which `copies` Gaussians blend like one (Eq. 9).

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
