"""Evaluation of scenes on held-back photos: metrics per view and their means."""

import json
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import torch

from mobilegs.atomic import atomic_write
from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.lpips import LPIPS_NAMES, LpipsSuite
from mobilegs.evaluate.metrics import color_corrected_psnr, displayed_colors, psnr, ssim
from mobilegs.render.scene import Scene
from mobilegs.render.supersampling import supersampling_for

METRICS = ("psnr", "cc_psnr", "ssim", *LPIPS_NAMES)


def evaluate(
    scene: Scene,
    dataset: Dataset,
    *,
    training_views: Sequence[Camera] = (),
    lpips: LpipsSuite | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
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
) -> dict[str, dict[str, Any]]:
    """Render the held-back views of every scene and compare them with the photos.

    Renders are rounded to 8 bits, and masked pixels do not count. The result has an entry per
    scene: `psnr` (dB), `cc_psnr` (dB, after a change of each render's colours that fits its photo
    best), `ssim` and the four `lpips_*` as means over the views, None where there is
    no value, and the same metrics per photo in `views`. The scenes share the LPIPS features of the
    photos. Photos smaller than those of the `training_views` are compared with larger renders,
    averaged (`supersampling_for`). `progress` is called with the number of views done and in total.

    Raises InputError if the capture holds no view back.
    """
    frames = dataset.test
    if not frames:
        raise InputError("the capture holds no view back for evaluation: it needs more photos")
    views: dict[str, list[dict[str, Any]]] = {name: [] for name in scenes}
    for done, frame in enumerate(frames, start=1):
        supersampling = supersampling_for(frame.camera, training_views)
        for name, row in evaluate_view(scenes, load_view(frame), lpips, supersampling).items():
            views[name].append(row)
        if progress:
            progress(done, len(frames))
    return {name: summary(rows) for name, rows in views.items()}


def evaluate_view(
    scenes: Mapping[str, Scene], view: View, lpips: LpipsSuite | None, supersampling: int = 1
) -> dict[str, dict[str, Any]]:
    """Return the metrics of every scene for one photo."""
    results: dict[str, dict[str, Any]] = {}
    images = []
    target, mask = view.image, view.mask
    for name, scene in scenes.items():
        device = scene.gaussians.means.device
        target = view.image.to(device)
        mask = None if view.mask is None else view.mask.to(device) > 0.5
        drawn = scene.render(view.camera.to(device), supersampling=supersampling)
        image = displayed_colors(drawn.image)
        if mask is not None:  # masked pixels equal the photo, also inside SSIM's windows
            image = torch.where(mask[..., None], image, target)
        images.append(image)
        results[name] = {
            "name": view.name,
            "psnr": psnr(image, target, mask),
            "cc_psnr": color_corrected_psnr(image, target, mask),
            "ssim": ssim(image, target, mask),
            **dict.fromkeys(LPIPS_NAMES),
        }
    if lpips is not None:
        for row, distances in zip(results.values(), lpips.distances(target, images), strict=True):
            row.update(distances)
    return results


def summary(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the means over the views, and the views themselves."""
    result: dict[str, Any] = {}
    for metric in METRICS:
        values = [row[metric] for row in rows]
        result[metric] = None if None in values else sum(values) / len(values)
    return result | {"views": list(rows)}


def write_metrics(
    path: Path | str,
    *,
    teacher: Mapping[str, Any],
    student: Mapping[str, Any],
    file_bytes: int,
    gaussians: int,
    seconds: Mapping[str, float],
    more: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Write a run's `metrics.json` and return its contents.

    `teacher` and `student` are results of `evaluate_side_by_side`. `file_bytes` and `gaussians`
    are the student's, `seconds` are by stage. The peak memory is that of this process. `more` adds
    entries at the top level.
    """
    content = {
        "teacher": dict(teacher),
        "student": {"file_bytes": file_bytes, "gaussians": gaussians, **student},
        "seconds": dict(seconds),
        "peak_memory_mib": peak_memory_mib(),
        **(more or {}),
    }
    atomic_write(path, to_json(content) + "\n")
    return content


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
