"""Runs of a tiny training, which a session trains once: finished, and interrupted."""

import signal
from pathlib import Path
from typing import Any

import pytest

from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_capture
from mobilegs.train.monitor import Monitor
from mobilegs.train.recipes import Recipe
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import TeacherConfig

RECIPE = Recipe(
    TeacherConfig(
        steps=12,
        max_splats=50,
        init_splats=40,
        densify=DensifyConfig(min_interval=3, prune_scale=0.0),
    ),
    StudentConfig(steps=18),
)


@pytest.fixture(scope="session")
def finished(capture: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run without interruption."""
    output = tmp_path_factory.mktemp("finished") / "run"
    train_capture(TrainRun(capture, output), recipe=RECIPE)
    return output


def stopped_in(stage: str, capture: Path, output: Path) -> Path:
    """Return the folder of a run that was interrupted in a stage."""
    after_step = Monitor.after_step

    def stop(monitor: Monitor, running: Any, result: Any) -> None:
        after_step(monitor, running, result)
        if (running.name, running.done) == (stage, 8):
            signal.raise_signal(signal.SIGINT)

    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(Monitor, "after_step", stop)
        train_capture(TrainRun(capture, output), recipe=RECIPE)
    return output


@pytest.fixture(scope="session")
def stopped(capture: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Runs that were interrupted, by the stage."""
    folder = tmp_path_factory.mktemp("stopped")
    return {stage: stopped_in(stage, capture, folder / stage) for stage in ("teacher", "student")}
