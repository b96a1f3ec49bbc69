"""Writes the tables and the plot of docs/compression.md from what bench/compression.py measured.

    python bench/compression_report.py [--json bench/results/compression.json]

Needs matplotlib (`pip install 'mobilegs[bench]'`).
"""

import argparse
import json
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "compression.md"
PLOT = ROOT / "docs" / "compression.png"
BEGIN, END = "<!-- BEGIN:tables -->", "<!-- END:tables -->"
PEERS = ("teacher", "spz", "sog", "compressed.ply")
PARTS = {
    "positions": ("positions",),
    "scales": ("scale",),
    "rotations": ("rotation", "rotation-finer"),
    "colour": ("appearance",),
    "opacity, lobes": ("opacity", "lobes"),
    "networks, books, header": ("appearance-decoder", "lobe-decoder", "codebooks", "header"),
}


def table(headings: list[str], rows: list[list[str]]) -> list[str]:
    lines = [headings, ["---"] + ["---:"] * (len(headings) - 1), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def against(cell: dict, base: dict | None, name: str, digits: int) -> str:
    """How far a figure lies from that of what was compressed."""
    if base is None or cell is base or name not in cell:
        return "-"
    return f"{cell[name] - base[name]:+.{digits}f}"


def row_of(name: str, cell: dict, base: dict | None) -> list[str]:
    size, count = cell.get("bytes"), cell["gaussians"]
    return [
        f"`{name}`",
        f"{cell['psnr']:.2f}",
        against(cell, base, "psnr", 2),
        against(cell, base, "lpips_vgg", 4),
        "-" if size is None else f"{size:,}",
        "-" if size is None else f"{size / count:.2f}",
        *(
            "-" if key not in cell else f"{cell[key]:.2f}"
            for key in ("encode_seconds", "decode_seconds")
        ),
    ]


HEADINGS = ["variant", "PSNR", "lost", "LPIPS more", "bytes", "a Gaussian", "encode s", "decode s"]


LAYER_HEADINGS = ["variant", "2 layers", "3 layers", "first of 3, PSNR", "first two", "all"]


def layer_columns(cell: dict) -> list[str]:
    """How much longer the file is, and how far its beginnings look like the photos."""
    layers = cell["layers"]
    longer = [f"{size / cell['bytes'] - 1:+.1%}" for size in layers["bytes"].values()]
    return [*longer, *(f"{part['psnr']:.2f}" for part in layers["beginnings"])]


def sections(cells: dict[str, dict]) -> list[str]:
    """One section a scene: variants, what their bytes are, peers."""
    lines: list[str] = []
    for scene in dict.fromkeys(key.split("/")[0] for key in cells):
        found = {key: cell for key, cell in cells.items() if key.startswith(f"{scene}/")}
        ours = {key.split("/")[2]: cell for key, cell in found.items() if key.count("/") == 2}
        steps = {key.split("/")[1] for key in found if key.count("/") == 2}
        plain = ours.get("plain")
        lines += [f"### {scene}, {', '.join(sorted(steps))} steps", ""]
        rows = [row_of(name, cell, plain) for name, cell in ours.items()]
        lines += [*table(HEADINGS, rows), "", "Bits of a Gaussian:", ""]
        rows = []
        for name, cell in ours.items():
            if "streams" in cell:
                bits = {
                    part: 8 * sum(cell["streams"].get(name, 0) for name in names)
                    for part, names in PARTS.items()
                }
                count = cell["gaussians"]
                rows.append([f"`{name}`", *(f"{value / count:.2f}" for value in bits.values())])
        lines += [*table(["variant", *PARTS], rows), ""]
        rows = [
            [f"`{name}`", *layer_columns(cell)] for name, cell in ours.items() if "layers" in cell
        ]
        if rows:
            lines += ["In layers:", "", *table(LAYER_HEADINGS, rows), ""]
        teacher = found.get(f"{scene}/teacher")
        if teacher:
            rows = [
                row_of(name, found[f"{scene}/{name}"], teacher)
                for name in PEERS
                if f"{scene}/{name}" in found
            ]
            lines += ["The sorted teacher in other formats:", "", *table(HEADINGS, rows), ""]
    return lines


def plot(cells: dict[str, dict]) -> None:
    """What is lost by bytes a Gaussian, one panel a scene."""
    import matplotlib.pyplot as plt

    scenes = list(dict.fromkeys(key.split("/")[0] for key in cells))
    figure, axes = plt.subplots(
        1, len(scenes), figsize=(4.6 * len(scenes), 4), squeeze=False, layout="constrained"
    )
    for axis, scene in zip(axes[0], scenes, strict=True):
        found = {key: cell for key, cell in cells.items() if key.startswith(f"{scene}/")}
        bases = {2: next((c for k, c in found.items() if k.endswith("/plain")), None)}
        bases[1] = found.get(f"{scene}/teacher")
        lines: dict[str, list[tuple[float, float]]] = {}
        for key, cell in found.items():
            base = bases[key.count("/")]
            if base is None or cell is base or "bytes" not in cell:
                continue
            name = key.split("/")[-1]
            kind = "sq" if name.startswith("sq") and name != "sq-fixed" else name
            point = (cell["bytes"] / cell["gaussians"], cell["psnr"] - base["psnr"])
            lines.setdefault(kind, []).append(point)
        for kind, points in lines.items():
            axis.plot(*zip(*sorted(points), strict=True), "o-", label=kind, alpha=0.8)
        axis.axhline(0, color="gray", linewidth=0.8)
        axis.set(title=scene, xlabel="bytes a Gaussian", ylabel="PSNR lost, dB")
        axis.grid(alpha=0.3, which="both")
    axes[0][0].legend(fontsize=8)
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
