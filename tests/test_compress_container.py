"""`.mgs` files: exact round trips, and what happens to damaged and hostile ones."""

import copy
import json
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fuzz.envelope import Piece, take_apart
from hypothesis import given, settings
from hypothesis import strategies as st

from mobilegs.camera import Camera, look_at
from mobilegs.compress import header as headers
from mobilegs.compress import lobes as lobe_shapes
from mobilegs.compress import rans
from mobilegs.compress.appearance import AppearanceDecoder
from mobilegs.compress.bits import pack_bits
from mobilegs.compress.codebooks import CUTS, Attribute, SubVectorCodebooks
from mobilegs.compress.codes import CodedScene, same
from mobilegs.compress.container import inspect, inspect_mgs, pack, read_mgs, unpack, write_mgs
from mobilegs.compress.encode import encode_scene
from mobilegs.compress.envelope import PREFIX
from mobilegs.compress.lobes import LobeDecoder, LobeShape
from mobilegs.compress.positions import Frame, morton_codes
from mobilegs.errors import InputError
from mobilegs.render import Weighting
from mobilegs.render.view_network import ViewNetwork

SIZES: dict[Attribute, int] = {"scale": 5, "rotation": 16, "appearance": 37, "opacity": 1}


# by name: what opacity and weight may come from
SHAPES = {
    "lobes": LobeShape(2, 6),
    "decoded": LobeShape(1, 0, (7, 5)),
    "all by latents": LobeShape(3, 6, (8,)),
}
SHAPE = {"degree": 2, "latents": 6, "hidden": []}  # the first of them in a header
VIEWS = ["nothing", "network", *SHAPES]


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def camera() -> Camera:
    viewmat = look_at(torch.tensor([0.3, 0.1, -4.0]), torch.zeros(3), torch.tensor([0.0, -1, 0]))
    K = torch.tensor([[40.1, 0, 16], [0, 41.7, 12], [0, 0, 1]])
    return Camera(viewmat, K, 32, 24)


def make_scene(count: int = 40, *, view: str = "lobes", seed: int = 0) -> CodedScene:
    g = seeded(seed)
    decoder = LobeDecoder(SHAPES[view], g) if view in SHAPES else None
    books: dict[Attribute, SubVectorCodebooks] = {}
    for name, cut in CUTS.items():
        centers = 0.5 * torch.randn(cut.count, SIZES[name], cut.length, generator=g)
        indices = torch.randint(SIZES[name], (count, cut.count), generator=g)
        books[name] = SubVectorCodebooks(centers - 1.5 * (name == "scale"), indices)
    if view in ("lobes", "all by latents"):
        centers = torch.randn(SHAPES[view].latents // 2, 8, 2, generator=g)
        books["lobes"] = SubVectorCodebooks(centers, torch.randint(8, (count, 3), generator=g))
    if view == "all by latents":
        books.pop("opacity")
    return encode_scene(
        torch.randn(count, 3, generator=g),
        books,
        frame=Frame(torch.tensor([0.1, -0.2, 0.3]), 1.7),
        decoder=AppearanceDecoder(g),
        lobe_decoder=decoder,
        network=ViewNetwork(g) if view == "network" else None,
        weighting=Weighting(exponent_max=6.5),
        background=torch.tensor([0.1, 0.5, 1.0]),
        near=0.05,
        views=[camera(), camera().resized(64, 48)],
        meta={"generator": "mobilegs 0", "psnr": 25.1, "steps": 7, "test": True, "notes": None},
    )


@pytest.fixture(scope="module")
def data() -> bytes:
    return pack(make_scene())


def split(data: bytes) -> tuple[dict[str, Any], bytes]:
    length = PREFIX.unpack_from(data)[3]
    return json.loads(data[PREFIX.size : PREFIX.size + length]), data[PREFIX.size + length :]


def join(header: dict[str, Any] | str, body: bytes, version: tuple[int, int] = (2, 1)) -> bytes:
    """A file with valid checksums around any header."""
    text = (header if isinstance(header, str) else json.dumps(header)).encode()
    text += b" " * (-(PREFIX.size + len(text)) % 8)
    fixed = struct.pack("<HHI", *version, len(text))
    return (
        b"MGS\x1a\r\n\x00\x01" + fixed + struct.pack("<I", zlib.crc32(fixed + text)) + text + body
    )


# --- round trips


@settings(deadline=None, max_examples=12)
@given(st.integers(1, 300), st.sampled_from(VIEWS), st.integers(0, 1000))
def test_unpacking_gives_the_packed_scene_in_morton_order(count: int, view: str, seed: int) -> None:
    scene = make_scene(count, view=view, seed=seed)
    assert same(unpack(pack(scene)), scene.sorted())


def test_a_scene_of_many_thousand_gaussians_comes_back() -> None:
    scene = make_scene(20_000)
    assert same(unpack(pack(scene)), scene.sorted())


def test_gaussians_in_the_same_place_keep_their_order() -> None:
    scene = make_scene(50)
    scene.positions[:] = scene.positions[:1]
    back = unpack(pack(scene))
    assert all(torch.equal(back.indices[name], scene.indices[name]) for name in CUTS)


def test_order_in_memory_does_not_change_a_byte_and_a_second_trip_neither() -> None:
    scene = make_scene(200)
    order = torch.randperm(200, generator=seeded())
    shuffled = replace(
        scene,
        positions=scene.positions[order],
        indices={name: rows[order] for name, rows in scene.indices.items()},
    )
    assert pack(shuffled) == pack(scene) == pack(unpack(pack(scene)))


def test_sorting_is_by_morton_code() -> None:
    codes = morton_codes(make_scene(100).sorted().positions)
    assert (np.diff(codes.astype(np.int64)) >= 0).all()


@pytest.mark.parametrize("size", [1, 2, 256, 1024, 4096])
def test_codebooks_of_every_size_come_back(size: int) -> None:
    scene = make_scene(100)
    scene.codebooks["rotation"] = torch.randn(2, size, 2, generator=seeded()).half()
    scene.indices["rotation"] = torch.randint(size, (100, 2), generator=seeded()).short()
    assert same(unpack(pack(scene)), scene.sorted())


def test_every_detail_counts_when_scenes_are_compared() -> None:
    scene = make_scene(10)
    flipped = {**scene.codebooks, "opacity": -scene.codebooks["opacity"]}
    others = [
        replace(scene, positions=-scene.positions),
        replace(scene, frame=replace(scene.frame, radius=1.8)),
        replace(scene, frame=replace(scene.frame, exponent=0)),
        replace(scene, codebooks=flipped),
        replace(scene, indices={**scene.indices, "scale": scene.indices["scale"].flip(0)}),
        replace(scene, lobe_decoder={**scene.lobe_decoder, "bias": -scene.lobe_decoder["bias"]}),
        replace(scene, lobe_shape=LobeShape(2, 6, (5,))),
        make_scene(10, view="nothing"),
        make_scene(10, view="network"),
        replace(scene, weighting=Weighting(exponent_max=7.0)),
        replace(scene, background=torch.zeros(3)),
        replace(scene, near=0.1),
        replace(scene, views=scene.views[:1]),
        replace(scene, meta={**scene.meta, "steps": 8}),
        make_scene(11),
    ]
    assert same(scene, copy.deepcopy(scene))
    assert not any(same(scene, other) for other in others)


def test_files_are_written_whole_and_read_back(tmp_path: Path) -> None:
    scene = make_scene()
    size = write_mgs(tmp_path / "deep" / "scene.mgs", scene)
    assert size == (tmp_path / "deep" / "scene.mgs").stat().st_size
    assert same(read_mgs(tmp_path / "deep" / "scene.mgs"), scene.sorted())


# --- decoding


def test_a_decoded_scene_has_the_values_that_training_saw() -> None:
    g = seeded()
    values = torch.randn(60, 6, generator=g)
    frame, means = Frame(torch.zeros(3), 1.0), torch.randn(60, 3, generator=g)
    decoder = AppearanceDecoder(g)
    books: dict[Attribute, SubVectorCodebooks] = {
        name: SubVectorCodebooks.fit(
            values[:, : cut.count * cut.length], length=cut.length, size=8, generator=g
        )
        for name, cut in CUTS.items()
    }
    coded = encode_scene(
        means, books, frame=frame, decoder=decoder, network=ViewNetwork(g),
        weighting=Weighting(), background=torch.ones(3),
    )  # fmt: skip
    scene = coded.decode()
    assert scene.blend == "sortfree" and torch.equal(scene.background, torch.ones(3))
    found = scene.gaussians
    assert torch.equal(found.means, frame.round(means))
    assert torch.equal(found.log_scales, books["scale"]())
    assert torch.equal(found.quats, books["rotation"]())
    assert torch.equal(found.logit_opacities, books["opacity"]()[:, 0])
    static, view = books["appearance"]().split(3, dim=1)
    positions = frame.normalised(frame.store(means))
    assert torch.allclose(found.sh, decoder(positions, static, view), atol=1e-6)


def test_a_scene_from_a_file_can_be_drawn(tmp_path: Path) -> None:
    write_mgs(tmp_path / "scene.mgs", make_scene())
    coded = read_mgs(tmp_path / "scene.mgs")
    drawn = coded.decode().render(coded.views[0])
    assert drawn.image.isfinite().all() and drawn.alpha.max() > 0.05


def test_decoding_leaves_the_global_random_state_alone() -> None:
    scene = make_scene()
    torch.manual_seed(1)
    expected = torch.rand(1)
    torch.manual_seed(1)
    unpack(pack(scene)).decode()
    assert torch.equal(torch.rand(1), expected)


# --- what is in a file


def test_the_bytes_of_the_table_add_up(tmp_path: Path) -> None:
    write_mgs(tmp_path / "scene.mgs", make_scene(100))
    report = inspect_mgs(tmp_path / "scene.mgs")
    parts = sum(row["bytes"] for row in report["streams"])
    assert parts + report["header_bytes"] + report["padding_bytes"] == report["file_bytes"]
    assert report["gaussians"] == 100 and report["meta"]["psnr"] == 25.1
    names = [row["name"] for row in report["streams"]]
    assert names[:4] == ["lobe-decoder", "appearance-decoder", "codebooks", "positions"]
    assert names[-4:] == ["opacity.0", "lobes.0", "lobes.1", "lobes.2"]
    assert all(row["bytes"] <= row["raw_bytes"] for row in report["streams"][:3])
    assert report["lobes"] == SHAPE
    json.dumps(report)
    network = inspect(pack(make_scene(100, view="network")))
    assert network["streams"][0]["name"] == "view-network" and network["lobes"] is None


def test_streams_start_at_multiples_of_eight_and_follow_the_order_of_use(data: bytes) -> None:
    header, body = split(data)
    assert (len(data) - len(body)) % 8 == 0
    start = 0
    for row in header["streams"]:
        assert zlib.crc32(body[start : start + row["bytes"]]) == row["crc32"]
        start += row["bytes"] + -row["bytes"] % 8
    assert start == len(body)


def test_index_streams_take_the_smaller_codec() -> None:
    scene = make_scene(3000)
    scene.indices["scale"] = torch.zeros(3000, 3).short()
    report = inspect(pack(scene))
    codecs = {row["name"]: row["codec"] for row in report["streams"]}
    assert codecs["scale.0"] == "rans" and codecs["rotation.0"] == "bits"


# --- damage


@settings(deadline=None, max_examples=150)
@given(st.data())
def test_a_file_cut_anywhere_is_refused(data: bytes, choice: st.DataObject) -> None:
    with pytest.raises(InputError):
        unpack(data[: choice.draw(st.integers(0, len(data) - 1))])


@settings(deadline=None, max_examples=200)
@given(st.data())
def test_a_flipped_bit_anywhere_is_refused(data: bytes, choice: st.DataObject) -> None:
    bit = choice.draw(st.integers(0, 8 * len(data) - 1))
    damaged = bytearray(data)
    damaged[bit // 8] ^= 1 << bit % 8
    with pytest.raises(InputError):
        unpack(bytes(damaged))


def test_every_bit_before_the_header_and_in_the_padding_counts(data: bytes) -> None:
    header, body = split(data)
    places = list(range(PREFIX.size))
    start = len(data) - len(body)
    for row in header["streams"]:
        end = start + row["bytes"]
        start = end + -row["bytes"] % 8
        places += range(end, start)
    for place in places:
        damaged = bytearray(data)
        damaged[place] ^= 16
        with pytest.raises(InputError):
            unpack(bytes(damaged))


def test_bytes_after_the_end_are_refused(data: bytes) -> None:
    for extra in (b"\0", bytes(8), data):
        with pytest.raises(InputError, match="too many"):
            unpack(data + extra)


@pytest.mark.parametrize(
    ("start", "sentence"),
    [
        (b"", "empty"),
        (b"ply\nformat binary_little_endian 1.0\n", "PLY"),
        (b"PK\x03\x04rest", "zip"),
        (b"\x1f\x8b\x08", "gzip"),
        (b"MGS\x1a\n\x00\x01", "binary mode"),
        (b"MGS\x1a\r", "damaged"),
        (b"something else", "not a .mgs scene"),
    ],
)
def test_foreign_files_are_recognised(start: bytes, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        unpack(start)


def test_an_unknown_major_version_is_refused_by_name(data: bytes) -> None:
    header, body = split(data)
    with pytest.raises(InputError, match=r"version 4\.0"):
        unpack(join(header, body, version=(4, 0)))


def test_a_later_minor_version_may_add_fields_and_streams(data: bytes) -> None:
    header, body = split(data)
    extra = b"something new"
    row = {"name": "new", "codec": "new", "bytes": 13, "crc32": zlib.crc32(extra)}
    later = {**header, "new": [1], "streams": [*header["streams"], row]}
    file = join(later, body + extra + bytes(3), version=(2, 7))
    assert same(unpack(file), unpack(data))
    assert inspect(file)["streams"][-1]["raw_bytes"] is None


def test_files_that_cannot_be_read_are_refused_by_name(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "bad.mgs").write_bytes(data[:-9])
    for path in (tmp_path / "none.mgs", tmp_path, tmp_path / "bad.mgs"):
        with pytest.raises(InputError, match=str(path)):
            read_mgs(path)
        with pytest.raises(InputError, match=str(path)):
            inspect_mgs(path)


# --- headers made by someone who knows how to make checksums


def places(value: Any, path: tuple = ()) -> list[tuple]:
    items = value.items() if isinstance(value, dict) else enumerate(value)
    found = []
    for key, inner in items:
        found.append((*path, key))
        if isinstance(inner, dict | list):
            found += places(inner, (*path, key))
    return found


STRANGE = st.sampled_from(
    [None, True, False, -1, 0, 1, 2, 3, 65, 4096, 4097, 2**26, 2**31, 2**40, 2**63, 10**400, 0.5,
     -0.0, 1e-300, 1e300, 3.3e38, "", "x", "raw", "bits", "rans", "halves", "sorted", "scale.0", [],
     {}, [0.0] * 3, [1e300] * 3, [[]], {"a": {}}, "\ud800"]
)  # fmt: skip


@settings(deadline=None, max_examples=200)
@given(st.data())
def test_a_crafted_header_is_refused_or_harmless(data: bytes, choice: st.DataObject) -> None:
    header, body = split(data)
    for _ in range(choice.draw(st.integers(1, 2))):
        path = choice.draw(st.sampled_from(places(header)))
        inner = header
        for key in path[:-1]:
            inner = inner[key]
        if choice.draw(st.booleans()) or isinstance(inner, list):
            inner[path[-1]] = choice.draw(STRANGE)
        else:
            del inner[path[-1]]
    crafted = join(header, body)
    try:
        scene = unpack(crafted)
    except InputError:
        return
    scene.check()


@settings(deadline=None, max_examples=150)
@given(st.data())
def test_crafted_streams_are_refused_or_harmless(data: bytes, choice: st.DataObject) -> None:
    header, body = split(data)
    streams, start = [], 0
    for row in header["streams"]:
        streams.append(bytearray(body[start : start + row["bytes"]]))
        start += row["bytes"] + -row["bytes"] % 8
    broken = choice.draw(st.sampled_from([s for s in streams if s]))
    for _ in range(choice.draw(st.integers(1, 3))):
        broken[choice.draw(st.integers(0, len(broken) - 1))] = choice.draw(st.integers(0, 255))
    del broken[choice.draw(st.integers(max(1, len(broken) - 3), len(broken))) :]
    for row, content in zip(header["streams"], streams, strict=True):
        row.update(bytes=len(content), crc32=zlib.crc32(content))
    padded = b"".join(bytes(content) + bytes(-len(content) % 8) for content in streams)
    try:
        scene = unpack(join(header, padded))
    except InputError:
        return
    scene.check()


@pytest.mark.parametrize(
    "text",
    ["", "[]", "1", "{", '{"streams":0}', '{"streams":[]}', "[" * 100_000, '{"count":NaN}',
     '{"near":' + "9" * 5000 + "}", '"\\ud800"'],
)  # fmt: skip
def test_a_header_that_is_not_ours_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        unpack(join(text, b""))


def test_a_header_of_bytes_that_are_no_text_is_refused() -> None:
    text = b"\xff\xfe{}" + bytes(8)
    fixed = struct.pack("<HHI", 2, 0, len(text))
    head = b"MGS\x1a\r\n\x00\x01" + fixed + struct.pack("<I", zlib.crc32(fixed + text))
    with pytest.raises(InputError, match="JSON"):
        unpack(head + text)


@pytest.mark.parametrize("count", [2**26, 300_000])
def test_a_count_beyond_the_bytes_is_refused_at_once(data: bytes, count: int) -> None:
    header, body = split(data)
    for read in (inspect, unpack):
        with pytest.raises(InputError, match=f"claims {count} Gaussians in"):
            read(join({**header, "count": count}, body))


DECODERS = {  # what they say to the first stream of rows, by its codec
    "rans": "a rANS stream (is longer or shorter than|ends early|does not end where)",
    "bits": "packed bits take more or fewer bytes than they should",
}


@pytest.mark.parametrize("codec", DECODERS)
@pytest.mark.parametrize("count", [300_000, 3000, 48, 32])
def test_a_false_count_is_refused_by_the_decoders_without_much_memory(
    data: bytes, codec: str, count: int
) -> None:
    parts = take_apart(data)
    assert parts.header["count"] == 40
    symbols, widths = np.arange(40, dtype=np.uint16) % 5, np.full(40, 3)
    first = parts.piece("scale.0")
    first.codec = codec
    first.data = (
        rans.encode(symbols, 5) if codec == "rans" else pack_bits(symbols.astype(np.uint64), widths)
    )
    unpack(parts.sealed())
    parts.header["count"] = count
    parts.pieces.append(Piece("spare", "none", bytes(count)))  # bytes enough for so many
    crafted = parts.sealed()
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=DECODERS[codec]):
            unpack(crafted)
        # the header speaks of 12 indices and a position for each Gaussian
        bound = 2 * (len(crafted) + count * (12 * 2 + 6)) + 100_000
        assert tracemalloc.get_traced_memory()[1] < bound
    finally:
        tracemalloc.stop()


def test_a_header_that_claims_gigabytes_is_refused_at_once(data: bytes) -> None:
    with pytest.raises(InputError, match="claims"):
        unpack(data[:12] + struct.pack("<I", 2**32 - 1) + data[16:])


# --- scenes that no file can hold


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"positions": torch.full((40, 3), torch.inf).half()}, "positions"),
        ({"frame": Frame(torch.zeros(3), torch.nan)}, "radius"),
        ({"frame": Frame(torch.zeros(3), 1.0, 15)}, "exponent"),
        ({"background": torch.tensor([0.0, 2.0, 0.0])}, "background"),
        ({"near": 0.0}, "near"),
        ({"weighting": Weighting(sigma=0.0)}, "sigma"),
        ({"views": [camera()] * 65}, "views"),
        ({"views": [replace(camera(), width=0)]}, "0 x 24"),
        ({"views": [replace(camera(), K=-camera().K)]}, "camera"),
        ({"views": [replace(camera(), viewmat=torch.full((4, 4), torch.nan))]}, "camera"),
        ({"meta": {"psnr": float("nan")}}, "psnr"),
        ({"meta": {"story": "x" * 5000}}, "story"),
        ({"meta": {str(i): i for i in range(65)}}, "65 notes"),
        ({"decoder": {}}, "decoder"),
        ({"indices": {}}, "scale"),
        ({"lobe_decoder": {}}, "lobe decoder"),
        ({"lobe_shape": None, "lobe_decoder": {}}, "nothing decodes"),
        ({"lobe_shape": LobeShape(2, 4)}, "do not make 4 latents"),
        ({"lobe_shape": LobeShape(2, 0)}, "nothing decodes"),
        ({"network": make_scene(view="network").network}, "one of them must go"),
    ],
)
def test_a_scene_that_no_file_can_hold_is_refused(change: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        pack(replace(make_scene(), **change))


@pytest.mark.parametrize(
    ("lobes", "sentence"),
    [
        (0, "field 'lobes'"),
        ([], "field 'lobes'"),
        ({}, "field 'hidden'"),
        ({**SHAPE, "degree": 4}, "field 'degree'"),
        ({**SHAPE, "degree": -1}, "field 'degree'"),
        ({**SHAPE, "degree": True}, "field 'degree'"),
        ({**SHAPE, "degree": 1}, "'lobe-decoder' of the .mgs file has a wrong length"),
        ({**SHAPE, "latents": 5}, "field 'codebooks.lobes'"),
        ({**SHAPE, "hidden": [0]}, "field 'hidden'"),
        ({**SHAPE, "hidden": [10**9]}, "field 'hidden'"),
        ({**SHAPE, "hidden": [5.0]}, "'lobe-decoder' of the .mgs file has a wrong length"),
        ({**SHAPE, "hidden": [5.5]}, "field 'hidden'"),
        ({**SHAPE, "hidden": [True]}, "field 'hidden'"),
        ({**SHAPE, "hidden": None}, "field 'hidden'"),
        (None, "field 'codebooks.lobes'"),
    ],
)
def test_lobes_that_cannot_be_are_refused(data: bytes, lobes: Any, sentence: str) -> None:
    header, body = split(data)
    assert header["lobes"] == SHAPE
    with pytest.raises(InputError, match=sentence):
        unpack(join({**header, "lobes": lobes}, body))


def test_a_header_that_does_not_speak_of_lobes_is_refused(data: bytes) -> None:
    header, body = split(data)
    del header["lobes"]
    with pytest.raises(InputError, match="field 'lobes'"):
        unpack(join(header, body))


@pytest.mark.parametrize(
    ("limit", "shape", "beyond", "field"),
    [
        ("LATENTS_MAX", (1, 32), (1, 33), "latents"),
        ("HIDDEN_LAYERS", (1, 2, (3,) * 3), (1, 2, (3,) * 4), "lobes.hidden"),
        ("HIDDEN_MAX", (1, 2, (256,)), (1, 2, (257,)), "hidden"),
    ],
)
def test_lobes_are_as_large_as_the_limits_and_no_larger(
    limit: str, shape: tuple, beyond: tuple, field: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def with_lobes(shape: LobeShape) -> CodedScene:
        g, scene = seeded(), make_scene(view="decoded")
        books = {"lobes": torch.randn(shape.latents, 4, 1, generator=g).half()}
        rows = torch.randint(4, (len(scene), shape.latents), generator=g, dtype=torch.int16)
        weights = LobeDecoder(shape, g).named_parameters()
        return replace(
            scene,
            codebooks=scene.codebooks | books,
            indices=scene.indices | {"lobes": rows},
            lobe_shape=shape,
            lobe_decoder={name: value.detach().half() for name, value in weights},
        ).sorted()

    largest = with_lobes(LobeShape(*shape))
    assert same(unpack(pack(largest)), largest)
    with monkeypatch.context() as patch:
        for module in (lobe_shapes, headers):
            patch.setattr(module, limit, getattr(module, limit) + 1)
        larger = with_lobes(LobeShape(*beyond))
        data = pack(larger)
        assert same(unpack(data), larger)  # nothing else is wrong with it
    for read in (inspect, unpack):
        with pytest.raises(InputError, match=f"the field '{field}' in the header"):
            read(data)


@pytest.mark.parametrize(
    "book",
    [None, [], {}, {"count": 33, "length": 1, "size": 8}, {"count": 3, "length": 1, "size": 8},
     {"count": 3, "length": 2, "size": 0}, {"count": 3, "length": 2, "size": 5000}],
)  # fmt: skip
def test_lobe_codebooks_that_cannot_be_are_refused_from_the_header_alone(
    data: bytes, book: Any
) -> None:
    header, body = split(data)
    assert header["codebooks"]["lobes"] == {"count": 3, "length": 2, "size": 8}
    with pytest.raises(InputError, match=r"lobes|count|length|size"):
        inspect(join({**header, "codebooks": {**header["codebooks"], "lobes": book}}, body))
    without = {name: b for name, b in header["codebooks"].items() if name != "lobes"}
    with pytest.raises(InputError, match=r"codebooks\.lobes"):
        inspect(join({**header, "codebooks": without}, body))


def _set(*path: str | int, to: Any) -> Callable[[dict[str, Any]], None]:
    """What gives a value inside of a header another value."""

    def change(header: dict[str, Any]) -> None:
        inner: Any = header
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = to

    return change


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (_set("positions", "radius", to=1e21), "centre or radius"),
        (_set("positions", "radius", to=0.0), "centre or radius"),
        (_set("positions", "center", 1, to=-1e21), "centre or radius"),
        (_set("near", to=-1), "near plane -1.0 is out of range"),
        (_set("near", to=1e21), "near plane"),
        (_set("background", 2, to=1.5), "background colour"),
        (_set("weighting", "sigma", to=-1), "sigma"),
        (_set("weighting", "background_weight", to=-0.1), "background weight"),
        (_set("views", 0, "K", 0, to=-5.0), "focal length"),
        (_set("views", 1, "K", 8, to=2.0), "matrices are not those of a camera"),
        (_set("views", 1, "viewmat", 12, to=0.5), "matrices are not those of a camera"),
        (_set("blend", to="sorted"), "blended sorted, but has lobes"),
    ],
)
def test_numbers_out_of_range_are_refused_from_the_header_alone(
    data: bytes, change: Callable[[dict[str, Any]], None], sentence: str
) -> None:
    header, body = split(data)
    change(header)
    for read in (inspect, unpack):
        with pytest.raises(InputError, match=sentence):
            read(join(header, body))


def test_lobes_beside_a_network_and_no_opacity_at_all_are_refused(data: bytes) -> None:
    header, body = split(data)
    with pytest.raises(InputError, match="one of them"):
        inspect(join({**header, "network": True}, body))
    books = {name: b for name, b in header["codebooks"].items() if name not in ("opacity", "lobes")}
    with pytest.raises(InputError, match="opacity"):
        inspect(join({**header, "codebooks": books, "lobes": None}, body))


def test_an_empty_scene_is_refused() -> None:
    scene = make_scene()
    nothing = {name: rows[:0] for name, rows in scene.indices.items()}
    with pytest.raises(InputError, match="0 Gaussians"):
        pack(replace(scene, positions=scene.positions[:0], indices=nothing))


@pytest.mark.parametrize("name", ["scale", "rotation", "appearance", "opacity", "lobes"])
def test_codes_out_of_range_are_refused(name: Attribute) -> None:
    scene = make_scene()
    scene.indices[name][3] = scene.codebooks[name].shape[1]
    with pytest.raises(InputError, match=f"{name} indices"):
        pack(scene)
    scene = make_scene()
    scene.codebooks[name][0, 0] = torch.inf
    with pytest.raises(InputError, match=f"{name} codebooks"):
        pack(scene)


def test_weights_that_are_not_finite_are_refused() -> None:
    scene = make_scene()
    scene.decoder["view1"][0, 0] = torch.nan
    with pytest.raises(InputError, match="colour decoder"):
        pack(scene)
