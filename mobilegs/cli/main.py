"""The command line: one function per verb, whose docstring is its help.

Heavy modules are imported when a verb runs, so that `--help` answers at once.
"""

import errno
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg

from mobilegs import __version__
from mobilegs.cli.options import call
from mobilegs.cli.output import print_contents, print_findings, print_metrics, progress_bar
from mobilegs.cli.render import Device, open_scene_and_capture, render
from mobilegs.cli.train import capture, compress, convert, demo, train
from mobilegs.errors import InputError

SceneFile = Annotated[Positional[Path], arg(metavar="SCENE")]


def evaluate(
    scene: SceneFile,
    *,
    capture: Annotated[Path, arg(metavar="CAPTURE")],
    json: bool = False,
    downscale: Annotated[int | None, arg(metavar="N")] = None,
    lpips_weights: Annotated[str | None, arg(metavar="DIR")] = None,
    device: Device = "auto",
) -> None:
    """Compare a scene with held-back photos: PSNR, SSIM and LPIPS.

    Renders are rounded to 8 bits, masked pixels do not count, and all photos have the same weight.
    lpips_vgg and lpips_alex feed images in [0, 1] to the network, as 3DGS does. The _rescaled
    values scale images to [-1, 1], as LPIPS was calibrated. The two cannot be compared.

    Args:
        scene: A .mgs file, or a plain 3DGS scene: .ply, .spz, .sog, .splat or .glb.
        capture: Folder of the capture. Photos 0, 8, 16, ... by name are held back.
        json: Print all metrics, also by photo, as JSON.
        downscale: Divide the width and height of the photos by N. Default: reduce photos to a
            width of at most 1600 pixels.
        lpips_weights: Folder or http(s) address of LPIPS weights. Default: the environment
            variable MOBILEGS_LPIPS; without either, LPIPS is not measured.
        device: Device that renders; auto takes an NVIDIA GPU if there is one.
    """
    from mobilegs.evaluate import report
    from mobilegs.evaluate.lpips import lpips_from
    from mobilegs.scene_file import size_of

    opened, dataset = open_scene_and_capture(scene, capture, downscale, device)
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
        print_metrics(about, result)


def view(
    scene: SceneFile,
    *,
    lan: bool = False,
    port: Annotated[int, arg(metavar="PORT")] = 0,
    no_browser: bool = False,
    native: bool = False,
    compare: Annotated[Path | None, arg(metavar="SCENE")] = None,
) -> None:
    """Show a scene in the browser, on a phone, or in a window.

    A .mgs file is rendered without sorting, a .ply or .spz is sorted. Only the scene and the
    viewer's own files are served, and no internet connection is needed.

    Args:
        scene: A .mgs file, or a .ply or .spz of plain 3DGS.
        lan: Allow other devices in the network to open the scene; prints the address as a QR code.
        port: Port to listen at. Default: a free port.
        no_browser: Do not open the browser.
        native: Open a window that renders with Vulkan, Metal or DirectX 12 instead of a page.
        compare: Another scene, shown with the same camera on the other side of a slider.
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
    *,
    to: Literal["html", "site", "ply", "spz", "sog", "glb"],
    output: Annotated[Path, arg(aliases=["-o"], metavar="PATH")],
    title: Annotated[str, arg(metavar="TEXT")] = "",
    url: Annotated[str, arg(metavar="ADDRESS")] = "",
    refit: bool = False,
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None,
    seed: Annotated[int, arg(metavar="N")] = 0,
    device: Device = "auto",
) -> None:
    """Export a scene as a web page or a web site, or convert it.

    Other tools sort Gaussians, but a .mgs file is made for rendering without sorting. For a .mgs
    in its run's folder, the run's teacher is exported. Any other .mgs is refitted to sorted
    blending with renders of itself, which takes minutes; the loss is measured and printed.

    Args:
        scene: A .mgs file, or a .ply or .spz of plain 3DGS; for other tools also .sog, .splat and
            .glb.
        to: html: one file that also works from a disk or an e-mail. site: a folder for any web
            host; served by https, it installs as an app and opens offline. ply, spz, sog, glb: a
            file for other tools, without the viewer.
        output: The file or folder to write.
        title: Title of the page. Default: the name of the capture or file.
        url: Future address of a site, like https://me.example/garden/, by which services that
            preview links find its image.
        refit: For other tools, also refit a .mgs in its run's folder.
        capture: Photos with poses, whose cameras a refit renders from. Default: the capture of the
            run, or cameras that the program places.
        seed: Seed of all random choices of a refit.
        device: Device of a refit; auto takes an NVIDIA GPU if there is one.
    """
    if to == "html" or to == "site":
        from mobilegs.view.export import export_html, export_site, title_of

        if refit or capture or seed or device != "auto":
            raise InputError(
                "a page shows the scene itself: leave out --refit, --capture, --seed and --device"
            )
        title = title or title_of(scene)
        if to == "site":
            size = export_site(scene, output, title=title, url=url)
        elif url:
            raise InputError("a page in one file needs no address: leave out --url")
        else:
            size = export_html(scene, output, title=title)
    else:
        for option, value in (("title", title), ("url", url)):
            if value:
                raise InputError(f"a .{to} file has no {option}: leave out --{option}")
        options = {"refit": refit, "capture": capture, "seed": seed, "device": device}
        size = convert(scene, output, to, **options)
    print(f"{output}: {size:,} bytes")


def info(scene: SceneFile, *, json: bool = False) -> None:
    """Describe a scene's file: its Gaussians, and the bytes of each part.

    Args:
        scene: A .mgs file, or a plain 3DGS scene: .ply, .spz, .sog, .splat or .glb.
        json: Print the description as JSON.
    """
    from mobilegs.evaluate.report import to_json
    from mobilegs.scene_file import inspect_scene

    found = inspect_scene(scene)
    if json:
        print(to_json(found))
    else:
        print_contents(found)


def doctor(*, json: bool = False) -> None:
    """List what works on this machine, and how to install what does not.

    Args:
        json: Print the list as JSON.
    """
    from mobilegs.cli import doctor as checks
    from mobilegs.evaluate.report import to_json

    findings = checks.examine()
    if json:
        print(to_json(checks.as_json(findings)))
        return
    print_findings(findings)


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
mobilegs {version}: 3D Gaussian splatting without sorting, in a few megabytes.

  mobilegs VERB ...          mobilegs VERB --help

{verbs}

`train` works in three stages. Photos or a video become a capture: photos with
camera poses, as from COLMAP, nerfstudio or NeRF-synthetic. The capture trains a
teacher, a plain 3DGS scene. The teacher trains a student that needs no sorting,
which is written to scene.mgs. `demo` shows all of this on a small example.

Environment: MOBILEGS_LPIPS is a folder or http(s) address of LPIPS weights.
Exit codes: 0 success, 1 a failure such as a full disk, 2 input that cannot be
used (the message says why), 130 interrupted.
"""


def help_text() -> str:
    """Return the text of `mobilegs --help`: every verb with the first line of its docstring."""
    lines = [
        f"  {name:<8} {(verb.__doc__ or '').strip().splitlines()[0]}"
        for name, verb in VERBS.items()
    ]
    return HELP.format(version=__version__, verbs="\n".join(lines))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code; `arguments` default to those of the process.

    Raises SystemExit after `VERB --help` (0) and for unknown or missing options (2).
    """
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
        if verb in (train, compress, capture):  # read their options from dataclasses, imported late
            verb(words[1:])
        else:
            call(verb, words[1:], verb=words[0])
    except InputError as error:
        return fail(str(error), 2)
    except (MemoryError, RuntimeError) as error:  # a small file can request much memory
        if not isinstance(error, MemoryError) and "allocate" not in str(error):  # torch's message
            raise
        return fail("there is not enough memory for this", 2)
    except KeyboardInterrupt as error:
        return fail(str(error) or "interrupted", 130)
    except BrokenPipeError:  # `mobilegs ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        if not error.filename and error.errno != errno.ENOSPC:  # a full disk has no file name
            raise
        return fail(": ".join(map(str, filter(None, (error.strerror, error.filename)))), 1)
    return 0


def fail(message: str, code: int) -> int:
    """Print why the program ends to standard error, and return the exit code."""
    print(f"mobilegs: {message}", file=sys.stderr)
    return code
