"""A task's process imports what is installed, and nothing from the current folder."""

from pathlib import Path

import pytest

from mobilegs.batch.row_folder import RowFolder
from mobilegs.batch.task import Outcome, Task, run_task


def test_files_in_the_current_folder_do_not_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran = tmp_path / "ran"
    for name in ("filelock", "json", "torch"):
        program = f"open({str(ran)!r}, 'a').write('{name} ')\nraise ImportError('not that one')\n"
        (tmp_path / f"{name}.py").write_text(program, "utf-8")
    folder = RowFolder(tmp_path / "out" / "one")
    folder.create("memory://nothing", {}, [])
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    task = Task(str(folder.path), "fetch", 1, 1, 0, str(tmp_path), source="memory://nothing")
    outcome = run_task(task)
    assert not ran.exists(), ran.read_text("utf-8")
    assert outcome == Outcome("refused", "there is nothing at memory://nothing")
