"""What the command line prints: tables, progress, figures for people."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mobilegs.cli.doctor import Finding

NAMED = 10  # photos in a line


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


def print_capture(found: dict[str, Any], output: Path) -> None:
    """What came of a capture: how many photos have a place, and how well points fit."""
    print(
        f"{output}: {found['registered']} of {found['photos']} photos placed, "
        f"{found['points']:,} points, reprojection error {found['reprojection_error']:.2f} px"
    )
    if found["left_out"]:
        names = found["left_out"]
        rest = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        print(f"left out: {', '.join(names[:NAMED])}{rest}")
    if len(found["models"]) > 1:
        sizes = " + ".join(str(size) for size in found["models"])
        print(f"the photos fall apart into models of {sizes}: the largest is kept")
    print(f"{output / 'coverage.png'} shows what is covered")


def print_trained(metrics: dict[str, Any], run: Path) -> None:
    """What came of a run: how large the scene is, and how good on held-back photos."""
    student, teacher = metrics["student"], metrics["teacher"]
    print(
        f"{run / 'scene.mgs'}: {student['gaussians']:,} Gaussians, "
        f"{student['file_bytes']:,} bytes, on held-back photos {decibels(student)} "
        f"(teacher {decibels(teacher)})"
    )
    print(f"{run / 'contact_sheet.png'} shows them side by side")


def print_findings(findings: Sequence[Finding]) -> None:
    """What a machine can do, a row each."""
    from rich.table import Table

    table = Table(box=None, show_header=False)
    marks = {"yes": "[green]yes[/]", "no": "[yellow]no[/]", "none": "-"}
    for finding in findings:
        text = f"{finding.found}\n-> {finding.remedy}" if finding.remedy else finding.found
        table.add_row(marks[finding.state], finding.what, escape(text))
    console().print(table)


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


PARTS = {
    "positions": "positions",
    "scale": "sizes",
    "rotation": "rotations",
    "rotation-finer": "rotations",
    "appearance": "colour",
    "opacity": "opacity",
    "lobes": "opacity and weight by direction",
    "color-matrices": "networks and matrices",
    "appearance-decoder": "networks and matrices",
    "lobe-decoder": "networks and matrices",
    "view-network": "networks and matrices",
    "codebooks": "codebooks",
}
IDLE = "what nobody uses"
# marks by which a terminal shows what follows from right to left
TURNS = dict.fromkeys([*range(0x202A, 0x202F), *range(0x2066, 0x206A), 0x200E, 0x200F, 0x061C])
CODINGS = {"nvq": "indices into codebooks (nvq)", "sq": "multiples of steps (sq)"}


def print_contents(found: dict[str, Any]) -> None:
    """What is in a scene's file, for people: what it is, how to blend it, where the bytes are."""
    from rich.table import Table

    size, count = found["file_bytes"], found["gaussians"]
    print(f"{found['file']}: {count:,} Gaussians, {size:,} bytes, {size / max(count, 1):.2f} each")
    table = Table(box=None, show_header=False)
    for name, text in _sentences(found).items():
        table.add_row(escape(name), escape(text))
    console().print(table)
    if found.get("meta"):
        # in a table of their own: a note must not pass for something that was found
        notes = Table("notes of who made it", "", box=None)
        for name, value in found["meta"].items():
            row = name.replace("_", " "), readable(value)
            notes.add_row(*(escape(text.translate(TURNS)) for text in row))
        console().print(notes)
    if "streams" not in found:
        return
    parts: dict[str, int] = {}
    for row in found["streams"]:
        part = PARTS[row["name"].split("@")[0].split(".")[0]] if row["used"] else IDLE
        parts[part] = parts.get(part, 0) + row["bytes"]
    parts["header"] = found["header_bytes"] + found["padding_bytes"]
    table = Table("part", box=None)
    for heading in ("bytes", "share", "bytes a Gaussian"):
        table.add_column(heading, justify="right")
    for part, taken in parts.items():
        table.add_row(part, f"{taken:,}", f"{taken / size:.1%}", f"{taken / count:.2f}")
    console().print(table)


def _sentences(found: dict[str, Any]) -> dict[str, str]:
    """What a report of `inspect_scene` says, by topic."""
    colour = f"spherical harmonics of degree {found['sh_degree']}"
    if "mode" not in found:
        return {"blended": "in the order of depth, as 3DGS does", "colour": colour}
    sorts = found["blend"] == "sorted"
    said = {
        "version": f"{found['version']} of the format",
        "blended": "in the order of depth, as 3DGS does"
        if sorts
        else f"without sorting, by the weights of {found['weighting']['name']}: "
        "a viewer that sorts shows it wrong",
        "colour": f"{colour}, made once of {found['color_latents']} numbers by "
        f"{'two matrices' if found['colors'] == 'linear' else 'networks'}",
        "opacity": "the same from everywhere",
        "codes": CODINGS[found["mode"]],
    }
    shape = found["lobes"]
    if shape is not None:
        said["opacity"] = (
            f"with the weight by direction: lobes of degree {shape['degree']}, made once of "
            f"{shape['latents']} numbers"
        )
    elif found["network"]:
        said["opacity"] = "with the weight by direction: a network, asked for every view"
    if "layers" in found:
        said["layers"] = " + ".join(f"{layer:,}" for layer in found["layers"]) + " Gaussians"
    said["cameras"] = f"{found['views']} for a first look"
    return said


def readable(value: Any) -> str:
    """A value for people: thousands apart, three digits after the point."""
    if isinstance(value, float):
        return f"{value:,.3f}"
    return f"{value:,}" if type(value) is int else str(value)


def decibels(figures: dict[str, Any]) -> str:
    """PSNR as text; null stands for a picture without any error."""
    return "without error" if figures["psnr"] is None else f"{figures['psnr']:.2f} dB"
