"""The command line with hostile files."""

import json
import logging
import os
import signal
import sys
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import torch

from mobilegs import scene_file
from mobilegs.cli.main import VERBS, main
from mobilegs.cli.output import print_capture
from mobilegs.errors import UNSEEN
from mobilegs.formats.ply import write_ply
from mobilegs.mgs.codec import inspect_mgs
from mobilegs.progress_display import ProgressLines, printed_log
from tests.support.mgs_parts import parse_parts
from tests.support.random_scenes import random_scene

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
    signal.alarm(60)
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
        escaped = ascii(chr(mark))[1:-1]
        assert [f"a{mark:x}{escaped}", f"x{escaped}y"] in shown
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


def test_a_library_that_cannot_be_loaded_is_a_sentence(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def short() -> None:
        raise ImportError("libx.so: failed to map segment from shared object")

    monkeypatch.setitem(VERBS, "doctor", short)
    assert main(["doctor"]) == 2
    assert "failed to map segment" in capsys.readouterr().err


NAME = "a\x1b[2J\nb\r\u202ec\x9b\u2028[red]d\udcff"


def test_names_reach_the_terminal_escaped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if sys.getfilesystemencoding() == "ascii":
        pytest.skip("needs file names beyond ASCII")
    # pytest-xdist cannot send the log of a test with a name that is not Unicode
    monkeypatch.setattr(logging.getLogger("mobilegs"), "propagate", False)
    scene = tmp_path / f"{NAME}.ply"
    write_ply(scene, random_scene(5, degree=0))
    assert main(["info", str(tmp_path / f"{NAME}.mgs")]) == 2
    assert main(["info", str(scene)]) == 0
    with printed_log():
        logging.getLogger("mobilegs.x").warning("left out %s", NAME)
    with ProgressLines(NAME, sys.stdout):
        pass
    report: Any = {"left_out": [NAME], "unreadable": [NAME], "other_files": {NAME: 1}}
    report |= {"registered": 1, "photos": 2, "points": 1, "reprojection_error": 1.0, "models": []}
    print_capture(report, tmp_path)
    printed = "".join(capsys.readouterr())
    shown = "a\\x1b[2J\\nb\\r\\u202ec\\x9b\\u2028[red]d\\udcff"
    assert printed.count(shown) >= 6 and not UNSEEN.search(printed.replace("\n", ""))
