"""The file that the long tests add their figures to."""

import json
import os
import platform
import time
from pathlib import Path
from typing import Any

from mobilegs.atomic import atomic_write


def add_record(path: Path | None, name: str, found: dict[str, Any]) -> None:
    """Write the figures of one test into a JSON file, with date and machine; the others stay."""
    if path is None:
        return
    content = json.loads(path.read_text()) if path.exists() else {}
    machine = f"{platform.machine()}, {os.cpu_count()} cores"
    content[name] = {"date": time.strftime("%Y-%m-%d"), "machine": machine, **found}
    atomic_write(path, json.dumps(content, indent=1) + "\n")
