"""A batch: every row of a list becomes a scene, with retries, results and a page."""

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from mobilegs.atomic import make_folder, refuse_links
from mobilegs.batch.columns import kind_of
from mobilegs.batch.engine import Engine, Node
from mobilegs.batch.fetch import is_address, shown_address
from mobilegs.batch.forecast import Effort, Forecast, Share, forecast
from mobilegs.batch.page import write_page
from mobilegs.batch.results import Entry, State, entry_of, read_effort, write_results
from mobilegs.batch.row_folder import RowFolder, RowKind, locked
from mobilegs.batch.rows import Row, refuse
from mobilegs.batch.task import POLL_SECONDS, STAGES, Outcome, Stage, Task
from mobilegs.errors import InputError
from mobilegs.progress_display import INTERVAL, clock
from mobilegs.train.run_dir import RunDir

PUBLISH_SECONDS = 5.0  # between two versions of results and page
CORES_MAX = 8  # of a task, unless more are asked for: trainings gain little from more
GPU_CORES_MAX = 4  # beside a GPU
RETRIES = 3
DOING = {
    "fetch": "fetching",
    "poses": "finding poses",
    "train": "training",
    "export": "exporting",
}


@dataclass(frozen=True)
class BatchOptions:
    """Options of a batch: those of `mobilegs batch` with the same names."""

    output: Path
    resume: bool = False
    device: Literal["auto", "cpu", "cuda"] = "auto"
    cores: int | None = None
    retries: int = RETRIES
    cache: Path | None = None
    prices: tuple[float, float] | None = None


@dataclass
class TrackedRow:
    """A row with its state; see `Entry` for what is published of it."""

    row: Row
    folder: RowFolder
    kind: RowKind | None
    state: State = "waiting"
    stage: Stage | None = None
    tries: int = 0
    attempt: int = 0
    started: float | None = None
    error: str = ""
    entry: Entry = field(init=False)
    effort: Effort = field(init=False)

    def refresh(self) -> None:
        """Read again what the folder tells of the row."""
        self.entry = entry_of(self.row, self.folder, self.kind, self.state, self.error)
        self.effort = read_effort(self.row, self.folder, self.kind)


# --- before anything runs -------------------------------------------------------------------------


def open_folder(options: BatchOptions, rows: Sequence[Row]) -> None:
    """Raise InputError unless the batch's folder can be used for these rows."""
    output = options.output
    for path in (output, *output.resolve().parents):
        if path.exists() and not path.is_dir():
            raise InputError(f"{path} is a file: give a folder for the batch")
    begun = (output / "results.jsonl").exists()
    if begun and not options.resume:
        raise InputError(
            f"{output} already holds a batch: add --resume to continue it, or give another folder"
        )
    if (output / "index.html").exists() and not begun:
        raise InputError(f"{output / 'index.html'} would be overwritten: give another folder")
    faults = []
    for row in rows:
        try:
            _validate_folder(output / row.name, row)
        except InputError as error:
            faults.append(f"row {row.number}: {error}")
    refuse(faults)
    make_folder(output)


def _validate_folder(path: Path, row: Row) -> None:
    """Raise InputError if a row's folder holds something else."""
    folder = RowFolder(path)
    begun = folder.load_row()
    run = RunDir(path)
    if begun is None:
        run.validate_new()
    elif not run.config.exists() and not folder.capture.exists():
        return  # nothing was made of the row yet
    elif begun["source"] != shown_address(row.source):
        raise InputError(
            f"{path} was begun with the source {begun['source']}: delete it, or give another name"
        )
    elif begun["options"] != row.options:
        both = begun["options"].keys() | row.options.keys()
        names = sorted(name for name in both if begun["options"].get(name) != row.options.get(name))
        raise InputError(
            f"{path} was begun with another {names[0]}: delete it, or give another name"
        )


def shares_for(options: BatchOptions, nodes: Sequence[Node]) -> dict[Stage, Share]:
    """Return the cores and GPUs of every stage; raises InputError if no machine has them."""
    if not nodes:
        raise InputError("the cluster has no machine with processor cores")
    with_gpu = [node for node in nodes if node.gpus]
    if options.device == "cuda" and not with_gpu:
        raise InputError("no machine has a GPU: leave out --device")
    cores = options.cores or min(CORES_MAX, *(node.cores for node in nodes))
    most = max(node.cores for node in nodes)
    if cores > most:
        raise InputError(f"no machine has {cores} cores: the largest has {most}")
    training = Share(cores, 0)
    if with_gpu and options.device != "cpu":
        each = min(node.cores // node.gpus // 2 for node in with_gpu)
        training = Share(max(1, min(GPU_CORES_MAX, each)), 1)
    return {
        "fetch": Share(1, 0),
        "poses": Share(cores, 0),
        "train": training,
        "export": Share(1, 0),
    }


# --- the batch ------------------------------------------------------------------------------------


def run_batch(
    rows: Sequence[Row],
    options: BatchOptions,
    open_engine: Callable[[], Engine],
    say: Callable[[str], None],
    summarize: Callable[[str], None],
) -> list[Entry]:
    """Make a scene of every row and return what became of each.

    `say` gets a line on every change, and `summarize` the latest summary. Raises InputError before
    anything runs if the folder or an option cannot be used, and KeyboardInterrupt after Ctrl-C,
    once all tasks have written their checkpoints.
    """
    open_folder(options, rows)
    output = options.output
    busy = InputError(f"another batch works in {output}: wait for it to end")
    with locked(output / ".lock", busy):
        engine = open_engine()
        try:
            nodes = engine.nodes()
            shares = shares_for(options, nodes)
            say(f"{engine.name}: {described(nodes)}; rows: {len(rows)}")
            return Batch(rows, options, engine, shares, say, summarize).run()
        finally:
            engine.close()


def described(nodes: Sequence[Node]) -> str:
    """Return the number of machines, and their cores and GPUs in total."""
    cores, gpus = sum(node.cores for node in nodes), sum(node.gpus for node in nodes)
    machines = f"{len(nodes)} machines, " if len(nodes) > 1 else ""
    return f"{machines}{cores} cores, {gpus} GPUs"


class Batch:
    """A batch in progress: submits the next stage of every row until all are done or failed."""

    def __init__(
        self,
        rows: Sequence[Row],
        options: BatchOptions,
        engine: Engine,
        shares: dict[Stage, Share],
        say: Callable[[str], None],
        summarize: Callable[[str], None],
    ) -> None:
        """Read the states of the rows from their folders. Arguments as in `run_batch`."""
        self.options, self.engine, self.shares = options, engine, shares
        self.say, self.summarize = say, summarize
        refuse_links(options.output / "cache")
        self.cache = (options.cache or options.output / "cache").resolve()
        self.rows = [self._begin(row) for row in rows]
        self.by_folder = {str(each.folder.path): each for each in self.rows}
        self.begun = time.monotonic()
        self.published = self.summarized = -INTERVAL
        self.changed = True

    def _begin(self, row: Row) -> TrackedRow:
        """Return a row with the state that its folder tells."""
        folder = RowFolder(self.options.output.resolve() / row.name)
        folder.create(shown_address(row.source), row.options, row.own)
        if not is_address(row.source):
            folder.set_place(Path(row.source), kind_of(Path(row.source)))
        tracked = TrackedRow(row, folder, None, attempt=folder.attempts())
        self._advance(tracked)
        return tracked

    def run(self) -> list[Entry]:
        """Work until every row is done or failed; return what became of them.

        After KeyboardInterrupt all tasks have stopped, and another call can continue.
        """
        try:
            while any(each.state in ("waiting", "running") for each in self.rows):
                self._submit()
                self._note_started()
                for task, outcome in self.engine.ended(POLL_SECONDS):
                    self._note_ended(self.by_folder[task.folder], task, outcome)
                self._publish()
        finally:
            self.engine.stop()
            for each in self.rows:
                if each.state == "running":
                    each.state = "waiting"
                    each.refresh()
            self._publish(now=True)
        return [each.entry for each in self.rows]

    def _submit(self) -> None:
        """Submit waiting stages, the last ones of a row first, as long as the engine takes them."""
        ready = [each for each in self.rows if each.state == "waiting"]
        ready.sort(key=lambda each: -STAGES.index(each.stage or "fetch"))
        gpus_taken = False
        for each in ready:
            assert each.stage is not None
            share = self.shares[each.stage]
            if share.gpus and gpus_taken:
                continue
            task = Task(
                str(each.folder.path),
                each.stage,
                each.attempt + 1,
                share.cores,
                share.gpus,
                str(self.cache),
                {key: os.environ[key] for key in ("MOBILEGS_LPIPS",) if key in os.environ},
                each.row.source if each.stage == "fetch" else "",
            )
            if not self.engine.accepts(task):
                if share.gpus:
                    gpus_taken = True
                    continue  # other stages may use cores
                break  # small tasks would keep the cores from a large one
            each.attempt, each.state, each.started = task.attempt, "running", None
            each.tries += 1
            self.engine.submit(task)
            each.refresh()
            self.changed = True

    def _note_started(self) -> None:
        """Say which tasks have begun, and where."""
        for each in self.rows:
            if each.state == "running" and each.started is None:
                event = each.folder.find("started", each.attempt)
                if event is not None:
                    each.started = event["time"]
                    again = f", try {each.tries}" if each.tries > 1 else ""
                    share = f"{event['cores']} cores" if event["cores"] > 1 else "1 core"
                    share += ", GPU" if event["gpus"] else ""
                    stage = DOING[event["stage"]]
                    self.say(f"{each.row.name}: {stage} ({share}, {event['host']}{again})")
                    each.refresh()
                    self.changed = True

    def _note_ended(self, each: TrackedRow, task: Task, outcome: Outcome) -> None:
        """Bring a row to its next stage, to another try, or to its end."""
        if each.folder.find("ended", task.attempt) is None:  # its machine could not say so itself
            started = each.folder.find("started", task.attempt) or {"time": time.time(), "host": ""}
            about = {"stage": task.stage, "cores": task.cores, "gpus": task.gpus}
            each.folder.append(
                "ended",
                task.attempt,
                **about,
                result=outcome.result,
                message=outcome.message,
                seconds=round(time.time() - started["time"], 2),
            )
        name, doing = each.row.name, DOING[task.stage]
        again = outcome.result != "refused" and each.tries <= self.options.retries
        if outcome.result == "done":
            each.tries = 0
            self._advance(each)
            if each.state == "done":
                self.say(f"{name}: {each.entry.described()}")
        elif again:
            each.state = "waiting"
            self.say(f"{name}: {doing} was lost ({outcome.message}); it continues")
        else:
            each.state, each.error = "failed", f"{doing}: {outcome.message}"
            self.say(f"{name}: failed while {each.error}")
        each.refresh()
        self.changed = True

    def _advance(self, each: TrackedRow) -> None:
        """Find the next stage of a row from what its folder holds."""
        place = each.folder.place()
        each.kind = None if place is None else place[1]
        each.stage = next_stage(each.folder, place)
        each.state = "done" if each.stage is None else "waiting"
        each.refresh()

    def forecast(self) -> Forecast | None:
        """Return the forecast for all rows that did not fail."""
        efforts = []
        for each in self.rows:
            effort = each.effort
            if each.state in ("waiting", "running"):
                open_stages = open_after(each.stage, each.kind)
                elapsed = 0.0 if each.started is None else time.time() - each.started
                running = each.state == "running"
                effort = replace(effort, open=open_stages, elapsed=elapsed if running else 0.0)
            efforts.append(effort)
        nodes = self.engine.nodes()
        cores, gpus = sum(node.cores for node in nodes), sum(node.gpus for node in nodes)
        return forecast(efforts, self.shares, cores, gpus)

    def summary(self) -> str:
        """Return a line about the whole batch: done, failed, time left, hours and cost."""
        states = [each.state for each in self.rows]
        parts = [f"{states.count('done')} of {len(states)} done"]
        if "failed" in states:
            parts.append(f"{states.count('failed')} failed")
        text = ", ".join(parts) + f" after {clock(time.monotonic() - self.begun)}"
        expected = self.forecast()
        if expected is None:
            return f"{text}; the first rows will tell the time left"
        if expected.seconds_left:
            text += f"; {clock(expected.seconds_left)} left"
        hours = f"{expected.core_hours:.2f} core-hours"
        if expected.gpu_hours:
            hours += f" and {expected.gpu_hours:.2f} GPU-hours"
        text += f"; the whole list: {hours}"
        if self.options.prices is not None:
            core, gpu = self.options.prices
            text += f", cost {expected.core_hours * core + expected.gpu_hours * gpu:,.2f}"
        return text

    def _publish(self, *, now: bool = False) -> None:
        """Write results and page, if something changed and the last ones are not new.

        The summary is passed on with them, and otherwise every 30 seconds.
        """
        write = now or (self.changed and time.monotonic() - self.published >= PUBLISH_SECONDS)
        if not write and time.monotonic() - self.summarized < INTERVAL:
            return
        summary = self.summary()
        if write:
            entries = [each.entry for each in self.rows]
            write_results(self.options.output / "results.jsonl", entries)
            write_page(self.options.output / "index.html", entries, summary)
            self.published, self.changed = time.monotonic(), False
        self.summarize(summary)
        self.summarized = time.monotonic()


def next_stage(folder: RowFolder, place: tuple[Path, RowKind] | None) -> Stage | None:
    """Return the first stage that a row still needs, or None if it is done."""
    if place is None:
        return "fetch"
    done, run = folder.done_stages(), RunDir(folder.path)
    if place[1] == "photos" and "poses" not in done:
        return "poses"
    if "train" not in done or not run.metrics.exists() or not run.scene.exists():
        return "train"
    return None if "export" in done else "export"


def open_after(stage: Stage | None, kind: RowKind | None) -> list[Stage]:
    """Return the stages of a row from `stage` on; a source that is not fetched counts as posed."""
    if stage is None:
        return []
    skipped = () if kind == "photos" else ("poses",)
    return [each for each in STAGES[STAGES.index(stage) :] if each not in skipped]
