"""Adam over named tensors, whose rows can be added and removed together with their moments."""

import math
from collections.abc import Mapping

import torch
from jaxtyping import Bool, Int
from torch import Tensor

EPS = 1e-15  # of 3DGS: gradients per Gaussian are tiny
MOMENTS = ("exp_avg", "exp_avg_sq")


def log_linear(start: float, end: float, fraction: float) -> float:
    """The rate on the way from `start` to `end` (both > 0), geometric, `fraction` in [0, 1]."""
    fraction = min(max(fraction, 0.0), 1.0)
    return math.exp(math.log(start) * (1 - fraction) + math.log(end) * fraction)


class NamedAdam:
    """Leaf tensors by name, each with its own rate, and the Adam that moves them.

    `tensors` always holds the current leaves: growing and pruning replace them. Methods that
    change rows apply to every tensor, so Gaussians have one `NamedAdam`, networks and codebooks
    another.
    """

    def __init__(
        self, tensors: Mapping[str, Tensor], rates: Mapping[str, float], *, eps: float = EPS
    ) -> None:
        """Parameters are adopted as they are (a network's stay its own), others are copied."""
        self.tensors: dict[str, Tensor] = {
            name: t if isinstance(t, torch.nn.Parameter) else _leaf(t)
            for name, t in tensors.items()
        }
        groups = [
            {"params": [tensor], "lr": rates[name], "name": name}
            for name, tensor in self.tensors.items()
        ]
        nothing = [{"params": [], "name": ""}]  # without any group, torch refuses to begin
        self.adam = torch.optim.Adam(groups or nothing, eps=eps, fused=True)

    def set_rate(self, name: str, rate: float) -> None:
        """Give one tensor another learning rate."""
        self._group(name)["lr"] = rate

    def rate(self, name: str) -> float:
        """The learning rate of one tensor."""
        return self._group(name)["lr"]

    def step(self) -> None:
        """One step of Adam with the gradients at hand, which are then dropped."""
        self.adam.step()
        self.adam.zero_grad(set_to_none=True)

    def add(self, name: str, tensor: Tensor, rate: float) -> None:
        """Take on one more tensor; the others keep their moments."""
        self.tensors[name] = tensor if isinstance(tensor, torch.nn.Parameter) else _leaf(tensor)
        self.adam.add_param_group({"params": [self.tensors[name]], "lr": rate, "name": name})

    def drop(self, name: str) -> Tensor:
        """Move one tensor no longer; its values are returned."""
        tensor = self.tensors.pop(name)
        self.adam.state.pop(tensor, None)
        groups = self.adam.param_groups
        groups[:] = [group for group in groups if group["name"] != name]
        return tensor.detach()

    @torch.no_grad()
    def keep_rows(self, rows: Bool[Tensor, "n"]) -> None:
        """Keep only the rows where the mask is true, of every tensor and of its moments."""
        for name, tensor in list(self.tensors.items()):
            moments = {key: value[rows] for key, value in self._moments(tensor).items()}
            self._replace(name, tensor[rows], moments)

    @torch.no_grad()
    def append_rows(self, new: Mapping[str, Tensor]) -> None:
        """Add rows to every tensor; their moments start at 0."""
        for name, tensor in list(self.tensors.items()):
            added = new[name]
            moments = {
                key: torch.cat([value, torch.zeros_like(added)])
                for key, value in self._moments(tensor).items()
            }
            self._replace(name, torch.cat([tensor, added]), moments)

    @torch.no_grad()
    def reset(self, name: str, value: Tensor) -> None:
        """Give one tensor new values of the same shape; its moments start again at 0."""
        moments = {key: torch.zeros_like(value) for key in self._moments(self.tensors[name])}
        self._replace(name, value, moments)

    def forget_all(self) -> None:
        """All moments start again: the tensors mean something else now."""
        self.adam.state.clear()

    @torch.no_grad()
    def forget(self, rows: Bool[Tensor, "n"] | Int[Tensor, "m"]) -> None:
        """The moments of some rows, of every tensor, start again at 0."""
        for tensor in self.tensors.values():
            for moment in self._moments(tensor).values():
                moment[rows] = 0

    @torch.no_grad()
    def restart(self, values: Mapping[str, Tensor]) -> None:
        """Give every tensor new values, of any number of rows, and begin Adam anew."""
        for name in list(self.tensors):
            self._replace(name, values[name], {})

    def state(self) -> dict:
        """Everything needed to continue: values, moments, step counts and rates, by name."""
        return {
            name: {
                "value": tensor.detach(),
                "rate": float(self._group(name)["lr"]),
                **self.adam.state.get(tensor, {}),
            }
            for name, tensor in self.tensors.items()
        }

    @torch.no_grad()
    def restore(self, state: Mapping[str, dict]) -> None:
        """Continue from what `state()` gave, whatever tensors and rows it had.

        Tensors that keep their shape are written in place, so networks stay connected. New ones
        go where the others are, wherever the state lies.
        """
        device = next((tensor.device for tensor in self.tensors.values()), None)
        for name in self.tensors.keys() - state.keys():
            self.drop(name)
        for name in sorted(state.keys() - self.tensors.keys()):
            self.add(name, state[name]["value"].to(device), state[name]["rate"])
        for name, tensor in list(self.tensors.items()):
            saved = state[name]
            if tensor.shape == saved["value"].shape:
                tensor.copy_(saved["value"])
            else:
                self._replace(name, saved["value"].to(tensor.device), {})
                tensor = self.tensors[name]
            self._group(name)["lr"] = saved["rate"]
            self.adam.state[tensor] = {
                key: saved[key].to(tensor.device, copy=True)
                for key in ("step", *MOMENTS)
                if key in saved
            }

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
    return value.detach().clone().contiguous().requires_grad_()
