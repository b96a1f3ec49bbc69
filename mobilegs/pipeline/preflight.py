"""Validation of options before the expensive work that precedes a training."""

import os
import shutil
from pathlib import Path

from mobilegs.device import choose_device
from mobilegs.errors import InputError
from mobilegs.evaluate.lpips import lpips_from
from mobilegs.live import validate_live_options
from mobilegs.pipeline.options import TrainRun, budget_of, repeat_run, resolve_recipe
from mobilegs.scene_file import plain_scene_at
from mobilegs.train.run_dir import RunDir

DISK = 200 << 20  # bytes that a run writes, about: photos, checkpoints, the teacher


def validate_run(run: TrainRun) -> None:
    """Raise InputError for what would stop a run after long work.

    That is an invalid option, a device or a teacher that is not there, and an output folder that
    the run cannot use or that lies on a full disk.
    """
    choose_device(run.device)
    run_dir = RunDir(run.output)
    if run.resume and run_dir.config.exists():
        validate_live_options(run.live, run.live_at)
    else:
        run_dir.validate_new()
        budget_of(run)
        resolve_recipe(run, None if run.recipe is None else repeat_run(run).recipe)
    lpips_from(run.lpips_weights)
    validate_folder(run.output)
    if run.teacher is not None and not run_dir.teacher.exists():
        plain_scene_at(run.teacher)


def validate_folder(output: Path) -> None:
    """Raise InputError if nothing can be written into a folder, or its disk is almost full."""
    there = next(path for path in (output, *output.resolve().parents) if path.exists())
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(f"cannot write into {there}: permission denied")
    free = shutil.disk_usage(there).free
    if free < DISK:
        raise InputError(
            f"the disk of {output} has {free >> 20} MiB left, and a run takes about {DISK >> 20}: "
            "make room, or give a folder on another disk"
        )
