"""The verb `batch`: scenes of a whole list, on this machine or on a Ray cluster."""

import math
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from mobilegs.cli.output import console, escape
from mobilegs.errors import InputError, printable
from mobilegs.progress_display import INTERVAL, is_terminal, print_line

if TYPE_CHECKING:
    from mobilegs.batch.engine import Engine
    from mobilegs.batch.results import Entry


def batch(
    list: Annotated[Positional[Path], arg(metavar="LIST")],
    *,
    output: Annotated[Path, arg(aliases=["-o"], metavar="DIR")],
    default: Annotated[tuple[str, ...], arg(metavar="COLUMN=VALUE ...")] = (),
    resume: bool = False,
    engine: Literal["local", "ray"] = "local",
    device: Literal["auto", "cpu", "cuda"] = "auto",
    cores: Annotated[int | None, arg(metavar="N")] = None,
    retries: Annotated[int, arg(metavar="N")] = 3,
    cache: Annotated[Path | None, arg(metavar="FOLDER")] = None,
    prices: Annotated[tuple[float, float] | None, arg(metavar="CORE GPU")] = None,
) -> None:
    """Make the scenes of a whole list, on this machine or on a Ray cluster.

    Each row becomes a run in DIR/NAME, as by `mobilegs train` or `mobilegs compress`, with an
    exported page. DIR/index.html shows all scenes, and DIR/results.jsonl lists them. A row that
    fails stops no other. Ctrl-C stops all trainings after a checkpoint, and --resume continues.

    Args:
        list: A .csv with a heading, a .jsonl with an object per line, or a folder: photos, videos,
            captures and plain 3DGS scenes. The column source is a path, relative to the list, or
            an address like s3://bucket/photos; name is the name of the scene, by default that of
            the source. All other columns are options of `mobilegs train`, `compress`, `capture`
            and `export`: minutes, preset, steps, max_splats, seed, set, export, title, ...
        output: Folder for all runs, on storage that all machines share; created if missing.
        default: Values for rows that leave a column empty, as in `--default minutes=10 seed=1`.
        resume: Continue the batch in DIR: make what is missing, and try failed rows again.
        engine: local: processes on this machine. ray: the Ray cluster of RAY_ADDRESS, or else the
            one that runs on this machine.
        device: Device that trains; auto takes GPUs if a machine has one.
        cores: Cores of each pose finding, and of each training without a GPU. Default: those of
            the smallest machine, at most 8.
        retries: Further tries of a stage whose process or machine died.
        cache: Folder for fetched sources, on storage that all machines share. Default: DIR/cache.
        prices: Prices of a core-hour and a GPU-hour, for the forecast of the cost.
    """
    from mobilegs.batch.rows import read_list
    from mobilegs.batch.run import BatchOptions, run_batch

    if cores is not None and cores < 1:
        raise InputError(f"--cores takes 1 or more, not {cores}")
    if retries < 0:
        raise InputError(f"--retries takes 0 or more, not {retries}")
    rows = read_list(list, defaults_of(default))
    options = BatchOptions(output, resume, device, cores, retries, cache, prices)

    def open_engine() -> "Engine":
        return engine_of(engine, device)

    with lines() as (say, summarize):
        try:
            entries = run_batch(rows, options, open_engine, say, summarize)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"interrupted: add --resume to continue {output}") from None
    print(f"{output / 'index.html'} shows all scenes, {output / 'results.jsonl'} lists them")
    failed = [entry for entry in entries if entry.state == "failed"]
    if failed:
        print_failed(failed)
        raise SystemExit(1)


def defaults_of(words: Sequence[str]) -> dict[str, str]:
    """Return the columns of `--default`."""
    from mobilegs.batch.fetch import without_secrets

    columns = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not equals:
            raise InputError(f"--default takes COLUMN=VALUE, not '{without_secrets(word)}'")
        columns[name.strip()] = value.strip()
    return columns


def engine_of(name: Literal["local", "ray"], device: str) -> "Engine":
    """Return the engine of that name."""
    from mobilegs.batch.engine import LocalEngine, visible_gpus
    from mobilegs.batch.ray_engine import RayEngine

    if name == "ray":
        return RayEngine()
    return LocalEngine([] if device == "cpu" else visible_gpus())


@contextmanager
def lines() -> Iterator[tuple[Any, Any]]:
    """Show lines with the time, and below them on a terminal the latest summary.

    Yields a function for a line and one for the summary. Where there is no terminal, a summary is
    a line of its own, when a row has ended and after 30 seconds without a line.
    """
    if not is_terminal(sys.stdout):
        yield _plain_lines()
        return
    from rich.live import Live
    from rich.text import Text

    shown = console()
    with Live(Text(""), console=shown, refresh_per_second=2, transient=True) as live:
        latest = ""

        def say(text: str) -> None:
            shown.print(with_time(text), markup=False, highlight=False, soft_wrap=True)

        def summarize(text: str) -> None:
            nonlocal latest
            live.update(Text(printable(text)))
            latest = text

        yield say, summarize
        if latest:
            say(latest)


def _plain_lines() -> tuple[Any, Any]:
    printed_at, latest = -math.inf, ""

    def say(text: str) -> None:
        nonlocal printed_at
        print_line(sys.stdout, with_time(text))
        printed_at = time.monotonic()

    def summarize(text: str) -> None:
        nonlocal latest
        state = text.partition(" after ")[0]
        if state != latest or time.monotonic() - printed_at >= INTERVAL:
            say(text)
        latest = state

    return say, summarize


def with_time(text: str) -> str:
    """Return a line with the time of day before it."""
    return f"{time.strftime('%H:%M:%S')} {printable(text)}"


def print_failed(entries: "Sequence[Entry]") -> None:
    """Print a row for every scene that failed, with the reason."""
    from rich.table import Column, Table

    table = Table("failed", Column("while", overflow="fold"), box=None)
    for entry in entries:
        table.add_row(escape(entry.name), escape(entry.error))
    console().print(table)
