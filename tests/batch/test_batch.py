"""A batch in processes of this machine: retries, failures, interruptions, results."""

import json
import re
import shutil
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil
import pytest
import torch

from mobilegs.batch.row_folder import RowFolder
from mobilegs.batch.run import next_stage, open_after
from mobilegs.cli.main import main
from mobilegs.formats.ply import read_ply
from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_capture

STEPS = 300  # so that a training still runs when another thread hears of its checkpoint
SAME = ("scene.mgs", "teacher.ply", "contact_sheet.png")
OPTIONS: dict[str, Any] = {"preset": "demo", "max_splats": 60}


def batch(listed: Path, output: Path, *words: str) -> int:
    """Run `mobilegs batch` with one core per training and a checkpoint after every step."""
    defaults = [f"{name}={value}" for name, value in OPTIONS.items()]
    defaults += [f"steps={STEPS}", "checkpoint_seconds=0"]
    command = ["batch", str(listed), "-o", str(output), "--engine", "local", "--device", "cpu"]
    try:
        return main([*command, "--cores", "1", "--default", *defaults, *words])
    except SystemExit as end:
        return int(str(end.code))


def results(output: Path) -> dict[str, dict[str, Any]]:
    rows = [json.loads(line) for line in (output / "results.jsonl").read_text().splitlines()]
    return {row["name"]: row for row in rows}


@contextmanager
def once_training(folder: RowFolder, act: Callable[[int], None]) -> Iterator[None]:
    """Call `act` with the process of a row's training, once that has written a checkpoint."""

    def watch() -> None:
        while not (folder.path / "checkpoint.safetensors").exists() and not over.is_set():
            time.sleep(0.005)
        events = folder.events()
        if events and events[-1]["event"] == "started" and events[-1]["stage"] == "train":
            act(events[-1]["pid"])

    over = threading.Event()
    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def interrupt() -> None:
    """Send Ctrl-C to the main thread: a signal also ends its waiting, at once."""
    main_thread = threading.main_thread().ident
    assert main_thread is not None
    signal.pthread_kill(main_thread, signal.SIGINT)


def write_list(folder: Path, rows: list[dict[str, Any]]) -> Path:
    path = folder / "list.jsonl"
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return path


@pytest.mark.thorough
@pytest.mark.usefixtures("heeds_ctrl_c")
def test_a_batch_continues_after_a_kill_a_bad_row_and_ctrl_c(
    capture: Path,
    finished: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    broken, output = tmp_path / "broken", tmp_path / "out"
    shutil.copytree(capture, broken)
    photo = sorted((broken / "images").iterdir())[1]
    photo.write_bytes(photo.read_bytes()[:100])
    rows = [
        {"name": "killed", "source": str(capture), "title": "A <title>"},
        {"name": "broken", "source": str(broken)},
        {"name": "scene", "source": str(finished / "teacher.ply"), "steps": 30, "views": 16},
    ]
    rows[-1] |= {"size": 64, "export": "site ply"}
    listed = write_list(tmp_path, rows)
    killed = []

    def kill(pid: int) -> None:
        psutil.Process(pid).kill()
        killed.append(pid)

    with once_training(RowFolder(output / "killed"), kill):
        assert batch(listed, output) == 1
    assert killed
    printed = capsys.readouterr().out
    assert "killed: training was lost (its process" in printed and "it continues" in printed
    assert "killed: training (1 core, " in printed and ", try 2)" in printed
    assert "2 of 3 done, 1 failed after " in printed
    table = printed.partition("lists them\n")[2]
    assert "broken" in table and photo.name in re.sub(r"\s", "", table)

    found = results(output)
    assert [row["state"] for row in found.values()] == ["done", "failed", "done"]
    assert found["killed"]["tries"] == 3  # two trainings and an export
    assert "cannot be decoded" in found["broken"]["error"] and found["broken"]["tries"] == 1
    single = tmp_path / "single"  # as one command makes it
    train_capture(TrainRun(capture, single, steps=STEPS, device="cpu", **OPTIONS))
    for name in SAME:
        assert (output / "killed" / name).read_bytes() == (single / name).read_bytes()
    metrics = json.loads((output / "killed" / "metrics.json").read_text())
    for key in ("psnr", "file_bytes", "gaussians"):
        assert found["killed"][key] == metrics["student"][key]
    assert found["killed"]["core_seconds"] == pytest.approx(
        sum(found["killed"]["seconds"].values()), abs=0.1
    )
    assert found["scene"]["page"] == "scene/site/index.html"
    exported, teacher = (read_ply(output / "scene" / name) for name in ("scene.ply", "teacher.ply"))
    assert torch.equal(exported.means, teacher.means)
    for row in (found["killed"], found["scene"]):
        assert (output / row["page"]).is_file() and (output / row["poster"]).is_file()
    page = (output / "index.html").read_text()
    assert 'href="killed/killed.html"' in page and "cannot be decoded" in page
    assert "A &lt;title&gt;" in page and "A <title>" not in page

    # without --resume nothing is touched, and with it only what failed is made
    assert batch(listed, output) == 2
    shutil.copyfile(capture / "images" / photo.name, photo)
    capsys.readouterr()
    with once_training(RowFolder(output / "broken"), lambda pid: interrupt()):
        assert batch(listed, output, "--resume") == 130
    assert f"interrupted: add --resume to continue {output}" in capsys.readouterr().err
    assert results(output)["broken"]["state"] == "waiting"
    ended = RowFolder(output / "broken").events()[-1]
    assert (ended["event"], ended["result"]) == ("ended", "stopped")
    assert (output / "broken" / "checkpoint.safetensors").exists()
    write_list(tmp_path, [rows[0], rows[1] | {"seed": 1}, rows[2]])
    assert batch(listed, output, "--resume") == 2
    assert "was begun with another seed: delete it" in capsys.readouterr().err
    write_list(tmp_path, rows)
    assert batch(listed, output, "--resume") == 0
    again = results(output)
    assert again["broken"]["state"] == "done"
    assert {**again, "broken": None} == {**found, "broken": None}


def test_folders_of_something_else_are_kept(
    capture: Path, finished: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "out"
    shutil.copytree(finished, output / "a")
    listed = write_list(tmp_path, [{"name": "a", "source": str(capture)}])
    assert batch(listed, output) == 2
    assert "row 1: " in (said := capsys.readouterr().err) and "already holds a run" in said
    shutil.rmtree(output)
    output.mkdir()
    (output / "index.html").write_text("mine")
    assert batch(listed, output) == 2
    assert "index.html would be overwritten" in capsys.readouterr().err
    assert (output / "index.html").read_text() == "mine"
    assert batch(listed, output / "index.html") == 2
    assert batch(listed, tmp_path / "new", "--cores", "0") == 2
    assert batch(listed, tmp_path / "new", "--cores", "9999") == 2
    assert "no machine has 9999 cores" in capsys.readouterr().err


def test_the_stages_of_a_row_follow_from_its_folder(capture: Path, tmp_path: Path) -> None:
    folder = RowFolder(tmp_path / "a")
    folder.create("s3://bucket/a", {}, [])
    assert next_stage(folder, folder.place()) == "fetch"
    folder.set_place(capture, "photos")
    assert next_stage(folder, folder.place()) == "poses"
    assert open_after("poses", "photos") == ["poses", "train", "export"]
    folder.append("ended", 1, stage="poses", result="lost")
    assert next_stage(folder, folder.place()) == "poses"
    folder.append("ended", 2, stage="poses", result="done")
    assert next_stage(folder, folder.place()) == "train"
    folder.append("ended", 3, stage="train", result="done")
    assert next_stage(folder, folder.place()) == "train"  # its files are gone
    for name in ("metrics.json", "scene.mgs"):
        (folder.path / name).touch()
    assert next_stage(folder, folder.place()) == "export"
    with folder.events_file.open("a") as file:
        file.write('{"event": "en')  # a machine died while it wrote
    assert folder.attempts() == 3 and next_stage(folder, folder.place()) == "export"
    assert open_after("train", "capture") == ["train", "export"]
    assert open_after("fetch", None) == ["fetch", "train", "export"]
