"""Cameras of browsers for tests of the live view."""

import math

from mobilegs.camera import Camera
from mobilegs.live.frames import BrowserCamera


def browser_at(camera: Camera, *, width: int = 24, height: int = 24) -> BrowserCamera:
    """A browser's camera in the place of a photo's."""
    x, y, z = camera.position.tolist()
    turn = tuple(camera.viewmat[:3, :3].T.flatten().tolist())
    return BrowserCamera((x, y, z), turn, 2 * math.atan(12 / 28), width, height)
