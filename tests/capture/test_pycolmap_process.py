"""The process that runs pycolmap: results, errors, crashes, and Ctrl-C."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from mobilegs.capture.mapping import read_geometry
from mobilegs.capture.pycolmap_runtime import PycolmapProcess
from mobilegs.capture.run import digest_inputs
from mobilegs.capture.workspace import file_digest
from mobilegs.errors import InputError
from tests.support.layered_photos import write_photos

pytest.importorskip("pycolmap", reason="needs the extra capture")
posix = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX")


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory):
    with PycolmapProcess(tmp_path_factory.mktemp("shared") / "log") as process:
        yield process


def wait_for(found: Callable[[], object], seconds: float = 60) -> object:
    """Return what `found` returns once it is true."""
    ends = time.monotonic() + seconds
    while not (value := found()):
        assert time.monotonic() < ends
        time.sleep(0.02)
    return value


def workers(parent: int) -> list[psutil.Process]:
    """Return the processes that run pycolmap for the process `parent`."""
    try:
        children = psutil.Process(parent).children()
        return [each for each in children if "mobilegs.capture.pycolmap_worker" in each.cmdline()]
    except psutil.NoSuchProcess:
        return []


def test_results_and_progress_arrive(shared: PycolmapProcess, tmp_path: Path) -> None:
    files = [tmp_path / "a", tmp_path / "b"]
    for file in files:
        file.write_text(file.name)
    seen: list[tuple[int, int]] = []
    expected = digest_inputs(files, lambda done, total: None)
    found = shared.call("reading", digest_inputs, files, progress=lambda *done: seen.append(done))
    assert found == expected and seen == [(1, 2), (2, 2)]
    assert shared.call("looking", os.getpid) not in (os.getpid(), None)


def test_exceptions_of_the_process_are_raised(shared: PycolmapProcess, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot read .*nothing"):
        shared.call("reading", file_digest, tmp_path / "nothing")
    (tmp_path / "cameras.bin").write_text("not a model")
    with pytest.raises(InputError, match="pycolmap failed while reading poses") as caught:
        shared.call("reading poses", read_geometry, tmp_path)
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match=r"matching photos \(there is not enough memory"):
        shared.call("matching photos", bytearray, 1 << 62)
    with pytest.raises(RuntimeError, match=r"(?s)Traceback.*TypeError") as bug:
        shared.call("counting", len, 5)
    assert not isinstance(bug.value, InputError)
    assert shared.call("counting", len, "abc") == 3  # it still runs


@posix
@pytest.mark.parametrize(
    ("end", "number", "words"),
    [
        (signal.raise_signal, signal.SIGSEGV, "crashed while matching photos (SIGSEGV)"),
        (signal.raise_signal, signal.SIGKILL, "was killed while matching photos, as happens when"),
        pytest.param(
            *(os._exit, 7, "crashed while matching photos (exit code 7"), marks=pytest.mark.thorough
        ),
    ],
)
def test_a_crash_is_one_sentence(
    tmp_path: Path, end: Callable[[int], object], number: int, words: str
) -> None:
    log = tmp_path / "work" / "log"
    with PycolmapProcess(log) as process:
        with pytest.raises(InputError) as caught:
            process.call("matching photos", end, number)
        if end is os._exit:
            assert process.call("counting", len, "ab") == 2  # in another process
    message = str(caught.value)
    assert words in message and "--max-size" in message and str(log) in message
    assert "\n" not in message


def test_an_exception_here_ends_the_process(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("a")
    numbers = []

    def interrupt(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), PycolmapProcess(tmp_path / "log") as process:
        numbers.append(process.call("looking", os.getpid))
        process.call("reading", digest_inputs, [tmp_path / "a"], progress=interrupt)
    assert not psutil.pid_exists(numbers[0])


@posix
def test_the_process_ends_with_its_parent(tmp_path: Path) -> None:
    script = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from mobilegs.capture.pycolmap_runtime import PycolmapProcess\n"
        "with PycolmapProcess(Path(sys.argv[1])) as process:\n"
        "    process.call('starting', len, '')\n"
        "    process.call('sleeping', time.sleep, 600)\n"
    )
    words = [sys.executable, "-c", script, str(tmp_path / "log")]
    parent = subprocess.Popen(words, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    child = wait_for(lambda: workers(parent.pid))[0]  # type: ignore[index]
    parent.kill()
    parent.wait()
    child.wait(120)


# --- mobilegs capture -----------------------------------------------------------------------------


@pytest.mark.thorough
@posix
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_capture_that_dies_keeps_its_stages(tmp_path: Path, number: int) -> None:
    photos, capture = write_photos(tmp_path / "photos"), tmp_path / "capture"
    words = [sys.executable, "-m", "mobilegs", "capture", str(photos), "-o", str(capture)]
    command = subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # shells start background jobs with SIGINT ignored, and children inherit that
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    child = wait_for(lambda: workers(command.pid))[0]  # type: ignore[index]
    if number == signal.SIGKILL:
        child.kill()  # as the kernel does when memory runs out
    else:
        command.send_signal(number)
    printed = command.communicate(timeout=60)
    child.wait(120)  # interrupted while it starts, it ends when it finds no parent
    if number == signal.SIGKILL:
        assert command.returncode == 2
        assert "mobilegs: pycolmap was killed while finding features, as happens" in printed[1]
        assert "\n" not in printed[1].strip()
    else:
        assert command.returncode == 130, printed[1]
        assert "Traceback" not in printed[1]
    assert "finding features: finished" not in printed[0] and "poses for" not in printed[0]
    assert json.loads((capture / "work/photos.json").read_text())["done"] is True
    assert json.loads((capture / "work/features.json").read_text())["done"] is False
