"""The process of `PycolmapProcess`: runs the functions that arrive on its standard input.

A task is the pickle of a pickled (function, arguments, options, whether it reports progress).
Answers are pickles of (kind, value) on standard output: `progress` (done, total), `result`,
`refused` with the message of an InputError, `failed` with a reason, `raised` with a traceback.
"""

import os
import pickle
import signal
import sys
import traceback
from queue import SimpleQueue
from threading import Thread
from typing import Any

from mobilegs.errors import InputError


def main() -> None:
    """Run tasks until standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which kills this
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what C++ prints to standard output must not mix with answers

    def send(kind: str, value: Any) -> None:
        pickle.dump((kind, value), channel)
        channel.flush()

    tasks: SimpleQueue[bytes] = SimpleQueue()
    Thread(target=_receive, args=(tasks,), daemon=True).start()
    while True:
        send(*_answer(tasks.get(), lambda done, total: send("progress", (done, total))))


def _answer(task: bytes, progress: Any) -> tuple[str, Any]:
    try:
        function, arguments, options, reports = pickle.loads(task)
        if reports:
            options["progress"] = progress
        return "result", function(*arguments, **options)
    except InputError as error:
        return "refused", str(error)
    except MemoryError:
        return "failed", "there is not enough memory"
    except (RuntimeError, ValueError) as error:  # those of pycolmap
        traceback.print_exc()
        return "failed", " ".join(str(error).split())
    except Exception:
        return "raised", traceback.format_exc()


def _receive(tasks: SimpleQueue[bytes]) -> None:
    """Move tasks from standard input to the queue. At its end this process has no user: exit."""
    try:
        while True:
            tasks.put(pickle.load(sys.stdin.buffer))
    except EOFError:
        os._exit(0)


if __name__ == "__main__":
    main()
