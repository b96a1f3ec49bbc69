"""Adam over named tensors whose rows, with their moments, can be added and removed."""

import ctypes
import math
from collections.abc import Collection, Mapping

import torch
from jaxtyping import Bool, Int
from torch import Tensor

from mobilegs.csrc import binding
from mobilegs.render.kernels import cuda

EPS = 1e-15  # of 3DGS: gradients per Gaussian are tiny
BETAS = 0.9, 0.999  # torch's
MOMENTS = ("exp_avg", "exp_avg_sq")
STEPS_MAX = 8  # tensors in one launch


def exponential_lr(start: float, end: float, fraction: float) -> float:
    """Interpolate geometrically from `start` to `end` (both > 0).

    `fraction` is clamped to [0, 1]. This is the schedule of 3DGS for the means' learning rate.
    """
    fraction = min(max(fraction, 0.0), 1.0)
    return math.exp(math.log(start) * (1 - fraction) + math.log(end) * fraction)


class Trained(ctypes.Structure):
    """A tensor with a row per Gaussian, and its Adam; mirrors `Trained` in csrc/student.h."""

    _fields_ = [
        *((name, ctypes.c_void_p) for name in ("values", "mean", "square", "grad")),
        ("columns", ctypes.c_int),
        ("rate", ctypes.c_float),
        ("root", ctypes.c_float),
    ]


class _Steps(ctypes.Structure):
    """Steps of several tensors; mirrors `Steps` in csrc/cuda_student.h field by field."""

    _fields_ = [
        ("tensors", Trained * STEPS_MAX),
        ("rows", ctypes.c_int64 * STEPS_MAX),
        ("strides", ctypes.c_int64 * STEPS_MAX),
        ("count", ctypes.c_int),
    ]


class NamedAdam:
    """Leaf tensors by name, each with its own learning rate, and the Adam that optimises them.

    `tensors` always holds the current leaves: growing and pruning replace them. Methods that
    change rows apply to every tensor, so Gaussians have one `NamedAdam`, networks and codebooks
    have another.
    """

    def __init__(self, tensors: Mapping[str, Tensor], lrs: Mapping[str, float]) -> None:
        """Take `nn.Parameter`s as they are, so that networks keep theirs, and copy other tensors.

        `lrs` holds a learning rate for each name.
        """
        self.tensors: dict[str, Tensor] = {
            name: t if isinstance(t, torch.nn.Parameter) else _leaf(t)
            for name, t in tensors.items()
        }
        groups = [
            {"params": [tensor], "lr": lrs[name], "name": name}
            for name, tensor in self.tensors.items()
        ]
        nothing = [{"params": [], "name": ""}]  # torch needs at least one group
        self.adam = torch.optim.Adam(groups or nothing, eps=EPS, fused=True)

    def set_lr(self, name: str, lr: float) -> None:
        """Set the learning rate of one tensor."""
        self._group(name)["lr"] = lr

    def lr(self, name: str) -> float:
        """Return the learning rate of one tensor."""
        return self._group(name)["lr"]

    def step(self, *, without: Collection[str] = ()) -> None:
        """Take one Adam step with the current gradients, then clear them.

        Tensors named in `without` keep their gradients, to which those of later steps are added.
        """
        kept = {name: self.tensors[name].grad for name in without}
        for name in kept:
            self.tensors[name].grad = None
        if all(_is_native(tensor) for tensor in self.tensors.values()):
            for rows, stride, trained in self._begin_steps():
                counts = ctypes.c_int64(rows), ctypes.c_int64(stride)
                binding.library().mgs_adam(*counts, ctypes.byref(trained))
        elif cuda.takes(*self.tensors.values()) and all(
            tensor.is_contiguous() for tensor in self.tensors.values()
        ):
            steps = self._begin_steps()
            for first in range(0, len(steps), STEPS_MAX):
                _launch(steps[first : first + STEPS_MAX], next(iter(self.tensors.values())))
        else:
            for tensor in self.tensors.values():
                # fused Adam refuses gradients with other strides, or misreads them
                if tensor.grad is not None and tensor.grad.stride() != tensor.stride():
                    tensor.grad = torch.empty_like(tensor).copy_(tensor.grad)
            self.adam.step()
        self.adam.zero_grad(set_to_none=True)
        for name, grad in kept.items():
            self.tensors[name].grad = grad

    def _begin_steps(self) -> list[tuple[int, int, Trained]]:
        """Return the rows, the floats from one row of the gradient to the next, and the tensors."""
        steps = []
        for name, tensor in self.tensors.items():
            if (grad := tensor.grad) is None:
                continue
            grad = grad.reshape(1) if grad.ndim == 0 else grad
            columns, stride = math.prod(grad.shape[1:]), grad.stride(0)
            if not grad[:1].is_contiguous():
                tensor.grad = grad = grad.contiguous()  # held until the step is done
                stride = columns
            mean, square, rate, root = self.begin_step(name)
            pointers = [t.data_ptr() for t in (tensor, mean, square, grad)]
            steps.append((len(grad), stride, Trained(*pointers, columns, rate, root)))
        return steps

    def begin_step(self, name: str) -> tuple[Tensor, Tensor, float, float]:
        """Count a step of one tensor, which the caller takes in place, and return what it needs.

        That is both moments, `lr / (1 - beta1^t)` and `1 / sqrt(1 - beta2^t)`.
        """
        tensor = self.tensors[name]
        state = self.adam.state[tensor]
        if not state:
            state["step"] = 0
            state.update({key: torch.zeros_like(tensor) for key in MOMENTS})
        state["step"] = done = int(state["step"]) + 1  # a number, which is read on the host
        biases = [1 - beta**done for beta in BETAS]
        return *(state[key] for key in MOMENTS), self.lr(name) / biases[0], biases[1] ** -0.5

    def add(self, name: str, tensor: Tensor, lr: float) -> None:
        """Add a tensor; the others keep their moments."""
        self.tensors[name] = tensor if isinstance(tensor, torch.nn.Parameter) else _leaf(tensor)
        self.adam.add_param_group({"params": [self.tensors[name]], "lr": lr, "name": name})

    def drop(self, name: str) -> Tensor:
        """Stop optimising one tensor and return its values."""
        tensor = self.tensors.pop(name)
        self.adam.state.pop(tensor, None)
        groups = self.adam.param_groups
        groups[:] = [group for group in groups if group["name"] != name]
        return tensor.detach()

    @torch.no_grad()
    def keep_rows(self, rows: Bool[Tensor, "n"]) -> None:
        """Keep the rows of every tensor, and of its moments, where the mask is true."""
        kept = rows.nonzero()[:, 0]  # once: each use of a mask would wait for a GPU
        for name, tensor in list(self.tensors.items()):
            moments = {key: value[kept] for key, value in self._moments(tensor).items()}
            self._replace(name, tensor[kept], moments)

    @torch.no_grad()
    def append_rows(self, new: Mapping[str, Tensor]) -> None:
        """Append rows to every tensor; their moments are 0."""
        for name, tensor in list(self.tensors.items()):
            added = new[name]
            moments = {
                key: torch.cat([value, torch.zeros_like(added)])
                for key, value in self._moments(tensor).items()
            }
            self._replace(name, torch.cat([tensor, added]), moments)

    @torch.no_grad()
    def reset(self, name: str, value: Tensor) -> None:
        """Replace the values of one tensor, of the same shape, and set its moments to 0."""
        moments = {key: torch.zeros_like(value) for key in self._moments(self.tensors[name])}
        self._replace(name, value, moments)

    def reset_all_moments(self) -> None:
        """Drop the moments of all tensors, because their parametrisation changed."""
        self.adam.state.clear()

    @torch.no_grad()
    def reset_moments(self, rows: Bool[Tensor, "n"] | Int[Tensor, "m"]) -> None:
        """Set the moments of some rows of every tensor to 0."""
        for tensor in self.tensors.values():
            for moment in self._moments(tensor).values():
                moment[rows] = 0

    @torch.no_grad()
    def replace_all(self, values: Mapping[str, Tensor]) -> None:
        """Replace the values of every tensor, with any number of rows, and drop all moments."""
        for name in list(self.tensors):
            self._replace(name, values[name], {})

    def state(self) -> dict:
        """Return values, moments, step counts and learning rates by name, for `restore`."""
        return {
            name: {
                "value": tensor.detach(),
                "lr": float(self._group(name)["lr"]),
                **self.adam.state.get(tensor, {}),
                **self._steps_taken(tensor),
                **({} if tensor.grad is None else {"grad": tensor.grad}),
            }
            for name, tensor in self.tensors.items()
        }

    @torch.no_grad()
    def restore(self, state: Mapping[str, dict]) -> None:
        """Continue from a result of `state()`, whose tensors and row counts may differ.

        Tensors of the same shape are written in place, so networks keep their parameters. New
        ones are placed on the device of the others. Raises ValueError for values and moments that
        do not belong together, and KeyError, TypeError or AttributeError for what is no state.
        """
        for name, saved in state.items():
            value = saved["value"]
            known = self.tensors[name] if name in self.tensors else value
            step = saved["step"] if "step" in saved else torch.zeros(())
            held = [value, *(saved[key] for key in (*MOMENTS, "grad") if key in saved)]
            alike = all(each.shape == value.shape and each.dtype == known.dtype for each in held)
            # rows come and go, and so do the harmonics in the middle of [n, k, 3]
            ends = [(each.ndim, each.shape[1:][-1:]) for each in (value, known)]
            if not alike or ends[0] != ends[1] or step.shape != ():
                raise ValueError(f"{name} has another shape or type")
            if not all(bool(each.isfinite().all()) for each in (*held, step)):
                raise ValueError(f"{name} is not finite")
            if not value.is_floating_point() or not math.isfinite(saved["lr"]):
                raise ValueError(f"{name} is not optimised by numbers")
        device = next((tensor.device for tensor in self.tensors.values()), None)
        for name in self.tensors.keys() - state.keys():
            self.drop(name)
        for name in (name for name in state if name not in self.tensors):
            self.add(name, state[name]["value"].to(device), state[name]["lr"])
        self.tensors = {name: self.tensors[name] for name in state}  # the next state is the same
        for name, tensor in list(self.tensors.items()):
            saved = state[name]
            if tensor.shape == saved["value"].shape:
                tensor.copy_(saved["value"])
            else:
                self._replace(name, saved["value"].to(tensor.device), {})
                tensor = self.tensors[name]
            self._group(name)["lr"] = saved["lr"]
            # steps stay on the host, where they are read
            taken = {"step": saved["step"].clone()} if "step" in saved else {}
            self.adam.state[tensor] = taken | {
                key: saved[key].to(tensor.device, copy=True) for key in MOMENTS if key in saved
            }
            if "grad" in saved:
                tensor.grad = saved["grad"].to(tensor.device, copy=True)

    def _steps_taken(self, tensor: Tensor) -> dict[str, Tensor]:
        state = self.adam.state.get(tensor, {})
        return {"step": torch.as_tensor(float(state["step"]))} if state else {}

    def validate_rows(self, *others: Tensor) -> None:
        """Raise ValueError unless all tensors, and all `others`, have a row for each Gaussian."""
        if len({len(tensor) for tensor in (*self.tensors.values(), *others)}) > 1:
            raise ValueError("its tensors are of different numbers of Gaussians")

    def _group(self, name: str) -> dict:
        return next(group for group in self.adam.param_groups if group["name"] == name)

    def _moments(self, tensor: Tensor) -> dict[str, Tensor]:
        """Return the moments of a tensor, and gradients that no step has taken yet."""
        state = self.adam.state.get(tensor, {})
        found = {key: state[key] for key in MOMENTS if key in state}
        return found if tensor.grad is None else found | {"grad": tensor.grad}

    def _replace(self, name: str, value: Tensor, moments: dict[str, Tensor]) -> None:
        old = self.tensors[name]
        new = _leaf(value)
        new.grad = moments.pop("grad", None)
        state = self.adam.state.pop(old, {})
        if moments:
            self.adam.state[new] = {"step": state["step"], **moments}
        self._group(name)["params"][0] = new
        self.tensors[name] = new


def _is_native(tensor: Tensor) -> bool:
    return binding.supports(tensor) and tensor.is_contiguous()


def _launch(steps: list[tuple[int, int, Trained]], on: Tensor) -> None:
    """Take the steps of at most `STEPS_MAX` tensors on the device of `on`."""
    struct, kernels = _Steps(count=len(steps)), cuda.kernels_for(on)
    for i, (rows, stride, trained) in enumerate(steps):
        struct.tensors[i], struct.rows[i], struct.strides[i] = trained, rows, stride
    blocks = sum(-(-rows * trained.columns // cuda.THREADS) for rows, _, trained in steps)
    with kernels.current():
        kernels.launch("mgs_adam", blocks, cuda.THREADS, struct)


def _leaf(value: Tensor) -> Tensor:
    leaf = torch.empty(value.shape, dtype=value.dtype, device=value.device)
    return leaf.copy_(value.detach()).requires_grad_()
