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


def test_a_generator_continues_its_sequence(tmp_path: Path) -> None:
    generator = torch.Generator().manual_seed(3)
    torch.rand(5, generator=generator)
    write_state(tmp_path / "c", {"generator": generator.get_state()})
    expected = torch.rand(4, generator=generator)
    other = torch.Generator()
    other.set_state(read_state(tmp_path / "c")["generator"])
    assert torch.equal(torch.rand(4, generator=other), expected)


def test_views_of_one_tensor_are_saved_separately(tmp_path: Path) -> None:
    whole = torch.arange(4.0)
    write_state(tmp_path / "c", {"a": whole, "b": whole[1:3]})
    assert read_state(tmp_path / "c")["b"].tolist() == [1, 2]


@pytest.mark.parametrize("keep", [0, 5, 100, -1])
def test_a_truncated_checkpoint_is_refused(tmp_path: Path, keep: int) -> None:
    write_state(tmp_path / "c", STATE)
    (tmp_path / "c").write_bytes((tmp_path / "c").read_bytes()[:keep])
    with pytest.raises(InputError, match="not a complete checkpoint"):
        read_state(tmp_path / "c")


def test_a_foreign_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "c").write_bytes(b"ply\nformat ascii 1.0\n" * 20)
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
