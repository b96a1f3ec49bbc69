"""The conformance files of docs/format.md: what both decoders find in them, written down once."""

import json
from pathlib import Path
from typing import Any

import pytest
import torch
from test_web_decoder import decoded
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.compress.container import inspect, pack, unpack
from mobilegs.compress.envelope import unseal
from mobilegs.render.lobes import constant_lobes

FOLDER = Path(__file__).parent / "conformance"
FILES = {path.stem: path.read_bytes() for path in sorted(FOLDER.glob("*.mgs"))}
EXACT = ("means", "log_scales")
# of the largest number; how networks add up is nobody's business
CLOSE = {"quats": 2e-7, "sh": 3e-6, "lobes": 3e-6}


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


@pytest.mark.parametrize("name", FILES)
def test_python_finds_what_is_written(name: str) -> None:
    coded = unpack(FILES[name])
    scene, written = coded.decode(), expected(name)
    assert (
        len(coded) == written["count"] and list(coded.layers or [len(coded)]) == written["layers"]
    )
    lobes = scene.lobes
    if lobes is None:
        lobes = constant_lobes(scene.gaussians.logit_opacities)
    parts = {
        "means": scene.gaussians.means,
        "log_scales": scene.gaussians.log_scales,
        "quats": normalize(scene.gaussians.quats, dim=1),
        "sh": scene.gaussians.sh.flatten(1),
        "lobes": lobes.flatten(1),
    }
    assert_as_written(name, parts)


def test_javascript_finds_what_is_written(tmp_path: Path) -> None:
    for name, found in decoded(tmp_path, FILES, seed=0).items():
        count, arrays = found["count"], found["arrays"]
        assert count == expected(name)["count"]
        assert found["header"]["layers"] == expected(name)["layers"]
        parts = {
            part: arrays[part].reshape(count, -1) for part in ("means", "quats", "sh", "lobes")
        }
        assert_as_written(name, parts | {"log_scales": arrays["logScales"].reshape(count, -1)})


@pytest.mark.parametrize("name", FILES)
def test_what_was_read_is_written_again_byte_by_byte(name: str) -> None:
    assert pack(unpack(FILES[name])) == FILES[name]


def contexts_of(data: bytes) -> int:
    """Contexts of the classes of a file's first positions: docs/format.md, sections 4 and 5."""
    _, streams = unseal(data)
    return int.from_bytes(streams["positions"].data[6:8], "little")


def test_the_files_use_all_that_there_is() -> None:
    reports = [inspect(data) for data in FILES.values()]
    codecs = {row["codec"] for report in reports for row in report["streams"]}
    assert codecs == {"raw", "halves", "planes", "morton-class", "bits", "rans"}
    versions = {report["version"] for report in reports}
    assert versions == {"2.1", "2.2", "2.3", "2.4", "3.0", "3.1", "3.2", "3.3"}
    weightings = {unpack(data).weighting.name for data in FILES.values()}
    assert weightings == {"mobile_gs", "no_depth", "no_scale", "sort_free_gs"}  # what viewers show
    assert {contexts_of(data) for data in FILES.values()} == {1, 49}
    assert {(report["mode"], report["blend"]) for report in reports} >= {
        *(("nvq", "sortfree"), ("sq", "sortfree"), ("sq", "sorted"))
    }
