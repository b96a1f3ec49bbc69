"""Write the figures of README.md and of pages in docs/explanation from bench/results.

    python -m bench.readme

Each table stands between its own pair of markers, `<!-- BEGIN:name -->` and `<!-- END:name -->`.
"""

import json
import math
from typing import Any

from bench.record import DOCS, RESULTS, ROOT, filled, origin_of, table

ALIKE = 98  # dB: pictures that differ by a rounding error are below this
# of bench/results/paper.json; the teacher takes as many steps as both parts of a student's training
TEACHER = "bonsai-400/20000+0/default-teacher/0"
SORTED = "bonsai-400/10000+10000/default-sorted/0/3f2ce7f5"
STUDENT = "bonsai-400/10000+10000/default/0/3f2ce7f5"
VIEWER = "ours, WebGPU, 800x533"  # of bench/results/viewer.json

Rows = list[list[str]]


def number(value: float | None, digits: int) -> str:
    return "-" if value is None or math.isnan(value) else f"{value:,.{digits}f}"


def size_of(sides: list[int]) -> str:
    return "x".join(map(str, sides))


def quality_rows(runs: dict[str, Any]) -> Rows:
    """Return the teacher's and the student's figures of every capture, on held-back photos."""
    rows = []
    for name, run in runs.items():
        for who in ("teacher", "student"):
            found = run[who]
            rows.append(
                [
                    f"{name}, {size_of(run['image_size'])}" if who == "teacher" else "",
                    who,
                    number(found["psnr"], 2),
                    number(found["ssim"], 3),
                    number(found["lpips_vgg"], 3),
                    f"{found['gaussians']:,}",
                    number(found["file_bytes"] / 1e6, 2),
                    number(run["seconds"].get(who, 0) / 60, 1),
                ]
            )
    return rows


def compressed_rows(runs: dict[str, Any]) -> Rows:
    """Return what each file of a compressed scene has of the given scene."""
    return [
        [
            f"{name}, {number(run['teacher']['file_bytes'] / 1e6, 1)} MB" if file == "mgs" else "",
            f"`.{file}`",
            number(found["file_bytes"] / 1e6, 2),
            number(found["psnr"], 2),
            number(found.get("worst_psnr"), 2),
            number(found["ssim"], 4),
            number(found["neutral_rms"], 2),
        ]
        for name, run in runs.items()
        for file, found in (("mgs", run["student"]), *run["formats"].items())
    ]


def minutes_rows(cells: dict[str, Any]) -> Rows:
    """Return time, size and quality of every run of `--minutes`."""
    return [
        [
            name.split("-")[0],
            f"{found['minutes']}",
            f"{found['taken']:.1f}",
            size_of(found["trained_at"]),
            f"{found['steps']['teacher']:,} + {found['steps']['student']:,}",
            f"{found['gaussians']:,}",
            number(found["bytes"] / 1e6, 2),
            number(found["psnr"], 2),
            number(found["ssim"], 3),
            number(found["lpips_vgg"], 3),
        ]
        for name, found in sorted(
            cells.items(), key=lambda cell: (cell[0].split("-")[0], cell[1]["minutes"])
        )
    ]


def size_rows(cells: dict[str, Any]) -> Rows:
    """Return the PSNR of every scene by size, beside that of an enlargement."""
    order = ("1/4", "1/2", "1", "2", "bicubic")
    return [[name, *(f"{found[size]:.2f}" for size in order)] for name, found in cells.items()]


def memory_rows(cells: dict[str, Any]) -> Rows:
    """Return peak and planned memory by size and number of Gaussians."""
    return [
        [
            size_of(cell["size"]),
            f"{cell['splats']:,}",
            *(number(1e-9 * cell[key], 2) for key in ("peak", "needed")),
        ]
        for cell in sorted(cells.values(), key=lambda cell: (cell["size"], cell["splats"]))
    ]


def step_rows(rows: dict[str, Any]) -> Rows:
    """Return times and counts of training steps on a CPU."""
    return [
        [
            name.replace(" ", " | "),
            f"{row['gaussians']:,}",
            number(row["ms"], 1),
            number(row["ms"] / row["reference_ms"], 2) if "reference_ms" in row else "-",
            *(number(row[key], 0) for key in ("operations", "native", "megabytes")),
        ]
        for name, row in rows.items()
    ]


def neighbor_rows(rows: dict[str, Any]) -> Rows:
    """Return the shares of a fair speed that steps beside busy programs have."""
    return [
        [name.replace(" ", " | "), *(number(row[f"beside_{count}"], 2) for count in (6, 8))]
        for name, row in rows.items()
        if "beside_6" in row
    ]


def kernel_rows(rows: dict[str, Any]) -> Rows:
    """Return the CPU kernels' milliseconds."""
    return [
        [path, f"{count:,}"]
        + [number(rows[f"{count} {path} {kind}"]["ours_ms"], 0) for kind in ("forward", "both")]
        for path in ("sortfree", "sorted")
        for count in sorted({row["gaussians"] for row in rows.values()})
    ]


def gpu_rows(rows: dict[str, Any]) -> Rows:
    """Return the CUDA kernels' milliseconds beside gsplat's, by number of Gaussians and size."""
    found = []
    for count, size in dict.fromkeys(tuple(name.split()[:2]) for name in rows):
        times = [
            rows[f"{count} {size} {path} {kind}"][key]
            for path, key in (("sorted", "ms"), ("sorted", "gsplat_ms"), ("sortfree", "ms"))
            for kind in ("forward", "both")
        ]
        found.append([f"{int(count):,}", size, *(number(ms, 2) for ms in times)])
    return found


def gpu_frame_rows(rows: dict[str, Any]) -> Rows:
    """Return the milliseconds of whole frames of trained scenes beside gsplat's."""
    return [
        [
            f"{name}, {row['blend']}",
            f"{row['gaussians']:,}",
            *(number(row[key], 2) for key in ("ms", "gsplat_ms")),
        ]
        for name, row in rows.items()
    ]


def gpu_step_rows(rows: dict[str, Any]) -> Rows:
    """Return where the time of a training step goes."""
    keys = {
        "gaussians": ("Gaussians", 0),
        "ms": ("one step, ms", 1),
        "rendering_gpu_ms": ("of them, rendering forward and backward, ms", 2),
        "kernel_launches": ("kernels started in a step", 0),
    }
    return [
        [title, *(number(row[key], digits) for row in rows.values())]
        for key, (title, digits) in keys.items()
    ]


def rms(decibels: float) -> float:
    """Return the error of a picture, of 255."""
    return 255 * 10 ** (-decibels / 20)


def viewer_rows(viewers: dict[str, Any]) -> Rows:
    """Return the time per frame, the bytes, the memory and the errors in a turn of every viewer."""
    found = []
    for name, row in viewers.items():
        if ", float" in name or "full size" in name or "turn" not in row:
            continue
        frame, turn = row["frame_ms"], row["turn"]["moving_settled"]["median"]
        settled = "noise" if "stochastic" in name else "equal" if turn >= ALIKE else number(turn, 1)
        found.append(
            [
                name.rpartition(", ")[0],
                f"{row['load_ms']['median']:.0f}",
                f"{frame['median']:.0f} / {frame['min']:.0f}",
                f"{row['cpu_ms']['median']:.0f}",
                number((row["viewer_gzip_bytes"] or math.nan) / 1e3, 0),
                number(row["scene_bytes"] / 1e6, 1),
                " + ".join(number(value, 0) for value in row["memory_mb"]),
                settled,
                *(number(rms(row[turn]["moving_true"]["median"]), 1) for turn in ("turn", "timed")),
            ]
        )
    return found


def screen_rows(viewers: dict[str, Any]) -> Rows:
    """Return the time of a frame of every viewer at both sizes of the screen."""
    found = []
    names = [name.rpartition(", ")[0] for name in viewers if ", float" not in name]
    for name in dict.fromkeys(names):
        rows = [viewers.get(f"{name}, {size}") for size in ("800x533", "1600x1066")]
        times = ["-" if row is None else f"{row['frame_ms']['median']:.0f}" for row in rows]
        counts = [number(sum(row["fragments"]), 1) for row in rows if row and "fragments" in row]
        found.append([name, *times, " / ".join(counts) or "-"])
    return found


def first_picture_rows(scenes: dict[str, Any]) -> Rows:
    """Return when first visits show something, by scene and network."""
    found = []
    for name, scene in scenes.items():
        size = [f"{scene['file_bytes'] / 1e6:.2f}", f"{scene['page_bytes'] / 1e3:.0f}"]
        for network, row in scene.items():
            if isinstance(row, dict):
                times = [f"{row[key]:,}" for key in ("first_paint", "meaningful", "loaded")]
                found.append([name, *size, network, *times, str(row["blank_after"])])
    return found


def format_rows(cells: dict[str, Any]) -> Rows:
    """Return bytes and quality of a teacher, of other formats of it, and of its student."""
    found = []
    for name, cell in cells.items():
        teacher = cells[f"{name.partition('/')[0]}/teacher"]
        lost = [
            f"{cell[key] - teacher[key]:+.{digits}f}"
            if key in teacher and cell is not teacher
            else "-"
            for key, digits in (("psnr", 2), ("lpips_vgg", 4))
        ]
        size = [f"{cell['bytes']:,}", f"{cell['bytes'] / cell['gaussians']:.2f}"]
        times = [number(cell.get(f"{way}_seconds"), 2) for way in ("encode", "decode")]
        found.append([name.replace("/", ", "), number(cell.get("psnr"), 2), *lost, *size, *times])
    return found


def comparison_rows(paper: dict[str, Any], formats: dict[str, Any], viewers: dict) -> Rows:
    """Return size, quality and frame times of scenes of one capture that took equally many steps.

    Raises ValueError if the results are not of the same files.
    """
    teacher, student, ours = paper[TEACHER], paper[STUDENT], viewers[VIEWER]
    others = {
        name: row
        for name, row in viewers.items()
        if not name.startswith("ours") and row["scene_bytes"] == teacher["bytes"]
    }
    if (
        formats["bonsai/teacher"]["bytes"] != teacher["bytes"]
        or ours["scene_bytes"] != student["bytes"]
        or student["teacher_crc"] != paper[SORTED]["teacher_crc"]
        or not others
    ):
        raise ValueError("the results are not of the same scenes")
    best = min(others, key=lambda name: others[name]["frame_ms"]["median"])
    fastest = f"{others[best]['frame_ms']['median']:.0f} ({best.rpartition(', ')[0]})"
    kernels = f"{teacher['frame_ms']:.1f}"
    rows = []
    for kind, cell, blended, ms, browser in (
        ("`.ply`, 3DGS", teacher, "sorted", kernels, fastest),
        ("`.sog` of it", formats["bonsai/sog by mobilegs"], "sorted", kernels, fastest),
        ("`.spz` of it", formats["bonsai/spz"], "sorted", kernels, fastest),
        ("`.mgs`, `blend=sorted`", paper[SORTED], "sorted", None, "-"),
        ("**`.mgs`**", student, "in any order", None, f"{ours['frame_ms']['median']:.0f} (ours)"),
    ):
        size, psnr = f"{cell['bytes'] / 1e6:.2f}", f"{cell['psnr']:.2f}"
        rows.append([kind, blended, size, psnr, ms or f"{cell['frame_ms']:.1f}", browser])
    return rows


def comparison(results: dict[str, Any]) -> str:
    """Return README's table, below the capture and the machine that it is of."""
    paper, viewer, gpu = results["paper"]["cells"], results["viewer"], results["gpu_h200"]
    student, frames = paper[STUDENT], results["gpu_h200"]["frames"]
    about = (
        f"Bonsai, {student['photos']} held-back photos of {size_of(student['image_size'])}. Each "
        f"scene took {student['teacher_steps'] + student['student_steps']:,} steps; those of a "
        f"`.mgs` are {student['teacher_steps']:,} of the same teacher and "
        f"{student['student_steps']:,} of the student. Times are of two cores without a GPU: the "
        f"kernels at the photos' size, and a browser at {VIEWER.rpartition(', ')[2]} "
        f"({viewer['rows'][VIEWER]['browser']}), where the `.ply` is drawn by the fastest other "
        f"viewer measured."
    )
    head = "file | blended | MB | PSNR dB | ms per frame, kernels | ms per frame, browser"
    rows = comparison_rows(paper, results["compression"]["rows"], viewer["rows"])
    on_gpu = "; ".join(
        f"{name}, {row['gaussians']:,} Gaussians, {row['blend']}: {row['ms']:.2f} ms"
        for name, row in frames["rows"].items()
    )
    return (
        f"{about}\n\n{table(head, rows)}\n\nOn a GPU ({gpu['device']}, "
        f"{size_of(frames['image_size'])}, another training): {on_gpu}; gsplat takes "
        f"{frames['rows']['teacher']['gsplat_ms']:.2f} ms for that teacher."
    )


def blocks(results: dict[str, Any]) -> dict[str, str]:
    """Return the tables of the pages by name, each below the command that made it."""

    def block(name: str, module: str, rows_of: Any, head: str) -> str:
        rows = results[name]["rows"]
        return f"`python -m bench.{module}`, {origin_of(rows)}:\n\n{table(head, rows_of(rows))}"

    captures = results.pop("captures")["rows"]
    for name, wanted in (("trained", False), ("compressed", True)):  # formats: of given scenes
        rows = {row: run for row, run in captures.items() if ("formats" in run) == wanted}
        results[name] = {"rows": rows}

    def gpu(part: dict[str, Any], module: str, about: str, rows_of: Any, head: str) -> str:
        origin = f"`python -m {module}`, {part['date']}, {part['device']}"
        return f"{origin}, {about}:\n\n{table(head, rows_of(part['rows']))}"

    h200, steps = results["gpu_h200"], results["gpu_h100"]["steps"]
    at = f"at {h200['commit']}"
    both = "forward | {0}, forward + backward"
    return {
        "quality": block(
            "trained",
            "captures",
            quality_rows,
            "capture | scene | PSNR dB | SSIM | LPIPS | Gaussians | file MB | minutes",
        ),
        "compressed": block(
            "compressed",
            "captures",
            compressed_rows,
            "scene | file | MB | PSNR dB | worst view | SSIM | whites and greys, of 255",
        ),
        "quality_per_minute": block(
            "quality_per_minute",
            "quality_per_minute",
            minutes_rows,
            "capture | minutes | taken | photos | steps | Gaussians | MB | PSNR dB | SSIM | LPIPS",
        ),
        "memory": block(
            "memory", "memory", memory_rows, "photos | Gaussians | peak GB | planned GB"
        ),
        "kernels": block(
            "kernels",
            "kernels",
            kernel_rows,
            "800x533 | Gaussians | forward ms | forward + backward ms",
        ),
        "gpu": gpu(
            h200["kernels"],
            "bench.gpu.kernels",
            f"{at}, torch {h200['torch']}, medians in ms",
            gpu_rows,
            " | ".join(
                ["Gaussians | size"]
                + [f"{who}, {both.format(who)}" for who in ("sorted", "gsplat", "sort-free")]
            ),
        ),
        "gpu_frames": gpu(
            h200["frames"],
            "bench.gpu.frames",
            f"{at}, bonsai at {size_of(h200['frames']['image_size'])}, medians of "
            f"{h200['frames']['cameras']} held-back cameras",
            gpu_frame_rows,
            "scene | Gaussians | ms | gsplat sorted, ms",
        ),
        "gpu_steps": gpu(
            steps,
            "bench.gpu.steps",
            f"at {results['gpu_h100']['commit']}, bonsai at 800x533, a profile of 15 steps each",
            gpu_step_rows,
            " | ".join(["", *steps["rows"]]),
        ),
        "steps": block(
            "steps",
            "steps",
            step_rows,
            "part | size | Gaussians | ms | of the reference's | operations | native calls | MB",
        ),
        "neighbors": block(
            "steps",
            "steps --beside 6 8",
            neighbor_rows,
            "part | size | beside 6 programs | beside 8",
        ),
        "viewer": block(
            "viewer",
            "viewers.compare",
            viewer_rows,
            "viewer | load ms | frame ms, median / least | CPU ms | viewer kB | scene MB "
            "| memory MB, page + GPU | turning against settled, dB "
            "| turning against the reference, of 255 | by time, of 255",
        ),
        "screens": block(
            "screens",
            "viewers.compare",
            screen_rows,
            "viewer | 800x533, ms | 1600x1066, ms | fragments per pixel",
        ),
        "formats": block(
            "compression",
            "compression",
            format_rows,
            "file | PSNR dB | lost | LPIPS lost | bytes | per Gaussian | encode s | decode s",
        ),
        "sizes": block(
            "sizes", "sizes", size_rows, "scene | 1/4 | 1/2 | 1 | 2 | 2, bicubic from 1"
        ),
        "first_picture": block(
            "first_picture",
            "viewers.first_picture",
            first_picture_rows,
            "scene | file MB | page kB | network | first paint ms | first meaningful picture ms "
            "| complete ms | blank pictures after",
        ),
    }


def main() -> None:
    results = {path.stem: json.loads(path.read_text()) for path in RESULTS.glob("*.json")}
    readme, page = ROOT / "README.md", DOCS.read_text()
    readme.write_text(filled(readme.read_text(), "comparison", comparison(results)))
    tables = blocks(results)
    others = {"formats": "compression.md", "neighbors": "reliability.md"}
    others["compressed"] = "../guides/existing_scenes.md"
    for name, other in others.items():
        place = DOCS.parent / other
        place.write_text(filled(place.read_text(), name, tables.pop(name)))
    for name, text in tables.items():
        page = filled(page, name, text)
    DOCS.write_text(page)


if __name__ == "__main__":
    main()
