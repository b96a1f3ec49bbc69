"""The report of a run: one HTML file with the scene, photos beside renders, curves and figures."""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mobilegs.atomic import atomic_write, read_text
from mobilegs.data.images import open_image
from mobilegs.errors import InputError
from mobilegs.mgs.codec import inspect_mgs
from mobilegs.mgs.contents import bytes_by_part
from mobilegs.train.run_dir import RunDir
from mobilegs.train.state_file import STATE_ERRORS
from mobilegs.view.assets import escaped
from mobilegs.view.export import HTML_MAX, embedded, embedded_policy, title_of
from mobilegs.view.poster import data_url, jpeg, posters_of
from mobilegs.view.serve import validate_scene_file

WIDTH, HEIGHT, LEFT, BOTTOM = 460, 220, 52, 24  # of a chart, in pixels
COLORS = {"teacher": "#c0392b", "student": "#0b62d6"}
STYLE = """
      :root { color-scheme: light dark; font: 15px/1.5 system-ui, sans-serif; }
      body { max-width: 1100px; margin: 0 auto; padding: 16px; }
      mobile-gs { display: block; height: 60vh; border-radius: 8px; }
      table { border-collapse: collapse; margin: 8px 0 24px; }
      th, td { padding: 2px 14px 2px 0; text-align: right; font-variant-numeric: tabular-nums; }
      th:first-child, td:first-child { text-align: left; }
      img { max-width: 100%; } svg { max-width: 100%; }
      svg text { font: 11px system-ui, sans-serif; fill: currentColor; }
      .scroll { overflow-x: auto; }
"""
FIGURES = {  # name of a metric: heading, decimals
    "psnr": ("PSNR dB", 2),
    "cc_psnr": ("PSNR dB, colours corrected", 2),
    "ssim": ("SSIM", 3),
    "neutral_rms": ("colour error of whites and greys, of 255", 2),
    "lpips_vgg": ("LPIPS", 3),
    "front": ("light lost before surfaces", 3),
}


def write_report(run_dir: RunDir) -> Path:
    """Write `report.html` of a finished run and return its path.

    Raises InputError if a file of the run is missing or damaged.
    """
    try:
        atomic_write(run_dir.report, _page(run_dir).encode())
    except InputError:
        raise
    except STATE_ERRORS as error:
        raise InputError(
            f"the metrics in {run_dir.path} are damaged ({error}): the run has no report"
        ) from error
    return run_dir.report


def _page(run_dir: RunDir) -> str:
    metrics = run_dir.load_metrics()
    rows = _log(run_dir.log)
    title = escaped(title_of(run_dir.scene))
    parts = [
        f"<h1>{title}</h1>",
        _scene(run_dir.scene),
        "<h2>Figures</h2>",
        _figures(metrics),
        _parts(run_dir.scene),
        "<h2>Held-back photos</h2>",
        "<p>Photo, teacher, student, and the student's error four times as strong.</p>",
        _picture(run_dir.contact_sheet),
        _photos(metrics),
        "<h2>Training</h2>",
        _chart(rows, "psnr", "PSNR of training photos, dB"),
        _chart(rows, "gaussians", "Gaussians, thousands", scale=1e-3),
        "<h2>Settings</h2>",
        f"<details><summary>config.json</summary><pre>{escaped(read_text(run_dir.config))}</pre>"
        "</details>",
    ]
    body = "\n    ".join(parts)
    return (
        '<!doctype html>\n<html lang="en">\n  <head>\n    <meta charset="utf-8" />\n'
        '    <meta name="viewport" content="width=device-width, initial-scale=1" />\n'
        f"    {embedded_policy()}\n"
        f"    <title>{title}</title>\n    <style>{STYLE}    </style>\n  </head>\n"
        f"  <body>\n    {body}\n  </body>\n</html>\n"
    )


def _log(path: Path) -> list[dict[str, Any]]:
    """Return the rows of `metrics.jsonl` that have a loss; none if the file was deleted."""
    if not path.exists():
        return []
    try:
        rows = [json.loads(line) for line in read_text(path).splitlines()]
        return [row for row in rows if isinstance(row, dict) and "loss" in row]
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is damaged ({error}): the run has no curves") from error


def _scene(scene: Path) -> str:
    """Return the viewer with the scene, or a sentence if the web viewer does not show it."""
    try:
        validate_scene_file(scene)
        poster = data_url(jpeg(posters_of(scene).preview), "image/jpeg")
    except InputError as error:
        return f"<p>{escaped(str(error))}</p>"
    if scene.stat().st_size > HTML_MAX:
        return "<p>The scene is too large for a page: see `mobilegs export --to site`.</p>"
    return "\n    ".join(embedded(scene, poster))


def _figures(metrics: Mapping[str, Any]) -> str:
    """Return a table of the teacher, the student and the run."""
    shown = {key: each for key, each in FIGURES.items() if _known(metrics["student"].get(key))}
    head = ["", "Gaussians", "MB", "minutes", *(name for name, _ in shown.values())]
    rows = []
    for stage in ("teacher", "student"):
        own, seconds = metrics[stage], metrics["seconds"].get(stage)
        values = [f"{own['gaussians']:,}", f"{own['file_bytes'] / 1e6:.2f}"]
        values.append("-" if seconds is None else f"{seconds / 60:.1f}")
        rows.append([stage, *values, *(_text(own.get(key), d) for key, (_, d) in shown.items())])
    for kind, own in metrics.get("formats", {}).items():
        values = [f"the teacher as .{kind}", "", f"{own['file_bytes'] / 1e6:.2f}", "-"]
        rows.append([*values, *(_text(own.get(key), d) for key, (_, d) in shown.items())])
    views, size = metrics["views"], metrics["image_size"]
    memory = metrics.get("peak_memory_mib")
    about = f"{views['train']} photos of {size[0]}x{size[1]} trained, {views['test']} held back"
    about += f"; {metrics['device']}; peak memory {memory:,.0f} MiB" if memory else ""
    return f"{_table(head, rows)}\n    <p>{escaped(about)}</p>"


def _parts(scene: Path) -> str:
    """Return a table of the parts of the file, the largest first."""
    contents = inspect_mgs(scene)
    whole, count = contents["file_bytes"], contents["gaussians"]
    parts = sorted(bytes_by_part(contents).items(), key=lambda part: -part[1])
    rows = [
        [name, f"{size:,}", f"{size / whole:.1%}", f"{size / count:.2f}"] for name, size in parts
    ]
    head = ["part of scene.mgs", "bytes", "of the file", "bytes a Gaussian"]
    return f"<details><summary>the bytes of scene.mgs</summary>{_table(head, rows)}</details>"


def _photos(metrics: Mapping[str, Any]) -> str:
    """Return a table of all held-back photos, the worst first."""
    views = sorted(
        metrics["student"]["views"], key=lambda v: math.inf if v["psnr"] is None else v["psnr"]
    )
    keys = [key for key in ("psnr", "cc_psnr", "ssim") if key in views[0]]
    head = ["photo, student", *(FIGURES[key][0] for key in keys)]
    rows = [[v["name"], *(_text(v[key], FIGURES[key][1]) for key in keys)] for v in views]
    return f"<details><summary>each photo, the worst first</summary>{_table(head, rows)}</details>"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    def line(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{escaped(cell)}</{tag}>" for cell in cells) + "</tr>"

    inner = line(head, "th") + "".join(line(row, "td") for row in rows)
    return f'<div class="scroll"><table>{inner}</table></div>'


def _picture(path: Path) -> str:
    try:
        with open_image(path) as image:
            picture = image.convert("RGB")
    except (InputError, OSError) as error:
        raise InputError(f"{path} is damaged ({error})") from error
    data = data_url(jpeg(picture, quality=85), "image/jpeg")
    return f'<img alt="photos beside renders" src="{data}" />'


def _chart(rows: Sequence[Mapping[str, Any]], key: str, title: str, scale: float = 1.0) -> str:
    """Return an SVG of a column of the log over the steps of both stages, one after the other."""
    lines: dict[str, list[tuple[float, float]]] = {}
    begin, last = 0.0, 0.0
    for row in rows:
        if row["stage"] not in lines:
            begin, lines[row["stage"]] = last, []
        last = begin + row["step"]
        if _known(row.get(key)):
            lines[row["stage"]].append((float(last), scale * float(row[key])))
    values = [y for line in lines.values() for _, y in line]
    if not values:
        return ""
    low, high = float(min(values)), float(max(values))
    if key == "psnr":
        low = max(low, high - 15)  # the first steps say nothing
    high = high if high > low else low + 1

    def place(x: float, y: float) -> str:
        across = LEFT + (WIDTH - LEFT - 8) * x / max(last, 1)
        share = (min(max(y, low), high) - low) / (high - low)
        return f"{across:.1f},{HEIGHT - BOTTOM - (HEIGHT - BOTTOM - 24) * share:.1f}"

    drawn = [f'<text x="{LEFT}" y="14">{escaped(title)}</text>']
    for share in (0.0, 0.5, 1.0):
        value = low + (high - low) * share
        x, y = place(0.0, value).split(",")
        drawn.append(f'<line x1="{x}" x2="{WIDTH - 8}" y1="{y}" y2="{y}" stroke="#8884" />')
        drawn.append(f'<text x="{LEFT - 6}" y="{y}" text-anchor="end">{value:,.1f}</text>')
    for name, line in lines.items():
        points, color = " ".join(place(x, y) for x, y in line), COLORS.get(name, "currentColor")
        drawn.append(
            f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="2" />'
        )
        at = place(line[len(line) // 2][0], low).split(",")[0] if line else str(LEFT)
        drawn.append(f'<text x="{at}" y="{HEIGHT - 6}" fill="{color}">{escaped(name)}</text>')
    box = f'viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}"'
    return f'<svg {box} role="img">{"".join(drawn)}</svg>'


def _known(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _text(value: Any, decimals: int) -> str:
    return f"{value:.{decimals}f}" if _known(value) else "-"
