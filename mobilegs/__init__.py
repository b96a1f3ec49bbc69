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
    "capture.run": ("CaptureRun", "capture_photos"),
    "formats.ply": ("read_ply", "write_ply"),
    "formats.spz": ("read_spz", "write_spz"),
    "formats.sog": ("read_sog", "write_sog"),
    "formats.glb": ("read_glb", "write_glb"),
    "formats.splat": ("read_splat",),
    "mgs.quantized_scene": ("QuantizedScene",),
    "mgs.codec": ("encode_mgs", "read_mgs", "decode_mgs", "write_mgs"),
    "mgs.lod": ("with_lod_levels",),
    "evaluate.lpips": ("lpips_from",),
    "evaluate.metrics": ("displayed_colors", "psnr", "ssim", "to_bytes"),
    "evaluate.report": ("evaluate_side_by_side",),
    "scene_file": ("inspect_scene", "open_scene", "write_gaussians"),
    "train.recipes": (
        "Recipe",
        "short_recipe",
        "demo_recipe",
        "long_recipe",
        "with_method",
        "with_settings",
        "with_steps",
    ),
    "pipeline.train": ("TrainRun", "train_run"),
    "pipeline.compress": ("CompressRun", "compress_run"),
    "pipeline.export_sorted": ("SortedExport", "export_sorted"),
    "view.export": ("export_html", "export_site"),
    "view.wgpu_renderer": ("WgpuRenderer",),
    "view.serve": ("Server",),
}
_HOMES = {name: module for module, names in PUBLIC.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'mobilegs' has no attribute '{name}'")
    found = getattr(importlib.import_module(f"mobilegs.{_HOMES[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
