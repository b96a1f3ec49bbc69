"""`.mgs` files: a coded scene to bytes and back, exactly. docs/format.md is the specification."""

import math
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from mobilegs.atomic import atomic_write, file_size, read_if
from mobilegs.compress.codebooks import Attribute
from mobilegs.csrc import native
from mobilegs.errors import InputError
from mobilegs.mgs.container import MAGIC, VERSION, Stream, seal, unseal
from mobilegs.mgs.header import (
    Header,
    describe,
    describe_lobes,
    describe_weighting,
    parse,
)
from mobilegs.mgs.positions import decode_positions, encode_positions
from mobilegs.mgs.quantized_scene import CodedScene, decoder_shapes, lobe_shapes, network_shapes
from mobilegs.mgs.streams import (
    decode_halves,
    decode_indices,
    encode_halves,
    encode_indices,
    index_width,
)
from mobilegs.mgs.uniform_streams import FINER, pack_scalars, scalars_of, unpack_scalars

FILE_MAX = 1 << 32
DECODERS = {"linear": "color-matrices", "networks": "appearance-decoder"}  # their streams
AT_ONCE = 8  # streams that are decoded, each of which may take 3 MiB beside what it fills
# of the streams that are used; no real scene comes near; a small file must not ask for much memory
GAUSSIANS_PER_BYTE = 1


def pack(coded: CodedScene) -> bytes:
    """The scene as the bytes of a `.mgs`: equal scenes give equal bytes.

    Raises:
        InputError: the scene holds something that a file cannot (see `CodedScene.check`).
    """
    coded.check()
    coded = coded.sorted()
    streams: list[Stream] = []
    if coded.network is not None:
        streams.append(_pack_halves("view-network", coded.network, network_shapes()))
    if coded.lobe_shape is not None:
        shapes = lobe_shapes(coded.lobe_shape)
        streams.append(_pack_halves("lobe-decoder", coded.lobe_decoder, shapes))
    shapes = decoder_shapes(coded.color)
    streams.append(_pack_halves(DECODERS[coded.color.colors], coded.decoder, shapes))
    if coded.codebooks:
        streams.append(_pack_halves("codebooks", coded.codebooks, coded.cuts))
    scalars = scalars_of(coded)
    for number, rows in enumerate(coded.parts()):
        layer = coded.pick(rows)
        places = Stream("positions", "morton-class", encode_positions(layer.positions))
        codes = pack_scalars(layer, scalars) if coded.steps else _pack_indices(layer)
        streams += [replace(s, name=_in_layer(s.name, number)) for s in (places, *codes)]
    content = sum(len(stream.data) for stream in streams)
    if len(coded) > GAUSSIANS_PER_BYTE * content:
        raise InputError(f"{len(coded)} Gaussians in {content} bytes: they are all the same")
    return seal(describe(coded), streams, major=3 if coded.layers else 2)


def _pack_indices(coded: CodedScene) -> list[Stream]:
    return [
        encode_indices(f"{name}.{i}", column, coded.codebooks[name].shape[1])
        for name in coded.cuts
        for i, column in enumerate(coded.indices[name].numpy().astype(np.uint16).T)
    ]


def _unpack_indices(
    header: Header,
    codes: Mapping[Attribute, Tensor],
    stream: Callable[[str], Stream],
    pool: Executor,
) -> None:
    """Fill a layer's `codes`."""
    for name, cut in header.cuts.items():
        found = codes[name].numpy()
        streams = [stream(f"{name}.{i}") for i in range(cut.count)]
        columns = pool.map(decode_indices, streams, repeat(len(found)), repeat(header.sizes[name]))
        for i, column in enumerate(columns):
            found[:, i] = column


def _in_layer(name: str, number: int) -> str:
    return f"{name}@{number}" if number else name


def _unpack_rows(
    header: Header, stream: Callable[[str], Stream]
) -> tuple[Tensor, dict[Attribute, Tensor]]:
    """Positions and codes of all layers, each of which is decoded to where it stays.

    Streams are decoded side by side by the C++ library, which lets go of the interpreter.
    """
    indices: dict[Attribute, Tensor] = {}
    for name, scalar in header.scalars.items():
        indices[name] = native.room(header.count, len(scalar.columns), dtype=torch.int32)
    for name, cut in header.cuts.items():
        indices[name] = native.room(header.count, cut.count, dtype=torch.int16)
    positions = native.room(header.count, 3, dtype=torch.float16)
    start = 0
    many = min(torch.get_num_threads(), AT_ONCE) if native.library() else 1
    with ThreadPoolExecutor(many) as pool:
        for number, size in enumerate(header.layers or (header.count,)):
            rows = slice(start, start + size)
            start += size

            def stream_of(name: str, number: int = number) -> Stream:
                return stream(_in_layer(name, number))

            places = stream_of("positions")
            if places.codec != "morton-class":
                raise InputError(f"the .mgs file codes positions as '{places.codec}', unknown here")
            found = pool.submit(decode_positions, places.data, size)
            codes: dict[Attribute, Tensor] = {name: part[rows] for name, part in indices.items()}
            if header.scalars:
                unpack_scalars(header.scalars, codes, stream_of, pool)
            else:
                _unpack_indices(header, codes, stream_of, pool)
            positions[rows] = found.result()
    return positions, indices


def unpack(data: bytes) -> CodedScene:
    """The scene in the bytes of a `.mgs`: `unpack(pack(scene))` equals `scene.sorted()`.

    Raises:
        InputError: the bytes are not a `.mgs`, are damaged, or ask for what is not known here.
    """
    fields, streams = unseal(data)
    header = parse(fields)
    _check_count(header, streams, len(data))

    def stream(name: str) -> Stream:
        if name not in streams:
            raise InputError(f"the .mgs file lacks its stream '{name}'")
        return streams[name]

    # first what takes little: its lengths are known
    decoder = _unpack_halves(stream(DECODERS[header.color.colors]), decoder_shapes(header.color))
    lobe_decoder, books = {}, {}
    network = None
    if header.lobes is not None:
        lobe_decoder = _unpack_halves(stream("lobe-decoder"), lobe_shapes(header.lobes))
    if header.network:
        network = _unpack_halves(stream("view-network"), network_shapes())
    if header.cuts:
        books = _unpack_halves(stream("codebooks"), _codebook_shapes(header))
    positions, indices = _unpack_rows(header, stream)
    coded = CodedScene(
        positions=positions,
        frame=header.frame,
        indices=indices,
        layers=header.layers,
        codebooks={name: books[name] for name in header.cuts},
        decoder=decoder,
        lobe_shape=header.lobes,
        lobe_decoder=lobe_decoder,
        network=network,
        steps={name: scalar.step for name, scalar in header.scalars.items()},
        blend=header.blend,
        weighting=header.weighting,
        background=header.background,
        near=header.near,
        views=header.views,
        meta=header.meta,
    )
    coded.check()
    return coded


def inspect(data: bytes) -> dict[str, Any]:
    """What is in a `.mgs`, byte by byte, as JSON-ready values; the streams are not decoded.

    `streams` lists name, codec, bytes, bytes per Gaussian, whether the header has a use for it
    (`used`) and `raw_bytes` (packed without an entropy coder; None where there is no use); with
    `header_bytes` and `padding_bytes` they add up to `file_bytes`.
    """
    fields, streams = unseal(data)
    header = parse(fields)
    _check_count(header, streams, len(data))
    raw = _raw_bytes(header, streams)
    rows = [
        {
            "name": stream.name,
            "codec": stream.codec,
            "bytes": len(stream.data),
            "bytes_per_gaussian": len(stream.data) / header.count,
            "used": stream.name in raw,
            "raw_bytes": raw.get(stream.name),
        }
        for stream in streams.values()
    ]
    content = sum(row["bytes"] for row in rows)
    padding = sum(-row["bytes"] % 8 for row in rows)
    return {
        "version": "{}.{}".format(*VERSION.unpack_from(data, 8)),
        "blend": header.blend,
        "sh_degree": header.color.degree,
        "colors": header.color.colors,
        "color_latents": header.color.latents,
        "file_bytes": len(data),
        "gaussians": header.count,
        "bytes_per_gaussian": len(data) / header.count,
        "header_bytes": len(data) - content - padding,
        "padding_bytes": padding,
        "streams": rows,
        **({"layers": list(header.layers)} if header.layers else {}),
        "mode": "sq" if header.scalars else "nvq",
        **(
            {"steps": {name: scalar.step for name, scalar in header.scalars.items()}}
            if header.scalars
            else {"codebook_sizes": header.sizes}
        ),
        "lobes": describe_lobes(header.lobes),
        "network": header.network,
        "views": len(header.views),
        "near": header.near,
        "weighting": describe_weighting(header.weighting),
        "meta": header.meta,
    }


def read_mgs(path: Path | str) -> CodedScene:
    """The scene in a `.mgs` file.

    Raises:
        InputError: the file cannot be read, or is not a sound `.mgs`.
    """
    data = _read_bytes(path)
    try:
        return unpack(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def inspect_mgs(path: Path | str) -> dict[str, Any]:
    """`inspect` of a `.mgs` file; raises like `read_mgs`."""
    data = _read_bytes(path)
    try:
        return inspect(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_mgs(path: Path | str, coded: CodedScene) -> int:
    """Write a scene to a `.mgs` file, whole or not at all; returns its size in bytes."""
    data = pack(coded)
    atomic_write(path, data)
    return len(data)


def _read_bytes(path: Path | str) -> bytes:
    path = Path(path)
    try:
        size = file_size(path)
        if size > FILE_MAX:
            raise InputError(f"{path}: {size} bytes are too many for a .mgs scene")
        return read_if(path, (MAGIC,))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None


def _pack_halves(name: str, parts: Mapping[Any, Tensor], order: Iterable[str]) -> Stream:
    """Tensors of halves as one stream, one after the other, rows first."""
    flat = torch.cat([parts[part].reshape(-1) for part in order])
    return encode_halves(name, flat.numpy().view(np.uint16))


def _unpack_halves(stream: Stream, shapes: Mapping[Any, tuple[int, ...]]) -> dict[Any, Tensor]:
    """The tensors of `shapes`, in its order, from one stream."""
    sizes = [math.prod(shape) for shape in shapes.values()]
    flat = torch.from_numpy(decode_halves(stream, sum(sizes)).view(np.float16))
    parts = zip(shapes.items(), flat.split(sizes), strict=True)
    return {name: part.reshape(shape).clone() for (name, shape), part in parts}


def _codebook_shapes(header: Header) -> dict[Attribute, tuple[int, ...]]:
    return {name: (cut.count, header.sizes[name], cut.length) for name, cut in header.cuts.items()}


def _check_count(header: Header, streams: Mapping[str, Stream], size: int) -> None:
    """Bytes of streams that nobody uses could be any, and entitle to nothing."""
    used = sum(len(streams[name].data) for name in _raw_bytes(header, streams) if name in streams)
    if header.count > GAUSSIANS_PER_BYTE * used:
        raise InputError(
            f"the .mgs file claims {header.count} Gaussians in {used} of its {size} bytes: "
            "it is damaged"
        )


def _raw_bytes(header: Header, streams: Mapping[str, Stream]) -> dict[str, int]:
    """Bytes without an entropy coder, by name of each stream that the header has a use for."""

    def halves(shapes: Mapping[Any, tuple[int, ...]]) -> int:
        return 2 * sum(math.prod(shape) for shape in shapes.values())

    raw = {DECODERS[header.color.colors]: halves(decoder_shapes(header.color))}
    if header.network:
        raw["view-network"] = halves(network_shapes())
    if header.lobes is not None:
        raw["lobe-decoder"] = halves(lobe_shapes(header.lobes))
    if header.cuts:
        raw["codebooks"] = halves(_codebook_shapes(header))
    for number, size in enumerate(header.layers or (header.count,)):
        raw |= {_in_layer(name, number): n for name, n in _raw_rows(header, size).items()}
        finer = _in_layer(FINER, number)
        if header.scalars and finer in streams:
            raw[finer] = len(streams[finer].data)  # nothing codes them
    return raw


def _raw_rows(header: Header, count: int) -> dict[str, int]:
    """The same for the streams of `count` Gaussians, as far as the header tells it."""
    raw = {"positions": 6 * count}
    for name, scalar in header.scalars.items():
        for i, column in enumerate(scalar.columns):
            raw[f"{name}.{i}"] = (index_width(column.size) * count + 7) // 8
    for name, cut in header.cuts.items():
        bits = index_width(header.sizes[name]) * count
        raw |= {f"{name}.{i}": (bits + 7) // 8 for i in range(cut.count)}
    return raw
