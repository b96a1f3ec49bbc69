"""The command line with hostile files."""

import json
import os
import signal
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import torch

from mobilegs import scene_file
from mobilegs.cli.main import VERBS, main
from mobilegs.mgs.codec import inspect_mgs
from tests.support.mgs_parts import parse_parts

CONFORMANCE = Path(__file__).parents[1] / "mgs" / "conformance"


def test_info_prints_only_known_fields(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sound, path = CONFORMANCE / "nvq_linear_lobes.mgs", tmp_path / "deep.mgs"
    parts = parse_parts(sound.read_bytes())
    deep: list = []
    for _ in range(900):
        deep = [deep]
    for field in ("lobes", "weighting"):
        parts.header[field]["later"] = deep
    path.write_bytes(parts.to_bytes())
    assert main(["info", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert all(found[field] == inspect_mgs(sound)[field] for field in ("lobes", "weighting"))


KINDS = ("mgs", "ply", "spz", "sog", "splat", "glb")


@contextmanager
def at_once() -> Iterator[None]:
    """Fail instead of waiting for a pipe."""

    def late(*_) -> None:
        raise AssertionError("this waits for the other end of a pipe")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(20)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs POSIX")
@pytest.mark.parametrize(
    ("kind", "what"),
    # the folder of a .sog is one that was unpacked
    [*zip(KINDS, ("folder", "device", "pipe", "pipe", "device", "folder"), strict=True)],
)
def test_pipes_devices_and_folders_are_refused_unread(
    kind: str, what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"scene.{kind}"
    if what == "pipe":
        os.mkfifo(path)
    elif what == "device":
        path.symlink_to("/dev/zero")
    else:
        path.mkdir()
    with at_once():
        assert main(["info", str(path)]) == 2
    printed = capsys.readouterr()
    expected = f"mobilegs: cannot read {path}: it is a folder, a device or a pipe\n"
    assert (printed.out, printed.err) == ("", expected)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs POSIX")
def test_a_pipe_in_the_folder_of_a_sog_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "meta.json").symlink_to("/dev/null")
    with at_once():
        assert main(["info", str(tmp_path / "meta.json")]) == 2
    assert "a folder, a device or a pipe" in capsys.readouterr().err


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_of_zeros_is_refused_by_its_first_bytes(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"zeros.{kind}"
    with path.open("wb") as file:
        file.truncate((1 << 30) + 1)  # which takes no room
    tracemalloc.start()
    try:
        assert main(["info", str(path)]) == 2
        assert tracemalloc.get_traced_memory()[1] < 4 << 20
    finally:
        tracemalloc.stop()
    assert f"{path}" in capsys.readouterr().err


def lines_of_info(notes: dict, path: Path, capsys: pytest.CaptureFixture[str]) -> list[list[str]]:
    """The lines that `info` prints for a file with these notes, split into words."""
    parts = parse_parts((CONFORMANCE / "nvq_constant.mgs").read_bytes())
    parts.header["meta"] = notes
    path.write_bytes(parts.to_bytes())
    assert main(["info", str(path)]) == 0
    return [line.split() for line in capsys.readouterr().out.splitlines()]


def test_notes_cannot_look_like_findings_of_info(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    false = {"blending": "in order of depth, as in 3DGS", "version": 9, "a_b": 1, "a b": 2}
    lines = lines_of_info(false, tmp_path / "notes.mgs", capsys)
    heading = lines.index(["notes", "of", "the", "author"])
    found = [line[:2] for line in lines[:heading]]
    assert ["blending", "without"] in found and ["version", "2.1"] in found
    assert not any("depth," in line for line in lines[:heading])
    noted = lines[heading + 1 : heading + 5]
    assert noted[0] == "blending in order of depth, as in 3DGS".split()
    assert noted[1:] == [["version", "9"], ["a", "b", "1"], ["a", "b", "2"]]
    assert ["notes", "of"] not in [
        line[:2] for line in lines_of_info({}, tmp_path / "n.mgs", capsys)
    ]


def test_notes_are_printed_without_markup_and_marks_of_direction(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    marks = [*range(0x202A, 0x202F), *range(0x2066, 0x206A), 0x200E, 0x200F, 0x061C]
    notes: dict = {f"a{mark:x}{chr(mark)}": f"x{chr(mark)}y" for mark in marks}
    notes |= {"[/x]": 1, "[bold]by": "[link=https://example.org]me", "z": "[red]"}
    shown = lines_of_info(notes, tmp_path / "notes.mgs", capsys)
    for mark in marks:
        assert [f"a{mark:x}", "xy"] in shown
    for line in (["[/x]", "1"], ["[bold]by", "[link=https://example.org]me"], ["z", "[red]"]):
        assert line in shown


def short_of_memory() -> None:
    raise MemoryError


def much_too_large() -> None:
    torch.empty(1 << 45)


@pytest.mark.parametrize("ask", [short_of_memory, much_too_large])
def test_too_little_memory_gives_one_line(
    ask, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_file, "read_mgs", lambda path: ask())
    words = ["eval", str(CONFORMANCE / "nvq_one.mgs"), "--capture", str(CONFORMANCE)]
    assert main(words) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err == "mobilegs: there is not enough memory for this\n"


def test_other_errors_of_torch_are_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> None:
        raise RuntimeError("the sizes of tensors must match")

    monkeypatch.setitem(VERBS, "doctor", broken)
    with pytest.raises(RuntimeError, match="must match"):
        main(["doctor"])
