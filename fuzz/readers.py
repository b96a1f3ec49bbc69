"""Run the Python readers with bounds on time and memory.

An input must give a scene, or a refusal with one sentence; anything else is an error.
"""

import logging
import re
import time
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path

import torch
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.formats.glb import read_glb
from mobilegs.formats.ply import read_ply
from mobilegs.formats.sog import read_sog
from mobilegs.formats.splat import read_splat
from mobilegs.formats.spz import read_spz
from mobilegs.mgs.codec import decode_mgs, inspect
from tests.support.memory_meter import MemoryMeter
from tests.support.quantized_scenes import tensors

Verdict = str | None | dict[str, str]  # a sentence, None for a scene, or {"error", "where"}

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
FREE = 32 << 20  # bytes allowed in addition to twice file and scene


class Reader:
    """The reader of one kind of file, which writes inputs to `folder`."""

    sentence_max = SENTENCE

    def __init__(self, kind: str, folder: Path, seconds: float) -> None:
        self.kind, self.path, self.seconds = kind, folder / f"input.{kind}", seconds

    def verdicts(self, inputs: list[bytes]) -> list[Verdict]:
        """Return the verdict on each input; too much memory is an error, too.

        One of `EVERY` scenes is decoded completely.
        """
        largest, found, meter = 0, list[Verdict](), MemoryMeter()
        meter.start()
        for i, data in enumerate(inputs):
            size, verdict = self.verdict(data, decode=i % EVERY == 0)
            largest = max(largest, len(data) + size)
            found.append(verdict)
        if meter.peak() > FREE + 2 * largest:  # find the input
            for i, data in enumerate(inputs):
                if error := self.too_much(data, decode=i % EVERY == 0):
                    found[i] = error
        return found

    def too_much(self, data: bytes, *, decode: bool) -> Verdict:
        """Return the error of an input that takes too much memory, else None."""
        meter = MemoryMeter()
        meter.start()
        size, _ = self.opened(data, decode=decode)
        if (peak := meter.peak()) <= FREE + 2 * (len(data) + size):
            return None
        return {"error": f"took {peak >> 20} MiB for {len(data)} and {size} bytes"}

    def verdict(self, data: bytes, *, decode: bool) -> tuple[int, Verdict]:
        """Return the bytes of the scene, and the verdict; more than `seconds` are an error."""
        begun = time.perf_counter()
        found = self.opened(data, decode=decode)
        if time.perf_counter() - begun > self.seconds:  # a busy machine, or a slow reader?
            begun = time.process_time()
            self.opened(data, decode=decode)
            if (used := time.process_time() - begun) > self.seconds:
                return found[0], {"error": f"took {used:.1f} s"}
        return found

    def opened(self, data: bytes, *, decode: bool) -> tuple[int, Verdict]:
        """Return the bytes of the scene, and the verdict, without a bound on time."""
        if self.kind == "mgs":
            return self._refusal(lambda: _open_mgs(data, decode))
        self.path.write_bytes(data)
        read = READERS[self.kind]
        return self._refusal(lambda: _finite(read(self.path).tensors().values()))

    def _refusal(self, read: Callable[[], int]) -> tuple[int, Verdict]:
        try:
            return read(), None
        except InputError as error:
            sentence = str(error).replace(str(self.path), "").replace(str(self.path.parent), "")
            if 0 < len(sentence) <= self.sentence_max and not UNPRINTABLE.search(sentence):
                return 0, sentence
            return 0, {"error": f"is not refused with one plain sentence: {sentence[:200]!r}"}
        except Exception as error:
            return 0, {"error": f"{type(error).__name__}: {error}", "where": _place_of(error)}


def _place_of(error: BaseException) -> str:
    """Return file and line of the last frame of an exception's traceback that is ours."""
    found, trace = "", error.__traceback__
    while trace is not None:
        name = trace.tb_frame.f_code.co_filename
        if "mobilegs" in name and "site-packages" not in name:
            found = f"{Path(name).name}:{trace.tb_lineno}"
        trace = trace.tb_next
    return found


def _open_mgs(data: bytes, decode: bool) -> int:
    quantized = decode_mgs(data)
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
