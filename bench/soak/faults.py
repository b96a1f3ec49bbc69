"""Trainings on a disk that becomes full, on a read-only disk, and two in one folder.

    python -m bench.soak.faults [--json OUT]

Needs the right to mount a memory disk (root on Linux). Each fault must end with exit code 2 and one
sentence that names the folder, and the run must then end as if nothing had happened.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bench.soak.record import add_record
from bench.soak.training import SoakError, Training, digests
from mobilegs.data.demo.capture import demo_capture, write_capture

DISK_MIB = 256
PATIENCE = 600.0  # seconds


@contextmanager
def memory_disk(folder: Path, options: str = "") -> Iterator[Path]:
    """Mount a memory disk; raises SoakError where that is not allowed."""
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={DISK_MIB}m{options}", "tmpfs", str(folder)]
    found = subprocess.run(command, capture_output=True, text=True)
    if found.returncode:
        raise SoakError(f"cannot mount a memory disk: {found.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def started(training: Training, run: Path) -> subprocess.Popen[str]:
    """Start a run, and wait for its first checkpoint."""
    process = subprocess.Popen(
        training.command(run), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    end = time.monotonic() + PATIENCE
    while not (run / "checkpoint.safetensors").exists():
        if process.poll() is not None or time.monotonic() > end:
            process.kill()
            raise SoakError(f"{run} made no checkpoint")
        time.sleep(0.01)
    return process


def refusal(process: subprocess.Popen[str], names: str) -> str:
    """Return the sentence with which a process ends; raises SoakError if it is none."""
    _, errors = process.communicate(timeout=PATIENCE)
    sentence = errors.strip().splitlines()[-1] if errors.strip() else ""
    if process.returncode != 2 or names not in sentence or "Traceback" in errors:
        raise SoakError(f"exit code {process.returncode}: {errors[-2000:]}")
    return sentence


def fill(folder: Path) -> Path:
    """Fill a disk; returns the file that does."""
    path = folder / "filler"
    with path.open("wb") as file:
        try:
            while True:
                file.write(bytes(1 << 16))
                file.flush()
        except OSError:
            return path


def full_disk(training: Training, expected: dict[str, str], folder: Path) -> str:
    """Fill the disk of a run, make room, and resume."""
    with memory_disk(folder) as disk:
        run = disk / "run"
        process = started(training, run)
        filler = fill(disk)
        said = refusal(process, str(run))
        filler.unlink()
        training.complete(run)
        if digests(run) != expected:
            raise SoakError(f"{run} differs after the disk was full")
    return said


def read_only_disk(training: Training, folder: Path) -> str:
    """Begin a run on a disk that cannot be written."""
    with memory_disk(folder, ",ro") as disk:
        process = subprocess.Popen(
            training.command(disk / "run"),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        return refusal(process, str(disk / "run"))


def two_processes(training: Training, expected: dict[str, str], run: Path) -> str:
    """Resume a run that is running."""
    first = started(training, run)
    second = subprocess.Popen(
        training.command(run), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    said = refusal(second, str(run))
    _, errors = first.communicate(timeout=PATIENCE)
    if first.returncode or digests(run) != expected:
        raise SoakError(f"the first of two processes was disturbed: {errors[-2000:]}")
    return said


def soak(folder: Path) -> dict[str, Any]:
    """Cause every fault in FOLDER and return the sentences; raises SoakError."""
    write_capture(folder / "capture", demo_capture(views=16, width=96, height=64, points=800))
    training = Training(folder / "capture")
    training.complete(folder / "whole")
    expected = digests(folder / "whole")
    said = {
        "full disk": full_disk(training, expected, folder / "full"),
        "read-only disk": read_only_disk(training, folder / "locked"),
        "two processes": two_processes(training, expected, folder / "shared"),
    }
    return {name: text.replace(str(folder), "FOLDER") for name, text in said.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="add the sentences to this file")
    options = parser.parse_args()
    if shutil.which("mount") is None or os.geteuid():
        sys.exit("this test mounts a memory disk: run it as root on Linux")
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = soak(Path(folder))
        except SoakError as error:
            sys.exit(str(error))
    print(json.dumps(found, indent=1))
    add_record(options.json, "faults", found)


if __name__ == "__main__":
    main()
