"""The cameras of one turn around a scene."""

import math

import numpy as np

from mobilegs.camera import Camera
from mobilegs.render.scene import Scene
from mobilegs.up import Axis
from mobilegs.viewpoints.framing import azimuth_of, direction_of, parsed_framing
from mobilegs.viewpoints.pose import camera_of, first_pose


def orbit_cameras(
    scene: Scene,
    views: list[Camera],
    count: int,
    *,
    width: int,
    height: int,
    up: Axis | None = None,
) -> list[Camera]:
    """Return `count` cameras of one turn around the target of the first view.

    Distance and height are those of the first view (`first_pose`), as far as the scene's limits
    allow. Where they do not allow a whole turn, the cameras swing from one end to the other and
    back.
    """
    pose = first_pose(scene, views, up, size=(width, height))
    limits = parsed_framing(scene.notes).limits_for(width, height) if up is None else None
    away = pose.eye - pose.target
    distance = float(np.linalg.norm(away))
    start, height_angle = azimuth_of(away / distance, pose.up)
    ends = None if limits is None else limits.ends_around(start)
    cameras = []
    for step in range(count):
        azimuth = start - 360 * step / count
        elevation = height_angle
        if ends is not None:
            azimuth = swing(start, *ends, step / count)
        if limits is not None:
            azimuth, low, high = limits.range_at(azimuth)
            elevation = min(max(elevation, low), high)
        pose.eye = pose.target + distance * direction_of(azimuth, elevation, pose.up)
        cameras.append(camera_of(pose, views[0] if views else None, width, height, scene.near))
    return cameras


def swing(start: float, low: float, high: float, time: float) -> float:
    """Return the azimuth at a time, 0 to 1, of a swing from `start` to both ends and back."""
    half = max((high - low) / 2, 1e-6)
    phase = math.asin(min(1.0, max(-1.0, (start - (low + high) / 2) / half)))
    return (low + high) / 2 + half * math.sin(phase - math.tau * time)
