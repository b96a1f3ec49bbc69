"""Write the table and the plot of docs/explanation/view_dependence.md.

    python -m bench.studies.view_dependence_report [--json bench/results/view_dependence.json]

Needs matplotlib (`pip install 'mobilegs[bench]'`).
"""

import argparse
import json
from pathlib import Path
from statistics import mean

from bench.pages import between

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/explanation/view_dependence.md"
PLOT = ROOT / "docs/images/view_dependence.png"
# of a run, that a student has each form in the presets
SHARES = {"explicit": 5 / 30, "networks": 0.7 - 5 / 30, "codes": 0.3}
CAPTURES = ("bonsai", "horns", "lego", "sample")


def by_variant(cells: dict, capture: str, steps: int) -> dict[str, list[dict]]:
    """Return the cells of a capture after `steps` steps, by variant."""
    found: dict[str, list[dict]] = {}
    for key, cell in cells.items():
        parts = key.split("/")
        if parts[:2] == [capture, str(steps)]:
            found.setdefault(parts[2], []).append(cell)
    return found


def lengths(cells: dict) -> list[int]:
    """Return the numbers of steps that cells have, the usual one first."""
    found = [cell["steps"] for cell in cells.values() if "steps" in cell]
    return sorted(set(found), key=lambda steps: -found.count(steps))


def row_of(variant: str, cells: list[dict], network: list[dict] | None) -> list[str]:
    def average(field: str) -> float | None:
        values = [cell.get(field) for cell in cells]
        return None if None in values else mean(values)

    def number(value: float | None, digits: int) -> str:
        return "-" if value is None else f"{value:.{digits}f}"

    psnrs = [cell["psnr"] for cell in cells]
    spread = f" ± {(max(psnrs) - min(psnrs)) / 2:.2f}" if len(psnrs) > 1 else ""
    bytes_each = None
    if "file_bytes" in cells[0]:
        bytes_each = mean(cell["file_bytes"] / cell["gaussians"] for cell in cells)
    against = None
    if network and all("psnr" in cell for cell in network):
        against = mean(psnrs) - mean(cell["psnr"] for cell in network)
    return [
        variant,
        number(mean(psnrs), 2) + spread,
        "-" if against is None else f"{against:+.2f}",
        number(average("ssim"), 4),
        number(average("lpips_vgg"), 3),
        number(bytes_each, 2),
        number(1e3 * mean(cell["cpu_seconds_per_step"] for cell in cells), 0),
        f"{cells[0]['multiply_adds']:,}" if "multiply_adds" in cells[0] else "-",
        str(len(cells)),
    ]


def table(found: dict[str, list[dict]]) -> str:
    head = (
        "variant | PSNR dB | against network | SSIM | LPIPS (VGG) | bytes per Gaussian | "
        "CPU ms per step | multiply-adds | seeds"
    ).split(" | ")
    rows = [row_of(name, some, found.get("network")) for name, some in found.items()]
    rows.sort(key=lambda row: -float(row[1].split()[0]))
    lines = ["| " + " | ".join(row) + " |" for row in [head, *rows]]
    lines.insert(1, "|" + "---|" * len(head))
    return "\n".join(lines)


def where_table(found: dict) -> str:
    """Return the student's squared error relative to the sorted scene's, by quarters."""
    lines = ["| pixels by | first quarter | second | third | last |", "|---|---|---|---|---|"]
    for name, quarters in found.items():
        if name == "mse":
            continue
        cells = [
            f"{q['student_mse'] / q['sorted_mse']:.2f} ({q['from']:.2f} to {q['to']:.2f})"
            for q in quarters
        ]
        lines.append("| " + " | ".join([name, *cells]) + " |")
    return "\n".join(lines)


def plot(cells: dict, steps: int, path: Path) -> None:
    """Plot quality against bytes, one panel per capture; sorted scenes are lines."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, len(CAPTURES), figsize=(16, 4.6), layout="constrained")
    for axis, capture in zip(axes, CAPTURES, strict=True):
        for variant, some in by_variant(cells, capture, steps).items():
            quality = mean(cell["psnr"] for cell in some)
            if variant.startswith("sorted"):
                style = "--" if variant.endswith("1") else ":"
                axis.axhline(quality, color="gray", linestyle=style, linewidth=1)
                axis.annotate(
                    variant, (0.02, quality), xycoords=("axes fraction", "data"), fontsize=7
                )
                continue
            size = mean(cell["file_bytes"] / cell["gaussians"] for cell in some)
            color = COLORS.get(variant.split("-")[0], "black")
            axis.scatter(size, quality, s=70 if variant == "chosen" else 22, color=color)
            axis.annotate(
                variant, (size, quality), fontsize=6, xytext=(3, 3), textcoords="offset points"
            )
        axis.set_title(capture)
        axis.set_xlabel("bytes per Gaussian, whole file")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("held-back PSNR, dB")
    figure.savefig(path, dpi=110)


COLORS = {
    "network": "tab:red",
    "fitted": "tab:orange",
    "decoded": "tab:purple",
    "latent": "tab:green",
    "projected": "tab:blue",
    "klt": "tab:cyan",
    "free": "tab:brown",
    "chosen": "tab:pink",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = ROOT / "bench" / "results" / "view_dependence.json"
    parser.add_argument("--json", type=Path, default=default)
    where = ROOT / "bench" / "results" / "where_loss_sits.json"
    parser.add_argument("--where", type=Path, default=where)
    options = parser.parse_args()
    result = json.loads(options.json.read_text())
    cells = result["cells"]
    sections = []
    for steps in lengths(cells):
        for capture in CAPTURES:
            found = by_variant(cells, capture, steps)
            if not found:
                continue
            teacher = cells[f"{capture}/teacher"]
            width, height = teacher["image_size"]
            sections.append(
                f"### {capture}, {width}x{height}, {steps:,} steps\n\nTeacher: "
                f"{teacher['gaussians']:,} Gaussians, {teacher['psnr']:.2f} dB.\n\n" + table(found)
            )
    if result["speed"]:
        lines = ["| form | variant | ms per step | of network's |", "|---|---|---|---|"]
        speed = result["speed"]
        for key, row in speed.items():
            form, _, name = key.partition("/")
            lines.append(f"| {form} | {name} | {row['ms']} | {row['of_network']} |")

        def whole(name: str) -> float:
            return sum(share * speed[f"{form}/{name}"]["ms"] for form, share in SHARES.items())

        for name in [key.partition("/")[2] for key in speed if key.startswith("explicit/")]:
            of_network = whole(name) / whole("network")
            lines.append(f"| mean of the run | {name} | {whole(name):.1f} | {of_network:.3f} |")
        sections.append("### Time of a training step, bonsai 400x267\n\n" + "\n".join(lines))
    made = "\n\n".join(sections)
    note = f"{result['date']}, {result['machine']}, torch {result['torch']}."
    text = between(PAGE.read_text(), "study", f"{note}\n\n{made}")
    if options.where.exists():
        text = between(text, "where", where_table(json.loads(options.where.read_text())))
    PAGE.write_text(text)
    plot(cells, lengths(cells)[0], PLOT)


if __name__ == "__main__":
    main()
