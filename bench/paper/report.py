"""Write the tables of the paper's pages from the collected cells.

docs/explanation/paper.md gets the table at equal bytes, a verdict on each claim of the paper, the
long runs and the short ones; paper_settings.md what each departure of the default gains. `make
docs` makes the page of the tables line by line and of all rows, paper_tables.md, which is not
committed.

    python -m bench.paper.report [--json bench/results/paper.json] [--tables FILE]
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import mean
from typing import NamedTuple

from bench.paper.captures import TITLES as GROUPS
from bench.paper.cells import scenes_of
from bench.paper.claims import (
    CLAIMS,
    DEPARTURES,
    LINES,
    PAPER_DELTAS,
    Line,
    base_of,
)
from bench.paper.equal_bytes import MOTION, equal_table, summary
from bench.paper.printed_bytes import readings
from bench.paper.rows import RELEASES, ROWS
from bench.paper.verdicts import LONG, own_rows, place, verdict_of
from bench.record import filled
from mobilegs.train.recipes import RECIPES

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/explanation/paper.md"
SETTINGS = ROOT / "docs/explanation/paper_settings.md"
PAIRED = ("horns-250", "lego-200")
SMALL = ("bonsai-400", *PAIRED)
TESTED = (*PAIRED, "bonsai-800-short")
TITLES = {
    "main": "Teacher and students",
    "default": "The default as it ships",
    "ablation": "What each part is worth",
    "pruning": "Pruning",
    "codebooks": "Codebooks",
    "rivals": "Rivals in the same trainer",
    "paper": "The paper's own model",
}
HEADS = {
    "ablation": "The ablation table",
    "pruning": "The tables of pruning",
    "codebooks": "The table of codebook sizes",
    "rivals": "Rivals",
}
TABLES_HEAD = """\
# All rows of the paper's tables

`make docs` makes this page from `bench/results/paper.json`, by `python -m bench.paper.report
--tables FILE`. [The paper's tables](paper.md) explains rows, protocol and findings.

| column | meaning |
|---|---|
| PSNR, SSIM, LPIPS | of held-back photos at 8 bits; LPIPS is VGG on images in [0, 1] |
| against the base | difference to the row without the change, by the same teacher |
| paper | the paper's difference to its whole method, mean of Mip-NeRF 360 |
| MiB | the file's, with one LOD level; of rows without codes four bytes per number |
| ms per frame | a whole frame of the CPU kernels, the fastest of four |
| min | the student's training, or the teacher's in its own row |
| ± | half the distance between two seeds; without it there is one seed |

Milliseconds and minutes come from several machines, many of them busy: they say little.
"""


class Run(NamedTuple):
    """The properties that the cells of one table share."""

    scene: str
    teacher_steps: int
    student_steps: int
    unusual: str
    """The parts that are not the default: protocol, seed of the teacher, settings."""

    @property
    def title(self) -> str:
        """Return the lengths, and everything that is not the default."""
        more = f", {self.unusual}" if self.unusual else ""
        return f"{self.teacher_steps} + {self.student_steps} steps{more}"


def number(values: Sequence[float | None], digits: int) -> str:
    """Return the mean, or a dash where a value is missing."""
    known = [value for value in values if value is not None]
    if not values or len(known) < len(values):
        return "-"
    return f"{mean(known):.{digits}f}"


def spread(values: list[float]) -> str:
    """Return half the distance between the largest and the smallest value."""
    return f" ± {(max(values) - min(values)) / 2:.2f}" if len(values) > 1 else ""


def difference(cells: list[dict], base: list[dict]) -> float | None:
    """Return the mean PSNR difference to cells of the same scene and seed, or None."""
    of = {(cell["scene"], cell["seed"]): cell["psnr"] for cell in base}
    pairs = [(cell["psnr"], of.get((cell["scene"], cell["seed"]))) for cell in cells]
    found = [psnr - other for psnr, other in pairs if other is not None]
    return mean(found) if found else None


def signed(value: float | None) -> str:
    return "-" if value is None else f"{value:+.2f}"


def row_of(name: str, cells: list[dict], base: list[dict] | None) -> list[str]:
    """Return a row of one scene: the mean over its seeds."""
    psnrs = [cell["psnr"] for cell in cells]
    delta = difference(cells, base) if base and name != base_of(name) else None
    return [
        f"`{name}`",
        ROWS[name].about,
        number(psnrs, 2) + spread(psnrs),
        signed(delta),
        signed(PAPER_DELTAS.get(name)),
        number([cell["ssim"] for cell in cells], 4),
        number([cell.get("lpips_vgg") for cell in cells], 3),
        number([cell.get("front") for cell in cells], 3),
        number([cell["bytes"] / 2**20 for cell in cells], 2),
        number([cell["gaussians"] / 1000 for cell in cells], 1),
        number([cell["frame_ms"] for cell in cells], 1),
        number([cell["seconds"] / 60 for cell in cells], 1),
    ]


def mean_row(name: str, cells: list[dict], base: list[dict] | None) -> list[str]:
    """Return a row of several scenes: the mean over scenes of the mean over seeds."""
    scenes = sorted({cell["scene"] for cell in cells})
    by_scene = {scene: [cell for cell in cells if cell["scene"] == scene] for scene in scenes}
    deltas = [difference(found, base) for found in by_scene.values()] if base else []
    known = [delta for delta in deltas if delta is not None]

    def over(digits: int, field: str, scale: float = 1.0) -> str:
        values = [[cell.get(field) for cell in found] for found in by_scene.values()]
        if any(value is None for found in values for value in found):
            return "-"
        return number([scale * mean(found) for found in values], digits)

    return [
        f"`{name}`",
        ROWS[name].about,
        str(len(scenes)),
        over(2, "psnr"),
        signed(mean(known) if known and name != base_of(name) else None),
        signed(PAPER_DELTAS.get(name)),
        over(4, "ssim"),
        over(3, "lpips_vgg"),
        over(3, "front"),
        over(2, "bytes", 2**-20),
        over(1, "gaussians", 1e-3),
        over(1, "frame_ms"),
        over(1, "seconds", 1 / 60),
    ]


FIGURES = ["PSNR", "against the base", "paper, mean of Mip-NeRF 360", "SSIM", "LPIPS"]
FIGURES += ["light lost before surfaces", "MiB", "k Gaussians", "ms per frame", "min"]
HEADINGS = ["row", "what", *FIGURES]
OF_SEVERAL = ["row", "what", "scenes", *FIGURES]


def table(headings: list[str], rows: list[list[str]], words: int = 2) -> list[str]:
    """Return the lines of a table; all columns but the first `words` are aligned as numbers."""
    lines = [headings, ["---"] * words + ["---:"] * (len(headings) - words), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def non_defaults(cell: Mapping, stages: tuple[str, ...]) -> str:
    """Return the words for a protocol and settings that differ from the default."""
    words = [cell["protocol"]] if cell.get("protocol", "paper") != "paper" else []
    if "student" in stages and cell.get("teacher_seed", 0):
        words.append(f"teacher of seed {cell['teacher_seed']}")
    settings = cell.get("settings", {}).items()
    words += [f"{path}={value}" for path, value in settings if path.split(".")[0] in stages]
    return ", ".join(words)


def teacher_of(cell: Mapping) -> tuple[str, int, str, int]:
    """Return the properties of a teacher; its seed comes last."""
    seed = cell.get("teacher_seed", 0) if cell["student_steps"] else cell["seed"]
    return cell["scene"], cell["teacher_steps"], non_defaults(cell, ("teacher",)), seed


def run_of(cell: Mapping) -> Run:
    """Return the table that a student's cell belongs to."""
    steps = (cell["teacher_steps"], cell["student_steps"])
    return Run(cell["scene"], *steps, non_defaults(cell, ("teacher", "student")))


def runs_of(cells: list[dict]) -> dict[Run, list[dict]]:
    """Group cells by run; teachers without students form their own."""
    runs: dict[Run, list[dict]] = {}
    teachers = [cell for cell in cells if not cell["student_steps"]]
    for cell in cells:
        if cell["student_steps"]:
            runs.setdefault(run_of(cell), []).append(cell)
    taught = {key: {teacher_of(cell) for cell in learned} for key, learned in runs.items()}
    for cell in teachers:
        of = teacher_of(cell)
        keys = [key for key in taught if of in taught[key]]
        for key in keys or [Run(of[0], of[1], 0, of[2])]:
            runs.setdefault(key, []).insert(0, cell)
    return dict(sorted(runs.items()))


def tables(cells: list[dict], headings: list[str], row) -> list[str]:
    """Return the paper's tables; `row` makes a line of a row's cells and of those of its base.

    The base is `codebooks`, and `paper` for the ablations of the paper's own model.
    """
    lines = []
    by_row = {
        name: rows for name in ROWS if (rows := [cell for cell in cells if cell["row"] == name])
    }
    for kind, title in TITLES.items():
        names = [name for name in by_row if ROWS[name].table == kind]
        if not names:
            continue
        base = base_of(names[0])
        if kind not in ("main", "paper", "default") and base in by_row:
            names = [base, *names]
        rows = [row(name, by_row[name], by_row.get(base_of(name))) for name in names]
        lines += [f"**{title}**", "", *table(headings, rows), ""]
    return lines


def origin(cells: list[dict]) -> list[str]:
    """Return device, date, and the number of LPIPS photos if it is not all of them."""
    dates = sorted({cell["date"] for cell in cells})
    text = ", ".join(sorted({cell["device"] for cell in cells})) + f"; {dates[0]}"
    text += f" to {dates[-1]}." if len(dates) > 1 else "."
    measured = [cell for cell in cells if cell.get("lpips_vgg") is not None]
    told = [(cell["lpips_photos"], cell["photos"]) for cell in measured if "lpips_photos" in cell]
    for some, whole in sorted({each for each in told if each[0] < each[1]}):
        text += f" LPIPS is of {some} of {whole} held-back photos."
    if len(told) < len(measured):
        text += " Of how many photos LPIPS is, older cells do not say."
    return [text, ""]


def side_by_side(runs: dict[Run, list[dict]]) -> list[str]:
    """Return the rows of several scenes with the same steps, in the paper's order."""
    lines: list[str] = []
    for of in sorted({run[1:] for run in runs}):
        found = {run.scene: cells for run, cells in runs.items() if run[1:] == of}
        rows = []
        for name in ROWS:
            pairs = [
                [[cell for cell in cells if cell["row"] == row] for row in (name, base_of(name))]
                for cells in found.values()
            ]
            worth = [difference(*pair) for pair in pairs]
            if name != base_of(name) and sum(value is not None for value in worth) > 1:
                paper = signed(PAPER_DELTAS.get(name))
                rows.append([f"`{name}`", ROWS[name].about, *map(signed, worth), paper])
        if rows:
            lines += [f"## Against the base, dB, {Run('', *of).title}", ""]
            lines += [*table(["row", "what", *found, "paper, mean of Mip-NeRF 360"], rows), ""]
    return lines


class Found(NamedTuple):
    """A row's figures on one scene against its base, of the longest runs that have both."""

    row: str
    steps: int
    psnr: float
    """dB, mean over the runs."""
    size: float
    """Bytes, as a share of the base's."""


def against(cells: list[dict], scene: str, name: str, base: str) -> Found | None:
    """Return the figures of a row against another one, of the longest runs that have both."""
    pairs = []
    for run, found in runs_of(cells).items():
        if run.scene != scene:
            continue
        of_row, of_base = ([cell for cell in found if cell["row"] == row] for row in (name, base))
        value = difference(of_row, of_base)
        if value is not None:
            sizes = [mean(cell["bytes"] for cell in some) for some in (of_row, of_base)]
            pairs.append((run.student_steps, value, sizes[0] / sizes[1]))
    if not pairs:
        return None
    steps = max(pair[0] for pair in pairs)
    values, ratios = zip(*(pair[1:] for pair in pairs if pair[0] == steps), strict=True)
    return Found(name, steps, mean(values), mean(ratios))


def longest(cells: list[dict], scene: str, rows: Sequence[str]) -> Found | None:
    """Return the figures of the longest runs of a scene; of equal ones, of the first row."""
    each = [against(cells, scene, name, base_of(name)) for name in rows]
    return max((one for one in each if one), key=lambda one: one.steps, default=None)


def steps_told(found: Sequence[Found | None]) -> str:
    """Return the lengths of the runs behind some figures, in student steps."""
    return "; ".join(f"{steps:,}" for steps in sorted({one.steps for one in found if one})) or "-"


def equal_bytes(cells: list[dict]) -> list[str]:
    """Return the table at equal bytes, or that there is none."""
    motion = json.loads(MOTION.read_text())["rows"] if MOTION.exists() else {}
    headings, rows = equal_table(cells, motion)
    return table(headings, rows) if rows else ["No cells of equal bytes have been made yet."]


def verdicts(cells: list[dict]) -> list[str]:
    """Return a table with one line for each claim: the paper's figures, ours, the verdict."""
    rows = []
    for claim in CLAIMS:
        lines = [LINES[key][index] for key, index in claim.lines]
        found = {line.about: [_tested(cells, scene, line) for scene in TESTED] for line in lines}
        told = verdict_of(
            [(line.paper, [one and one.psnr for one in found[line.about]]) for line in lines]
        )
        columns = zip(*found.values(), strict=True) if found else [()] * len(TESTED)
        figures = ["; ".join(signed(one and one.psnr) for one in some) for some in columns]
        blank = ["-" if not text.strip("-; ") else text for text in figures]
        rows.append([told, claim.about, claim.paper, *blank])
    rows.sort(key=lambda row: place(row[0]))
    return table(["verdict", "claim", "paper", *TESTED], rows, words=3)


def _tested(cells: list[dict], scene: str, line: Line) -> Found | None:
    """Return the figures of the line's own rows on a scene, if a run was long enough."""
    found = longest(cells, scene, own_rows(line))
    return found if found is not None and found.steps >= LONG else None


def short_runs(cells: list[dict]) -> list[str]:
    """Return a table of the claims' lines that no long run tests, from the longest runs."""
    rows = []
    for claim in CLAIMS:
        lines = [LINES[key][index] for key, index in claim.lines]
        lines = [line for line in lines if not any(_tested(cells, s, line) for s in TESTED)]
        for line in lines:
            of_scenes = [longest(cells, scene, line.rows) for scene in SMALL]
            names = sorted({one.row for one in of_scenes if one}, key=line.rows.index)
            row = ", ".join(f"`{name}`" for name in names)
            told = [signed(one and one.psnr) for one in of_scenes]
            if names:
                rows.append([line.about, row, signed(line.paper), *told, steps_told(of_scenes)])
    return table(["line", "row", "paper", *SMALL, "steps"], rows)


def paper_table(cells: list[dict], key: str) -> list[str]:
    """Return a table of the paper, line by line, with the same on the small captures."""
    rows = []
    for line in LINES[key]:
        found = [longest(cells, scene, line.rows) for scene in SMALL]
        names = sorted({one.row for one in found if one}, key=line.rows.index)
        ratios = [one.size for one in found if one]
        rows.append(
            [
                line.about,
                ", ".join(f"`{name}`" for name in names or line.rows[:1]),
                signed(line.paper),
                line.more or "-",
                *(signed(one and one.psnr) for one in found),
                f"{100 * (mean(ratios) - 1):+.0f} %" if ratios else "-",
                steps_told(found),
            ]
        )
    headings = ["line", "row here", "paper, dB", "its other figures", *SMALL, "bytes", "steps"]
    lines = table(headings, rows)
    cut = lines[1].split(" | ")
    cut[3] = "---"
    return [lines[0], " | ".join(cut), *lines[2:]]


def departures(cells: list[dict]) -> list[str]:
    """Return a table of the default's departures from the paper, with what each gains."""
    rows = []
    for one in DEPARTURES:
        without = f"default-{one.without}"
        found = [against(cells, scene, one.base, without) for scene in PAIRED]
        ratios = [each.size for each in found if each]
        rows.append(
            [
                one.about,
                ", ".join(f"`student.{setting}`" for setting in one.settings.split(", ")),
                one.why,
                f"`{one.base}` - `{without}`",
                *(signed(each.psnr if each else None) for each in found),
                f"{100 * (mean(ratios) - 1):+.0f} %" if ratios else "-",
                steps_told(found),
            ]
        )
    headings = ["departure", "setting", "why", "rows", *PAIRED, "bytes", "steps"]
    return table(headings, rows, words=4)


def float32_networks(cells: list[dict]) -> list[str]:
    """Return a table of scenes with a network: as their files have it, and in float32."""
    key = "psnr_float32_network"
    rows = [
        [cell["scene"], f"`{cell['row']}`", f"{cell['psnr']:.3f}", f"{cell[key]:.3f}"]
        for cell in cells
        if key in cell and cell["row"] in ("release", "paper")
    ]
    return table(["capture", "row", "float16, dB", "float32, dB"], rows)


def printed_bytes() -> list[str]:
    """Return the table of the paper's printed sizes against two readings of its codebooks."""
    headings = ["entries", "printed, MiB", "eight codebooks (`paper`)", "five codebooks"]
    return table(headings, readings(RECIPES["paper"]().student.quantization.codebooks), words=1)


LONG_ROWS = ("teacher", "ours", "ours-sorted", "paper", "paper-no-order-independence", *RELEASES)


def pairs(cells: list[dict]) -> list[str]:
    """Return the figures of the long runs whose commit is known, a line for each teacher."""
    rows = []
    known = [cell for cell in cells if "commit" in cell and cell["row"] in LONG_ROWS]
    runs = runs_of([cell for cell in known if cell["student_steps"] >= LONG])
    for run, found in runs.items():
        for cell in sorted(found, key=lambda cell: (cell["seed"], LONG_ROWS.index(cell["row"]))):
            rows.append(
                [
                    run.scene,
                    f"`{cell['row']}`",
                    str(cell.get("teacher_seed", cell["seed"])),
                    f"{cell['psnr']:.2f}",
                    f"{cell['ssim']:.4f}",
                    f"{cell['lpips_vgg']:.4f}",
                    f"{cell['bytes'] / 1000:.0f}",
                    f"{cell['gaussians']:,}",
                    f"{cell['student_steps']:,}",
                    f"{cell['seconds']:,}",
                    cell["commit"],
                ]
            )
    headings = ["capture", "row", "teacher", "PSNR", "SSIM", "LPIPS", "kB", "Gaussians"]
    return table([*headings, "steps", "seconds", "commit"], rows)


def sections(cells: list[dict]) -> list[str]:
    """Return the page's sections: rows side by side, then groups, then scenes and lengths."""
    runs = runs_of(cells)
    lines = side_by_side(runs)
    for group, title in GROUPS.items():
        scenes = scenes_of(group)
        of_group = {run: cells for run, cells in runs.items() if run.scene in scenes}
        for of in sorted({run[1:] for run in of_group}):
            found = [cell for run in of_group if run[1:] == of for cell in of_group[run]]
            count = len({cell["scene"] for cell in found})
            lines += [f"## {title}, mean of {count} of {len(scenes)} scenes, {Run('', *of).title}"]
            lines += ["", *origin(found), *tables(found, OF_SEVERAL, mean_row)]
    for run, found in runs.items():
        width, height = found[0]["image_size"]
        lines += [f"## {run.scene}, {width}x{height}, {run.title}", ""]
        lines += [*origin(found), *tables(found, HEADINGS, row_of)]
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench" / "results" / "paper.json")
    parser.add_argument("--tables", type=Path, help="write the page of all rows, and nothing else")
    options = parser.parse_args()
    cells = [
        cell
        for cell in json.loads(options.json.read_text())["cells"].values()
        if cell["row"] in ROWS
    ]
    if options.tables:
        options.tables.write_text(tables_page(cells))
        return
    for page, name, lines in (
        (PAGE, "equal", equal_bytes(cells)),
        (ROOT / "README.md", "equal", [summary(cells)]),
        (PAGE, "verdicts", verdicts(cells)),
        (PAGE, "pairs", pairs(cells)),
        (PAGE, "short", short_runs(cells)),
        (SETTINGS, "departures", departures(cells)),
        (SETTINGS, "bytes", printed_bytes()),
        (SETTINGS, "float32", float32_networks(cells)),
    ):
        page.write_text(filled(page.read_text(), name, "\n".join(lines).strip()))
    print(f"{len(cells)} cells -> {PAGE}, {SETTINGS}")


def tables_page(cells: list[dict]) -> str:
    """Return the text of docs/explanation/paper_tables.md."""
    lines = [TABLES_HEAD]
    for key in LINES:
        lines += [f"## {HEADS[key]}", "", *paper_table(cells, key), ""]
    return "\n".join([*lines, *sections(cells), ""])


if __name__ == "__main__":
    main()
