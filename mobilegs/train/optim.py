"""Adam over named tensors whose rows, with their moments, can be added and removed."""

import math
from collections.abc import Mapping

import torch
from jaxtyping import Bool, Int
from torch import Tensor

EPS = 1e-15  # of 3DGS: gradients per Gaussian are tiny
MOMENTS = ("exp_avg", "exp_avg_sq")


def exponential_lr(start: float, end: float, fraction: float) -> float:
    """Interpolate geometrically from `start` to `end` (both > 0).

    `fraction` is clamped to [0, 1]. This is the schedule of 3DGS for the means' learning rate.
    """
    fraction = min(max(fraction, 0.0), 1.0)
    return math.exp(math.log(start) * (1 - fraction) + math.log(end) * fraction)


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

    def step(self) -> None:
        """Take one Adam step with the current gradients, then clear them."""
        for tensor in self.tensors.values():
            # on a GPU, Adam refuses gradients with other strides, be they of empty dimensions
            if tensor.grad is not None and tensor.grad.stride() != tensor.stride():
                tensor.grad = torch.empty_like(tensor).copy_(tensor.grad)
        self.adam.step()
        self.adam.zero_grad(set_to_none=True)

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
        for name, tensor in list(self.tensors.items()):
            moments = {key: value[rows] for key, value in self._moments(tensor).items()}
            self._replace(name, tensor[rows], moments)

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
            held = [value, *(saved[key] for key in MOMENTS if key in saved)]
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
        for name in sorted(state.keys() - self.tensors.keys()):
            self.add(name, state[name]["value"].to(device), state[name]["lr"])
        for name, tensor in list(self.tensors.items()):
            saved = state[name]
            if tensor.shape == saved["value"].shape:
                tensor.copy_(saved["value"])
            else:
                self._replace(name, saved["value"].to(tensor.device), {})
                tensor = self.tensors[name]
            self._group(name)["lr"] = saved["lr"]
            self.adam.state[tensor] = {
                key: saved[key].to(tensor.device, copy=True)
                for key in ("step", *MOMENTS)
                if key in saved
            }

    def validate_rows(self, *others: Tensor) -> None:
        """Raise ValueError unless all tensors, and all `others`, have a row for each Gaussian."""
        if len({len(tensor) for tensor in (*self.tensors.values(), *others)}) > 1:
            raise ValueError("its tensors are of different numbers of Gaussians")

    def _group(self, name: str) -> dict:
        return next(group for group in self.adam.param_groups if group["name"] == name)

    def _moments(self, tensor: Tensor) -> dict[str, Tensor]:
        state = self.adam.state.get(tensor, {})
        return {key: state[key] for key in MOMENTS if key in state}

    def _replace(self, name: str, value: Tensor, moments: dict[str, Tensor]) -> None:
        old = self.tensors[name]
        new = _leaf(value)
        state = self.adam.state.pop(old, {})
        if moments:
            self.adam.state[new] = {"step": state["step"], **moments}
        self._group(name)["params"][0] = new
        self.tensors[name] = new


def _leaf(value: Tensor) -> Tensor:
    leaf = torch.empty(value.shape, dtype=value.dtype, device=value.device)
    return leaf.copy_(value.detach()).requires_grad_()
