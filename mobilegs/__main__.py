"""Entry point of `mobilegs`, `python -m mobilegs` and `torchrun ... -m mobilegs train`."""

import io
import os
import signal
import sys

from mobilegs.cli.main import main

SIGNALS = ("SIGTERM", "SIGHUP")  # that end the program; Windows lacks SIGHUP


def run() -> int:
    """Run `main` as a process: signals end it like Ctrl-C, and any file name can be printed."""
    if "RANK" not in os.environ:  # torchrun must be able to end processes that wait for each other
        for number in (getattr(signal, name) for name in SIGNALS if hasattr(signal, name)):
            if signal.getsignal(number) == signal.SIG_DFL:  # nohup ignores SIGHUP
                signal.signal(number, signal.default_int_handler)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # file names can be any bytes
            stream.reconfigure(errors="backslashreplace")
    return main()


if __name__ == "__main__":
    sys.exit(run())
