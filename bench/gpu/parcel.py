"""What a training goes on from on another machine: parcel-0.bin, parcel-1.bin ... in a folder.

    python bench/gpu/parcel.py pack RUNS FOLDER
    python bench/gpu/parcel.py open FOLDER RUNS

RUNS is what bench/paper.py fills, or the checks of run.sh. A parcel has the notes of all cells, or
of the checks, which are then not made again, and as many teachers and checkpoints as fit, the
newest scene's first, stored as compact.py does; a sentence names what does not fit. Opening one
leaves alone what is there already, and writes into travelled.json which trainings went on from a
rounded teacher or checkpoint.
"""

import argparse
import io
import json
import sys
import time
import zipfile
import zlib
from pathlib import Path

import torch
from compact import TooLargeError, grown, shrunk
from safetensors import safe_open
from safetensors.torch import save_file
from torch import Tensor

from mobilegs.atomic import atomic_path, atomic_write
from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.gaussians import Gaussians

# what comes back from a call at most, files and bytes, and what goes there beside the repository
FILES, PART_BYTES, BACK_BYTES, THERE_BYTES = 8, 15 << 20, 63 << 20, 56 << 20
CONFIG, TRAVELLED = "config.json", "travelled.json"
TEACHER, CHECKPOINT = "teacher.ply", "checkpoint.safetensors"
SMALL = (
    *(f"*/*/{name}" for name in ("settings.json", "cell.json", "frames.json", "seconds.json")),
    # of the checks, whose scene is a run of `mobilegs train`
    *(f"scene/*/{name}" for name in (CONFIG, "metrics.json", "scene.mgs")),
    "logs/parts.txt", "tests.xml", "kernels.json", "frames.json", "native.json", "gsplat.failed",
    TRAVELLED,
)  # fmt: skip
SHRUNK = ".shrunk"  # behind the name of what is not stored as it is


def pack(runs: Path, folder: Path) -> list[str]:
    """Write a parcel into FOLDER; returns what is in it and what stays behind, in sentences."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("parcel-*.bin"):
        old.unlink()
    beside = [path.stat().st_size for path in folder.iterdir() if path.is_file()]
    most = min(THERE_BYTES, BACK_BYTES - sum(beside), PART_BYTES * (FILES - len(beside)))
    notes = sorted(path for pattern in SMALL for path in runs.glob(pattern))
    file, told, left = io.BytesIO(), [], set()
    with zipfile.ZipFile(file, "w") as parcel:
        for path in notes:
            parcel.write(path, path.relative_to(runs))
        for path in worth(runs):
            if path.parent in left:  # a student is nothing without the teacher beside it
                continue
            name = path.relative_to(runs)
            room = most - file.tell() - (1 << 16)  # what a zip says at its end
            small = _teacher if path.name == TEACHER else _checkpoint
            try:
                content = small(path, room)
            except TooLargeError:
                left.add(path.parent)
                told.append(
                    f"{name} stays, it needs more than the {max(0, room) >> 20} MiB that are left: "
                    "on another machine this training begins anew"
                )
                continue
            parcel.writestr(f"{name}{SHRUNK}", content)
            told.append(f"{name} travels, {len(content) / 2**20:.1f} MiB")
    content = file.getvalue()
    for number, start in enumerate(range(0, len(content), PART_BYTES)):
        part = content[start : start + PART_BYTES]
        atomic_write(folder / f"parcel-{number}.bin", part)
    return told


def worth(runs: Path) -> list[Path]:
    """Finished teachers and checkpoints, the newest scene's first, of each the teachers first.

    A checkpoint of a teacher that is finished is of no use any more.
    """
    found = [*runs.glob(f"*/*/{TEACHER}"), *runs.glob(f"*/*/{CHECKPOINT}")]
    found = [path for path in found if path.name == TEACHER or not _is_done(path.parent)]
    newest: dict[Path, float] = {}
    for path in found:
        scene = path.parents[1]
        newest[scene] = max(newest.get(scene, 0), path.stat().st_mtime)
    return sorted(
        found,
        key=lambda path: (
            -newest[path.parents[1]], str(path.parents[1]), path.name != TEACHER,
            -path.stat().st_mtime,
        ),
    )  # fmt: skip


def _is_done(folder: Path) -> bool:
    if (folder / CONFIG).exists():  # teacher and student in one folder
        return (folder / "scene.mgs").exists()
    return (folder / TEACHER).exists() or (folder / "cell.json").exists()


def _teacher(path: Path, most: int) -> bytes:
    """A finished teacher, small."""
    tensors = read_ply(path).tensors()
    sh = tensors.pop("sh")
    named = {**tensors, "sh0": sh[:, :1], "sh_rest": sh[:, 1:]}
    values = ((f"rows/{name}/value", tensor.contiguous()) for name, tensor in named.items())
    return shrunk(values, len(sh), most)


def _checkpoint(path: Path, most: int) -> bytes:
    """A checkpoint, small, with its JSON."""
    with safe_open(str(path), framework="pt") as file:
        names = sorted(file.keys())
        means = [name for name in names if name.endswith(("adam/means/value", "rows/means/value"))]
        rows = file.get_slice(means[0]).get_shape()[0] if means else 0
        about = torch.tensor(list(json.dumps(file.metadata()).encode()), dtype=torch.uint8)
        tensors = ((name, file.get_tensor(name)) for name in names)
        return shrunk([("about", about), *tensors], rows, most)


def unpack(folder: Path, runs: Path) -> list[str]:
    """Take up a parcel; returns the names of what was rounded on its way."""
    parts = sorted(folder.glob("parcel-*.bin"), key=lambda path: int(path.stem.split("-")[1]))
    if not parts:
        return []
    try:
        parcel = zipfile.ZipFile(io.BytesIO(b"".join(path.read_bytes() for path in parts)))
        damaged = parcel.testzip()
    except (zipfile.BadZipFile, ValueError) as error:
        raise InputError(
            f"{folder} holds no whole parcel ({error}): bring all its parts"
        ) from error
    if damaged:
        raise InputError(f"{folder} holds a damaged parcel, in {damaged}: bring it again")
    taken = []
    for name in parcel.namelist():
        path = runs / name.removesuffix(SHRUNK)
        if path.exists() or (path.name == CHECKPOINT and _is_done(path.parent)):
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        content = parcel.read(name)
        if not name.endswith(SHRUNK):
            atomic_write(path, content)
            continue
        _restore(path, grown(content))
        taken.append(str(path.relative_to(runs)))
    if taken:
        note = runs / TRAVELLED
        before = json.loads(note.read_text()) if note.exists() else []
        now = time.strftime("%Y-%m-%d %H:%M:%S")
        more = [{"went_on_from": name, "rounded": True, "when": now} for name in taken]
        atomic_write(note, json.dumps([*before, *more], indent=1) + "\n")
    return taken


def _restore(path: Path, tensors: dict[str, Tensor]) -> None:
    if path.name == TEACHER:
        named = {name.split("/")[1]: tensor for name, tensor in tensors.items()}
        sh = torch.cat([named.pop("sh0"), named.pop("sh_rest")], dim=1)
        write_ply(path, Gaussians(**named, sh=sh))
        return
    about = json.loads(bytes(tensors.pop("about").tolist()))
    if (teacher := path.with_name(TEACHER)).exists():  # by its sum a student knows it again
        tree = json.loads(about["checkpoint"])
        if tree["state"]["stage"] == "student":
            tree["state"]["teacher_crc"] = zlib.crc32(teacher.read_bytes())
        about["checkpoint"] = json.dumps(tree)
    with atomic_path(path) as temporary:
        save_file(tensors, temporary, metadata=about)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["pack", "open"])
    parser.add_argument("source", type=Path)
    parser.add_argument("target", type=Path)
    options = parser.parse_args()
    if options.what == "pack":
        for sentence in pack(options.source, options.target):
            print(sentence)
        return
    try:
        for name in unpack(options.source, options.target):
            print(f"{name}: goes on from what was brought, rounded")
    except InputError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
