"""The process of a task: `python -m mobilegs.batch.worker`, with the task on standard input.

It ends when its standard input does, because then the process that started it is gone.
"""

import os
import platform
import signal
import sys
import threading
import time
import traceback
from pathlib import Path

from mobilegs.batch.row_folder import RowFolder
from mobilegs.batch.task import GRACE_SECONDS, Result, Task
from mobilegs.errors import InputError, printable
from mobilegs.progress_display import printed_log

BLOCK = 4096


def main() -> int:
    """Run the task; return 0 if it is done."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    task = Task.from_json(_read_line())
    threading.Thread(target=_end_with_parent, daemon=True).start()
    folder = RowFolder(Path(task.folder))
    about = {"stage": task.stage, "cores": task.cores, "gpus": task.gpus}
    host = platform.node()
    try:
        with folder.lock():
            folder.append("started", task.attempt, **about, host=host, pid=os.getpid())
            started = time.monotonic()
            result, message = _run(task, folder)
            about["seconds"] = round(time.monotonic() - started, 2)
            folder.append("ended", task.attempt, **about, result=result, message=message)
    except TimeoutError as error:
        about |= {"seconds": 0.0, "result": "lost", "message": str(error)}
        folder.append("ended", task.attempt, **about)
        return 1
    except KeyboardInterrupt:  # before or after the stage
        return 1
    return 0 if result == "done" else 1


def _run(task: Task, folder: RowFolder) -> tuple[Result, str]:
    """Run the stage of a task; return the result and, if it is not done, why."""
    from mobilegs.batch.stages import run_stage
    from mobilegs.train.memory import keep_freed_memory

    keep_freed_memory()
    try:
        with printed_log():
            run_stage(task, folder)
    except (InputError, FloatingPointError) as error:  # a training that diverged does so again
        result, message = "refused", str(error)
    except KeyboardInterrupt:
        result, message = "stopped", "it was stopped"
    except Exception as error:
        traceback.print_exc()
        result, message = "lost", f"{type(error).__name__}: {error}"
    else:
        result, message = "done", ""
    if message:
        print(f"mobilegs: {printable(message)}", file=sys.stderr)
    return result, message


def _read_line() -> str:
    """Return the first line of standard input, and leave the rest."""
    line = b""
    while not line.endswith(b"\n"):
        part = os.read(0, BLOCK)
        if not part:
            raise SystemExit(1)
        line += part
    return line.decode()


def _end_with_parent() -> None:
    """Stop this process as Ctrl-C does when standard input ends, and kill it if that fails."""
    while os.read(0, BLOCK):
        pass
    signal.raise_signal(signal.SIGTERM)
    time.sleep(GRACE_SECONDS)
    os._exit(1)


if __name__ == "__main__":
    sys.exit(main())
