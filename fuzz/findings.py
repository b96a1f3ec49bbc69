"""The findings of a fuzzing process: one input for each kind of failure, with its description."""

import hashlib
import json
import re
from pathlib import Path

Failure = dict[str, str] | str  # a description, or {"error": ..., "where": ...}


class Findings:
    """Keeps the first input of each failure in `folder`, named after target and content."""

    def __init__(self, target: str, folder: Path) -> None:
        self.target, self.folder = target, folder
        self.known: set[str] = set()
        folder.mkdir(parents=True, exist_ok=True)

    def add(self, data: bytes, found: Failure) -> None:
        """Keep an input unless the same failure is known: numbers in messages do not count."""
        error = found if isinstance(found, str) else found["error"]
        where = "" if isinstance(found, str) else found.get("where", "")
        key = where or re.sub(r"[0-9.e+-]+|'[^']*'", "#", error)[:80]
        if key in self.known:
            return
        self.known.add(key)
        name = f"{self.target}-{hashlib.sha1(data).hexdigest()[:12]}"
        (self.folder / name).write_bytes(data)
        with (self.folder / "findings.txt").open("a") as log:
            log.write(f"{name}\t{where}\t{json.dumps(error[:2000])}\n")
        print(f"finding {name}: {where} {error[:300]!r}", flush=True)
