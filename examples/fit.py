"""Fit Gaussians to one photo: differentiable rendering in your own training loop.

    python examples/fit.py photo.jpg fitted.png --count 2000 --steps 300

One photo does not determine depth, but the loop has all parts of a training: tensors with
gradients, `render_sortfree`, a loss and an optimiser.
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from mobilegs import Camera, psnr, render_sortfree, to_bytes


def main() -> None:
    options = argparse.ArgumentParser(description="Fit Gaussians to a photo.")
    options.add_argument("photo", type=Path)
    options.add_argument("fitted", type=Path)
    options.add_argument("--count", type=int, default=2000, help="number of Gaussians")
    options.add_argument("--steps", type=int, default=300)
    given = options.parse_args()

    photo = Image.open(given.photo).convert("RGB")
    photo.thumbnail((320, 320))
    target = torch.from_numpy(np.array(photo)).float() / 255  # [h, w, 3]
    height, width = target.shape[:2]
    k = torch.tensor([[width, 0, width / 2], [0, width, height / 2], [0, 0, 1]])
    camera = Camera(torch.eye(4), k, width, height)

    torch.manual_seed(0)
    count = given.count
    means = (torch.rand(count, 3) - 0.5) * torch.tensor([1.0, height / width, 0.2])
    parameters = {
        "means": means + torch.tensor([0.0, 0.0, 1.0]),  # a slab, one unit in front of the camera
        "quats": torch.randn(count, 4),
        "log_scales": torch.full((count, 3), -0.5 * float(np.log(count)) - 1),
        "logit_opacities": torch.zeros(count),
        "sh": torch.zeros(count, 1, 3),
    }
    for value in parameters.values():
        value.requires_grad_()
    lr = {"means": 1e-3, "quats": 1e-2, "log_scales": 1e-2, "logit_opacities": 5e-2, "sh": 2e-2}
    groups = [{"params": [parameters[name]], "lr": lr[name]} for name in parameters]
    optimizer = torch.optim.Adam(groups, eps=1e-15)

    def render() -> torch.Tensor:
        return render_sortfree(
            parameters["means"],
            parameters["quats"],
            parameters["log_scales"].exp(),
            parameters["logit_opacities"].sigmoid(),
            parameters["sh"],
            camera=camera,
            background=torch.zeros(3),
        ).image

    for step in range(given.steps):
        image = render()
        if step % max(1, given.steps // 5) == 0:
            print(f"step {step}: {psnr(image.detach(), target):.2f} dB")
        optimizer.zero_grad()
        (image - target).abs().mean().backward()
        optimizer.step()

    image = render().detach()
    print(f"step {given.steps}: {psnr(image, target):.2f} dB")
    Image.fromarray(to_bytes(image).numpy()).save(given.fitted)


if __name__ == "__main__":
    main()
