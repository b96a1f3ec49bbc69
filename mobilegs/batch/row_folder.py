"""The folder of a row: its options, and the events of its tasks on all machines."""

import json
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, Literal

from filelock import FileLock, Timeout

from mobilegs.atomic import atomic_write, make_folder, read_json, read_text, refuse_links
from mobilegs.errors import InputError

RowKind = Literal["capture", "photos", "scene"]  # of a row's source
LOCK_SECONDS = 180.0  # until a network's filesystem gives up the lock of a machine that died


class RowFolder:
    """Paths in the folder of a row, which is that of a run (`RunDir`) with a folder `batch`.

    The events tell how far a row is; tasks append them from whatever machine they run on.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        own = path / "batch"
        self.own = own
        self.row = own / "row.json"
        self.place_file = own / "place.json"
        self.events_file = own / "events.jsonl"
        self.log = own / "log.txt"
        self.capture = path / "capture"
        self.poster = path / "poster.jpg"
        self.page = path / f"{path.name}.html"
        self.site = path / "site"

    def create(self, source: str, options: dict[str, str], own: list[str]) -> None:
        """Write what the list says of a row; `source` is a path or a `shown_address`.

        Raises InputError for links in place of the row's files.
        """
        refuse_links(self.path, self.own, self.log, self.events_file, self.capture, self.site)
        make_folder(self.own)
        content = {"source": source, "options": options, "own": own}
        atomic_write(self.row, json.dumps(content, indent=2) + "\n")

    def load_row(self) -> dict[str, Any] | None:
        """Return what `create` wrote, or None if the row is new."""
        if not self.row.exists():
            return None
        try:
            row = read_json(self.row)
            return {key: row[key] for key in ("source", "options", "own")}
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(f"{self.row} is damaged: delete the folder {self.path}") from error

    def set_place(self, path: Path, kind: RowKind) -> None:
        """Note where the source lies on the shared storage, and its kind."""
        atomic_write(self.place_file, json.dumps({"path": str(path), "kind": kind}) + "\n")

    def place(self) -> tuple[Path, RowKind] | None:
        """Return path and kind of the source, or None if it must be fetched."""
        if not self.place_file.exists():
            return None
        place = read_json(self.place_file)
        path = Path(place["path"])
        return (path, place["kind"]) if path.exists() else None

    def append(self, event: str, attempt: int, **about: Any) -> None:
        row = {"event": event, "attempt": attempt, "time": round(time.time(), 3), **about}
        with self.events_file.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")

    def events(self) -> list[dict[str, Any]]:
        """Return all events; a line that a dying machine left half written is skipped."""
        if not self.events_file.exists():
            return []
        events = []
        for line in read_text(self.events_file).splitlines():
            try:
                events.append(json.loads(line))
            except ValueError:
                continue
        return events

    def find(self, event: Literal["started", "ended"], attempt: int) -> dict[str, Any] | None:
        """Return this event of an attempt, if it happened."""
        for row in self.events():
            if row["event"] == event and row["attempt"] == attempt:
                return row
        return None

    def done_stages(self) -> set[str]:
        return {row["stage"] for row in self.events() if row.get("result") == "done"}

    def attempts(self) -> int:
        """Return the number of the last attempt, or 0."""
        return max((row["attempt"] for row in self.events()), default=0)

    def lock(self) -> AbstractContextManager[None]:
        """Keep other machines from this row; wait for one that is ending.

        Raises TimeoutError if another machine keeps the row.
        """
        error = TimeoutError(f"another process works in {self.path}")
        return locked(self.own / ".lock", error, seconds=LOCK_SECONDS)


@contextmanager
def locked(path: Path, error: Exception, *, seconds: float = 0.0) -> Iterator[None]:
    """Hold the lock file `path`; raises `error` if another process keeps it for some seconds."""
    refuse_links(path)
    lock = FileLock(path)
    try:
        lock.acquire(timeout=seconds)
    except Timeout:
        raise error from None
    try:
        yield
    finally:
        lock.release()
