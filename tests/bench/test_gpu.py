"""The GPU script: it runs what is missing, stops in time, and keeps its figures."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bench.gpu import run
from bench.gpu.run import Part, parts_of, run_parts


@pytest.fixture(autouse=True)
def no_gpu_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "device", lambda: {"device": "a stand-in"})


def writes(name: str, path: Path, *, code: int = 0, needs: tuple[Path, ...] = ()) -> Part:
    """A part that appends its name to a file and ends with `code`."""
    program = f"open({str(path)!r}, 'a').write('{name} '); raise SystemExit({code})"
    return Part(name, ("-c", program), needs)


def test_a_part_that_succeeded_is_not_repeated(tmp_path: Path) -> None:
    said = tmp_path / "said"
    assert run_parts([writes("a", said, code=3), writes("b", said)], tmp_path, None) == ["a"]
    assert run_parts([writes("a", said), writes("b", said)], tmp_path, None) == []
    assert said.read_text().split() == ["a", "b", "a"]
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["device"] == "a stand-in"
    assert {name: part["exit"] for name, part in result["parts"].items()} == {"a": 0, "b": 0}


def test_a_part_without_its_files_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = writes("frames", tmp_path / "said", needs=(tmp_path / "scene.mgs",))
    assert run_parts([part], tmp_path, None) == ["frames"]
    assert "scene.mgs is missing" in capsys.readouterr().out
    assert not (tmp_path / "said").exists()


def test_a_part_is_interrupted_when_the_time_is_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = """
import signal, sys, time
def stop(*_):
    open(sys.argv[1], "w").write("checkpoint")
    sys.exit(130)
signal.signal(signal.SIGINT, signal.SIG_IGN)  # as in the background of a script
signal.signal(signal.SIGTERM, stop)
open(sys.argv[2], "w").close()
time.sleep(60)
"""
    begun, waited = tmp_path / "begun", subprocess.Popen.wait

    def wait(process: subprocess.Popen, timeout: float | None = None) -> int:
        while not begun.exists():  # a busy machine takes its time to start Python
            time.sleep(0.01)
        return waited(process, timeout)

    monkeypatch.setattr(subprocess.Popen, "wait", wait)
    slow = Part("train", ("-I", "-S", "-c", program, str(tmp_path / "saved"), str(begun)))
    after = writes("frames", tmp_path / "said")
    assert run_parts([slow, after], tmp_path, 1 / 60) == ["train", "frames"]
    assert (tmp_path / "saved").read_text() == "checkpoint"
    assert not (tmp_path / "said").exists()
    assert json.loads((tmp_path / "parts.json").read_text())["rows"]["train"]["exit"] == 130


def test_figures_of_parts_and_tests_come_together(tmp_path: Path) -> None:
    (tmp_path / "frames.json").write_text('{"rows": {}}')
    (tmp_path / "tests.xml").write_text(
        '<testsuites><testsuite tests="2" failures="1" errors="0" skipped="0">'
        '<testcase name="good"/><testcase name="bad"><failure/></testcase>'
        "</testsuite></testsuites>"
    )
    run_parts([], tmp_path, None)
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["frames"] == {"rows": {}} and "kernels" not in result
    assert result["tests"]["tests"] == 2 and result["tests"]["failed"] == ["bad"]


def test_every_module_and_option_that_the_parts_name_exists(tmp_path: Path) -> None:
    import importlib.util

    for part in parts_of(tmp_path, tmp_path, 100):
        assert part.words[0] == "-m" and importlib.util.find_spec(part.words[1]), part.name
        if part.words[1].startswith("bench."):
            source = importlib.util.find_spec(part.words[1])
            assert source is not None and source.origin is not None
            text = Path(source.origin).read_text()
            for word in part.words[2:]:
                assert not word.startswith("--") or f'"{word}"' in text, (part.name, word)


def test_a_machine_without_a_gpu_is_told_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    monkeypatch.setattr(sys, "argv", ["run.py", "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as end:
        run.main()
    assert end.value.code == 2 and not (tmp_path / "out").exists()
    assert "CUDA" in capsys.readouterr().err or "compiler" in capsys.readouterr().err
