"""What tells the cells of bench/paper.py apart, where they lie, and how they are put together.

A folder is called ROW-STEPS-SEED, a teacher's teacher-METHOD-STEPS-SEED, with behind it whatever is
not the default: `-t5000` (other steps of the teacher; STEPS are both stages' together), `-standard`
(the protocol), `-teacher1` (its seed) and eight digits of what `--set` changes beside lengths.
settings.json in it says everything; a folder of other settings is refused.
"""

import argparse
import hashlib
import json
import tarfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path

import torch
from paper_places import PLACES, Place
from paper_rows import ROWS, Row

from mobilegs.atomic import atomic_path, atomic_write
from mobilegs.errors import InputError
from mobilegs.train.recipes import RECIPES, Recipe, with_method, with_settings, with_steps

LENGTHS = ("teacher.steps", "student.steps")  # which names and keys have anyway
SETTINGS, CELL, TROUBLE = "settings.json", "cell.json", "error.txt"
PART_BYTES = 15 << 20  # of an archive
NOTES = (CELL, SETTINGS, TROUBLE, "frames.json", "metrics.json")


def recipe_of(place: Place, row: Row, options: argparse.Namespace) -> Recipe:
    """The preset with all that place, `--steps`, row and `--set` change, in this order."""
    recipe = with_method(RECIPES[place.preset](), row.teacher)
    recipe = with_settings(recipe, place.settings)
    if row.teacher == "3dgs":
        recipe = with_settings(recipe, place.of_3dgs)
    if options.steps:
        recipe = with_steps(recipe, options.steps)
    metric = f"teacher.mini_splatting.metric={place.metric}"
    return with_settings(recipe, (metric, *row.settings, *options.set))


def steps_of(name: str, recipe: Recipe) -> tuple[int, int]:
    """Of the teacher, and of the student if the row has one."""
    return recipe.teacher.steps, recipe.student.steps if ROWS[name].student else 0


def asked(options: argparse.Namespace, *, student: bool) -> dict[str, str]:
    """What `--set` changes beside lengths, path by path, of the teacher alone or of both."""
    found = {}
    for setting in options.set:
        path, _, value = setting.partition("=")
        path = path.strip().replace("-", "_")
        if path not in LENGTHS and (student or path.startswith("teacher.")):
            found[path] = value.strip()
    return dict(sorted(found.items()))


def unusual(protocol: str, teacher_seed: int, settings: Mapping[str, str]) -> list[str]:
    """Words for what is not the default, for names and keys."""
    words = [] if protocol == "paper" else [protocol]
    words += [f"teacher{teacher_seed}"] if teacher_seed else []
    text = json.dumps(dict(sorted(settings.items())))
    return words + ([hashlib.sha256(text.encode()).hexdigest()[:8]] if settings else [])


def folder_of(name: str, scene: str, place: Place, seed: int, options: argparse.Namespace) -> Path:
    """Where a cell lies."""
    row = ROWS[name]
    teacher, student = steps_of(name, recipe_of(place, row, options))
    plain = argparse.Namespace(steps=None, set=())
    usual, _ = steps_of(name, recipe_of(place, row, plain))
    words = [name, str(teacher + student), str(seed)]
    words += [f"t{teacher}"] if row.student and teacher != usual else []
    teacher_seed = options.teacher_seed if row.student else 0
    words += unusual(place.protocol, teacher_seed, asked(options, student=row.student))
    return options.runs / scene / "-".join(words)


def teacher_folder(
    row: Row, scene: str, place: Place, seed: int, steps: int, options: argparse.Namespace
) -> Path:
    """Where a teacher lies, whichever rows learn from it."""
    words = ["teacher", row.teacher, str(steps), str(seed)]
    words += unusual(place.protocol, 0, asked(options, student=False))
    return options.runs / scene / "-".join(words)


def about(
    name: str, scene: str, place: Place, seed: int, options: argparse.Namespace
) -> dict[str, object]:
    """What a cell says of itself before it is measured."""
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
        "settings": asked(options, student=student),
    }


def is_done(folder: Path, of: Mapping[str, object], recipe: dict) -> bool:
    """Whether a cell is there; raises InputError if it is another one than `of` and `recipe` say.

    What cells of before do not say counts as the default.
    """
    path = folder / CELL
    if not path.exists():
        return False
    found = {"protocol": "paper", "teacher_seed": 0, "settings": {}, **json.loads(path.read_text())}
    other = [name for name, value in of.items() if found[name] != value]
    if other:
        raise InputError(f"{path} is a cell with another {', '.join(other)}: {OTHERWISE}")
    refuse_other(folder, recipe)
    return True


# what students were before there was a setting for it
BEFORE = {"student.fill_price": 0, "student.distill_between": 0, "student.price_fraction": 1}
OTHERWISE = "move the folder away, or give another one with --runs"


def refuse_other(folder: Path, recipe: dict) -> None:
    """Raise InputError if something else was trained in a folder; one without notes passes."""
    path = folder / SETTINGS
    if not path.exists():
        return
    found, wanted = dict(_flat(json.loads(path.read_text()))), dict(_flat(recipe))
    if "student.steps" in found:
        found = BEFORE | found
    other = [name for name in wanted if name in found and found[name] != wanted[name]]
    if other:
        told = ", ".join(f"{name} {found[name]} and not {wanted[name]}" for name in other[:4])
        raise InputError(f"{folder} was begun with {told}: {OTHERWISE}")


def begin(folder: Path, recipe: dict) -> None:
    """Write down what is trained in a folder; refuses one where something else was."""
    refuse_other(folder, recipe)
    new = not folder.exists() or not any(folder.iterdir())
    folder.mkdir(parents=True, exist_ok=True)
    if new:
        atomic_write(folder / SETTINGS, json.dumps(recipe, indent=1) + "\n")


def as_json(recipe: Recipe, row: Row, **more: object) -> dict:
    """All that a folder's contents depend on, as JSON has it."""
    content = asdict(recipe)
    if not row.student:
        del content["student"]
    return json.loads(json.dumps({**more, **content}))


def _flat(content: object, path: str = "") -> Iterator[tuple[str, object]]:
    if isinstance(content, dict):
        for name, value in content.items():
            yield from _flat(value, f"{path}.{name}" if path else name)
    else:
        yield path, content


def key_of(cell: Mapping) -> str:
    """By what a cell is known among those of all scenes."""
    steps = f"{cell['teacher_steps']}+{cell['student_steps']}"
    seed = cell.get("teacher_seed", 0)
    words = unusual(cell.get("protocol", "paper"), seed, cell.get("settings", {}))
    return "/".join([cell["scene"], steps, cell["row"], str(cell["seed"]), *words])


def collect(runs: Path, out: Path) -> None:
    """All cells under RUNS, and what OUT had beside them, in one file."""
    before = json.loads(out.read_text())["cells"].values() if out.exists() else []
    found = [json.loads(path.read_text()) for path in sorted(runs.glob(f"*/*/{CELL}"))]
    cells = {key_of(cell): cell for cell in (*before, *found)}
    ordered = dict(sorted(cells.items()))
    atomic_write(out, json.dumps({"cells": ordered, "torch": torch.__version__}, indent=1) + "\n")


def pack(runs: Path, folder: Path, *, part_bytes: int = PART_BYTES) -> list[Path]:
    """Archives cells-0.tar, cells-1.tar ... of all that is small under RUNS, and worth keeping.

    Cells, notes and logs come first, then files of scenes, the newest first. Checkpoints and
    teachers stay where they are; so does a scene that is larger than a part, which is said.
    """
    notes = sorted(path for name in NOTES for path in runs.glob(f"*/*/{name}"))
    notes += [path for name in ("*.json", "*.xml", "logs/*") for path in sorted(runs.glob(name))]
    scenes = sorted(runs.glob("*/*/scene.mgs"), key=lambda path: -path.stat().st_mtime)
    parts: list[list[Path]] = [[]]
    room = part_bytes
    for path in [*notes, *scenes]:
        size = path.stat().st_size + 1024  # its header, and what fills up its last block
        if size > part_bytes:
            print(f"{path}: {size:,} bytes are too many for an archive")
            continue
        if size > room:
            parts.append([])
            room = part_bytes
        parts[-1].append(path)
        room -= size
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for number, paths in enumerate(parts):
        written.append(folder / f"cells-{number}.tar")
        with atomic_path(written[-1]) as whole, tarfile.open(whole, "w") as archive:
            for path in paths:
                archive.add(path, arcname=str(path.relative_to(runs)))
    return written


def scenes_of(group: str) -> list[str]:
    """The scenes of a group."""
    return [name for name, place in PLACES.items() if place.group == group]
