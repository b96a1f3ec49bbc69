"""Reading and writing `.sog`, both versions, files of splat-transform, invalid files and bombs."""

import io
import json
import logging
import math
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.sog import read_sog, write_sog
from mobilegs.formats.sog_palette import palette
from mobilegs.render import Footprint
from mobilegs.scene_file import open_scene
from tests.support.memory_meter import RESET, MemoryMeter
from tests.support.random_scenes import (
    error_message,
    matched,
    max_error,
    random_scene,
    rotation_error,
)

OTHERS = Path(__file__).parent / "other_tools"


def unzipped(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def zipped(files: dict[str, bytes], method: int = zipfile.ZIP_STORED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


def webp(pixels: np.ndarray, **options: Any) -> bytes:
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "WEBP", **({"lossless": True, "exact": True} | options))
    return out.getvalue()


@pytest.fixture
def valid(tmp_path: Path) -> dict[str, bytes]:
    """The files of a valid scene of 30 Gaussians, which is written to `valid.sog`."""
    write_sog(tmp_path / "valid.sog", random_scene(30, 1))
    return unzipped((tmp_path / "valid.sog").read_bytes())


def signed_log(values: torch.Tensor) -> torch.Tensor:
    return values.double().sign() * values.double().abs().log1p()


def uniform_error(values: torch.Tensor) -> float:
    """Return the RMS error of 256 equal steps over the range of these values."""
    return float(values.max() - values.min()) / 255 / math.sqrt(12)


@pytest.mark.parametrize("degree", [0, 3])
def test_a_written_scene_is_read_back_within_its_precision(degree: int, tmp_path: Path) -> None:
    made = random_scene(700, degree)
    write_sog(tmp_path / "scene.sog", made)
    found = read_sog(tmp_path / "scene.sog")
    assert all(value.is_contiguous() for value in found.tensors().values())
    found = matched(found, made)
    one, other = signed_log(found.means), signed_log(made.means)
    assert (
        max_error(one, other) <= 0.5 * float((other.amax(0) - other.amin(0)).max()) / 65535 + 1e-6
    )
    assert max_error(found.opacities, made.opacities) <= 0.5 / 255 + 1e-6
    # half a step for each of three components, and their effect on the largest (at least 1/2)
    assert rotation_error(found, made) <= 2 * math.sqrt(3) * 0.5 / 127.5 * math.sqrt(0.5)
    for one, other in (
        (found.log_scales, made.log_scales),
        (found.sh[:, 0], made.sh[:, 0]),
        (found.sh[:, 1:], made.sh[:, 1:]),
    ):
        assert not other.numel() or (one - other).square().mean().sqrt() < uniform_error(other)


def test_up_to_256_values_are_kept_exactly(tmp_path: Path) -> None:
    made = random_scene(80, 0)  # 240 scales, 240 colours
    write_sog(tmp_path / "scene.sog", made)
    found = matched(read_sog(tmp_path / "scene.sog"), made)
    assert max_error(found.log_scales, made.log_scales) < 1e-6
    assert max_error(found.sh, made.sh) < 1e-6


@pytest.mark.parametrize("name", ["ours.sog", "theirs.sog"])
def test_splat_transform_reads_the_same_values(name: str) -> None:
    found, back = read_sog(OTHERS / name), read_ply(OTHERS / f"{name}.back.ply")
    for part, value in found.tensors().items():
        assert torch.equal(value, back.tensors()[part]), part


def test_the_writer_still_makes_the_committed_file(tmp_path: Path) -> None:
    write_sog(tmp_path / "ours.sog", read_ply(OTHERS / "scene.ply"))
    found, given = read_sog(tmp_path / "ours.sog"), read_sog(OTHERS / "ours.sog")
    for part, value in found.tensors().items():
        assert max_error(value, given.tensors()[part]) < 1e-6


def test_the_same_scene_gives_the_same_bytes_and_names_its_blending(tmp_path: Path) -> None:
    for name in ("one.sog", "other.sog"):
        write_sog(tmp_path / name, random_scene(50, 1))
    data = (tmp_path / "one.sog").read_bytes()
    assert data == (tmp_path / "other.sog").read_bytes()
    meta = json.loads(unzipped(data)["meta.json"])
    assert meta["version"] == 2 and meta["count"] == 50 and meta["shN"]["bands"] == 1
    assert meta["asset"]["extras"] == {"blend": "sorted"}


def test_a_folder_is_read_and_so_is_its_meta_json(valid: dict[str, bytes], tmp_path: Path) -> None:
    for name, content in valid.items():
        (tmp_path / name).write_bytes(content)
    expected = read_sog(tmp_path / "valid.sog")
    for path in (tmp_path, tmp_path / "meta.json"):
        assert torch.equal(read_sog(path).means, expected.means)
    (tmp_path / "quats.webp").unlink()
    with pytest.raises(InputError, match="cannot read"):
        read_sog(tmp_path)


def test_version_1_is_read(tmp_path: Path) -> None:
    made = random_scene(20, 2)
    bytes_ = np.random.default_rng(0).integers(0, 256, (5, 64, 4)).astype(np.uint8)
    bytes_[2, :, 3] = 252
    centroids = np.random.default_rng(1).integers(0, 256, (2, 512, 4)).astype(np.uint8)
    labels = np.full((8, 8, 4), 255, np.uint8)
    labels.reshape(-1, 4)[:, :2] = [[i * 2 % 128, 0] for i in range(64)]
    names = ["means_l", "means_u", "quats", "scales", "sh0"]
    files = {
        f"{name}.webp": webp(part.reshape(8, 8, 4))
        for name, part in zip(names, bytes_, strict=True)
    }
    files |= {"shN_centroids.webp": webp(centroids), "shN_labels.webp": webp(labels)}
    low, high = [-1.0, -2, -3], [1.0, 2, 3]
    meta = {
        "means": {"shape": [20, 3], "mins": low, "maxs": high, "files": list(files)[:2]},
        "quats": {"files": ["quats.webp"]},
        "scales": {"mins": low, "maxs": high, "files": ["scales.webp"]},
        "sh0": {"mins": [*low, -4], "maxs": [*high, 4], "files": ["sh0.webp"]},
        "shN": {"mins": -0.5, "maxs": 0.5, "files": list(files)[5:]},
    }
    files["meta.json"] = json.dumps(meta).encode()
    (tmp_path / "old.sog").write_bytes(zipped(files, zipfile.ZIP_DEFLATED))
    found = read_sog(tmp_path / "old.sog")
    assert len(found) == len(made) and found.sh_degree == 2
    share = torch.from_numpy(bytes_[3, :20, :3] / 255.0)
    assert max_error(found.log_scales, torch.tensor(low) * (1 - 2 * share)) < 1e-6
    share = torch.from_numpy(bytes_[4, :20] / 255.0)
    assert max_error(found.sh[:, 0], torch.tensor(low) * (1 - 2 * share[:, :3])) < 1e-6
    assert max_error(found.logit_opacities, 8 * share[:, 3] - 4) < 1e-6
    sets = torch.from_numpy(centroids.reshape(-1, 8, 4)[0:40:2, :, :3] / 255 - 0.5)
    assert max_error(found.sh[:, 1:], sets) < 1e-6


def test_a_codebook_that_starts_with_null_is_read(valid: dict[str, bytes], tmp_path: Path) -> None:
    meta = json.loads(valid["meta.json"])
    book = meta["scales"]["codebook"]
    expected = read_sog(tmp_path / "valid.sog").log_scales
    lowest = expected == book[0]
    assert lowest.any()
    first, book[0] = book[1] + (book[1] - book[255]) / 255, None
    files = valid | {"meta.json": json.dumps(meta).encode()}
    (tmp_path / "null.sog").write_bytes(zipped(files))
    found = read_sog(tmp_path / "null.sog").log_scales
    assert max_error(found, torch.where(lowest, first, expected)) < 1e-6


def test_an_empty_scene_is_read_back_and_gaussians_that_are_not_finite_are_dropped(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_sog(tmp_path / "none.sog", random_scene(0, 2))
    assert len(read_sog(tmp_path / "none.sog")) == 0
    made = random_scene(5, 1)
    made.means[1, 1], made.sh[2, 3, 0] = math.nan, math.inf
    with caplog.at_level(logging.WARNING):
        write_sog(tmp_path / "scene.sog", made)
    assert "2 of 5 Gaussians" in caplog.text
    assert len(read_sog(tmp_path / "scene.sog")) == 3


# --- codebooks and palettes


def test_a_palette_beats_random_entries_and_is_deterministic() -> None:
    g = torch.Generator().manual_seed(0)
    rows = torch.randn(6000, 9, generator=g)
    entries, labels = palette(rows, 1000)
    assert len(entries) <= 1000 and int(labels.min()) >= 0 and int(labels.max()) < len(entries)
    error = (rows - entries[labels]).square().mean()
    random = rows[torch.randperm(6000, generator=g)[:1000]]
    assert error < 0.8 * torch.cdist(rows, random).min(1).values.square().mean() / 9
    for one, other in zip((entries, labels), palette(rows, 1000), strict=True):
        assert torch.equal(one, other)
    everything, own = palette(rows[:50], 1000)
    assert torch.equal(everything[own], rows[:50])


# --- invalid files

Files = dict[str, bytes]


def changed(change: Callable[[Any], object]) -> Callable[[Files], Files]:
    def apply(files: Files) -> Files:
        meta = json.loads(files["meta.json"])
        change(meta)
        return files | {"meta.json": json.dumps(meta).encode()}

    return apply


def picture(name: str, content: bytes) -> Callable[[Files], Files]:
    return lambda files: files | {f"{name}.webp": content}


def blank(height: int, width: int, value: int = 255, **options: Any) -> bytes:
    return webp(np.full((height, width, 4), value, np.uint8), **options)


INVALID: dict[str, tuple[Callable[[Files], Files], str]] = {
    "no meta.json": (lambda files: {k: v for k, v in files.items() if "meta" not in k}, "lacks"),
    "a later version": (changed(lambda m: m.update(version=3)), "only 1 and 2"),
    "a huge count": (changed(lambda m: m.update(count=10**9)), "cut off"),
    "a path outside": (
        changed(lambda m: m["quats"].update(files=["../../etc/passwd"])),
        "not consistent",
    ),
    "deep nests": (lambda files: files | {"meta.json": b"[" * 10**5}, "cannot be read"),
    "no WebP": (picture("quats", b"RIFF" + bytes(40)), "not a lossless WebP"),
    "a lossy WebP": (picture("quats", blank(8, 8, lossless=False)), "not a lossless WebP"),
    "a cut WebP": (lambda f: f | {"quats.webp": f["quats.webp"][:-20]}, "cannot be decoded"),
    "many pixels": (picture("sh0", blank(4000, 4000)), "4000 x 4000 pixels"),
    "labels beyond the palette": (picture("shN_labels", blank(8, 8)), "SH palette"),
}


@pytest.mark.parametrize("case", INVALID)
def test_an_inconsistent_file_raises_a_one_line_error(
    case: str, valid: dict[str, bytes], tmp_path: Path
) -> None:
    change, words = INVALID[case]
    assert words in error_message(read_sog, tmp_path / "bad.sog", zipped(change(valid)))


def test_an_invalid_archive_raises_a_one_line_error(
    valid: dict[str, bytes], tmp_path: Path
) -> None:
    path, data = tmp_path / "bad.sog", zipped(valid)
    assert "like a zip archive" in error_message(read_sog, path, b"")
    assert "like a zip archive" in error_message(read_sog, path, data[:-1])
    assert "cannot be opened" in error_message(read_sog, path, data[len(data) // 2 :])
    assert "cannot be opened" in error_message(read_sog, path, zipped(valid, zipfile.ZIP_BZIP2))
    many = valid | {f"{i:0200}": b"" for i in range(400)}
    assert "too many files" in error_message(read_sog, path, zipped(many))
    with pytest.raises(InputError, match="cannot read"):
        read_sog(tmp_path / "missing.sog")


@pytest.mark.skipif(not RESET.exists(), reason="needs Linux")
@pytest.mark.parametrize("name", ["meta.json", "quats.webp", "an image of 268 megapixels"])
def test_a_bomb_raises_an_error_before_it_is_unpacked(
    name: str, valid: dict[str, bytes], tmp_path: Path
) -> None:
    if name in valid:
        files = valid | {name: bytes(64 << 20)}
    else:  # the header of an image of 16383 x 16383
        head = bytearray(valid["quats.webp"])
        head[21:25] = (16382 | 16382 << 14 | 1 << 28).to_bytes(4, "little")
        files = valid | {"quats.webp": bytes(head)}
    path = tmp_path / "bomb.sog"
    path.write_bytes(zipped(files, zipfile.ZIP_DEFLATED))
    assert path.stat().st_size < 1 << 20
    del files
    meter = MemoryMeter()
    meter.start()
    with pytest.raises(InputError):
        read_sog(path)
    assert meter.peak() < 16 << 20


def test_the_model_of_antialiased_scenes_is_read_and_written(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "scene.sog"
    gaussians = random_scene(30, 1)
    for footprint, model in ((Footprint(), None), (Footprint(antialiased=True), "antialiased")):
        write_sog(path, gaussians, footprint=footprint)
        files = unzipped(path.read_bytes())
        meta = json.loads(files["meta.json"])
        assert meta.get("model") == model
        assert open_scene(path).footprint == footprint
    assert not caplog.text
    files["meta.json"] = json.dumps(meta | {"model": "2dgs"}).encode()
    path.write_bytes(zipped(files))
    assert open_scene(path).footprint == Footprint()
    assert "made for the model '2dgs'" in caplog.text
    write_sog(path, gaussians, footprint=Footprint(0.1, antialiased=True))
    assert "no place for the blur 0.1" in caplog.text
