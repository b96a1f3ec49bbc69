"""The verbs that train or convert: demo, train, compress, capture, and export to other formats."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import arg

from mobilegs.cli.options import call
from mobilegs.cli.output import print_capture, print_trained
from mobilegs.errors import InputError, printable
from mobilegs.progress_display import show_progress

if TYPE_CHECKING:
    from mobilegs.capture import CaptureRun
    from mobilegs.pipeline.compress import CompressRun
    from mobilegs.pipeline.options import TrainRun
    from mobilegs.scene_file import Kind

# of train and compress; the others are expert options
COMMON = (
    "capture", "scene", "output", "minutes", "preset", "downscale", "steps", "max_splats",
    "target_mb", "seed", "resume", "device", "live",
)  # fmt: skip


def demo(
    *,
    output: Annotated[Path, arg(aliases=["-o"], metavar="DIR")] = Path("demo"),
    seed: Annotated[int, arg(metavar="N")] = 0,
    live: bool = False,
) -> None:
    """Train on a small capture that mobilegs renders itself.

    This takes a few minutes on two cores. DIR receives the capture and the files of
    `mobilegs train`. The same command continues an interrupted demo.

    Args:
        output: Folder for all files; created if missing.
        seed: Seed of all random choices.
        live: Show the scene in the browser during the training; the address is printed.
    """
    from mobilegs.atomic import make_folder, refuse_links
    from mobilegs.data.demo.capture import demo_capture, write_capture
    from mobilegs.live import ADDRESS, validate_live_options
    from mobilegs.pipeline.options import TrainRun

    validate_live_options(live, ADDRESS)
    capture = output / "capture"
    if not (capture / "sparse" / "0" / "cameras.txt").exists():  # written last
        if (output / "config.json").exists():
            raise InputError(f"{output} holds a run of something else: give another folder")
        refuse_links(capture, capture / "images", capture / "sparse", capture / "sparse" / "0")
        make_folder(capture)
        with show_progress("rendering photos") as advance:
            write_capture(capture, demo_capture(width=480, height=320, progress=advance))
    run = TrainRun(capture, output, preset="demo", seed=seed, resume=True, live=live)
    run_training(run, how_to_continue=f"give the same command to continue {output}")


def train(words: Sequence[str]) -> None:
    """Train a phone-sized scene.mgs from photos or a video."""
    from mobilegs.pipeline.options import TrainRun
    from mobilegs.pipeline.unposed import with_poses

    run = call(TrainRun, words, verb="train", common=COMMON)
    run_training(with_poses(run, make_capture))


def capture(words: Sequence[str]) -> None:
    """Compute the camera poses of photos or of a video, to make a capture."""
    from mobilegs.capture import CaptureRun

    make_capture(call(CaptureRun, words, verb="capture"))


def make_capture(run: "CaptureRun") -> None:
    """Make a capture and print a summary."""
    from mobilegs.capture import capture_photos

    try:
        report = capture_photos(run, progress=show_progress)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("interrupted: give the same command to continue") from None
    print_capture(report, run.output)


def compress(words: Sequence[str]) -> None:
    """Compress a trained 3DGS scene into a phone-sized scene.mgs."""
    from mobilegs.pipeline.compress import CompressRun

    run_training(call(CompressRun, words, verb="compress", common=COMMON))


def convert(scene: Path, output: Path, kind: "Kind", **options: Any) -> int:
    """Write a scene as a file for tools that sort and return its bytes.

    `options` are fields of `SortedExport`. Prints how the scene was converted.
    """
    from mobilegs.pipeline.export_sorted import SortedExport, export_sorted

    run = SortedExport(scene, output, kind, **options)
    try:
        size, message = export_sorted(run, progress=show_progress)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("interrupted: nothing was written") from None
    if message:
        print(printable(message))
    return size


def run_training(run: "TrainRun | CompressRun", *, how_to_continue: str = "") -> None:
    """Train or compress, and print a summary, or how to continue after an interruption."""
    from mobilegs.pipeline.compress import CompressRun, compress_scene
    from mobilegs.pipeline.train import train_capture
    from mobilegs.train.distributed import is_main_process
    from mobilegs.train.memory import keep_freed_memory
    from mobilegs.train.run_dir import RunDir
    from mobilegs.view.report import write_report

    keep_freed_memory()
    try:
        if isinstance(run, CompressRun):
            metrics = compress_scene(run, progress=show_progress)
        else:
            metrics = train_capture(run, progress=show_progress)
    except KeyboardInterrupt:
        how_to_continue = how_to_continue or f"add --resume to continue {run.output}"
        raise KeyboardInterrupt(f"interrupted: {how_to_continue}") from None
    if is_main_process():
        write_report(RunDir(run.output))
        print_trained(metrics, run.output)
