"""Our readers under watch: an input gives a scene or a sentence, at a fair price, or an error."""

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
from tests.fuzz.seeds import tensors

Verdict = str | None | dict[str, str]

READERS = {
    "ply": read_ply,
    "compressed": read_ply,
    "spz": read_spz,
    "splat": read_splat,
    "sog": read_sog,
    "glb": read_glb,
}
EVERY = 20  # one in so many scenes is decoded to the last number
SENTENCE = 300  # characters
# what a terminal obeys, and halves of a pair, which nothing prints
UNSHOWN = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
# bytes beside twice what file and scene take
FREE = 32 << 20
STATUS = Path("/proc/self/status")
RESET = Path("/proc/self/clear_refs")


class Meter:
    """The most memory that the process has had since `start`, beyond what it had then."""

    def start(self) -> None:
        RESET.write_text("5")
        self.before = self._read("VmRSS")

    def peak(self) -> int:
        return self._read("VmHWM") - self.before

    def _read(self, name: str) -> int:
        return int(STATUS.read_text().split(name + ":", 1)[1].split(None, 1)[0]) << 10


def verdicts(kind: str, inputs: list[bytes], folder: Path, *, seconds: float) -> list[Verdict]:
    """What becomes of each input: None is a scene, a text is why it is refused.

    An error is what no input may lead to: anything else, too much memory, or more than `seconds` of
    processor time. One in `EVERY` scenes is decoded to the last number. `folder` takes a file, for
    the formats that are read from one.
    """
    reader = Reader(kind, folder / f"input.{kind}", seconds)
    meter = Meter()
    meter.start()
    found = [reader.verdict(data, decode=i % EVERY == 0) for i, data in enumerate(inputs)]
    if meter.peak() > FREE + 2 * reader.largest:  # of which?
        for i, data in enumerate(inputs):
            meter.start()
            size, _ = reader.opened(data, decode=i % EVERY == 0)
            if (peak := meter.peak()) > FREE + 2 * (len(data) + size):
                found[i] = {"error": f"took {peak >> 20} MiB for {len(data)} and {size} bytes"}
    return found


class Reader:
    """Of one kind of file.

    Attributes:
        largest: bytes of the largest input together with its scene.
    """

    def __init__(self, kind: str, path: Path, seconds: float) -> None:
        self.kind, self.path, self.seconds, self.largest = kind, path, seconds, 0

    def verdict(self, data: bytes, *, decode: bool) -> Verdict:
        """See `verdicts`."""
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
        """Bytes of the scene, and the verdict."""
        try:
            if self.kind == "mgs":
                return _open_mgs(data, decode), None
            self.path.write_bytes(data)
            scene = READERS[self.kind](self.path)
            return _finite(scene.tensors().values()), None
        except InputError as error:
            sentence = str(error).removeprefix(str(self.path))
            if 0 < len(sentence) <= SENTENCE and not UNSHOWN.search(sentence):
                return 0, sentence
            return 0, {"error": f"is refused in no plain sentence: {sentence[:200]!r}"}
        except Exception as error:
            return 0, {"error": f"{type(error).__name__}: {error}"}


def _open_mgs(data: bytes, decode: bool) -> int:
    coded = unpack(data)
    size = sum(part.nbytes for part in tensors(coded))
    if decode:
        inspect(data)
        scene = coded.decode()
        lobes = [] if scene.lobes is None else [scene.lobes]
        size += _finite([*scene.gaussians.tensors().values(), *lobes])
    return size


def _finite(values: Iterable[Tensor]) -> int:
    """Bytes of tensors without NaN and infinity."""
    found = list(values)
    if not all(bool(value.isfinite().all()) for value in found):
        raise ArithmeticError("gives numbers that are not finite")
    return sum(value.nbytes for value in found)


def quiet() -> None:
    """For processes that read nothing but such files: warnings are errors, one thread."""
    logging.disable()
    warnings.simplefilter("error")
    torch.set_num_threads(1)
