"""Evaluation of scenes on held-back photos: metrics per view and their means."""

import json
import logging
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypedDict, cast

import torch

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.lpips import LPIPS_NAMES, LpipsSuite
from mobilegs.evaluate.metrics import (
    color_corrected_psnr,
    displayed_colors,
    neutral_rms,
    psnr,
    ssim,
)
from mobilegs.render.levels import usual_level_sigma
from mobilegs.render.scene import Scene
from mobilegs.render.supersampling import supersampling_for

log = logging.getLogger(__name__)
METRICS = ("psnr", "cc_psnr", "ssim", "neutral_rms", *LPIPS_NAMES)
OF_SOME = ("neutral_rms",)  # which photos may lack


class Metrics(TypedDict):
    """Metrics of a render against a photo, or their means.

    Attributes:
        psnr: in dB; infinite for equal images, which JSON has as null.
        cc_psnr: in dB, after the change of a render's colours that fits its photo best.
        ssim: -1 to 1.
        neutral_rms: error of colour in whites and greys, of 255 (`evaluate/metrics.py`); None if
            there are few. The mean is over the photos that have some.
        lpips_vgg, lpips_vgg_rescaled, lpips_alex, lpips_alex_rescaled: from 0, lower is better
            (`evaluate/lpips.py`); None without weights and for sides below 32 pixels.
    """

    psnr: float
    cc_psnr: float
    ssim: float
    neutral_rms: float | None
    lpips_vgg: float | None
    lpips_vgg_rescaled: float | None
    lpips_alex: float | None
    lpips_alex_rescaled: float | None


class ViewMetrics(Metrics):
    """Metrics of a render against the photo `name`."""

    name: str


class SceneMetrics(Metrics):
    """Means over the held-back photos, and in `views` the metrics of each photo."""

    views: list[ViewMetrics]


class FileMetrics(SceneMetrics):
    """Metrics of a scene's file.

    Attributes:
        file_bytes: size of the file.
        gaussians: number of Gaussians.
        front: share of light lost before the teacher's surfaces, 0 to 1
            (`evaluate/front.py`); None if no held-back photo shows enough of them.
    """

    file_bytes: int
    gaussians: int
    front: float | None


class RunMetrics(TypedDict):
    """The content of a run's `metrics.json`. A PSNR of null is that of images without error.

    Attributes:
        teacher: metrics of `teacher.ply`.
        student: metrics of `scene.mgs`.
        formats: of a given teacher, as `.sog` and `.spz`: `file_bytes`, and means of `psnr`, `ssim`
            and `neutral_rms`; empty for a teacher that the run trained.
        seconds: time of each stage: `teacher`, `student` and `evaluation`.
        peak_memory_mib: of the process that measured, with torch's memory on the GPU; None where
            the system does not tell.
        capture: name of the capture.
        image_size: width and height of the first held-back photo, in pixels.
        views: number of photos, `train` and `test`.
        exposures: by stage, the `spread` of the photos' exposures, and whether they are `learned`.
        poses: `refined` or `as given`.
        seed: of all random choices.
        device: that trained.
    """

    teacher: FileMetrics
    student: FileMetrics
    formats: dict[str, Any]
    seconds: dict[str, float]
    peak_memory_mib: float | None
    capture: str
    image_size: list[int]
    views: dict[str, int]
    exposures: dict[str, Any]
    poses: str
    seed: int
    device: str


def evaluate(
    scene: Scene,
    dataset: Dataset,
    *,
    training_views: Sequence[Camera] = (),
    lpips: LpipsSuite | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> SceneMetrics:
    """Evaluate one scene on the held-back views; see `evaluate_side_by_side`."""
    options = {"training_views": training_views, "lpips": lpips, "progress": progress}
    return evaluate_side_by_side({"scene": scene}, dataset, **options)["scene"]


@torch.inference_mode()
def evaluate_side_by_side(
    scenes: Mapping[str, Scene],
    dataset: Dataset,
    *,
    training_views: Sequence[Camera] = (),
    lpips: LpipsSuite | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, SceneMetrics]:
    """Render the held-back views of every scene and compare them with the photos.

    Scenes are drawn as viewers draw them: sort-free ones with `usual_level_sigma`. Renders are
    rounded to 8 bits, and masked pixels do not count. The result has the metrics of
    each scene by its name. The scenes share the LPIPS features of the photos. Photos smaller than
    those of the `training_views` are compared with larger renders, averaged (`supersampling_for`).
    `progress` is called with the number of views done and in total.

    Views of which the masks leave no pixel are left out, and a warning counts them. Raises
    InputError if the capture holds no view back, or none with a pixel.
    """
    frames = dataset.test
    if not frames:
        raise InputError("the capture holds no view back for evaluation: it needs more photos")
    views: dict[str, list[ViewMetrics]] = {name: [] for name in scenes}
    empty = 0
    for done, frame in enumerate(frames, start=1):
        supersampling, view = supersampling_for(frame.camera, training_views), load_view(frame)
        if view.mask is not None and not view.mask.any():
            empty += 1
        else:
            for name, row in evaluate_view(scenes, view, lpips, supersampling).items():
                views[name].append(row)
        if progress:
            progress(done, len(frames))
    if empty == len(frames):
        raise InputError("masks leave no pixel of the held-back photos to compare with")
    if empty:
        log.warning("%d held-back views are masked whole and do not count", empty)
    return {name: summary(rows) for name, rows in views.items()}


def evaluate_view(
    scenes: Mapping[str, Scene], view: View, lpips: LpipsSuite | None, supersampling: int = 1
) -> dict[str, ViewMetrics]:
    """Return the metrics of every scene for one photo."""
    results: dict[str, ViewMetrics] = {}
    images = []
    target, mask = view.image, view.mask
    for name, scene in scenes.items():
        device = scene.gaussians.means.device
        target = view.image.to(device)
        mask = None if view.mask is None else view.mask.to(device) > 0.5
        level_sigma = usual_level_sigma(soft_edge=scene.footprint.soft_edge)
        options = {"level_sigma": level_sigma, "supersampling": supersampling}
        drawn = scene.render(view.camera.to(device), **options)
        image = displayed_colors(drawn.image)
        if mask is not None:  # masked pixels equal the photo, also inside SSIM's windows
            image = torch.where(mask[..., None], image, target)
        images.append(image)
        results[name] = {
            "name": view.name,
            "psnr": psnr(image, target, mask),
            "cc_psnr": color_corrected_psnr(image, target, mask),
            "ssim": ssim(image, target, mask),
            "neutral_rms": neutral_rms(image, target, mask),
            "lpips_vgg": None,
            "lpips_vgg_rescaled": None,
            "lpips_alex": None,
            "lpips_alex_rescaled": None,
        }
    if lpips is not None:
        for row, distances in zip(results.values(), lpips.distances(target, images), strict=True):
            row.update(cast(ViewMetrics, distances))
    return results


def summary(rows: Sequence[ViewMetrics]) -> SceneMetrics:
    """Return the means over the views, and the views themselves."""
    means: dict[str, float | None] = {}
    for metric in METRICS:
        values = [value for row in rows if (value := row[metric]) is not None]
        known = len(values) == len(rows) or (values and metric in OF_SOME)
        means[metric] = sum(values) / len(values) if known else None
    return cast(SceneMetrics, means | {"views": list(rows)})


def to_json(content: Any) -> str:
    """Return indented JSON; floats that are not finite become null."""
    return json.dumps(finite(content), indent=2, allow_nan=False)


def finite(content: Any) -> Any:
    """Replace every float that is not finite by None."""
    if isinstance(content, float):
        return content if math.isfinite(content) else None
    if isinstance(content, Mapping):
        return {key: finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [finite(value) for value in content]
    return content


def peak_memory_mib() -> float | None:
    """Return the peak memory of this process in MiB, with torch's memory on the GPU.

    Return None on Windows, which has no `resource` module.
    """
    try:
        import resource
    except ImportError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # KiB, but bytes on macOS
    mib = peak / (1 << 20 if sys.platform == "darwin" else 1 << 10)
    if torch.cuda.is_available():
        mib += torch.cuda.max_memory_allocated() / (1 << 20)
    return round(mib, 1)
