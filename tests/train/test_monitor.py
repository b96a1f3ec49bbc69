"""The progress display: the time left, a narrow terminal, and lines without a terminal."""

import io
import math
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import torch
from rich.console import Console

from mobilegs.train.monitor import Monitor
from mobilegs.train.stage import StepResult


@dataclass
class Counted:
    """A stage that only counts its steps."""

    name: str = "teacher"
    phase: str = "densify"
    steps: int = 30_000
    views_per_step: int = 1
    runs_kernels: bool = True
    exposures: None = None
    done: int = 0
    count: int = 213_148

    def nothing(self, *given: Any) -> Any:
        """Stand for the methods of a stage, which the display never calls."""

    advance = scene = state = restore = set_steps = nothing


def counted() -> Any:
    return Counted()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [0.0]
    monkeypatch.setattr("mobilegs.train.monitor.time.monotonic", lambda: now[0])
    return now


def advance(monitor: Monitor, stage: Any, clock: list[float], steps: int, each: float) -> None:
    for _ in range(steps):
        stage.done += 1
        clock[0] += each
        monitor.after_step(stage, StepResult(torch.tensor(0.05), torch.tensor(0.001)))


def test_the_time_left_follows_the_last_seconds(tmp_path: Path, clock: list[float]) -> None:
    stage = counted()
    with Monitor(tmp_path / "log", [], {}, silent=True) as monitor:
        monitor.begin(stage)
        advance(monitor, stage, clock, 1000, 0.1)
        assert monitor.summary(stage)["speed"] == "10.0 steps/s"
        clock[0] += 3600  # a machine that slept
        advance(monitor, stage, clock, 300, 0.1)
        found = monitor.summary(stage)
    assert found["speed"] == "10.0 steps/s"
    assert found["left"] == "47:50"  # 28,700 steps


def test_a_terminal_of_80_columns_shows_the_time_left(
    tmp_path: Path, clock: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    with (tmp_path / "screen").open("w+") as screen:
        narrow = Console(file=screen, width=80, force_terminal=True, color_system=None)
        monkeypatch.setattr("mobilegs.train.monitor.Console", lambda **options: narrow)
        monkeypatch.setattr("mobilegs.train.monitor.shows_bars", lambda: True)
        stage = counted()
        with Monitor(tmp_path / "log", [], {}) as monitor:
            monitor.begin(stage)
            advance(monitor, stage, clock, 301, 0.1)
            monitor.display.refresh()
        screen.seek(0)
        shown = screen.read()
    assert "301/30,000" in shown and "49:30 left" in shown and "10.0 steps/s" in shown


class Log(io.StringIO):
    """A log, and whether it has a line of step 301."""

    def __init__(self) -> None:
        super().__init__()
        self.has_step = threading.Event()

    def write(self, text: str, /) -> int:
        if "301 of 30,000" in text:
            self.has_step.set()
        return super().write(text)


def test_steps_without_a_pixel_have_no_psnr(tmp_path: Path) -> None:
    monitor = Monitor(tmp_path / "log", [], {})
    stage: Any = Counted(steps=2)
    monitor.begin(stage)
    for error in (math.nan, 0.01):
        stage.done += 1
        monitor.after_step(stage, StepResult(torch.zeros(()), torch.tensor(error)))
        assert monitor.rows[-1].get("psnr") == (None if math.isnan(error) else pytest.approx(20))
    assert "NaN" not in (tmp_path / "log").read_text("utf-8")


def test_a_log_has_the_state_of_the_training(
    tmp_path: Path, clock: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    log, stage = Log(), counted()
    monkeypatch.setattr("mobilegs.progress_display.INTERVAL", 0.01)
    monkeypatch.setattr("mobilegs.train.monitor.line_stream", lambda: log)
    with Monitor(tmp_path / "log", [], {}) as monitor:
        with monitor.begin(stage):
            advance(monitor, stage, clock, 301, 0.1)
            assert log.has_step.wait(60)
    begun, *lines, last = log.getvalue().splitlines()
    assert begun == "training the teacher: started"
    line = next(line for line in lines if "301 of 30,000" in line)
    assert "after 0:30, 49:30 left" in line and "30.00 dB" in line and "213,148" in line
    assert last == "training the teacher: finished in 0:30"
