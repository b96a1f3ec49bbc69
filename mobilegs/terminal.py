"""What the command line prints: tables, progress, figures for people."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


def console() -> Any:
    """Standard output, with colours where it is a terminal."""
    from rich.console import Console

    return Console()


def escape(text: str) -> str:
    """Text in which square brackets are no markup."""
    from rich.markup import escape

    return escape(text)


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error; yields what is to be called with done and total."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Remaining

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Remaining())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


def print_figures(about: dict[str, Any], result: dict[str, Any]) -> None:
    """The figures of an evaluation as a table, a line a photo, the means last."""
    from rich.table import Table

    metrics = [name for name in result if name != "views" and result[name] is not None]
    name = Path(about["scene"]).name
    print(f"{name}: {about['gaussians']:,} Gaussians, {about['file_bytes']:,} bytes")
    table = Table("photo", *(name.replace("_", " ") for name in metrics), box=None)
    for view in result["views"]:
        table.add_row(escape(view["name"]), *(f"{view[name]:.4f}" for name in metrics))
    table.add_section()
    table.add_row("mean", *(f"{result[name]:.4f}" for name in metrics))
    console().print(table)


def print_contents(found: dict[str, Any]) -> None:
    """What is in a file: a line a value, and a table of its streams."""
    from rich.table import Table

    table = Table(box=None, show_header=False)
    for key, value in found.items():
        if isinstance(value, dict):
            table.add_row(key, ", ".join(f"{name} {readable(v)}" for name, v in value.items()))
        elif not isinstance(value, list):
            table.add_row(key, readable(value))
    console().print(table)
    for rows in (value for value in found.values() if isinstance(value, list) and value):
        table = Table(box=None)
        for key in rows[0]:
            table.add_column(key, justify="left" if key in ("name", "codec") else "right")
        for row in rows:
            table.add_row(*(readable(value) for value in row.values()))
        console().print(table)


def readable(value: Any) -> str:
    """A value for people: thousands apart, three digits after the point."""
    if isinstance(value, float):
        return f"{value:,.3f}"
    return f"{value:,}" if type(value) is int else escape(str(value))


def decibels(figures: dict[str, Any]) -> str:
    """PSNR as text; null stands for a picture without any error."""
    return "without error" if figures["psnr"] is None else f"{figures['psnr']:.2f} dB"
