"""Write the tables and the plot of the paper's pages from the collected cells.

docs/explanation/paper.md gets one line for each table of the paper, paper_tables.md every row.

    python -m bench.paper.report [--json bench/results/paper.json]

Needs matplotlib (`pip install 'mobilegs[bench]'`).
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import mean
from typing import NamedTuple

from bench.paper.captures import TITLES as GROUPS
from bench.paper.cells import scenes_of
from bench.paper.rows import BASE, ROWS

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/explanation/paper.md"
TABLES = ROOT / "docs/explanation/paper_tables.md"
PLOT = ROOT / "docs/images/paper.png"
FEW = 3  # cells that need no plot
COLUMNS = 3  # panels side by side
SHOWN_DB = 7  # below the best row
SHORT = "10000 + 1200 steps"
SMALL = ("bonsai-400", "horns-250", "lego-200")
TITLES = {
    "main": "Teacher and students",
    "ablation": "What each part is worth",
    "pruning": "Pruning",
    "codebooks": "Codebooks",
    "rivals": "Rivals in the same trainer",
    "fixes": "Errors of the release, put back",
    "paper": "The paper's own model",
}
# PSNR against the whole method in the paper's tables, mean of Mip-NeRF 360 (27.12 dB). Its sorted
# row (+0.14) is another thing than ours, which drops phi and lobes, too.
PAPER_DELTAS = {
    "no-view-dependence": -0.44,
    "no-codes": 0.21,
    "no-depth-term": -0.09,
    "no-scale-term": -0.04,
    "sh-0": -0.08,
    "sh-2": 0.01,
    "sh-3": 0.03,
    "no-pruning": 0.10,
    "by-opacity": -0.28,
    "by-scale": -0.25,
    "vote-0.1": 0.03,
    "vote-0.4": -0.65,
    "vote-0.6": -1.27,
    "codebook-6": -1.60,
    "codebook-8": -0.29,
    "codebook-12": 0.03,
    "sort-free-gs": -0.38,
    "quantized-mini-splatting": -0.10,
    "quantized-3dgs": -0.11,
    "paper-no-view-dependence": -0.44,
    "paper-no-quantization": 0.21,
    "paper-no-depth-term": -0.09,
    "paper-no-scale-term": -0.04,
    "paper-sh-0": -0.08,
    "paper-sh-2": 0.01,
    "paper-sh-3": 0.03,
    "paper-no-pruning": 0.10,
    "paper-by-opacity": -0.28,
    "paper-by-scale": -0.25,
    "paper-vote-0.1": 0.03,
    "paper-vote-0.4": -0.65,
    "paper-vote-0.6": -1.27,
    "paper-codebook-6": -1.60,
    "paper-codebook-8": -0.29,
    "paper-codebook-12": 0.03,
}


def base_of(name: str) -> str:
    """Return the row that a row is compared with."""
    return "paper" if ROWS[name].table == "paper" else BASE


class Claim(NamedTuple):
    """A table or figure of the paper, and the rows that test it."""

    about: str
    paper: str
    """The paper's figure, in dB against its whole method unless stated otherwise."""
    rows: tuple[str, ...] = ()
    verdict: str = "not measured"
    base: str = BASE


NOT_RUN = "not run at full size, nor on a GPU"
CLAIMS = (
    Claim("Mip-NeRF 360, T&T, DB", "27.12, 23.09, 29.93 dB; 4.6, 2.5, 4.6 MB", verdict=NOT_RUN),
    Claim("figures of each scene", "bicycle 24.91 to bonsai 31.25 dB", verdict=NOT_RUN),
    Claim("phone (Snapdragon 8 Gen 3)", "127 frames/s cold, 74 steady; 0.83 W"),
    Claim("time by stage, and with and without sorting", "bicycle 134, 857 frames/s"),
    Claim(
        "without order independence",
        "+0.14",
        ("no-order-independence",),
        "at 1,200 steps; at 5,000 no difference",
    ),
    Claim("without view dependence", "-0.44", ("no-view-dependence",), "yes, larger here"),
    Claim("without vector quantisation", "+0.21", ("no-codes",), "yes"),
    Claim(
        "w without depth term; without scale term",
        "-0.09; -0.04",
        ("no-depth-term", "no-scale-term"),
        "no",
    ),
    Claim(
        "SH of degree 0; 2; 3", "-0.08; +0.01; +0.03", ("sh-0", "sh-2", "sh-3"), "within the noise"
    ),
    Claim("no pruning", "+0.10", ("no-pruning",), "yes, larger here"),
    Claim(
        "votes by opacity only; by scale only",
        "-0.28; -0.25",
        ("by-opacity-once", "by-scale-once"),
        "not opacity; scale larger here",
    ),
    Claim(
        "vote quantile 0.1; 0.4; 0.6",
        "+0.03; -0.65; -1.27",
        ("vote-0.1", "vote-0.4", "vote-0.6"),
        "order yes; 0.6 leaves almost nothing",
    ),
    Claim(
        "votes; MaskGaussian, on Mini-Splatting",
        "-0.03; -0.08",
        ("mini-splatting-votes", "masks"),
        "votes yes; masks lose more here",
        "mini-splatting-on",
    ),
    Claim(
        "codebooks of 2^6; 2^8; 2^12 entries",
        "-1.60; -0.29; +0.03",
        ("codebook-6", "codebook-8", "codebook-12"),
        "order yes, smaller here",
    ),
    Claim(
        "SortFreeGS; GES",
        "-0.38; -0.10 or -0.14",
        ("sort-free-gs", "two-pass"),
        "sign yes; other forms of both",
    ),
    Claim(
        "coded Mini-Splatting; coded 3DGS",
        "-0.10; -0.11",
        ("quantized-mini-splatting", "quantized-3dgs"),
        "no",
    ),
)


class Run(NamedTuple):
    """The properties that the cells of one table share."""

    scene: str
    teacher_steps: int
    student_steps: int
    unusual: str
    """What is not the default: protocol, seed of the teacher, settings."""

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
        over(2, "bytes", 2**-20),
        over(1, "gaussians", 1e-3),
        over(1, "frame_ms"),
        over(1, "seconds", 1 / 60),
    ]


FIGURES = ["PSNR", "against the base", "paper, mean of Mip-NeRF 360", "SSIM", "LPIPS"]
FIGURES += ["MiB", "k Gaussians", "ms per frame", "min"]
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
        if kind not in ("main", "paper") and base in by_row:
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


def claims(cells: list[dict]) -> list[str]:
    """Return a table with one line for each of the paper's: its figures, ours, the verdict."""
    rows = []
    for claim in CLAIMS:
        measured = [
            "; ".join(small_difference(cells, scene, row, claim.base) for row in claim.rows)
            for scene in SMALL
        ]
        names = ", ".join(f"`{row}`" for row in claim.rows) or "-"
        dashes = [text if claim.rows else "-" for text in measured]
        rows.append([claim.about, claim.paper, names, *dashes, claim.verdict])
    lines = table(["paper", "its figures", "row here", *SMALL, "agrees"], rows, words=3)
    lines[1] = f"{lines[1].removesuffix('---: |')}--- |"
    return lines


def small_difference(cells: list[dict], scene: str, row: str, base: str) -> str:
    """Return a row's dB against `base` by the first teacher that has both, after 1,200 steps."""
    runs = {run: found for run, found in runs_of(cells).items() if run.scene == scene}
    for run, found in sorted(runs.items()):
        pair = [[cell for cell in found if cell["row"] == name] for name in (row, base)]
        value = difference(*pair) if run.title.startswith(SHORT) else None
        if value is not None:
            return signed(value)
    return "-"


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


def plot(cells: list[dict]) -> None:
    """Plot bytes against PSNR of every row, one panel per scene and length."""
    import matplotlib.pyplot as plt
    from matplotlib.ticker import LogLocator, NullFormatter

    runs = {key: found for key, found in runs_of(cells).items() if len(found) > FEW}
    columns = min(len(runs), COLUMNS)
    lines = -(-len(runs) // columns)
    figure, axes = plt.subplots(
        lines, columns, figsize=(5 * columns, 3.8 * lines), squeeze=False, layout="constrained"
    )
    looks = {kind: dict(marker=mark) for kind, mark in zip(TITLES, "*osD^v", strict=True)}
    for i, look in enumerate(looks.values()):
        look["color"] = f"C{i}"
    for axis in axes.flat[len(runs) :]:
        axis.remove()
    for axis, (run, every) in zip(axes.flat, runs.items(), strict=False):
        least = max(cell["psnr"] for cell in every) - SHOWN_DB
        found = [cell for cell in every if cell["psnr"] > least]
        left = len(every) - len(found)
        for kind, title in TITLES.items():
            some = [cell for cell in found if ROWS[cell["row"]].table == kind]
            sizes = [cell["bytes"] / 2**20 for cell in some]
            psnrs = [cell["psnr"] for cell in some]
            axis.plot(sizes, psnrs, ls="", label=title, alpha=0.8, **looks[kind])
        below = f" ({left} below {least:.1f})" if left else ""
        axis.set(xlabel="MiB", xscale="log")
        axis.set_title(f"{run.scene}, {run.title}", fontsize=10)
        axis.set_ylabel(f"PSNR, dB{below}")
        axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.xaxis.set_major_formatter(lambda size, _: f"{size:g}")
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.grid(alpha=0.3)
    axes[0][0].legend(fontsize=8)
    figure.savefig(PLOT, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench" / "results" / "paper.json")
    options = parser.parse_args()
    cells = [
        cell
        for cell in json.loads(options.json.read_text())["cells"].values()
        if cell["row"] in ROWS
    ]
    write(PAGE, "claims", claims(cells))
    write(TABLES, "tables", sections(cells))
    plot(cells)
    print(f"{len(cells)} cells -> {PAGE}, {TABLES}, {PLOT}")


def write(page: Path, name: str, lines: list[str]) -> None:
    """Replace the text between a page's markers of that name."""
    begin, end = f"<!-- BEGIN:{name} -->", f"<!-- END:{name} -->"
    head, rest = page.read_text().split(begin)
    text = "\n".join(lines).strip()
    page.write_text(f"{head}{begin}\n\n{text}\n\n{end}{rest.split(end)[1]}")


if __name__ == "__main__":
    main()
