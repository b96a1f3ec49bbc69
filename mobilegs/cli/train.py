"""The verbs that make scenes or captures, of photos or of other scenes: they take their time."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro
from tyro.conf import FlagCreatePairsOff, arg

from mobilegs.cli.output import print_capture, print_trained, progress_bar
from mobilegs.errors import InputError

if TYPE_CHECKING:
    from mobilegs.capture import CaptureRun
    from mobilegs.pipeline.train import TrainRun
    from mobilegs.scene_file import Kind

Output = Annotated[Path, arg(aliases=["-o"], metavar="DIR")]
CONFIG = (FlagCreatePairsOff,)  # --json without its twin --no-json


def demo(*, output: Output = Path("demo"), seed: int = 0, live: bool = False) -> None:
    """Go the whole way on a small capture that mobilegs renders itself; minutes on two cores.

    The folder then holds what `mobilegs train` leaves, and the capture beside it. A demo that
    was interrupted goes on where it stopped.

    Args:
        output: Folder for everything; it is made if it is missing.
        seed: Start of all random choices.
        live: Show the scene in the browser while it trains; prints the address.
    """
    from mobilegs.atomic import make_folder
    from mobilegs.data.demo.capture import sample_capture, write_sample
    from mobilegs.live import ADDRESS, refuse
    from mobilegs.pipeline.train import TrainRun

    refuse(live, ADDRESS)
    capture = output / "capture"
    if not (capture / "sparse" / "0" / "cameras.txt").exists():  # what is written last
        if (output / "config.json").exists():
            raise InputError(f"{output} holds a run of something else: give another folder")
        make_folder(capture)
        with progress_bar("tracing photos") as advance:
            write_sample(capture, sample_capture(progress=advance))
    run = TrainRun(capture, output, preset="demo", seed=seed, resume=True, live=live)
    run_training(run, f"give the same command to continue {output}")


def train(words: Sequence[str]) -> None:
    """Train a capture, or photos or a video: a phone-sized scene.mgs comes out."""
    from mobilegs.pipeline.train import TrainRun
    from mobilegs.pipeline.unposed import with_poses

    run = tyro.cli(TrainRun, prog="mobilegs train", args=words, config=CONFIG)
    run_training(with_poses(run, make_capture), f"add --resume to continue {run.output}")


def capture(words: Sequence[str]) -> None:
    """Find out where photos were taken, or the frames of a video: a capture for training."""
    from mobilegs.capture import CaptureRun

    make_capture(tyro.cli(CaptureRun, prog="mobilegs capture", args=words, config=CONFIG))


def make_capture(run: "CaptureRun") -> None:
    """Make a capture, and print what came of it."""
    from mobilegs.capture import capture_photos

    try:
        found = capture_photos(run, bar=progress_bar)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("interrupted: give the same command to continue") from None
    print_capture(found, run.output)


def compress(words: Sequence[str]) -> None:
    """Make a phone-sized scene.mgs of a trained 3DGS scene, with its photos or without."""
    from mobilegs.pipeline.compress import CompressRun, compress_run

    run = tyro.cli(CompressRun, prog="mobilegs compress", args=words, config=CONFIG)
    work = partial(compress_run, run, progress=progress_bar)
    finish(run.output, work, f"add --resume to continue {run.output}")


def convert(scene: Path, output: Path, kind: "Kind", **how: Any) -> int:
    """Write a scene as a file for tools that sort; `how` are fields of `SortedExport`.

    What is to be said of it is printed. Returns the bytes.
    """
    from mobilegs.pipeline.export_sorted import SortedExport, export_sorted

    try:
        size, said = export_sorted(SortedExport(scene, output, kind, **how), progress=progress_bar)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("interrupted: nothing was written") from None
    if said:
        print(said)
    return size


def run_training(run: "TrainRun", again: str) -> None:
    """Train, and print what came of it; `again` says what to do when it was interrupted."""
    from mobilegs.pipeline.train import train_run

    finish(run.output, partial(train_run, run), again)


def finish(output: Path, work: Callable[[], dict[str, Any]], again: str) -> None:
    """Do the work, whose figures are a run's, and print what came of it."""
    from mobilegs.train.distributed import is_first

    try:
        metrics = work()
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted: {again}") from None
    if is_first():
        print_trained(metrics, output)
