"""Mobile-GS: 3D Gaussian splatting without sorting, in a file of a few megabytes.

`make docs` makes a page that describes the public names below. Each is imported on first access, so
`import mobilegs` is fast. `__init__.pyi` lists the same names for type checkers.
"""

import importlib
from typing import Any

__version__ = "0.1.0"

# module -> its public names
PUBLIC = {
    "errors": ("InputError",),
    "camera": ("Camera", "look_at"),
    "gaussians": ("Gaussians",),
    "render": ("render_sorted", "render_sortfree"),
    "render.rendered": ("Rendered",),
    "render.scene": ("Scene",),
    "render.sortfree": ("Weighting",),
    "data": ("load_capture",),
    "data.dataset": ("Dataset", "Frame", "View", "ViewLoader", "load_view"),
    "data.demo.capture": ("demo_capture", "write_capture"),
    "capture.run": ("CaptureReport", "CaptureRun", "capture_photos"),
    "formats.ply": ("read_ply", "write_ply"),
    "formats.spz": ("read_spz", "write_spz"),
    "formats.sog": ("read_sog", "write_sog"),
    "formats.glb": ("read_glb", "write_glb"),
    "formats.splat": ("read_splat",),
    "mgs.quantized_scene": ("QuantizedScene",),
    "mgs.codec": ("decode_mgs", "encode_mgs", "read_mgs", "write_mgs"),
    "mgs.contents": ("MgsContents", "StreamContents"),
    "mgs.lod": ("with_lod_levels",),
    "evaluate.lpips": ("lpips_from",),
    "evaluate.metrics": ("displayed_colors", "psnr", "ssim", "to_bytes"),
    "evaluate.report": (
        "FileMetrics",
        "Metrics",
        "RunMetrics",
        "SceneMetrics",
        "ViewMetrics",
        "evaluate_side_by_side",
    ),
    "scene_file": (
        "MgsFileContents",
        "SceneContents",
        "inspect_scene",
        "open_scene",
        "write_gaussians",
    ),
    "train.losses": (
        "color_distillation_loss",
        "depth_distillation_loss",
        "photo_loss",
        "raw_depth_loss",
    ),
    "train.stage": ("StepResult",),
    "train.student.config": ("StudentConfig",),
    "train.student.trainer": ("Student",),
    "train.teacher.trainer": ("Teacher", "TeacherConfig"),
    "train.recipes": (
        "Recipe",
        "demo_recipe",
        "short_recipe",
        "long_recipe",
        "with_method",
        "with_settings",
        "with_steps",
    ),
    "pipeline.options": ("TrainRun",),
    "pipeline.train": ("train_capture",),
    "pipeline.compress": ("CompressRun", "compress_scene"),
    "pipeline.export_sorted": ("SortedExport", "export_sorted"),
    "view.export": ("export_html", "export_site"),
    "view.wgpu_renderer": ("WgpuRenderer",),
    "view.serve": ("Server",),
}
_HOMES = {name: module for module, names in PUBLIC.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'mobilegs' has no attribute '{name}'")
    value = getattr(importlib.import_module(f"mobilegs.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
