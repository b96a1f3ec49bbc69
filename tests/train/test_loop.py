"""The step loop: its files, and a stop from which it resumes."""

import json
from pathlib import Path

import pytest
import torch

from mobilegs.data.dataset import Dataset, ViewLoader
from mobilegs.train.distributed import SINGLE_PROCESS
from mobilegs.train.loop import LiveView, train_stage
from mobilegs.train.monitor import Monitor
from mobilegs.train.run_dir import RunDir, StopRequest
from mobilegs.train.stage import Stage
from mobilegs.train.teacher.trainer import Teacher
from tests.support.tiny import CPU, TEACHER

STOP_AT = 10


class StopButton:
    """A live view that stops the training after some steps."""

    def after_step(self, stage: Stage, stop: StopRequest) -> None:
        stop.requested = stage.done == STOP_AT


def run_loop(dataset: Dataset, run_dir: RunDir, live: LiveView | None = None) -> Teacher:
    """Train the tiny teacher in `run_dir`, from its checkpoint if there is one."""
    run_dir.path.mkdir(exist_ok=True)
    run_dir.previews.mkdir(exist_ok=True)
    stage = Teacher(TEACHER, dataset, seed=0, device=CPU)
    saved = run_dir.load_checkpoint()
    with (
        ViewLoader(dataset.train) as loader,
        Monitor(run_dir.log, saved.log, saved.seconds, silent=False) as monitor,
    ):
        train_stage(
            stage,
            loader,
            run_dir,
            monitor,
            SINGLE_PROCESS,
            resume_from=saved,
            order_seed=3,
            preview_frame=dataset.test[0],
            live=live,
        )
    return stage


def test_a_stopped_loop_resumes_bit_for_bit(dataset: Dataset, tmp_path: Path) -> None:
    whole, stopped = RunDir(tmp_path / "whole"), RunDir(tmp_path / "stopped")
    expected = run_loop(dataset, whole)
    with pytest.raises(KeyboardInterrupt):
        run_loop(dataset, stopped, StopButton())
    saved = stopped.load_checkpoint()
    assert (saved.stage, saved.state["done"]) == ("teacher", STOP_AT)
    resumed = run_loop(dataset, stopped)
    assert resumed.done == TEACHER.steps
    for name, tensor in expected.gaussians().tensors().items():
        assert torch.equal(tensor, resumed.gaussians().tensors()[name]), name
    rows = [json.loads(line) for line in stopped.log.read_text().splitlines()]
    assert [row["step"] for row in rows if "loss" in row] == list(range(1, TEACHER.steps + 1))


def test_the_loop_writes_eight_previews_and_a_final_checkpoint(
    dataset: Dataset, tmp_path: Path
) -> None:
    run_dir = RunDir(tmp_path / "run")
    stage = run_loop(dataset, run_dir)
    assert len(list(run_dir.previews.iterdir())) == 8
    assert run_dir.load_checkpoint().state["done"] == stage.done == TEACHER.steps
