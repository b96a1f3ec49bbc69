"""The bytes that Huffman codes would take for the indices, which the file has in rANS or bits.

The paper codes indices by Huffman.
"""

import heapq

import numpy as np
from jaxtyping import Int

from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.mgs.streams import in_level
from mobilegs.mgs.uniform_streams import attribute_codings, column_symbols


def huffman_bytes(scene: QuantizedScene) -> dict[str, int]:
    """Return the bytes of each index stream in a Huffman code of its own, by name of the stream.

    A stream has the bits of its code words, and a table for the canonical code: a byte with the
    bits of the longest length, then the length of each symbol in as many bits.
    """
    codings, stream_bytes = attribute_codings(scene), {}
    for number, rows in enumerate(scene.lod_slices()):
        level = scene.select(rows)
        for name, codes in level.indices.items():
            if name in codings:
                columns = column_symbols(level, name, codings[name])
                sizes = [column.size for column in codings[name].columns]
            else:
                columns = codes.numpy().T
                sizes = [level.codebooks[name].shape[1]] * len(columns)
            for i, (column, size) in enumerate(zip(columns, sizes, strict=True)):
                counts = np.bincount(column, minlength=size)
                lengths = code_lengths(counts)
                bits = 8 + size * int(lengths.max()).bit_length() + int(counts @ lengths)
                stream_bytes[in_level(f"{name}.{i}", number)] = (bits + 7) // 8
    return stream_bytes


def code_lengths(counts: Int[np.ndarray, "a"]) -> Int[np.ndarray, "a"]:
    """Return the bits of each symbol's code word in a Huffman code for these counts.

    The code has the fewest bits of all prefix codes (Huffman 1952). Symbols that do not occur have
    length 0; so does a symbol that occurs alone.
    """
    occurring = np.flatnonzero(counts)
    heap = [(int(counts[i]), int(i)) for i in occurring]
    heapq.heapify(heap)
    parent: dict[int, int] = {}
    while len(heap) > 1:
        (few, one), (more, other) = heapq.heappop(heap), heapq.heappop(heap)
        node = parent[one] = parent[other] = len(counts) + len(parent)
        heapq.heappush(heap, (few + more, node))
    depth: dict[int, int] = {}
    for node in sorted(parent, reverse=True):  # a parent has a larger number than its children
        depth[node] = depth.get(parent[node], 0) + 1
    lengths = np.zeros(len(counts), np.int64)
    lengths[occurring] = [depth.get(int(i), 0) for i in occurring]
    return lengths
