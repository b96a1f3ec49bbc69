"""A small scene of known shape, a garden, and cameras around it."""

import json
from pathlib import Path

import torch

from mobilegs.camera import look_at
from mobilegs.gaussians import Gaussians

UP = torch.tensor([0.0, 0.0, 1.0])


def garden(count: int = 3000, *, seed: int = 0) -> Gaussians:
    """Return a round lawn in the plane z = 0 with a post in its middle."""
    random = torch.Generator().manual_seed(seed)
    post = count // 3
    turn, out, high = torch.rand(3, count, generator=random)
    radius = 2 * out.sqrt()
    means = torch.stack([radius * (6.28 * turn).cos(), radius * (6.28 * turn).sin(), 0 * high], 1)
    means[:post, :2] *= 0.1
    means[:post, 2] = 1.5 * high[:post]
    sh = torch.zeros(count, 4, 3)
    sh[:, 0] = 2 * torch.rand(count, 3, generator=random) - 1
    return Gaussians(
        means=means + torch.tensor([5.0, 6.0, 7.0]),
        quats=torch.tensor([[1.0, 0, 0, 0]]).expand(count, 4).clone(),
        log_scales=torch.full((count, 3), 0.05).log(),
        logit_opacities=torch.full((count,), 2.0),
        sh=sh,
    )


def cameras_json(path: Path, count: int = 6) -> Path:
    """Write a 3DGS cameras.json with `count` cameras on a circle around the garden."""
    rows = []
    for step in range(count):
        turn = torch.tensor(6.28 * step / count)
        eye = torch.tensor([5.0, 6.0, 8.5]) + 4 * torch.stack([turn.cos(), turn.sin(), 0 * turn])
        viewmat = look_at(eye, torch.tensor([5.0, 6.0, 7.3]), UP)
        rows.append(
            {
                "id": step,
                "img_name": f"{step}",
                "width": 320,
                "height": 200,
                "position": eye.tolist(),
                "rotation": viewmat[:3, :3].T.tolist(),
                "fx": 300.0,
                "fy": 310.0,
            }
        )
    path.write_text(json.dumps(rows))
    return path
