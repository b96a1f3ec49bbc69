"""The columns of a batch's list: options of captures, trainings and exports, read from texts.

A column is a field of `CaptureRun`, `TrainRun` or `CompressRun` under the name of its option, with
underscores: `max_splats`, `set`. `export` and `title` are those of `mobilegs export`.
"""

import os
import re
import shlex
import types
from collections.abc import Collection, Mapping
from dataclasses import fields
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from mobilegs.batch.fetch import is_address
from mobilegs.batch.row_folder import Kind
from mobilegs.capture import CaptureRun, is_capture_source
from mobilegs.capture.run import validate_options
from mobilegs.data import has_poses
from mobilegs.errors import InputError
from mobilegs.formats import Export
from mobilegs.pipeline.compress import CompressRun
from mobilegs.pipeline.train import TrainRun, budget_of, resolve_recipe
from mobilegs.scene_file import PLAIN

Options = Mapping[str, str]  # texts by column
EXPORTS: tuple[Export, ...] = get_args(Export)
OF_THE_LIST = ("name", "source")
OF_THE_EXPORT = ("export", "title")
# fields that the batch gives itself
OWN = (
    "source", "output", "resume", "device", "lpips_weights", "live", "live_at",
)  # fmt: skip
RUNS: dict[Kind, tuple[type, ...]] = {
    "capture": (TrainRun,),
    "photos": (CaptureRun, TrainRun),
    "scene": (CompressRun,),
}
WHAT: dict[Kind, str] = {
    "capture": "a capture",
    "photos": "photos without poses",
    "scene": "a trained scene",
}


def kind_of(path: Path) -> Kind:
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
def columns_of(run: type) -> dict[str, Any]:
    """Return the type of every column that stands for a field of `run`."""
    hints = get_type_hints(run)
    own = (*OWN, "capture") if run is TrainRun else (*OWN, "scene")
    named = {"set" if f.name == "settings" else f.name: hints[f.name] for f in fields(run)}
    return {name: hint for name, hint in named.items() if name not in own}


def all_columns() -> list[str]:
    """Return the names of all columns of a list."""
    found = dict.fromkeys((*OF_THE_LIST, *OF_THE_EXPORT))
    for runs in RUNS.values():
        for run in runs:
            found |= dict.fromkeys(columns_of(run))
    return list(found)


def unknown_column(name: str) -> str:
    """Return a sentence about a column that does not exist."""
    near = get_close_matches(name, all_columns(), n=1)
    hint = f"did you mean '{near[0]}'?" if near else f"there are {', '.join(all_columns())}"
    return f"there is no column '{name}': {hint}"


def applies(name: str, kind: Kind) -> bool:
    """Return True if a column is an option of the runs of a kind of row."""
    return name in OF_THE_EXPORT or any(name in columns_of(run) for run in RUNS[kind])


def validate_row(options: Options, own: Collection[str], kind: Kind | None) -> None:
    """Raise InputError for options that the runs of a row would refuse.

    `own` are the columns that the row itself gives. `kind` is None for a source that is not
    fetched yet. The machine that validates need not be the one that trains, so nothing is asked of
    its devices.
    """
    exports_of(options)
    for name in options:
        if kind is not None and name in own and not applies(name, kind):
            raise InputError(f"'{name}' does not apply to {WHAT[kind]}: leave it empty")
        for run in (CaptureRun, TrainRun, CompressRun):
            if name in columns_of(run):
                parsed(name, options[name], columns_of(run)[name])
    if kind == "photos":
        validate_options(run_of(CaptureRun, options, source=Path("."), output=Path(".")))
    if kind == "capture" or kind == "photos":
        run = run_of(TrainRun, options, capture=Path("."), output=Path("."), device="cpu")
        if run.recipe is None:
            budget_of(run)
            resolve_recipe(run)
    elif kind == "scene":
        scene = run_of(CompressRun, options, scene=Path("."), output=Path("."))
        settings = scene.settings
        if scene.steps is not None:
            settings = (*settings, (f"student.steps={scene.steps}",))
        same = {"minutes": scene.minutes, "preset": scene.preset, "seed": scene.seed}
        training = TrainRun(Path("."), Path("."), device="cpu", settings=settings, **same)
        budget_of(training)
        resolve_recipe(training)


def run_of(run: type, options: Options, **given: Any) -> Any:
    """Return a `run`, a dataclass of options, with the columns that are its fields."""
    values = {
        "settings" if name == "set" else name: parsed(name, options[name], hint)
        for name, hint in columns_of(run).items()
        if name in options
    }
    return run(**values, **given)


def exports_of(options: Options) -> list[Export]:
    """Return the kinds of exports of a row; a page in one file by default."""
    kinds = options.get("export", "html").split()
    for kind in kinds:
        if kind not in EXPORTS:
            raise InputError(f"there is no export '{kind}': use some of {', '.join(EXPORTS)}")
    return [kind for kind in EXPORTS if kind in kinds]


def parsed(name: str, text: str, hint: Any) -> Any:
    """Return the value of a column as its option's type; raises InputError if it has another."""
    if get_origin(hint) is Annotated:
        hint = get_args(hint)[0]
    if get_origin(hint) in (Union, types.UnionType):
        [hint] = [each for each in get_args(hint) if each is not type(None)]
    if get_origin(hint) is Literal:
        if text not in get_args(hint):
            raise InputError(f"{name} is one of {', '.join(get_args(hint))}, not '{text}'")
        return text
    if hint is bool:
        if text.lower() not in ("true", "false"):
            raise InputError(f"{name} is true or false, not '{text}'")
        return text.lower() == "true"
    if hint in (int, float):
        try:
            return hint(text)
        except ValueError:
            kind = "a whole number" if hint is int else "a number"
            raise InputError(f"{name} is {kind}, not '{text}'") from None
    if name == "set":
        return (tuple(shlex.split(text)),)
    if get_origin(hint) is tuple:
        parts = re.split(r"[\s,]+", text.strip())
        if len(parts) != len(get_args(hint)):
            raise InputError(f"{name} is {len(get_args(hint))} numbers, not '{text}'")
        return tuple(parsed(name, part, float) for part in parts)
    if hint is Path:
        if not Path(text).exists():
            raise InputError(f"{name} is {text}, which does not exist")
        return Path(text)
    return text


def path_columns() -> set[str]:
    """Return the columns that are paths, which are relative to the list."""
    found = {"source"}
    for run in (TrainRun, CompressRun):
        found |= {name for name, hint in columns_of(run).items() if Path in (hint, *get_args(hint))}
    return found


def command_of(kind: Kind, source: str, output: Path, options: Options) -> list[str]:
    """Return the words of the single command that trains the scene of a row."""
    verb = "compress" if kind == "scene" else "train"
    words = ["mobilegs", verb, source, "-o", str(output)]
    run = CompressRun if kind == "scene" else TrainRun
    for name, hint in columns_of(run).items():
        if name in options:
            value = parsed(name, options[name], hint)
            words.append(f"--{name.replace('_', '-')}")
            if name == "set":
                words += value[0]
            elif isinstance(value, tuple):
                words += [f"{part:g}" for part in value]
            elif value is not True:
                words.append(options[name])
    return words


def absolute(name: str, text: str, folder: Path) -> str:
    """Return a source or another path of a list in `folder` as an absolute path or an address."""
    if name not in path_columns() or is_address(text):
        return text.removeprefix("file://")
    return os.path.abspath(folder / Path(text).expanduser())  # a link keeps its name
