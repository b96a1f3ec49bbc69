"""The GPU and its pipelines for WgpuRenderer: WebGPU on Vulkan, Metal or DirectX 12.

The shaders are those of the web viewer, from viewer/shaders.
"""

from functools import cache, cached_property
from typing import Any

import numpy as np

from mobilegs.errors import InputError
from mobilegs.view import assets

PASSES = ("network", "project", "splat", "resolve")
FLOATS = {"float32-blendable", "float32-filterable"}  # levels are enlarged by filtering
FLOAT16_SCALE = 2.0**-6  # of weights in float16: sums of 1,400 of the largest do not overflow
INSTALL = "pip install 'mobilegs[native]'"


@cache
def adapter() -> Any:
    """Return the GPU, a discrete one if there is a choice, or a software device (lavapipe).

    Raises InputError without wgpu or a GPU.
    """
    try:
        import wgpu
    except ImportError:
        raise InputError(
            f"rendering with WebGPU needs wgpu, which is not installed: {INSTALL}"
        ) from None
    try:
        found = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    except RuntimeError:
        found = None
    if found is None:
        raise InputError(
            "no GPU was found: install its Vulkan driver (on Debian and Ubuntu "
            "mesa-vulkan-drivers, which also works without a GPU), or use the web viewer or "
            "--renderer kernels, which need none"
        )
    return found


def shader(*names: str) -> str:
    """Return the WGSL of a pass: view.wgsl, which all share, and the named parts."""
    return "\n".join(assets.shader(name) for name in ("view", *names))


class Program:
    """A device and its pipelines for one way of blending.

    Attributes:
        device: the wgpu device.
        sorted: True for alpha blending far to near, False for sums in any order.
        formats: texture formats of the sums.
        weight_scale: factor of the weights, which cancels in the image.
        network: the pipeline of the paper's network, in float16 unless `full_precision` or the GPU
            has none; made at its first use.
        bilinear: the sampler that enlarges levels.
        number: `f16` or `f32`, the numbers of the network's layers.
        project: the pipeline of the next pass.
    """

    def __init__(self, blend_sorted: bool, full_precision: bool) -> None:
        self.sorted = blend_sorted
        bits = 32 if full_precision else 16
        self.formats = [f"rgba{bits}float"] + ([] if blend_sorted else [f"r{bits}float"])
        self.weight_scale = 1.0 if full_precision else FLOAT16_SCALE
        found = adapter()
        wanted = {"timestamp-query"} if full_precision else {"timestamp-query", "shader-f16"}
        features = wanted & set(found.features)
        self.number = "f16" if "shader-f16" in features else "f32"
        if full_precision:
            if not found.features.issuperset(FLOATS):
                raise InputError(
                    "this GPU cannot blend and filter 32-bit floats: render with "
                    "full_precision=False"
                )
            features |= FLOATS
        limits = ("max-buffer-size", "max-storage-buffer-binding-size")
        self.device = found.request_device_sync(
            required_features=sorted(features),
            required_limits={name: found.limits[name] for name in limits},
        )
        self.bilinear = self.device.create_sampler(mag_filter="linear", min_filter="linear")
        self._queries = None
        if "timestamp-query" in features:
            self._queries = self.device.create_query_set(type="timestamp", count=2 * len(PASSES))
        self._make_pipelines()

    @cached_property
    def network(self) -> Any:
        return self.network_of(self.number, "wide")

    def network_of(self, number: str, rows: str) -> Any:
        """Return the pipeline of the network in `f16` or `f32`, for `wide` or `packed` scenes."""
        enable = "enable f16;\n" if number == "f16" else ""
        code = f"{enable}alias Num = {number};\n{shader(rows, 'network')}"
        module = self.device.create_shader_module(code=code)
        stage = {"module": module, "entry_point": "evaluate_network"}
        return self.device.create_compute_pipeline(layout="auto", compute=stage)

    def resolve(self, target_format: str, *, levels: bool = False) -> Any:
        """Return the pipeline of the last pass, into a texture of the given format.

        With `levels` it adds those of `enlarge`.
        """
        key = (target_format, levels)
        if key not in self._resolve:
            kind = "sorted" if self.sorted else "levels" if levels else "sortfree"
            self._resolve[key] = self.device.create_render_pipeline(
                layout="auto",
                vertex={"module": self._resolve_code, "entry_point": "whole_picture"},
                primitive={"topology": "triangle-list"},
                fragment={
                    "module": self._resolve_code,
                    "entry_point": f"resolve_{kind}",
                    "targets": [{"format": target_format}],
                },
            )
        return self._resolve[key]

    @cached_property
    def splat(self) -> Any:
        """The pipeline that adds or blends Gaussians at full size."""
        return self._splat_of(
            *(("corner_sorted", "cover") if self.sorted else ("corner_sortfree", "add_weighted"))
        )

    @cached_property
    def splat_levels(self) -> Any:
        """The pipeline that adds Gaussians, each in its level."""
        return self._splat_of("corner_of_level", "add_to_level")

    def _splat_of(self, vertex: str, fragment: str) -> Any:
        targets = [{"format": name, "blend": self._blend} for name in self.formats]
        return self.device.create_render_pipeline(
            layout="auto",
            vertex={"module": self._splat_code, "entry_point": vertex},
            primitive={"topology": "triangle-list"},
            fragment={"module": self._splat_code, "entry_point": fragment, "targets": targets},
        )

    @cached_property
    def enlarge(self) -> dict[int, Any]:
        """The pipelines that add the coarser levels to levels 1 and 2."""
        return {
            level: self.device.create_render_pipeline(
                layout="auto",
                vertex={"module": self._resolve_code, "entry_point": "whole_picture"},
                primitive={"topology": "triangle-list"},
                fragment={
                    "module": self._resolve_code,
                    "entry_point": "add_enlarged",
                    "constants": {"LEVEL": level},
                    "targets": [{"format": name} for name in self.formats],
                },
            )
            for level in (1, 2)
        }

    def stamps(self, name: str, *, begin: bool = True, end: bool = True) -> dict[str, Any] | None:
        """Return where a pass writes its timestamps; None if the device has none.

        Of several passes of one name, the first writes the `begin` and the last the `end`.
        """
        if self._queries is None or not (begin or end):
            return None
        first = 2 * PASSES.index(name)
        return {
            "query_set": self._queries,
            **({"beginning_of_pass_write_index": first} if begin else {}),
            **({"end_of_pass_write_index": first + 1} if end else {}),
        }

    def milliseconds(self, passes: tuple[str, ...]) -> dict[str, float] | None:
        """Return the time of these passes of the last frame; None if the device has no timer."""
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
        return {name: 1e-6 * float(ticks[PASSES.index(name)]) for name in passes}

    def _make_pipelines(self) -> None:
        code = self.device.create_shader_module(code=shader("wide", "project"))
        entry = "project_sorted" if self.sorted else "project_sortfree"
        stage = {"module": code, "entry_point": entry}
        self.project = self.device.create_compute_pipeline(layout="auto", compute=stage)
        self._splat_code = self.device.create_shader_module(code=shader("wide", "splat"))
        color = {"src_factor": "one", "dst_factor": "one", "operation": "add"}
        alpha = {"src_factor": "zero", "dst_factor": "one-minus-src-alpha", "operation": "add"}
        if self.sorted:
            color = alpha = {**color, "dst_factor": "one-minus-src-alpha"}
        self._blend = {"color": color, "alpha": alpha}
        self._resolve_code = self.device.create_shader_module(code=shader("resolve"))
        self._resolve: dict[tuple[str, bool], Any] = {}


@cache
def program(blend_sorted: bool, full_precision: bool) -> Program:
    """Return the device with its pipelines, one for all scenes with the same arguments.

    Raises InputError without a GPU, or if it cannot blend and filter 32-bit floats.
    """
    return Program(blend_sorted, full_precision)
