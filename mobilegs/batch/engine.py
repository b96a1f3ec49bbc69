"""Engines: run tasks on this machine (`LocalEngine`) or on a Ray cluster (`ray_engine`)."""

import os
import threading
import time
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

from mobilegs.batch.task import Outcome, Task, run_task


@dataclass(frozen=True)
class Node:
    """A machine with its processor cores and GPUs."""

    name: str
    cores: int
    gpus: int


@runtime_checkable
class Engine(Protocol):
    """Runs tasks in the order in which they are submitted, as resources allow."""

    name: str

    def nodes(self) -> Sequence[Node]:
        """Return the machines that are alive."""
        ...

    def accepts(self, task: Task) -> bool:
        """Return True if a task can be submitted now."""
        ...

    def submit(self, task: Task) -> None:
        """Start a task, or queue it where the engine chooses the machine."""
        ...

    def ended(self, seconds: float) -> list[tuple[Task, Outcome]]:
        """Return tasks that ended; wait for one for at most some seconds."""
        ...

    def stop(self) -> None:
        """Stop all tasks, with their checkpoints, and wait for them."""
        ...

    def close(self) -> None:
        """Leave the engine; no task may run."""
        ...


class LocalEngine:
    """An `Engine` whose tasks are processes of this machine."""

    name = "this machine"

    def __init__(self, gpus: Sequence[str] = ()) -> None:
        """Use all cores of this process, and GPUs with these values of CUDA_VISIBLE_DEVICES."""
        self._node = Node("local", available_cores(), len(gpus))
        self._cores, self._gpus = self._node.cores, list(gpus)
        self._pool = ThreadPoolExecutor(self._node.cores)
        self._running: dict[Future[Outcome], tuple[Task, str | None]] = {}
        self._stopping = threading.Event()

    def nodes(self) -> list[Node]:
        return [self._node]

    def accepts(self, task: Task) -> bool:
        return task.cores <= self._cores and task.gpus <= len(self._gpus)

    def submit(self, task: Task) -> None:
        self._cores -= task.cores
        gpu = self._gpus.pop() if task.gpus else None
        given = replace(task, environment={**task.environment, "CUDA_VISIBLE_DEVICES": gpu or ""})
        future = self._pool.submit(run_task, given, self._stopping.is_set)
        self._running[future] = task, gpu

    def ended(self, seconds: float) -> list[tuple[Task, Outcome]]:
        if not self._running:
            time.sleep(seconds)
        ended = []
        for future in wait(self._running, seconds, FIRST_COMPLETED).done:
            task, gpu = self._running.pop(future)
            self._cores += task.cores
            if gpu is not None:
                self._gpus.append(gpu)
            error = future.exception()  # the process could not be started
            ended.append((task, Outcome("lost", str(error)) if error else future.result()))
        return ended

    def stop(self) -> None:
        self._stopping.set()
        self._pool.shutdown()

    def close(self) -> None:
        pass


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def visible_gpus() -> list[str]:
    """Return a value of CUDA_VISIBLE_DEVICES for each GPU of this machine."""
    import torch

    count = torch.cuda.device_count() if torch.cuda.is_available() else 0
    given = [name for name in os.environ.get("CUDA_VISIBLE_DEVICES", "").split(",") if name]
    return given[:count] if given else [str(number) for number in range(count)]
