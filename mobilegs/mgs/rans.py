"""Static interleaved rANS: an entropy coder that decodes with table look-ups.

rANS is by Duda (2013), the interleaving by Giesen (2014). Probabilities are multiples of 2^-14, a
state has 32 bits, the stream is a sequence of 16-bit words. L states ("lanes") read the words in
turn; each lane codes its own run of consecutive symbols, so that the previous symbol can serve as
context. In each round every lane codes one symbol. The stream is undamaged if every lane ends in
the encoder's start state and no word is left.
"""

import heapq
import struct

import numpy as np
from jaxtyping import Int, Int32, UInt16, UInt32

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.mgs.bits import bit_lengths, pack_bits

PRECISION = 14
TOTAL = 1 << PRECISION
STATE_LOW = 1 << 16
ALPHABET_MAX = 4096
CONTEXTS_MAX = 64  # a decoder's tables have 2^14 entries for each
LANES_MAX = 256
LANE_SYMBOLS = 2048  # least per lane: a lane takes about 2.5 bytes
HEADER = struct.Struct("<HHII")  # alphabet, contexts, bytes of tables, words
SYMBOL_BITS = 2 + 2 * PRECISION  # most that a symbol takes in a table


def encode(symbols: UInt16[np.ndarray, "n"], alphabet: int, *, contextual: bool = False) -> bytes:
    """Encode `symbols`, each below `alphabet` (1 to 4096), with their frequency tables.

    `contextual` uses a table for each previous symbol (alphabets up to 64). The result is
    deterministic: arithmetic is in integers or exactly rounded.
    """
    contexts = alphabet if contextual else 1
    lanes = lane_count(len(symbols))
    order, active = _layout(len(symbols), lanes)
    rows = symbols[order]  # [rounds, lanes]; finished lanes repeat a symbol
    context = np.zeros_like(rows)
    if contextual:
        context[1:] = rows[:-1]
    entries = context.astype(np.int32) * alphabet + rows
    present = np.arange(lanes) < active[:, None]
    counts = np.bincount(entries[present], minlength=contexts * alphabet)
    frequencies = np.stack([normalise_counts(row) for row in counts.reshape(contexts, alphabet)])
    starts = np.cumsum(frequencies, axis=1) - frequencies
    shares, below = (table.reshape(-1).astype(np.uint32) for table in (frequencies, starts))
    coded = binding.encode_rans(entries, shares, below, len(symbols))
    words, states = coded or encode_rounds(entries, shares, below, len(symbols))
    tables = _write_tables(frequencies)
    head = HEADER.pack(alphabet, contexts, len(tables), len(words))
    return head + tables + states.astype("<u4").tobytes() + words.astype("<u2").tobytes()


def decode(data: bytes | memoryview, count: int, alphabet: int) -> UInt16[np.ndarray, "n"]:
    """Decode the `count` symbols below `alphabet` that `encode` wrote.

    Raises InputError if the bytes are not a complete stream of `count` symbols of this alphabet.
    """
    check_header(data, count, alphabet)
    symbols = binding.decode_rans(data, count, alphabet)
    return decode_reference(data, count, alphabet) if symbols is None else symbols


def check_header(data: bytes | memoryview, count: int, alphabet: int) -> tuple[int, int, int]:
    """Return the contexts, bytes of tables and lanes of a stream; InputError if invalid."""
    if len(data) < HEADER.size:
        raise InputError("a rANS stream is too short to hold its header")
    stored, contexts, table_bytes, word_count = HEADER.unpack_from(data)
    if stored != alphabet:
        raise InputError(f"a rANS stream has an alphabet of {stored} symbols instead of {alphabet}")
    if contexts not in (1, alphabet) or contexts > CONTEXTS_MAX:
        raise InputError(f"a rANS stream has {contexts} contexts")
    if 8 * table_bytes > contexts * (5 + SYMBOL_BITS * alphabet) + 7:
        raise InputError("a rANS stream's frequency tables are longer than they should be")
    lanes = lane_count(count)
    if len(data) != HEADER.size + table_bytes + 4 * lanes + 2 * word_count:
        raise InputError("a rANS stream is longer or shorter than its header says")
    return contexts, table_bytes, lanes


def decode_reference(
    data: bytes | memoryview, count: int, alphabet: int
) -> UInt16[np.ndarray, "n"]:
    """The numpy reference of `decode`."""
    contexts, table_bytes, lanes = check_header(data, count, alphabet)
    body = memoryview(data)[HEADER.size :]
    frequencies = _read_tables(bytes(body[:table_bytes]), contexts, alphabet)
    states = np.frombuffer(body[table_bytes : table_bytes + 4 * lanes], dtype="<u4")
    words = np.frombuffer(body[table_bytes + 4 * lanes :], dtype="<u2")
    if (states < STATE_LOW).any():
        raise InputError("a rANS stream starts in an impossible state")
    order, active = _layout(count, lanes)
    rows = _decode_rounds(frequencies, states.astype(np.uint32), words.astype(np.uint32), active)
    symbols = np.empty(count, dtype=np.uint16)
    present = np.arange(lanes) < active[:, None]
    symbols[order[present]] = rows[present]
    return symbols


def normalise_counts(counts: Int[np.ndarray, "a"]) -> Int[np.ndarray, "a"]:
    """Return frequencies that sum to 2^14, at least 1 for every symbol that occurs, else 0.

    They are all 0 if no symbol occurs. The rounding error is distributed one unit at a time, to
    the symbols where it adds the fewest bits.
    """
    total = int(counts.sum())
    frequencies = np.zeros(len(counts), dtype=np.int64)
    if total == 0:
        return frequencies
    occurs = np.flatnonzero(counts)
    frequencies[occurs] = np.maximum(1, counts[occurs] * TOTAL // total)
    missing = TOTAL - int(frequencies.sum())
    unit = 1 if missing > 0 else -1
    # bits saved by f -> f + 1 are count * log2(1 + 1 / f), close to count / (f + 1/2)
    queue = [
        (-unit * int(counts[i]) / (2 * int(frequencies[i]) + unit), int(i))
        for i in occurs
        if unit > 0 or frequencies[i] > 1
    ]
    heapq.heapify(queue)
    for _ in range(abs(missing)):
        _, i = heapq.heappop(queue)
        frequencies[i] += unit
        if unit > 0 or frequencies[i] > 1:
            heapq.heappush(queue, (-unit * int(counts[i]) / (2 * int(frequencies[i]) + unit), i))
    return frequencies


def lane_count(count: int) -> int:
    """Return the lanes of a stream of `count` symbols: a power of two, at most 256."""
    return min(LANES_MAX, 1 << max(0, (count // LANE_SYMBOLS).bit_length() - 1))


def _layout(
    count: int, lanes: int
) -> tuple[Int[np.ndarray, "rounds lanes"], Int[np.ndarray, "rounds"]]:
    """Return the symbol of each lane in each round, and the number of active lanes per round.

    Lanes take consecutive runs, the first `count % lanes` of them one symbol longer. Active lanes
    are therefore always the first ones.
    """
    short, longer = divmod(count, lanes)
    rounds = short + (longer > 0)
    lane = np.arange(lanes)
    first = lane * short + np.minimum(lane, longer)
    order = np.minimum(first + np.arange(rounds)[:, None], max(count - 1, 0))
    active = np.full(rounds, lanes)
    active[short:] = longer
    return order, active


def encode_rounds(
    entries: Int32[np.ndarray, "rounds lanes"],
    frequencies: UInt32[np.ndarray, "entries"],
    starts: UInt32[np.ndarray, "entries"],
    count: int,
) -> tuple[UInt16[np.ndarray, "w"], UInt32[np.ndarray, "lanes"]]:
    """Encode `count` symbols, given by their entries in the tables, from last to first round.

    Returns the words in reading order, and the states. The reference of csrc/decode.cpp's loop.
    """
    states = np.full(entries.shape[1], STATE_LOW, dtype=np.uint64)
    words: list[np.ndarray] = []
    for number in range(len(entries) - 1, -1, -1):
        row = entries[number][: count - number * len(states)]
        lanes = len(row)
        x, f = states[:lanes], frequencies[row].astype(np.uint64)
        full = x >= (f << np.uint64(32 - PRECISION))
        if full.any():
            words.append(x[full].astype(np.uint16))  # the low 16 bits
            x = np.where(full, x >> np.uint64(16), x)
        quotient, rest = np.divmod(x, f)
        states[:lanes] = (quotient << np.uint64(PRECISION)) + rest + starts[row]
    empty = np.empty(0, dtype=np.uint16)
    return np.concatenate([empty, *reversed(words)]), states.astype(np.uint32)


def _decode_rounds(
    frequencies: Int[np.ndarray, "c a"],
    states: UInt32[np.ndarray, "lanes"],
    words: UInt32[np.ndarray, "w"],
    active: Int[np.ndarray, "rounds"],
) -> UInt16[np.ndarray, "rounds lanes"]:
    """Decode all rounds; InputError unless the lanes end in the start state."""
    contexts, alphabet = frequencies.shape
    used = frequencies.any(axis=1)
    symbol_of, frequency_of, rest_of = (
        np.zeros((contexts, TOTAL), dtype=np.uint16) for _ in range(3)
    )
    for context in np.flatnonzero(used):
        f = frequencies[context]
        symbol_of[context] = np.repeat(np.arange(alphabet), f)
        frequency_of[context] = np.repeat(f, f)
        rest_of[context] = np.arange(TOTAL) - np.repeat(np.cumsum(f) - f, f)
    symbol_of, frequency_of, rest_of = (t.reshape(-1) for t in (symbol_of, frequency_of, rest_of))
    rows = np.zeros((len(active), len(states)), dtype=np.uint16)
    context = np.zeros(len(states), dtype=np.uint32)
    position = 0
    for number, lanes in enumerate(active):
        x = states[:lanes]
        slot = x & np.uint32(TOTAL - 1)
        if contexts > 1:
            slot = slot + (context[:lanes] << np.uint32(PRECISION))
        symbols = symbol_of[slot]
        # an unused context has frequency 0: the state becomes 0, which is refused below
        x = frequency_of[slot] * (x >> np.uint32(PRECISION)) + rest_of[slot]
        low = np.flatnonzero(x < STATE_LOW)
        if len(low):
            read = words[position : position + len(low)]
            if len(read) < len(low):
                raise InputError("a rANS stream ends early: the file is damaged")
            position += len(low)
            x[low] = (x[low] << np.uint32(16)) | read
            if x.min() < STATE_LOW:
                raise InputError("a rANS stream leads to an impossible state")
        states[:lanes] = x
        rows[number, :lanes] = symbols
        if contexts > 1:
            context[:lanes] = symbols
    if position != len(words) or (states != STATE_LOW).any():
        raise InputError("a rANS stream does not end where it should: the file is damaged")
    return rows


def _write_tables(frequencies: Int[np.ndarray, "c a"]) -> bytes:
    """Write the tables of all contexts (docs/reference/format.md, section 4).

    A context has one bit (0: unused); a bit per symbol (1: it occurs); four bits `k`; and
    `frequency - 1` of all symbols that occur, except the last, in exponential Golomb code k.
    """
    fields: list[tuple[np.ndarray, np.ndarray]] = []  # values, and the bits of each
    for row in frequencies:
        fields.append((np.array([row.any()]), np.ones(1)))
        if not row.any():
            continue
        fields.append((row > 0, np.ones(len(row))))
        known = (row[row > 0] - 1)[:-1]
        lengths = [bit_lengths((known + (1 << k)).astype(np.uint64)) for k in range(PRECISION)]
        k = int(
            np.argmin([(2 * length.astype(np.int64) - k).sum() for k, length in enumerate(lengths)])
        )
        fields.append((np.array([k]), np.array([4])))
        length = lengths[k].astype(np.int64)
        pair = np.stack([1 << (length - 1 - k), known + (1 << k) - (1 << (length - 1))], axis=1)
        widths = np.stack([length - k, length - 1], axis=1)
        fields.append((pair.reshape(-1), widths.reshape(-1)))
    values, widths = zip(*fields, strict=True)
    return pack_bits(
        np.concatenate(values, dtype=np.uint64, casting="unsafe"),
        np.concatenate(widths, dtype=np.int64, casting="unsafe"),
    )


def _read_tables(data: bytes, contexts: int, alphabet: int) -> Int[np.ndarray, "c a"]:
    """Read what `_write_tables` wrote; the frequencies of a used context sum to 2^14."""
    bits = np.unpackbits(np.frombuffer(data, dtype=np.uint8), bitorder="little").tolist()
    position = 0

    def take(width: int) -> int:
        nonlocal position
        if position + width > len(bits):
            raise InputError("a rANS stream's frequency tables end early")
        position += width
        return sum(bit << i for i, bit in enumerate(bits[position - width : position]))

    frequencies = np.zeros((contexts, alphabet), dtype=np.int64)
    for row in frequencies:
        if not take(1):
            continue
        occurs = [i for i in range(alphabet) if take(1)]
        k = take(4)
        for i in occurs[:-1]:
            zeros = 0
            while not take(1):
                zeros += 1
            if zeros + k > PRECISION:
                raise InputError("a rANS stream's frequency table holds a number out of range")
            row[i] = take(zeros + k) + (1 << (zeros + k)) - (1 << k) + 1
        rest = TOTAL - int(row.sum())
        if not occurs or rest < 1:
            raise InputError("a rANS stream's frequencies do not sum to 16384")
        row[occurs[-1]] = rest
    if len(bits) - position >= 8 or any(bits[position:]):
        raise InputError("a rANS stream's frequency tables are longer than they should be")
    return frequencies
