"""What a capture has done so far: stages, and of what each was made."""

import hashlib
import json
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mobilegs.atomic import atomic_write
from mobilegs.errors import InputError

STAGES = ("photos", "features", "matches", "model", "capture")


class Workspace:
    """The folder of a capture, and the records of its stages in `work/`.

    A stage is done once its record says so, of the key that the record holds: a digest of the
    input and of the options, those of earlier stages included. A stage whose key changed is done
    anew, with all after it; one that was interrupted goes on in what it left.

    Attributes:
        path: the capture's folder.
        work: `work/` in it, which may be deleted once the capture is whole.
        photos: upright photos in `work/`, of the size that is reconstructed.
        database: COLMAP's, of features and matches.
        models: what mapping found, one folder a model.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.work = path / "work"
        self.photos = self.work / "photos"
        self.database = self.work / "database.db"
        self.models = self.work / "models"
        self.undistorted = self.work / "undistorted"
        self.images = path / "images"
        self.sparse = path / "sparse"
        self.report = path / "capture.json"
        self.coverage = path / "coverage.png"

    def refuse_foreign(self) -> None:
        """InputError if the folder holds something, not of a capture, that would be overwritten."""
        if self.path.exists() and not self.path.is_dir():
            raise InputError(f"{self.path} is a file: give a folder for the capture")
        if self._parsed("photos") or self._parsed("capture"):
            return
        for there in (self.work, self.images, self.sparse, self.report, self.coverage):
            if there.exists():
                raise InputError(f"{there} would be overwritten: give another folder")

    def run(self, stage: str, key: str, do: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """The record of a stage, after doing what is left of it.

        `do` returns what the record is to hold besides its key, state and seconds.
        """
        record = self.read(stage)
        if record is None or record["key"] != key:
            self.forget(stage)
            record = {"key": key, "done": False, "seconds": 0.0}
            if stage != STAGES[-1]:  # the report appears when all is there
                self._write(stage, record)
        elif record["done"]:
            return record
        started = time.monotonic()
        try:
            found = do()
        finally:
            seconds = round(record["seconds"] + time.monotonic() - started, 1)
            record = {**record, "seconds": seconds}
            if stage != STAGES[-1]:
                self._write(stage, record)
        record = {**record, "done": True, **found}
        self._write(stage, record)
        return record

    def read(self, stage: str) -> dict[str, Any] | None:
        """The record of a stage; None where there is none, or what it speaks of is gone."""
        record = self._parsed(stage)
        gone = record is not None and record["done"] and not self._product(stage).exists()
        return None if gone else record

    def _parsed(self, stage: str) -> dict[str, Any] | None:
        try:
            record = json.loads(self._record(stage).read_text())
            known = {"key": str(record["key"]), "done": bool(record["done"])}
            return {**record, **known, "seconds": float(record["seconds"])}
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def finished(self, key: str) -> dict[str, Any] | None:
        """The report, if the capture is whole and of this key; `work/` is not needed for that."""
        record = self.read(STAGES[-1])
        whole = record is not None and record["key"] == key and self.images.is_dir()
        return record if whole else None

    def forget(self, stage: str) -> None:
        """Remove what a stage and those after it have left, records first."""
        for later in STAGES[STAGES.index(stage) :]:
            self._record(later).unlink(missing_ok=True)
        for later in STAGES[STAGES.index(stage) :]:
            for path in self._outputs(later):
                if path.is_dir():
                    shutil.rmtree(path)
                else:
                    path.unlink(missing_ok=True)

    def _product(self, stage: str) -> Path:
        """What is there once a stage is done."""
        return {
            "photos": self.photos,
            "features": self.database,
            "matches": self.database,
            "model": self.models,
            "capture": self.sparse / "0",
        }[stage]

    def _outputs(self, stage: str) -> list[Path]:
        """What a stage leaves. Matches are in the database of features, which pairs.py clears."""
        files = [self.database.with_name(self.database.name + end) for end in ("", "-wal", "-shm")]
        return {
            "photos": [self.photos],
            "features": files,
            "matches": [],
            "model": [self.models, self.coverage],
            "capture": [self.sparse, self.images, self.undistorted],
        }[stage]

    def _record(self, stage: str) -> Path:
        return self.report if stage == STAGES[-1] else self.work / f"{stage}.json"

    def _write(self, stage: str, record: dict[str, Any]) -> None:
        atomic_write(self._record(stage), json.dumps(record, indent=2, ensure_ascii=False) + "\n")


def digest(*parts: Any) -> str:
    """A short name of JSON-like values: the same for the same values only."""
    text = json.dumps(parts, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def file_digest(path: Path) -> str:
    """A name of a file's content. InputError if it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error
