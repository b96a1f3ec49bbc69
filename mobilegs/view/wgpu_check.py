"""Checks the GPUs: `python -m mobilegs.view.wgpu_check` prints a line of JSON for each.

`check_gpus` runs it in a process of its own, since a driver can crash or hang.
"""

import json
import subprocess
import sys
from typing import Any, NamedTuple

from mobilegs.child_process import module_command
from mobilegs.errors import InputError
from mobilegs.view.wgpu_device import REMEDY, gpus, name_of
from mobilegs.view.wgpu_renderer import AGREEMENT, agreement

SECONDS_MAX = 300.0  # a GPU in software takes two; on a busy machine many times that


class Check(NamedTuple):
    """The result for one GPU.

    Attributes:
        gpu: its name, as `wgpu_device.name_of` gives it.
        decibels: PSNR of its images against the reference; None if it cannot render.
        problem: a sentence, or an empty text if it renders right.
    """

    gpu: str
    decibels: float | None
    problem: str


def check(gpu: Any) -> Check:
    """Render small images with one of `gpus()`, and compare them with the reference."""
    try:
        decibels = agreement(gpu)
    except InputError as error:
        return Check(name_of(gpu), None, str(error))
    problem = "" if decibels >= AGREEMENT else f"its images are wrong ({decibels:.0f} dB)"
    return Check(name_of(gpu), decibels, problem)


def check_gpus() -> list[Check]:
    """Return the result for each GPU, the best first.

    Raises InputError without wgpu or a GPU, and if a driver ends the process.
    """
    command, environment = module_command("mobilegs.view.wgpu_check")
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, env=environment, timeout=SECONDS_MAX
        )
    except subprocess.TimeoutExpired:
        raise InputError(
            f"the GPU's driver took more than {SECONDS_MAX:.0f} s to draw a small image: {REMEDY}"
        ) from None
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    if done.returncode or not lines:
        if lines and isinstance(lines[-1], str):
            raise InputError(lines[-1])
        words = done.stderr.strip().splitlines() or ["no message"]
        raise InputError(f"the GPU's driver crashed while it drew ({words[-1]}): {REMEDY}")
    return [Check(*line) for line in lines]


def run() -> int:
    """Print the results, or the sentence of an InputError."""
    try:
        for gpu in gpus():
            print(json.dumps(check(gpu)), flush=True)
    except InputError as error:
        print(json.dumps(str(error)))
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(run())
