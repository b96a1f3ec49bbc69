"""Notes of a file: texts within the format's limits, which parse back to what was given."""

import json

import numpy as np
import pytest

from mobilegs.edit.notes import (
    annotation_notes,
    continued_note,
    line_of_text,
    merged_notes,
    parsed_annotations,
    parsed_path,
    path_notes,
    start_text,
)
from mobilegs.errors import InputError
from mobilegs.mgs.limits import TEXT_MAX, check_meta
from mobilegs.viewpoints.framing import Start, parsed_start


def test_a_start_view_parses_back() -> None:
    start = Start(np.array([1e-5, -2.5, 3]), np.array([0.0, 0, 1e6]), (0.4, 0.3))
    found = parsed_start(start_text(start))
    assert found is not None and found.text == start.text
    assert found.eye == pytest.approx(start.eye) and found.box == start.box


@pytest.mark.parametrize("box", [(0.0, 1.0), (1.0, -1.0), (1e4, 1.0)])
def test_a_start_view_without_a_picture_is_refused(box: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="tangents"):
        start_text(Start(np.ones(3), np.zeros(3), box))


def test_annotations_continue_in_further_notes() -> None:
    given = [{"at": [i, 0.1, -2], "text": f'"{i}"\nü' * 40, "eye": [0, 0, i]} for i in range(90)]
    del given[3]["eye"]
    annotations = parsed_annotations(given)
    notes = annotation_notes(annotations)
    assert list(notes)[:2] == ["annotations", "annotations.2"]
    assert all(len(text) <= TEXT_MAX for text in notes.values())
    check_meta(notes)
    lists = [json.loads(text) for text in continued_note(notes, "annotations")]
    assert parsed_annotations([one for part in lists for one in part]) == annotations
    assert annotations[3].eye is None


def test_a_path_continues_in_further_notes() -> None:
    given = [[i / 7, 0, 0, i, 1, 0] for i in range(300)]
    notes = path_notes(parsed_path(given))
    assert "path.2" in notes
    check_meta(notes)
    texts = continued_note(notes, "path")
    poses = [[float(word) for word in pose.split()] for t in texts for pose in t.split(";")]
    assert poses == [pytest.approx(pose, rel=1e-5) for pose in given]


def test_notes_are_merged_removed_and_replaced_with_their_continuations() -> None:
    old = {"title": "a", "path": "1", "path.2": "2", "annotations": "[]", "annotations.2": "[]"}
    merged = merged_notes(old | {"n": 3}, {"title": "", "path": "4", "credit": "me"})
    assert merged == {
        "path": "4",
        "annotations": "[]",
        "annotations.2": "[]",
        "n": 3,
        "credit": "me",
    }
    framed = {"up": "0 -1 0", "start": "s", "limits": "l", "limits_portrait": "p"}
    assert merged_notes(framed, {"up": "0 0 1"}) == {"up": "0 0 1", "start": "s"}
    assert merged_notes(framed, {"up": "0 -1 0"}) == framed
    assert merged_notes(framed, {"up": "0 0 1", "limits": "none"})["limits"] == "none"
    assert merged_notes(old, annotation_notes([])) == {"title": "a", "path": "1", "path.2": "2"}


def test_too_many_notes_are_refused() -> None:
    with pytest.raises(InputError, match="64 notes"):
        merged_notes({str(i): "x" for i in range(64)}, {"title": "a"})


def test_titles_are_one_line() -> None:
    assert line_of_text("  A garden ", "title") == "A garden"
    for text in ("two\nlines", "x" * 201, "\x1b[31m"):
        with pytest.raises(InputError, match="the title must be one line"):
            line_of_text(text, "title")


@pytest.mark.parametrize(
    "item",
    [
        {"at": [0, 0, 0]},
        {"at": [0, 0, True], "text": "a"},
        {"at": [0, 0, 0], "text": "a", "eye": "b"},
        {"at": [0, 0, 0], "text": "  "},
        {"at": [0, 0, 0], "text": "x" * 1001},
        {"at": [0, 0, 0], "text": "\ud800"},
    ],
)
def test_other_annotations_are_refused(item: object) -> None:
    with pytest.raises(InputError, match="annotation 1"):
        parsed_annotations([item])


@pytest.mark.parametrize("path", [None, [[0] * 6], [[0] * 6, [1, 2]]])
def test_other_paths_are_refused(path: object) -> None:
    with pytest.raises(InputError, match="camera path"):
        parsed_path(path)
