"""Reading `.splat`: comparison with splat-transform, special values, invalid files."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest
import torch
from torch.nn.functional import normalize

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.splat import ROW, read_splat
from tests.support.random_scenes import error_message, max_error

THEIRS = Path(__file__).parent / "other_tools" / "rows.splat"


def test_splat_transform_reads_the_same_values_except_for_rotations() -> None:
    ours, theirs = read_splat(THEIRS), read_ply(THEIRS.with_name("rows.splat.back.ply"))
    assert torch.equal(ours.means, theirs.means)
    assert max_error(ours.log_scales, theirs.log_scales) < 1e-6
    assert max_error(ours.logit_opacities, theirs.logit_opacities) < 1e-6
    assert max_error(ours.sh, theirs.sh) < 1e-6
    # it decodes a byte as b / 127.5 - 1, the format's author as b / 128 - 1
    bytes_ = torch.from_numpy(np.fromfile(THEIRS, ROW)["rotation"].astype(np.float64))
    assert max_error(ours.quats, normalize(bytes_ / 128 - 1, dim=1)) < 1e-6


def test_scales_of_zero_become_finite_and_bad_rows_are_dropped(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rows, path = np.fromfile(THEIRS, ROW), tmp_path / "scene.splat"
    rows["scale"][0], rows["rotation"][1], rows["color"][:2, 3] = 0, 128, [0, 255]
    rows["mean"][2, 2], rows["scale"][3] = math.nan, [math.inf, math.nan, 1]
    path.write_bytes(rows.tobytes())
    with caplog.at_level(logging.WARNING):
        found = read_splat(path)
    assert len(found) == 9 and "3 of 12 Gaussians" in caplog.text
    assert all(bool(value.isfinite().all()) for value in found.tensors().values())
    assert found.scales[0].max() < 1e-20


def test_an_invalid_file_raises_a_one_line_error(tmp_path: Path) -> None:
    path = tmp_path / "bad.splat"
    assert "is empty" in error_message(read_splat, path, b"")
    assert "not rows of 32" in error_message(read_splat, path, bytes(33))
    with pytest.raises(InputError, match="cannot read"):
        read_splat(tmp_path / "missing.splat")
    with pytest.raises(InputError, match="cannot read"):
        read_splat(tmp_path)
