"""Compressed `.ply`, and what stands in the head of a plain one."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.formats.ply_compressed import BOUNDS, CHUNK, COLORS, PACKED, SCALES
from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import C0
from tests.support.plain import matched, plain_scene, refusal_of, turn_between, worst

OTHERS = Path(__file__).parent / "other_tools"


def unorm(values: np.ndarray, bits: int) -> np.ndarray:
    return np.rint(values * ((1 << bits) - 1)).astype(np.uint32)


def compressed(
    scene: Gaussians,
    *,
    colors: bool = True,
    order: str = "<",
    kinds: tuple[str, str, str] = ("float", "uint", "uchar"),
    chunks: int | None = None,
) -> bytes:
    """A file by the format's description; without `colors` as it was before 2024."""
    count = len(scene)
    number = -(-count // CHUNK)
    rgb = (0.5 + C0 * scene.sh[:, 0]).clamp(*((-9, 9) if colors else (0, 1))).numpy()
    parts = [scene.means.numpy(), scene.log_scales.numpy(), rgb]
    bounds, places = [], []
    for part, names in zip(parts, (BOUNDS, SCALES, COLORS), strict=True):
        pieces = np.split(part, range(CHUNK, count, CHUNK)) if count else []
        low = np.array([piece.min(0) for piece in pieces], np.float32).reshape(number, 3)
        high = np.array([piece.max(0) for piece in pieces], np.float32).reshape(number, 3)
        if names is COLORS and not colors:
            places.append(part)
            continue
        bounds += [low, high]
        wide = np.repeat(np.maximum(high - low, 1e-20), CHUNK, axis=0)[:count]
        places.append((part - np.repeat(low, CHUNK, axis=0)[:count]) / wide)
    q = scene.quats.numpy()
    largest = np.abs(q).argmax(1)
    q = q * np.sign(q[np.arange(count), largest])[:, None]
    rotation = largest.astype(np.uint32)
    for i in range(3):
        which = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[largest, i]
        small = q[np.arange(count), which] / math.sqrt(2) + 0.5
        rotation = rotation << 10 | unorm(small, 10)

    def three(values: np.ndarray) -> np.ndarray:
        x, y, z = (unorm(values[:, i], bits) for i, bits in enumerate((11, 10, 11)))
        return x << 21 | y << 11 | z

    r, g, b = (unorm(places[2][:, i], 8) for i in range(3))
    color = r << 24 | g << 16 | b << 8 | unorm(scene.opacities.numpy(), 8)
    words = np.stack([three(places[0]), rotation, three(places[1]), color], axis=1)
    rest = scene.sh[:, 1:].transpose(1, 2).flatten(1).numpy()
    harmonics = np.trunc((rest / 8 + 0.5) * 256).clip(0, 255).astype(np.uint8)
    format_ = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    names = [*BOUNDS, *SCALES, *(COLORS if colors else [])]
    lines = [
        "ply",
        f"format {format_} 1.0",
        f"element chunk {number if chunks is None else chunks}",
    ]
    lines += [f"property {kinds[0]} {name}" for name in names]
    lines += [f"element vertex {count}", *(f"property {kinds[1]} {name}" for name in PACKED)]
    if rest.shape[1]:
        lines += [f"element sh {count}"]
        lines += [f"property {kinds[2]} f_rest_{i}" for i in range(rest.shape[1])]
    table = np.concatenate(bounds, axis=1) if number else np.zeros((0, len(names)))
    body = table.astype(order + "f4").tobytes() + words.astype(order + "u4").tobytes()
    return "\n".join([*lines, "end_header\n"]).encode() + body + harmonics.tobytes()


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_compressed_scene_is_read_within_its_bits(
    degree: int, order: str, tmp_path: Path
) -> None:
    made = plain_scene(700, degree)  # three chunks, the last one not full
    (tmp_path / "scene.compressed.ply").write_bytes(compressed(made, order=order))
    found = read_ply(tmp_path / "scene.compressed.ply")
    for first in range(0, 700, CHUNK):
        rows = slice(first, first + CHUNK)
        for name, bits in (("means", 10), ("log_scales", 10)):
            one, other = found.tensors()[name][rows], made.tensors()[name][rows]
            step = float((other.amax(0) - other.amin(0)).max()) / ((1 << bits) - 1)
            assert worst(one, other) <= 0.5 * step + 1e-6
        one, other = found.sh[rows, 0], made.sh[rows, 0]
        assert worst(one, other) <= 0.5 * float((other.amax(0) - other.amin(0)).max()) / 255 + 1e-6
    assert worst(found.opacities, made.opacities) <= 0.5 / 255 + 1e-6
    if degree:
        assert worst(found.sh[:, 1:], made.sh[:, 1:]) <= 8 / 256 / 2 + 1e-6
    assert turn_between(found, made) <= 2 * math.sqrt(3) * 0.5 / 1023 * math.sqrt(2)


def test_another_program_s_file_is_read_as_it_reads_it_itself() -> None:
    path = OTHERS / "theirs.compressed.ply"
    found, back = read_ply(path), read_ply(path.with_name(f"{path.name}.back.ply"))
    for name, value in found.tensors().items():
        assert torch.equal(value, back.tensors()[name]), name
    made = read_ply(OTHERS / "scene.ply")
    assert worst(matched(found, made).means, made.means) < 0.01


def test_colours_without_bounds_lie_between_0_and_1(tmp_path: Path) -> None:
    made = plain_scene(30, 0)
    (tmp_path / "old.ply").write_bytes(compressed(made, colors=False))
    expected = made.sh.clamp(-0.5 / C0, 0.5 / C0)
    assert worst(read_ply(tmp_path / "old.ply").sh, expected) <= 0.5 / 255 / C0 + 1e-6


def test_a_compressed_scene_of_nothing_is_read(tmp_path: Path) -> None:
    (tmp_path / "none.ply").write_bytes(compressed(plain_scene(0, 1)))
    assert len(read_ply(tmp_path / "none.ply")) == 0


def test_wide_bounds_and_more_harmonics_than_vertices_are_read(tmp_path: Path) -> None:
    data = compressed(plain_scene(2, 1), kinds=("double", "uint", "uchar"))
    head, end, body = data.partition(b"end_header\n")
    wide = np.frombuffer(body[:72], "<f4").astype("<f8")
    head = head.replace(b"element sh 2", b"element sh 3")
    path = tmp_path / "wide.ply"
    path.write_bytes(head + end + wide.tobytes() + body[72:] + bytes(9))
    assert len(read_ply(path)) == 2
    wide[[0, 3]] = 1e300  # which is not finite as a float
    path.write_bytes(head + end + wide.tobytes() + body[72:] + bytes(9))
    assert len(read_ply(path)) == 0


def test_chunks_that_are_not_finite_are_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    data = compressed(plain_scene(300, 0))
    at = data.index(b"end_header\n") + 11 + 18 * 4  # the second chunk's lower bound of x
    data = data[:at] + b"\0\0\xc0\x7f" + data[at + 4 :]
    (tmp_path / "nan.ply").write_bytes(data)
    with caplog.at_level(logging.WARNING):
        assert len(read_ply(tmp_path / "nan.ply")) == CHUNK
    assert "44 of 300 Gaussians are not finite" in caplog.text


SCENE = plain_scene(3, 1)
SOUND = compressed(SCENE)
REFUSED = {
    "cut off": (SOUND[:-1], "cut off"),
    "a huge count": (SOUND.replace(b"vertex 3", b"vertex 999999999999999"), "cut off"),
    "too few chunks": (compressed(SCENE, chunks=0) + bytes(99), "only 0 chunks"),
    "no chunks": (SOUND.replace(b"element chunk", b"element chank"), "its chunks lack bounds"),
    "no bound": (SOUND.replace(b"max_scale_z", b"max_scale_q"), "its chunks lack bounds"),
    "half the colours": (SOUND.replace(b" min_g", b" min_q"), "its chunks lack bounds"),
    "floats for words": (compressed(SCENE, kinds=("float", "float", "uchar")), "as uint"),
    "no rotation": (SOUND.replace(b"packed_rotation", b"packed_rotatoin"), "packed_rotation"),
    "odd harmonics": (SOUND.replace(b"f_rest_8", b"f_rest_9"), "they do not fit"),
    "wide harmonics": (
        compressed(SCENE, kinds=("float", "uint", "ushort")) + bytes(99),
        "no bytes",
    ),
    "few harmonics": (SOUND.replace(b"element sh 3", b"element sh 2"), "they do not fit"),
    "in text": (SOUND.replace(b"binary_little_endian", b"ascii"), "compressed PLY in text"),
    "two of a kind": (SOUND.replace(b"element sh", b"element vertex"), "cut off"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_compressed_file_that_is_no_scene_gets_a_sentence(case: str, tmp_path: Path) -> None:
    data, words = REFUSED[case]
    assert words in refusal_of(read_ply, tmp_path / "bad.ply", data)


def test_a_plain_file_says_how_it_is_blended(tmp_path: Path) -> None:
    write_ply(tmp_path / "scene.ply", plain_scene(2, 0))
    head = (tmp_path / "scene.ply").read_bytes().split(b"end_header")[0].splitlines()
    assert {b"comment SplatRenderMode: default", b"comment mobilegs blend sorted"} <= set(head)


def test_a_million_vertices_without_a_body_take_no_memory(tmp_path: Path) -> None:
    head = SOUND[: SOUND.index(b"end_header")].replace(b" 3\n", b" 1000000\n")
    path = tmp_path / "head.ply"
    path.write_bytes(head.replace(b"chunk 1\n", b"chunk 3907\n") + b"end_header\n")
    with pytest.raises(InputError, match="cut off"):
        read_ply(path)


def test_infinite_logits_and_scales_of_nothing_are_taken_for_what_they_mean(tmp_path: Path) -> None:
    made = plain_scene(4, 0)
    made.logit_opacities[:2] = torch.tensor([math.inf, -math.inf])
    made.log_scales[2, 1], made.log_scales[3, 0] = -math.inf, math.inf
    write_ply(tmp_path / "scene.ply", made)
    found = read_ply(tmp_path / "scene.ply")
    assert len(found) == 3
    assert found.opacities[0] > 1 - 1e-5 and found.opacities[1] < 1e-5
    assert found.scales[2, 1] < 1e-20
