"""The paper's view-dependence network: opacity and weight of a Gaussian, seen from a direction."""

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import normalize, pad

from mobilegs.gaussians import Gaussians
from mobilegs.render.lobes import constant_lobes

STATICS = 19  # numbers of `statics`


class ViewNetwork(nn.Module):
    """22 -> 256 -> 128 -> 64 -> (phi, opacity), 47,170 parameters (paper section 3.2).

    There is no activation after the 64-wide layer, and the two heads are linear, as in the
    authors' release; the ReLU of phi is the renderer's. phi starts at 1 everywhere. The opacity's
    head starts at 0 here, because its output is added to a base logit that each Gaussian brings
    from the teacher (the release throws the teacher's opacities away and learns them anew).
    """

    def __init__(self, generator: torch.Generator | None = None) -> None:
        super().__init__()
        self.hidden1 = _linear(22, 256)
        self.hidden2 = _linear(256, 128)
        self.hidden3 = _linear(128, 64)
        self.phi = _linear(64, 1)
        self.opacity = _linear(64, 1)
        with torch.no_grad():
            for layer in (self.hidden1, self.hidden2, self.hidden3):
                bound = layer.in_features**-0.5  # torch's default, drawn from our generator
                layer.weight.uniform_(-bound, bound, generator=generator)
                layer.bias.uniform_(-bound, bound, generator=generator)
            self.phi.weight.zero_()
            self.phi.bias.fill_(1.0)
            self.opacity.weight.zero_()
            self.opacity.bias.zero_()

    def forward(
        self, gaussians: Gaussians, directions: Float[Tensor, "n 3"]
    ) -> Float[Tensor, "n 1 2"]:
        """The lobes for this view alone, of degree 0.

        Opacity is the base's logit and what the network adds to it. `directions` are unit
        vectors from the eye to the Gaussians in world space. Of harmonics (degree 1), scales and
        quaternions only the proportions are an input.
        """
        color, shape = statics(gaussians).split([12, 7], dim=1)
        inputs = torch.cat([color, directions, shape], dim=1)  # [n, 22]
        hidden = torch.relu(self.hidden2(torch.relu(self.hidden1(inputs))))
        # two linear maps in a row are one: the 64-wide layer is folded into the heads
        heads = torch.cat([self.phi.weight, self.opacity.weight])  # [2, 64]
        bias = torch.cat([self.phi.bias, self.opacity.bias])
        out = hidden @ (heads @ self.hidden3.weight).T + heads @ self.hidden3.bias + bias
        return constant_lobes(gaussians.logit_opacities + out[:, 1], out[:, 0])


def statics(gaussians: Gaussians) -> Float[Tensor, "n 19"]:
    """What the network knows of a Gaussian beside the direction: harmonics, scales, rotation.

    Harmonics are those of degree 0 and 1; zeros stand for what the colour does not have.
    """
    known = gaussians.sh[:, :4]
    color = pad(known, (0, 0, 0, 4 - known.shape[1])).flatten(1)
    parts = [color, gaussians.scales, gaussians.quats]
    return torch.cat([normalize(part, dim=1) for part in parts], dim=1)


def _linear(inputs: int, outputs: int) -> nn.Linear:
    """A layer without values: torch would draw them from its global random state."""
    return nn.Linear(inputs, outputs, device="meta").to_empty(device=torch.get_default_device())
