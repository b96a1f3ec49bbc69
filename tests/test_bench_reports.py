"""What benches say of their cells."""

from paper_report import runs_of


def test_cells_of_other_lengths_are_no_seeds_of_each_other() -> None:
    def cell(row: str, student_steps: int) -> dict:
        return {"scene": "a", "row": row, "teacher_steps": 10, "student_steps": student_steps}

    teacher, short, long = cell("teacher", 0), cell("ours", 1), cell("ours", 5)
    assert runs_of([long, teacher, short]) == {
        ("a", 10, 1): [teacher, short],
        ("a", 10, 5): [teacher, long],
    }
    assert runs_of([teacher]) == {("a", 10, 0): [teacher]}
