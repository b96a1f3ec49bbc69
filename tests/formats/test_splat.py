"""antimatter15's `.splat`: rows by formula, another program's view of them, damaged files."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.splat import ROW, read_splat
from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import C0
from tests.support.plain import plain_scene, refusal_of, turn_between, worst

OTHERS = Path(__file__).parent / "other_tools"


def rows_of(scene: Gaussians) -> np.ndarray:
    """As the format's own converter writes them."""
    rows = np.zeros(len(scene), ROW)
    rows["mean"], rows["scale"] = scene.means, scene.scales
    rows["color"][:, :3] = ((0.5 + C0 * scene.sh[:, 0]) * 255).round().clamp(0, 255)
    rows["color"][:, 3] = (scene.opacities * 255).round()
    rows["rotation"] = (scene.quats * 128 + 128).round().clamp(0, 255)
    return rows


def test_rows_are_read_within_their_bytes(tmp_path: Path) -> None:
    made = plain_scene(500, 0)
    made.sh.clamp_(-1.7, 1.7)  # a byte has colours from 0 to 1
    (tmp_path / "scene.splat").write_bytes(rows_of(made).tobytes())
    found = read_splat(tmp_path / "scene.splat")
    assert torch.equal(found.means, made.means)
    assert worst(found.log_scales, made.log_scales) < 2e-6
    assert worst(found.opacities, made.opacities) <= 0.5 / 255 + 1e-6
    assert worst(found.sh, made.sh) <= 0.5 / 255 / C0 + 1e-6
    # half a step each, a whole one where 1 would be 256; and the length is made one again
    assert turn_between(found, made) < 2 * math.sqrt(3 * 0.5**2 + 1) / 128


def test_another_program_reads_the_same() -> None:
    ours, theirs = read_splat(OTHERS / "rows.splat"), read_ply(OTHERS / "rows.splat.back.ply")
    assert torch.equal(ours.means, theirs.means)
    assert worst(ours.log_scales, theirs.log_scales) < 1e-6
    assert worst(ours.logit_opacities, theirs.logit_opacities) < 1e-6
    assert worst(ours.sh, theirs.sh) < 1e-6
    # it takes the byte b for b / 127.5 - 1, the format's author for b / 128 - 1
    assert turn_between(ours, theirs) < 2 * 2 / 128


def test_scales_of_zero_and_rotations_of_nothing_are_finite(tmp_path: Path) -> None:
    rows = rows_of(plain_scene(2, 0))
    rows["scale"][0], rows["rotation"][1], rows["color"][:, 3] = 0, 128, [0, 255]
    (tmp_path / "scene.splat").write_bytes(rows.tobytes())
    found = read_splat(tmp_path / "scene.splat")
    assert all(bool(value.isfinite().all()) for value in found.tensors().values())
    assert found.quats[1].tolist() == [1, 0, 0, 0]
    assert found.scales[0].max() < 1e-20


def test_rows_that_are_not_finite_are_left_out_and_counted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rows = rows_of(plain_scene(5, 0))
    rows["mean"][1, 2], rows["scale"][3] = math.nan, [math.inf, math.nan, 1]
    (tmp_path / "scene.splat").write_bytes(rows.tobytes())
    with caplog.at_level(logging.WARNING):
        assert len(read_splat(tmp_path / "scene.splat")) == 3
    assert "2 of 5 Gaussians are not finite" in caplog.text


def test_what_is_no_splat_gets_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "bad.splat"
    assert "is empty" in refusal_of(read_splat, path, b"")
    assert "no rows of 32" in refusal_of(read_splat, path, bytes(33))
    with pytest.raises(InputError, match="cannot read"):
        read_splat(tmp_path / "missing.splat")
    with pytest.raises(InputError, match="cannot read"):
        read_splat(tmp_path)
