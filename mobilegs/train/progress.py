"""What a person sees of a training, and what it leaves to be plotted."""

import json
import math
import sys
import time
from pathlib import Path

import torch
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn

from mobilegs.atomic import atomic_write
from mobilegs.train.stage import Stage, StepResult
from mobilegs.train.student.config import StudentConfig

ROWS_PER_STAGE = 100  # lines of the journal
LINE_SECONDS = 10.0  # where there is no terminal, a line at least so far apart


class Monitor:
    """The display and the journal of a run; use it in a `with` block.

    The journal is JSON lines, one every hundredth of a stage: step, phase, mean loss and PSNR
    since the line before, Gaussians, seconds of the stage so far.
    """

    def __init__(
        self,
        journal: Path,
        rows: list[dict],
        seconds: dict[str, float],
        *,
        sizes: tuple[int, float] = StudentConfig().bytes_expected,
        silent: bool = False,
    ) -> None:
        """`rows` and `seconds` (by stage) are those of the run so far, and are added to.

        `sizes` are bytes that a file has once and for each Gaussian, by which its size is foretold.
        A silent one prints and writes nothing.
        """
        self.sizes = sizes
        self.journal, self.rows, self.seconds, self.silent = journal, rows, seconds, silent
        self.console = Console(stderr=True, quiet=silent)
        columns = (
            TextColumn("[bold]{task.description}"),
            BarColumn(bar_width=30),
            TextColumn("{task.completed:,.0f}/{task.total:,.0f}  {task.fields[status]}"),
        )
        self.display = Progress(
            *columns, console=self.console, disable=silent or not sys.stderr.isatty()
        )
        self.task: TaskID | None = None

    def __enter__(self) -> "Monitor":
        self.display.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.display.stop()

    def begin(self, stage: Stage) -> None:
        """Show another stage; its clock goes on from `seconds`."""
        if self.task is not None:
            self.display.remove_task(self.task)
        self.task = self.display.add_task(
            stage.name, total=stage.steps, completed=stage.done, status=""
        )
        self.every = max(1, stage.steps // ROWS_PER_STAGE)
        self.started = time.monotonic() - self.seconds.get(stage.name, 0.0)
        self.resumed_at = (stage.done, self.elapsed())
        self.said = -math.inf
        self.losses: list[torch.Tensor] = []
        self.errors: list[torch.Tensor] = []

    def elapsed(self) -> float:
        """Seconds of the present stage, over all its sessions."""
        return time.monotonic() - self.started

    def after_step(self, stage: Stage, result: StepResult) -> None:
        """Take note of a step.

        Raises FloatingPointError if training has diverged.
        """
        self.losses.append(result.loss)
        self.errors.append(result.mse)
        self.seconds[stage.name] = self.elapsed()
        if stage.done % self.every == 0 or stage.done == stage.steps:
            self._write_row(stage)
        if len(self.losses) % 10 == 1 or stage.done == stage.steps:
            self._show(stage)

    def note(self, **values: float | str | int) -> None:
        """Add to the journal what is no step."""
        self.rows.append(dict(values))
        self._flush()

    def say(self, text: str) -> None:
        """A line that stays, above the bar."""
        self.console.print(text, highlight=False, markup=False, soft_wrap=True)

    def _write_row(self, stage: Stage) -> None:
        loss = float(torch.stack(self.losses).mean())
        if not math.isfinite(loss):
            raise FloatingPointError(
                f"the {stage.name}'s loss is not a number at step {stage.done}: lower its rates"
            )
        self.latest = (loss, _psnr(self.errors))
        self.losses, self.errors = [], []
        self.note(
            stage=stage.name,
            step=stage.done,
            phase=stage.phase if stage.done < stage.steps else "done",
            loss=loss,
            psnr=self.latest[1],
            gaussians=stage.count,
            seconds=round(self.elapsed(), 2),
        )

    def _show(self, stage: Stage) -> None:
        now = time.monotonic()
        if self.display.disable and now - self.said < LINE_SECONDS and stage.done < stage.steps:
            return
        self.said = now
        status = self._status(stage)
        if self.display.disable:
            self.say(f"{stage.name} {stage.done}/{stage.steps}  {status}")
        elif self.task is not None:
            self.display.update(self.task, completed=stage.done, status=status)

    def figures(self, stage: Stage) -> dict[str, str]:
        """How a stage that has taken a step stands, for people."""
        if self.losses:
            loss, psnr = float(torch.stack(self.losses[-10:]).mean()), _psnr(self.errors[-100:])
        else:
            loss, psnr = self.latest
        first, seconds = self.resumed_at
        rate = (stage.done - first) / max(self.elapsed() - seconds, 1e-9)
        left = (stage.steps - stage.done) / max(rate, 1e-9)
        fixed, each = self.sizes
        size = (fixed + each * stage.count) / 1e6
        return {
            "phase": stage.phase,
            "loss": f"{loss:.4f}",
            "PSNR": f"{psnr:.2f} dB",
            "Gaussians": f"{stage.count:,}",
            "file": f"~{size:.{1 if size >= 1 else 2}f} MB",
            "speed": f"{rate:.1f} steps/s",
            "left": _clock(left),
        }

    def leave_out(self, seconds: float) -> None:
        """Time that just passed does not count: the training stood still."""
        self.started += seconds

    def _status(self, stage: Stage) -> str:
        phase, loss, psnr, count, size, speed, left = self.figures(stage).values()
        return f"{phase}  loss {loss}  {psnr}  {count} Gaussians  {size}  {speed}  {left} left"

    def _flush(self) -> None:
        if not self.silent:
            atomic_write(self.journal, "".join(json.dumps(row) + "\n" for row in self.rows))


def _psnr(errors: list[torch.Tensor]) -> float:
    """PSNR of the mean squared error, in dB; 99 for none."""
    return -10 * math.log10(max(float(torch.stack(errors).mean()), 10**-9.9))


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
