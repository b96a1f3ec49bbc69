"""`mobilegs`, `python -m mobilegs`, and what torchrun starts: `torchrun ... -m mobilegs train`."""

import io
import os
import signal
import sys

from mobilegs.cli.main import main

ENDS = ("SIGTERM", "SIGHUP")  # as far as the system has them


def run() -> int:
    """`main` in a process of its own, in which it ends tidily and can print any name."""
    if "RANK" not in os.environ:  # torchrun ends its processes while they wait for each other
        for number in (getattr(signal, name) for name in ENDS if hasattr(signal, name)):
            if signal.getsignal(number) == signal.SIG_DFL:  # nohup ignores SIGHUP
                signal.signal(number, signal.default_int_handler)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # names of files may be any bytes
            stream.reconfigure(errors="backslashreplace")
    return main()


if __name__ == "__main__":
    sys.exit(run())
