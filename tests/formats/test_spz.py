"""Reading and writing `.spz`: every version, other tools' files and values, invalid files."""

import gzip
import json
import math
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.spz import SH_SIGNS, read_spz, write_spz
from mobilegs.gaussians import Gaussians
from mobilegs.render import Footprint
from mobilegs.scene_file import inspect_scene, open_scene
from mobilegs.spherical_harmonics import C0
from tests.support.random_scenes import error_message, max_error, random_scene, rotation_error

OTHERS = Path(__file__).parent / "other_tools"


def rotated(scene: Gaussians) -> Gaussians:
    """Convert between RDF and RUB axes: half a turn around x."""
    means = scene.means * torch.tensor([1.0, -1, -1])
    quats = scene.quats * torch.tensor([1.0, 1, -1, -1])
    sh = scene.sh.clone()
    sh[:, 1:] *= torch.from_numpy(SH_SIGNS[: sh.shape[1] - 1])[:, None]
    return Gaussians(means, quats, scene.log_scales, scene.logit_opacities, sh)


def test_version_1_has_positions_of_half_precision_and_degree_4_is_left_out(tmp_path: Path) -> None:
    data = gzip.decompress((OTHERS / "spz_js.spz").read_bytes())
    head, rest, sh = data[:16], data[16 + 9 * 12 : -45 * 12], data[-45 * 12 :]
    assert struct.unpack_from("<IIB", head, 4) == (2, 12, 3)
    whole = read_spz(OTHERS / "spz_js.spz")
    halves = rotated(whole).means.numpy().astype("<f2").tobytes()
    wide = np.frombuffer(sh, "u1").reshape(12, 45).repeat([1] * 44 + [28], axis=1).tobytes()
    first = head[:4] + struct.pack("<IIB", 1, 12, 4) + head[13:]
    (tmp_path / "old.spz").write_bytes(gzip.compress(first + halves + rest + wide))
    found = read_spz(tmp_path / "old.spz")
    torch.testing.assert_close(found.means, whole.means, rtol=2**-11, atol=1e-6)
    for name in ("quats", "log_scales", "logit_opacities", "sh"):
        assert torch.equal(found.tensors()[name], whole.tensors()[name]), name


def gzipped(data: bytes) -> bytes:
    zipper = zlib.compressobj(wbits=31)
    return zipper.compress(data) + zipper.flush()


def test_an_invalid_header_raises_a_one_line_error(tmp_path: Path) -> None:
    path = tmp_path / "bad.spz"

    def head(version: int = 2, count: int = 1, degree: int = 0, fraction: int = 12) -> bytes:
        return b"NGSP" + struct.pack("<IIBBBB", version, count, degree, fraction, 0, 0)

    assert "not an .spz" in error_message(read_spz, path, b"something else entirely")
    assert "not an .spz" in error_message(read_spz, path, gzipped(b"something else entirely"))
    assert "version 9" in error_message(read_spz, path, gzipped(head(version=9)))
    assert "damaged" in error_message(read_spz, path, gzipped(head(version=4) + bytes(16)))
    assert "announces 4000000000" in error_message(
        read_spz, path, gzipped(head(count=4_000_000_000))
    )
    assert "cut off" in error_message(read_spz, path, gzipped(head(count=9_000_000)))
    assert "more than the 1" in error_message(read_spz, path, gzipped(head() + bytes(10**7)))
    assert "damaged" in error_message(read_spz, path, gzipped(head(degree=5)))
    nan = struct.pack("<3e", 0, math.nan, 0)
    assert "drawn" in error_message(read_spz, path, gzipped(head(version=1) + nan + bytes(10)))
    with pytest.raises(InputError, match="cannot read"):
        read_spz(tmp_path / "missing.spz")


@pytest.mark.parametrize(("degree", "size"), [(0, 1.0), (3, 1e-3), (3, 1e3)])
def test_a_written_scene_is_read_back_within_its_precision(
    degree: int, size: float, tmp_path: Path
) -> None:
    made = random_scene(400, degree)
    made.means *= size
    write_spz(tmp_path / "scene.spz", made)
    found = read_spz(tmp_path / "scene.spz")
    most = float(made.means.abs().max())
    whole = math.frexp(most)[1]
    bits = min(23 - whole, max(12, 16 - whole))
    assert max_error(found.means, made.means) <= 0.5 * 2.0**-bits + 1e-7 * most
    assert max_error(found.log_scales, made.log_scales) <= 0.5 / 16 + 1e-6
    assert max_error(found.opacities, made.opacities) <= 0.5 / 255 + 1e-6
    assert (
        max_error(found.sh[:, 0], made.sh[:, 0].clamp(-1 / 0.3, 1 / 0.3)) <= 0.5 / 255 / 0.15 + 1e-6
    )
    rest = made.sh[:, 1:].clamp(-1, 127 / 128)
    if degree > 0:
        assert max_error(found.sh[:, 1:4], rest[:, :3]) <= 1 / 32 + 1e-6
    if degree > 1:
        assert max_error(found.sh[:, 4:], rest[:, 3:]) <= 1 / 16 + 1e-6
    # half a step for each of three components, and their effect on the largest (at least 1/2)
    assert rotation_error(found, made) <= 2 * math.sqrt(3) * 0.5 / 511 * math.sqrt(0.5) + 1e-6


def test_splat_transform_reads_the_same_values_after_half_a_turn() -> None:
    """splat-transform uses the axes of `.ply` in `.spz`, unlike Niantic's code."""
    for name in ("ours.spz", "theirs.spz", "theirs_v3.spz"):
        ours, theirs = read_spz(OTHERS / name), rotated(read_ply(OTHERS / f"{name}.back.ply"))
        for part in ("means", "log_scales", "quats"):
            assert max_error(ours.tensors()[part], theirs.tensors()[part]) < 1e-6
        assert max_error(ours.opacities, theirs.opacities) < 2e-6
        assert max_error(ours.sh, theirs.sh) < 1e-6
    one, other = read_spz(OTHERS / "ours.spz"), rotated(read_spz(OTHERS / "theirs_v3.spz"))
    assert rotation_error(one, other) < 1e-6
    assert max_error(one.means, other.means) <= 2**-12  # both round
    assert torch.equal(one.log_scales, other.log_scales)
    assert torch.equal(one.logit_opacities, other.logit_opacities)
    assert max_error(one.sh, other.sh) <= 1 / 8  # one step: it rounds twice


@pytest.mark.parametrize("name", ["ours.spz", "spz_js.spz"])
def test_niantics_code_reads_the_same_values(name: str) -> None:
    """Compare our file of version 3, and a file of version 2 from spz-js."""
    parts = json.loads((OTHERS / f"{name}.niantic.json").read_text())
    theirs = {part: torch.tensor(numbers).reshape(12, -1) for part, numbers in parts.items()}
    ours = rotated(read_spz(OTHERS / name))  # into the axes of the file
    assert max_error(ours.means, theirs["positions"]) < 1e-6
    assert max_error(ours.scales, theirs["scales"]) < 1e-6
    assert max_error(ours.opacities, theirs["alphas"][:, 0]) < 1e-6
    assert max_error(0.5 + C0 * ours.sh[:, 0], theirs["colors"]) < 1e-6
    assert max_error(ours.sh[:, 1:].flatten(1), theirs["sh"]) < 1e-6
    quats = theirs["rotations"][:, [3, 0, 1, 2]]
    assert max_error(ours.quats * (ours.quats * quats).sum(1, keepdim=True).sign(), quats) < 1e-6


def test_a_file_of_spz_js_is_read() -> None:
    """spz-js keeps the axes of the `.ply`, too, so the scene is rotated."""
    found, made = rotated(read_spz(OTHERS / "spz_js.spz")), read_ply(OTHERS / "scene.ply")
    assert max_error(found.means, made.means) <= 2**-12
    assert max_error(found.log_scales, made.log_scales) <= 1 / 32 + 1e-6
    assert max_error(found.sh[:, 1:], made.sh[:, 1:].clamp(-1, 1)) <= 1 / 8
    assert rotation_error(found, made) < 0.1  # three bytes; a small w is imprecise


def test_the_writer_still_makes_the_committed_file(tmp_path: Path) -> None:
    write_spz(tmp_path / "ours.spz", read_ply(OTHERS / "scene.ply"))
    committed = gzip.decompress((OTHERS / "ours.spz").read_bytes())
    assert gzip.decompress((tmp_path / "ours.spz").read_bytes()) == committed


def test_the_header_has_version_3_and_an_empty_scene_is_read(tmp_path: Path) -> None:
    write_spz(tmp_path / "none.spz", random_scene(0, 2))
    head = gzip.decompress((tmp_path / "none.spz").read_bytes())
    assert head[:4] == b"NGSP" and struct.unpack_from("<IIB", head, 4) == (3, 0, 2)
    assert len(read_spz(tmp_path / "none.spz")) == 0


def test_extreme_values_stay_finite_and_infinite_ones_are_dropped(tmp_path: Path) -> None:
    made = random_scene(4, 1)
    made.logit_opacities[:2] = torch.tensor([-200.0, 200.0])
    made.log_scales[0], made.sh[1] = -300, 1e29
    made.means[3, 0] = math.nan
    write_spz(tmp_path / "scene.spz", made)
    found = read_spz(tmp_path / "scene.spz")
    assert len(found) == 3
    assert found.opacities[0] < 1e-5 and found.opacities[1] > 1 - 1e-5
    assert found.log_scales[0].tolist() == [-10.0] * 3


def test_a_gaussian_that_is_too_far_away_raises_an_error_and_leaves_no_file(tmp_path: Path) -> None:
    made = random_scene(2, 0)
    made.means[0, 0] = 1e8
    with pytest.raises(InputError, match="too far away"):
        write_spz(tmp_path / "far.spz", made)
    assert not list(tmp_path.iterdir())
    made.means[0, 0] = 8e6
    write_spz(tmp_path / "far.spz", made)
    assert abs(float(read_spz(tmp_path / "far.spz").means[0, 0]) - 8e6) <= 1


def test_the_flag_of_antialiased_scenes_is_read_and_written(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path, gaussians = tmp_path / "scene.spz", random_scene(30, 1)
    for footprint in (Footprint(), Footprint(antialiased=True)):
        write_spz(path, gaussians, footprint=footprint)
        head = gzip.decompress(path.read_bytes())[:16]
        assert head[14] == footprint.antialiased
        assert open_scene(path).footprint == footprint
    assert inspect_scene(path)["gaussians"] == 30
    assert not caplog.text
    write_spz(path, gaussians, footprint=Footprint(0.1, antialiased=True))
    assert "no place for the blur 0.1" in caplog.text
