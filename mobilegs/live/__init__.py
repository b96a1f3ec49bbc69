"""Watching a training: its scene in the browser, drawn between steps by the kernels that train.

Nothing of this touches what is trained: pictures are drawn without a graph and without random
numbers. viser is imported once somebody wants to watch.
"""

import importlib.util
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol, runtime_checkable

from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.train.progress import Monitor
from mobilegs.train.run_dir import StopRequest
from mobilegs.train.stage import Stage

ADDRESS = "127.0.0.1:8080"


@runtime_checkable
class Watch(Protocol):
    """What the loop tells those who watch."""

    def between_steps(self, stage: Stage, stop: StopRequest) -> None:
        """Called after every step; keeps who calls while training is paused and need not stop."""
        ...


def refuse(live: bool, address: str) -> None:
    """Raise InputError if nothing can be shown at `address`, or it is given without `live`."""
    if not live:
        if address != ADDRESS:
            raise InputError("--live-at says where --live listens: give both")
        return
    if int(os.environ.get("WORLD_SIZE", "1")) > 1:
        raise InputError("--live shows a training in one process: leave it out, or torchrun")
    if importlib.util.find_spec("viser") is None:
        raise InputError("--live needs viser, which is not installed: pip install 'mobilegs[live]'")
    host, _ = place(address)
    with socket.socket() as probe:
        try:
            probe.bind((host, 0))
        except OSError as error:
            raise InputError(
                f"--live cannot listen at {host} ({error.strerror}): give an address of this "
                "machine, or 0.0.0.0 for all that it has"
            ) from None


def place(address: str) -> tuple[str, int]:
    """Host and port of HOST:PORT; raises InputError if it is something else."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise InputError(f"--live-at {address} is no HOST:PORT like {ADDRESS}")
    return host, int(port)


@contextmanager
def watched(live: bool, address: str, dataset: Dataset, monitor: Monitor) -> Iterator[Watch | None]:
    """What shows a training at `address` for as long as the block runs; None if not `live`."""
    refuse(live, address)
    if not live:
        yield None
        return
    from mobilegs.live.page import Page
    from mobilegs.live.session import Show

    page = Page(*place(address), dataset)
    monitor.say(f"to watch: {page.address}")
    try:
        yield Show(page, dataset, monitor)
    finally:
        page.close()
