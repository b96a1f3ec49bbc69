"""Choice of the position grid by the errors in training images."""

import torch

from mobilegs.mgs.positions import PositionGrid
from mobilegs.train.student.position_grid import choose_grid, pixels_per_unit
from tests.support.scenes import camera

VIEWS = [view.to("cpu", torch.float32) for view in (camera(400, 300), camera(800, 600))]


def points(count: int = 500) -> torch.Tensor:
    return torch.randn(count, 3, generator=torch.Generator().manual_seed(0))


def moved(frame: PositionGrid, means: torch.Tensor) -> float:
    """Return the error of stored means in pixels, root mean square over both views."""
    squares, seen = torch.zeros(()), 0
    for view in VIEWS:
        places = []
        for where in (means.double(), frame.world(frame.store(means)).double()):
            seen_from = where @ view.viewmat[:3, :3].double().T + view.viewmat[:3, 3]
            on_screen = seen_from @ view.K.double().T
            places.append(on_screen[:, :2] / on_screen[:, 2:])
        inside = (places[0] > 0).all(1) & (places[0] < torch.tensor([view.width, view.height])).all(
            1
        )
        squares = squares + (places[1] - places[0])[inside].square().sum()
        seen += int(inside.sum())
    return float((squares / seen).sqrt())


def test_grids_are_as_coarse_as_the_error_allows() -> None:
    means = points()
    exponents = []
    for error in (0.3, 0.1, 0.05):
        frame = choose_grid(means, VIEWS, error)
        exponents.append(frame.exponent)
        assert moved(frame, means) <= 1.2 * error
        coarser = PositionGrid(frame.center, frame.radius, frame.exponent + 1)
        assert moved(coarser, means) > 0.8 * error
    assert exponents == sorted(exponents, reverse=True) and len(set(exponents)) == 3


def test_an_impossible_error_takes_the_finest_grid_and_a_large_one_the_coarsest() -> None:
    assert choose_grid(points(), VIEWS, 1e-9).exponent == 0
    assert choose_grid(points(), VIEWS, 1e9).exponent == 14


def test_gaussians_that_no_camera_sees_do_not_count() -> None:
    behind = points(50) + 20 * torch.nn.functional.normalize(VIEWS[0].position, dim=0)
    assert (pixels_per_unit(behind, VIEWS[:1]) == 0).all()
    assert choose_grid(behind, VIEWS[:1], 0.05).exponent == 14
