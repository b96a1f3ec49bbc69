"""Figures that are written after every row, so that an interrupted run keeps what it has."""

import json
import time
from pathlib import Path

from mobilegs.atomic import atomic_write


class Figures:
    """Rows by name in a JSON file; values that an earlier run wrote stay."""

    def __init__(self, path: Path | None, **about: object) -> None:
        self.path = path
        found = json.loads(path.read_text()) if path is not None and path.exists() else {}
        self.content = {"date": time.strftime("%Y-%m-%d"), **about, "rows": found.get("rows", {})}

    def add(self, name: str, **values: object) -> None:
        """Add values to a row, print them, and write the file."""
        row = self.content["rows"].setdefault(name, {})
        row |= values
        print(name, json.dumps(values), flush=True)
        if self.path is not None:
            atomic_write(self.path, json.dumps(self.content, indent=1) + "\n")
