"""Votes: what is counted, and when."""

import pytest
import torch

from mobilegs.train.student.vote_pruning import Ballot, VoteConfig, vote

CPU = torch.device("cpu")


def test_only_what_is_both_faint_and_small_is_voted_against() -> None:
    opacities = torch.linspace(0.1, 1, 10)
    scales = torch.ones(10, 3)
    scales[[0, 9]] = 0.1  # small: the faintest and the surest
    assert vote(opacities, scales, quantile=0.2).tolist() == [True, *[False] * 9]


def test_the_largest_axis_decides_about_size() -> None:
    opacities = torch.linspace(0.1, 1, 10)
    scales = torch.full((10, 3), 0.1)
    scales[:, 2] = torch.linspace(1, 2, 10).flip(0)
    assert not vote(opacities, scales, quantile=0.2).any()


def test_equal_gaussians_are_never_voted_against() -> None:
    assert not vote(torch.full((9,), 0.5), torch.ones(9, 3), quantile=0.2).any()


@pytest.mark.parametrize("count", [1, 2, 7, 100])
@pytest.mark.parametrize("quantile", [0.0, 0.2, 0.5, 1.0])
def test_quantiles_are_those_of_torch(count: int, quantile: float) -> None:
    values = torch.randn(count, generator=torch.Generator().manual_seed(count))
    scales = values.exp()[:, None].expand(count, 3)
    expected = values < values.quantile(quantile)
    # both conditions are the same one here
    assert torch.equal(vote(values, scales, quantile=quantile), expected)


def test_an_empty_set_votes_for_nothing() -> None:
    assert vote(torch.zeros(0), torch.zeros(0, 3), quantile=0.2).shape == (0,)


def test_the_verdict_compares_with_the_votes_that_were_held() -> None:
    ballot = Ballot(VoteConfig(share=0.6), steps=300, count=3, device=CPU)
    for round_ in range(5):
        ballot.cast(torch.tensor([round_ < 3, round_ < 4, False]))
    assert ballot.verdict().tolist() == [True, False, True]  # 3 of 5 is not more than 0.6


def test_a_new_interval_starts_without_votes() -> None:
    ballot = Ballot(VoteConfig(), steps=300, count=3, device=CPU)
    ballot.cast(torch.ones(3, dtype=torch.bool))
    ballot.clear(2)
    assert ballot.verdict().tolist() == [True, True] and ballot.held == 0


@pytest.mark.parametrize("steps", [60, 3500, 30_000])
def test_prunings_keep_their_place_whatever_the_length(steps: int) -> None:
    ballot = Ballot(VoteConfig(), steps=steps, count=1, device=CPU)
    prunings = [step for step in range(1, steps + 1) if ballot.prunes_after(step)]
    assert len(prunings) == pytest.approx(24, abs=1)
    assert prunings[0] == pytest.approx(steps / 30, abs=1)
    assert prunings[-1] == pytest.approx(0.8 * steps, abs=steps / 30)


def test_the_papers_schedule_holds_the_votes_asked_for_in_every_interval() -> None:
    ballot = Ballot(VoteConfig(votes_per_interval=10), steps=30_000, count=1, device=CPU)
    votes = [step for step in range(1, 30_001) if ballot.votes_in(step)]
    assert votes[:3] == [100, 200, 300] and votes[-1] == 24_000


def test_no_quantile_means_no_votes() -> None:
    ballot = Ballot(VoteConfig(quantile=0.0), steps=30, count=1, device=CPU)
    assert not any(ballot.votes_in(step) for step in range(1, 31))
    assert ballot.verdict().all()


def test_a_restored_ballot_counts_on() -> None:
    first = Ballot(VoteConfig(), steps=300, count=2, device=CPU)
    first.cast(torch.tensor([True, False]))
    second = Ballot(VoteConfig(), steps=300, count=5, device=CPU)
    second.restore(first.state())
    assert second.verdict().tolist() == [False, True]
