"""The list of a batch: rows of a CSV, of JSON lines or of a folder, or its faults in sentences."""

import csv
import io
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mobilegs.atomic import read_text
from mobilegs.batch.columns import (
    absolute,
    all_columns,
    applies,
    kind_of,
    unknown_column,
    validate_row,
)
from mobilegs.batch.fetch import is_address, public_address, validate_address, without_secrets
from mobilegs.capture.photos import PHOTOS
from mobilegs.data import has_poses
from mobilegs.errors import InputError

NAME = re.compile(r"[\w][\w.+-]{0,99}")
# names in a batch's folder that no row can have
RESERVED_NAMES = ("cache", "index.html", "results.jsonl")
FAULTS_MAX = 20  # that are printed


@dataclass(frozen=True)
class Row:
    """A scene to make.

    Attributes:
        number: of the row in the list, from 1.
        name: of the scene and its folder.
        source: an absolute path or an address.
        options: texts by column, with the defaults that apply.
        own: columns that the row itself gives.
    """

    number: int
    name: str
    source: str
    options: dict[str, str]
    own: list[str]


def read_list(path: Path, defaults: Mapping[str, str]) -> list[Row]:
    """Return the rows of a list; `defaults` fill columns that a row leaves empty.

    Raises InputError that names every fault, one sentence each with the number of its row, without
    the secrets of addresses.
    """
    try:
        return _read_list(path, defaults)
    except InputError as error:
        raise InputError(without_secrets(str(error))) from None


def _read_list(path: Path, defaults: Mapping[str, str]) -> list[Row]:
    if not path.exists():
        raise InputError(f"{path} does not exist")
    if path.is_dir():
        given = _of_folder(path)
    elif path.suffix.lower() == ".csv":
        given = _of_csv(path)
    elif path.suffix.lower() in (".jsonl", ".ndjson"):
        given = _of_json_lines(path)
    else:
        raise InputError(f"{path} is no list: give a .csv, a .jsonl or a folder")
    folder = path if path.is_dir() else path.parent
    faults = [unknown_column(name) for name in defaults if name not in all_columns()]
    rows: list[Row] = []
    seen: dict[str, int] = {}
    for number, cells in enumerate(given, start=1):
        try:
            row = _validated(_row(number, cells, defaults, folder))
            if row.name.lower() in seen:
                raise InputError(f"row {seen[row.name.lower()]} has the name '{row.name}', too")
            seen[row.name.lower()] = number
            rows.append(row)
        except InputError as error:
            faults.append(f"row {number} of {path.name}: {error}")
    if not faults and not rows:
        raise InputError(f"{path} has no rows")
    refuse(faults)
    return rows


def refuse(faults: Sequence[str]) -> None:
    """Raise InputError with the faults, a line each, if there are any."""
    if faults:
        more = len(faults) - FAULTS_MAX
        rest = [f"and {more} more"] if more > 0 else []
        raise InputError(*faults[:FAULTS_MAX], *rest)


def _row(number: int, cells: Mapping[str, Any], defaults: Mapping[str, str], folder: Path) -> Row:
    """Return a row of a list as it was written, with absolute paths."""
    own: dict[str, str] = {}
    for column, value in cells.items():
        if column not in all_columns():
            raise InputError(unknown_column(column))
        if text := _text(column, value):
            own[column] = text
    texts = {name: absolute(name, text, folder) for name, text in ({**defaults, **own}).items()}
    source = texts.pop("source", "")
    if not source:
        raise InputError("there is no source: give a path or an address in the column 'source'")
    last = public_address(source) if is_address(source) else source
    usual = re.sub(r"[^\w.+-]+", "-", Path(last.rstrip("/")).stem)
    name = texts.pop("name", "") or usual
    if not NAME.fullmatch(name):
        raise InputError(
            f"'{name}' cannot be the name of a folder: use letters, digits, '.', '_' and '-' in "
            "the column 'name'"
        )
    if name.lower() in RESERVED_NAMES:
        raise InputError(f"the name '{name}' is taken by the batch: give another one")
    return Row(number, name, source, texts, sorted(own.keys() & texts.keys()))


def _text(column: str, value: Any) -> str:
    """Return a value of JSON or CSV as the text of a column."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list) and not any(isinstance(part, list | dict) for part in value):
        return " ".join(str(part) for part in value)
    if isinstance(value, str | int | float):
        return str(value).strip()
    raise InputError(f"{column} is {json.dumps(value)[:60]}: give a text, a number or a list")


def _validated(row: Row) -> Row:
    """Return a row with the defaults that apply to it.

    Raises InputError if its source or an option cannot be used.
    """
    if is_address(row.source):
        validate_address(row.source)
        validate_row(row.options, row.own, None)
        return row
    kind = kind_of(Path(row.source))
    validate_row(row.options, row.own, kind)
    options = {name: text for name, text in row.options.items() if applies(name, kind)}
    return replace(row, options=options)


def _of_csv(path: Path) -> Iterator[dict[str, Any]]:
    text = io.StringIO(read_text(path), newline="")
    reader = csv.DictReader(text, restkey="", strict=True)
    try:
        names = [name.strip() for name in reader.fieldnames or []]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise InputError(f"{path} has the column '{twice[0]}' twice")
        for name in names:
            if name not in all_columns():
                raise InputError(f"{path}: {unknown_column(name)}")
        reader.fieldnames = names
        for cells in reader:
            if extra := cells.pop("", None):
                raise InputError(f"{path}, line {reader.line_num}: '{extra[0]}' has no column")
            yield cells
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}: {error}") from None


def _of_json_lines(path: Path) -> Iterator[dict[str, Any]]:
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        if not line.strip():
            continue
        try:
            cells = json.loads(line)
        except (ValueError, RecursionError) as error:
            raise InputError(f"{path}, line {number}: this is not JSON ({error})") from None
        if not isinstance(cells, dict):
            raise InputError(f'{path}, line {number}: give an object like {{"source": "a"}}')
        yield cells


def _of_folder(path: Path) -> Iterator[dict[str, Any]]:
    """Return a row for everything in a folder of which a scene can be made."""
    photos = (path / "images").is_dir() or any(f.suffix.lower() in PHOTOS for f in path.iterdir())
    if photos or has_poses(path):
        raise InputError(f"{path} is one capture: give the folder around it, or use another verb")
    for entry in sorted(path.iterdir()):
        try:
            kind_of(entry)
        except InputError:
            continue
        if not entry.name.startswith("."):
            yield {"source": entry.name}
