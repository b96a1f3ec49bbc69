"""What benches say of their cells."""

import compression_report
import paper_report


def test_cells_of_other_lengths_are_no_seeds_of_each_other() -> None:
    def cell(row: str, student_steps: int) -> dict:
        return {"scene": "a", "row": row, "teacher_steps": 10, "student_steps": student_steps}

    teacher, short, long = cell("teacher", 0), cell("ours", 1), cell("ours", 5)
    assert paper_report.runs_of([long, teacher, short]) == {
        ("a", 10, 1): [teacher, short],
        ("a", 10, 5): [teacher, long],
    }
    assert paper_report.runs_of([teacher]) == {("a", 10, 0): [teacher]}


def test_files_after_other_lengths_are_compared_apart() -> None:
    cells = {"a/5/plain": {"psnr": 2.0}, "a/2/plain": {"psnr": 1.0}, "a/spz": {}, "a/2/sq": {}}
    found = compression_report.runs_of(cells)
    assert list(found) == [("a", 2), ("a", 5)]
    assert found["a", 2] == {"plain": {"psnr": 1.0}, "sq": {}}
