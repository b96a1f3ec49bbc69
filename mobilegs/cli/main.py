"""The command line: one function per verb, whose docstring is its help.

Heavy modules are imported when a verb runs, so that `--help` answers at once.
"""

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from mobilegs import __version__
from mobilegs.atomic import disk_error
from mobilegs.cli.batch import batch
from mobilegs.cli.edit import NO_EDITS, EditOptions, convert_edited, edit, edited_copy
from mobilegs.cli.options import call
from mobilegs.cli.output import print_contents, print_findings, print_metrics
from mobilegs.cli.render import Device, Up, open_scene_and_capture, render, usual_capture
from mobilegs.cli.train import capture, compress, convert, demo, train
from mobilegs.errors import InputError, printable
from mobilegs.formats import Export
from mobilegs.progress_display import printed_log, show_progress

SceneFile = Annotated[Positional[Path], arg(metavar="SCENE")]  # or a run's folder


def evaluate(
    scene: SceneFile,
    *,
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None,
    json: bool = False,
    downscale: Annotated[int | None, arg(metavar="N")] = None,
    lpips_weights: Annotated[str | None, arg(metavar="DIR")] = None,
    device: Device = "auto",
) -> None:
    """Compare a scene with held-back photos: PSNR, SSIM and LPIPS.

    Renders are rounded to 8 bits, masked pixels do not count, and all photos have the same weight.
    cc_psnr is the PSNR after a change of each render's colours that fits its photo best: it does
    not count exposure and white balance. neutral_rms is the error of colour where a photo is white
    or grey, of 255; coloured noise shows there first. There are two conventions for LPIPS, whose
    values cannot be compared: lpips_vgg and lpips_alex give the network images in [0, 1], as 3DGS
    does; lpips_vgg_rescaled and lpips_alex_rescaled give it images in [-1, 1], for which LPIPS was
    calibrated. Photos smaller than those of the training are compared with larger renders,
    averaged, as the viewers show them.

    Args:
        scene: A .mgs file, a run's folder, or a plain 3DGS scene: .ply, .spz, .sog, .splat or .glb.
        capture: Folder of the capture. The held-back photos are numbers 0, 8, 16, ... by name, or
            those of transforms_test.json. Default: the capture of the scene's run.
        json: Print the metrics of each photo and their means as JSON.
        downscale: Divide the width and height of the photos by N. Default: as in the scene's run;
            for other scenes, reduce photos to a width of at most 1600 pixels.
        lpips_weights: Folder or http(s) address of LPIPS weights. Default: the environment
            variable MOBILEGS_LPIPS; if that is not set, LPIPS is not measured.
        device: Device that renders; auto takes an NVIDIA GPU if there is one.
    """
    from mobilegs.evaluate import report
    from mobilegs.evaluate.fragments import mean_fragments
    from mobilegs.evaluate.lpips import lpips_from
    from mobilegs.render.levels import usual_level_sigma
    from mobilegs.scene_file import scene_at, size_of

    scene = scene_at(scene)
    capture, downscale = usual_capture(scene, capture, downscale)
    opened, views, dataset = open_scene_and_capture(scene, capture, downscale, device)
    lpips = lpips_from(lpips_weights)
    with show_progress("evaluating", data=json) as advance:
        result = report.evaluate(
            opened, dataset, training_views=views, lpips=lpips, progress=advance
        )
        cameras = [frame.camera for frame in dataset.test]
        fragments, levels = sum(mean_fragments(opened, cameras)), None
        if opened.blend == "sortfree":
            sigma = usual_level_sigma(soft_edge=opened.footprint.soft_edge)
            levels = mean_fragments(opened, cameras, level_sigma=sigma)
    about = {
        "scene": str(scene),
        "capture": str(capture),
        "downscale": downscale,
        "blend": opened.blend,
        "gaussians": len(opened.gaussians),
        "file_bytes": size_of(scene),
        "fragments": fragments,
    }
    if levels is not None:
        about["fragments_by_level"] = levels
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
    up: Up = None,
) -> None:
    """Show a scene in the browser, on a phone, or in a window.

    A .mgs file is rendered without sorting; a .ply or .spz is sorted. The server sends only the
    scene and the viewer, and needs no internet connection.

    Args:
        scene: A .mgs file, a run's folder, or a .ply or .spz of plain 3DGS.
        lan: Let other devices in the network open the scene, and print its address as a QR code.
        port: Port of the server. Default: a free port.
        no_browser: Do not open the browser.
        native: Show the scene in a window instead of the browser, with Vulkan, Metal, DirectX 12 or
            OpenGL.
        compare: A second scene. Both have the same camera, and a slider divides the view.
        up: Axis of the scene that points up; while the scene is shown, the key U changes it.
            Default: as the file or its cameras tell, otherwise -y.
    """
    from mobilegs.scene_file import scene_at

    if native and (lan or port or no_browser or compare):
        raise InputError("--native shows one scene here: leave out --lan and the other options")
    scene, compare = scene_at(scene), None if compare is None else scene_at(compare)
    if native:
        from mobilegs.view.window import show

        return show(scene, up)
    from mobilegs.view.serve import serve

    serve(scene, compare, up=up, lan=lan, port=port, browser=not no_browser)


def export(
    scene: SceneFile,
    *,
    to: Export,
    output: Annotated[Path, arg(aliases=["-o"], metavar="PATH")],
    title: Annotated[str, arg(metavar="TEXT")] = "",
    url: Annotated[str, arg(metavar="ADDRESS")] = "",
    up: Up = None,
    edits: EditOptions = NO_EDITS,
    refit: bool = False,
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None,
    seed: Annotated[int, arg(metavar="N")] = 0,
    device: Device = "auto",
) -> None:
    """Export a scene as a web page or a web site, or convert it.

    The options of `mobilegs edit` change what is exported, not the scene's own file. Converted
    scenes can lose Gaussians, and have no place for the rest.

    The formats ply, spz, sog and glb are for tools that sort Gaussians. A .mgs file is made for
    rendering without sorting, so it cannot be converted directly. If the .mgs lies in the folder
    of its run, the run's teacher is exported instead. Otherwise the scene is refitted: trained
    for sorted blending on renders of itself. This takes minutes; the loss of quality is printed.

    Args:
        scene: A .mgs file, a run's folder, or a .ply or .spz of plain 3DGS. To ply, spz, sog and
            glb, also a .sog, .splat or .glb.
        to: html: one file with scene and viewer, which also opens from a disk or an e-mail. site:
            a folder for any web host; over https it can be installed as an app and opens offline.
            ply, spz, sog, glb: a file for other tools.
        output: The file or folder to write.
        title: Title of the page. Default: the name of the capture, or of the file.
        url: Address that the site will have, like https://me.example/garden/. Services that
            preview links need it to find the image.
        up: Axis of the scene that points up. A .ply names it; spz, sog and glb have their own, to
            which the scene is turned. Default: as the file or its cameras tell, otherwise -y.
        refit: Refit the .mgs even if its teacher is there.
        capture: Capture whose cameras a refit uses, and which --min-cameras and --remove-floaters
            count. Default: the capture of the run; for a refit without one, cameras that the
            program places.
        seed: Seed of all random choices of a refit.
        device: Device of a refit; auto takes an NVIDIA GPU if there is one.
    """
    from mobilegs.scene_file import scene_at

    scene = scene_at(scene)
    if to == "html" or to == "site":
        from mobilegs.view.export import export_html, export_site, title_of
        from mobilegs.view.serve import validate_scene_file

        counts = edits.min_cameras or edits.remove_floaters
        if refit or (capture and not counts) or seed or device != "auto":
            raise InputError(
                "a page shows the scene itself: leave out --refit, --capture, --seed and --device"
            )
        if url and to == "html":
            raise InputError("a page in one file needs no address: leave out --url")
        validate_scene_file(scene)
        with edited_copy(scene, edits, title=title, capture=capture) as (copy, notes):
            options = {"up": up, "heading": title, "notes": notes}
            title = title or title_of(scene)
            if to == "site":
                size = export_site(copy, output, title=title, url=url, **options)
            else:
                size = export_html(copy, output, title=title, **options)
    else:
        for option, value in (("title", title), ("url", url)):
            if value:
                raise InputError(f"a .{to} file has no {option}: leave out --{option}")
        options = {"refit": refit, "capture": capture, "seed": seed, "device": device}
        if edits == NO_EDITS:
            size = convert(scene, output, to, up=up, **options)
        else:
            size = convert_edited(scene, output, to, edits, up=up, **options)
    print(printable(f"{output}: {size:,} bytes"))


def info(scene: SceneFile, *, json: bool = False) -> None:
    """Describe a scene's file: its Gaussians, and the bytes of each part.

    Args:
        scene: A .mgs file, a run's folder, or a plain 3DGS scene: .ply, .spz, .sog, .splat or .glb.
        json: Print the description as JSON.
    """
    from mobilegs.evaluate.report import to_json
    from mobilegs.scene_file import inspect_scene, scene_at

    contents = inspect_scene(scene_at(scene))
    if json:
        print(to_json(contents))
    else:
        print_contents(contents)


def doctor(*, json: bool = False) -> None:
    """List what works on this machine, and how to install what does not.

    Args:
        json: Print the list as JSON.
    """
    from mobilegs.cli import doctor as checks
    from mobilegs.evaluate.report import to_json

    findings = checks.examine()
    if json:
        print(to_json([asdict(finding) for finding in findings]))
        return
    print_findings(findings)


VERBS: dict[str, Callable[..., None]] = {
    "demo": demo,
    "train": train,
    "compress": compress,
    "capture": capture,
    "batch": batch,
    "render": render,
    "eval": evaluate,
    "view": view,
    "edit": edit,
    "export": export,
    "info": info,
    "doctor": doctor,
}

HELP = """\
mobilegs {version}: 3D Gaussian splatting without sorting, in a few megabytes.

  mobilegs VERB ...          mobilegs VERB --help

{verbs}

`train` has three stages. It computes the camera poses of the photos; photos
with poses, as from COLMAP, nerfstudio or NeRF-synthetic, are a capture. It
trains a teacher on the capture: a plain 3DGS scene. It trains a student on
teacher and capture: a scene that needs no sorting, which it writes to
scene.mgs. `demo` does the same with a small capture of its own.

Environment: MOBILEGS_LPIPS is the folder or http(s) address of LPIPS weights.
Exit codes: 0 success; 2 input that cannot be used, or a full disk (the message
says why); 130 interrupted; 1 an error of the program, or failed rows of a batch.
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
        return fail(f"there is no verb '{words[0]}': use one of {', '.join(VERBS)}", code=2)
    try:
        with printed_log():
            if verb in (train, compress, capture):  # options are dataclasses, imported late
                verb(words[1:])
            else:
                call(verb, words[1:], verb=words[0])
    except (InputError, FloatingPointError) as error:  # a training has diverged
        return fail(*error.args, code=2)
    except (MemoryError, RuntimeError) as error:  # a small file can request much memory
        if not isinstance(error, MemoryError) and "allocate" not in str(error):  # torch's message
            raise
        return fail("there is not enough memory for this", code=2)
    except KeyboardInterrupt as error:
        return fail(str(error) or "interrupted", code=130)
    except BrokenPipeError:  # `mobilegs ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        reason = disk_error(error)  # a disk's errors have no file name
        if not error.filename and not reason:
            raise
        parts = (error.filename, reason or error.strerror)
        return fail(": ".join(map(str, filter(None, parts))), code=2)
    except ImportError as error:  # a damaged installation, or too little memory for a library
        if isinstance(error, ModuleNotFoundError):
            raise
        return fail(f"a library cannot be loaded ({error}): free memory, or reinstall it", code=2)
    return 0


def fail(*sentences: object, code: int) -> int:
    """Print why the program ends to standard error, a line each, and return the exit code."""
    for number, sentence in enumerate(sentences):
        print(f"{'' if number else 'mobilegs: '}{printable(str(sentence))}", file=sys.stderr)
    return code
