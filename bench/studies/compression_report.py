"""Write the tables and the plot of docs/explanation/compression.md from bench/results.

    python -m bench.studies.compression_report [--json bench/results/compression.json]

Needs matplotlib (`pip install 'mobilegs[bench]'`).
"""

import argparse
import json
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/explanation/compression.md"
PLOT = ROOT / "docs/images/compression.png"
BEGIN, END = "<!-- BEGIN:tables -->", "<!-- END:tables -->"
PEERS = ("teacher", "spz", "sog", "compressed.ply")
PARTS = {
    "positions": ("positions",),
    "scales": ("scale",),
    "rotations": ("rotation", "rotation-finer"),
    "colour": ("appearance",),
    "opacity, lobes": ("opacity", "lobes"),
    "networks, books, header": (
        "color-matrices",
        "appearance-decoder",
        "lobe-decoder",
        "codebooks",
        "header",
    ),
}


def table(headings: list[str], rows: list[list[str]]) -> list[str]:
    lines = [headings, ["---"] + ["---:"] * (len(headings) - 1), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def against(cell: dict, base: dict | None, name: str, digits: int) -> str:
    """Return a figure's difference to the unquantised one."""
    if base is None or cell is base or name not in cell or name not in base:
        return "-"
    return f"{cell[name] - base[name]:+.{digits}f}"


def row_of(name: str, cell: dict, base: dict | None) -> list[str]:
    size, count = cell.get("bytes"), cell["gaussians"]
    return [
        f"`{name}`",
        f"{cell['psnr']:.2f}" if "psnr" in cell else "-",
        against(cell, base, "psnr", 2),
        against(cell, base, "lpips_vgg", 4),
        "-" if size is None else f"{size:,}",
        "-" if size is None else f"{size / count:.2f}",
        *(
            "-" if key not in cell else f"{cell[key]:.2f}"
            for key in ("encode_seconds", "decode_seconds")
        ),
    ]


HEADINGS = [
    "variant",
    "PSNR",
    "lost",
    "LPIPS lost",
    "bytes",
    "per Gaussian",
    "encode s",
    "decode s",
]


LAYER_HEADINGS = ["variant", "2 levels", "3 levels", "first of 3, PSNR", "first two", "all"]


def layer_columns(cell: dict) -> list[str]:
    """Return the growth of the file and the PSNR of its first levels."""
    layers = cell["layers"]
    longer = [f"{size / cell['bytes'] - 1:+.1%}" for size in layers["bytes"].values()]
    return [*longer, *(f"{part['psnr']:.2f}" for part in layers["beginnings"])]


def runs_of(cells: dict[str, dict]) -> dict[tuple[str, int], dict[str, dict]]:
    """Return our variants by scene and steps."""
    runs: dict[tuple[str, int], dict[str, dict]] = {}
    for key, cell in cells.items():
        if key.count("/") == 2:
            scene, steps, name = key.split("/")
            runs.setdefault((scene, int(steps)), {})[name] = cell
    return dict(sorted(runs.items()))


def sections(cells: dict[str, dict]) -> list[str]:
    """Return one section per scene and length: variants, their bytes, other formats."""
    lines: list[str] = []
    for (scene, steps), ours in runs_of(cells).items():
        plain = ours.get("plain")
        lines += [f"## {scene}, {steps} steps", ""]
        rows = [row_of(name, cell, plain) for name, cell in ours.items()]
        lines += [*table(HEADINGS, rows), ""]
        rows = []
        for name, cell in ours.items():
            if "streams" in cell:
                bits = {
                    part: 8 * sum(cell["streams"].get(name, 0) for name in names)
                    for part, names in PARTS.items()
                }
                count = cell["gaussians"]
                rows.append([f"`{name}`", *(f"{value / count:.2f}" for value in bits.values())])
        if rows:
            lines += ["Bits per Gaussian:", "", *table(["variant", *PARTS], rows), ""]
        rows = [
            [f"`{name}`", *layer_columns(cell)] for name, cell in ours.items() if "layers" in cell
        ]
        if rows:
            lines += ["With LOD levels:", "", *table(LAYER_HEADINGS, rows), ""]
    for scene in dict.fromkeys(key.split("/")[0] for key in cells):
        teacher = cells.get(f"{scene}/teacher")
        if teacher:
            found = {name: cells.get(f"{scene}/{name}") for name in ("teacher", *PEERS)}
            rows = [row_of(name, cell, teacher) for name, cell in found.items() if cell]
            lines += [f"## {scene}: the sorted teacher in other formats", ""]
            lines += [*table(HEADINGS, rows), ""]
    return lines


def kinds_of(variant: str) -> list[str]:
    """Return the lines of the plot that a variant is a point of."""
    if variant == "sq-0.001":
        return ["sq, by lambda", "sq, by quality"]
    if variant.startswith("sq-quality-"):
        return ["sq, by quality"]
    if variant.startswith("sq-early-"):
        return ["sq, early rate term"]
    if variant in ("sq-fixed", "nvq-canonical"):
        return [variant]
    return ["nvq" if variant.startswith("nvq") else "sq, by lambda"]


def plot(cells: dict[str, dict]) -> None:
    """Plot the loss in dB against bytes per Gaussian, one panel per scene and length."""
    import matplotlib.pyplot as plt

    runs = {key: ours for key, ours in runs_of(cells).items() if "plain" in ours and len(ours) > 1}
    figure, axes = plt.subplots(
        1, len(runs), figsize=(4.2 * len(runs), 4), squeeze=False, layout="constrained", sharey=True
    )
    colors: dict[str, str] = {}
    for axis, ((scene, steps), ours) in zip(axes[0], runs.items(), strict=True):
        lines: dict[str, list[tuple[float, float]]] = {}
        for name, cell in ours.items():
            if "bytes" in cell:
                lost = cell["psnr"] - ours["plain"]["psnr"]
                for kind in kinds_of(name):
                    lines.setdefault(kind, []).append((cell["bytes"] / cell["gaussians"], lost))
        for kind, points in lines.items():
            color = colors.setdefault(kind, f"C{len(colors)}")
            x, y = zip(*sorted(points), strict=True)
            axis.plot(x, y, "o-", color=color, label=kind, alpha=0.8)
        axis.axhline(0, color="gray", linewidth=0.8)
        axis.set(title=f"{scene}, {steps} steps", xlabel="bytes per Gaussian")
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize=8)
    axes[0][0].set_ylabel("PSNR lost, dB")
    figure.savefig(PLOT, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/compression.json")
    options = parser.parse_args()
    result = json.loads(options.json.read_text())
    text = PAGE.read_text()
    start, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    when = f"{result['machine']}; {result['date']}."
    lines = ["", "", when, "", *sections(result["cells"])]
    PAGE.write_text(text[:start] + "\n".join(lines) + "\n" + text[end:])
    plot(result["cells"])


if __name__ == "__main__":
    main()
