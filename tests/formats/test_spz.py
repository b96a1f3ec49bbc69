"""Reading `.spz`: files of splat-transform, files of every version, damaged files."""

import math
import struct
import subprocess
import zlib
from pathlib import Path

import pytest
import torch

from mobilegs.cli.main import main
from mobilegs.errors import InputError
from mobilegs.formats.spz import read_spz
from mobilegs.gaussians import Gaussians
from mobilegs.scene_file import inspect_scene, open_scene
from mobilegs.view.poster import posters_of
from tests.support.node import WEB, node_program
from tests.support.random_scenes import error_message

COUNT = 60
WRITE = """
import { writeFileSync } from "node:fs";
import { example, gzippedSpz } from "./plain.js";
const [path, version, degree] = process.argv.slice(1);
writeFileSync(path, gzippedSpz(example(+degree), +version, +degree));
"""


def expected(degree: int) -> Gaussians:
    """The Gaussians of tests/web/plain.js, by the same formula."""

    def waves(first: int, number: int) -> torch.Tensor:
        rows = [
            [math.sin(1 + 7.3 * i + 2.1 * k * k) for k in range(first, first + number)]
            for i in range(COUNT)
        ]
        return torch.tensor(rows, dtype=torch.float64)

    number = (degree + 1) ** 2
    sh = torch.cat([1.5 * waves(30, 3), 0.4 * waves(40, 3 * (number - 1))], dim=1)
    return Gaussians(
        means=3 * waves(0, 3),
        quats=torch.nn.functional.normalize(waves(10, 4), dim=1),
        log_scales=-2 + 2.5 * waves(4, 3),
        logit_opacities=4 * waves(20, 1)[:, 0],
        sh=sh.unflatten(1, (number, 3))[:, :16],
    )


def compare(found: Gaussians, degree: int, *, position: float, rotation: float, sh: float) -> None:
    made = expected(degree)
    torch.testing.assert_close(found.means.double(), made.means, atol=position, rtol=0)
    torch.testing.assert_close(found.log_scales.double(), made.log_scales, atol=0.5 / 16, rtol=0)
    opacities = found.logit_opacities.double().sigmoid()
    torch.testing.assert_close(opacities, made.logit_opacities.sigmoid(), atol=0.5 / 254, rtol=0)
    same = (found.quats.double() * made.quats).sum(1).abs()  # up to the sign
    assert (same > 1 - rotation).all()
    torch.testing.assert_close(
        found.sh[:, 0].double(), made.sh[:, 0].clamp(-1 / 0.3, 1 / 0.3), atol=0.5 / 38, rtol=0
    )
    torch.testing.assert_close(found.sh[:, 1:].double(), made.sh[:, 1:], atol=sh, rtol=0)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory):
    """Return a function that writes a file of a given version and degree."""
    folder = tmp_path_factory.mktemp("spz")

    def make(version: int, degree: int) -> Path:
        path = folder / f"v{version}_{degree}.spz"
        command = [node_program(), "--input-type=module", "-e", WRITE, path]
        subprocess.run([*command, str(version), str(degree)], check=True, cwd=WEB)
        return path

    return make


@pytest.mark.parametrize("name", ["spz_v3.spz", "spz_v4.spz"])
def test_files_of_splat_transform_are_read(name: str) -> None:
    # it rounds SH above degree 0 to steps of 1/8
    compare(read_spz(WEB / name), 3, position=2**-12, rotation=1e-5, sh=0.067)


@pytest.mark.parametrize("version", [1, 2, 3])
@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4])
def test_every_version_and_degree_is_read(made, version: int, degree: int) -> None:
    found = read_spz(made(version, degree))
    assert found.sh_degree == min(degree, 3)
    compare(
        found,
        degree,
        position=2e-3 if version == 1 else 2**-12,
        rotation=1e-5 if version == 3 else 2e-2,  # a small w is imprecise
        sh=0.5 / 127,
    )


def test_an_spz_can_be_opened_inspected_and_rendered(capsys: pytest.CaptureFixture[str]) -> None:
    path = WEB / "spz_v4.spz"
    scene = open_scene(path, torch.device("cpu"))
    assert scene.blend == "sorted" and len(scene.gaussians) == COUNT
    assert inspect_scene(path)["sh_degree"] == 3
    assert posters_of(path).preview.size == (1200, 630)
    assert main(["info", str(path)]) == 0
    assert "60" in capsys.readouterr().out


def gzipped(data: bytes) -> bytes:
    zipper = zlib.compressobj(wbits=31)
    return zipper.compress(data) + zipper.flush()


@pytest.mark.parametrize("name", ["spz_v3.spz", "spz_v4.spz"])
def test_a_file_cut_at_any_length_raises_an_error(name: str, tmp_path: Path) -> None:
    data = (WEB / name).read_bytes()
    for length in [*range(64), *range(64, len(data), 97), len(data) - 1]:
        assert error_message(read_spz, tmp_path / "cut.spz", data[:length])


@pytest.mark.parametrize("name", ["spz_v3.spz", "spz_v4.spz"])
def test_a_file_with_a_changed_byte_is_read_or_raises_input_error(
    name: str, tmp_path: Path
) -> None:
    data, path = (WEB / name).read_bytes(), tmp_path / "changed.spz"
    for place in [*range(64), *range(64, len(data), 53)]:
        changed = bytearray(data)
        changed[place] ^= 0xFF
        path.write_bytes(changed)
        try:
            found = read_spz(path)
        except InputError:
            continue
        assert all(tensor.isfinite().all() for tensor in found.tensors().values())


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
    assert "damaged" in error_message(read_spz, path, gzipped(head(version=1) + nan + bytes(10)))
    missing = tmp_path / "missing.spz"
    with pytest.raises(InputError, match="cannot read"):
        read_spz(missing)
