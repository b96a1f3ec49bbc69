"""Write and read `.mgs` files. docs/reference/format.md is the specification."""

import math
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import asdict, replace
from itertools import repeat
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch
from torch import Tensor

from mobilegs.atomic import atomic_write, read_input
from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.mgs.container import MAGIC, VERSION, Stream, read_container, write_container
from mobilegs.mgs.contents import MgsContents, StreamContents
from mobilegs.mgs.header import (
    Header,
    header_fields,
    lobe_fields,
    parse_header,
    weighting_fields,
)
from mobilegs.mgs.positions import decode_positions, encode_positions
from mobilegs.mgs.quantized_scene import QuantizedScene, decoder_shapes, lobe_shapes, network_shapes
from mobilegs.mgs.streams import (
    decode_float16,
    decode_indices,
    encode_float16,
    encode_indices,
    in_level,
    index_width,
)
from mobilegs.mgs.uniform_streams import (
    REFINEMENT,
    attribute_codings,
    decode_columns,
    encode_columns,
)
from mobilegs.render.project import CLASSIC
from mobilegs.representation.codebooks import Attribute

Result = TypeVar("Result")

FILE_MAX = 1 << 32
# stream of the colour decoder, by the header's field `colors`
COLOR_STREAMS = {
    "linear": "color-matrices",
    "networks": "appearance-decoder",
    "latent_networks": "color-networks",
}
THREADS_MAX = 8  # each decodes one stream, which may take 3 MiB besides its output
# counted over used streams; far above real scenes; keeps small files from using much memory
GAUSSIANS_PER_BYTE = 1


def encode_mgs(scene: QuantizedScene) -> bytes:
    """Return the bytes of a `.mgs` file; equal scenes give equal bytes.

    Raises InputError if a file cannot hold the scene (see `QuantizedScene.check`).
    """
    scene.check()
    scene = scene.sorted()
    streams: list[Stream] = []
    if scene.network is not None:
        streams.append(_encode_tensors("view-network", scene.network, network_shapes()))
    if scene.lobe_shape is not None:
        shapes = lobe_shapes(scene.lobe_shape)
        streams.append(_encode_tensors("lobe-decoder", scene.lobe_decoder, shapes))
    shapes = decoder_shapes(scene.color)
    streams.append(_encode_tensors(COLOR_STREAMS[scene.color.colors], scene.decoder, shapes))
    if scene.codebooks:
        streams.append(_encode_tensors("codebooks", scene.codebooks, scene.cuts))
    codings = attribute_codings(scene)
    for number, rows in enumerate(scene.lod_slices()):
        level = scene.select(rows)
        positions = Stream("positions", "morton-class", encode_positions(level.positions))
        codes = encode_columns(level, codings) if scene.step_sizes else _encode_indices(level)
        streams += [replace(s, name=in_level(s.name, number)) for s in (positions, *codes)]
    content = sum(len(stream.data) for stream in streams)
    if len(scene) > GAUSSIANS_PER_BYTE * content:
        raise InputError(f"{len(scene)} Gaussians in {content} bytes: they are all the same")
    fields = header_fields(scene)
    major = 4 if "footprint" in fields else 3 if scene.lod_sizes else 2
    return write_container(fields, streams, major=major)


def _encode_indices(level: QuantizedScene) -> list[Stream]:
    return [
        encode_indices(f"{name}.{i}", column, level.codebooks[name].shape[1])
        for name in level.cuts
        for i, column in enumerate(level.indices[name].numpy().astype(np.uint16).T)
    ]


def _decode_indices(
    header: Header,
    codes: Mapping[Attribute, Tensor],
    stream: Callable[[str], Stream],
    pool: Executor,
) -> None:
    """Fill the `codes` of one LOD level."""
    for name, cut in header.cuts.items():
        table = codes[name].numpy()
        streams = [stream(f"{name}.{i}") for i in range(cut.count)]
        columns = pool.map(decode_indices, streams, repeat(len(table)), repeat(header.sizes[name]))
        for i, column in enumerate(columns):
            table[:, i] = column


def _decode_rows(
    header: Header, stream: Callable[[str], Stream]
) -> tuple[Tensor, dict[Attribute, Tensor]]:
    """Return positions and codes of all LOD levels, each decoded in place.

    Threads decode several streams at once: the C++ library releases the interpreter's lock.
    """
    indices: dict[Attribute, Tensor] = {}
    for name, coding in header.codings.items():
        indices[name] = binding.empty(header.count, len(coding.columns), dtype=torch.int32)
    for name, cut in header.cuts.items():
        indices[name] = binding.empty(header.count, cut.count, dtype=torch.int16)
    positions = binding.empty(header.count, 3, dtype=torch.float16)
    start = 0
    threads = min(torch.get_num_threads(), THREADS_MAX) if binding.decoders() else 1
    with ThreadPoolExecutor(threads) as pool:
        for number, size in enumerate(header.lod_sizes or (header.count,)):
            rows = slice(start, start + size)
            start += size

            def stream_of(name: str, number: int = number) -> Stream:
                return stream(in_level(name, number))

            coded = stream_of("positions")
            if coded.codec != "morton-class":
                raise InputError(
                    f"the .mgs file has the unknown codec '{coded.codec}' of positions"
                )
            decoded = pool.submit(decode_positions, coded.data, size)
            codes: dict[Attribute, Tensor] = {name: part[rows] for name, part in indices.items()}
            if header.codings:
                decode_columns(header.codings, codes, stream_of, pool)
            else:
                _decode_indices(header, codes, stream_of, pool)
            positions[rows] = decoded.result()
    return positions, indices


def decode_mgs(data: bytes) -> QuantizedScene:
    """Return the scene in the bytes of a `.mgs`, the inverse of `encode_mgs` up to the order.

    `decode_mgs(encode_mgs(scene))` equals `scene.sorted()`.

    Raises InputError if the bytes are not a `.mgs`, are damaged, or need a newer program.
    """
    fields, streams = read_container(data)
    header = parse_header(fields)
    _check_count(header, streams, len(data))

    def stream(name: str) -> Stream:
        if name not in streams:
            raise InputError(f"the .mgs file lacks its stream '{name}'")
        return streams[name]

    # weights come first: the header bounds their size
    decoder = _decode_tensors(
        stream(COLOR_STREAMS[header.color.colors]), decoder_shapes(header.color)
    )
    lobe_decoder, books = {}, {}
    network = None
    if header.lobes is not None:
        lobe_decoder = _decode_tensors(stream("lobe-decoder"), lobe_shapes(header.lobes))
    if header.network:
        network = _decode_tensors(stream("view-network"), network_shapes())
    if header.cuts:
        books = _decode_tensors(stream("codebooks"), _codebook_shapes(header))
    positions, indices = _decode_rows(header, stream)
    scene = QuantizedScene(
        positions=positions,
        grid=header.grid,
        indices=indices,
        lod_sizes=header.lod_sizes,
        codebooks={name: books[name] for name in header.cuts},
        decoder=decoder,
        lobe_shape=header.lobes,
        lobe_decoder=lobe_decoder,
        network=network,
        step_sizes={name: coding.step_size for name, coding in header.codings.items()},
        blend=header.blend,
        weighting=header.weighting,
        footprint=header.footprint,
        background=header.background,
        near=header.near,
        views=header.views,
        meta=header.meta,
    )
    scene.check()
    return scene


def inspect(data: bytes) -> MgsContents:
    """Report the content of a `.mgs` as JSON-ready values, without decoding its streams.

    Raises InputError if the bytes are not a `.mgs`, or the header is not valid.
    """
    fields, streams = read_container(data)
    header = parse_header(fields)
    _check_count(header, streams, len(data))
    raw = _raw_bytes(header, streams)
    rows: list[StreamContents] = [
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
    contents: MgsContents = {
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
        "mode": "sq" if header.codings else "nvq",
        "lobes": lobe_fields(header.lobes),
        "network": header.network,
        "views": len(header.views),
        "near": header.near,
        "weighting": weighting_fields(header.weighting),
        "meta": header.meta,
    }
    if header.lod_sizes:
        contents["layers"] = list(header.lod_sizes)
    if header.codings:
        sizes = {str(name): coding.step_size for name, coding in header.codings.items()}
        contents["step_sizes"] = sizes
    else:
        contents["codebook_sizes"] = {str(name): size for name, size in header.sizes.items()}
    if header.footprint != CLASSIC:
        contents["footprint"] = asdict(header.footprint)
    return contents


def read_mgs(path: Path | str) -> QuantizedScene:
    """Read the scene in a `.mgs` file.

    Raises InputError if the file cannot be read, or is not a valid `.mgs`.
    """
    return _parsed(path, decode_mgs)


def inspect_mgs(path: Path | str) -> MgsContents:
    """Report the content of a `.mgs` file as `inspect` does; raises like `read_mgs`."""
    return _parsed(path, inspect)


def write_mgs(path: Path | str, scene: QuantizedScene) -> int:
    """Write a scene to a `.mgs` file atomically; returns its size in bytes.

    Raises InputError if a file cannot hold the scene.
    """
    data = encode_mgs(scene)
    atomic_write(path, data)
    return len(data)


def _parsed(path: Path | str, parse: Callable[[bytes], Result]) -> Result:
    path = Path(path)
    data = read_input(path, FILE_MAX, (MAGIC,))
    try:
        return parse(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _encode_tensors(name: str, parts: Mapping[Any, Tensor], order: Iterable[str]) -> Stream:
    """Encode float16 tensors as one stream, concatenated row by row."""
    flat = torch.cat([parts[part].reshape(-1) for part in order])
    return encode_float16(name, flat.numpy().view(np.uint16))


def _decode_tensors(stream: Stream, shapes: Mapping[Any, tuple[int, ...]]) -> dict[Any, Tensor]:
    """Decode the float16 tensors of `shapes`, in its order, from one stream."""
    sizes = [math.prod(shape) for shape in shapes.values()]
    flat = torch.from_numpy(decode_float16(stream, sum(sizes)).view(np.float16))
    parts = zip(shapes.items(), flat.split(sizes), strict=True)
    return {name: part.reshape(shape).clone() for (name, shape), part in parts}


def _codebook_shapes(header: Header) -> dict[Attribute, tuple[int, ...]]:
    return {name: (cut.count, header.sizes[name], cut.length) for name, cut in header.cuts.items()}


def _check_count(header: Header, streams: Mapping[str, Stream], size: int) -> None:
    """Refuse more Gaussians than bytes; streams without a use do not count."""
    used = sum(len(streams[name].data) for name in _raw_bytes(header, streams) if name in streams)
    if header.count > GAUSSIANS_PER_BYTE * used:
        raise InputError(
            f"the .mgs file claims {header.count} Gaussians in {used} of its {size} bytes: "
            "it is damaged"
        )


def _raw_bytes(header: Header, streams: Mapping[str, Stream]) -> dict[str, int]:
    """Return the bytes without an entropy coder of each stream that the header uses, by name."""

    def float16_bytes(shapes: Mapping[Any, tuple[int, ...]]) -> int:
        return 2 * sum(math.prod(shape) for shape in shapes.values())

    raw = {COLOR_STREAMS[header.color.colors]: float16_bytes(decoder_shapes(header.color))}
    if header.network:
        raw["view-network"] = float16_bytes(network_shapes())
    if header.lobes is not None:
        raw["lobe-decoder"] = float16_bytes(lobe_shapes(header.lobes))
    if header.cuts:
        raw["codebooks"] = float16_bytes(_codebook_shapes(header))
    for number, size in enumerate(header.lod_sizes or (header.count,)):
        raw |= {in_level(name, number): n for name, n in _raw_rows(header, size).items()}
        refinement = in_level(REFINEMENT, number)
        if header.codings and refinement in streams:
            raw[refinement] = len(streams[refinement].data)  # has no entropy coder
    return raw


def _raw_rows(header: Header, count: int) -> dict[str, int]:
    """Return the same for the streams of one LOD level of `count` Gaussians."""
    raw = {"positions": 6 * count}
    for name, coding in header.codings.items():
        for i, column in enumerate(coding.columns):
            raw[f"{name}.{i}"] = (index_width(column.size) * count + 7) // 8
    for name, cut in header.cuts.items():
        bits = index_width(header.sizes[name]) * count
        raw |= {f"{name}.{i}": (bits + 7) // 8 for i in range(cut.count)}
    return raw
