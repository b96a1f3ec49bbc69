"""Write the figures of README.md and docs/explanation/benchmarks.md from bench/results.

    python -m bench.readme [--json OUT]

Each table stands between its own pair of markers, `<!-- BEGIN:name -->` and `<!-- END:name -->`.
`--json` also writes the tables' cells.
"""

import argparse
import json
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", ROOT / "docs/explanation/benchmarks.md")
ALIKE = 98  # dB: pictures that differ by a rounding error are below this
TEACHER = "bonsai-400/10000+0/teacher/2"  # of bench/results/paper.json
STUDENT = "bonsai-400/10000+5000/ours/2/teacher2"


def table(rows: list[list[str]]) -> str:
    """Return a Markdown table; the first row is its head."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines.insert(1, "|" + "---|" * len(rows[0]))
    return "\n".join(lines)


def number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def quality_rows(runs: dict) -> list[list[str]]:
    """Return the teacher's and the student's figures of every capture, on held-back photos."""
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
    """Return the CPU kernels' milliseconds and their ratio to those of the prototype."""
    head = ["800x533", "Gaussians", "forward ms", "forward + backward ms", "ratio to the prototype"]
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


def gpu_rows(rows: dict) -> list[list[str]]:
    """Return the CUDA kernels' milliseconds beside gsplat's, by number of Gaussians and size."""
    kinds = ("forward", "both")
    found = [["Gaussians", "size"]]
    found[0] += [f"sorted, {kind}" for kind in ("forward", "forward + backward")]
    found[0] += [f"gsplat, {kind}" for kind in ("forward", "forward + backward")]
    found[0] += [f"sort-free, {kind}" for kind in ("forward", "forward + backward")]
    for count, size in dict.fromkeys(tuple(name.split()[:2]) for name in rows):
        by_kind = {
            path: [rows[f"{count} {size} {path} {kind}"] for kind in kinds]
            for path in ("sorted", "sortfree")
        }
        times = [row["ms"] for row in by_kind["sorted"]]
        times += [row["gsplat_ms"] for row in by_kind["sorted"]]
        times += [row["ms"] for row in by_kind["sortfree"]]
        found.append([f"{int(count):,}", size, *(number(ms, 2) for ms in times)])
    return found


def gpu_frame_rows(rows: dict) -> list[list[str]]:
    """Return the milliseconds of whole frames of trained scenes beside gsplat's."""
    found = [["scene", "Gaussians", "ms", "gsplat sorted, ms"]]
    for name, row in rows.items():
        times = [number(row[key], 2) for key in ("ms", "gsplat_ms")]
        found.append([f"{name}, {row['blend']}", f"{row['gaussians']:,}", *times])
    return found


def gpu_step_rows(rows: dict) -> list[list[str]]:
    """Return where the time of a training step goes."""
    keys = {
        "gaussians": ("Gaussians", 0),
        "ms": ("one step, ms", 1),
        "rendering_gpu_ms": ("of them, rendering forward and backward, ms", 2),
        "kernel_launches": ("kernels started in a step", 0),
    }
    found = [["", *rows]]
    for key, (title, digits) in keys.items():
        found.append([title, *(f"{row[key]:,.{digits}f}" for row in rows.values())])
    return found


def viewer_rows(viewers: dict) -> list[list[str]]:
    """Return the time per frame, the bytes sent and the error during a turn of every viewer."""
    head = (
        "viewer | load ms | frame ms, median / least | CPU ms | viewer kB | scene MB "
        "| turning against settled, dB | turning against the reference, dB"
    )
    found = [head.split(" | ")]
    for name, row in viewers.items():
        frame, turn = row["frame_ms"], row["turn"]["moving_settled"]["median"]
        found.append(
            [
                (f"{name}, {row['date']}" if "date" in row else name)
                .replace("halves", "float16")
                .replace("floats", "float32"),
                number(row["load_ms"]["median"], 0),
                f"{frame['median']:.0f} / {frame['min']:.0f}",
                number(row["cpu_ms"]["median"], 0),
                number(row["viewer_gzip_bytes"] / 1e3, 0),
                number(row["scene_bytes"] / 1e6, 1),
                "equal" if turn >= ALIKE else number(turn, 1),
                number(row["turn"]["moving_true"]["median"], 1),
            ]
        )
    return found


def loading_rows(loading: dict) -> list[list[str]]:
    """Return the milliseconds until the first picture, the decoded and the drawn scene."""
    found = [["renderer", "visit", "first picture ms", "decoded ms", "all drawn ms"]]
    for renderer in ("webgpu", "webgl"):
        for visit in ("first_visit", "later_visit"):
            row = loading[renderer][visit]
            times = [f"{row[key]}" for key in ("first_picture", "decoded", "loaded")]
            found.append([renderer, visit.replace("_", " "), *times])
    return found


def first_picture_rows(scenes: dict) -> list[list[str]]:
    """Return when first visits show something, by scene and network."""
    head = "scene | file MB | page kB | network | first paint ms | first meaningful picture ms"
    found = [f"{head} | complete ms | blank pictures after".split(" | ")]
    for name, scene in scenes.items():
        size = [f"{scene['file_bytes'] / 1e6:.2f}", f"{scene['page_bytes'] / 1e3:.0f}"]
        for network, row in scene.items():
            if isinstance(row, dict):
                times = [f"{row[key]:,}" for key in ("first_paint", "meaningful", "loaded")]
                found.append([name, *size, network, *times, str(row["blank_after"])])
    return found


def framing_rows(scenes: dict) -> list[list[str]]:
    """Return the greatest unseen shares over four screens, by scene."""
    head = "scene | Gaussians | cameras | first camera | first view | subject in it"
    found = [f"{head} | inside the limits, mean | p90 | most | seconds to find".split(" | ")]
    for name, scene in scenes.items():
        screens = list(scene["screens"].values())
        cells = [
            percent(max(row["before"] for row in screens)),
            percent(max(row["first_view"] for row in screens)),
            percent(min(row["subject"] for row in screens)) if "subject" in screens[0] else "",
        ]
        for key in ("inside_mean", "inside_p90", "inside_most"):
            cells.append(percent(max(row[key] for row in screens)) if key in screens[0] else "")
        seconds = number(scene.get("seconds"), 1)
        found.append([name, f"{scene['gaussians']:,}", str(scene["cameras"]), *cells, seconds])
    return found


def far_rows(cells: dict) -> list[list[str]]:
    """Return PSNR and bytes with and without Gaussians on a far sphere."""
    head = "capture | far Gaussians at first | teacher PSNR dB | student PSNR dB | file kB"
    rows = [head.split(" | ")]
    for name, cell in cells.items():
        capture, count = name.split(", ")
        size = "x".join(map(str, cell["image_size"]))
        figures = [number(cell[who]["psnr"], 2) for who in ("teacher", "student")]
        size_kb = f"{cell['student']['file_bytes'] / 1e3:.0f}"
        rows.append([f"{capture}, {size}", f"{int(count):,}", *figures, size_kb])
    return rows


def percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def size_rows(sizes: dict) -> list[list[str]]:
    """Return PSNR at other sizes than that of training, each beside the resized image."""
    head = "capture | scene | 1/4 | area average | 1/2 | area average | 1 | 2 | bicubic"
    found = [head.split(" | ")]
    for capture, content in sizes.items():
        width, height = content["image_size"]
        for name, row in content["scenes"].items():
            seen = row["psnr_by_size"]
            keys = ("1/4", "1/4, area average", "1/2", "1/2, area average", "1", "2", "2, bicubic")
            cells = [number(seen.get(key), 2) for key in keys]
            found.append([f"{capture.rsplit('-', 1)[0]}, {width}x{height}", name, *cells])
    return found


def level_rows(sizes: dict) -> list[list[str]]:
    """Return fragments and errors of the viewers' levels, by screen."""
    head = (
        "capture | scene | screen | fragments | with levels | share | dB | p99.9 | largest change"
    )
    found = [head.split(" | ")]
    for capture, content in sizes.items():
        for name, row in content["scenes"].items():
            for screen, by_sigma in row.get("levels", {}).items():
                full, drawn = by_sigma["0"], by_sigma[f"{row['level_sigma']:g}"]
                found.append(
                    [
                        capture.rsplit("-", 1)[0],
                        name,
                        f"{screen}x",
                        number(full["fragments"], 1),
                        " + ".join(number(value, 1) for value in drawn["by_level"]),
                        number(drawn["fragments"] / full["fragments"], 2),
                        number(drawn["psnr"], 1),
                        number(drawn["p99.9"], 1),
                        f"{full['largest_change']:.0f} / {drawn['largest_change']:.0f}",
                    ]
                )
    return found


def screen_rows(screens: dict) -> list[list[str]]:
    """Return the time of a frame of every viewer at every size of the screen."""
    found = [["viewer", *(f"{size}, ms" for size in screens), "fragments per pixel"]]
    for name in next(iter(screens.values()))["viewers"]:
        rows = [screen["viewers"].get(name) for screen in screens.values()]
        times = ["-" if row is None else number(row["frame_ms"]["median"], 0) for row in rows]
        counts = [number(sum(row["fragments"]), 1) for row in rows if row and "fragments" in row]
        words = name.replace("halves", "float16").replace("floats", "float32")
        found.append([words, *times, " / ".join(counts) or "-"])
    return found


def trained_rows(rows: list[dict]) -> list[list[str]]:
    """Return the CPU kernels' milliseconds for trained scenes, all at full size and with levels."""
    found = [["scene", "size", "forward ms", "with levels", "forward + backward ms", "with levels"]]
    for forward, both in zip(rows[::2], rows[1::2], strict=True):
        times = [number(row[key], 1) for row in (forward, both) for key in ("full_ms", "levels_ms")]
        size = "x".join(map(str, forward["size"]))
        found.append([f"{forward['scene']}, {forward['gaussians']:,}", size, *times])
    return found


def off_path_rows(students: dict) -> list[list[str]]:
    """Return each student's PSNR to held-back photos, and to its teacher by kind of view."""
    kinds = list(next(iter(students.values()))["to_teacher"])
    rows = [["share of virtual views beside the path", "held-back photos dB", *kinds, "file MB"]]
    for share, found in students.items():
        near = [found["to_teacher"][kind] for kind in kinds]
        cells = [f"{each['mean']:.2f} ({each['least']:.1f})" for each in near]
        held = number(found["held_back"], 2)
        rows.append([share, held, *cells, number(found["bytes"] / 1e6, 2)])
    return rows


def pose_rows(found: dict) -> list[list[str]]:
    """Return a teacher's PSNR and the error of its cameras, by what happened to their poses."""
    rows = [["poses", "held-back photos dB", "median error of training cameras, px"]]
    rows += [
        [name, number(row["psnr"], 2), number(row["median_pixels"], 2)]
        for name, row in found.items()
    ]
    return rows


def exposure_rows(cells: dict) -> list[list[str]]:
    """Return the student's figures by capture, made steps and setting."""
    head = "capture, photos | exposures learned | spread, log2 | PSNR dB | cc-PSNR dB | LPIPS (VGG)"
    rows = [[*head.split(" | ")]]
    for name, cell in cells.items():
        capture, photos, setting = name.split(", ")
        student, seen = cell["student"], cell["exposures"].get("student")
        learned = "yes" if seen and seen["learned"] else "no"
        spread = number(seen["spread"] if seen else None, 3)
        figures = [number(student[key], 2) for key in ("psnr", "cc_psnr")]
        lpips = number(student["lpips_vgg"], 3)
        rows.append([f"{capture}, {photos}", f"{setting}: {learned}", spread, *figures, lpips])
    return rows


def comparison_rows(paper: dict, formats: dict, viewers: dict) -> list[list[str]]:
    """Return size, quality and frame times of one teacher in other formats and of its student."""
    teacher, student, ours = paper[TEACHER], paper[STUDENT], viewers["ours, WebGPU"]
    ply = formats["bonsai/teacher"]
    others = {
        name: row
        for name, row in viewers.items()
        if not name.startswith("ours") and row["scene_bytes"] == ply["bytes"]
    }
    if ply["bytes"] != teacher["bytes"] or ours["scene_bytes"] != student["bytes"] or not others:
        raise ValueError("the results are not of one teacher and its student")
    best = min(others, key=lambda name: others[name]["frame_ms"]["median"])
    kernels = "ms per frame, CPU kernels"
    rows = [["file", "blended", "MB", "PSNR dB", kernels, "ms per frame, browser"]]
    for kind, cell, blended, ms, browser in (
        ("`.ply`, the teacher", ply, "sorted", teacher["frame_ms"], best),
        ("`.sog`", formats["bonsai/sog"], "sorted", None, ""),
        ("`.spz`", formats["bonsai/spz"], "sorted", None, ""),
        ("**`.mgs`**", student, "in any order", student["frame_ms"], "ours, WebGPU"),
    ):
        row = viewers.get(browser)
        frame = f"{row['frame_ms']['median']:.0f} ({browser})" if row else "as `.ply`"
        size, psnr = f"{cell['bytes'] / 1e6:.2f}", f"{cell['psnr']:.2f}"
        rows.append([kind, blended, size, psnr, f"{ms:.1f}" if ms else "as `.ply`", frame])
    return rows


def blocks(results: dict) -> dict[str, tuple[str, list[list[str]]]]:
    """Return every block: its name, the line above the table, and the table's rows."""
    captures, kernels, viewer = results["captures"], results["kernels"], results["viewer"]
    loading, paper = results["loading"], results["paper"]["cells"]
    sizes, screens, trained = results["sizes"], results["screens"], results["trained_kernels"]
    off_path, poses, exposure = (results[name] for name in ("off_path", "poses", "exposure"))
    picture, framing, far = (results[name] for name in ("first_picture", "framing", "far_splats"))
    gpu, steps = results["gpu_h200"], results["gpu_h100"]["steps"]
    first = next(iter(screens.values()))
    student = paper[STUDENT]
    size = "x".join(map(str, student["image_size"]))
    return {
        "comparison": (
            f"Bonsai, {student['photos']} held-back photos of {size}, "
            f"{student['device'].replace('kernels v4', 'AVX-512')}, {student['date']}. "
            f"The browser ({viewer['browser']}, {viewer['plan']['size']}) draws "
            "in software; its time for the `.ply` is that of the fastest other viewer measured. "
            f"The student took {student['student_steps']:,} steps "
            f"({student['seconds'] / 60:.1f} minutes), its teacher "
            f"{student['teacher_steps']:,}.",
            comparison_rows(paper, results["compression"]["cells"], viewer["viewers"]),
        ),
        "quality": (
            f"`python -m bench.captures`, {captures['date']}, {captures['machine']}:",
            quality_rows(captures["runs"]),
        ),
        "kernels": (
            f"`python -m bench.kernels`, {kernels['date']}, {kernels['machine']}:",
            kernel_rows(kernels["rows"]),
        ),
        "gpu": (
            f"`python -m bench.gpu.kernels`, {gpu['date']}, {gpu['device']}, torch {gpu['torch']}, "
            "the study's dense scene, medians in ms:",
            gpu_rows(gpu["kernels"]["rows"]),
        ),
        "gpu_frames": (
            f"`python -m bench.gpu.frames`, {gpu['date']}, {gpu['device']}, bonsai at "
            f"{'x'.join(map(str, gpu['frames']['image_size']))}, medians of "
            f"{gpu['frames']['cameras']} held-back cameras:",
            gpu_frame_rows(gpu["frames"]["rows"]),
        ),
        "gpu_steps": (
            f"`python -m bench.gpu.steps`, {steps['date']}, {steps['device']}, bonsai at 800x533, "
            "profile of 15 steps each:",
            gpu_step_rows(steps["rows"]),
        ),
        "viewer": (
            f"`python -m bench.viewers.compare`, {viewer['date']}, {viewer['machine']}, "
            f"{viewer['browser']}, bonsai at {viewer['plan']['size']}, medians of "
            f"{viewer['plan']['rounds']} rounds, a turn of "
            f"{viewer['plan']['turn_degrees_a_frame']} degrees per frame:",
            viewer_rows(viewer["viewers"]),
        ),
        "sizes": (
            "`python -m bench.studies.sizes`, PSNR in dB to held-back photos:",
            size_rows(sizes),
        ),
        "levels": (
            "`python -m bench.studies.sizes`, two held-back cameras of each capture:",
            level_rows(sizes),
        ),
        "screens": (
            f"`python -m bench.viewers.compare`, {first['date']}, {first['machine']}, "
            f"{first['browser']}, {first['scene']['name']}, medians of "
            f"{first['plan']['frames']} frames:",
            screen_rows(screens),
        ),
        "off_path": (
            f"`python -m bench.studies.off_path`, {off_path['date']}, {off_path['machine']}, "
            f"bonsai at {'x'.join(map(str, off_path['size']))}, {off_path['steps']:,} steps of the "
            "student, one seed; PSNR in dB to the teacher's images, mean (least):",
            off_path_rows(off_path["students"]),
        ),
        "poses": (
            f"`python -m bench.studies.poses`, {poses['date']}, {poses['machine']}, teachers of "
            f"{poses['steps']:,} steps, bonsai at 200x133, one seed:",
            pose_rows(poses["rows"]),
        ),
        "exposure": (
            f"`python -m bench.studies.exposure`, {exposure['date']}, {exposure['machine']}, the "
            "preset cpu with at most 30,000 Gaussians and "
            f"{' '.join(exposure['settings'])}, photos at a quarter of their size, one seed, "
            "students on held-back photos:",
            exposure_rows(exposure["cells"]),
        ),
        "trained": (
            f"`python -m bench.kernels --scenes`, {trained['date']}, {trained['machine']}:",
            trained_rows(trained["scenes"]),
        ),
        "loading": (
            f"`python -m bench.viewers.loading`, {loading['date']}, {loading['machine']}, the same "
            f"browser, {loading['gaussians']:,} Gaussians in {loading['file_bytes'] / 1e6:.1f} MB "
            f"(`{loading['coding']}`). In a page that draws nothing, decoding takes "
            f"{loading['alone']['first']} ms on the first visit and {loading['alone']['later']} ms "
            "later:",
            loading_rows(loading),
        ),
        "first_picture": (
            f"`python -m bench.viewers.first_picture`, {picture['date']}, {picture['machine']}, "
            f"{'x'.join(map(str, picture['size']))} pixels, medians of {picture['rounds']} visits:",
            first_picture_rows(picture["scenes"]),
        ),
        "far_splats": (
            f"`python -m bench.studies.far_splats`, {far['date']}, {far['machine']}, the preset "
            "cpu with at most 30,000 Gaussians and 2,000 + 2,000 steps, one seed:",
            far_rows(far["cells"]),
        ),
        "framing": (
            f"`python -m bench.studies.framing`, {framing['date']}, {framing['machine']}, the "
            "greatest share over four screens (390x844, 820x1180, 1440x900, 844x390) of pixels "
            "that no training camera saw:",
            framing_rows(framing["scenes"]),
        ),
    }


def filled(page: str, name: str, text: str) -> str:
    """Return the page with the text between the markers of `name`, if it has them."""
    begin, end = f"<!-- BEGIN:{name} -->", f"<!-- END:{name} -->"
    if begin not in page:
        return page
    before, rest = page.split(begin)
    return f"{before}{begin}\n\n{text}\n\n{end}{rest.split(end)[1]}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="write the tables' cells here")
    options = parser.parse_args()
    names = ("captures", "compression", "kernels", "loading", "paper", "viewer")
    names += ("sizes", "screens", "trained_kernels", "off_path", "poses", "exposure")
    names += ("first_picture", "framing", "far_splats", "gpu_h200", "gpu_h100")
    results = {
        name: json.loads((ROOT / f"bench/results/{name}.json").read_text()) for name in names
    }
    found = blocks(results)
    for path in PAGES:
        page = path.read_text()
        for name, (line, rows) in found.items():
            page = filled(page, name, f"{line}\n\n{table(rows)}")
        path.write_text(page)
    if options.json:
        tables = {name: rows for name, (_, rows) in found.items()}
        options.json.write_text(json.dumps(tables, indent=1) + "\n")


if __name__ == "__main__":
    main()
