"""The conformance files of docs/reference/format.md: both decoders find the listed numbers."""

import json
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.mgs.container import read_container
from mobilegs.render.lobes import constant_lobes, evaluate_lobes
from mobilegs.render.scene import Scene
from mobilegs.render.sortfree import WEIGHTINGS
from tests.support.node import decoded, refusals

FOLDER = Path(__file__).parent / "conformance"
FILES = {path.stem: path.read_bytes() for path in sorted(FOLDER.glob("*.mgs"))}
OF_DEGREE_1 = {name: data for name, data in FILES.items() if "degree" not in name}
EXACT = ("means", "log_scales")
# relative to the largest number: the order of sums in networks is not specified
CLOSE = {"quats": 2e-7, "sh": 3e-6, "lobes": 3e-6}
SEEN = 3e-6  # opacities, and phi relative to the largest one or 1
DRAWN = 1e-5  # pixels


def expected(name: str) -> dict[str, Any]:
    return json.loads((FOLDER / f"{name}.json").read_text())


def assert_as_written(name: str, parts: dict[str, Tensor]) -> None:
    written = expected(name)
    rows = written["rows"]
    for part in EXACT:
        assert torch.equal(parts[part][rows], torch.tensor(written[part])), part
    for part, tolerance in CLOSE.items():
        values = torch.tensor(written[part])
        error = (parts[part][rows] - values).abs().max() / values.abs().max().clamp_min(1e-6)
        assert error < tolerance, part


def lobes_of(scene: Scene) -> Tensor:
    if scene.lobes is None:
        return constant_lobes(scene.gaussians.logit_opacities)
    return scene.lobes


@torch.no_grad()
def assert_shown_as_written(name: str, scene: Scene) -> None:
    """Check opacity and phi by direction, and pixels, if the file lists them."""
    written, camera = expected(name), decode_mgs(FILES[name]).views[0]
    rows = torch.tensor(written["rows"])
    some = scene.gaussians.select(rows)
    for i, direction in enumerate(written.get("directions", ())):
        directions = torch.tensor(direction).expand(len(rows), 3)
        lobes = lobes_of(scene)[rows] if scene.network is None else scene.network(some, directions)
        for part, found in zip(("opacity", "phi"), evaluate_lobes(lobes, directions), strict=True):
            values = torch.tensor(written[part])[:, i]
            assert (found - values).abs().max() < SEEN * values.abs().max().clamp_min(1), part
    if "picture" in written:
        x, y = torch.tensor(written["pixels"]).T
        error = scene.render(camera).image[y, x] - torch.tensor(written["picture"])
        assert error.abs().max() < DRAWN


@pytest.mark.parametrize("name", FILES)
def test_python_finds_the_listed_numbers(name: str) -> None:
    coded = decode_mgs(FILES[name])
    scene, written = coded.decode(), expected(name)
    assert (
        len(coded) == written["count"]
        and list(coded.lod_sizes or [len(coded)]) == written["layers"]
    )
    parts = {
        "means": scene.gaussians.means,
        "log_scales": scene.gaussians.log_scales,
        "quats": normalize(scene.gaussians.quats, dim=1),
        "sh": scene.gaussians.sh.flatten(1),
        "lobes": lobes_of(scene).flatten(1),
    }
    assert_as_written(name, parts)
    assert_shown_as_written(name, scene)


def test_javascript_finds_the_listed_numbers(tmp_path: Path) -> None:
    for name, found in decoded(tmp_path, OF_DEGREE_1, seed=0).items():
        count, arrays = found["count"], found["arrays"]
        assert count == expected(name)["count"]
        assert found["header"]["lodSizes"] == expected(name)["layers"]
        parts = {
            part: arrays[part].reshape(count, -1) for part in ("means", "quats", "sh", "lobes")
        }
        assert_as_written(name, parts | {"log_scales": arrays["logScales"].reshape(count, -1)})


def test_viewers_refuse_degrees_other_than_1(tmp_path: Path) -> None:
    others = [name for name in FILES if name not in OF_DEGREE_1]
    degrees = [inspect(FILES[name])["sh_degree"] for name in others]
    assert sorted(degrees) == [0, 2, 3]
    found = refusals(tmp_path, [FILES[name] for name in others])
    for degree, sentence in zip(degrees, found, strict=True):
        assert sentence is not None and f"has sh_degree '{degree}'" in sentence


@pytest.mark.parametrize("name", FILES)
def test_files_are_rewritten_byte_for_byte(name: str) -> None:
    assert encode_mgs(decode_mgs(FILES[name])) == FILES[name]


def contexts_of(data: bytes) -> int:
    """Return the contexts of the first positions' classes (format.md, sections 4 and 5)."""
    _, streams = read_container(data)
    return int.from_bytes(streams["positions"].data[6:8], "little")


def test_the_files_cover_every_codec_version_and_mode() -> None:
    reports = [inspect(data) for data in FILES.values()]
    codecs = {row["codec"] for report in reports for row in report["streams"]}
    assert codecs == {"raw", "halves", "planes", "morton-class", "bits", "rans"}
    versions = {report["version"] for report in reports}
    minor = {2: range(1, 7), 3: range(6), 4: range(2)}
    assert versions == {f"{major}.{each}" for major in minor for each in minor[major]}
    weightings = {decode_mgs(data).weighting.name for data in FILES.values()}
    assert weightings == set(WEIGHTINGS)
    assert {contexts_of(data) for data in FILES.values()} == {1, 49}
    assert {(report["mode"], report["blend"]) for report in reports} >= {
        *(("nvq", "sortfree"), ("sq", "sortfree"), ("sq", "sorted"))
    }
    report = inspect(FILES["sq_sorted_lobes_picture"])
    assert (report["version"], report["blend"]) == ("2.5", "sorted") and report["lobes"]
    assert {report["sh_degree"] for report in reports} == {0, 1, 2, 3}
