"""Photos without poses, or a video: the capture that has to be made before a run can train."""

import os
from collections.abc import Callable
from dataclasses import replace

from mobilegs.capture import CaptureRun, is_source
from mobilegs.data import has_poses
from mobilegs.errors import InputError
from mobilegs.pipeline.preflight import refuse_beforehand
from mobilegs.pipeline.train import TrainRun
from mobilegs.train.run_dir import RunFolder


def with_poses(run: TrainRun, make: Callable[[CaptureRun], None]) -> TrainRun:
    """The run itself, or where it is of photos without poses or a video, one that has them.

    `make` is called for the capture, in the run's folder, that takes the photos' place. Raises
    InputError for what can be refused before the work of it.
    """
    if has_poses(run.capture) or not is_source(run.capture):
        return run
    if int(os.environ.get("WORLD_SIZE", "1")) > 1:
        raise InputError(
            f"{run.capture} has no camera poses: make them with `mobilegs capture {run.capture} "
            "-o CAPTURE` before several processes train on CAPTURE"
        )
    refuse_beforehand(run)
    first = CaptureRun(run.capture, run.output / "capture")
    if RunFolder(run.output).config.exists() and not first.output.exists():
        raise InputError(f"{run.output} holds a run of something else: give another folder")
    make(first)
    return replace(run, capture=first.output)
