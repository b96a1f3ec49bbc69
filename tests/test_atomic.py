"""Files that appear whole or not at all."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mobilegs.atomic import DISK_ERRORS, atomic_path, atomic_write
from mobilegs.cli.main import VERBS, main
from mobilegs.errors import InputError

# `mobilegs doctor`, which for once writes a file and takes its time
SLOW = """
import signal, sys, time
from pathlib import Path
from mobilegs.cli import main
from mobilegs.__main__ import run
for number in (signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, signal.SIG_DFL)  # who runs the tests may ignore them
from mobilegs.atomic import atomic_path
def write():
    with atomic_path(Path(sys.argv[2])) as temporary:
        temporary.write_text("half")
        time.sleep(60)
main.VERBS["doctor"] = write
sys.argv[1:] = ["doctor", *sys.argv[1:]]
main.call = lambda function, *_, **__: function()
sys.exit(run())
"""


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_what_fails_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "out.txt"
    atomic_write(path, "before")
    with pytest.raises(KeyboardInterrupt), atomic_path(path) as temporary:
        temporary.write_text("half")
        raise KeyboardInterrupt
    assert path.read_text() == "before" and names(tmp_path) == {"out.txt"}


def test_long_names_have_room(tmp_path: Path) -> None:
    path = tmp_path / ("a" * 251 + ".mgs")
    atomic_write(path, b"1")
    assert path.read_bytes() == b"1"


def test_links_are_replaced(tmp_path: Path) -> None:
    target, link = tmp_path / "far" / "target.txt", tmp_path / "link.txt"
    target.parent.mkdir()
    target.write_text("before")
    link.symlink_to(target)
    atomic_write(link, "after")
    assert not link.is_symlink() and link.read_text() == "after"
    assert target.read_text() == "before" and names(tmp_path) == {"far", "link.txt"}
    with pytest.raises(InputError, match="a device or a pipe"):
        atomic_write("/dev/stdout", "after")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs POSIX")
def test_a_pipe_is_no_place_for_a_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="a device or a pipe"):
        atomic_write(tmp_path / "pipe", "text")
    assert (tmp_path / "pipe").is_fifo()


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="needs POSIX")
@pytest.mark.parametrize("number", ["SIGTERM", "SIGHUP"])
def test_a_process_that_is_told_to_end_leaves_nothing_half(tmp_path: Path, number: str) -> None:
    program = [sys.executable, "-c", SLOW, str(tmp_path / "out.txt")]
    environment = {name: value for name, value in os.environ.items() if name != "RANK"}
    with subprocess.Popen(program, stderr=subprocess.PIPE, text=True, env=environment) as process:
        while not names(tmp_path) and process.poll() is None:
            time.sleep(0.05)
        time.sleep(0.2)
        process.send_signal(getattr(signal, number))
        assert process.stderr and process.stderr.read() == "mobilegs: interrupted\n"
    assert process.returncode == 130 and not names(tmp_path)


@pytest.mark.parametrize("number", DISK_ERRORS)
def test_errors_of_a_disk_are_sentences(
    number: int, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    reason = DISK_ERRORS[number]
    for error in (OSError(number, os.strerror(number)), RuntimeError(f"x: {os.strerror(number)}")):
        with pytest.raises(InputError, match=f"cannot write .*: {reason}"):
            with atomic_path(tmp_path / "out"):
                raise error
    assert not list(tmp_path.iterdir())

    def full() -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setitem(VERBS, "doctor", full)
    assert main(["doctor"]) == 2
    assert capsys.readouterr().err == f"mobilegs: {reason}\n"


def test_errors_of_other_files_are_not_those_of_the_output(tmp_path: Path) -> None:
    with pytest.raises(PermissionError), atomic_path(tmp_path / "out"):
        raise PermissionError(errno.EACCES, "Permission denied", "/other")
