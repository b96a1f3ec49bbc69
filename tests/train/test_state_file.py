"""Checkpoints: exact round trip, and errors for damaged files."""

from pathlib import Path

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.train.state_file import read_state, write_state

STATE = {
    "step": 7,
    "rate": 0.1 + 0.2,
    "nothing": None,
    "nested": {"x": torch.arange(6.0).reshape(2, 3), "empty": torch.zeros(0, 3)},
    "list": [torch.tensor(3, dtype=torch.int32), 1e-300, "text", True],
}


def test_a_state_survives_bit_for_bit(tmp_path: Path) -> None:
    write_state(tmp_path / "c.safetensors", STATE)
    back = read_state(tmp_path / "c.safetensors")
    assert back["step"] == 7 and back["rate"] == 0.1 + 0.2 and back["nothing"] is None
    assert torch.equal(back["nested"]["x"], STATE["nested"]["x"])
    assert back["nested"]["empty"].shape == (0, 3)
    assert back["list"][0].dtype == torch.int32 and back["list"][1:] == [1e-300, "text", True]


def test_views_of_one_tensor_are_saved_separately(tmp_path: Path) -> None:
    whole = torch.arange(4.0)
    write_state(tmp_path / "c", {"a": whole, "b": whole[1:3]})
    assert read_state(tmp_path / "c")["b"].tolist() == [1, 2]


@pytest.mark.parametrize("keep", [0, 100, -1, "foreign"])
def test_a_file_that_is_no_complete_checkpoint_is_refused(tmp_path: Path, keep: int | str) -> None:
    write_state(tmp_path / "c", STATE)
    content = (tmp_path / "c").read_bytes()
    foreign = b"ply\nformat ascii 1.0\n" * 20
    (tmp_path / "c").write_bytes(foreign if isinstance(keep, str) else content[:keep])
    with pytest.raises(InputError, match="not a complete checkpoint"):
        read_state(tmp_path / "c")


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no checkpoint at"):
        read_state(tmp_path / "c")


def test_a_failed_save_keeps_the_previous_checkpoint(tmp_path: Path) -> None:
    write_state(tmp_path / "c", {"step": 1})
    with pytest.raises(TypeError):
        write_state(tmp_path / "c", {"step": object()})
    assert read_state(tmp_path / "c") == {"step": 1}
    assert [path.name for path in tmp_path.iterdir()] == ["c"]
