"""The verb `render`: images for the cameras of a capture, or a video around a scene."""

from collections.abc import Callable, Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from mobilegs.errors import InputError, printable
from mobilegs.progress_display import show_progress
from mobilegs.up import Axis

if TYPE_CHECKING:
    from mobilegs.camera import Camera
    from mobilegs.data.dataset import Dataset, Frame
    from mobilegs.render.scene import Scene

Device = Annotated[str, arg(metavar="{auto,cpu,cuda,cuda:N}")]
Up = Annotated[Axis | None, arg(metavar="{x,-x,y,-y,z,-z}")]
Renderer = Literal["kernels", "wgpu"]


def render(
    scene: Annotated[Positional[Path], arg(metavar="SCENE")],
    *,
    capture: Annotated[Path | None, arg(metavar="CAPTURE")] = None,
    output: Annotated[Path | None, arg(aliases=["-o"], metavar="DIR")] = None,
    orbit: Annotated[Path | None, arg(metavar="MP4")] = None,
    split: Literal["test", "train"] = "test",
    downscale: Annotated[int | None, arg(metavar="N")] = None,
    seconds: Annotated[float, arg(metavar="SECONDS")] = 8.0,
    size: Annotated[tuple[int, int], arg(metavar="WIDTH HEIGHT")] = (1280, 720),
    up: Up = None,
    device: Device = "auto",
    renderer: Renderer = "kernels",
) -> None:
    """Render a scene with the cameras of a capture, or as a video of one turn.

    Give either -o or --orbit. -o renders one PNG for each photo of --capture, with the photo's
    camera and name: IMG_0042.JPG becomes IMG_0042.png. A .mgs file is rendered without sorting;
    other scenes are sorted.

    Args:
        scene: A .mgs file, a run's folder, or a plain 3DGS scene: .ply, .spz, .sog, .splat or .glb.
        capture: Folder of the capture. Default: the capture of the scene's run.
        output: Folder for the PNGs; created if missing.
        orbit: Video to write: one turn around the scene.
        split: Photos whose cameras are used: the held-back ones (test) or the others (train).
        downscale: Divide the width and height of the photos by N. Default: as in the scene's run;
            for other scenes, reduce photos to a width of at most 1600 pixels.
        seconds: Length of the video.
        size: Size of the video in pixels.
        up: Axis of the scene that points up in the video. Default: as the file or its cameras tell,
            otherwise -y.
        device: Device that renders; auto takes an NVIDIA GPU if there is one.
        renderer: kernels: the renderer of the training, on --device. wgpu: the renderer of the
            viewer, in float16, on any GPU with Vulkan, Metal, DirectX 12 or OpenGL.
    """
    from mobilegs.scene_file import scene_at

    scene = scene_at(scene)
    if renderer == "wgpu":
        device = "cpu"  # only reads the scene
    if orbit is not None:
        if capture or output or downscale:
            raise InputError("--orbit needs no photos: leave out --capture, -o and --downscale")
        return render_orbit(scene, orbit, seconds, size, up, device, renderer)
    if up is not None:
        raise InputError("the cameras of the photos are used: --up is for --orbit")
    if output is None:
        raise InputError(
            "there is nothing to render: give --capture CAPTURE -o DIR, or --orbit MP4"
        )
    capture, downscale = usual_capture(scene, capture, downscale)
    render_photos(scene, capture, output, split, downscale, device, renderer)


def render_photos(
    scene: Path,
    capture: Path,
    output: Path,
    split: Literal["test", "train"],
    downscale: int | None,
    device: Device,
    renderer: Renderer,
) -> None:
    """Write a PNG for each photo of a split."""
    import torch
    from PIL import Image

    from mobilegs.atomic import atomic_path
    from mobilegs.evaluate.metrics import to_bytes

    opened, views, dataset = open_scene_and_capture(scene, capture, downscale, device)
    frames = dataset.test if split == "test" else dataset.train
    if not frames:
        raise InputError(f"{capture} has no {split} photos")
    paths = image_paths(frames, dataset, output)
    draw = draw_function(opened, views, renderer)
    with torch.inference_mode(), show_progress("rendering") as advance:
        for done, (frame, path) in enumerate(zip(frames, paths, strict=True), start=1):
            camera = frame.camera.to(opened.gaussians.means.device)
            pixels = to_bytes(draw(camera).image).cpu().numpy()
            with atomic_path(path) as temporary:
                Image.fromarray(pixels).save(temporary, format="PNG")
            advance(done, len(frames))
    print(printable(f"{output}: {len(frames)} images"))


def render_orbit(
    scene: Path,
    output: Path,
    seconds: float,
    size: tuple[int, int],
    up: Axis | None,
    device: Device,
    renderer: Renderer,
) -> None:
    """Write a video of one turn around a scene."""
    from mobilegs.device import choose_device
    from mobilegs.scene_file import open_with_views, up_source
    from mobilegs.view.video import write_orbit

    opened, views = open_with_views(scene, choose_device(device))
    draw = draw_function(opened, views, renderer)
    width, height = size
    with show_progress("rendering") as advance:
        options = {"seconds": seconds, "width": width, "height": height, "progress": advance}
        written = write_orbit(opened, views, output, up=up, draw=draw, **options)
    print(printable(f"{output}: {written:,} bytes"))
    if up is None and opened.up is None:
        print(f"up is {up_source(scene, None)} (--up changes it)")


def draw_function(
    scene: "Scene", views: "Sequence[Camera]", renderer: Renderer
) -> "Callable[[Camera], Any]":
    """Return a function that renders the scene for a camera to an object with an `image`.

    Images smaller than those of the training `views` are rendered larger and averaged.
    """
    from mobilegs.render.supersampling import supersampling_for

    render: Callable[..., Any] = scene.render
    if renderer == "wgpu":
        from mobilegs.view.wgpu_renderer import WgpuRenderer

        render = WgpuRenderer(scene).render
    return lambda camera: render(camera, supersampling=supersampling_for(camera, views))


def usual_capture(
    scene: Path, capture: Path | None, downscale: int | None
) -> tuple[Path, int | None]:
    """Return the capture and the divisor of its photos, by default those of the scene's run.

    Raises InputError if no capture is given and the run's is not known or not there.
    """
    from mobilegs.scene_file import capture_of_run

    own, own_downscale = capture_of_run(scene)
    if capture is None:
        capture = own
    if capture is None:
        raise InputError(f"give --capture CAPTURE: {scene} does not lie in a run with its capture")
    return capture, own_downscale if downscale is None else downscale


def open_scene_and_capture(
    scene: Path, capture: Path, downscale: int | None, device: Device
) -> "tuple[Scene, list[Camera], Dataset]":
    """Open a scene on its device, its training views, and a capture with the same background.

    The background is that of a .mgs, and for other scenes that of the capture. The capture of the
    scene's run has the poses that the run refined.
    """
    from dataclasses import replace

    from mobilegs.data import load_capture
    from mobilegs.device import choose_device
    from mobilegs.scene_file import capture_of_run, open_with_views
    from mobilegs.train.poses import with_poses
    from mobilegs.train.run_dir import RunDir

    opened, views = open_with_views(scene, choose_device(device))
    coded = scene.suffix.lower() == ".mgs"
    color = tuple(opened.background.tolist()) if coded else None
    dataset = load_capture(capture, downscale=downscale, background=color)
    own, poses = capture_of_run(scene)[0], RunDir(scene.parent).poses
    if own is not None and own.samefile(capture) and poses.exists():
        dataset = with_poses(dataset, poses)
    if coded:
        return opened, views, dataset
    background = dataset.background.to(opened.background.device)
    return replace(opened, background=background, near=dataset.near), views, dataset


def image_paths(frames: "Sequence[Frame]", dataset: "Dataset", output: Path) -> list[Path]:
    """Return a path in `output` for the image of each frame.

    Raises InputError if that is one of the capture's own photos or masks.
    """
    names = png_names([frame.name for frame in frames])
    paths = [output / names[frame.name] for frame in frames]
    inputs = set()
    for frame in (*dataset.train, *dataset.test):
        inputs |= {path.resolve() for path in (frame.image_path, frame.mask_path) if path}
    for path in paths:
        if path.resolve() in inputs:
            raise InputError(f"{path} is a photo of the capture: give another folder for images")
    return paths


def png_names(photos: Sequence[str]) -> dict[str, Path]:
    """Return the relative path of each photo's PNG: the name of the photo with another suffix.

    Photos that differ only in their suffix keep it: a.jpg, a.png -> a.jpg.png, a.png.png. Parts of
    a name that would leave the output folder are dropped, because captures are not trusted.
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
