"""MCMC: copies, relocation, budget, noise."""

import math

import pytest
import torch

from mobilegs.train.optim import NamedAdam
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.init import gaussians_at
from mobilegs.train.teacher.mcmc import Mcmc, split_copies

CONFIG = DensifyConfig("mcmc", start=0.0, min_interval=10)


def optimiser(count: int, opacity: float = 0.5) -> NamedAdam:
    """Gaussians at random, all momentum 1."""
    points = torch.randn(count, 3, generator=torch.Generator().manual_seed(1))
    made = gaussians_at(points, torch.rand(count, 3), opacity=opacity, sh_degree=0)
    adam = NamedAdam(made.tensors(), dict.fromkeys(made.tensors(), 0.0))
    for tensor in adam.tensors.values():
        tensor.grad = torch.ones_like(tensor)
    adam.step()
    return adam


def strategy(max_splats: int) -> Mcmc:
    return Mcmc(CONFIG, steps=100, max_splats=max_splats)


def defined(opacity: float, scale: float, copies: int) -> tuple[float, float]:
    """Eq. 9 of the paper, sum by sum."""
    after = 1 - (1 - opacity) ** (1 / copies)
    total = sum(
        math.comb(i - 1, k) * (-1) ** k / math.sqrt(k + 1) * after ** (k + 1)
        for i in range(1, copies + 1)
        for k in range(i)
    )
    return after, scale * opacity / total


@pytest.mark.parametrize("copies", [1, 2, 3, 10, 51])
def test_copies_have_the_opacity_and_size_of_the_paper(copies: int) -> None:
    opacities = torch.tensor([0.006, 0.1, 0.5, 0.9, 0.99, 0.9999])
    scales = torch.tensor([[0.5, 1.0, 2.0]]).expand(6, 3)
    faint, small = split_copies(opacities, scales, torch.full((6,), copies))
    for row, opacity in enumerate(opacities.tolist()):
        after, scale = defined(opacity, 1.0, copies)
        assert faint[row].item() == pytest.approx(after, rel=1e-5)
        assert small[row].tolist() == pytest.approx([0.5 * scale, scale, 2 * scale], rel=1e-5)


def test_dead_gaussians_move_to_living_ones(generator: torch.Generator) -> None:
    adam = optimiser(12)
    with torch.no_grad():
        adam.tensors["logit_opacities"][:4] = -6
    before = {name: tensor.detach().clone() for name, tensor in adam.tensors.items()}
    with torch.no_grad():
        strategy(12)._relocate(adam, generator)
    assert adam.tensors["means"].shape == (12, 3)
    assert torch.equal(adam.tensors["means"][4:], before["means"][4:])
    distance = torch.cdist(adam.tensors["means"][:4].detach(), before["means"][4:])
    assert (distance.amin(1) == 0).all()
    moments = adam.adam.state[adam.tensors["means"]]["exp_avg"]
    for row, source in enumerate((distance.argmin(1) + 4).tolist()):
        for name in ("quats", "log_scales", "logit_opacities", "sh"):
            assert torch.equal(adam.tensors[name][row], adam.tensors[name][source]), name
        assert adam.tensors["logit_opacities"][source] < before["logit_opacities"][source]
        assert (moments[row] == 0).all() and (moments[source] == 0).all()
    others = torch.ones(12, dtype=torch.bool)
    others[:4], others[distance.argmin(1) + 4] = False, False
    assert others.any() and (moments[others] != 0).all()


@pytest.mark.parametrize("dead", [0, 12])
def test_without_dead_or_living_gaussians_none_moves(dead: int, generator) -> None:
    adam = optimiser(12)
    with torch.no_grad():
        adam.tensors["logit_opacities"][:dead] = -9
    before = adam.tensors["means"].detach().clone()
    with torch.no_grad():
        strategy(12)._relocate(adam, generator)
    assert torch.equal(adam.tensors["means"], before)


def test_the_number_grows_by_a_twentieth_up_to_the_budget(generator: torch.Generator) -> None:
    adam, moves = optimiser(100), strategy(112)
    counts = []
    for step in range(1, 61):
        moves.after_step(step, adam, generator)
        counts.append(len(adam.tensors["means"]))
    assert counts[8:40:10] == [100, 105, 110, 112] and counts[-1] == 112
    moves.after_step(90, adam, generator)
    assert all(tensor.is_leaf for tensor in adam.tensors.values())


def test_nothing_is_moved_after_the_stop(generator: torch.Generator) -> None:
    adam, moves = optimiser(100), strategy(200)
    for step in (84, 90, 100):
        moves.after_step(step, adam, generator)
    assert len(adam.tensors["means"]) == 100


def test_noise_moves_only_faint_gaussians_along_their_covariance(
    generator: torch.Generator,
) -> None:
    adam = optimiser(4000)
    half = 2**-0.5
    with torch.no_grad():
        adam.tensors["means"].zero_()
        adam.tensors["log_scales"][:] = torch.tensor([0.2, 0.01, 0.1]).log()
        adam.tensors["quats"][:] = torch.tensor([half, 0, 0, half])  # x turns to y
        adam.tensors["logit_opacities"][:2000] = -12.0
        adam.tensors["logit_opacities"][2000:] = 0.0
    adam.set_lr("means", 1e-5)
    with torch.no_grad():
        strategy(4000)._add_noise(adam, generator)
    moved = adam.tensors["means"].detach()
    assert (moved[2000:].abs() < 1e-12).all()
    # 5e5 x 1e-5 x variance x sigmoid(100 x 0.005) for an opacity of nothing
    gate = torch.sigmoid(torch.tensor(0.5)).item()
    expected = [5 * gate * s * s for s in (0.01, 0.2, 0.1)]
    assert moved[:2000].std(0).tolist() == pytest.approx(expected, rel=0.08)
