"""A task: one stage of one row, in a process of its own that starts here and ends with its parent.

This module imports nothing heavy: the machines of a cluster load it for every task.
"""

import json
import signal
import subprocess
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Literal

from mobilegs.batch.row_folder import RowFolder
from mobilegs.child_process import module_command

Stage = Literal["fetch", "poses", "train", "export"]
STAGES: tuple[Stage, ...] = ("fetch", "poses", "train", "export")
Result = Literal["done", "refused", "lost", "stopped"]
POLL_SECONDS = 0.5  # between two looks at a process
GRACE_SECONDS = 60.0  # in which a stopped process writes its checkpoint


@dataclass(frozen=True)
class Task:
    """A stage of a row, with its share of a machine.

    Attributes:
        folder: of the row.
        attempt: number of the try, from 1, over all stages and calls.
        cores: processor cores, which is also the number of threads.
        gpus: 1 if the stage runs on a GPU.
        cache: folder for fetched sources.
        environment: variables that the process gets.
        source: address of the stage fetch, with its secrets. It is in no file.
    """

    folder: str
    stage: Stage
    attempt: int
    cores: int
    gpus: int
    cache: str
    environment: dict[str, str] = field(default_factory=dict)
    source: str = field(default="", repr=False)

    def as_json(self) -> str:
        return json.dumps(asdict(self))

    @staticmethod
    def from_json(line: str) -> "Task":
        return Task(**json.loads(line))


@dataclass(frozen=True)
class Outcome:
    """The end of a task.

    Attributes:
        result: done; refused: the input cannot be used, and another try would not help; lost: the
            process or its machine died, or the program failed; stopped: it was asked to stop.
        message: why a task is not done.
    """

    result: Result
    message: str = ""


def run_task(task: Task, stopping: Callable[[], bool] = lambda: False) -> Outcome:
    """Run a task in a new process and return its outcome.

    The process ends when this one does, however that happens: it watches its standard input. It
    also ends, with a checkpoint, once `stopping` is true or after KeyboardInterrupt.
    """
    folder = RowFolder(Path(task.folder))
    command, environment = module_command("mobilegs.batch.worker")
    threads = {"OMP_NUM_THREADS": str(task.cores)}
    with folder.log.open("ab") as log:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=log,
            stderr=log,
            env=environment | task.environment | threads,
            start_new_session=True,  # Ctrl-C in a terminal is for the batch, not for its tasks
        )
    assert process.stdin is not None
    try:
        process.stdin.write(f"{task.as_json()}\n".encode())
        process.stdin.flush()
        while process.poll() is None and not stopping():
            try:
                process.wait(POLL_SECONDS)
            except subprocess.TimeoutExpired:
                continue
    except (KeyboardInterrupt, BrokenPipeError):
        pass
    finally:
        _end(process)
    ended = folder.find("ended", task.attempt)
    if ended is not None:
        return Outcome(ended["result"], ended["message"])
    return Outcome("lost", _why(process.returncode))


def _end(process: subprocess.Popen[bytes]) -> None:
    """Ask a process to stop, and kill it if it does not."""
    assert process.stdin is not None
    try:
        process.stdin.close()
    except BrokenPipeError:
        pass
    try:
        process.wait(GRACE_SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _why(code: int) -> str:
    """Return a sentence about a process that ended without a word."""
    if code < 0:
        name = signal.Signals(-code).name
        hint = ", as the system does when memory runs out" if name == "SIGKILL" else ""
        return f"its process was ended by {name}{hint}"
    return f"its process ended with code {code}"
