"""Training from photos without poses, or a video: the capture is made first."""

import os
from collections.abc import Callable
from dataclasses import replace

from mobilegs.atomic import refuse_links
from mobilegs.capture import CaptureRun, is_capture_source
from mobilegs.data import has_poses
from mobilegs.errors import InputError
from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.preflight import validate_run
from mobilegs.scene_file import read_plain_scene
from mobilegs.train.run_dir import RunDir


def with_poses(run: TrainRun, make: Callable[[CaptureRun], None]) -> TrainRun:
    """Return `run`, with a capture made in its folder if its input has no poses.

    `make` makes the capture. Raises InputError for an invalid run before that.
    """
    if has_poses(run.capture) or not is_capture_source(run.capture):
        return run
    if int(os.environ.get("WORLD_SIZE", "1")) > 1:
        raise InputError(
            f"{run.capture} has no camera poses: make them with `mobilegs capture {run.capture} "
            "-o CAPTURE` before several processes train on CAPTURE"
        )
    validate_run(run)
    if run.teacher is not None and not RunDir(run.output).teacher.exists():
        read_plain_scene(run.teacher)  # minutes before it is needed
    first = CaptureRun(run.capture, run.output / "capture")
    if RunDir(run.output).config.exists() and not first.output.exists():
        raise InputError(f"{run.output} holds a run of something else: give another folder")
    refuse_links(first.output)
    make(first)
    return replace(run, capture=first.output)
