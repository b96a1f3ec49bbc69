"""Cells of the paper's tables: their identity, their folders, and how they are collected.

A cell is one row on one scene with one seed. Its folder is called ROW-STEPS-SEED, a teacher's
teacher-METHOD-STEPS-SEED. STEPS counts both stages. A suffix follows for everything that is not
the default: `-t5000` (steps of the teacher), `-standard` (protocol), `-teacher1` (seed of the
teacher), and eight hexadecimal digits for other settings of `--set`. settings.json in the folder
has all settings; a folder with other settings is refused.
"""

import argparse
import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path

import torch

from bench.paper.captures import CAPTURES, BenchCapture
from bench.paper.rows import ROWS, Row
from mobilegs.atomic import atomic_write
from mobilegs.errors import InputError
from mobilegs.train.recipes import (
    CLASSIC_STUDENT,
    CLASSIC_TEACHER,
    RECIPES,
    Recipe,
    with_method,
    with_settings,
    with_steps,
)

LENGTHS = ("teacher.steps", "student.steps")  # names and keys have these anyway
SETTINGS, CELL, ERROR = "settings.json", "cell.json", "error.txt"


def recipe_of(place: BenchCapture, row: Row, options: argparse.Namespace) -> Recipe:
    """Return the preset changed by the capture, `--steps`, the row and `--set`, in this order.

    Classic rows cover pixels as 3DGS does, so that they can share a teacher.
    """
    recipe = with_method(RECIPES[place.preset](), row.teacher)
    if row.classic:
        recipe = with_settings(recipe, (*CLASSIC_TEACHER, *CLASSIC_STUDENT))
    recipe = with_settings(recipe, place.settings)
    if row.teacher == "3dgs":
        recipe = with_settings(recipe, place.settings_3dgs)
    if options.steps:
        recipe = with_steps(recipe, options.steps)
    metric = f"teacher.importance={place.metric}"
    return with_settings(recipe, (metric, *row.settings, *options.set))


def steps_of(name: str, recipe: Recipe) -> tuple[int, int]:
    """Return the steps of the teacher, and of the student if the row has one."""
    return recipe.teacher.steps, recipe.student.steps if ROWS[name].student else 0


def changed_settings(options: argparse.Namespace, *, student: bool) -> dict[str, str]:
    """Return what `--set` changes except lengths, by path: of the teacher, or of both stages."""
    found = {}
    for setting in options.set:
        path, _, value = setting.partition("=")
        path = path.strip().replace("-", "_")
        if path not in LENGTHS and (student or path.startswith("teacher.")):
            found[path] = value.strip()
    return dict(sorted(found.items()))


def suffixes(protocol: str, teacher_seed: int, settings: Mapping[str, str]) -> list[str]:
    """Return the words for everything that is not the default, for folder names and keys."""
    words = [] if protocol == "paper" else [protocol]
    words += [f"teacher{teacher_seed}"] if teacher_seed else []
    text = json.dumps(dict(sorted(settings.items())))
    return words + ([hashlib.sha256(text.encode()).hexdigest()[:8]] if settings else [])


def folder_of(
    name: str, scene: str, place: BenchCapture, seed: int, options: argparse.Namespace
) -> Path:
    """Return a cell's folder."""
    row = ROWS[name]
    teacher, student = steps_of(name, recipe_of(place, row, options))
    plain = argparse.Namespace(steps=None, set=())
    usual, _ = steps_of(name, recipe_of(place, row, plain))
    words = [name, str(teacher + student), str(seed)]
    words += [f"t{teacher}"] if row.student and teacher != usual else []
    teacher_seed = options.teacher_seed if row.student else 0
    words += suffixes(place.protocol, teacher_seed, changed_settings(options, student=row.student))
    return options.runs / scene / "-".join(words)


def teacher_folder(
    row: Row, scene: str, place: BenchCapture, seed: int, steps: int, options: argparse.Namespace
) -> Path:
    """Return a teacher's folder; rows with the same teacher share it."""
    words = ["teacher", row.teacher, str(steps), str(seed)]
    words += [] if row.classic else ["default"]
    words += suffixes(place.protocol, 0, changed_settings(options, student=False))
    return options.runs / scene / "-".join(words)


def cell_identity(
    name: str, scene: str, place: BenchCapture, seed: int, options: argparse.Namespace
) -> dict[str, object]:
    """Return the fields of a cell that are known before it is measured."""
    student = ROWS[name].student
    teacher_steps, student_steps = steps_of(name, recipe_of(place, ROWS[name], options))
    return {
        "scene": scene,
        "row": name,
        "seed": seed,
        "protocol": place.protocol,
        "teacher_steps": teacher_steps,
        "student_steps": student_steps,
        **({"teacher_seed": options.teacher_seed} if student else {}),
        "settings": changed_settings(options, student=student),
    }


def is_done(folder: Path, of: Mapping[str, object], recipe: dict) -> bool:
    """Return whether a cell is there.

    Raises InputError if the folder holds a cell with another identity or recipe. Fields that
    older cells lack count as the default.
    """
    path = folder / CELL
    if not path.exists():
        return False
    found = {"protocol": "paper", "teacher_seed": 0, "settings": {}, **json.loads(path.read_text())}
    other = [name for name, value in of.items() if found[name] != value]
    if other:
        raise InputError(f"{path} is a cell with another {', '.join(other)}: {MOVE_IT}")
    validate_folder(folder, recipe)
    return True


MOVE_IT = "move the folder away, or give another one with --runs"


def validate_folder(folder: Path, recipe: dict) -> None:
    """Raise InputError if a folder was begun with other settings; one without settings passes."""
    path = folder / SETTINGS
    if not path.exists():
        return
    found, wanted = dict(_flat(json.loads(path.read_text()))), dict(_flat(recipe))
    if "student.steps" in found and not {*wanted} <= {*found}:
        raise InputError(f"{folder} was begun by a version with other settings: {MOVE_IT}")
    other = [name for name in wanted if name in found and found[name] != wanted[name]]
    if other:
        told = ", ".join(f"{name} {found[name]} and not {wanted[name]}" for name in other[:4])
        raise InputError(f"{folder} was begun with {told}: {MOVE_IT}")


def begin_folder(folder: Path, recipe: dict) -> None:
    """Write the settings into a new folder; raises InputError if it has others."""
    validate_folder(folder, recipe)
    new = not folder.exists() or not any(folder.iterdir())
    folder.mkdir(parents=True, exist_ok=True)
    if new:
        atomic_write(folder / SETTINGS, json.dumps(recipe, indent=1) + "\n")


def as_json(recipe: Recipe, row: Row, **more: object) -> dict:
    """Return everything that the contents of a folder depend on, as JSON values."""
    content = asdict(recipe)
    if row.student:
        content["method"] = asdict(row.method)
    else:
        del content["student"]
    return json.loads(json.dumps({**more, **content}))


def _flat(content: object, path: str = "") -> Iterator[tuple[str, object]]:
    if isinstance(content, dict):
        for name, value in content.items():
            yield from _flat(value, f"{path}.{name}" if path else name)
    else:
        yield path, content


def key_of(cell: Mapping) -> str:
    """Return the key of a cell among the cells of all scenes."""
    steps = f"{cell['teacher_steps']}+{cell['student_steps']}"
    seed = cell.get("teacher_seed", 0)
    words = suffixes(cell.get("protocol", "paper"), seed, cell.get("settings", {}))
    return "/".join([cell["scene"], steps, cell["row"], str(cell["seed"]), *words])


def collect(runs: Path, out: Path) -> None:
    """Write all cells under RUNS into OUT, in addition to those that OUT has."""
    before = json.loads(out.read_text())["cells"].values() if out.exists() else []
    found = [json.loads(path.read_text()) for path in sorted(runs.glob(f"*/*/{CELL}"))]
    cells = {key_of(cell): cell for cell in (*before, *found)}
    ordered = dict(sorted(cells.items()))
    atomic_write(out, json.dumps({"cells": ordered, "torch": torch.__version__}, indent=1) + "\n")


def scenes_of(group: str) -> list[str]:
    """Return the scenes of a group."""
    return [name for name, place in CAPTURES.items() if place.group == group]
