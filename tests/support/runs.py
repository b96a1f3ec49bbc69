"""A finished run of a tiny training, which a session trains once."""

from pathlib import Path

import pytest

from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_capture
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
