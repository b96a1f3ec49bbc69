"""The GPU and its pipelines for WgpuRenderer: WebGPU on Vulkan, Metal, DirectX 12, OpenGL.

The shaders are those of the web viewer, from viewer/shaders.
"""

import ctypes
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, cached_property
from typing import Any

import numpy as np

from mobilegs.errors import InputError
from mobilegs.extras import extra_module
from mobilegs.view import assets

PASSES = ("network", "project", "splat", "resolve")
FLOAT32_FEATURES = {"float32-blendable", "float32-filterable"}  # levels are enlarged by filtering
ADAPTER_TYPES = ("DiscreteGPU", "IntegratedGPU")  # the preferred ones, in this order
# factors of weights in float16, without a depth pass and with one, whose factors are up to exp(8):
# sums of 1,400 and of 400 of the largest do not overflow
FLOAT16_SCALES = (2.0**-6, 2.0**-10)
REMEDY = (
    "install or update the GPU's Vulkan driver (on Debian and Ubuntu mesa-vulkan-drivers, which "
    "also draws without a GPU), or use the web viewer or --renderer kernels, which need none"
)


def gpus() -> list[Any]:
    """Return the GPUs as wgpu's adapters, the best first. Raises InputError without wgpu or a GPU.

    Hardware comes before software, Vulkan, Metal and DirectX 12 before OpenGL, and discrete GPUs
    before integrated ones. wgpu's variable WGPUPY_WGPU_ADAPTER_NAME leaves those whose summary
    contains it.
    """
    wgpu = extra_module("wgpu", "rendering with WebGPU needs wgpu", "native")
    name = os.environ.get("WGPUPY_WGPU_ADAPTER_NAME", "")
    try:
        adapters = [gpu for gpu in wgpu.gpu.enumerate_adapters_sync() if name in gpu.summary]
    except (wgpu.GPUError, RuntimeError) as error:
        raise InputError(f"the drivers of GPUs do not load ({reason(error)}): {REMEDY}") from error
    if not adapters:
        raise InputError(f"no GPU was found: {REMEDY}")
    return sorted(adapters, key=_rank)


def _rank(gpu: Any) -> tuple[bool, bool, int]:
    kind = gpu.info["adapter_type"]
    place = ADAPTER_TYPES.index(kind) if kind in ADAPTER_TYPES else len(ADAPTER_TYPES)
    return kind == "CPU", draws_by_opengl(gpu), place


def draws_by_opengl(gpu: Any) -> bool:
    """Return True if wgpu reaches this GPU by OpenGL, whose drivers promise less than WebGPU."""
    return gpu.info["backend_type"].startswith("OpenGL")


def name_of(gpu: Any) -> str:
    """Return the GPU's name, how it is reached, and whether it is a program on the CPU."""
    software = ", software" if gpu.info["adapter_type"] == "CPU" else ""
    return f"{gpu.info['device']}, {gpu.info['backend_type']}{software}"


def reason(error: Exception) -> str:
    """Return the line of wgpu's message that says what is wrong: the last one."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[-1] if lines else type(error).__name__


@contextmanager
def translated_errors(gpu: str) -> Iterator[None]:
    """Raise what wgpu raises as InputError; a lost device and a full memory are among it.

    After that, new renderers open the GPU again.
    """
    import wgpu

    try:
        yield
    except (wgpu.GPUError, RuntimeError) as error:
        program_of.cache_clear()
        raise InputError(f"the GPU {gpu} failed ({reason(error)}): {REMEDY}") from error


@contextmanager
def translated_abort(gpu: str) -> Iterator[None]:
    """End the process with a sentence and code 2 where wgpu aborts it: a device lost in `submit`.

    wgpu-native panics there instead of reporting an error (its issue 588).
    """
    c_signal, handler = _abort_handler(gpu)
    before = c_signal(signal.SIGABRT, ctypes.cast(handler, ctypes.c_void_p))
    try:
        yield
    finally:
        c_signal(signal.SIGABRT, before)


@cache
def _abort_handler(gpu: str) -> tuple[Any, Any]:
    """Return C's `signal`, and a handler that ends the process; made once, not in each frame."""
    sentence = f"\nmobilegs: the GPU {gpu} was lost while it drew: {REMEDY}\n".encode()

    @ctypes.CFUNCTYPE(None, ctypes.c_int)
    def end(_: int) -> None:
        os.write(2, sentence)
        os._exit(2)

    c_signal = ctypes.CDLL(None if os.name == "posix" else "ucrtbase").signal
    c_signal.argtypes = (ctypes.c_int, ctypes.c_void_p)
    c_signal.restype = ctypes.c_void_p
    return c_signal, end


def shader(*names: str) -> str:
    """Return the WGSL of a pass: view.wgsl, which all share, and the named parts."""
    return "\n".join(assets.shader(name) for name in ("view", *names))


class Program:
    """A device and its pipelines for one way of blending.

    Attributes:
        gpu: the name of the GPU.
        device: the wgpu device.
        sorted: True for alpha blending far to near, False for sums in any order.
        formats: texture formats of the sums.
        target: the format of a picture that is read back.
        network: the pipeline of the paper's network, in float16 unless `full_precision` or the GPU
            has none; made at its first use.
        bilinear: the sampler that enlarges levels.
        number: `f16` or `f32`, the numbers of the network's layers.
        project: the pipeline of the next pass.
        splat: the pipeline that adds or blends Gaussians at full size.
        splat_levels: the pipeline that adds Gaussians, each in its level; not if sorted.
        moments: the texture format of the picture of a depth pass: float32 where the GPU blends and
            filters that, as variances cancel in float16.
        depths: the pipeline that adds Gaussians to that picture; not if sorted.
        splat_seen: the pipelines that add Gaussians by their visibility in it, at full size (False)
            and each in its level (True); not if sorted.
        enlarge: the pipelines that add the coarser levels to levels 1 and 2; not if sorted.
    """

    def __init__(self, gpu: Any, blend_sorted: bool, full_precision: bool) -> None:
        """Open a GPU, one of `gpus()`. Raises InputError if it lacks something that is needed."""
        import wgpu

        self.gpu = name_of(gpu)
        self.sorted = blend_sorted
        bits = 32 if full_precision else 16
        self.target = f"rgba{bits}float"
        self.formats = [self.target] + ([] if blend_sorted else [f"r{bits}float"])
        wanted = {"timestamp-query"} if full_precision else {"timestamp-query", "shader-f16"}
        features = wanted & set(gpu.features)
        self.number = "f16" if "shader-f16" in features else "f32"
        blends_floats = set(gpu.features) >= FLOAT32_FEATURES
        if full_precision and not blends_floats:
            raise InputError(
                f"{self.gpu} cannot blend and filter 32-bit floats, which full_precision needs"
            )
        features |= FLOAT32_FEATURES & set(gpu.features)
        self.moments = "rgba32float" if blends_floats else "rgba16float"
        limits = ("max-buffer-size", "max-storage-buffer-binding-size")
        try:
            self.device = gpu.request_device_sync(
                required_features=sorted(features),
                required_limits={name: gpu.limits[name] for name in limits},
            )
            self._queries = None
            if "timestamp-query" in features:
                count = 2 * len(PASSES)
                self._queries = self.device.create_query_set(type="timestamp", count=count)
            self.bilinear = self.device.create_sampler(mag_filter="linear", min_filter="linear")
            self._make_pipelines()
        except (wgpu.GPUError, RuntimeError) as error:
            raise InputError(f"{self.gpu} cannot run the renderer ({reason(error)})") from error

    @cached_property
    def network(self) -> Any:
        return self.network_of(self.number, "wide")

    def network_of(self, number: str, rows: str) -> Any:
        """Return the pipeline of the network in `f16` or `f32`, for `wide` or `packed` scenes."""
        enable = "enable f16;\n" if number == "f16" else ""
        code = f"{enable}alias Num = {number};\n{shader(rows, 'network')}"
        module = self.device.create_shader_module(code=code)
        return self._compute_pipeline(module, "evaluate_network")

    def resolve(self, target_format: str, *, levels: bool = False) -> Any:
        """Return the pipeline of the last pass, into a texture of the given format.

        With `levels` it adds those of `enlarge`.
        """
        key = (target_format, levels)
        if key not in self._resolve:
            kind = "sorted" if self.sorted else "levels" if levels else "sortfree"
            self._resolve[key] = self._full_size_pipeline(
                f"resolve_{kind}", [{"format": target_format}]
            )
        return self._resolve[key]

    def _compute_pipeline(self, module: Any, entry_point: str) -> Any:
        function = {"module": module, "entry_point": entry_point}
        return self.device.create_compute_pipeline(layout="auto", compute=function)

    def _splat_of(self, vertex: str, fragment: str, *, leveled: bool = True) -> Any:
        targets = [{"format": name, "blend": self._blend} for name in self.formats]
        return self._render_pipeline(
            self._splat_code,
            vertex,
            fragment,
            targets,
            vertex_constants={"LEVELED": float(leveled)},
        )

    def _depths(self) -> Any:
        blend = {"color": self._blend["color"], "alpha": self._blend["color"]}
        targets = [{"format": self.moments, "blend": blend}]
        return self._render_pipeline(self._splat_code, "corner_of_pass", "add_depth", targets)

    def _enlarge_of(self, level: int) -> Any:
        targets = [{"format": name} for name in self.formats]
        return self._full_size_pipeline("add_enlarged", targets, constants={"LEVEL": level})

    def _full_size_pipeline(self, fragment: str, targets: list[dict], **options: Any) -> Any:
        code = self._resolve_code
        return self._render_pipeline(code, "whole_picture", fragment, targets, **options)

    def _render_pipeline(
        self,
        module: Any,
        vertex: str,
        fragment: str,
        targets: list[dict],
        *,
        vertex_constants: dict[str, float] | None = None,
        **options: Any,
    ) -> Any:
        function = {"module": module, "entry_point": fragment, "targets": targets, **options}
        return self.device.create_render_pipeline(
            layout="auto",
            vertex={
                "module": module,
                "entry_point": vertex,
                "constants": vertex_constants or {},
            },
            primitive={"topology": "triangle-list"},
            fragment=function,
        )

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
        self.project = self._compute_pipeline(code, entry)
        self._splat_code = self.device.create_shader_module(code=shader("wide", "splat"))
        color = {"src_factor": "one", "dst_factor": "one", "operation": "add"}
        alpha = {"src_factor": "zero", "dst_factor": "one-minus-src-alpha", "operation": "add"}
        if self.sorted:
            color = alpha = {**color, "dst_factor": "one-minus-src-alpha"}
        self._blend = {"color": color, "alpha": alpha}
        self._resolve_code = self.device.create_shader_module(code=shader("resolve"))
        self._resolve: dict[tuple[str, bool], Any] = {}
        # a GPU that lacks something fails here, not in the first frame
        self.resolve(self.target)
        if self.sorted:
            self.splat = self._splat_of("corner_sorted", "cover")
        else:
            self.splat = self._splat_of("corner_sortfree", "add_weighted")
            self.splat_levels = self._splat_of("corner_of_level", "add_to_level")
            self.enlarge = {level: self._enlarge_of(level) for level in (1, 2)}
            self.depths = self._depths()
            self.splat_seen = {
                leveled: self._splat_of("corner_of_level", "add_seen", leveled=leveled)
                for leveled in (False, True)
            }


@cache
def program_of(gpu: Any, blend_sorted: bool, full_precision: bool) -> Program:
    """Return a GPU's device with its pipelines, one for all scenes with the same arguments.

    Raises InputError if the GPU cannot render.
    """
    return Program(gpu, blend_sorted, full_precision)
