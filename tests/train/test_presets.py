"""The presets `paper` and `release` against the paper's statements."""

import csv
import json
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest

from mobilegs.train.recipes import PAPER, RECIPES, RELEASE, PresetName

STATEMENTS = Path(__file__).parents[2] / "docs" / "paper_statements.csv"


def table() -> list[tuple[str, dict[str, str]]]:
    """Return the settings of the paper's statements, each with its value by preset."""
    with STATEMENTS.open(newline="") as file:
        return [(row["setting"], row) for row in csv.DictReader(file)]


def value(config: Any, path: str) -> Any:
    for name in path.split("."):
        config = getattr(config, name)
    return config


def paths(config: Any, prefix: str = "") -> list[str]:
    found = []
    for each in fields(config):
        inner = getattr(config, each.name)
        path = f"{prefix}{each.name}"
        found += paths(inner, f"{path}.") if is_dataclass(inner) else [path]
    return found


@pytest.mark.parametrize("preset", ["paper", "release"])
def test_a_preset_has_the_values_of_the_statements(preset: PresetName) -> None:
    recipe, rows = RECIPES[preset](), table()
    assert len(rows) > 40
    for path, values in rows:
        found = value(recipe, path)
        expected = values[preset]
        if isinstance(found, str):
            assert found == expected, path
        else:
            assert found == pytest.approx(json.loads(expected), rel=1e-8), path


@pytest.mark.parametrize("preset", ["paper", "release"])
def test_the_statements_have_every_departure_of_the_default(preset: PresetName) -> None:
    recipe, default = RECIPES[preset](), RECIPES["long"]()
    listed = {path for path, _ in table()}
    listed |= {"student.lr.quantized_factor"}  # has no effect in these presets
    for path in paths(recipe):
        if value(recipe, path) != value(default, path):
            assert path in listed, path


def test_the_settings_of_the_presets_are_in_the_statements() -> None:
    listed = {path for path, _ in table()}
    for setting in (*PAPER, *RELEASE):
        path = setting.split("=")[0]
        assert path in listed or path.startswith("student.lr."), path
