"""The GPU to draw with, and the shaders as its pipelines: WebGPU on Vulkan, Metal or DirectX 12.

The shaders in `shaders/` are the ones that the web viewer runs.
"""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mobilegs.errors import InputError

SHADERS = Path(__file__).parent / "shaders"
PASSES = ("project", "splat", "resolve")
HALF_SCALE = 2.0**-6  # of weights in half-float targets: 1,400 layers of the heaviest still fit
INSTALL = "pip install 'mobilegs[native]'"


@cache
def adapter() -> Any:
    """The GPU to draw with; InputError with one sentence where there is none.

    A discrete one is preferred. Software devices (Mesa's lavapipe) count.
    """
    try:
        import wgpu
    except ImportError:
        raise InputError(
            f"drawing on a GPU needs wgpu, which is not installed: {INSTALL}"
        ) from None
    try:
        found = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    except RuntimeError:
        found = None
    if found is None:
        raise InputError(
            "no GPU can be used here: install its Vulkan driver (on Debian and Ubuntu "
            "mesa-vulkan-drivers, which also draws without a GPU), or use what needs none: "
            "--backend kernels, the web viewer"
        )
    return found


def shader(*names: str) -> str:
    """The WGSL of a pass: the named parts one after the other, what they share first."""
    return "\n".join((SHADERS / f"{name}.wgsl").read_text() for name in ("view", *names))


class Program:
    """The device, and its pipelines for one way of blending.

    Attributes:
        device: wgpu's device.
        sorted: whether splats lie over one another, far ones first, or add up in any order.
        formats: of the textures that sums go to.
        weight_scale: what weights are multiplied by; it cancels in the end.
        project, splat: the pipelines of the first two passes.
    """

    def __init__(self, blend_sorted: bool, full_precision: bool) -> None:
        self.sorted = blend_sorted
        bits = 32 if full_precision else 16
        self.formats = [f"rgba{bits}float"] + ([] if blend_sorted else [f"r{bits}float"])
        self.weight_scale = 1.0 if full_precision else HALF_SCALE
        found = adapter()
        features = {"timestamp-query"} & set(found.features)
        if full_precision:
            if "float32-blendable" not in found.features:
                raise InputError("this GPU cannot blend 32-bit floats: draw with halves")
            features.add("float32-blendable")
        wanted = ("max-buffer-size", "max-storage-buffer-binding-size")
        self.device = found.request_device_sync(
            required_features=sorted(features),
            required_limits={name: found.limits[name] for name in wanted},
        )
        self._queries = None
        if "timestamp-query" in features:
            self._queries = self.device.create_query_set(type="timestamp", count=2 * len(PASSES))
        self._make_pipelines()

    def resolve(self, target_format: str) -> Any:
        """The pipeline of the last pass, into a texture of the given format."""
        if target_format not in self._resolve:
            kind = "sorted" if self.sorted else "sortfree"
            self._resolve[target_format] = self.device.create_render_pipeline(
                layout="auto",
                vertex={"module": self._resolve_code, "entry_point": "whole_picture"},
                primitive={"topology": "triangle-list"},
                fragment={
                    "module": self._resolve_code,
                    "entry_point": f"resolve_{kind}",
                    "targets": [{"format": target_format}],
                },
            )
        return self._resolve[target_format]

    def stamps(self, name: str) -> dict[str, Any] | None:
        """Where a pass notes when it began and ended; None where the device has no clock."""
        if self._queries is None:
            return None
        first = 2 * PASSES.index(name)
        return {
            "query_set": self._queries,
            "beginning_of_pass_write_index": first,
            "end_of_pass_write_index": first + 1,
        }

    def milliseconds(self) -> dict[str, float] | None:
        """What each pass of the last frame took; None where the device has no clock."""
        import wgpu

        if self._queries is None:
            return None
        use, size = wgpu.BufferUsage, 16 * len(PASSES)
        buffer = self.device.create_buffer(size=size, usage=use.QUERY_RESOLVE | use.COPY_SRC)
        encoder = self.device.create_command_encoder()
        encoder.resolve_query_set(self._queries, 0, 2 * len(PASSES), buffer, 0)
        self.device.queue.submit([encoder.finish()])
        stamps = np.frombuffer(self.device.queue.read_buffer(buffer), np.uint64).reshape(-1, 2)
        ticks = (stamps[:, 1] - stamps[:, 0]).astype(np.float64)  # nanoseconds
        return dict(zip(PASSES, (1e-6 * ticks).tolist(), strict=True))

    def _make_pipelines(self) -> None:
        constants = {"SORTED": self.sorted}
        code = self.device.create_shader_module(code=shader("wide", "project"))
        stage = {"module": code, "entry_point": "project_all", "constants": constants}
        self.project = self.device.create_compute_pipeline(layout="auto", compute=stage)
        code = self.device.create_shader_module(code=shader("wide", "splat"))
        color = {"src_factor": "one", "dst_factor": "one", "operation": "add"}
        alpha = {"src_factor": "zero", "dst_factor": "one-minus-src-alpha", "operation": "add"}
        if self.sorted:
            color = alpha = {**color, "dst_factor": "one-minus-src-alpha"}
        blend = {"color": color, "alpha": alpha}
        self.splat = self.device.create_render_pipeline(
            layout="auto",
            vertex={"module": code, "entry_point": "corner", "constants": constants},
            primitive={"topology": "triangle-list"},
            fragment={
                "module": code,
                "entry_point": "cover" if self.sorted else "add_weighted",
                "targets": [{"format": name, "blend": blend} for name in self.formats],
            },
        )
        self._resolve_code = self.device.create_shader_module(code=shader("resolve"))
        self._resolve: dict[str, Any] = {}


@cache
def program(blend_sorted: bool, full_precision: bool) -> Program:
    """The device with its pipelines, which all scenes of a kind share.

    Raises InputError where there is no GPU, or it cannot blend 32-bit floats.
    """
    return Program(blend_sorted, full_precision)
