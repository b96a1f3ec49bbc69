"""The folder of a run: what it will hold, where it stands, and what stopping leaves behind."""

import json
import signal
import threading
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from types import FrameType
from typing import Any

import torch

from mobilegs.atomic import atomic_write
from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.train.checkpoint import load_checkpoint, save_checkpoint
from mobilegs.train.recipes import Recipe, from_json


class RunFolder:
    """Names in the folder of a run. Every file appears whole or not at all.

    How far a run is follows from what is there: `teacher.ply` once the teacher is trained,
    `scene.mgs` once the student is, `metrics.json` once all is done; between these the
    checkpoint.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.config = path / "config.json"
        self.checkpoint = path / "checkpoint.safetensors"
        self.teacher = path / "teacher.ply"
        self.scene = path / "scene.mgs"
        self.metrics = path / "metrics.json"
        self.journal = path / "metrics.jsonl"
        self.contact_sheet = path / "contact_sheet.png"
        self.previews = path / "previews"

    def refuse(self) -> None:
        """Raise InputError if no run can begin here.

        That is so if the folder holds one already, or something of the name of its files; anything
        else there stays as it is.
        """
        for path in (self.path, *self.path.parents):
            if path.exists() and not path.is_dir():
                raise InputError(f"{path} is a file: give a folder for the run")
        if self.config.exists():
            raise InputError(
                f"{self.path} already holds a run: add --resume to continue it, or give another "
                "folder"
            )
        pictures = (self.contact_sheet, self.previews)
        for file in (
            self.checkpoint, self.teacher, self.scene, self.metrics, self.journal, *pictures
        ):  # fmt: skip
            if file.exists():
                raise InputError(f"{file} would be overwritten: give another folder for the run")

    def begin(self, *, options: dict[str, Any], recipe: Recipe, photos: dict[str, Any]) -> None:
        """Write down what the new run does, and with which photos; refuses as `refuse` does."""
        self.refuse()
        content = {"options": options, "recipe": asdict(recipe), "photos": photos}
        atomic_write(self.config, json.dumps(content, indent=2) + "\n")

    def continued(self) -> tuple[dict[str, Any], Recipe, dict[str, Any]]:
        """Options, recipe and photos of the run that this folder holds."""
        try:
            content = json.loads(self.config.read_text())
            recipe, photos = from_json(Recipe, content["recipe"]), content["photos"]
            poses = [float(number) for number in photos["poses"]]
            if len(poses) != 12:
                raise ValueError(f"a mean pose of {len(poses)} numbers")
            return content["options"], recipe, {**photos, "poses": poses}
        except InputError as error:
            raise InputError(f"{self.config} cannot be used: {error}") from error
        except (OSError, KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"{self.config} is damaged ({error}): delete the folder and start anew"
            ) from error

    def results(self) -> dict[str, Any]:
        """The contents of `metrics.json`."""
        try:
            return json.loads(self.metrics.read_text())
        except (OSError, ValueError) as error:
            raise InputError(
                f"{self.metrics} is damaged ({error}): delete it, and --resume measures again"
            ) from error

    def save(self, stage: str, state: dict, *, seconds: dict[str, float], rows: list) -> None:
        """Write the checkpoint: a stage's state, seconds by stage, and the journal's rows."""
        save_checkpoint(
            self.checkpoint,
            {
                "stage": stage,
                "state": state,
                "teacher_crc": self._teacher_crc() if stage == "student" else None,
                "seconds": seconds,
                "journal": rows,
            },
        )

    def saved(self) -> dict[str, Any] | None:
        """What `save` wrote last, or None.

        Raises InputError if it is damaged, or the teacher is no longer the one it began with.
        """
        if not self.checkpoint.exists():
            return None
        content = load_checkpoint(self.checkpoint)
        if content["stage"] == "student" and content["teacher_crc"] != self._teacher_crc():
            raise InputError(
                f"{self.teacher} is not the one that this run's student learns from: put it "
                "back, or start anew"
            )
        return content

    def finish(self) -> None:
        """Drop what only resuming needs."""
        self.checkpoint.unlink(missing_ok=True)

    def _teacher_crc(self) -> int | None:
        return zlib.crc32(self.teacher.read_bytes()) if self.teacher.exists() else None


def photos_of(dataset: Dataset) -> dict[str, Any]:
    """By what a capture is known again: its photos, their sizes, where they were taken."""
    frames = [*dataset.train, *dataset.test]
    sizes = [[frame.name, frame.camera.width, frame.camera.height] for frame in frames]
    poses = torch.stack([frame.camera.viewmat[:3] for frame in frames]).double().mean(0)
    return {"names": zlib.crc32(json.dumps(sizes).encode()), "poses": poses.flatten().tolist()}


def same_photos(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether two captures are the same but for what other machines round in another way."""
    poses = [torch.tensor(photos["poses"], dtype=torch.float64) for photos in (one, other)]
    return one["names"] == other["names"] and torch.allclose(*poses, rtol=1e-3, atol=1e-3)


class StopRequest:
    """Set once somebody asked the process to stop; true in a condition."""

    def __init__(self) -> None:
        self.asked = False

    def __bool__(self) -> bool:
        return self.asked


@contextmanager
def stopping_between_steps() -> Iterator[StopRequest]:
    """Turn Ctrl-C and SIGTERM into a request that the loop honours after the current step.

    A second signal stops at once. Outside of the main thread signals stay as they are.
    """
    request = StopRequest()
    if threading.current_thread() is not threading.main_thread():
        yield request
        return
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def ask(number: int, frame: FrameType | None) -> None:
        request.asked = True
        for each, handler in before.items():
            signal.signal(each, handler)

    for number in before:
        signal.signal(number, ask)
    try:
        yield request
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
