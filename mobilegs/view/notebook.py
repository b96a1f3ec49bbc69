"""A scene as the output of a notebook's cell: the exported page in a frame."""

import html
from pathlib import Path
from tempfile import TemporaryDirectory

from mobilegs.errors import InputError
from mobilegs.formats.ply import write_ply
from mobilegs.mgs.codec import write_mgs
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render.scene import Scene
from mobilegs.view.export import export_html, title_of

MEGABYTES_MAX = 25  # of a scene's file: notebooks keep outputs in theirs
STYLE = "width: 100%; height: 480px; border: 0; border-radius: 8px"


def scene_html(scene: Scene | QuantizedScene) -> str:
    """Return the exported page of a scene in a frame, which needs no server and no network.

    A sentence takes its place if the scene's file has more than 25 MB, if no viewer shows it, or if
    the scene is sort-free and does not come from a file: only its training can write one.
    """
    with TemporaryDirectory() as folder:
        page = Path(folder, "page.html")
        try:
            file = file_of(scene, Path(folder))
            megabytes = file.stat().st_size / 1e6
            if megabytes > MEGABYTES_MAX:
                raise InputError(
                    f"this scene has {megabytes:.0f} MB, and a notebook shows up to "
                    f"{MEGABYTES_MAX} MB: `mobilegs view` shows its file"
                )
            export_html(file, page, title=title_of(file))
        except InputError as error:
            return f"<p>{html.escape(str(error))}</p>"
        content = html.escape(page.read_text(encoding="utf-8"))
    # without the notebook's origin: titles and notes are those of a file
    return (
        f'<iframe srcdoc="{content}" style="{STYLE}" sandbox="allow-scripts allow-pointer-lock" '
        'allow="fullscreen; xr-spatial-tracking"></iframe>'
    )


def file_of(scene: Scene | QuantizedScene, folder: Path) -> Path:
    """Return the file of a scene, written into `folder` if the scene can be written."""
    if isinstance(scene, QuantizedScene):
        write_mgs(folder / "scene.mgs", scene)
        return folder / "scene.mgs"
    if scene.is_plain:
        options = {"footprint": scene.footprint.drawn(scene.blend), "up": scene.up}
        write_ply(folder / "scene.ply", scene.gaussians.detached(), **options)
        return folder / "scene.ply"
    if scene.file is None:
        raise InputError("a sort-free scene shows itself if open_scene has read it from a file")
    return scene.file
