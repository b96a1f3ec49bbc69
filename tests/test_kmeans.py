"""K-means for codebooks."""

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from mobilegs.errors import InputError
from mobilegs.kmeans import CHUNK, _nearest_of_all, kmeans, nearest_centers


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def mean_error(points: torch.Tensor, centers: torch.Tensor, nearest: torch.Tensor) -> float:
    return float((points - centers[nearest]).square().sum(1).mean())


@pytest.mark.parametrize("d", [1, 3])
def test_every_point_goes_to_its_nearest_center(d: int) -> None:
    points = torch.randn(500, d, generator=seeded())
    centers, nearest = kmeans(points, 17, generator=seeded(1))
    assert torch.equal(nearest, torch.cdist(points, centers).argmin(1))


@pytest.mark.parametrize("d", [1, 2])
@pytest.mark.parametrize("count", [1, CHUNK + 7])
def test_what_a_gpu_does_finds_the_same_centers(d: int, count: int) -> None:
    points = torch.randn(count, d, generator=seeded())
    centers = torch.randn(64, d, generator=seeded(1))
    assert torch.equal(_nearest_of_all(points, centers), nearest_centers(points, centers))


def test_the_error_on_a_line_is_near_the_optimal_quantiser_of_a_gaussian() -> None:
    points = torch.randn(100_000, 1, generator=seeded())
    centers, nearest = kmeans(points, 16, generator=seeded())
    assert mean_error(points, centers, nearest) == pytest.approx(0.009497, rel=0.03)  # Max 1960


def test_the_error_in_a_plane_is_near_the_hexagonal_bound() -> None:
    points = torch.rand(200_000, 2, generator=seeded())
    centers, nearest = kmeans(points, 256, generator=seeded())
    hexagonal = 0.1604 / 256  # second moment of hexagons that tile the unit square
    assert hexagonal * 0.99 < mean_error(points, centers, nearest) < hexagonal * 1.08


def test_the_same_seed_gives_the_same_centers() -> None:
    points = torch.randn(3000, 2, generator=seeded())
    one, other = (kmeans(points, 40, generator=seeded(5)) for _ in range(2))
    assert torch.equal(one[0], other[0]) and torch.equal(one[1], other[1])


@settings(deadline=None, max_examples=60)
@given(
    st.lists(st.sampled_from([-2.0, 0.0, 0.5, 7.0, 1e4]), min_size=1, max_size=40),
    st.integers(1, 2),
    st.integers(1, 12),
)
def test_as_many_centers_as_distinct_points_leave_no_error(
    values: list[float], d: int, k: int
) -> None:
    points = torch.tensor(values)[:, None].expand(-1, d).contiguous()
    centers, nearest = kmeans(points, k, generator=seeded())
    assert centers.shape == (k, d) and centers.isfinite().all()
    if k >= len(set(values)):
        assert mean_error(points, centers, nearest) == 0


def test_every_center_is_used_when_there_are_enough_points() -> None:
    points = torch.cat([torch.zeros(20_000, 2), torch.randn(600, 2, generator=seeded())])
    _, nearest = kmeans(points, 256, generator=seeded())
    assert len(nearest.unique()) == 256


@pytest.mark.parametrize("bad", [torch.zeros(0, 2), torch.tensor([[1.0], [torch.nan]])])
def test_nothing_and_not_a_number_are_refused(bad: torch.Tensor) -> None:
    with pytest.raises(InputError):
        kmeans(bad, 4, generator=seeded())
