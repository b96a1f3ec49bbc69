"""The columns of a batch's list: options of captures, trainings and exports, read from texts.

A column is a field of `CaptureRun`, `TrainRun` or `CompressRun` under the name of its option, with
underscores: `max_splats`, `set`. The command line's parser reads its text. `export` and `title` are
those of `mobilegs export`.
"""

import os
import re
import shlex
from collections.abc import Collection, Mapping
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_type_hints
from urllib.parse import urlsplit
from urllib.request import url2pathname

from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from mobilegs.batch.fetch import is_address
from mobilegs.batch.row_folder import RowKind
from mobilegs.capture import CaptureRun, is_capture_source
from mobilegs.capture.run import validate_options
from mobilegs.data import has_poses
from mobilegs.errors import InputError
from mobilegs.formats import Export
from mobilegs.pipeline.compress import CompressRun, training_of
from mobilegs.pipeline.options import TrainRun, budget_of, resolve_recipe
from mobilegs.scene_file import PLAIN

Options = Mapping[str, str]  # texts by column
EXPORTS: tuple[Export, ...] = get_args(Export)
LIST_COLUMNS = ("name", "source")
EXPORT_COLUMNS = ("export", "title")
# fields that the batch gives itself
BATCH_FIELDS = (
    "source", "output", "resume", "device", "lpips_weights", "live", "live_at",
)  # fmt: skip
RUNS: dict[RowKind, tuple[type, ...]] = {
    "capture": (TrainRun,),
    "photos": (CaptureRun, TrainRun),
    "scene": (CompressRun,),
}
TYPE_WORDS = {  # by tyro's description of a type
    "INT": "a whole number",
    "FLOAT": "a number",
    "FLOAT FLOAT FLOAT": "3 numbers",
    "{True,False}": "true or false",
}
KIND_WORDS: dict[RowKind, str] = {
    "capture": "a capture",
    "photos": "photos without poses",
    "scene": "a trained scene",
}


def kind_of(path: Path) -> RowKind:
    """Return what lies at `path`; raises InputError for anything that no scene can be made of."""
    if not path.exists():
        raise InputError(f"{path} does not exist")
    if path.suffix.lower() in PLAIN or (path / "meta.json").is_file():
        return "scene"
    if has_poses(path):
        return "capture"
    if is_capture_source(path):
        return "photos"
    raise InputError(
        f"{path} is neither a capture, photos, a video nor a scene ({', '.join(PLAIN)})"
    )


@cache
def columns_of(run: type) -> dict[str, PrimitiveConstructorSpec]:
    """Return the command line's parser for every column that stands for a field of `run`."""
    own = (*BATCH_FIELDS, "capture" if run is TrainRun else "scene")
    parsers = {}
    for name, hint in get_type_hints(run).items():
        if name not in own:
            if NoneType in get_args(hint):  # a text is a value
                [hint] = [part for part in get_args(hint) if part is not NoneType]
            parser = ConstructorRegistry.get_primitive_spec(PrimitiveTypeInfo.make(hint, set()))
            assert isinstance(parser, PrimitiveConstructorSpec)
            parsers["set" if name == "settings" else name] = parser
    return parsers


@cache
def run_columns() -> dict[str, PrimitiveConstructorSpec]:
    """Return the columns of all runs; those of the same name have the same type."""
    return columns_of(TrainRun) | columns_of(CaptureRun) | columns_of(CompressRun)


def all_columns() -> list[str]:
    return [*LIST_COLUMNS, *EXPORT_COLUMNS, *run_columns()]


def unknown_column(name: str) -> str:
    """Return a sentence about a column that does not exist."""
    near = get_close_matches(name, all_columns(), n=1)
    hint = f"did you mean '{near[0]}'?" if near else f"there are {', '.join(all_columns())}"
    return f"there is no column '{name}': {hint}"


def applies(name: str, kind: RowKind) -> bool:
    """Return True if a column is an option of the runs of a kind of row."""
    return name in EXPORT_COLUMNS or any(name in columns_of(run) for run in RUNS[kind])


def validate_row(options: Options, own: Collection[str], kind: RowKind | None) -> None:
    """Raise InputError for options that the runs of a row would refuse.

    `own` are the columns that the row itself gives. `kind` is None for a source that is not
    fetched yet. The machine that validates need not be the one that trains, so nothing is asked of
    its devices.
    """
    exports_of(options)
    for name in options:
        if kind is not None and name in own and not applies(name, kind):
            raise InputError(f"'{name}' does not apply to {KIND_WORDS[kind]}: leave it empty")
        if name in run_columns():
            parsed(name, options[name])
    if kind is None:
        return
    here = Path(".")
    if kind == "photos":
        validate_options(run_of(CaptureRun, options, source=here, output=here))
    if kind == "scene":
        run = training_of(run_of(CompressRun, options, scene=here, output=here, device="cpu"))
    else:
        run = run_of(TrainRun, options, capture=here, output=here, device="cpu")
    if run.recipe is None:
        budget_of(run)
        resolve_recipe(run)


def run_of(run: type, options: Options, **given: Any) -> Any:
    """Return a `run`, a dataclass of options, with the columns that are its fields."""
    values = {name: parsed(name, options[name]) for name in columns_of(run) if name in options}
    if "set" in values:
        values["settings"] = values.pop("set")
    return run(**values, **given)


def exports_of(options: Options) -> list[Export]:
    """Return the kinds of exports of a row; a page in one file by default."""
    kinds = options.get("export", "html").split()
    for kind in kinds:
        if kind not in EXPORTS:
            raise InputError(f"there is no export '{kind}': use some of {', '.join(EXPORTS)}")
    return [kind for kind in EXPORTS if kind in kinds]


def parsed(name: str, text: str) -> Any:
    """Return the value of a column; raises InputError if its option does not take the text."""
    parser = run_columns()[name]
    try:
        words = words_of(name, text)
        if parser.nargs not in ("*", len(words)) or not {*words} <= {*(parser.choices or words)}:
            raise ValueError
        value = parser.instance_from_str(words)
    except ValueError:
        choices = parser.choices and f"one of {', '.join(parser.choices)}"
        allowed = TYPE_WORDS.get(parser.metavar) or choices or "PATH=VALUE ..."
        raise InputError(f"{name} is {allowed}, not '{text}'") from None
    if isinstance(value, Path) and not value.exists():
        raise InputError(f"{name} is {text}, which does not exist")
    return value


def words_of(name: str, text: str) -> list[str]:
    """Return the words of the command line for the text of a column."""
    if name == "set":
        return shlex.split(text)
    parser = run_columns()[name]
    if parser.nargs != 1:
        return re.split(r"[\s,]+", text.strip())
    return [text.capitalize() if parser.metavar == "{True,False}" else text]


def path_columns() -> set[str]:
    """Return the columns that are paths, which are relative to the list."""
    return {"source", *(name for name, parser in run_columns().items() if parser.metavar == "PATH")}


def command_of(kind: RowKind, source: str, output: Path, options: Options) -> list[str]:
    """Return the words of the single command that trains the scene of a row."""
    verb = "compress" if kind == "scene" else "train"
    words = ["mobilegs", verb, source, "-o", str(output)]
    run = CompressRun if kind == "scene" else TrainRun
    for name in columns_of(run):
        if name in options:
            words += [f"--{name.replace('_', '-')}", *words_of(name, options[name])]
    return words


def absolute(name: str, text: str, folder: Path) -> str:
    """Return a source or another path of a list in `folder` as an absolute path or an address.

    Other columns are returned as they are. Raises InputError for `file://` with another machine.
    """
    if name not in path_columns() or is_address(text):
        return text
    if "://" in text:
        address = urlsplit(text)
        if address.netloc not in ("", "localhost"):
            raise InputError(f"{text} names the machine '{address.netloc}': write file:///PATH")
        text = url2pathname(address.path)
    return os.path.abspath(folder / Path(text).expanduser())  # a link keeps its name
