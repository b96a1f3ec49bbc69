"""The paper's network for view-dependent opacity and phi (section 3.2)."""

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import normalize, pad

from mobilegs.gaussians import Gaussians
from mobilegs.render.lobes import constant_lobes

STATICS = 19  # columns of `static_inputs`


class ViewNetwork(nn.Module):
    """22 -> 256 -> 128 -> 64 -> (phi, opacity), 47,170 parameters (paper section 3.2).

    As in the authors' release, the 64-wide layer has no activation and both heads are linear; the
    renderer applies the ReLU of phi. phi starts at 1. Unlike in the release, which discards the
    teacher's opacities, the opacity head's output is added to each Gaussian's logit from the
    teacher and starts at 0.
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
                bound = layer.in_features**-0.5  # torch's default, from the given generator
                layer.weight.uniform_(-bound, bound, generator=generator)
                layer.bias.uniform_(-bound, bound, generator=generator)
            self.phi.weight.zero_()
            self.phi.bias.fill_(1.0)
            self.opacity.weight.zero_()
            self.opacity.bias.zero_()

    def forward(
        self, gaussians: Gaussians, directions: Float[Tensor, "n 3"]
    ) -> Float[Tensor, "n 1 2"]:
        """Return the lobes of degree 0 for one view.

        `directions` are unit vectors from the camera to the Gaussians in world space. The other
        inputs are spherical harmonics of degree 0 and 1, scales and quaternion, each normalised.
        """
        color, shape = static_inputs(gaussians).split([12, 7], dim=1)
        inputs = torch.cat([color, directions, shape], dim=1)  # [n, 22]
        hidden = torch.relu(self.hidden2(torch.relu(self.hidden1(inputs))))
        # two linear layers in a row are one: fold the 64-wide layer into the heads
        heads = torch.cat([self.phi.weight, self.opacity.weight])  # [2, 64]
        bias = torch.cat([self.phi.bias, self.opacity.bias])
        out = hidden @ (heads @ self.hidden3.weight).T + heads @ self.hidden3.bias + bias
        return constant_lobes(gaussians.logit_opacities + out[:, 1], out[:, 0])


def static_inputs(gaussians: Gaussians) -> Float[Tensor, "n 19"]:
    """Return the network's inputs that do not depend on the view: harmonics, scales, rotation.

    Harmonics are those of degree 0 and 1, padded with zeros; each of the three has length 1.
    """
    low = gaussians.sh[:, :4]
    color = pad(low, (0, 0, 0, 4 - low.shape[1])).flatten(1)
    parts = [color, gaussians.scales, gaussians.quats]
    return torch.cat([normalize(part, dim=1) for part in parts], dim=1)


def _linear(inputs: int, outputs: int) -> nn.Linear:
    """Make a layer without values: torch would draw them from its global random state."""
    return nn.Linear(inputs, outputs, device="meta").to_empty(device=torch.get_default_device())
