"""The stages of a row: fetch, poses, train, export. Each continues what an earlier try left."""

from pathlib import Path

from PIL import Image

from mobilegs.atomic import atomic_write
from mobilegs.batch.columns import Options, exports_of, kind_of, run_of, validate_row
from mobilegs.batch.fetch import fetch
from mobilegs.batch.row_folder import RowFolder
from mobilegs.batch.task import Task
from mobilegs.capture import CaptureRun, capture_photos
from mobilegs.errors import InputError
from mobilegs.pipeline.compress import CompressRun, compress_scene
from mobilegs.pipeline.export_sorted import SortedExport, export_sorted
from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_capture
from mobilegs.progress_display import show_progress
from mobilegs.train.run_dir import RunDir
from mobilegs.view.export import export_html, export_site, title_of
from mobilegs.view.poster import jpeg, posters_of
from mobilegs.view.report import write_report

POSTER = (800, 420)  # pixels


def run_stage(task: Task, folder: RowFolder) -> None:
    """Run the stage of a task; raises InputError as the single commands do."""
    row = folder.load_row()
    assert row is not None, "the batch writes the row before its first task"
    source, options = row["source"], row["options"]
    if task.stage == "fetch":
        path = fetch(task.source, Path(task.cache))
        kind = kind_of(path)
        validate_row(options, row["own"], kind)
        folder.set_place(path, kind)
        return
    place = folder.place()
    if place is None:
        raise InputError(f"{source} is no longer there")
    path, kind = place
    device = "cuda" if task.gpus else "cpu"
    if task.stage == "poses":
        run = run_of(CaptureRun, options, source=path, output=folder.capture)
        capture_photos(run, progress=show_progress)
    elif task.stage == "export":
        export(folder, options)
    elif kind == "scene":
        given = {"scene": path, "output": folder.path, "resume": True, "device": device}
        compress_scene(run_of(CompressRun, options, **given), progress=show_progress)
    else:
        capture = folder.capture if kind == "photos" else path
        given = {"capture": capture, "output": folder.path, "resume": True, "device": device}
        train_capture(run_of(TrainRun, options, **given), progress=show_progress)


def export(folder: RowFolder, options: Options) -> None:
    """Write the report, the poster and all exports of a trained row."""
    run = RunDir(folder.path)
    write_report(run)
    write_poster(run.scene, folder.poster)
    heading = options.get("title", "")
    title = heading or title_of(run.scene)
    for kind in exports_of(options):
        if kind == "html":
            export_html(run.scene, folder.page, title=title, heading=heading)
        elif kind == "site":
            export_site(run.scene, folder.site, title=title, heading=heading)
        else:
            output = folder.page.with_name(f"{folder.path.name}.{kind}")
            export_sorted(SortedExport(run.scene, output, kind), progress=show_progress)


def write_poster(scene: Path, output: Path) -> None:
    """Write the first view of a scene as a JPEG; none for a scene that the viewer does not show."""
    try:
        image = posters_of(scene).preview
    except InputError:
        return
    atomic_write(output, jpeg(image.resize(POSTER, Image.Resampling.LANCZOS)))
