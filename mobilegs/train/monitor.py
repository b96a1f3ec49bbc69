"""The progress display of a training, and its log for plots."""

import json
import logging
import math
import sys
import time
from collections import deque
from pathlib import Path
from typing import Any

import torch
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn

from mobilegs.atomic import atomic_write
from mobilegs.evaluate.metrics import decibels
from mobilegs.progress_display import (
    ProgressLines,
    clock,
    is_terminal,
    line_stream,
    shows_bars,
)
from mobilegs.train.stage import Stage, StepResult
from mobilegs.train.student.config import StudentConfig

ROWS_PER_STAGE = 100  # of the log
STATUS_SECONDS = 1.0  # between two states for lines
SPEED_SECONDS = 20.0  # of the last steps, whose speed predicts the time left
WIDE = 120  # columns of a terminal with place for a long bar
log = logging.getLogger(__name__)


class Monitor:
    """The progress display and the log of a run; use it in a `with` block.

    The log has a JSON line per hundredth of a stage: step, phase, mean loss and PSNR since the
    line before, number of Gaussians, seconds of the stage so far.

    Attributes:
        rows: the lines of the log.
        seconds: training time by stage.
    """

    def __init__(
        self,
        log_path: Path,
        rows: list[dict],
        seconds: dict[str, float],
        *,
        sizes: tuple[int, float] = StudentConfig().expected_bytes,
        silent: bool = False,
    ) -> None:
        """Continue the log `rows` and the times `seconds` of the run so far; both are modified.

        `sizes` predicts the size of the file: bytes per file and bytes per Gaussian. A silent
        monitor prints, logs and writes nothing.
        """
        self.sizes = sizes
        self.log_path, self.rows, self.seconds, self.silent = log_path, rows, seconds, silent
        self.console = Console(stderr=True, quiet=silent)
        columns = (
            TextColumn("[bold]{task.description}"),
            BarColumn(bar_width=30 if self.console.width >= WIDE else 10),
            TextColumn("{task.completed:,.0f}/{task.total:,.0f}  {task.fields[status]}"),
        )
        self.display = Progress(
            *columns,
            console=self.console,
            disable=silent or not shows_bars(),
            redirect_stdout=is_terminal(sys.stdout),  # a file has its own lines
        )
        self.stream = None if silent else line_stream()
        self.task: TaskID | None = None

    def __enter__(self) -> "Monitor":
        self.display.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.display.stop()

    def begin(self, stage: Stage) -> ProgressLines:
        """Start the display of a stage; its clock continues from `seconds`.

        Returns a context manager that prints lines where there is no terminal.
        """
        if self.task is not None:
            self.display.remove_task(self.task)
        self.task = self.display.add_task(
            stage.name, total=stage.steps, completed=stage.done, status=""
        )
        self.every = max(1, stage.steps // ROWS_PER_STAGE)
        self.started = time.monotonic() - self.seconds.get(stage.name, 0.0)
        self.latest_steps = deque([(stage.done, self.elapsed())])
        self.shown_at = -math.inf
        self.losses: list[torch.Tensor] = []
        self.errors: list[torch.Tensor] = []
        self.lines = self.lines_of(f"training the {stage.name}")
        return self.lines

    def elapsed(self) -> float:
        """Return the seconds of the current stage, those before a resume included."""
        return time.monotonic() - self.started

    def after_step(self, stage: Stage, result: StepResult) -> None:
        """Record the result of a step.

        Raises FloatingPointError if training has diverged.
        """
        self.losses.append(result.loss)
        self.errors.append(result.mse)
        self.seconds[stage.name] = now = self.elapsed()
        self.latest_steps.append((stage.done, now))
        while len(self.latest_steps) > 2 and self.latest_steps[1][1] < now - SPEED_SECONDS:
            self.latest_steps.popleft()
        if stage.done % self.every == 0 or stage.done == stage.steps:
            self._write_row(stage)
        if len(self.losses) % 10 == 1 or stage.done == stage.steps:
            self._show(stage)

    def log(self, **values: float | str | int) -> None:
        """Append a row to the log."""
        self.rows.append(dict(values))
        if not self.silent:
            atomic_write(self.log_path, "".join(json.dumps(row) + "\n" for row in self.rows))

    def exposures(self, stage: Stage, spread: float) -> None:
        """Log the spread of the photos' exposures, and print it if the stage learns them.

        A spread of 0 is not printed: nothing shows that they differ (`exposures_for`).
        """
        learned = stage.exposures is not None
        self.log(stage=stage.name, step=stage.done, exposure_spread=spread, learned=int(learned))
        if learned:
            why = (
                f"the photos' exposures differ by {100 * (2**spread - 1):.0f} %: " if spread else ""
            )
            self.note(f"{why}the {stage.name} learns colours for each photo")

    def note(self, text: str) -> None:
        """Log a note, unless the monitor is silent."""
        if not self.silent:
            log.info(text)

    def lines_of(self, title: str) -> ProgressLines:
        """Return a context manager for work between the stages: lines, and no bar."""
        return ProgressLines(title, self.stream)

    def _write_row(self, stage: Stage) -> None:
        loss = float(torch.stack(self.losses).mean())
        if not math.isfinite(loss):
            raise FloatingPointError(
                f"the {stage.name}'s loss is not a number at step {stage.done}: lower its "
                "learning rates"
            )
        self.latest = (loss, _psnr(self.errors))
        self.losses, self.errors = [], []
        self.log(
            stage=stage.name,
            step=stage.done,
            phase=stage.phase if stage.done < stage.steps else "done",
            loss=loss,
            **({} if math.isnan(self.latest[1]) else {"psnr": self.latest[1]}),
            gaussians=stage.count,
            seconds=round(self.elapsed(), 2),
        )

    def _show(self, stage: Stage) -> None:
        now = time.monotonic()
        if (
            self.display.disable
            and now - self.shown_at < STATUS_SECONDS
            and stage.done < stage.steps
        ):
            return
        self.shown_at = now
        status = self._status(stage)
        self.lines.update(stage.done, stage.steps, status)
        if self.task is not None:
            self.display.update(self.task, completed=stage.done, total=stage.steps, status=status)

    def summary(self, stage: Stage) -> dict[str, str]:
        """Return the state of a stage for people, after its first step."""
        if self.losses:
            loss, psnr = float(torch.stack(self.losses[-10:]).mean()), _psnr(self.errors[-100:])
        else:
            loss, psnr = self.latest
        (first, begun), (last, ended) = self.latest_steps[0], self.latest_steps[-1]
        rate = (last - first) / max(ended - begun, 1e-9)
        left = (stage.steps - stage.done) / max(rate, 1e-9)
        fixed, each = self.sizes
        size = (fixed + each * stage.count) / 1e6
        return {
            "phase": stage.phase,
            "loss": f"{loss:.4f}",
            "PSNR": decibels(psnr),
            "Gaussians": f"{stage.count:,}",
            "file": f"~{size:.{1 if size >= 1 else 2}f} MB",
            "speed": f"{rate:.1f} steps/s",
            "left": clock(left),
        }

    def exclude_time(self, seconds: float) -> None:
        """Subtract a pause that just ended from the stage's time."""
        self.started += seconds

    def _status(self, stage: Stage) -> str:
        phase, loss, psnr, count, size, speed, left = self.summary(stage).values()
        return f"{left} left  {speed}  {psnr}  {count} Gaussians  {size}  {phase}  loss {loss}"


def _psnr(errors: list[torch.Tensor]) -> float:
    """Return the PSNR of mean squared errors in dB, at most 99; those of empty masks are NaN."""
    return -10 * math.log10(max(float(torch.stack(errors).nanmean()), 10**-9.9))


def exposures_of(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return by stage the spread of the photos' exposures, and whether the stage learned them."""
    return {
        row["stage"]: {"spread": row["exposure_spread"], "learned": bool(row["learned"])}
        for row in rows
        if "exposure_spread" in row
    }
