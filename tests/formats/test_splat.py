"""Reading `.splat`: rows by formula, comparison with splat-transform, invalid files."""

import logging
import math
from pathlib import Path

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.splat import read_splat
from mobilegs.spherical_harmonics import C0
from tests.support.format_files import encode_splat
from tests.support.random_scenes import error_message, max_error, random_scene, rotation_error

OTHERS = Path(__file__).parent / "other_tools"


def test_rows_are_read_within_their_precision(tmp_path: Path) -> None:
    made = random_scene(500, 0)
    made.sh.clamp_(-1.7, 1.7)  # a byte holds colours in [0, 1]
    (tmp_path / "scene.splat").write_bytes(encode_splat(made).tobytes())
    found = read_splat(tmp_path / "scene.splat")
    assert torch.equal(found.means, made.means)
    assert max_error(found.log_scales, made.log_scales) < 2e-6
    assert max_error(found.opacities, made.opacities) <= 0.5 / 255 + 1e-6
    assert max_error(found.sh, made.sh) <= 0.5 / 255 / C0 + 1e-6
    # half a step per component, a whole one where 1 would be 256; then normalised
    assert rotation_error(found, made) < 2 * math.sqrt(3 * 0.5**2 + 1) / 128


def test_splat_transform_reads_the_same_values() -> None:
    ours, theirs = read_splat(OTHERS / "rows.splat"), read_ply(OTHERS / "rows.splat.back.ply")
    assert torch.equal(ours.means, theirs.means)
    assert max_error(ours.log_scales, theirs.log_scales) < 1e-6
    assert max_error(ours.logit_opacities, theirs.logit_opacities) < 1e-6
    assert max_error(ours.sh, theirs.sh) < 1e-6
    # it decodes a byte as b / 127.5 - 1, the format's author as b / 128 - 1
    assert rotation_error(ours, theirs) < 2 * 2 / 128


def test_scales_of_zero_and_quaternions_of_zero_become_finite(tmp_path: Path) -> None:
    rows = encode_splat(random_scene(2, 0))
    rows["scale"][0], rows["rotation"][1], rows["color"][:, 3] = 0, 128, [0, 255]
    (tmp_path / "scene.splat").write_bytes(rows.tobytes())
    found = read_splat(tmp_path / "scene.splat")
    assert all(bool(value.isfinite().all()) for value in found.tensors().values())
    assert found.quats[1].tolist() == [1, 0, 0, 0]
    assert found.scales[0].max() < 1e-20


def test_rows_that_are_not_finite_are_dropped_and_counted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rows = encode_splat(random_scene(5, 0))
    rows["mean"][1, 2], rows["scale"][3] = math.nan, [math.inf, math.nan, 1]
    (tmp_path / "scene.splat").write_bytes(rows.tobytes())
    with caplog.at_level(logging.WARNING):
        assert len(read_splat(tmp_path / "scene.splat")) == 3
    assert "2 of 5 Gaussians" in caplog.text


def test_an_invalid_file_raises_a_one_line_error(tmp_path: Path) -> None:
    path = tmp_path / "bad.splat"
    assert "is empty" in error_message(read_splat, path, b"")
    assert "not rows of 32" in error_message(read_splat, path, bytes(33))
    with pytest.raises(InputError, match="cannot read"):
        read_splat(tmp_path / "missing.splat")
    with pytest.raises(InputError, match="cannot read"):
        read_splat(tmp_path)
