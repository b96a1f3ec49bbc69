"""Training cameras and rendercanvas events, for tests of the pose and the window."""

from itertools import count
from typing import Any

import numpy as np
import torch

from mobilegs.camera import Camera, look_at

SECONDS = count(1.0)


def ring(size: int = 5, *, outwards: bool = False) -> list[Camera]:
    """Cameras around the origin, a little above it, that look at it or away from it."""
    views = []
    for angle in torch.linspace(0.2, 4.5, size).tolist():
        eye = 3 * torch.tensor([np.cos(angle), -0.4, np.sin(angle)]).float()
        target = torch.tensor([0.2, 0.1, -0.1]) * (1 - outwards) + 2 * eye * outwards
        viewmat = look_at(eye, target, torch.tensor([0.05, -1.0, 0.02]))
        k = torch.tensor([[90.0, 0, 40], [0, 80, 30], [0, 0, 1]])
        views.append(Camera(viewmat, k, 80, 60))
    return views


def event(kind: str, **more: Any) -> dict:
    """An event as rendercanvas sends it, a second after the one before."""
    given = {"modifiers": (), "buttons": (), "time_stamp": next(SECONDS), **more}
    return {"event_type": kind, **given}
