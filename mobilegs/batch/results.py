"""Results of a batch's rows: `results.jsonl`, and the lines that are printed."""

import json
import shlex
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from mobilegs.atomic import atomic_write
from mobilegs.batch.columns import command_of
from mobilegs.batch.fetch import shown_address
from mobilegs.batch.forecast import Effort
from mobilegs.batch.row_folder import RowFolder, RowKind
from mobilegs.batch.rows import Row
from mobilegs.errors import InputError
from mobilegs.train.run_dir import RunDir

State = Literal["waiting", "running", "done", "failed"]


@dataclass(frozen=True)
class Entry:
    """A line of `results.jsonl`.

    Attributes:
        name, source, kind, options: of the row; the source without secrets (`shown_address`).
        error: why it failed.
        command: the single command that trains the same scene.
        seconds: of the tasks by stage, all tries together.
        core_seconds, gpu_seconds: reserved by the tasks, all tries together.
        tries: number of tasks.
        machines: on which they ran.
        photos, image_size: of the capture, as trained.
        file_bytes, gaussians: of the student.
        psnr, ssim, lpips: of the student on held-back photos.
        page, poster: paths in the batch's folder.
    """

    name: str
    source: str
    kind: RowKind | None
    options: dict[str, str]
    state: State
    error: str = ""
    command: str = ""
    seconds: dict[str, float] = field(default_factory=dict)
    core_seconds: float = 0.0
    gpu_seconds: float = 0.0
    tries: int = 0
    machines: list[str] = field(default_factory=list)
    photos: int | None = None
    image_size: list[int] | None = None
    file_bytes: int | None = None
    gaussians: int | None = None
    psnr: float | None = None
    ssim: float | None = None
    lpips: float | None = None
    page: str | None = None
    poster: str | None = None

    @property
    def minutes(self) -> float:
        """Minutes of all tasks of the row."""
        return sum(self.seconds.values()) / 60

    def described(self) -> str:
        """Return a line for people about a row that is done."""
        size = "" if self.file_bytes is None else f", {self.file_bytes / 1e6:.2f} MB"
        quality = "" if self.psnr is None else f", {self.psnr:.2f} dB"
        return f"done{size}{quality}, {self.minutes:.1f} minutes"


def entry_of(row: Row, folder: RowFolder, kind: RowKind | None, state: State, error: str) -> Entry:
    """Return what the folder of a row tells of it."""
    events = folder.events()
    ended = [event for event in events if event["event"] == "ended"]
    seconds: dict[str, float] = {}
    for event in ended:
        seconds[event["stage"]] = seconds.get(event["stage"], 0.0) + event["seconds"]
    machines = [event["host"] for event in events if event["event"] == "started"]
    about: dict[str, Any] = {
        "seconds": {stage: round(value, 2) for stage, value in seconds.items()},
        "core_seconds": _total(ended, "cores"),
        "gpu_seconds": _total(ended, "gpus"),
        "tries": len({event["attempt"] for event in events}),
        "machines": list(dict.fromkeys(machines)),
    }
    source = shown_address(row.source)
    if kind is not None:
        place = folder.place()
        here = source if place is None else str(place[0])
        about["command"] = shlex.join(command_of(kind, here, folder.path, row.options))
    run = RunDir(folder.path)
    if run.metrics.exists():
        about |= _figures(run)
    if state == "done":
        about["page"] = _link(folder)
        about["poster"] = f"{row.name}/poster.jpg" if folder.poster.exists() else None
    return Entry(row.name, source, kind, row.options, state, error, **about)


def _total(ended: Sequence[dict[str, Any]], unit: str) -> float:
    """Return the seconds of cores or GPUs that tasks reserved."""
    return round(sum((event["seconds"] * event[unit] for event in ended), 0.0), 2)


def _figures(run: RunDir) -> dict[str, Any]:
    """Return the figures of a trained run; none if its metrics are damaged."""
    try:
        metrics = run.load_metrics()
        student, views = metrics["student"], metrics["views"]
    except (InputError, KeyError):
        return {}
    return {
        "photos": views["train"] + views["test"],
        "image_size": metrics["image_size"],
        "file_bytes": student["file_bytes"],
        "gaussians": student["gaussians"],
        "psnr": student["psnr"],
        "ssim": student["ssim"],
        "lpips": student.get("lpips_vgg"),
    }


def _link(folder: RowFolder) -> str:
    """Return the path of the page that shows a scene, from the batch's folder."""
    site = folder.site / "index.html"
    page = next((each for each in (folder.page, site) if each.exists()), RunDir(folder.path).report)
    return page.relative_to(folder.path.parent).as_posix()


def read_effort(row: Row, folder: RowFolder, kind: RowKind | None) -> Effort:
    """Return the time that the stages of a row took so far."""
    unit = next((name for name in ("steps", "minutes") if name in row.options), "")
    size = float(row.options[unit]) if unit else 1.0
    effort = Effort(f"{kind} {unit}", size)
    ended = [event for event in folder.events() if event["event"] == "ended"]
    done = {event["stage"] for event in ended if event["result"] == "done"}
    for event in ended:
        seconds, stage = event["seconds"], event["stage"]
        if stage in done:
            effort.taken[stage] = effort.taken.get(stage, 0.0) + seconds
        else:
            cores, gpus = effort.lost
            effort.lost = (cores + seconds * event["cores"], gpus + seconds * event["gpus"])
    return effort


def write_results(path: Path, entries: Sequence[Entry]) -> None:
    """Write `results.jsonl`: a line per row, in the order of the list."""
    lines = [json.dumps(asdict(entry)) + "\n" for entry in entries]
    atomic_write(path, "".join(lines))
