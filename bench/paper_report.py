"""Writes the tables and the plot of docs/paper.md from the cells that bench/paper.py collected.

    python bench/paper_report.py [--json bench/results/paper.json]

Needs matplotlib (`pip install 'mobilegs[bench]'`).
"""

import argparse
import json
from pathlib import Path
from statistics import mean

from paper_rows import ROWS

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "paper.md"
PLOT = ROOT / "docs" / "paper.png"
FEW = 3  # cells that need no plot
BEGIN, END = "<!-- BEGIN:tables -->", "<!-- END:tables -->"
TITLES = {
    "main": "Teacher and students",
    "ablation": "What each part is worth",
    "pruning": "Pruning",
    "codebooks": "Codebooks",
    "rivals": "Rivals in the same trainer",
    "fixes": "Errors of the release, put back",
}
# PSNR against the whole method in the paper's tables, mean of Mip-NeRF 360 (27.12 dB)
PAPER_DELTAS = {
    "no-order-independence": 0.14,
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
}


def number(values: list[float | None], digits: int) -> str:
    """The mean, or a dash where a value is missing."""
    if not values or None in values:
        return "-"
    return f"{mean(values):.{digits}f}"


def spread(values: list[float]) -> str:
    """Half the distance between the highest and the lowest."""
    return f" ± {(max(values) - min(values)) / 2:.2f}" if len(values) > 1 else ""


def row_of(name: str, cells: list[dict], base: list[dict] | None) -> list[str]:
    psnrs = [cell["psnr"] for cell in cells]
    delta = "-"
    if base and cells is not base:
        delta = f"{mean(psnrs) - mean(cell['psnr'] for cell in base):+.2f}"
    of_paper = PAPER_DELTAS.get(name)
    return [
        f"`{name}`",
        ROWS[name].about,
        number(psnrs, 2) + spread(psnrs),
        delta,
        "-" if of_paper is None else f"{of_paper:+.2f}",
        number([cell["ssim"] for cell in cells], 4),
        number([cell.get("lpips_vgg") for cell in cells], 3),
        number([cell["bytes"] / 2**20 for cell in cells], 2),
        number([cell["gaussians"] / 1000 for cell in cells], 1),
        number([cell["frame_ms"] for cell in cells], 1),
        number([cell["seconds"] / 60 for cell in cells], 1),
    ]


HEADINGS = ["row", "what", "PSNR", "against `ours`", "in the paper", "SSIM", "LPIPS"]
HEADINGS += ["MiB", "k Gaussians", "ms a frame", "min"]


def table(rows: list[list[str]]) -> list[str]:
    lines = [HEADINGS, ["---"] * 2 + ["---:"] * (len(HEADINGS) - 2), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def runs_of(cells: list[dict]) -> dict[tuple[str, int, int], list[dict]]:
    """Cells by scene, steps of the teacher, and of the student, each with its teachers."""
    runs: dict[tuple[str, int, int], list[dict]] = {}
    teachers: dict[tuple[str, int], list[dict]] = {}
    for cell in cells:
        of = (cell["scene"], cell["teacher_steps"])
        if cell["student_steps"]:
            runs.setdefault((*of, cell["student_steps"]), []).append(cell)
        else:
            teachers.setdefault(of, []).append(cell)
    for of, found in teachers.items():
        keys = [key for key in runs if key[:2] == of] or [(*of, 0)]
        for key in keys:
            runs[key] = [*found, *runs.get(key, [])]
    return dict(sorted(runs.items()))


def sections(cells: list[dict]) -> list[str]:
    """One section per scene and length, one table for each of the paper's."""
    lines: list[str] = []
    for (scene, steps, students), found in runs_of(cells).items():
        width, height = found[0]["image_size"]
        devices = ", ".join(sorted({cell["device"] for cell in found}))
        dates = sorted({cell["date"] for cell in found})
        lines += [
            f"### {scene}, {width}x{height}, {steps} + {students} steps",
            "",
            f"{devices}; {dates[0]}" + (f" to {dates[-1]}" if len(dates) > 1 else "") + ".",
            "",
        ]
        by_row = {
            name: rows for name in ROWS if (rows := [cell for cell in found if cell["row"] == name])
        }
        base = by_row.get("ours")
        for kind, title in TITLES.items():
            names = [name for name in by_row if ROWS[name].table == kind]
            if not names:
                continue
            if kind != "main" and base:
                names = ["ours", *names]
            rows = [row_of(name, by_row[name], base) for name in names]
            lines += [f"**{title}**", "", *table(rows), ""]
    return lines


def plot(cells: list[dict]) -> None:
    """Bytes and PSNR of every row, one panel a scene and length, if there are some."""
    import matplotlib.pyplot as plt
    from matplotlib.ticker import LogLocator, NullFormatter

    runs = {key: found for key, found in runs_of(cells).items() if len(found) > FEW}
    figure, axes = plt.subplots(
        1, len(runs), figsize=(5 * len(runs), 4.2), squeeze=False, layout="constrained"
    )
    looks = {kind: dict(marker=mark) for kind, mark in zip(TITLES, "*osD^v", strict=True)}
    for i, look in enumerate(looks.values()):
        look["color"] = f"C{i}"
    for axis, ((scene, steps, students), found) in zip(axes[0], runs.items(), strict=True):
        for kind, title in TITLES.items():
            some = [cell for cell in found if ROWS[cell["row"]].table == kind]
            sizes = [cell["bytes"] / 2**20 for cell in some]
            psnrs = [cell["psnr"] for cell in some]
            axis.plot(sizes, psnrs, ls="", label=title, alpha=0.8, **looks[kind])
        title = f"{scene}, {steps} + {students} steps"
        axis.set(title=title, xlabel="MiB", ylabel="PSNR, dB", xscale="log")
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
    page = PAGE.read_text()
    head, rest = page.split(BEGIN)
    _, tail = rest.split(END)
    PAGE.write_text(head + BEGIN + "\n\n" + "\n".join(sections(cells)) + END + tail)
    plot(cells)
    print(f"{len(cells)} cells -> {PAGE}, {PLOT}")


if __name__ == "__main__":
    main()
