"""Cameras of browsers for tests of the live view."""

from mobilegs.camera import Camera
from mobilegs.live.frames import BrowserCamera


def browser_at(camera: Camera, *, width: int = 24, height: int = 24) -> BrowserCamera:
    """A browser's camera in the place of a photo's."""
    focal = float(camera.K[1, 1]) * height / camera.height
    viewmat = (*camera.viewmat[:3].flatten().tolist(), 0.0, 0.0, 0.0, 1.0)
    return BrowserCamera(viewmat, focal, width, height)
