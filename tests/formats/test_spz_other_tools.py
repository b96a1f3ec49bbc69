"""`.spz` as it is written: what it keeps, and what another program reads of it."""

import gzip
import json
import math
import struct
from pathlib import Path

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.spz import SIGNS, read_spz, write_spz
from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import C0
from tests.support.plain import plain_scene, turn_between, worst

OTHERS = Path(__file__).parent / "other_tools"


def turned(scene: Gaussians) -> Gaussians:
    """Half a turn around x: what RDF calls its axes, RUB calls so."""
    means = scene.means * torch.tensor([1.0, -1, -1])
    quats = scene.quats * torch.tensor([1.0, 1, -1, -1])
    sh = scene.sh.clone()
    sh[:, 1:] *= torch.from_numpy(SIGNS[: sh.shape[1] - 1])[:, None]
    return Gaussians(means, quats, scene.log_scales, scene.logit_opacities, sh)


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_scene_survives_within_its_bits(degree: int, size: float, tmp_path: Path) -> None:
    made = plain_scene(400, degree)
    made.means *= size
    write_spz(tmp_path / "scene.spz", made)
    found = read_spz(tmp_path / "scene.spz")
    most = float(made.means.abs().max())
    whole = math.frexp(most)[1]
    bits = min(23 - whole, max(12, 16 - whole))
    assert worst(found.means, made.means) <= 0.5 * 2.0**-bits + 1e-7 * most
    assert worst(found.log_scales, made.log_scales) <= 0.5 / 16 + 1e-6
    assert worst(found.opacities, made.opacities) <= 0.5 / 255 + 1e-6
    assert worst(found.sh[:, 0], made.sh[:, 0].clamp(-1 / 0.3, 1 / 0.3)) <= 0.5 / 255 / 0.15 + 1e-6
    rest = made.sh[:, 1:].clamp(-1, 127 / 128)
    if degree > 0:
        assert worst(found.sh[:, 1:4], rest[:, :3]) <= 1 / 32 + 1e-6
    if degree > 1:
        assert worst(found.sh[:, 4:], rest[:, 3:]) <= 1 / 16 + 1e-6
    # three parts of half a step each, and what the largest, at least 1/2, makes of them
    assert turn_between(found, made) <= 2 * math.sqrt(3) * 0.5 / 511 * math.sqrt(0.5) + 1e-6


def test_another_program_reads_the_same_after_half_a_turn() -> None:
    """It takes the axes of a `.spz` for those of a `.ply`, and writes them so; Niantic does not."""
    for name in ("ours.spz", "theirs.spz", "theirs_v3.spz"):
        ours, theirs = read_spz(OTHERS / name), turned(read_ply(OTHERS / f"{name}.back.ply"))
        for part in ("means", "log_scales", "quats"):
            assert worst(ours.tensors()[part], theirs.tensors()[part]) < 1e-6
        assert worst(ours.opacities, theirs.opacities) < 2e-6
        assert worst(ours.sh, theirs.sh) < 1e-6
    one, other = read_spz(OTHERS / "ours.spz"), turned(read_spz(OTHERS / "theirs_v3.spz"))
    assert turn_between(one, other) < 1e-6
    assert worst(one.means, other.means) <= 2**-12  # both round to so much or less
    assert torch.equal(one.log_scales, other.log_scales)
    assert torch.equal(one.logit_opacities, other.logit_opacities)
    assert worst(one.sh, other.sh) <= 1 / 8  # a step: it rounds twice


@pytest.mark.parametrize("name", ["ours.spz", "spz_js.spz"])
def test_niantics_own_code_reads_the_same(name: str) -> None:
    """Of our file of version 3, and of one of version 2 that a writer in JavaScript made."""
    parts = json.loads((OTHERS / f"{name}.niantic.json").read_text())
    theirs = {part: torch.tensor(numbers).reshape(12, -1) for part, numbers in parts.items()}
    ours = turned(read_spz(OTHERS / name))  # into the axes of the file
    assert worst(ours.means, theirs["positions"]) < 1e-6
    assert worst(ours.scales, theirs["scales"]) < 1e-6
    assert worst(ours.opacities, theirs["alphas"][:, 0]) < 1e-6
    assert worst(0.5 + C0 * ours.sh[:, 0], theirs["colors"]) < 1e-6
    assert worst(ours.sh[:, 1:].flatten(1), theirs["sh"]) < 1e-6
    quats = theirs["rotations"][:, [3, 0, 1, 2]]
    assert worst(ours.quats * (ours.quats * quats).sum(1, keepdim=True).sign(), quats) < 1e-6


def test_what_a_writer_in_javascript_made_is_the_scene_itself() -> None:
    """After half a turn: it, too, leaves the axes of the `.ply` as they are."""
    found, made = turned(read_spz(OTHERS / "spz_js.spz")), read_ply(OTHERS / "scene.ply")
    assert worst(found.means, made.means) <= 2**-12
    assert worst(found.log_scales, made.log_scales) <= 1 / 32 + 1e-6
    assert worst(found.sh[:, 1:], made.sh[:, 1:].clamp(-1, 1)) <= 1 / 8
    assert turn_between(found, made) < 0.1  # three bytes; a small fourth part of what they leave


def test_what_is_written_today_is_what_the_other_program_was_given(tmp_path: Path) -> None:
    write_spz(tmp_path / "ours.spz", read_ply(OTHERS / "scene.ply"))
    committed = gzip.decompress((OTHERS / "ours.spz").read_bytes())
    assert gzip.decompress((tmp_path / "ours.spz").read_bytes()) == committed


def test_a_scene_read_and_written_again_has_the_same_bytes(tmp_path: Path) -> None:
    write_spz(tmp_path / "one.spz", plain_scene(200, 3))
    write_spz(tmp_path / "other.spz", read_spz(tmp_path / "one.spz"))
    assert (tmp_path / "one.spz").read_bytes() == (tmp_path / "other.spz").read_bytes()


def test_the_header_is_of_version_3_and_a_scene_of_nothing_is_read(tmp_path: Path) -> None:
    write_spz(tmp_path / "none.spz", plain_scene(0, 2))
    head = gzip.decompress((tmp_path / "none.spz").read_bytes())
    assert head[:4] == b"NGSP" and struct.unpack_from("<IIB", head, 4) == (3, 0, 2)
    assert len(read_spz(tmp_path / "none.spz")) == 0


def test_extremes_stay_finite_and_what_is_not_is_left_out(tmp_path: Path) -> None:
    made = plain_scene(4, 1)
    made.logit_opacities[:2] = torch.tensor([-200.0, 200.0])
    made.log_scales[0], made.sh[1] = -300, 1e30
    made.means[3, 0] = math.nan
    write_spz(tmp_path / "scene.spz", made)
    found = read_spz(tmp_path / "scene.spz")
    assert len(found) == 3
    assert found.opacities[0] < 1e-5 and found.opacities[1] > 1 - 1e-5
    assert found.log_scales[0].tolist() == [-10.0] * 3


def test_what_is_too_far_away_is_refused_and_nothing_is_left(tmp_path: Path) -> None:
    made = plain_scene(2, 0)
    made.means[0, 0] = 1e8
    with pytest.raises(InputError, match="farther away"):
        write_spz(tmp_path / "far.spz", made)
    assert not list(tmp_path.iterdir())
    made.means[0, 0] = 8e6
    write_spz(tmp_path / "far.spz", made)
    assert abs(float(read_spz(tmp_path / "far.spz").means[0, 0]) - 8e6) <= 1
