"""The order of training views."""

import pytest

from mobilegs.train.stage import view_order


def test_every_pass_shows_every_view_once_in_another_order() -> None:
    order = view_order(5, 0, 15, seed=1)
    passes = [order[:5], order[5:10], order[10:]]
    assert all(sorted(p) == [0, 1, 2, 3, 4] for p in passes)
    assert len({tuple(p) for p in passes}) > 1


@pytest.mark.parametrize("first", [0, 3, 5, 13])
def test_the_view_order_does_not_depend_on_its_first_index(first: int) -> None:
    assert view_order(5, first, 9, seed=1) == view_order(5, 0, 40, seed=1)[first : first + 9]
