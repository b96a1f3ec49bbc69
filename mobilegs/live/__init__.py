"""Live view of a training in the browser, rendered between steps by the training's own kernels.

It does not change the result: frames are rendered without gradients and without random numbers.
viser is imported only when a live view opens.
"""

import importlib.util
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager

from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.extras import not_installed
from mobilegs.train.loop import LiveView
from mobilegs.train.progress import Monitor

ADDRESS = "127.0.0.1:8080"


def validate_live_options(live: bool, address: str) -> None:
    """Raise InputError if --live cannot listen at `address`, or it is given without --live."""
    if not live:
        if address != ADDRESS:
            raise InputError("--live-at sets the address of --live: give both")
        return
    if int(os.environ.get("WORLD_SIZE", "1")) > 1:
        raise InputError("--live shows a training in one process: leave out --live or torchrun")
    if importlib.util.find_spec("viser") is None:
        raise not_installed("--live needs viser", "live")
    host, _ = parse_address(address)
    with socket.socket() as probe:
        try:
            probe.bind((host, 0))
        except OSError as error:
            raise InputError(
                f"--live cannot listen at {host} ({error.strerror}): give an address of this "
                "machine, or 0.0.0.0 for all of its addresses"
            ) from None


def parse_address(address: str) -> tuple[str, int]:
    """Split HOST:PORT into host and port; raises InputError if it has another form."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise InputError(f"--live-at {address} is not of the form HOST:PORT, like {ADDRESS}")
    return host, int(port)


@contextmanager
def open_live_view(
    live: bool, address: str, dataset: Dataset, monitor: Monitor
) -> Iterator[LiveView | None]:
    """Serve a live view at `address` while the block runs; yields None if not `live`.

    Raises InputError as `validate_live_options` does.
    """
    validate_live_options(live, address)
    if not live:
        yield None
        return
    from mobilegs.live.page import Page
    from mobilegs.live.session import LiveSession

    page = Page(*parse_address(address), dataset)
    monitor.note(f"live view: {page.address}")
    try:
        yield LiveSession(page, dataset, monitor)
    finally:
        page.close()
