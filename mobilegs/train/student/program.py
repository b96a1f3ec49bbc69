"""The default student's decoding, its adjoint and Adam: csrc/student.cpp and cuda_student.h."""

import ctypes
import math
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.csrc import binding
from mobilegs.csrc.binding import address
from mobilegs.render.inputs import RenderSettings
from mobilegs.render.kernels import cuda
from mobilegs.render.kernels.kernel_view import BLACK, KernelView, kernel_view
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.view_network import STATICS
from mobilegs.representation.appearance import LATENTS
from mobilegs.representation.float16 import SIGNIFICAND_BITS
from mobilegs.representation.lobes import C0
from mobilegs.representation.rotations import bits_table
from mobilegs.train.optim import NamedAdam, Trained
from mobilegs.train.student.model import StudentModel
from mobilegs.train.student.shared_decode import SharedDecode, overdraw_limits

PHASES = "explicit", "latents", "quantized"
# of `StudentModel.rows`, in the order of the struct; None: no columns
TENSORS = {
    "explicit": (
        *("means", "quats", "log_scales", "sh0", "sh_rest", "logit_opacities", "lobe_latents"),
    ),
    "latents": (
        *("means", "quats", "log_scales", "static", "view", "logit_opacities", "lobe_latents"),
    ),
    "quantized": ("means", "rotation", "scale", "appearance", None, "opacity", "lobes"),
}
STEPS = "scale", "rotation", "appearance", "opacity", "lobes"
COLORS_MAX, LATENTS_MAX, HIDDEN_MAX = 48, 32, 64


class _Shared(ctypes.Structure):
    """A parameter of all Gaussians; mirrors `Shared` in csrc/student.h field by field."""

    _fields_ = [
        ("tensor", Trained),
        *((name, ctypes.c_int) for name in ("rows", "at", "row_step", "column_step", "bits")),
        *((name, ctypes.c_float) for name in ("initial", "least", "most")),
    ]


class _Student(ctypes.Structure):
    """A model's parameters; mirrors `Student` in csrc/student.h field by field."""

    _fields_ = [
        ("tensors", Trained * 7),
        ("shared", _Shared * 12),
        ("count", ctypes.c_int64),
        *((name, ctypes.c_int) for name in ("phase", "colors", "lobes", "hidden")),
        ("center", ctypes.c_float * 3),
        ("radius", ctypes.c_float),
        ("unit", ctypes.c_float),
        ("rounds", ctypes.c_int),
        ("shared_count", ctypes.c_int),
        ("base", ctypes.c_float),
        ("bits", ctypes.c_void_p),
        ("last_bits", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in ("weights", "turned")),
    ]


class _Decoded(ctypes.Structure):
    _fields_ = [(f"p{i}", ctypes.c_void_p) for i in range(5)]


class _Overdraw(ctypes.Structure):
    """The overdraw term; mirrors `Overdraw` in csrc/student.h field by field."""

    _fields_ = [
        ("view", KernelView),
        *((name, ctypes.c_float) for name in ("weight", "alpha_min", "level_sigma")),
    ]


def runs_program(model: StudentModel) -> bool:
    """Return whether `ProgramDecode` takes a model: the default kind, in float32."""
    lobes, colors = model.lobe_decoder, 3 * (model.color.degree + 1) ** 2
    if lobes is None or len(lobes.shape.hidden) != 1 or model.step_sizes is None:
        return False
    fits = lobes.shape.hidden[0] <= HIDDEN_MAX and 0 < lobes.shape.latents <= LATENTS_MAX
    fits &= max(colors, model.color.latents) <= COLORS_MAX
    linear = model.color.colors == "linear"
    tensors = model.rows.tensors.values()
    return fits and linear and (cuda.takes(*tensors) or binding.supports(*tensors))


class ProgramDecode(SharedDecode):
    """`SharedDecode` of a default student, with decoding, adjoint and Adam as kernels.

    On a GPU all Gaussians are decoded, since projection finds those in sight.

    Attributes:
        detached: the decoded tensors by name, the leaves.
    """

    def __init__(self, model: StudentModel, cameras: list[Camera]) -> None:
        """Decode what `cameras` may see; all Gaussians if there is none."""
        self.model, self.cameras = model, cameras
        self.rows = [None] * len(cameras)
        self.student, self.held = _student(model)
        means = model.rows.tensors["means"]
        self.kernels = cuda.kernels_for(means) if cuda.takes(means) else None
        count = len(model) if self.kernels else self._find_rows()
        new, size = means.new_empty, self.student.lobes // 2
        self.detached = {
            "means": new(count, 3),
            "quats": new(count, 4),
            "log_scales": new(count, 3),
            "sh": new(count, self.student.colors // 3, 3),
            "lobes": new(count, size, 2),
        }
        self._run("decode", _pointers(self.detached.values()))
        for tensor in self.detached.values():
            tensor.requires_grad_()

    def _find_rows(self) -> int:
        """List the Gaussians that the cameras may see, on a CPU; return their number."""
        native, count = _native(), len(self.model)
        native.mgs_student_prepare(ctypes.byref(self.student))
        blocks = -(-count // native.mgs_student_block())
        self.shown = torch.empty(count, dtype=torch.int32)
        self.starts = torch.empty(blocks + 1, dtype=torch.int64)
        views = [_opaque_view(self.model, camera) for camera in self.cameras]
        return native.mgs_student_rows(
            *(ctypes.byref(self.student), (KernelView * len(views))(*views), len(views)),
            *(address(self.shown), address(self.starts)),
        )

    def _run(self, name: str, decoded: _Decoded, *overdraw: _Overdraw) -> None:
        """Run `decode` or `update` on the values, or gradients, of `detached`."""
        if self.kernels is None:
            run = getattr(_native(), f"mgs_student_{name}")
            places = address(self.shown), address(self.starts)
            structs = [ctypes.byref(struct) for struct in (decoded, *overdraw)]
            run(ctypes.byref(self.student), *places, *structs)
            return
        blocks = -(-len(self.model) // cuda.THREADS)
        with self.kernels.current():
            if name == "decode":
                self._launch("prepare", 1)
                self._launch("decode", blocks, decoded)
                return
            weights = next(held for held in self.held if held.data_ptr() == self.student.weights)
            parts = weights.new_empty(blocks, len(weights))
            self._launch("update", blocks, decoded, *overdraw, address(parts))
            count = ctypes.c_int(blocks)
            self._launch("finish", -(-len(weights) // cuda.THREADS), count, address(parts))

    def _launch(self, name: str, blocks: int, *arguments: Any) -> None:
        assert self.kernels is not None
        self.kernels.launch(f"mgs_student_{name}", blocks, cuda.THREADS, self.student, *arguments)

    @torch.no_grad()
    def step(self, overdraw_weight: float = 0.0) -> None:
        """Take a step of Adam on the gradients of the leaves and those that the model has."""
        rows, shared = self.model.rows, self.model.shared
        for tensor, name in zip(self.student.tensors, TENSORS[self.model.phase], strict=True):
            if name is not None:
                self._begin(tensor, rows, name)
        for parameter, name in zip(self.student.shared, shared.tensors, strict=False):
            self._begin(parameter.tensor, shared, name)
        found = [torch.zeros_like(t) if t.grad is None else t.grad for t in self.leaves]
        gradients = [gradient.contiguous() for gradient in found]
        overdraw = _Overdraw()
        if overdraw_weight:
            model = self.model
            alpha_min, sigma = overdraw_limits(model)
            view = _opaque_view(model, self.cameras[0])
            overdraw = _Overdraw(view, overdraw_weight, alpha_min, sigma)
        self._run("update", _pointers(gradients), overdraw)
        for tensor in (*rows.tensors.values(), *shared.tensors.values()):
            tensor.grad = None

    def _begin(self, into: Trained, adam: NamedAdam, name: str) -> None:
        """Fill in what a step of Adam needs of a tensor."""
        mean, square, into.rate, into.root = adam.begin_step(name)
        into.mean, into.square = mean.data_ptr(), square.data_ptr()
        if (grad := adam.tensors[name].grad) is not None:
            self.held.append(grad.contiguous())
            into.grad = self.held[-1].data_ptr()


@torch.no_grad()
def opacities_and_scales(
    model: StudentModel, cameras: list[Camera]
) -> Iterator[tuple[Float[Tensor, "n"], Float[Tensor, "n 3"]]]:
    """Return the opacities, as each camera sees them, and scales of all Gaussians."""
    decoded = ProgramDecode(model, []).detached
    scales = decoded["log_scales"].exp()
    for camera in cameras:
        directions = normalize(decoded["means"] - camera.position, dim=1)
        yield evaluate_lobes(decoded["lobes"], directions)[0], scales


def _opaque_view(model: StudentModel, camera: Camera) -> KernelView:
    """Return the view in which Gaussians are looked for: as if they were opaque."""
    settings = RenderSettings(footprint=model.footprint)
    return kernel_view(camera, BLACK, settings, sh_size=1, lobe_size=0)


@cache
def _native() -> ctypes.CDLL:
    """Return the library; raises ImportError if its struct differs from `_Student`."""
    loaded = binding.library()
    if loaded.mgs_student_bytes() != ctypes.sizeof(_Student):
        raise ImportError("the C++ library belongs to another version of mobilegs")
    loaded.mgs_student_rows.restype = ctypes.c_int64
    return loaded


def _pointers(tensors: Iterable[Tensor]) -> _Decoded:
    return _Decoded(*(tensor.data_ptr() for tensor in tensors))


@torch.no_grad()
def _student(model: StudentModel) -> tuple[_Student, list[Tensor]]:
    """Return the struct of a model, without moments, and the tensors that it points to."""
    lobes, student = model.lobe_decoder, _Student()
    assert lobes is not None
    for into, name in zip(student.tensors, TENSORS[model.phase], strict=True):
        if name is not None:
            tensor = model.rows.tensors[name]
            assert tensor.is_contiguous()
            into.values, into.columns = tensor.data_ptr(), math.prod(tensor.shape[1:])
    student.count, student.phase = len(model), PHASES.index(model.phase)
    student.colors = 3 * (model.color.degree + 1) ** 2
    student.lobes, student.hidden = lobes.shape.outputs, lobes.shape.hidden[0]
    student.base = 1 / C0
    if model.grid is not None:
        student.center[:] = model.grid.center.tolist()
        student.radius, student.unit = model.grid.radius, 2.0**model.grid.exponent
        student.rounds = model.round_means
    means = model.rows.tensors["means"]
    weights, turned = _add_shared(student, model)
    table = bits_table(means.device)
    held = [means.new_empty(weights), means.new_empty(turned), table]
    student.weights, student.turned, student.bits = (tensor.data_ptr() for tensor in held)
    student.last_bits = len(table) - 1
    return student, held


def _add_shared(student: _Student, model: StudentModel) -> tuple[int, int]:
    """Add the shared parameters in the order of `model.shared`, at the places of csrc/student.h.

    Return the numbers of weights and of turned weights.
    """
    lobes, color = model.lobe_decoder, student.tensors[3].columns + student.tensors[4].columns
    assert lobes is not None
    outputs, latents, [hidden] = lobes.shape.outputs, lobes.shape.latents, lobes.shape.hidden
    first_width, last_width = STATICS + latents, hidden + latents + 1
    first = 0 if model.phase == "explicit" else student.colors * color
    offset = first + hidden * first_width
    last = offset + hidden
    bias = last + outputs * last_width
    steps = bias + outputs
    places = {  # the first place, and the steps from row to row and from column to column
        "lobe_decoder.weights.0": (first, first_width, 1),
        "lobe_decoder.offsets.0": (offset, 1, 1),
        "lobe_decoder.weights.1": (last, last_width, 1),
        "lobe_decoder.basis": (last + hidden, 1, last_width),
        "lobe_decoder.bias": (bias, 1, 1),
        "decoder.static2": (0, color, 1),
        "decoder.view2": (3 * color + LATENTS, color, 1),
        **{f"{name}.log_step_offset": (steps + i, 1, 1) for i, name in enumerate(STEPS)},
    }
    student.shared_count = len(model.shared.tensors)
    for into, (name, tensor) in zip(student.shared, model.shared.tensors.items(), strict=False):
        assert tensor.is_contiguous()
        into.tensor.values, into.tensor.columns = tensor.data_ptr(), math.prod(tensor.shape[1:])
        into.rows = len(tensor) if tensor.ndim else 1
        into.at, into.row_step, into.column_step = places[name]
        owner, _, field = name.partition(".")
        if field == "log_step_offset":
            quantizer = model.uniform(owner)  # pyright: ignore[reportArgumentType]
            into.initial = quantizer.initial_step_size
            into.least, into.most = quantizer.step_size_range
        elif tensor.ndim == 1:
            into.bits = SIGNIFICAND_BITS
        else:
            into.bits = getattr(model, owner).significand_bits
    return steps + len(STEPS), first + latents * hidden + last_width * outputs
