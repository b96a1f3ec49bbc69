"""The folder of a run: its files, its checkpoint, and a stop between two steps."""

import json
import signal
import threading
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from pathlib import Path
from types import FrameType, NoneType
from typing import Any

import torch
from filelock import FileLock, Timeout

from mobilegs.atomic import atomic_write, read_input, read_json, refuse_links, remove_unfinished
from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.evaluate.report import RunMetrics
from mobilegs.train.budget import Plan
from mobilegs.train.recipes import Recipe, from_json
from mobilegs.train.state_file import STATE_ERRORS, UNUSABLE, read_state, write_state


@dataclass(frozen=True)
class Checkpoint:
    """The state from which a run resumes; the default is that of a new run."""

    stage: str | None = None
    """Name of the stage that was interrupted."""
    state: dict[str, Any] = field(default_factory=dict)
    """Result of `Stage.state()`."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Training time by stage."""
    log: list[dict[str, Any]] = field(default_factory=list)
    """Rows of metrics.jsonl."""


@dataclass(frozen=True)
class RunConfig:
    """The content of a run's `config.json`.

    Attributes:
        options: of the command line, as JSON data.
        recipe: all settings.
        photos: a result of `capture_fingerprint`.
        plan: of the time, if the run has a budget.
    """

    options: dict[str, Any]
    recipe: Recipe
    photos: dict[str, Any]
    plan: Plan | None = None


def load_config(path: Path, instead: str) -> RunConfig:
    """Return the content of a `config.json`.

    Raises InputError if the file is damaged or another version of the program wrote it; `instead`
    says what to do about a damaged one.
    """
    try:
        content = read_json(path)
    except InputError as error:
        raise InputError(f"{path} is damaged ({error}): {instead}") from error
    try:
        recipe, photos = from_json(Recipe, content["recipe"]), content["photos"]
        poses = [float(number) for number in photos["poses"]]
        _validate_options(content["options"])
        if len(poses) != 12:
            raise ValueError(f"a mean pose of {len(poses)} numbers")
        plan = None if content.get("plan") is None else Plan.from_json(content["plan"])
        return RunConfig(content["options"], recipe, {**photos, "poses": poses}, plan)
    except InputError as error:
        raise InputError(f"{path} cannot be used: {error}") from error
    except STATE_ERRORS as error:
        raise InputError(f"{path} is damaged ({error}): {instead}") from error


def _validate_options(options: dict[str, Any]) -> None:
    """Raise ValueError or another of `STATE_ERRORS` for options with which no run can go on."""
    teacher, downscale, background = (options[n] for n in ("teacher", "downscale", "background"))
    numbers = [options["seed"], 1 if downscale is None else downscale]
    if not (teacher is None or isinstance(teacher, str)) or any(
        type(n) is not int for n in numbers
    ):
        raise TypeError("its options have other types than they should")
    if background is not None and (
        len(background) != 3 or any(type(channel) not in (int, float) for channel in background)
    ):
        raise TypeError("its background is not three numbers")
    if not (0 <= numbers[0] < 1 << 32 and 1 <= numbers[1] < 1 << 16):
        raise ValueError("its options are out of range")


class RunDir:
    """Paths in the folder of a run. Every file appears complete or not at all.

    The files tell how far a run is: `teacher.ply` exists once the teacher is trained, `scene.mgs`
    once the student is, and `metrics.json` once everything is done. In between, `checkpoint`
    holds the state.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.config = path / "config.json"
        self.checkpoint = path / "checkpoint.safetensors"
        self.teacher = path / "teacher.ply"
        self.scene = path / "scene.mgs"
        self.poses = path / "poses.json"
        self.metrics = path / "metrics.json"
        self.log = path / "metrics.jsonl"
        self.contact_sheet = path / "contact_sheet.png"
        self.previews = path / "previews"
        self.report = path / "report.html"

    @property
    def _outputs(self) -> tuple[Path, ...]:
        """All files but `config.json` and previews."""
        results = (self.checkpoint, self.teacher, self.poses, self.scene, self.metrics, self.log)
        return *results, self.contact_sheet, self.report

    def validate_new(self) -> None:
        """Raise InputError if the folder holds a run or a file that a new run would overwrite.

        Other files in the folder do not matter.
        """
        for path in (self.path, *self.path.parents):
            if path.exists() and not path.is_dir():
                raise InputError(f"{path} is a file: give a folder for the run")
        if self.config.exists():
            raise InputError(
                f"{self.path} already holds a run: add --resume to continue it, or give another "
                "folder"
            )
        for file in (*self._outputs, self.previews):
            if file.exists():
                raise InputError(f"{file} would be overwritten: give another folder for the run")

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Keep other processes from this run; the folder must exist.

        Raises InputError if another process has the run, or a folder or the lock is a link.
        """
        refuse_links(self.previews, self.path / ".lock")
        lock = FileLock(self.path / ".lock")
        try:
            lock.acquire(blocking=False)
        except Timeout:
            raise InputError(
                f"another process trains the run in {self.path}: wait for it, or give another "
                "folder"
            ) from None
        try:
            for file in (self.config, *self._outputs, self.previews / "*.png"):
                remove_unfinished(file)
            yield
        finally:
            lock.release()

    def create(self, config: RunConfig) -> None:
        """Write `config.json` of a new run; raises InputError as `validate_new` does."""
        self.validate_new()
        self.write_config(config)

    def write_config(self, config: RunConfig) -> None:
        """Write `config.json`."""
        content = {
            "options": config.options,
            "recipe": asdict(config.recipe),
            "photos": config.photos,
            "plan": None if config.plan is None else config.plan.as_json(),
        }
        atomic_write(self.config, json.dumps(content, indent=2) + "\n")

    def load_config(self) -> RunConfig:
        """Return what `write_config` wrote.

        Raises InputError if the file is damaged or another version of the program wrote it.
        """
        return load_config(self.config, "delete the folder and start a new run")

    def load_metrics(self) -> RunMetrics:
        """Return the contents of `metrics.json`; raises InputError if it is damaged."""
        try:
            metrics = read_json(self.metrics)
            for stage, name in product(("teacher", "student"), ("gaussians", "file_bytes", "psnr")):
                if type(metrics[stage][name]) not in (int, float, NoneType):
                    raise TypeError(f"{name} of the {stage} is no number")
            return metrics
        except STATE_ERRORS as error:
            raise InputError(
                f"{self.metrics} is damaged ({error}): delete it, and --resume measures again"
            ) from error

    def save_checkpoint(self, checkpoint: Checkpoint) -> None:
        """Write the state of the current stage."""
        crc = self._teacher_crc() if checkpoint.stage == "student" else None
        write_state(self.checkpoint, {**vars(checkpoint), "teacher_crc": crc})

    def load_checkpoint(self) -> Checkpoint:
        """Return the last checkpoint, or the state of a new run if there is none.

        Raises InputError if it is damaged, or if the student learned from another teacher than
        the one in the folder.
        """
        if not self.checkpoint.exists():
            return Checkpoint()
        content = read_state(self.checkpoint)
        try:
            teacher_crc = content.pop("teacher_crc")
            checkpoint = Checkpoint(**content)
            seconds = {name: float(each) for name, each in checkpoint.seconds.items()}
            checkpoint = replace(
                checkpoint, seconds=seconds, log=[{**row} for row in checkpoint.log]
            )
        except STATE_ERRORS as error:
            raise InputError(f"{self.checkpoint} is damaged ({error}): {UNUSABLE}") from error
        if checkpoint.stage == "student" and teacher_crc != self._teacher_crc():
            raise InputError(
                f"{self.teacher} is not the teacher from which this run's student learned: restore "
                "it, or start a new run"
            )
        return checkpoint

    def remove_checkpoint(self) -> None:
        """Delete the checkpoint of a finished run."""
        self.checkpoint.unlink(missing_ok=True)

    def _teacher_crc(self) -> int | None:
        return zlib.crc32(read_input(self.teacher)) if self.teacher.exists() else None


def capture_fingerprint(dataset: Dataset) -> dict[str, Any]:
    """Return JSON data that identifies a capture: its photos' names and sizes, its mean pose."""
    frames = [*dataset.train, *dataset.test]
    sizes = [[frame.name, frame.camera.width, frame.camera.height] for frame in frames]
    poses = torch.stack([frame.camera.viewmat[:3] for frame in frames]).double().mean(0)
    return {"names": zlib.crc32(json.dumps(sizes).encode()), "poses": poses.flatten().tolist()}


def same_capture(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Return True if two fingerprints agree up to rounding on another machine."""
    poses = [torch.tensor(photos["poses"], dtype=torch.float64) for photos in (one, other)]
    return one["names"] == other["names"] and torch.allclose(*poses, rtol=1e-3, atol=1e-3)


class StopRequest:
    """A flag, true in a condition once a signal asked the process to stop."""

    def __init__(self) -> None:
        self.requested = False

    def __bool__(self) -> bool:
        return self.requested


@contextmanager
def stop_between_steps() -> Iterator[StopRequest]:
    """Turn Ctrl-C and SIGTERM into a request that the loop honours after the current step.

    A second signal stops at once. Outside the main thread, signal handlers do not change.
    """
    request = StopRequest()
    if threading.current_thread() is not threading.main_thread():
        yield request
        return
    previous = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def restore() -> None:
        for number, handler in previous.items():
            signal.signal(number, handler)

    def stop(number: int, frame: FrameType | None) -> None:
        request.requested = True
        restore()

    for number in previous:
        signal.signal(number, stop)
    try:
        yield request
    finally:
        restore()
