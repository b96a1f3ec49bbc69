"""Rows that cannot be drawn: one rule for all readers, the web viewer and the writers."""

import gzip
import json
import logging
import math
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.cli.main import main
from mobilegs.errors import InputError
from mobilegs.formats import WRITTEN, Kind
from mobilegs.formats.ply import read_ply
from mobilegs.formats.splat import ROW
from mobilegs.scene_file import PLAIN, WRITERS, inspect_scene, open_scene
from tests.formats.test_glb import joined, parts_of
from tests.formats.test_sog import unzipped, zipped
from tests.support.node import javascript
from tests.support.random_scenes import random_scene

OTHERS = Path(__file__).parent / "other_tools"
NAMES = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()
REST = [f"f_rest_{i}" for i in range(9)]
GOOD = dict.fromkeys([*NAMES, *REST], 0.0) | {"rot_0": 1.0, "f_dc_0": 0.5}
NAN, INF = math.nan, math.inf


def turned(length: float) -> dict[str, float]:
    return dict.fromkeys(NAMES[-4:], length / 2)


# what is changed in a good row, and whether it is kept
RULES: dict[str, tuple[dict[str, float], bool]] = {
    "a good row": ({}, True),
    "zeros": ({"rot_0": 0, "f_dc_0": 0}, False),
    "a tiny rotation": (turned(1e-11), True),
    "too tiny a rotation": (turned(1e-13), False),
    "a huge rotation": (turned(1e17), True),
    "too huge a rotation": (turned(1e19), False),
    "a rotation that is NaN": ({"rot_2": NAN}, False),
    "a mean that is NaN": ({"y": NAN}, False),
    "an infinite mean": ({"z": -INF}, False),
    "a far mean": ({"x": 1e29}, True),
    "too far a mean": ({"x": -1e31}, False),
    "a scale of 0": ({"scale_1": -INF}, True),
    "a tiny scale": ({"scale_1": -1e31}, True),
    "a large scale": ({"scale_2": 68}, True),
    "too large a scale": ({"scale_2": 70}, False),
    "an infinite scale": ({"scale_0": INF}, False),
    "a scale that is NaN": ({"scale_0": NAN}, False),
    "a faint opacity": ({"opacity": -200}, True),
    "an opacity of 0": ({"opacity": -INF}, False),
    "an opacity of 1": ({"opacity": INF}, True),
    "an opacity that is NaN": ({"opacity": NAN}, False),
    "a colour that is NaN": ({"f_dc_1": NAN}, False),
    "an infinite harmonic": ({"f_rest_4": INF}, False),
}
COUNTS = """
const { readPly } = await import(`${process.argv[1]}/load/ply.js`);
console.warn = () => {};
const files = JSON.parse(process.argv[2]).map((hex) => Uint8Array.from(Buffer.from(hex, "hex")));
const finite = ({ shapes, lobes }) => [...shapes, ...lobes].every(Number.isFinite);
console.log(JSON.stringify(files.map((bytes) => [readPly(bytes).count, finite(readPly(bytes))])));
"""


def ply_of(*rows: dict[str, float]) -> bytes:
    properties = "".join(f"property float {name}\n" for name in GOOD)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{properties}"
    table = np.array([[*(GOOD | row).values()] for row in rows], "<f4")
    return f"{head}end_header\n".encode() + table.tobytes()


def test_python_and_the_web_viewer_keep_the_same_rows(tmp_path: Path) -> None:
    files = [ply_of({}, row) for row, _ in RULES.values()]
    theirs = javascript(COUNTS, [file.hex() for file in files])
    for (name, (_, kept)), file, found in zip(RULES.items(), files, theirs, strict=True):
        (tmp_path / "scene.ply").write_bytes(file)
        read = read_ply(tmp_path / "scene.ply")
        assert (len(read), read.left_out) == ((2, 0) if kept else (1, 1)), name
        assert all(bool(value.isfinite().all()) for value in read.tensors().values()), name
        assert found == [1 + kept, True], name


def broken_glb(data: bytes) -> bytes:
    content, body = parts_of(data)
    view = content["bufferViews"][2]  # rotations
    at = view["byteOffset"]
    return joined(content, body[:at] + bytes(16) + body[at + 16 :])


def broken_sog(data: bytes) -> bytes:
    files = unzipped(data)
    meta = json.loads(files["meta.json"])
    meta["sh0"]["codebook"][1:128] = [NAN] * 127
    return zipped(files | {"meta.json": json.dumps(meta).encode()})


def broken_splat(_: bytes) -> bytes:
    rows = np.fromfile(OTHERS / "rows.splat", ROW)
    rows["rotation"][1], rows["mean"][2, 2], rows["scale"][3, 1] = 128, NAN, -1
    return rows.tobytes()


def broken_spz(_: bytes) -> bytes:
    head = b"NGSP" + struct.pack("<IIBBBB", 1, 2, 0, 12, 0, 0)
    return gzip.compress(head + struct.pack("<6e", 0, NAN, 0, 1, 2, 3) + bytes(20))


def broken_compressed(_: bytes) -> bytes:
    head, end, body = (OTHERS / "theirs.compressed.ply").read_bytes().partition(b"end_header\n")
    head = head.replace(b"chunk 1\n", b"chunk 2\n")
    for name in (b"vertex", b"sh"):
        head = head.replace(name + b" 12\n", name + b" 300\n")
    bad = np.frombuffer(body[:72], "<f4").copy()
    bad[0] = NAN
    return head + end + body[:72] + bad.tobytes() + 25 * body[72:264] + 25 * body[264:]


BROKEN: dict[str, tuple[str, Callable[[bytes], bytes]]] = {
    "plain": ("ply", lambda _: ply_of({}, {"x": NAN}, turned(0))),
    "compressed": ("ply", broken_compressed),
    "splat": ("splat", broken_splat),
    "spz": ("spz", broken_spz),
    "sog": ("sog", broken_sog),
    "glb": ("glb", broken_glb),
}
LOST = {"plain": 2, "compressed": 44, "splat": 3, "spz": 1, "glb": 1}


@pytest.mark.parametrize("case", BROKEN)
def test_every_reader_leaves_such_rows_out_and_counts_them(
    case: str, tmp_path: Path, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    kind, broken = BROKEN[case]
    path = tmp_path / f"scene.{kind}"
    if kind in WRITTEN:
        WRITERS[kind](path, random_scene(300, 1))
    path.write_bytes(broken(path.read_bytes() if kind in WRITTEN else b""))
    with caplog.at_level(logging.WARNING):
        found = open_scene(path).gaussians
    lost = found.left_out
    assert lost == LOST.get(case, lost) > 0 < len(found)
    assert caplog.text.count(f"left out {lost} of {lost + len(found)} Gaussians") == 1
    contents = inspect_scene(path)
    assert (contents["left_out"], contents["gaussians"]) == (lost, len(found))
    assert main(["info", str(path)]) == 0
    assert f"left out: {lost} rows that cannot be drawn" in capsys.readouterr().out


@pytest.mark.parametrize("kind", WRITTEN)
def test_every_writer_leaves_such_rows_out(
    kind: Kind, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made, path = random_scene(6, 0), tmp_path / f"scene.{kind}"
    made.quats[0], made.logit_opacities[1], made.means[2, 0] = 0, -INF, NAN
    made.log_scales[3, 1], made.logit_opacities[4] = -INF, INF
    with caplog.at_level(logging.WARNING):
        WRITERS[kind](path, made)
    assert "left out 3 of 6 Gaussians" in caplog.text
    assert (len(PLAIN[f".{kind}"](path)), PLAIN[f".{kind}"](path).left_out) == (3, 0)
    with pytest.raises(InputError, match="has no Gaussian that can be drawn"):
        WRITERS[kind](tmp_path / "none", made.select(torch.arange(3)))
    assert not (tmp_path / "none").exists()


def test_a_file_without_a_row_that_can_be_drawn_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "zeros.ply"
    path.write_bytes(ply_of(*[turned(0)] * 5))
    for words in (["info", str(path)], ["view", str(path), "--no-browser"]):
        assert main(words) == 2
        assert "has no Gaussian that can be drawn" in capsys.readouterr().err
