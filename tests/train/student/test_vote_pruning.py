"""Pruning by votes: criteria, counts and schedule."""

from itertools import pairwise

import pytest
import torch

from mobilegs.train.student.vote_pruning import VoteConfig, VoteCounter, vote
from mobilegs.train.times import Times

CPU = torch.device("cpu")


def test_votes_go_against_gaussians_that_are_faint_and_small() -> None:
    opacities = torch.linspace(0.1, 1, 10)
    scales = torch.ones(10, 3)
    scales[[0, 9]] = 0.1  # small: the faintest and the most opaque
    assert vote(opacities, scales, quantile=0.2).tolist() == [True, *[False] * 9]


def test_the_largest_axis_decides() -> None:
    opacities = torch.linspace(0.1, 1, 10)
    scales = torch.full((10, 3), 0.1)
    scales[:, 2] = torch.linspace(1, 2, 10).flip(0)
    assert not vote(opacities, scales, quantile=0.2).any()


@pytest.mark.parametrize("count", [1, 7, 100])
@pytest.mark.parametrize("quantile", [0.0, 0.2, 1.0])
def test_quantiles_match_torch(count: int, quantile: float) -> None:
    values = torch.randn(count, generator=torch.Generator().manual_seed(count))
    scales = values.exp()[:, None].expand(count, 3)
    expected = values < values.quantile(quantile)
    # both criteria are equal here
    assert torch.equal(vote(values, scales, quantile=quantile), expected)


def test_a_vote_on_no_gaussians_is_empty() -> None:
    assert vote(torch.zeros(0), torch.zeros(0, 3), quantile=0.2).shape == (0,)


def test_the_share_is_of_the_votes_held() -> None:
    votes = VoteCounter(VoteConfig(), Times(300), 3, CPU)
    for round_ in range(5):
        votes.add(torch.tensor([round_ < 3, round_ < 4, False]))
    assert votes.kept().tolist() == [True, False, True]  # 3 of 5 is not more than 0.6


def test_a_new_interval_starts_without_votes() -> None:
    votes = VoteCounter(VoteConfig(), Times(300), 3, CPU)
    votes.add(torch.ones(3, dtype=torch.bool))
    votes.reset(2)
    assert votes.kept().tolist() == [True, True] and votes.held == 0


@pytest.mark.parametrize("steps", [60, 30_000])
def test_prunings_scale_with_the_length_of_the_run(steps: int) -> None:
    votes = VoteCounter(VoteConfig(), Times(steps), 1, CPU)
    prunings = [step for step in range(1, steps + 1) if votes.prunes_after(step)]
    assert len(prunings) == pytest.approx(24, abs=1)
    assert prunings[0] == pytest.approx(steps / 30, abs=1)
    assert prunings[-1] == pytest.approx(0.8 * steps, abs=steps / 30)


def test_a_quantile_of_0_holds_no_votes() -> None:
    votes = VoteCounter(VoteConfig(quantile=0.0), Times(30), 1, CPU)
    assert not any(votes.votes_at(step) for step in range(1, 31))
    assert votes.kept().all()


def test_a_longer_run_keeps_the_votes_of_an_interval() -> None:
    times = Times(3000)
    votes = VoteCounter(VoteConfig(votes_per_interval=10), times, 1, CPU)
    times.set_steps(9000, 1550)  # in the middle of an interval
    held = [step for step in range(1, 9001) if votes.votes_at(step)]
    prunings = [step for step in range(1, 9001) if votes.prunes_after(step)]
    ends = [0, *prunings]
    assert [sum(a < step <= b for step in held) for a, b in pairwise(ends)] == [10] * 24
    assert prunings[14] == 1500 and prunings[15] == 1550 + round(50 * 7450 / 1450)
