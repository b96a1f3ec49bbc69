"""The command line: one function a verb, its docstring the help.

Nothing heavy is imported until a verb runs, so that `--help` answers at once.
"""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro
from tyro.conf import FlagCreatePairsOff, Positional, arg

from mobilegs import __version__
from mobilegs.errors import InputError

if TYPE_CHECKING:
    from mobilegs.data.dataset import Dataset
    from mobilegs.render.scene import Scene
    from mobilegs.train.loop import TrainRun

Split = Literal["test", "train"]
Device = Literal["auto", "cpu", "cuda"]
SceneFile = Annotated[Positional[Path], arg(metavar="SCENE")]
Capture = Annotated[Path, arg(metavar="CAPTURE")]
Output = Annotated[Path, arg(aliases=["-o"], metavar="DIR")]
Downscale = Annotated[int | None, arg(metavar="N")]


def demo(*, output: Output = Path("demo"), seed: int = 0) -> None:
    """Go the whole way on a small capture that mobilegs renders itself; minutes on two cores.

    The folder then holds what `mobilegs train` leaves, and the capture beside it. A demo that
    was interrupted goes on where it stopped.

    Args:
        output: Folder for everything; it is made if it is missing.
        seed: Start of all random choices.
    """
    from mobilegs.data.sample import write_sample
    from mobilegs.train.loop import TrainRun

    capture = output / "capture"
    if not (capture / "sparse" / "0" / "cameras.txt").exists():  # what is written last
        write_sample(capture)
    run_training(TrainRun(capture, output, preset="demo", seed=seed, resume=True))


def train(words: Sequence[str]) -> None:
    """Train a capture: photos with poses in, a phone-sized scene.mgs out."""
    from mobilegs.train.loop import TrainRun

    run_training(tyro.cli(TrainRun, prog="mobilegs train", args=words, config=CONFIG))


def run_training(run: "TrainRun") -> None:
    """Train, and print what came of it."""
    from mobilegs.train.loop import train_run

    try:
        metrics = train_run(run)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted: add --resume to continue {run.output}") from None
    student, teacher = metrics["student"], metrics["teacher"]
    print(
        f"{run.output / 'scene.mgs'}: {student['gaussians']:,} Gaussians, "
        f"{student['file_bytes']:,} bytes, on held-back photos {decibels(student)} "
        f"(teacher {decibels(teacher)})"
    )
    print(f"{run.output / 'contact_sheet.png'} shows them side by side")


def decibels(figures: dict[str, Any]) -> str:
    """PSNR as text; null stands for a picture without any error."""
    return "without error" if figures["psnr"] is None else f"{figures['psnr']:.2f} dB"


def render(
    scene: SceneFile,
    /,
    *,
    capture: Capture,
    output: Output,
    split: Split = "test",
    downscale: Downscale = None,
    device: Device = "auto",
) -> None:
    """Draw the views of a capture from a scene, one PNG a photo.

    Each picture carries the photo's own name: IMG_0042.JPG becomes IMG_0042.png. A .mgs is
    drawn without sorting, a .ply sorted.

    Args:
        scene: The scene: a .mgs file, or a .ply in the layout of 3DGS.
        capture: Folder of the capture whose cameras are used.
        output: Folder for the pictures; it is made if it is missing.
        split: The held-back photos (test), or those trained on (train).
        downscale: Divide the photos' size by this. Without it they are at most 1600 wide.
        device: Where to draw; auto takes a GPU if there is one.
    """
    import torch
    from PIL import Image

    from mobilegs.atomic import atomic_path
    from mobilegs.evaluate.metrics import to_bytes

    opened, dataset = open_both(scene, capture, downscale, device)
    frames = dataset.test if split == "test" else dataset.train
    if not frames:
        raise InputError(f"{capture} has no {split} views to draw")
    names = png_names([frame.name for frame in frames])
    with torch.inference_mode(), progress_bar("drawing") as advance:
        for done, frame in enumerate(frames, start=1):
            camera = frame.camera.to(opened.gaussians.means.device)
            pixels = to_bytes(opened.render(camera).image).cpu().numpy()
            with atomic_path(output / names[frame.name]) as temporary:
                Image.fromarray(pixels).save(temporary, format="PNG")
            advance(done, len(frames))
    print(f"{len(frames)} pictures in {output}")


def evaluate(
    scene: SceneFile,
    /,
    *,
    capture: Capture,
    json: bool = False,
    downscale: Downscale = None,
    lpips_weights: Annotated[str | None, arg(metavar="DIR")] = None,
    device: Device = "auto",
) -> None:
    """Compare a scene with the photos that were held back: PSNR, SSIM, LPIPS.

    Renders are rounded to 8 bits, masked pixels do not count, every photo counts the same.
    lpips_vgg and lpips_alex feed pictures in [0, 1], as 3DGS's own figures do; the _rescaled
    ones bring them to [-1, 1], as LPIPS was meant. Compare like with like.

    Args:
        scene: The scene: a .mgs file, or a .ply in the layout of 3DGS.
        capture: Folder of the capture; photos 0, 8, 16, ... by name are the held-back ones.
        json: Print the figures, by photo too, as JSON.
        downscale: Divide the photos' size by this. Without it they are at most 1600 wide.
        lpips_weights: Folder or http(s) address of LPIPS weights; MOBILEGS_LPIPS says the same.
        device: Where to draw; auto takes a GPU if there is one.
    """
    from mobilegs.evaluate import report
    from mobilegs.evaluate.lpips import lpips_from

    opened, dataset = open_both(scene, capture, downscale, device)
    lpips = lpips_from(lpips_weights)
    with progress_bar("evaluating") as advance:
        result = report.evaluate(opened, dataset, lpips=lpips, progress=advance)
    about = {
        "scene": str(scene),
        "capture": str(capture),
        "downscale": downscale,
        "blend": opened.blend,
        "gaussians": len(opened.gaussians),
        "file_bytes": scene.stat().st_size,
    }
    if json:
        print(report.to_json(about | result))
    else:
        print_figures(about, result)


def info(scene: SceneFile, /, *, json: bool = False) -> None:
    """Say what is in a scene's file, byte by byte.

    Args:
        scene: A .mgs file, or a .ply in the layout of 3DGS.
        json: Print it as JSON.
    """
    from mobilegs.evaluate.report import to_json
    from mobilegs.scene_file import inspect_scene

    found = inspect_scene(scene)
    if json:
        print(to_json(found))
    else:
        print_contents(found)


def doctor(*, json: bool = False) -> None:
    """Say what this machine can do, and what to install for what it cannot.

    Args:
        json: Print it as JSON.
    """
    from mobilegs import doctor as checks
    from mobilegs.evaluate.report import to_json

    findings = checks.examine()
    if json:
        print(to_json(checks.as_json(findings)))
        return
    from rich.table import Table

    table = Table(box=None, show_header=False)
    marks = {"yes": "[green]yes[/]", "no": "[yellow]no[/]", "none": "-"}
    for finding in findings:
        text = f"{finding.found}\n-> {finding.remedy}" if finding.remedy else finding.found
        table.add_row(marks[finding.state], finding.what, escape(text))
    console().print(table)


# --- what the verbs share -------------------------------------------------------------------------


def open_both(
    scene: Path, capture: Path, downscale: int | None, device: Device
) -> tuple["Scene", "Dataset"]:
    """A scene on its device, and the capture over the same background.

    A .mgs knows its background; a .ply takes that of the capture.
    """
    from dataclasses import replace

    from mobilegs.data import load_capture
    from mobilegs.scene_file import choose_device, open_scene

    opened = open_scene(scene, choose_device(device))
    if scene.suffix.lower() == ".mgs":
        color = tuple(opened.background.tolist())
        return opened, load_capture(capture, downscale=downscale, background=color)
    dataset = load_capture(capture, downscale=downscale)
    behind = dataset.background.to(opened.background.device)
    return replace(opened, background=behind, near=dataset.near), dataset


def png_names(photos: Sequence[str]) -> dict[str, Path]:
    """Where each photo's picture goes, relative to the output folder: its name, but PNG.

    Photos that differ only in their extension keep it: a.jpg, a.png -> a.jpg.png, a.png.png.
    A capture is not trusted to stay inside the folder.
    """
    parts = {
        photo: [p for p in PurePosixPath(photo.replace("\\", "/")).parts if p.strip("/.: ")]
        for photo in photos
    }
    short = {photo: Path(*parts[photo]).with_suffix(".png") for photo in photos}
    counts = list(short.values())
    return {
        photo: name
        if counts.count(name) == 1
        else Path(*parts[photo][:-1], f"{parts[photo][-1]}.png")
        for photo, name in short.items()
    }


def console() -> Any:
    """Standard output, with colours where it is a terminal."""
    from rich.console import Console

    return Console()


def escape(text: str) -> str:
    """Text in which square brackets are no markup."""
    from rich.markup import escape

    return escape(text)


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error; yields what is to be called with done and total."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Remaining

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Remaining())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


def print_figures(about: dict[str, Any], result: dict[str, Any]) -> None:
    """The figures of an evaluation as a table, a line a photo, the means last."""
    from rich.table import Table

    metrics = [name for name in result if name != "views" and result[name] is not None]
    name = Path(about["scene"]).name
    print(f"{name}: {about['gaussians']:,} Gaussians, {about['file_bytes']:,} bytes")
    table = Table("photo", *(name.replace("_", " ") for name in metrics), box=None)
    for view in result["views"]:
        table.add_row(escape(view["name"]), *(f"{view[name]:.4f}" for name in metrics))
    table.add_section()
    table.add_row("mean", *(f"{result[name]:.4f}" for name in metrics))
    console().print(table)


def print_contents(found: dict[str, Any]) -> None:
    """What is in a file: a line a value, and a table of its streams."""
    from rich.table import Table

    table = Table(box=None, show_header=False)
    for key, value in found.items():
        if isinstance(value, dict):
            table.add_row(key, ", ".join(f"{name} {readable(v)}" for name, v in value.items()))
        elif not isinstance(value, list):
            table.add_row(key, readable(value))
    console().print(table)
    for rows in (value for value in found.values() if isinstance(value, list) and value):
        table = Table(box=None)
        for key in rows[0]:
            table.add_column(key, justify="left" if key in ("name", "codec") else "right")
        for row in rows:
            table.add_row(*(readable(value) for value in row.values()))
        console().print(table)


def readable(value: Any) -> str:
    """A value for people: thousands apart, three digits after the point."""
    if isinstance(value, float):
        return f"{value:,.3f}"
    return f"{value:,}" if type(value) is int else escape(str(value))


# --- the way in -----------------------------------------------------------------------------------

CONFIG = (FlagCreatePairsOff,)  # --json without its twin --no-json
VERBS: dict[str, Callable[..., None]] = {
    "demo": demo,
    "train": train,
    "render": render,
    "eval": evaluate,
    "info": info,
    "doctor": doctor,
}

HELP = """\
mobilegs {version}: 3D Gaussian splatting without sorting, in a file of a few megabytes.

A capture (photos with poses: COLMAP, nerfstudio's transforms.json, NeRF-synthetic) becomes a
teacher, a plain 3DGS scene; the teacher a student that needs no sorting; the student scene.mgs.

  mobilegs VERB ...          mobilegs VERB --help

{verbs}

Environment: MOBILEGS_LPIPS names a folder or address of LPIPS weights.
Exit codes: 0 done, 1 something broke, 2 the input cannot be used (one sentence says why),
130 interrupted.
"""


def help_text() -> str:
    """The text of `mobilegs --help`: every verb with the first line of its docstring."""
    lines = [
        f"  {name:<8} {(verb.__doc__ or '').strip().splitlines()[0]}"
        for name, verb in VERBS.items()
    ]
    return HELP.format(version=__version__, verbs="\n".join(lines))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or words[0] in ("-h", "--help", "help"):
        print(help_text(), end="")
        return 0 if words else 2
    if words[0] == "--version":
        print(__version__)
        return 0
    verb = VERBS.get(words[0])
    if verb is None:
        return fail(f"there is no verb '{words[0]}': use one of {', '.join(VERBS)}", 2)
    try:
        if verb is train:  # its options are the fields of a dataclass that is slow to import
            train(words[1:])
        else:
            tyro.cli(verb, prog=f"mobilegs {words[0]}", args=words[1:], config=CONFIG)
    except InputError as error:
        return fail(str(error), 2)
    except KeyboardInterrupt as error:
        return fail(str(error) or "interrupted", 130)
    except BrokenPipeError:  # `mobilegs ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        if not error.filename:
            raise
        return fail(f"{error.strerror}: {error.filename}", 1)
    return 0


def fail(sentence: str, code: int) -> int:
    """Say on standard error why it ended, and with which exit code."""
    print(f"mobilegs: {sentence}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
