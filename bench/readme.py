"""Writes the README's figures, between its markers, from the JSON in bench/results.

    python bench/readme.py [--json OUT]

`--json` also writes the tables' cells, for whoever wants to check them.
"""

import argparse
import json
from pathlib import Path

ROOT = Path(__file__).parent.parent
ALIKE = 98  # dB: no two pictures differ by a rounding less
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


def viewer_rows(viewers: dict) -> list[list[str]]:
    """Our viewer beside others: time of a frame, what is shipped, and what a turn costs."""
    head = (
        "viewer | load ms | frame ms, median / least | CPU ms | viewer kB | scene MB "
        "| while turning, dB | of the true picture, dB"
    )
    found = [head.split(" | ")]
    for name, row in viewers.items():
        frame, turn = row["frame_ms"], row["turn"]["moving_settled"]["median"]
        found.append(
            [
                f"{name}, {row['date']}" if "date" in row else name,
                number(row["load_ms"]["median"], 0),
                f"{frame['median']:.0f} / {frame['min']:.0f}",
                number(row["cpu_ms"]["median"], 0),
                number(row["viewer_gzip_bytes"] / 1e3, 0),
                number(row["scene_bytes"] / 1e6, 1),
                "the same" if turn >= ALIKE else number(turn, 1),
                number(row["turn"]["moving_true"]["median"], 1),
            ]
        )
    return found


def loading_rows(loading: dict) -> list[list[str]]:
    """Milliseconds until something and until everything is seen."""
    found = [["renderer", "visit", "first picture ms", "decoded ms", "all drawn ms"]]
    for renderer in ("webgpu", "webgl"):
        for visit in ("first_visit", "later_visit"):
            row = loading[renderer][visit]
            times = [f"{row[key]}" for key in ("first_picture", "decoded", "loaded")]
            found.append([renderer, visit.replace("_", " "), *times])
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="write the tables' cells here")
    options = parser.parse_args()
    captures = json.loads((ROOT / "bench/results/captures.json").read_text())
    kernels = json.loads((ROOT / "bench/results/kernels.json").read_text())
    viewer = json.loads((ROOT / "bench/results/viewer.json").read_text())
    loading = json.loads((ROOT / "bench/results/loading.json").read_text())
    tables = {
        "quality": quality_rows(captures["runs"]),
        "kernels": kernel_rows(kernels["rows"]),
        "viewer": viewer_rows(viewer["viewers"]),
        "loading": loading_rows(loading),
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
            f"`python bench/viewer.py`, {viewer['date']}, {viewer['machine']}, "
            f"{viewer['browser']}, bonsai at {viewer['plan']['size']}: ours draws the student, "
            "all others (and ours sorted) its teacher. Load is from navigation to the first frame "
            "that looks like the settled picture, from a local server; ours finds out meanwhile "
            "how to draw, unless its name says how. The last columns compare frames of a turn "
            f"by {viewer['plan']['turn_degrees_a_frame']} degrees a frame: with the same viewer's "
            "picture from there once it has settled, where orders that come too late show (sums in "
            "halves differ from frame to frame by the order in which they are added up), and with "
            "the kernels' picture of the same file, from which viewers also differ by what they "
            "cull, round, or leave out of the colours. A row with a date was measured then, on "
            "another processor. A software device measures filling and its own "
            f"cost of an instance, and says nothing about phones. Medians of "
            f"{viewer['plan']['rounds']} rounds, turns of the first:",
            table(tables["viewer"]),
            f"`python bench/loading.py`, {loading['date']}, {loading['machine']}, the same "
            f"browser: {loading['gaussians']:,} Gaussians in {loading['file_bytes'] / 1e6:.1f} MB "
            f"({loading['coding']}) "
            "from a local server, from navigation on, in a window that has been open for some "
            "seconds (decoded: from the request on); after its first visit a browser knows how "
            "its device draws fastest. A picture's time ends when its frame is done, which the "
            "processor draws here, too. The Gaussians are a trained scene's, copied and made "
            "smaller until they are so many:",
            table(tables["loading"]),
            "In a page that draws nothing, decoding takes "
            f"{loading['alone']['first']} ms the first time and {loading['alone']['later']} ms "
            "later. The first picture is of dots, one for each of some thousand Gaussians.",
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
