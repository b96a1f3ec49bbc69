"""Valid files that our writer does not make: both decoders open them, or refuse them."""

import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.container import VERSION
from mobilegs.mgs.quantized_scene import scenes_equal
from tests.support.node import assert_same_refusals
from tests.support.quantized_scenes import join, make_scene, split

CONFORMANCE = Path(__file__).parent / "conformance"
Row = tuple[str, str, bytes]  # name, codec, content


def rearranged(data: bytes, change: Callable[[list[Row]], list[Row]]) -> bytes:
    """Return a file with the same header fields and changed streams."""
    header, body = split(data)
    rows: list[Row] = []
    for row in header["streams"]:
        rows.append((row["name"], row["codec"], body[: row["bytes"]]))
        body = body[row["bytes"] + -row["bytes"] % 8 :]
    rows = change(rows)
    table = [
        {"name": name, "codec": codec, "bytes": len(content), "crc32": zlib.crc32(content)}
        for name, codec, content in rows
    ]
    body = b"".join(content + bytes(-len(content) % 8) for _, _, content in rows)
    return join({**header, "streams": table}, body, VERSION.unpack_from(data, 8))


@pytest.mark.parametrize("name", ["nvq_linear_lobes", "sq_layers", "nvq_layers"])
def test_streams_may_come_in_any_order_and_some_may_be_unneeded(name: str, tmp_path: Path) -> None:
    data = (CONFORMANCE / f"{name}.mgs").read_bytes()
    idle = [("", "", b""), ("scale.3", "bits", b"abc"), ("view-network", "raw", b"abc")]
    files = [
        rearranged(data, lambda rows: rows[::-1]),
        rearranged(data, lambda rows: idle + rows),
        rearranged(data, lambda rows: rows + idle),
    ]
    assert assert_same_refusals(tmp_path, files) == [None] * 3
    assert all(scenes_equal(decode_mgs(file), decode_mgs(data)) for file in files)


def test_the_last_of_equal_fields_counts_and_infinite_numbers_matter_in_known_fields(
    data: bytes, tmp_path: Path
) -> None:
    header, body = split(data)
    text = json.dumps({**header, "meta": {"": ""}})
    cases = {
        '{"near": -1, ' + text[1:]: True,
        text[:-1] + ', "near": -1}': False,
        text[:-1] + ', "later": [1e999, ' + "9" * 400 + "]}": True,
        text[:-1] + ', "near": 1e999}': False,
        text[:-1] + ', "meta": {"psnr": -1e999}}': False,
    }
    found = assert_same_refusals(tmp_path, [join(text, body) for text in cases])
    assert [sentence is None for sentence in found] == list(cases.values())


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["lobe-decoder", "appearance-decoder", "codebooks"])
def test_numbers_that_are_not_finite_are_refused_in_every_stream(
    name: str, number: float, tmp_path: Path
) -> None:
    scene = make_scene()
    parts: dict[str, dict[Any, Any]] = {
        "lobe-decoder": scene.lobe_decoder,
        "appearance-decoder": scene.decoder,
        "codebooks": {key: scene.codebooks[key] for key in scene.cuts},
    }
    halves = np.concatenate([part.numpy().ravel() for part in parts[name].values()])

    def raw(rows: list[Row]) -> list[Row]:
        plain = (name, "raw", halves.tobytes())
        return [plain if row[0] == name else row for row in rows]

    sound = rearranged(encode_mgs(scene), raw)
    halves[7] = number
    found = assert_same_refusals(tmp_path, [sound, rearranged(encode_mgs(scene), raw)])
    assert found[0] is None and found[1] is not None


def test_quaternions_of_zeros_are_read_and_not_rendered(tmp_path: Path) -> None:
    scene = make_scene()
    scene.codebooks["rotation"][:] = 0
    data = encode_mgs(scene)
    assert assert_same_refusals(tmp_path, [data]) == [None]
    drawn = decode_mgs(data)
    assert drawn.decode().render(drawn.views[0]).alpha.max() == 0


def test_an_unused_log_scale_above_80_is_refused(tmp_path: Path) -> None:
    scene = make_scene()
    scene.indices["scale"][:] = 0
    scene.codebooks["scale"][2, 4] = 80.0
    books = np.concatenate([scene.codebooks[key].numpy().ravel() for key in scene.cuts])

    def raw(rows: list[Row]) -> list[Row]:
        return [
            ("codebooks", "raw", books.tobytes()) if row[0] == "codebooks" else row for row in rows
        ]

    sound = rearranged(encode_mgs(scene), raw)
    assert books[14] == 80
    books[14] = 80.0625  # the next float16 number
    found = assert_same_refusals(tmp_path, [sound, rearranged(encode_mgs(scene), raw)])
    assert found[0] is None and "scales that are out of range" in str(found[1])
