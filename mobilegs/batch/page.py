"""The page of a batch: `index.html` with a poster, figures and a link for each scene."""

from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import mean
from string import Template
from urllib.parse import quote

from mobilegs.atomic import atomic_write
from mobilegs.batch.results import Entry
from mobilegs.view.assets import escaped

TEMPLATE = Path(__file__).with_name("page.html")
# label, key to sort by, text, whether the first click sorts upwards
Column = tuple[str, Callable[[Entry], float | None], Callable[[float], str], bool]
COLUMNS: tuple[Column, ...] = (
    ("MB", lambda each: each.file_bytes, lambda value: f"{value / 1e6:.2f}", True),
    ("PSNR, dB", lambda each: each.psnr, lambda value: f"{value:.2f}", False),
    ("Gaussians", lambda each: each.gaussians, lambda value: f"{value:,.0f}", False),
    ("Minutes", lambda each: each.minutes or None, lambda value: f"{value:.1f}", True),
)


def write_page(path: Path, entries: Sequence[Entry], summary: str) -> None:
    """Write the page of a batch; `summary` is a line about its progress."""
    template = Template(TEMPLATE.read_text(encoding="utf-8"))
    parts = {
        "title": escaped(path.resolve().parent.name),
        "summary": escaped(summary),
        "totals": "".join(_totals(entries)),
        "head": _head(),
        "rows": "\n          ".join(map(_row, entries)),
    }
    atomic_write(path, template.substitute(parts))


def _totals(entries: Sequence[Entry]) -> list[str]:
    """Return a few figures of all scenes that are done."""
    done = [each for each in entries if each.state == "done"]
    shown = [("scenes", f"{len(done)} of {len(entries)}")]
    if sizes := [each.file_bytes for each in done if each.file_bytes is not None]:
        shown.append(("MB in all", f"{sum(sizes) / 1e6:.2f}"))
    if qualities := [each.psnr for each in done if each.psnr is not None]:
        shown.append(("dB on average", f"{mean(qualities):.2f}"))
    if done:
        shown.append(("minutes per scene", f"{mean(each.minutes for each in done):.1f}"))
    return [f"<div><dt>{label}</dt><dd>{value}</dd></div>" for label, value in shown]


def _head() -> str:
    heads = ['<th role="columnheader" scope="col"><span hidden>Poster</span></th>']
    labels = [("Scene", True), *((label, upwards) for label, _, _, upwards in COLUMNS)]
    for label, upwards in labels:
        first = "ascending" if upwards else "descending"
        heads.append(
            f'<th role="columnheader" scope="col" data-first="{first}">'
            f'<button type="button">{label}</button></th>'
        )
    return "".join(heads)


def _row(each: Entry) -> str:
    page = None if each.page is None else quote(each.page)
    poster = (
        "" if each.poster is None else f'<img src="{quote(each.poster)}" alt="" loading="lazy" />'
    )
    name = f'<span class="name">{escaped(each.name)}</span>'
    if page is None:
        name += f'<span class="state {each.state}">{each.state}</span>'
        picture = f'<span class="poster">{poster}</span>'
    else:
        name = f'<a href="{page}">{name}</a>'
        picture = f'<a class="poster" href="{page}" tabindex="-1" aria-hidden="true">{poster}</a>'
    kind = "why" if each.error else "about"
    below = f'<div class="{kind}">{escaped(each.error or _about(each))}</div>'
    cells = [
        f'<td role="cell">{picture}</td>',
        f'<td role="cell" data-kind="text" data-value="{escaped(each.name)}">{name}{below}</td>',
    ]
    for label, key, text, _ in COLUMNS:
        value = key(each) if each.state == "done" else None
        shown = '<span class="none">-</span>' if value is None else text(value)
        order = "" if value is None else f"{value:.6g}"
        cells.append(f'<td role="cell" data-label="{label}" data-value="{order}">{shown}</td>')
    return f'<tr role="row" class="{each.state}">{"".join(cells)}</tr>'


def _about(each: Entry) -> str:
    """Return a line about a row: its title and its photos, or the source of one not yet made."""
    if each.photos is None or each.image_size is None:
        return each.source
    width, height = each.image_size
    parts = [each.options.get("title", ""), f"{each.photos} photos of {width} x {height}"]
    return ", ".join(filter(None, parts))
