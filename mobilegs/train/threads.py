"""Threads that leave room for other programs: a training's step waits for its slowest thread."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

import psutil
import torch

ADAPT_SECONDS = 1.0  # between two choices of the number
FREE_TIMES = ("idle", "iowait", "steal")  # of a core that no other program uses

_open: list["FairThreads"] = []


@contextmanager
def first_threads() -> Iterator[None]:
    """Use as many threads as before `FairThreads`, for results that depend on their number.

    Such are matrix products: each thread adds a part of the terms.
    """
    number = torch.get_num_threads()
    torch.set_num_threads(_open[0].most if _open else number)
    try:
        yield
    finally:
        torch.set_num_threads(number)


class FairThreads:
    """While it is open, torch uses as many threads as cores that other programs leave.

    A step's operations share their work evenly among the threads and wait for all of them. If a
    thread has to share its core, the others wait, too: one busy program beside two threads makes a
    training three times slower, beside one thread 1.7 times (docs/explanation/reliability.md).

    Example:

        with FairThreads() as threads:
            for _ in range(steps):
                stage.advance(views)
                threads.adapt()
    """

    def __enter__(self) -> "FairThreads":
        """Begin with the present number of threads, which is also the most."""
        self.most = torch.get_num_threads()
        _open.append(self)
        self.process = psutil.Process()
        self.at, self.before = time.monotonic(), self._core_seconds()
        return self

    def __exit__(self, *exception: object) -> None:
        """Go back to the first number of threads."""
        _open.remove(self)
        torch.set_num_threads(self.most)

    def adapt(self) -> None:
        """Choose the number of threads anew, if a second has passed since the last time."""
        passed = time.monotonic() - self.at
        if passed < ADAPT_SECONDS:
            return
        now = self._core_seconds()
        cores = (now - self.before) / passed
        self.at, self.before = self.at + passed, now
        threads = min(max(1, round(cores)), self.most)
        if threads != torch.get_num_threads():
            torch.set_num_threads(threads)

    def _core_seconds(self) -> float:
        """Return the seconds of this process's cores that it used or that were free, until now."""
        cores = psutil.cpu_times(percpu=True)
        if hasattr(self.process, "cpu_affinity"):  # Linux and Windows
            usable = self.process.cpu_affinity()
            cores = [cores[index] for index in usable if index < len(cores)]
        free = sum(getattr(core, name, 0.0) for core in cores for name in FREE_TIMES)
        own = self.process.cpu_times()
        return free + own.user + own.system
