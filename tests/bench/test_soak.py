"""Short forms of the long tests of bench/soak."""

from pathlib import Path

import pytest

from bench.soak import server, training
from bench.soak.record import add_record


@pytest.mark.thorough
def test_a_training_that_is_killed_leaves_the_same_files(tmp_path: Path) -> None:
    found = training.soak(tmp_path, kills=1, seed=1, steps=24)
    assert found["kills"] == 1 and found["runs"] >= 1 and sum(found["killed"].values()) == 1


@pytest.mark.thorough
def test_a_server_answers_all_kinds_of_visits_and_forgets_them(tmp_path: Path) -> None:
    found = server.soak(tmp_path, visits=70, seed=1, size=1 << 20)
    assert set(found["kinds"]) == set(server.KINDS)
    assert found["after"]["threads"] <= found["before"]["threads"]
    assert found["after"]["files"] <= found["before"]["files"]
    assert found["peak"]["memory_mib"] < found["before"]["memory_mib"] + 100


def test_figures_of_other_tests_stay(tmp_path: Path) -> None:
    path = tmp_path / "soak.json"
    add_record(path, "one", {"visits": 3})
    add_record(path, "two", {"kills": 4})
    assert '"visits": 3' in path.read_text() and '"kills": 4' in path.read_text()
