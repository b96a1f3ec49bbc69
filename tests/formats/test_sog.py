"""PlayCanvas's `.sog`: what it keeps, both versions, zip and folder, another program's, bombs."""

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
from mobilegs.formats.sog_palette import codebook, palette
from mobilegs.gaussians import Gaussians
from tests.fuzz.readers import RESET, Meter
from tests.support.plain import matched, plain_scene, refusal_of, turn_between, worst

OTHERS = Path(__file__).parent / "other_tools"


def taken_apart(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def zipped(files: dict[str, bytes], way: int = zipfile.ZIP_STORED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", way) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


def webp(pixels: np.ndarray, **options: Any) -> bytes:
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "WEBP", **({"lossless": True, "exact": True} | options))
    return out.getvalue()


@pytest.fixture
def sound(tmp_path: Path) -> dict[str, bytes]:
    write_sog(tmp_path / "sound.sog", plain_scene(30, 1))
    return taken_apart((tmp_path / "sound.sog").read_bytes())


def signed_log(values: torch.Tensor) -> torch.Tensor:
    return values.double().sign() * values.double().abs().log1p()


def spread(values: torch.Tensor) -> float:
    """The error (RMS) of 256 equal steps over these values."""
    return float(values.max() - values.min()) / 255 / math.sqrt(12)


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_a_scene_survives_within_its_bits(degree: int, tmp_path: Path) -> None:
    made = plain_scene(700, degree)
    write_sog(tmp_path / "scene.sog", made)
    found = matched(read_sog(tmp_path / "scene.sog"), made)
    one, other = signed_log(found.means), signed_log(made.means)
    assert worst(one, other) <= 0.5 * float((other.amax(0) - other.amin(0)).max()) / 65535 + 1e-6
    assert worst(found.opacities, made.opacities) <= 0.5 / 255 + 1e-6
    # three parts of half a step each, and what the largest, at least 1/2, makes of them
    assert turn_between(found, made) <= 2 * math.sqrt(3) * 0.5 / 127.5 * math.sqrt(0.5)
    for one, other in (
        (found.log_scales, made.log_scales),
        (found.sh[:, 0], made.sh[:, 0]),
        (found.sh[:, 1:], made.sh[:, 1:]),
    ):
        assert not other.numel() or (one - other).square().mean().sqrt() < spread(other)


def test_up_to_256_values_are_kept_exactly(tmp_path: Path) -> None:
    made = plain_scene(80, 0)  # 240 scales, 240 colours
    write_sog(tmp_path / "scene.sog", made)
    found = matched(read_sog(tmp_path / "scene.sog"), made)
    assert worst(found.log_scales, made.log_scales) < 1e-6
    assert worst(found.sh, made.sh) < 1e-6


@pytest.mark.parametrize("name", ["ours.sog", "theirs.sog"])
def test_another_program_reads_the_same(name: str) -> None:
    found, back = read_sog(OTHERS / name), read_ply(OTHERS / f"{name}.back.ply")
    for part, value in found.tensors().items():
        assert torch.equal(value, back.tensors()[part]), part


def test_what_is_written_today_is_what_the_other_program_was_given(tmp_path: Path) -> None:
    write_sog(tmp_path / "ours.sog", read_ply(OTHERS / "scene.ply"))
    found, given = read_sog(tmp_path / "ours.sog"), read_sog(OTHERS / "ours.sog")
    for part, value in found.tensors().items():
        assert worst(value, given.tensors()[part]) < 1e-6


def test_the_same_scene_gives_the_same_bytes_and_says_how_it_is_blended(tmp_path: Path) -> None:
    for name in ("one.sog", "other.sog"):
        write_sog(tmp_path / name, plain_scene(50, 1))
    data = (tmp_path / "one.sog").read_bytes()
    assert data == (tmp_path / "other.sog").read_bytes()
    meta = json.loads(taken_apart(data)["meta.json"])
    assert meta["version"] == 2 and meta["count"] == 50 and meta["shN"]["bands"] == 1
    assert meta["asset"]["extras"] == {"blend": "sorted"}


def test_a_folder_is_read_and_so_is_its_meta_json(sound: dict[str, bytes], tmp_path: Path) -> None:
    for name, content in sound.items():
        (tmp_path / name).write_bytes(content)
    expected = read_sog(tmp_path / "sound.sog")
    for path in (tmp_path, tmp_path / "meta.json"):
        assert torch.equal(read_sog(path).means, expected.means)
    (tmp_path / "quats.webp").unlink()
    with pytest.raises(InputError, match="cannot read"):
        read_sog(tmp_path)


def test_version_1_is_read(tmp_path: Path) -> None:
    made = plain_scene(20, 2)
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
    assert worst(found.log_scales, torch.tensor(low) * (1 - 2 * share)) < 1e-6
    share = torch.from_numpy(bytes_[4, :20] / 255.0)
    assert worst(found.sh[:, 0], torch.tensor(low) * (1 - 2 * share[:, :3])) < 1e-6
    assert worst(found.logit_opacities, 8 * share[:, 3] - 4) < 1e-6
    sets = torch.from_numpy(centroids.reshape(-1, 8, 4)[0:40:2, :, :3] / 255 - 0.5)
    assert worst(found.sh[:, 1:], sets) < 1e-6


def test_a_codebook_that_begins_with_null_is_read(sound: dict[str, bytes], tmp_path: Path) -> None:
    meta = json.loads(sound["meta.json"])
    book = meta["scales"]["codebook"]
    expected = read_sog(tmp_path / "sound.sog").log_scales
    lowest = expected == book[0]
    assert lowest.any()
    first, book[0] = book[1] + (book[1] - book[255]) / 255, None
    files = sound | {"meta.json": json.dumps(meta).encode()}
    (tmp_path / "null.sog").write_bytes(zipped(files))
    found = read_sog(tmp_path / "null.sog").log_scales
    assert worst(found, torch.where(lowest, first, expected)) < 1e-6


def test_a_scene_of_nothing_survives(tmp_path: Path) -> None:
    write_sog(tmp_path / "none.sog", plain_scene(0, 2))
    assert len(read_sog(tmp_path / "none.sog")) == 0


def test_what_is_not_finite_is_left_out(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    made = plain_scene(5, 1)
    made.means[1, 1], made.sh[2, 3, 0] = math.nan, math.inf
    with caplog.at_level(logging.WARNING):
        write_sog(tmp_path / "scene.sog", made)
    assert "2 of 5 Gaussians are not finite" in caplog.text
    assert len(read_sog(tmp_path / "scene.sog")) == 3


# --- what stands for numbers


def test_a_codebook_is_ascending_and_names_the_nearest_value() -> None:
    values = np.random.default_rng(0).normal(size=(4000, 3)).astype(np.float32)
    book, nearest = codebook(values)
    assert (np.diff(book) >= 0).all()
    best = np.abs(values[..., None] - book).min(-1)
    np.testing.assert_allclose(np.abs(values - book[nearest]), best, atol=1e-6)
    assert np.sqrt((best**2).mean()) < 0.75 * spread(torch.from_numpy(values))


def test_a_palette_is_better_than_sets_that_are_drawn_and_repeats_itself() -> None:
    g = torch.Generator().manual_seed(0)
    rows = torch.randn(6000, 9, generator=g)
    sets, labels = palette(rows, 1000)
    assert len(sets) <= 1000 and int(labels.min()) >= 0 and int(labels.max()) < len(sets)
    error = (rows - sets[labels]).square().mean()
    drawn = rows[torch.randperm(6000, generator=g)[:1000]]
    assert error < 0.8 * torch.cdist(rows, drawn).min(1).values.square().mean() / 9
    for one, other in zip((sets, labels), palette(rows, 1000), strict=True):
        assert torch.equal(one, other)
    everything, own = palette(rows[:50], 1000)
    assert torch.equal(everything[own], rows[:50])


# --- files that are no scenes

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


BAD: dict[str, tuple[Callable[[Files], Files], str]] = {
    "no meta.json": (lambda files: {k: v for k, v in files.items() if "meta" not in k}, "lacks"),
    "no picture": (lambda files: {k: v for k, v in files.items() if "quats" not in k}, "lacks"),
    "a later version": (changed(lambda m: m.update(version=3)), "1 and 2 can be read"),
    "a huge count": (changed(lambda m: m.update(count=10**9)), "cut off"),
    "a count beyond all": (changed(lambda m: m.update(count=10**400)), "do not fit together"),
    "a large count": (changed(lambda m: m.update(count=3000)), "pixels for 3000 values"),
    "a negative count": (changed(lambda m: m.update(count=-1)), "do not fit together"),
    "a text for a count": (changed(lambda m: m.update(count="30")), "do not fit together"),
    "a short codebook": (changed(lambda m: m["sh0"]["codebook"].pop()), "do not fit together"),
    "no codebook": (changed(lambda m: m["scales"].pop("codebook")), "do not fit together"),
    "a bound beyond all": (
        changed(lambda m: m["means"]["mins"].__setitem__(0, 10**400)),
        "do not fit together",
    ),
    "two bounds": (changed(lambda m: m["means"]["mins"].pop()), "do not fit together"),
    "another degree": (changed(lambda m: m["shN"].update(bands=3)), "do not fit together"),
    "a way out": (
        changed(lambda m: m["quats"].update(files=["../../etc/passwd"])),
        "do not fit together",
    ),
    "a list": (lambda files: files | {"meta.json": b"[]"}, "do not fit together"),
    "deep nests": (lambda files: files | {"meta.json": b"[" * 10**5}, "cannot be read"),
    "a long meta.json": (lambda files: files | {"meta.json": b" " * 10**6}, "larger than it can"),
    "no WebP": (picture("quats", b"RIFF" + bytes(40)), "no lossless WebP"),
    "a lossy WebP": (picture("quats", blank(8, 8, lossless=False)), "no lossless WebP"),
    "a cut WebP": (lambda f: f | {"quats.webp": f["quats.webp"][:-20]}, "cannot be decoded"),
    "few pixels": (picture("sh0", blank(2, 2)), "2 x 2 pixels"),
    "many pixels": (picture("sh0", blank(4000, 4000)), "4000 x 4000 pixels"),
    "harmonics beyond": (picture("shN_labels", blank(8, 8)), "its palette has not"),
    "a wide palette": (picture("shN_centroids", blank(1, 200)), "do not fit together"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_does_not_fit_together_gets_a_sentence(
    case: str, sound: dict[str, bytes], tmp_path: Path
) -> None:
    change, words = BAD[case]
    assert words in refusal_of(read_sog, tmp_path / "bad.sog", zipped(change(sound)))


def test_what_is_no_archive_gets_a_sentence(sound: dict[str, bytes], tmp_path: Path) -> None:
    path, data = tmp_path / "bad.sog", zipped(sound)
    assert "as a zip archive" in refusal_of(read_sog, path, b"")
    assert "as a zip archive" in refusal_of(read_sog, path, data[:-1])
    assert "cannot be opened" in refusal_of(read_sog, path, data[len(data) // 2 :])
    assert "cannot be opened" in refusal_of(read_sog, path, zipped(sound, zipfile.ZIP_BZIP2))
    many = sound | {f"{i:0200}": b"" for i in range(400)}
    assert "too many files" in refusal_of(read_sog, path, zipped(many))
    with pytest.raises(InputError, match="cannot read"):
        read_sog(tmp_path / "missing.sog")


@pytest.mark.skipif(not RESET.exists(), reason="memory is measured as Linux tells it")
@pytest.mark.parametrize("name", ["meta.json", "quats.webp", "a picture of 268 megapixels"])
def test_a_bomb_is_refused_before_it_grows(
    name: str, sound: dict[str, bytes], tmp_path: Path
) -> None:
    if name in sound:
        files = sound | {name: bytes(300 << 20)}
    else:  # the head of a picture of 16383 x 16383
        head = bytearray(sound["quats.webp"])
        head[21:25] = (16382 | 16382 << 14 | 1 << 28).to_bytes(4, "little")
        files = sound | {"quats.webp": bytes(head)}
    path = tmp_path / "bomb.sog"
    path.write_bytes(zipped(files, zipfile.ZIP_DEFLATED))
    assert path.stat().st_size < 1 << 20
    del files
    meter = Meter()
    meter.start()
    with pytest.raises(InputError):
        read_sog(path)
    assert meter.peak() < 16 << 20


def test_reading_gives_tensors_of_their_own(sound: dict[str, bytes], tmp_path: Path) -> None:
    found = read_sog(tmp_path / "sound.sog")
    assert isinstance(found, Gaussians)
    assert all(value.is_contiguous() for value in found.tensors().values())
