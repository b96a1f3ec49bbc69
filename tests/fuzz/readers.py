"""Run the Python readers with bounds on time and memory.

An input must give a scene, or a refusal with one sentence; anything else is an error.
"""

import logging
import re
import time
import warnings
from collections.abc import Iterable
from pathlib import Path

import torch
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.formats.glb import read_glb
from mobilegs.formats.ply import read_ply
from mobilegs.formats.sog import read_sog
from mobilegs.formats.splat import read_splat
from mobilegs.formats.spz import read_spz
from mobilegs.mgs.codec import inspect, unpack
from tests.support.memory_meter import MemoryMeter
from tests.support.quantized_scenes import tensors

Verdict = str | None | dict[str, str]

READERS = {
    "ply": read_ply,
    "compressed": read_ply,
    "spz": read_spz,
    "splat": read_splat,
    "sog": read_sog,
    "glb": read_glb,
}
EVERY = 20  # one of this many scenes is decoded completely
SENTENCE = 300  # characters
# control characters, which terminals obey, and unpaired surrogates, which cannot be printed
UNPRINTABLE = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
# bytes allowed in addition to twice file and scene
FREE = 32 << 20


def verdicts(kind: str, inputs: list[bytes], folder: Path, *, seconds: float) -> list[Verdict]:
    """Return the verdict on each input: None for a scene, the message of a refusal, or an error.

    Errors (`{"error": ...}`) are other exceptions, too much memory, and more than `seconds` of
    processor time. One of `EVERY` scenes is decoded completely. Inputs of formats that are read
    from a file are written to `folder`.
    """
    reader = Reader(kind, folder / f"input.{kind}", seconds)
    meter = MemoryMeter()
    meter.start()
    found = [reader.verdict(data, decode=i % EVERY == 0) for i, data in enumerate(inputs)]
    if meter.peak() > FREE + 2 * reader.largest:  # find the input
        for i, data in enumerate(inputs):
            meter.start()
            size, _ = reader.opened(data, decode=i % EVERY == 0)
            if (peak := meter.peak()) > FREE + 2 * (len(data) + size):
                found[i] = {"error": f"took {peak >> 20} MiB for {len(data)} and {size} bytes"}
    return found


class Reader:
    """The reader of one kind of file.

    Attributes:
        largest: most bytes of an input plus its scene.
    """

    def __init__(self, kind: str, path: Path, seconds: float) -> None:
        self.kind, self.path, self.seconds, self.largest = kind, path, seconds, 0

    def verdict(self, data: bytes, *, decode: bool) -> Verdict:
        """Return the verdict on one input, as in `verdicts`."""
        begun = time.perf_counter()
        size, found = self.opened(data, decode=decode)
        self.largest = max(self.largest, len(data) + size)
        if time.perf_counter() - begun > self.seconds:  # a busy machine, or a slow reader?
            begun = time.process_time()
            self.opened(data, decode=decode)
            if (used := time.process_time() - begun) > self.seconds:
                return {"error": f"took {used:.1f} s"}
        return found

    def opened(self, data: bytes, *, decode: bool) -> tuple[int, Verdict]:
        """Return the bytes of the scene, and the verdict."""
        try:
            if self.kind == "mgs":
                return _open_mgs(data, decode), None
            self.path.write_bytes(data)
            scene = READERS[self.kind](self.path)
            return _finite(scene.tensors().values()), None
        except InputError as error:
            sentence = str(error).removeprefix(str(self.path))
            if 0 < len(sentence) <= SENTENCE and not UNPRINTABLE.search(sentence):
                return 0, sentence
            return 0, {"error": f"is not refused with one plain sentence: {sentence[:200]!r}"}
        except Exception as error:
            return 0, {"error": f"{type(error).__name__}: {error}"}


def _open_mgs(data: bytes, decode: bool) -> int:
    quantized = unpack(data)
    size = sum(part.nbytes for part in tensors(quantized))
    if decode:
        inspect(data)
        scene = quantized.decode()
        lobes = [] if scene.lobes is None else [scene.lobes]
        size += _finite([*scene.gaussians.tensors().values(), *lobes])
    return size


def _finite(values: Iterable[Tensor]) -> int:
    """Return the bytes of tensors; ArithmeticError if one is not finite."""
    found = list(values)
    if not all(bool(value.isfinite().all()) for value in found):
        raise ArithmeticError("gives numbers that are not finite")
    return sum(value.nbytes for value in found)


def quiet() -> None:
    """Set up a fuzzing process: no logs, warnings are errors, one thread."""
    logging.disable()
    warnings.simplefilter("error")
    torch.set_num_threads(1)
