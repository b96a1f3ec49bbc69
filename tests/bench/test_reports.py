"""Reports of the benchmarks: tables and pages made of their cells."""

from bench.paper import report as paper_report
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
    one, neither = cell("network", seed=1, psnr=32.5), cell("no-phi", seed=7, psnr=10.0)
    assert paper_report.difference([one], base) == -0.5
    assert paper_report.difference([neither], base) is None
    text = "\n".join(paper_report.sections([*base, one, neither]))
    assert "| 32.50 | -0.50 | - |" in text and "| 10.00 | - | - |" in text


def test_rows_of_several_scenes_stand_side_by_side() -> None:
    cells = [
        cell("codebooks", "a", psnr=30.0),
        cell("codebooks", "b", psnr=20.0),
        cell("codebooks", "b", seed=1, psnr=22.0),
        cell("no-pruning", "a", psnr=30.25),
        cell("no-pruning", "b", seed=1, psnr=21.5),
        cell("no-phi", "b", psnr=19.0),  # of one scene alone
    ]
    text = "\n".join(paper_report.side_by_side(paper_report.runs_of(cells)))
    assert (
        "| a | b | paper" in text and "| `no-pruning` | no votes | +0.25 | -0.50 | +0.10 |" in text
    )
    assert "no-phi" not in text
    longer = cell("no-phi", "a", psnr=29.0, student_steps=9)
    text = "\n".join(paper_report.side_by_side(paper_report.runs_of([*cells, longer])))
    assert "no-phi" not in text


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
    [line] = [line for line in paper_report.claims(cells) if "vector quantisation" in line]
    assert "| - | +0.50 | - | 200 |" in line
