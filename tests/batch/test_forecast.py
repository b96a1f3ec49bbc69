"""The forecast of time, hours and cost."""

import pytest

from mobilegs.batch.forecast import Effort, Share, forecast
from mobilegs.batch.task import Stage

SHARES: dict[Stage, Share] = {
    "fetch": Share(1, 0),
    "poses": Share(4, 0),
    "train": Share(2, 1),
    "export": Share(1, 0),
}


def test_there_is_none_before_every_stage_was_seen() -> None:
    rows = [Effort(taken={"train": 100.0}, open=["export"]), Effort(open=["train", "export"])]
    assert forecast(rows, SHARES, 8, 1) is None


def test_rows_take_as_long_as_the_first_ones() -> None:
    done = Effort(taken={"train": 100.0, "export": 10.0})
    waiting = [Effort(open=["train", "export"]) for _ in range(3)]
    found = forecast([done, *waiting], SHARES, cores=8, gpus=1)
    assert found is not None
    assert found.seconds_left == pytest.approx(300)  # on the GPU, one after the other
    assert found.gpu_hours == pytest.approx(400 / 3600)
    assert found.core_hours == pytest.approx(4 * (200 + 10) / 3600)
    found = forecast([done, *waiting], SHARES, cores=8, gpus=10)
    assert found is not None and found.seconds_left == pytest.approx(110)  # a whole row


def test_trainings_take_time_by_their_steps_and_running_ones_less() -> None:
    done = Effort(size=50.0, taken={"train": 100.0, "export": 10.0})
    large = Effort(size=200.0, open=["train", "export"], elapsed=150.0)
    found = forecast([done, large], SHARES, cores=8, gpus=1)
    assert found is not None and found.seconds_left == pytest.approx(250 + 10)
    assert found.gpu_hours == pytest.approx(500 / 3600)


def test_trainings_of_other_groups_take_the_mean() -> None:
    one = Effort("capture steps", 50.0, taken={"train": 100.0, "export": 10.0})
    two = Effort("scene ", 1.0, taken={"train": 300.0, "export": 10.0})
    open_rows = [Effort("scene ", 1.0, open=["export"]), Effort("photos minutes", 5.0)]
    open_rows[1].open = ["train"]
    found = forecast([one, two, *open_rows], SHARES, cores=8, gpus=1)
    assert found is not None and found.seconds_left == pytest.approx(200)


def test_lost_tries_count_and_finished_lists_have_no_time_left() -> None:
    rows = [Effort(taken={"train": 100.0}, lost=(20.0, 10.0))]
    found = forecast(rows, SHARES, cores=8, gpus=1)
    assert found is not None and found.seconds_left == 0
    assert found.core_hours == pytest.approx(220 / 3600)
    assert found.gpu_hours == pytest.approx(110 / 3600)
