"""Several processes train bit for bit like one, and end together."""

import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import torch
import torch.distributed as dist

from mobilegs.cli.main import main
from mobilegs.data import load_capture
from mobilegs.errors import InputError
from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_in_team
from mobilegs.train import distributed
from mobilegs.train.distributed import LostProcessError, Team, join_team
from mobilegs.train.stage import view_order
from mobilegs.train.state_file import digest, read_state

SETTINGS = (
    "teacher.steps=11",
    "student.steps=19",
    "teacher.max_splats=50",
    "teacher.init_splats=40",
    "teacher.densify.min_interval=3",
)
OPTIONS = ["--preset", "demo", "--views-per-step", "4", "--resume"]
OPTIONS += ["--set", *SETTINGS]
TEACHER_STEPS = 11  # of 30
# `mobilegs` in which one process may send itself a signal, then a list of the threads that remain
PROGRAM = """
import os, sys
from pathlib import Path
from mobilegs.cli.main import main
from mobilegs.pipeline import train
rank, steps, number, *words = sys.argv[1:]
taken = 0
for kind in (train.Teacher, train.Student):
    def advance(stage, views, original=kind.advance):
        global taken
        taken += 1
        if (taken, os.environ["RANK"]) == (int(steps), rank):
            os.kill(os.getpid(), int(number))
        return original(stage, views)
    kind.advance = advance
code = main(words)
print("threads", *{path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm")})
sys.exit(code)
"""


def words(capture: Path, run: Path) -> list[str]:
    return ["train", str(capture), "-o", str(run), *OPTIONS]


def together(
    capture: Path, run: Path, *, rank: int = 0, steps: int = 0, number: int = 0
) -> subprocess.CompletedProcess[str]:
    """Train in two processes with torchrun, one of which gets a signal in a step."""
    command = [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node"]
    command += ["2", "--no-python", sys.executable, "-c", PROGRAM]
    command += [str(rank), str(steps), str(number), *words(capture, run)]
    return subprocess.run(command, capture_output=True, text=True)


def sentences(said: str) -> list[str]:
    return [line for line in said.splitlines() if line.startswith("mobilegs: ")]


@pytest.fixture(scope="module", autouse=True)
def one_thread() -> Iterator[None]:
    """Use one thread, as torchrun does: matrix products depend on the number of threads."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.mark.thorough
def test_two_interrupted_and_resumed_processes_leave_the_bytes_of_one(
    capture: Path, tmp_path: Path
) -> None:
    single_run, run = tmp_path / "single_run", tmp_path / "run"
    assert main(words(capture, single_run)) == 0
    # SIGTERM for the second process, in the student's third step
    done = together(capture, run, rank=1, steps=TEACHER_STEPS + 3, number=15)
    assert done.returncode == 1
    told = f"mobilegs: interrupted: add --resume to continue {run}"
    assert sentences(done.stderr) == [told] and "exitcode  : 130" in done.stderr
    saved = read_state(run / "checkpoint.safetensors")
    assert (saved["stage"], saved["state"]["done"]) == ("student", 3)
    done = together(capture, run)
    assert done.returncode == 0, done.stderr
    for name in ("scene.mgs", "teacher.ply", "contact_sheet.png"):
        assert (run / name).read_bytes() == (single_run / name).read_bytes(), name
    assert {path.name for path in run.iterdir()} == {path.name for path in single_run.iterdir()}
    rows, others = (
        re.sub(r'"seconds": [\d.]+', "", (folder / "metrics.jsonl").read_text())
        for folder in (run, single_run)
    )
    assert rows == others
    if sys.platform == "linux":  # a thread that is left, and holds a tensor, aborts Python's end
        assert "threads" in done.stdout and "gloo" not in done.stdout
    assert done.stdout.count("scene.mgs") == 1  # one of them speaks
    assert done.stdout.count("training the student: finished in ") == 1


@pytest.mark.thorough
def test_an_error_in_one_process_gives_one_line_and_ends_all(capture: Path, tmp_path: Path) -> None:
    broken = shutil.copytree(capture, tmp_path / "broken")
    dataset = load_capture(broken)
    second = dataset.train[view_order(len(dataset.train), 0, 2, seed=0)[1]].image_path
    assert second is not None
    second.write_bytes(second.read_bytes()[:90])
    done = together(broken, tmp_path / "run")
    [sentence] = sentences(done.stderr)
    assert done.returncode == 1 and str(second) in sentence
    assert "exitcode  : 2" in done.stderr and "distributed.py" not in done.stderr


def test_uneven_shares_of_views_are_refused(capture: Path, tmp_path: Path) -> None:
    run = TrainRun(capture, tmp_path / "run", views_per_step=3)
    with pytest.raises(
        InputError, match=r"2 processes cannot share the 3 views of a step .* of 2,"
    ):
        train_in_team(run, None, Team(torch.device("cpu"), world_size=2))
    assert not run.output.exists()


@pytest.fixture
def launched(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """A function that fails in one of two processes, `before` of which have failed already."""

    def launch(error: BaseException, before: int) -> None:
        store = dist.HashStore()  # pyright: ignore[reportPrivateImportUsage]
        store.add("mobilegs/failed", before)
        monkeypatch.setenv("TORCHELASTIC_RUN_ID", "test")
        monkeypatch.setenv("WORLD_SIZE", "2")
        meeting = sys.modules["torch.distributed.rendezvous"]  # a function hides its module
        monkeypatch.setattr(meeting, "rendezvous", lambda _: iter([(store, 1, 2)]))
        monkeypatch.setattr(dist, "init_process_group", lambda *_, **__: None)
        with join_team("cpu") as team:
            assert (team.rank, team.world_size, team.is_main) == (1, 2, False)
            raise error

    return launch


@pytest.mark.parametrize(
    ("error", "code"), [(InputError("x"), 2), (KeyboardInterrupt(), 130), (ValueError("x"), 1)]
)
def test_only_the_first_failing_process_reports_its_error(
    error: BaseException, code: int, launched: Callable[..., None]
) -> None:
    with pytest.raises(type(error)):
        launched(error, 0)
    with pytest.raises(SystemExit) as ended:
        launched(error, 1)
    assert ended.value.code == code


def test_a_killed_process_is_reported(
    launched: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    def closed(*_: object) -> None:
        raise RuntimeError("connection closed by peer")

    monkeypatch.setattr(dist, "all_gather", closed)
    with pytest.raises(LostProcessError) as parted:
        Team(torch.device("cpu"), world_size=2).barrier()
    with pytest.raises(SystemExit, match=r"another process .* has ended \(connection closed"):
        launched(parted.value, 0)


def test_more_processes_than_gpus_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 1)
    for name, value in {"LOCAL_RANK": "1", "LOCAL_WORLD_SIZE": "2"}.items():
        monkeypatch.setenv(name, value)
    assert distributed._own_device(torch.device("cpu")).type == "cpu"
    with pytest.raises(InputError, match="start 1, or add --device cpu"):
        distributed._own_device(torch.device("cuda"))


def test_diverging_processes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    team = Team(torch.device("cpu"), rank=1, world_size=2)
    monkeypatch.setattr(team, "all_gather_ints", lambda *own: [[7], list(own)])
    team.require_identical("after step 3", 7)
    with pytest.raises(InputError, match="no longer hold the same scene after step 3"):
        team.require_identical("after step 3", 8)


def test_a_digest_changes_with_any_bit() -> None:
    state = {"done": 3, "rows": {"a": torch.zeros(4), "b": [torch.zeros(2), 0.5]}}
    before = digest(state)
    assert digest({"done": 3, "rows": {"a": torch.zeros(4), "b": [torch.zeros(2), 0.5]}}) == before
    state["rows"]["a"][2] = 1e-30
    assert digest(state) != before
    assert digest({**state, "done": 4}) != digest(state)
