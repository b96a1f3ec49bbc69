"""Reports of the benchmarks: tables and pages made of their cells."""

import numpy as np

from bench.paper import report as paper_report
from bench.paper.equal_bytes import equal_table, popping, summary
from bench.paper.report import Run
from mobilegs.train.recipes import RECIPES, with_settings


def cell(row: str, scene: str = "a", seed: int = 0, psnr: float = 30.0, **more) -> dict:
    figures = {"ssim": 0.9, "bytes": 2**20, "gaussians": 1000, "frame_ms": 1.0, "seconds": 60}
    where = {"image_size": [4, 3], "device": "none", "date": "2026-01-01"}
    steps = {"teacher_steps": 10, "student_steps": 0 if row == "teacher" else 5}
    return {"scene": scene, "row": row, "seed": seed, "psnr": psnr} | figures | where | steps | more


def test_cells_of_other_lengths_protocols_teachers_and_settings_have_tables_of_their_own() -> None:
    plain, standard = cell("ours"), cell("ours", protocol="standard")
    seeded = cell("ours", teacher_seed=1)
    changed = cell("ours", settings={"student.pruning.quantile": "0", "teacher.min_views": "1"})
    teacher, second = cell("teacher"), cell("teacher", seed=1)
    other = cell("teacher", settings={"teacher.min_views": "1"})
    short = cell("ours", student_steps=1)
    runs = paper_report.runs_of([plain, standard, seeded, changed, teacher, second, other, short])
    assert runs == {
        Run("a", 10, 1, ""): [teacher, short],
        Run("a", 10, 5, ""): [teacher, plain],
        Run("a", 10, 5, "standard"): [standard],
        Run("a", 10, 5, "student.pruning.quantile=0, teacher.min_views=1"): [other, changed],
        Run("a", 10, 5, "teacher of seed 1"): [second, seeded],
    }


def test_rows_are_compared_by_seeds_that_both_have() -> None:
    base = [cell("codebooks", psnr=30.0), cell("codebooks", seed=1, psnr=33.0)]
    one, neither = cell("sh-0", seed=1, psnr=32.5), cell("no-codes", seed=7, psnr=10.0)
    assert paper_report.difference([one], base) == -0.5
    assert paper_report.difference([neither], base) is None
    text = "\n".join(paper_report.sections([*base, one, neither]))
    assert "| 32.50 | -0.50 | -0.08 |" in text and "| 10.00 | - | +0.21 |" in text


def test_rows_of_several_scenes_stand_side_by_side() -> None:
    cells = [
        cell("codebooks", "a", psnr=30.0),
        cell("codebooks", "b", psnr=20.0),
        cell("codebooks", "b", seed=1, psnr=22.0),
        cell("no-pruning", "a", psnr=30.25),
        cell("no-pruning", "b", seed=1, psnr=21.5),
        cell("no-codes", "b", psnr=19.0),  # of one scene alone
    ]
    text = "\n".join(paper_report.side_by_side(paper_report.runs_of(cells)))
    assert (
        "| a | b | paper" in text and "| `no-pruning` | no votes | +0.25 | -0.50 | +0.10 |" in text
    )
    assert "no-codes" not in text
    longer = cell("no-codes", "a", psnr=29.0, student_steps=9)
    text = "\n".join(paper_report.side_by_side(paper_report.runs_of([*cells, longer])))
    assert "no-codes" not in text


def test_a_group_has_means_over_the_scenes_that_have_a_row() -> None:
    cells = [
        cell("codebooks", "garden", psnr=27.0, lpips_vgg=0.1),
        cell("codebooks", "garden", seed=1, psnr=28.0, lpips_vgg=0.1),
        cell("codebooks", "room", psnr=31.0, lpips_vgg=0.3),
        cell("no-pruning", "garden", psnr=27.2),
        cell("codebooks", "truck", psnr=23.0),
    ]
    text = "\n".join(paper_report.sections(cells))
    assert "## Mip-NeRF 360, mean of 2 of 9 scenes, 10 + 5 steps" in text
    assert "## Tanks and Temples, mean of 1 of 2 scenes" in text and "Deep Blending" not in text
    assert "| 2 | 29.25 | - | - | 0.9000 | 0.200 |" in text  # seeds first, then scenes
    assert "| 1 | 27.20 | +0.20 | +0.10 | 0.9000 | - |" in text
    assert "paper, mean of Mip-NeRF 360" in text and "| `codebooks` |" in text


def test_departures_are_the_defaults_and_not_the_papers() -> None:
    default, paper = RECIPES["long"](), RECIPES["paper"]()
    for departure in paper_report.DEPARTURES:
        settings = [f"student.{setting}" for setting in departure.settings.split(", ")]
        assert with_settings(default, settings) == default, departure
        assert with_settings(paper, settings) != paper, departure


def test_the_longest_runs_with_both_rows_count() -> None:
    cells = [
        cell(row, scene="horns-250", student_steps=steps, psnr=psnr, bytes=size)
        for row, steps, psnr, size in (
            ("codebooks", 100, 20.0, 100),
            ("no-codes", 100, 21.0, 200),
            ("codebooks", 200, 30.0, 100),
            ("no-codes", 200, 30.5, 300),
            ("codebooks", 300, 31.0, 100),
        )
    ]
    found = paper_report.longest(cells, "horns-250", ("paper-no-quantization", "no-codes"))
    assert found == paper_report.Found("no-codes", 200, 0.5, 3.0)
    assert paper_report.longest(cells, "lego-200", ("no-codes",)) is None
    [line] = [line for line in paper_report.short_runs(cells) if "vector quantisation" in line]
    assert "| `no-codes` | +0.21 | - | +0.50 | - | 200 |" in line


def test_a_verdict_needs_the_papers_own_rows_at_length_on_two_captures() -> None:
    def told(deltas: dict[str, float], row: str, base: str, steps: int = 10_000) -> str:
        cells = [
            cell(name, scene, student_steps=steps, psnr=psnr)
            for scene, delta in deltas.items()
            for name, psnr in ((base, 30.0), (row, 30.0 + delta))
        ]
        [line] = [line for line in paper_report.verdicts(cells) if " no pruning " in line]
        return line.split(" | ")[0].removeprefix("| ")

    row, base = "release-no-votes", "release"
    both = {"horns-250": 0.3, "lego-200": 0.12}
    assert told(both, row, base) == "reproduced"  # the paper's is +0.10
    assert told({name: -delta for name, delta in both.items()}, row, base) == "contradicted"
    assert told(both | {"lego-200": 0.09}, row, base) == "mixed"
    assert told(dict.fromkeys(both, 0.05), row, base) == "contradicted"
    assert told({"horns-250": 0.3}, row, base) == "not tested"
    assert told(both, row, base, steps=9000) == "not tested"
    assert told(both, "no-pruning", "codebooks") == "not tested"  # not the paper's own model


def test_lines_of_a_claim_may_differ() -> None:
    deltas = {6: -0.3, 8: 0.0}
    cells = [
        cell(name, scene, student_steps=10_000, psnr=30.0 + delta)
        for scene in ("horns-250", "lego-200")
        for name, delta in (
            ("release", 0.0),
            *((f"release-codebook-{bits}", delta) for bits, delta in deltas.items()),
        )
    ]
    lines = paper_report.verdicts(cells)
    [line] = [line for line in lines if "codebooks of" in line]
    assert line.startswith("| reproduced; contradicted; not tested |")
    assert "| -0.30; +0.00; - | -0.30; +0.00; - | - |" in line
    assert lines.index(line) == 2 and lines[3].startswith("| not tested |")


def test_files_of_equal_bytes_are_compared() -> None:
    aimed = {"student.quantization.target_mb": "0.1"}
    coarse = {"student.views_per_step": "1", "student.quantization.quality": "1.5"}
    trial = {"student.pruning.quantile": "0.3"}  # a cell of another setting is none of the table
    cells = [
        cell("default", "horns-250", bytes=99_000, psnr=60.0, student_steps=7, settings=trial),
        cell("default", "horns-250", bytes=99_000, psnr=60.0, settings=trial | aimed),
        cell("default", "horns-250", bytes=100_000, student_steps=5, lpips_vgg=0.1),
        cell("default", "horns-250", bytes=99_000, psnr=30.5, lpips_vgg=0.1, settings=coarse),
        *(
            cell("default-sorted", "horns-250", lpips_vgg=0.1, settings=aimed, **other)
            for other in (
                {"bytes": 89_000, "psnr": 40.0},  # too small
                {"bytes": 98_500, "psnr": 31.0},
                {"bytes": 101_500, "psnr": 31.5},
                {"bytes": 100_000, "psnr": 50.0, "student_steps": 9},
            )
        ),
        cell("default-no-depth-pass", "horns-250", bytes=120_000, psnr=29.0, lpips_vgg=0.1),
        cell("default-no-depth-pass", "horns-250", psnr=34.0, student_steps=9, lpips_vgg=0.1),
        cell("default", "lego-200"),  # with no other
    ]
    motion = {"horns-250, default": {"frame_ms": 8.2, "stale": 0, "frames": 9, "pops": 0.0}}
    _, rows = equal_table(cells, motion)
    assert [row[1:3] for row in rows] == [
        ["default", "30.00"],
        ["default-no-depth-pass", "29.00"],
        ["default, more Gaussians", "30.50"],
        ["default-sorted", "31.50"],
    ]
    assert rows[0][-3:] == ["8", "0 of 9", "0.0"] and rows[1][-3:] == ["-", "-", "-"]
    assert "horns 30.00 and 31.50 dB, LPIPS 0.1000 and 0.1000 ([table]" in summary(cells)


def test_a_pixel_that_jumps_pops_and_one_that_moves_evenly_does_not() -> None:
    frames = np.zeros((6, 4, 5, 3))
    frames[:, 0, 0] = 20 * np.arange(6)[:, None]  # evenly
    frames[3:, 1, 1] = 12  # at once
    assert popping(frames) == 1e5 / (3 * 20)
