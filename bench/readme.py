"""Writes the README's figures, between its markers, from the JSON in bench/results.

    python bench/readme.py [--json OUT]

`--json` also writes the tables' cells, for whoever wants to check them.
"""

import argparse
import json
from pathlib import Path

ROOT = Path(__file__).parent.parent
BEGIN, END = "<!-- BEGIN:numbers -->", "<!-- END:numbers -->"


def table(rows: list[list[str]]) -> str:
    """Markdown, the first row as its head."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines.insert(1, "|" + "---|" * len(rows[0]))
    return "\n".join(lines)


def number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def quality_rows(runs: dict) -> list[list[str]]:
    """Teacher and student of every capture, on the held-back photos."""
    head = "capture | scene | PSNR dB | SSIM | LPIPS (VGG, [0, 1]) | Gaussians | file MB | minutes"
    rows = [head.split(" | ")]
    for name, run in runs.items():
        size = "x".join(str(side) for side in run["image_size"])
        for who in ("teacher", "student"):
            found = run[who]
            minutes = run["seconds"].get(who, 0) / 60
            rows.append(
                [
                    f"{name}, {size}" if who == "teacher" else "",
                    who,
                    number(found["psnr"], 2),
                    number(found["ssim"], 3),
                    number(found["lpips_vgg"], 3),
                    f"{found['gaussians']:,}",
                    number(found["file_bytes"] / 1e6, 2),
                    number(minutes, 1),
                ]
            )
    return rows


def kernel_rows(rows: list[dict]) -> list[list[str]]:
    """Milliseconds of the CPU kernels beside those of the technology study."""
    head = ["800x533", "Gaussians", "forward ms", "forward + backward ms", "against the study"]
    found = [head]
    for path in ("sortfree", "sorted"):
        for count in sorted({row["gaussians"] for row in rows}):
            both = {r["kind"]: r for r in rows if (r["path"], r["gaussians"]) == (path, count)}
            ratios = [both[kind].get("ratio") for kind in ("forward", "both")]
            found.append(
                [
                    path,
                    f"{count:,}",
                    number(both["forward"]["ours_ms"], 0),
                    number(both["both"]["ours_ms"], 0),
                    " / ".join(number(ratio, 2) for ratio in ratios),
                ]
            )
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="write the tables' cells here")
    options = parser.parse_args()
    captures = json.loads((ROOT / "bench/results/captures.json").read_text())
    kernels = json.loads((ROOT / "bench/results/kernels.json").read_text())
    tables = {
        "quality": quality_rows(captures["runs"]),
        "kernels": kernel_rows(kernels["rows"]),
    }
    text = "\n\n".join(
        [
            BEGIN,
            f"`python bench/captures.py`, {captures['date']}, {captures['machine']}, the CPU "
            "preset (the demo has its own), minutes of training:",
            table(tables["quality"]),
            f"`python bench/kernels.py`, {kernels['date']}, {kernels['machine']} (the synthetic "
            "scene of the study that chose the kernels' technology, and the ratio to its own "
            "kernels in the same run, forward / forward + backward):",
            table(tables["kernels"]),
            "Nothing was measured on a GPU yet: the CUDA kernels are compiled in every test run, "
            "and `bench/gpu/run.sh` awaits the first machine that has one.",
            END,
        ]
    )
    readme = (ROOT / "README.md").read_text()
    before, rest = readme.split(BEGIN)
    (ROOT / "README.md").write_text(before + text + rest.split(END)[1])
    if options.json:
        options.json.write_text(json.dumps(tables, indent=1) + "\n")


if __name__ == "__main__":
    main()
