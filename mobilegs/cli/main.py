"""The command line: one function a verb, its docstring the help.

Nothing heavy is imported until a verb runs, so that `--help` answers at once.
"""

import errno
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro
from tyro.conf import Positional, arg

from mobilegs import __version__
from mobilegs.cli.output import print_contents, print_figures, print_findings, progress_bar
from mobilegs.cli.train import CONFIG, capture, compress, convert, demo, train
from mobilegs.errors import InputError

if TYPE_CHECKING:
    from mobilegs.data.dataset import Dataset
    from mobilegs.render.scene import Scene

Split = Literal["test", "train"]
Device = Literal["auto", "cpu", "cuda"]
SceneFile = Annotated[Positional[Path], arg(metavar="SCENE")]
Capture = Annotated[Path, arg(metavar="CAPTURE")]
Downscale = Annotated[int | None, arg(metavar="N")]


def render(
    scene: SceneFile,
    /,
    *,
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None,
    output: Annotated[Path | None, arg(aliases=["-o"], metavar="DIR")] = None,
    orbit: Annotated[Path | None, arg(metavar="MP4")] = None,
    split: Split = "test",
    downscale: Downscale = None,
    seconds: float = 8.0,
    size: tuple[int, int] = (1280, 720),
    device: Device = "auto",
    backend: Literal["kernels", "gpu"] = "kernels",
) -> None:
    """Draw the views of a capture from a scene, one PNG a photo, or a video around the scene.

    Each picture carries the photo's own name: IMG_0042.JPG becomes IMG_0042.png. A .mgs is
    drawn without sorting, the others sorted.

    Args:
        scene: The scene: a .mgs file, or a .ply, .spz, .sog, .splat or .glb of plain 3DGS.
        capture: Folder of the capture whose cameras are used.
        output: Folder for the pictures; it is made if it is missing.
        orbit: Instead of these two: a video to write, of one turn around the scene.
        split: The held-back photos (test), or those trained on (train).
        downscale: Divide the photos' size by this. Without it they are at most 1600 wide.
        seconds: How long the video is.
        size: Width and height of the video.
        device: Where the kernels draw; auto takes an NVIDIA GPU if there is one.
        backend: The kernels that training uses, or gpu: as the viewers draw, with half floats,
            on any GPU that Vulkan, Metal or DirectX 12 reaches.
    """
    import torch
    from PIL import Image

    from mobilegs.atomic import atomic_path
    from mobilegs.cli.render import picture_paths
    from mobilegs.evaluate.metrics import to_bytes

    if backend == "gpu":
        device = "cpu"  # where the scene is read; the renderer takes it from there
    if orbit is not None:
        if capture or output or downscale:
            raise InputError("--orbit needs no photos: leave out --capture, -o and --downscale")
        return render_orbit(scene, orbit, seconds, size, device, backend)
    if capture is None or output is None:
        raise InputError("what is to be drawn? give --capture CAPTURE -o DIR, or --orbit MP4")
    opened, dataset = open_both(scene, capture, downscale, device)
    frames = dataset.test if split == "test" else dataset.train
    if not frames:
        raise InputError(f"{capture} has no {split} views to draw")
    paths = picture_paths(frames, dataset, output)
    draw = drawing(opened, backend)
    with torch.inference_mode(), progress_bar("drawing") as advance:
        for done, (frame, path) in enumerate(zip(frames, paths, strict=True), start=1):
            camera = frame.camera.to(opened.gaussians.means.device)
            pixels = to_bytes(draw(camera).image).cpu().numpy()
            with atomic_path(path) as temporary:
                Image.fromarray(pixels).save(temporary, format="PNG")
            advance(done, len(frames))
    print(f"{len(frames)} pictures in {output}")


def render_orbit(
    scene: Path,
    output: Path,
    seconds: float,
    size: tuple[int, int],
    device: Device,
    backend: Literal["kernels", "gpu"],
) -> None:
    """Write a video of one turn around a scene."""
    from mobilegs.scene_file import choose_device
    from mobilegs.view.video import open_with_views, write_orbit

    opened, views = open_with_views(scene, choose_device(device))
    draw = drawing(opened, backend)
    width, height = size
    with progress_bar("drawing") as advance:
        options = {"seconds": seconds, "width": width, "height": height, "progress": advance}
        written = write_orbit(opened, views, output, draw=draw, **options)
    print(f"{output}: {written:,} bytes")


def drawing(scene: "Scene", backend: Literal["kernels", "gpu"]) -> Callable:
    """What draws a scene for a camera."""
    if backend == "kernels":
        return scene.render
    from mobilegs.view.wgpu_renderer import GpuRenderer

    return GpuRenderer(scene).draw


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
        scene: The scene: a .mgs file, or a .ply, .spz, .sog, .splat or .glb of plain 3DGS.
        capture: Folder of the capture; photos 0, 8, 16, ... by name are the held-back ones.
        json: Print the figures, by photo too, as JSON.
        downscale: Divide the photos' size by this. Without it they are at most 1600 wide.
        lpips_weights: Folder or http(s) address of LPIPS weights; MOBILEGS_LPIPS says the same.
        device: Where to draw; auto takes a GPU if there is one.
    """
    from mobilegs.evaluate import report
    from mobilegs.evaluate.lpips import lpips_from
    from mobilegs.scene_file import size_of

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
        "file_bytes": size_of(scene),
    }
    if json:
        print(report.to_json(about | result))
    else:
        print_figures(about, result)


def view(
    scene: SceneFile,
    /,
    *,
    lan: bool = False,
    port: int = 0,
    no_browser: bool = False,
    native: bool = False,
    compare: SceneFile | None = None,
) -> None:
    """Show a scene in the browser, on a phone in the same network, or in a window.

    A .mgs is drawn without sorting, a .ply or .spz sorted. Nothing but the scene and the viewer's
    own files is served, and the internet is not needed.

    Args:
        scene: The scene: a .mgs file, or a .ply or .spz of plain 3DGS.
        lan: Let other devices in the network open it; prints the address as a QR code.
        port: Where to listen; 0 takes any port that is free.
        no_browser: Open no browser here.
        native: Open a window that draws by Vulkan, Metal or DirectX 12; serve nothing.
        compare: Another scene, under the same camera behind a handle.
    """
    if native:
        if lan or port or no_browser or compare:
            raise InputError("--native shows one scene here: leave out --lan and the other options")
        from mobilegs.view.window import show

        return show(scene)
    from mobilegs.view.serve import serve

    serve(scene, compare, lan=lan, port=port, browser=not no_browser)


def export(
    scene: SceneFile,
    /,
    *,
    to: Literal["html", "site", "ply", "spz", "sog", "glb"],
    output: Annotated[Path, arg(aliases=["-o"], metavar="PATH")],
    title: str = "",
    url: Annotated[str, arg(metavar="ADDRESS")] = "",
    refit: bool = False,
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None,
    seed: int = 0,
    device: Device = "auto",
) -> None:
    """Put a scene and its viewer into an HTML file or a folder for any web host; or convert it.

    Other tools sort, which a .mgs is not made for: of one in its run the teacher goes in its place,
    any other is refitted by pictures of itself, which takes minutes, and the loss is measured.

    Args:
        scene: The scene: a .mgs file, or a .ply or .spz of plain 3DGS; for files of other tools
            also .sog, .splat and .glb.
        to: html: one file, which also works from a disk or an e-mail. site: a folder, which
            installs as an app where it is served by https, and then opens offline. ply, spz, sog,
            glb: a file for other tools, without the viewer.
        output: The file or folder to write.
        title: What the page is called; what the scene is of if it is not given.
        url: Where a site will lie, like https://me.example/garden/: services that preview links
            find its picture by that.
        refit: For files of other tools: refit a .mgs that lies in its run, too.
        capture: The photos of a .mgs that is refitted, with their poses. Without them it is looked
            at from where its run's photos were taken, or from places that the program finds.
        seed: Start of all random choices of a refit.
        device: Where a refit draws; auto takes an NVIDIA GPU if there is one.
    """
    if to == "html" or to == "site":
        from mobilegs.view.export import export_html, export_site, title_of

        if refit or capture or seed or device != "auto":
            raise InputError(
                "a page shows the scene itself: leave out --refit and what goes with it"
            )
        title = title or title_of(scene)
        if to == "site":
            size = export_site(scene, output, title=title, url=url)
        elif url:
            raise InputError("a page in one file may lie anywhere: leave out --url")
        else:
            size = export_html(scene, output, title=title)
    else:
        for option, value in (("title", title), ("url", url)):
            if value:
                raise InputError(f"a .{to} file has no {option}: leave out --{option}")
        how = {"refit": refit, "capture": capture, "seed": seed, "device": device}
        size = convert(scene, output, to, **how)
    print(f"{output}: {size:,} bytes")


def info(scene: SceneFile, /, *, json: bool = False) -> None:
    """Say what is in a scene's file, byte by byte.

    Args:
        scene: A .mgs file, or a .ply, .spz, .sog, .splat or .glb of plain 3DGS.
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
    from mobilegs.cli import doctor as checks
    from mobilegs.evaluate.report import to_json

    findings = checks.examine()
    if json:
        print(to_json(checks.as_json(findings)))
        return
    print_findings(findings)


# --- what the verbs share -------------------------------------------------------------------------


def open_both(
    scene: Path, capture: Path, downscale: int | None, device: Device
) -> tuple["Scene", "Dataset"]:
    """A scene on its device, and the capture over the same background.

    A .mgs knows its background; others take that of the capture.
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


# --- the way in -----------------------------------------------------------------------------------

VERBS: dict[str, Callable[..., None]] = {
    "demo": demo,
    "train": train,
    "compress": compress,
    "capture": capture,
    "render": render,
    "eval": evaluate,
    "view": view,
    "export": export,
    "info": info,
    "doctor": doctor,
}

HELP = """\
mobilegs {version}: 3D Gaussian splatting without sorting, in a file of a few megabytes.

Photos or a video become a capture (photos with poses: COLMAP, nerfstudio's transforms.json,
NeRF-synthetic); the capture a teacher, a plain 3DGS scene; the teacher a student that needs no
sorting; the student scene.mgs. A teacher may also come from another tool.

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
        # options of these are fields of dataclasses that are slow to import
        if verb in (train, compress, capture):
            verb(words[1:])
        else:
            tyro.cli(verb, prog=f"mobilegs {words[0]}", args=words[1:], config=CONFIG)
    except InputError as error:
        return fail(str(error), 2)
    except (MemoryError, RuntimeError) as error:  # a short file may ask for much
        if not isinstance(error, MemoryError) and "allocate" not in str(error):  # as torch says it
            raise
        return fail("there is too little memory for this", 2)
    except KeyboardInterrupt as error:
        return fail(str(error) or "interrupted", 130)
    except BrokenPipeError:  # `mobilegs ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        if not error.filename and error.errno != errno.ENOSPC:  # a full disk has no name
            raise
        return fail(": ".join(map(str, filter(None, (error.strerror, error.filename)))), 1)
    return 0


def fail(sentence: str, code: int) -> int:
    """Say on standard error why it ended, and with which exit code."""
    print(f"mobilegs: {sentence}", file=sys.stderr)
    return code
