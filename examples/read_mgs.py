"""Decode .mgs files with numpy: written from docs/reference/format.md, without torch and mobilegs.

    python examples/read_mgs.py scene.mgs [--npz arrays.npz]

Prints the streams and the ranges of the decoded arrays. It checks what it needs to decode safely.
It does not check the limits of section 2. Sections are those of docs/reference/format.md.
"""

import argparse
import json
import struct
import zlib
from pathlib import Path

import numpy as np

MAGIC = b"MGS\x1a\r\n\x00\x01"
C0 = np.float32(0.28209479)
COLUMNS = {"scale": 3, "rotation": 3, "appearance": 6, "opacity": 1}  # of the mode sq
REFINEMENT_LIMITS = np.array([53, 210, 405, 600, 787, 970, 1151, 1329], np.float32) / 256


def need(condition: object, part: str) -> None:
    if not condition:
        raise ValueError(f"this is not a valid .mgs file: {part}")


# --- 1. container ---------------------------------------------------------------------------------


def number(text: str) -> int | float:
    """Parse a number with a point or an exponent: JSON has one type of number, so 3.0 is 3."""
    value = float(text)
    return int(value) if value.is_integer() else value


def read_container(data: bytes) -> tuple[dict, dict[str, tuple[str, bytes]]]:
    """Return the header, and the codec and bytes of each stream by name."""
    need(data[:8] == MAGIC and len(data) >= 20, "its first bytes")
    major, _, size, crc = struct.unpack_from("<HHII", data, 8)
    need(major in (2, 3, 4) and size <= 1 << 20, "its version")
    need(crc == zlib.crc32(data[8:16] + data[20 : 20 + size]), "the checksum of its header")
    header = json.loads(data[20 : 20 + size], parse_float=number)
    place, streams = 20 + size, {}
    if major == 2:
        header.pop("layers", None)  # an unknown field
    for row in header["streams"]:
        part = data[place : place + row["bytes"]]
        need(len(part) == row["bytes"] and zlib.crc32(part) == row["crc32"], row["name"])
        streams[row["name"]] = (row["codec"], part)
        end, place = place + row["bytes"], place + (row["bytes"] + 7) // 8 * 8
        need(not any(data[end:place]), "its padding")
    need(place == len(data), "its length")
    return header, streams


# --- 4. codecs ------------------------------------------------------------------------------------


def bits_of(data: bytes) -> np.ndarray:
    return np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little")


def unpack_bits(data: bytes, widths: np.ndarray) -> np.ndarray:
    """Unpack numbers of the given widths, the lowest bit first."""
    widths = widths.astype(np.int64)
    need(len(data) == (widths.sum() + 7) // 8, "a stream of bits")
    bits = np.append(bits_of(data), np.zeros(64, np.uint8))  # so that every read is in range
    begin, found = np.cumsum(widths) - widths, np.zeros(len(widths), np.uint64)
    for bit in range(int(widths.max(initial=0))):
        found |= np.where(bit < widths, bits[begin + bit], 0).astype(np.uint64) << np.uint64(bit)
    return found


def frequencies(data: bytes, contexts: int, alphabet: int) -> np.ndarray:
    """Read the frequency tables of `rans`, `[contexts, alphabet]`."""
    bits, place, tables = bits_of(data).tolist(), 0, np.zeros((contexts, alphabet), np.int64)

    def number(width: int) -> int:
        nonlocal place
        place += width
        return sum(bit << i for i, bit in enumerate(bits[place - width : place]))

    for table in tables:
        if not number(1):
            continue
        occurring = [symbol for symbol in range(alphabet) if number(1)]
        k = number(4)
        for symbol in occurring[:-1]:
            zeros = 0
            while not number(1):
                zeros += 1
                need(place < len(bits), "a table")
            need(zeros + k <= 14, "a table")
            table[symbol] = number(zeros + k) + (1 << zeros + k) - (1 << k) + 1
        table[occurring[-1]] = 16384 - table.sum()
        need(table[occurring[-1]] >= 1, "a table")
    need(place <= len(bits) < place + 8, "a table's length")
    return tables


def rans(data: bytes, count: int, alphabet: int) -> np.ndarray:
    """Decode `count` symbols below `alphabet`; a round decodes one symbol per lane."""
    size, contexts, table_bytes, words_count = struct.unpack_from("<HHII", data)
    need(size == alphabet and contexts in (1, alphabet), "an alphabet")
    lanes = min(256, 1 << max(1, count // 2048).bit_length() - 1)
    states_at = 12 + table_bytes
    need(len(data) == states_at + 4 * lanes + 2 * words_count, "the length of a stream")
    frequency = frequencies(data[12:states_at], contexts, alphabet)
    start = np.cumsum(frequency, axis=1) - frequency
    symbol_at = np.full((contexts, 16384), -1, np.int64)
    for c, row in enumerate(frequency):
        if row.any():
            symbol_at[c] = np.repeat(np.arange(alphabet), row)
    states = np.frombuffer(data, "<u4", lanes, states_at).astype(np.int64)
    words = np.frombuffer(data, "<u2", words_count, states_at + 4 * lanes).astype(np.int64)
    each, rest = divmod(count, lanes)
    rounds = each + (rest > 0)
    decoded, used = np.zeros((rounds, lanes), np.int64), 0
    for t in range(rounds):
        live = slice(lanes if t < each else rest)
        x = states[live]
        c = decoded[t - 1, live] if contexts > 1 and t else np.zeros_like(x)
        slot = x & 16383
        s = symbol_at[c, slot]
        need((s >= 0).all(), "an unused context")
        x = frequency[c, s] * (x >> 14) + slot - start[c, s]
        short = np.flatnonzero(x < 65536)
        need(used + len(short) <= words_count, "a stream that ends too soon")
        x[short] = x[short] << 16 | words[used : used + len(short)]
        states[live], decoded[t, live], used = x, s, used + len(short)
    need(used == words_count and (states == 65536).all(), "the end of a stream")
    return np.concatenate([decoded[: each + (lane < rest), lane] for lane in range(lanes)])


def indices(stream: tuple[str, bytes], count: int, size: int) -> np.ndarray:
    codec, data = stream
    if codec == "rans":
        return rans(data, count, size)
    need(codec == "bits", f"the codec {codec}")
    found = unpack_bits(data, np.full(count, (size - 1).bit_length())).astype(np.int64)
    need((found < size).all(), "an index")
    return found


def float16_numbers(stream: tuple[str, bytes], count: int) -> np.ndarray:
    """Decode `count` float16 numbers, as float32."""
    codec, data = stream
    if codec == "raw":
        pattern = np.frombuffer(data, "<u2")
    else:
        need(codec in ("halves", "planes"), f"the codec {codec}")
        end = 4 + struct.unpack_from("<I", data)[0]
        low = rans(data[end:], count, 256) if codec == "planes" else np.frombuffer(data[end:], "u1")
        need(len(low) == count, "a stream of float16 numbers")
        pattern = (rans(data[4:end], count, 256) << 8 | low).astype(np.uint16)
    need(len(pattern) == count, "a stream of float16 numbers")
    return pattern.view(np.float16).astype(np.float32)


def cut(flat: np.ndarray, shapes: list[tuple[int, ...]]) -> list[np.ndarray]:
    """Cut consecutive numbers into arrays."""
    ends = np.cumsum([np.prod(shape, dtype=int) for shape in shapes])
    return [part.reshape(s) for part, s in zip(np.split(flat, ends[:-1]), shapes, strict=True)]


def matrices(stream: tuple[str, bytes], *shapes: tuple[int, ...]) -> list[np.ndarray]:
    return cut(float16_numbers(stream, sum(int(np.prod(shape)) for shape in shapes)), list(shapes))


# --- 5. positions ---------------------------------------------------------------------------------


def positions(stream: tuple[str, bytes], count: int) -> np.ndarray:
    """Decode positions before the exponent, float32 `[count, 3]`."""
    codec, data = stream
    need(codec == "morton-class", f"the codec {codec}")
    end = 4 + struct.unpack_from("<I", data)[0]
    classes = rans(data[4:end], count, 49)
    widths = np.maximum(classes - 1, 0)
    lower = unpack_bits(data[end:], widths)
    differences = np.where(classes > 0, np.uint64(1) << widths.astype(np.uint64) | lower, 0)
    codes = np.cumsum(differences, dtype=np.uint64)
    need(codes[-1] < 1 << 48, "a position")
    ordered = np.zeros((count, 3), np.uint64)
    for bit in range(16):
        for axis in range(3):
            one = codes >> np.uint64(3 * bit + axis) & np.uint64(1)
            ordered[:, axis] |= one << np.uint64(bit)
    ordered = ordered.astype(np.uint16)
    pattern = np.where(ordered & 0x8000, ordered & 0x7FFF, ordered ^ 0xFFFF).astype(np.uint16)
    return pattern.view(np.float16).astype(np.float32)


# --- 6. codes -------------------------------------------------------------------------------------


def attributes(header: dict, streams: dict, count: int, suffix: str) -> dict[str, np.ndarray]:
    """Return the attributes of one LOD level; `suffix` ends the names of its streams."""
    if header["mode"] == "nvq":
        books = header["codebooks"]
        names = [name for name in (*COLUMNS, "lobes") if name in books]
        shapes = [
            tuple(books[name][part] for part in ("count", "size", "length")) for name in names
        ]
        entries = dict(zip(names, matrices(streams["codebooks"], *shapes), strict=True))
        return {
            name: np.concatenate(
                [
                    book[indices(streams[f"{name}.{j}{suffix}"], count, book.shape[0])]
                    for j, book in enumerate(entries[name])
                ],
                axis=1,
            )
            for name in names
        }
    need(header["mode"] == "sq", f"the mode {header['mode']}")
    cells, found = {}, {}
    for name, scalar in header["scalars"].items():
        rows = zip(scalar["size"], scalar["least"], strict=True)
        columns = [
            indices(streams[f"{name}.{j}{suffix}"], count, int(size)) + int(least)
            for j, (size, least) in enumerate(rows)
        ]
        cells[name] = np.stack(columns, axis=1)
        found[name] = np.float32(scalar["step"]) * cells[name].astype(np.float32)
    codec, data = streams[f"rotation-finer{suffix}"]
    need(codec == "bits", f"the codec {codec}")
    step_size = np.float32(header["scalars"]["rotation"]["step"])
    found["rotation"] = rotations(cells["rotation"], found["scale"], step_size, data)
    return found


def rotations(
    cells: np.ndarray, log_scales: np.ndarray, step_size: np.float32, data: bytes
) -> np.ndarray:
    """Return the quaternions of mode `sq` from cells of angles and their refinement bits."""
    others = log_scales[:, [1, 2, 0]] - log_scales[:, [2, 0, 1]]
    bits = (np.abs(others)[..., None] >= REFINEMENT_LIMITS).sum(-1)
    within = unpack_bits(data, bits.ravel()).reshape(-1, 3).astype(np.float64)
    angles = step_size * (cells - 0.5 + (within + 0.5) / 2.0**bits)
    angle = np.linalg.norm(angles, axis=1, keepdims=True)
    axis = np.where(angle > 1e-8, np.sin(angle / 2) / np.maximum(angle, 1e-8), 0.5) * angles
    return np.concatenate([np.cos(angle / 2), axis], axis=1).astype(np.float32)


# --- 7. colour ------------------------------------------------------------------------------------


def harmonics(header: dict, streams: dict, u: np.ndarray, latents: np.ndarray) -> np.ndarray:
    """Decode the spherical harmonics of the colour, `[count, 3 (degree + 1)^2]`."""
    static, view = latents[:, :3], latents[:, 3:]
    rest = 3 * (header["sh_degree"] + 1) ** 2 - 3
    if header.get("colors", "networks") == "linear":
        static2, view2 = matrices(streams["color-matrices"], (3, 3), (rest, view.shape[1]))
        return np.concatenate([static @ static2.T, view @ view2.T], axis=1)

    def leaky(hidden: np.ndarray) -> np.ndarray:
        return np.where(hidden > 0, hidden, np.float32(0.01) * hidden)

    if header.get("colors") == "latent_networks":
        shapes = ((128, 6), (3, 64), (rest, 64))
        both1, static2, view2 = matrices(streams["color-networks"], *shapes)
        hidden = leaky(latents @ both1.T)
        return np.concatenate([hidden[:, :64] @ static2.T, hidden[:, 64:] @ view2.T], axis=1)
    shapes = ((64, 96), (13, 64), (64, 16), (3, 64), (64, 16), (rest, 64))
    weights = matrices(streams["appearance-decoder"], *shapes)
    context1, context2, static1, static2, view1, view2 = weights
    x, y, z = u.T
    length = np.maximum(1, np.sqrt(x * x + y * y + z * z))[:, None]
    v = (2 - 1 / length) * (u / length) * np.float32(0.25) + np.float32(0.5)
    turns = (v[:, :, None] * np.exp2(np.arange(-1, 15, dtype=np.float32))).reshape(len(u), 48)
    angles = 2 * np.pi * (turns - np.round(turns)).astype(np.float64)
    encoded = np.concatenate([np.sin(angles), np.cos(angles)], axis=1).astype(np.float32)
    context = np.maximum(encoded @ context1.T, 0) @ context2.T

    def head(numbers: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        return leaky(np.concatenate([context, numbers], axis=1) @ first.T) @ last.T

    return np.concatenate([head(static, static1, static2), head(view, view1, view2)], axis=1)


# --- 8. lobes -------------------------------------------------------------------------------------


def lobes_of(header: dict, streams: dict, values: dict, sh: np.ndarray) -> np.ndarray:
    """Decode the harmonics of the opacity's logit and of phi; constant without a lobe decoder."""
    count, shape, base = len(sh), header["lobes"], values.get("opacity")
    if shape is None:
        return np.concatenate([values["opacity"], np.ones((count, 1), np.float32)], axis=1) / C0
    latents = values.get("lobes", np.zeros((count, 0), np.float32))
    outputs, widths = 2 * (shape["degree"] + 1) ** 2, shape["hidden"]
    inputs = [19 + shape["latents"], *widths]
    layers = list(zip([*widths, outputs], inputs, strict=True)) if widths else []
    shapes = [(outputs,), (shape["latents"], outputs), *layers, *((width,) for width in widths)]
    bias, basis, *weights = matrices(streams["lobe-decoder"], *shapes)
    lobes = bias + latents @ basis
    if widths:
        h = np.concatenate(
            [
                unit(np.pad(sh, ((0, 0), (0, 12)))[:, :12]),
                unit(np.exp(values["scale"])),
                unit(values["rotation"]),
                latents,
            ],
            axis=1,
        )
        for matrix, offset in zip(weights, weights[len(widths) + 1 :], strict=False):
            h = np.maximum(h @ matrix.T + offset, 0)
        lobes = lobes + h @ weights[len(widths)].T
    if base is not None:
        lobes[:, :1] += base / C0
    return lobes


def unit(rows: np.ndarray) -> np.ndarray:
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), np.float32(1e-12))


# --- the whole file -------------------------------------------------------------------------------


def decode(data: bytes) -> tuple[dict, dict[str, np.ndarray]]:
    """Return the header, and float32 arrays with a row per Gaussian.

    They are means, log_scales, quats, sh and lobes.
    """
    header, streams = read_container(data)
    sizes = header.get("layers") or [header["count"]]
    need(sum(sizes) == header["count"] <= len(data), "the number of its Gaussians")
    places, parts = [], []
    for level, size in enumerate(sizes):
        suffix = f"@{level}" if level else ""
        places.append(positions(streams[f"positions{suffix}"], size))
        parts.append(attributes(header, streams, size, suffix))
    values = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    grid = header["positions"]
    u = np.concatenate(places) * np.float32(2.0 ** grid["exponent"])
    sh = harmonics(header, streams, u, values["appearance"])
    return header, {
        "means": np.float32(grid["center"]) + np.float32(grid["radius"]) * u,
        "log_scales": values["scale"],
        "quats": unit(values["rotation"]),
        "sh": sh,
        "lobes": lobes_of(header, streams, values, sh),
    }


def main() -> None:
    options = argparse.ArgumentParser(description="Decode a .mgs file with numpy.")
    options.add_argument("scene", type=Path)
    options.add_argument("--npz", type=Path, help="write the arrays to this file")
    given = options.parse_args()
    data = given.scene.read_bytes()
    header, arrays = decode(data)
    for row in header["streams"]:
        print(f"{row['name']:20} {row['codec']:14} {row['bytes']:9,} bytes")
    print(f"{header['count']:,} Gaussians in {len(data):,} bytes, blended {header['blend']}")
    for name, array in arrays.items():
        print(f"{name:12} {array.shape!s:16} {array.min():.4g} to {array.max():.4g}")
    if given.npz:
        np.savez_compressed(given.npz, **arrays)
        print(f"wrote {given.npz}")


if __name__ == "__main__":
    main()
