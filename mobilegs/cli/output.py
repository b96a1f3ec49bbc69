"""Output of the command line for people: tables and summaries."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from mobilegs.cli.doctor import Finding
from mobilegs.errors import printable

if TYPE_CHECKING:
    from mobilegs.capture.run import CaptureReport
    from mobilegs.evaluate.other_formats import FormatMetrics
    from mobilegs.evaluate.report import FileMetrics, RunMetrics, SceneMetrics
    from mobilegs.scene_file import MgsFileContents, SceneContents

NAMES_MAX = 10  # photos in a line


def console() -> Any:
    """Return standard output, with colours on a terminal."""
    from rich.console import Console

    return Console()


def escape(text: str) -> str:
    """Return a text as `printable` has it, for rich: square brackets are its markup."""
    from rich.markup import escape

    return escape(printable(text))


def print_capture(report: "CaptureReport", output: Path) -> None:
    """Print how many photos have a pose, how well points fit, and the photos left out."""
    print(
        f"{output}: poses for {report['registered']} of {report['photos']} photos, "
        f"{report['points']:,} points, reprojection error {report['reprojection_error']:.2f} px"
    )
    if report["left_out"]:
        names = report["left_out"]
        rest = f" and {len(names) - NAMES_MAX} more" if len(names) > NAMES_MAX else ""
        print(printable(f"left out: {', '.join(names[:NAMES_MAX])}{rest}"))
    for colors, number in report.get("converted", {}).items():
        print(printable(f"converted to sRGB: {number} photos in {colors}"))
    for sentence in report.get("unreadable", [])[:NAMES_MAX]:
        print(printable(f"left out: {sentence}"))
    if others := report.get("other_files"):
        kinds = ", ".join(f"{number} {kind}" for kind, number in others.items())
        print(printable(f"files beside the photos that are none, and were not used: {kinds}"))
    if len(report["models"]) > 1:
        sizes = " + ".join(str(size) for size in report["models"])
        print(f"the photos form unconnected models of {sizes} photos: the largest is used")
    print(f"{output / 'coverage.png'} shows where photos are missing")


def print_trained(metrics: "RunMetrics", run: Path) -> None:
    """Print the size of a run's scene and its PSNR on held-back photos."""
    student, teacher = metrics["student"], metrics["teacher"]
    print(
        f"{run / 'scene.mgs'}: {student['gaussians']:,} Gaussians, "
        f"{student['file_bytes']:,} bytes, {psnr_text(student)} on held-back photos "
        f"(teacher: {psnr_text(teacher)})"
    )
    for kind, other in metrics.get("formats", {}).items():
        print(f"the same scene as .{kind}: {other['file_bytes']:,} bytes, {psnr_text(other)}")
    print(f"{run / 'report.html'} shows the scene, photos beside renders, curves and figures")
    print("next:")
    page = shlex.quote(str(run / f"{run.resolve().name}.html"))
    name = shlex.quote(str(run))
    for command, result in (
        (f"view {name}", "opens it in the browser"),
        (f"view {name} --lan", "opens it on a phone"),
        (f"export {name} --to html -o {page}", "makes one file to send"),
    ):
        print(f"  mobilegs {command}  # {result}")


def print_findings(findings: Sequence[Finding]) -> None:
    """Print a row per finding, with its remedy."""
    from rich.table import Table

    table = Table(box=None, show_header=False)
    marks = {"yes": "[green]yes[/]", "no": "[yellow]no[/]", "none": "-"}
    for finding in findings:
        text = f"{finding.found}\n-> {finding.remedy}" if finding.remedy else finding.found
        table.add_row(marks[finding.state], finding.what, escape(text))
    console().print(table)


def print_metrics(about: dict[str, Any], result: "SceneMetrics") -> None:
    """Print the metrics of an evaluation: a row per photo, then the means."""
    from rich.table import Table

    means = {name: mean for name, mean in result.items() if name != "views" and mean is not None}
    name = Path(about["scene"]).name
    line = f"{name}: {about['gaussians']:,} Gaussians, {about['file_bytes']:,} bytes"
    print(printable(line))
    line = f"{about['fragments']:.1f} fragments per pixel"
    if levels := about.get("fragments_by_level"):
        listed = ", ".join(f"{value:.1f}" for value in levels)
        line += f"; with levels {sum(levels):.1f} ({listed})"
    print(line)
    table = Table("photo", *(name.replace("_", " ") for name in means), box=None)
    for view in result["views"]:
        values = (dict(view)[name] for name in means)
        shown = ("-" if value is None else f"{value:.4f}" for value in values)
        table.add_row(escape(view["name"]), *shown)
    table.add_section()
    table.add_row("mean", *(f"{mean:.4f}" for mean in means.values()))
    console().print(table)


SORTED = "in order of depth, as in 3DGS"
QUANTIZERS = {"nvq": "codebooks (nvq)", "sq": "step sizes (sq)"}


def print_contents(contents: "SceneContents") -> None:
    """Print what a scene's file contains, how it is blended, and the bytes of each part."""
    from rich.table import Table

    from mobilegs.mgs.contents import bytes_by_part

    size, count = contents["file_bytes"], contents["gaussians"]
    line = f"{contents['file']}: {count:,} Gaussians, {size:,} bytes, "
    print(printable(line + f"{size / max(count, 1):.2f} per Gaussian"))
    if contents["left_out"]:
        print(f"left out: {contents['left_out']:,} rows that cannot be drawn")
    table = Table(box=None, show_header=False)
    for name, text in _topics(contents).items():
        table.add_row(escape(name), escape(text))
    console().print(table)
    if "streams" not in contents:
        return
    mgs = cast("MgsFileContents", contents)
    if mgs["meta"]:
        # in a separate table: a note must not look like a finding
        notes = Table("notes of the author", "", box=None)
        for name, value in mgs["meta"].items():
            row = name.replace("_", " "), readable(value)
            notes.add_row(*(escape(text) for text in row))
        console().print(notes)
    table = Table("part", box=None)
    for heading in ("bytes", "share", "bytes per Gaussian"):
        table.add_column(heading, justify="right")
    for part, taken in bytes_by_part(mgs).items():
        table.add_row(part, f"{taken:,}", f"{taken / size:.1%}", f"{taken / count:.2f}")
    console().print(table)


def _topics(contents: "SceneContents") -> dict[str, str]:
    """Return descriptions of a scene by topic."""
    import numpy as np

    from mobilegs.scene_file import up_source

    colour = f"spherical harmonics of degree {contents['sh_degree']}"
    up = up_source(
        Path(contents["file"]), None if contents["up"] is None else np.array(contents["up"])
    )
    if "streams" not in contents:
        return {"blending": SORTED, "colour": colour, "up": up}
    mgs = cast("MgsFileContents", contents)
    sorts = mgs["blend"] == "sorted"
    topics = {
        "version": f"{mgs['version']} of the format",
        "blending": SORTED
        if sorts
        else f"without sorting, weighting {mgs['weighting']['name']} "
        "(viewers that sort show it wrong)",
        "colour": f"{colour}, decoded on loading from {mgs['color_latents']} latents by "
        f"{'two matrices' if mgs['colors'] == 'linear' else 'networks'}",
        "opacity": "the same from all directions",
        "quantisation": QUANTIZERS[mgs["mode"]],
    }
    shape = mgs["lobes"]
    depends = "view-dependent" if sorts else "view-dependent, with the weight"
    if shape is not None:
        topics["opacity"] = (
            f"{depends}: lobes of degree {shape['degree']}, decoded on "
            f"loading from {shape['latents']} latents"
        )
    elif mgs["network"]:
        topics["opacity"] = f"{depends}: a network, evaluated for every view"
    if "footprint" in mgs:
        footprint = mgs["footprint"]
        parts = [f"blur of {footprint['blur']:g} px^2"]
        parts += ["antialiased"] if footprint["antialiased"] else []
        parts += ["soft edges"] if footprint["soft_edge"] else []
        topics["footprint"] = ", ".join(parts)
    if "layers" in mgs:
        topics["LOD levels"] = " + ".join(f"{n:,}" for n in mgs["layers"]) + " Gaussians"
    topics["cameras"] = f"{mgs['views']} for a first look"
    topics["up"] = up
    return topics


def readable(value: Any) -> str:
    """Format a value with thousands separators and three decimals."""
    if isinstance(value, float):
        return f"{value:,.3f}"
    return f"{value:,}" if type(value) is int else str(value)


def psnr_text(metrics: "FileMetrics | FormatMetrics") -> str:
    """Format a PSNR; None is that of images without error."""
    return "no error" if metrics["psnr"] is None else f"{metrics['psnr']:.2f} dB"
