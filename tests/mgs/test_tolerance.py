"""Valid files that our writer does not make: both decoders open them, or refuse them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.quantized_scene import scenes_equal
from tests.support.mgs_parts import Piece, parse_parts
from tests.support.node import assert_same_refusals
from tests.support.quantized_scenes import SMALL
from tests.support.scene_cases import make_scene

CONFORMANCE = Path(__file__).parent / "conformance"


def rearranged(data: bytes, change: Callable[[list[Piece]], list[Piece]]) -> bytes:
    """Return a file with the same header fields and changed streams."""
    parts = parse_parts(data)
    parts.pieces = change(parts.pieces)
    return parts.to_bytes()


@pytest.mark.parametrize("name", ["sq_layers", "nvq_layers"])
def test_streams_may_come_in_any_order_and_some_may_be_unneeded(name: str, tmp_path: Path) -> None:
    data = (CONFORMANCE / f"{name}.mgs").read_bytes()
    idle = [
        Piece("", "", b""),
        Piece("scale.3", "bits", b"abc"),
        Piece("view-network", "raw", b"a"),
    ]
    files = [
        rearranged(data, lambda pieces: pieces[::-1]),
        rearranged(data, lambda pieces: idle + pieces),
        rearranged(data, lambda pieces: pieces + idle),
    ]
    assert assert_same_refusals(tmp_path, files) == [None] * 3
    assert all(scenes_equal(decode_mgs(file), decode_mgs(data)) for file in files)


@pytest.mark.parametrize(
    ("name", "number"), [("lobe-decoder", np.nan), ("appearance-decoder", np.inf)]
)
def test_weights_that_are_not_finite_are_refused(name: str, number: float, tmp_path: Path) -> None:
    scene, files = make_scene(SMALL), []
    weights = scene.lobe_decoder if name == "lobe-decoder" else scene.decoder
    halves = np.concatenate([part.numpy().ravel() for part in weights.values()])
    for value in (halves[7], number):
        halves[7] = value
        parts = parse_parts(encode_mgs(scene))
        piece = parts.piece(name)
        piece.codec, piece.data = "raw", halves.tobytes()
        files.append(parts.to_bytes())
    found = assert_same_refusals(tmp_path, files)
    assert found[0] is None and found[1] is not None


def test_quaternions_of_zeros_are_read_and_not_rendered(tmp_path: Path) -> None:
    scene = make_scene(SMALL)
    scene.codebooks["rotation"][:] = 0
    data = encode_mgs(scene)
    assert assert_same_refusals(tmp_path, [data]) == [None]
    drawn = decode_mgs(data)
    assert drawn.decode().render(drawn.views[0]).alpha.max() == 0
