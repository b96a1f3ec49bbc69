"""Lists become rows, or a sentence for every fault."""

import csv
import json
import shutil
from pathlib import Path

import pytest

from mobilegs.batch.columns import all_columns, command_of, exports_of, run_of
from mobilegs.batch.rows import Row, read_list
from mobilegs.capture import CaptureRun
from mobilegs.errors import InputError
from mobilegs.pipeline.compress import CompressRun
from mobilegs.pipeline.options import TrainRun


@pytest.fixture
def folder(capture: Path, finished: Path, tmp_path: Path) -> Path:
    """A folder with a capture, photos, a scene and a file that is none of them."""
    shutil.copytree(capture, tmp_path / "garden")
    photos = tmp_path / "old town"
    photos.mkdir()
    for photo in sorted((capture / "images").iterdir())[:3]:
        (photos / photo.name).write_bytes(photo.read_bytes())
    (tmp_path / "tree.ply").write_bytes((finished / "teacher.ply").read_bytes())
    (tmp_path / "notes.txt").write_text("nothing")
    return tmp_path


def written(folder: Path, text: str, name: str = "list.csv") -> Path:
    (folder / name).write_text(text)
    return folder / name


def faults(path: Path, defaults: dict[str, str] | None = None) -> list[str]:
    with pytest.raises(InputError) as caught:
        read_list(path, defaults or {})
    return str(caught.value).splitlines()


def test_csv_json_lines_and_a_folder_give_the_same_rows(folder: Path) -> None:
    table = written(folder, "source,seed\ngarden,3\nold town,\ntree.ply,\n")
    lines = [{"source": "garden", "seed": 3}, {"source": "old town"}, {"source": "tree.ply"}]
    listed = written(folder, "\n".join(map(json.dumps, lines)) + "\n", "list.jsonl")
    own = folder / "own"
    own.mkdir()
    for name in ("garden", "old town"):
        shutil.copytree(folder / name, own / name)
    shutil.copyfile(folder / "tree.ply", own / "tree.ply")
    of_csv = read_list(table, {})
    assert of_csv == read_list(listed, {})
    assert [row.name for row in of_csv] == ["garden", "old-town", "tree"]
    assert [row.options for row in of_csv] == [{"seed": "3"}, {}, {}]
    assert [row.name for row in read_list(own, {})] == [row.name for row in of_csv]
    assert read_list(own, {})[1].source == str(own / "old town")


def test_addresses_of_files_are_paths(folder: Path) -> None:
    address = (folder / "old town").as_uri()  # with %20
    rows = [{"source": address}, {"source": address.replace("///", "//localhost/"), "name": "b"}]
    rows.append({"source": "tree.ply", "capture": (folder / "garden").as_uri(), "title": address})
    listed = written(folder, "\n".join(map(json.dumps, rows)), "list.jsonl")
    one, other, scene = read_list(listed, {})
    assert one.source == other.source == str(folder / "old town") and one.name == "old-town"
    assert scene.options["capture"] == str(folder / "garden")
    assert scene.options["title"] == address


def test_defaults_fill_empty_columns_where_they_apply(folder: Path) -> None:
    table = written(folder, "source,steps\ngarden,50\ntree.ply,\n")
    defaults = {"steps": "70", "views": "16", "max_splats": "90", "export": "site ply"}
    capture, scene = read_list(table, defaults)
    assert capture.options == {"steps": "50", "max_splats": "90", "export": "site ply"}
    assert scene.options == {"steps": "70", "views": "16", "export": "site ply"}
    assert faults(table, {"stesp": "1"})[0].startswith("there is no column 'stesp': did you mean")


def test_columns_become_options_of_the_runs(folder: Path) -> None:
    lines = [
        {
            "source": "garden",
            "minutes": 2.5,
            "background": [1, 1, 0.5],
            "set": ["student.lr.opacities=0.02", "teacher.min_views=0"],
            "export": ["ply", "html"],
        },
        {"source": "tree.ply", "capture": "garden", "target_mb": 1},
        {"source": "old town", "rig": True, "lens": "opencv"},
    ]
    listed = written(folder, "\n".join(map(json.dumps, lines)), "list.jsonl")
    one, other, photos = read_list(listed, {})
    run = run_of(TrainRun, one.options, capture=Path("a"), output=Path("b"))
    assert run.minutes == 2.5 and run.background == (1.0, 1.0, 0.5)
    assert run.settings == (("student.lr.opacities=0.02", "teacher.min_views=0"),)
    assert exports_of(one.options) == ["html", "ply"]
    compress = run_of(CompressRun, other.options, scene=Path("a"), output=Path("b"))
    assert compress.capture == folder / "garden" and compress.target_mb == 1.0
    rig = run_of(CaptureRun, photos.options, source=Path("a"), output=Path("b"))
    assert rig.rig is True and rig.lens == "opencv"
    words = command_of("capture", one.source, Path("out"), one.options)
    assert words[:5] == ["mobilegs", "train", str(folder / "garden"), "-o", "out"]
    assert words[words.index("--background") + 1 :][:3] == ["1", "1", "0.5"]
    assert words[words.index("--set") + 1 :] == list(run.settings[0])


FAULTS = [
    ("nothing", {}, "nothing does not exist"),
    ("notes.txt", {}, "is neither a capture, photos, a video nor a scene"),
    ("garden", {"steps": "many"}, "steps is a whole number, not 'many'"),
    ("garden", {"steps": "1"}, "1 steps are too few"),
    ("garden", {"minutes": "5", "steps": "50"}, "steps decides the length of the run"),
    ("garden", {"preset": "cup"}, "preset is one of demo, short, long, paper, release"),
    ("old town", {"rig": "maybe"}, "rig is true or false, not 'maybe'"),
    ("old town", {"min_placed": "2"}, "--min-placed must lie between 0 and 1"),
    ("garden", {"background": "1 1"}, "background is 3 numbers, not '1 1'"),
    ("garden", {"views": "16"}, "'views' does not apply to a capture: leave it empty"),
    ("tree.ply", {"method": "mcmc"}, "'method' does not apply to a trained scene"),
    ("garden", {"set": "student.lr.opacitis=3"}, "there is no 'opacitis': did you mean"),
    ("tree.ply", {"set": "student.lr=x"}, "student.lr"),
    ("garden", {"set": "student.lr='3"}, "set is PATH=VALUE ..., not 'student.lr='3'"),
    ("tree.ply", {"capture": "nothing"}, "nothing, which does not exist"),
    ("tree.ply", {"downscale": "2"}, "--downscale is for the photos of --capture: use --size"),
    ("garden", {"export": "pdf"}, "there is no export 'pdf': use some of html, site"),
    ("s4://bucket/a", {}, "has an unknown kind of address: 's4'"),
    ("file://nas/a", {}, "file://nas/a names the machine 'nas': write file:///PATH"),
    ("", {}, "there is no source: give a path or an address"),
]


def test_a_fault_is_a_sentence_with_the_number_of_its_row(folder: Path) -> None:
    rows = [{"name": "first", "source": "garden"}]
    rows += [
        {"name": f"row-{i}", "source": source, **columns}
        for i, (source, columns, _) in enumerate(FAULTS)
    ]
    columns = list(dict.fromkeys(name for row in rows for name in row))
    with (folder / "list.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, columns)
        table.writeheader()
        table.writerows(rows)
    found = faults(folder / "list.csv")
    assert len(found) == len(FAULTS)
    for number, (fault, (_, _, says)) in enumerate(zip(found, FAULTS, strict=True), 2):
        assert fault.startswith(f"row {number} of list.csv: ") and says in fault


def test_names_that_no_folder_can_have_are_refused(folder: Path) -> None:
    text = "source,name\ngarden,../a\ngarden,cache\ngarden,b\n"
    first, second = faults(written(folder, text))
    assert "row 1 of list.csv: '../a' cannot be the name of a folder" in first
    assert "row 2 of list.csv: the name 'cache' is taken by the batch" in second


def test_all_faults_are_named_at_once(folder: Path) -> None:
    text = "source,name\ngarden,a\nnothing,b\nold town,A\ntree.ply,c\nno,d\n"
    found = faults(written(folder, text))
    assert [line.split(":")[0] for line in found] == [
        f"row {number} of list.csv" for number in (2, 3, 5)
    ]
    assert found[1].endswith("row 1 has the name 'A', too")
    many = "source\n" + "nothing\n" * 30
    assert len(faults(written(folder, many))) == 21


def test_a_list_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    for name, content, says in (
        ("list.txt", b"", "is no list: give a .csv, a .jsonl or a folder"),
        ("list.csv", b"", "has no rows"),
        ("list.csv", b"source\n", "has no rows"),
        ("list.csv", b"source,source\na,b\n", "has the column 'source' twice"),
        ("list.csv", b"source,stesp\na,5\n", "there is no column 'stesp': did you mean 'steps'?"),
        ("list.csv", b"source\na,b\n", "line 2: 'b' has no column"),
        ("list.csv", b"source\n\xff\n", "is not text in UTF-8"),
        ("list.jsonl", b"{}\n[]\n", "line 2: give an object like"),
        ("list.jsonl", b"{\n", "line 1: this is not JSON"),
    ):
        (tmp_path / name).write_bytes(content)
        found = faults(tmp_path / name)
        assert any(says in line for line in found), (content, found)


def test_a_capture_is_not_taken_for_a_folder_of_captures(capture: Path) -> None:
    assert "is one capture: give the folder around it" in faults(capture)[0]


def test_every_column_has_the_name_of_an_option() -> None:
    names = all_columns()
    assert {"name", "source", "export", "title", "set", "lens", "views", "minutes"} <= set(names)
    assert not {"output", "resume", "device", "live", "settings"} & set(names)
    assert len(names) == len(set(names))


def test_values_that_are_no_text_are_refused(folder: Path) -> None:
    listed = written(folder, json.dumps({"source": "garden", "seed": {"a": 1}}), "list.jsonl")
    assert "seed is {" in faults(listed)[0]
    assert isinstance(read_list(written(folder, "source\ngarden\n"), {})[0], Row)
