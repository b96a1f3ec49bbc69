"""A browser that asks for one address, and leaves by Ctrl-C."""

import _thread
import http.client
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest


@pytest.fixture
def heeds_ctrl_c() -> Iterator[None]:
    """Let Ctrl-C raise KeyboardInterrupt: a shell's background jobs ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def visited(monkeypatch: pytest.MonkeyPatch, heeds_ctrl_c: None) -> list[int]:
    """The status of each address that the browser is opened at; each visit ends the server."""
    found: list[int] = []

    def browse(address: str) -> None:
        parts = urlsplit(address)
        if parts.scheme == "file":  # whoever sees the browser's arguments does not see the address
            file = Path(url2pathname(parts.path))
            assert file.parent.stat().st_mode & 0o077 == 0
            [target] = re.findall(r"url=(http[^\"]+)", file.read_text())
            parts = urlsplit(target)
            assert parts.path not in address
        connection = http.client.HTTPConnection(parts.netloc, timeout=20)
        connection.request("GET", parts.path)
        found.append(connection.getresponse().status)
        connection.close()
        _thread.interrupt_main()

    monkeypatch.setattr("webbrowser.open", browse)
    return found
