"""Reading compressed `.ply`."""

import logging
import re
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.ply_compressed import CHUNK
from mobilegs.spherical_harmonics import C0
from tests.support.random_scenes import error_message, matched, max_error

OTHERS = Path(__file__).parent / "other_tools"
THEIRS = OTHERS / "theirs.compressed.ply"  # of splat-transform: twelve Gaussians in a chunk
HEAD, END, BODY = THEIRS.read_bytes().partition(b"end_header\n")
BOUNDS, WORDS, SH = BODY[:72], BODY[72:264], BODY[264:]


def joined(
    head: bytes = HEAD, bounds: bytes = BOUNDS, words: bytes = WORDS, sh: bytes = SH
) -> bytes:
    return head + END + bounds + words + sh


def counted(chunks: int, vertices: int) -> bytes:
    """Return the header with other numbers of rows."""
    head = HEAD.replace(b"chunk 1\n", b"chunk %d\n" % chunks)
    return re.sub(rb"(vertex|sh) 12\n", rb"\1 %d\n" % vertices, head)


def test_a_file_of_splat_transform_is_read_as_by_itself() -> None:
    found, back = read_ply(THEIRS), read_ply(THEIRS.with_name(f"{THEIRS.name}.back.ply"))
    for name, value in found.tensors().items():
        assert torch.equal(value, back.tensors()[name]), name
    made = read_ply(OTHERS / "scene.ply")
    assert max_error(matched(found, made).means, made.means) < 0.01


def test_the_other_byte_order_is_read(tmp_path: Path) -> None:
    head = HEAD.replace(b"little", b"big")
    bounds, words = (np.frombuffer(part, "<u4").byteswap().tobytes() for part in (BOUNDS, WORDS))
    (tmp_path / "big.ply").write_bytes(joined(head, bounds, words))
    found = read_ply(tmp_path / "big.ply").tensors()
    for name, value in read_ply(THEIRS).tensors().items():
        assert torch.equal(found[name], value), name


def test_chunks_have_their_own_bounds_and_those_that_are_not_finite_are_dropped(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path, head = tmp_path / "scene.ply", counted(2, 300)
    moved = np.frombuffer(BOUNDS, "<f4").copy()
    moved[[0, 3]] += 1
    path.write_bytes(joined(head, BOUNDS + moved.tobytes(), 25 * WORDS, 25 * SH))
    found, expected = read_ply(path).means, read_ply(THEIRS).means.repeat(25, 1)
    assert torch.equal(found[:CHUNK], expected[:CHUNK])
    assert max_error(found[CHUNK:], expected[CHUNK:] + torch.tensor([1.0, 0, 0])) < 1e-6
    moved[0] = np.nan
    path.write_bytes(joined(head, BOUNDS + moved.tobytes(), 25 * WORDS, 25 * SH))
    with caplog.at_level(logging.WARNING):
        assert len(read_ply(path)) == CHUNK
    assert "44 of 300 Gaussians" in caplog.text


def test_colours_without_bounds_lie_between_0_and_1(tmp_path: Path) -> None:
    head = re.sub(rb"property float (min|max)_[rgb]\n", b"", HEAD)
    (tmp_path / "old.ply").write_bytes(joined(head, BOUNDS[:48]))
    red = torch.tensor([word >> 24 for word in np.frombuffer(WORDS, "<u4")[3::4].tolist()])
    found = read_ply(tmp_path / "old.ply").sh[:, 0, 0]
    assert max_error(found, (red / 255 - 0.5) / C0) < 1e-6


def test_an_empty_compressed_scene_is_read(tmp_path: Path) -> None:
    (tmp_path / "none.ply").write_bytes(joined(counted(0, 0), b"", b"", b""))
    assert len(read_ply(tmp_path / "none.ply")) == 0


def test_double_bounds_and_more_sh_rows_than_vertices_are_read(tmp_path: Path) -> None:
    head = HEAD.replace(b"property float", b"property double").replace(b"sh 12\n", b"sh 13\n")
    wide, path = np.frombuffer(BOUNDS, "<f4").astype("<f8"), tmp_path / "wide.ply"
    path.write_bytes(joined(head, wide.tobytes(), sh=SH + bytes(45)))
    assert torch.equal(read_ply(path).means, read_ply(THEIRS).means)
    wide[[0, 3]] = 1e300  # infinite as float32
    path.write_bytes(joined(head, wide.tobytes(), sh=SH + bytes(45)))
    with pytest.raises(InputError, match="no Gaussian that can be drawn"):
        read_ply(path)


INVALID = {
    "cut off": (joined()[:-1], "cut off"),
    "a huge count": (joined(HEAD.replace(b"vertex 12\n", b"vertex 999999999999999\n")), "cut off"),
    "too few chunks": (joined(HEAD.replace(b"chunk 1\n", b"chunk 0\n")), "only 0 chunks"),
    "half the colours": (joined(HEAD.replace(b" min_g", b" min_q")), "its chunks lack bounds"),
    "floats for words": (joined(HEAD.replace(b"uint", b"float")), "as uint"),
    "a wrong SH name": (joined(HEAD.replace(b"f_rest_8\n", b"f_rest_99\n")), "do not fit"),
    "SH of 16 bits": (joined(HEAD.replace(b"uchar", b"ushort"), sh=2 * SH), "not uchar"),
    "too few SH rows": (joined(HEAD.replace(b"sh 12\n", b"sh 11\n")), "do not fit"),
    "in text": (joined(HEAD.replace(b"binary_little_endian", b"ascii")), "as text"),
}


@pytest.mark.parametrize("case", INVALID)
def test_an_invalid_compressed_file_raises_a_one_line_error(case: str, tmp_path: Path) -> None:
    data, words = INVALID[case]
    assert words in error_message(read_ply, tmp_path / "bad.ply", data)
