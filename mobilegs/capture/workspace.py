"""The working folder of a capture: records of finished stages, so that a run can resume."""

import hashlib
import json
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mobilegs.atomic import atomic_write, open_input, read_json
from mobilegs.errors import InputError

STAGES = ("photos", "features", "matches", "model", "capture")


class Workspace:
    """The folder of a capture, with the records of its stages in `work/`.

    A record holds the stage's key, a digest of the input and of the options of this and all
    earlier stages, and whether the stage is done. If the key changed, the stage and all later ones
    run again; an interrupted stage continues from its files.

    Attributes:
        path: the capture's folder.
        work: `work/` in it, which may be deleted once the capture is complete.
        photos, photo_masks: upright photos for reconstruction and their masks, in `work/`.
        log: messages of pycolmap.
        database: COLMAP's database of features and matches.
        models: reconstructions, one folder per model.
        undistorted: output of undistortion, before it moves to `images` and `sparse`.
        images, masks, sparse: photos, their masks and COLMAP model of the finished capture.
        report: `capture.json`, the record of the last stage.
        coverage: `coverage.png`, the drawing of cameras and points.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.work = path / "work"
        self.photos = self.work / "photos"
        self.photo_masks = self.work / "masks"
        self.log = self.work / "pycolmap.log"
        self.database = self.work / "database.db"
        self.models = self.work / "models"
        self.undistorted = self.work / "undistorted"
        self.images = path / "images"
        self.masks = path / "masks"
        self.sparse = path / "sparse"
        self.report = path / "capture.json"
        self.coverage = path / "coverage.png"

    def validate_not_foreign(self) -> None:
        """Raise InputError if the folder has files of something else that would be overwritten."""
        if self.path.exists() and not self.path.is_dir():
            raise InputError(f"{self.path} is a file: give a folder for the capture")
        if self._parsed("photos") or self._parsed("capture"):
            return
        for existing in (
            self.work,
            self.images,
            self.masks,
            self.sparse,
            self.report,
            self.coverage,
        ):
            if existing.exists():
                raise InputError(f"{existing} would be overwritten: give another folder")

    def run(self, stage: str, key: str, do: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Run `do` unless the stage is done with this key, and return the stage's record.

        The record has `key`, `done`, `seconds` and the items that `do` returns.
        """
        record = self.read(stage)
        if record is None or record["key"] != key:
            self.forget(stage)
            record = {"key": key, "done": False, "seconds": 0.0}
            if stage != STAGES[-1]:  # the report appears only when the capture is complete
                self._write(stage, record)
        elif record["done"]:
            return record
        started = time.monotonic()
        try:
            items = do()
        finally:
            seconds = round(record["seconds"] + time.monotonic() - started, 1)
            record = {**record, "seconds": seconds}
            if stage != STAGES[-1]:
                self._write(stage, record)
        record = {**record, "done": True, **items}
        self._write(stage, record)
        return record

    def read(self, stage: str) -> dict[str, Any] | None:
        """Return the record of a stage, or None if it or the stage's result is missing."""
        record = self._parsed(stage)
        gone = record is not None and record["done"] and not self._product(stage).exists()
        return None if gone else record

    def _parsed(self, stage: str) -> dict[str, Any] | None:
        try:
            record = read_json(self._record(stage))
            known = {"key": str(record["key"]), "done": bool(record["done"])}
            return {**record, **known, "seconds": float(record["seconds"])}
        except (ValueError, LookupError, TypeError, OverflowError):
            return None

    def finished(self, key: str) -> dict[str, Any] | None:
        """Return the report if the capture is complete and has this key; needs no `work/`."""
        record = self.read(STAGES[-1])
        whole = record is not None and record["key"] == key and self.images.is_dir()
        return record if whole else None

    def forget(self, stage: str) -> None:
        """Remove the records, then the files, of a stage and of all later ones."""
        for later in STAGES[STAGES.index(stage) :]:
            self._record(later).unlink(missing_ok=True)
        for later in STAGES[STAGES.index(stage) :]:
            for path in self._outputs(later):
                if path.is_dir():
                    shutil.rmtree(path)
                else:
                    path.unlink(missing_ok=True)

    def _product(self, stage: str) -> Path:
        """Return the path that exists once a stage is done."""
        return {
            "photos": self.photos,
            "features": self.database,
            "matches": self.database,
            "model": self.models,
            "capture": self.sparse / "0",
        }[stage]

    def _outputs(self, stage: str) -> list[Path]:
        """Return the files of a stage. `forget_matches` removes matches."""
        files = [self.database.with_name(self.database.name + end) for end in ("", "-wal", "-shm")]
        return {
            "photos": [self.photos, self.photo_masks],
            "features": files,
            "matches": [],
            "model": [self.models, self.coverage],
            "capture": [self.sparse, self.images, self.masks, self.undistorted],
        }[stage]

    def _record(self, stage: str) -> Path:
        return self.report if stage == STAGES[-1] else self.work / f"{stage}.json"

    def _write(self, stage: str, record: dict[str, Any]) -> None:
        atomic_write(self._record(stage), json.dumps(record, indent=2, ensure_ascii=False) + "\n")


def digest(*parts: Any) -> str:
    """Return a hexadecimal digest of JSON-like values."""
    text = json.dumps(parts, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file's content. Raises InputError if it cannot be read."""
    with open_input(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
