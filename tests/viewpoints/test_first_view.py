"""The first view and the limits of a scene, found from depth images of its cameras."""

import math
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.mgs.codec import inspect_mgs
from mobilegs.render.scene import Scene
from mobilegs.up import unit
from mobilegs.viewpoints.first_view import Coverage, find_framing, find_subject
from mobilegs.viewpoints.framing import SECTORS, Framing, azimuth_between, azimuth_of
from mobilegs.viewpoints.orbit import orbit_cameras
from mobilegs.viewpoints.pose import Pose, camera_of
from tests.support.garden import garden

UP = torch.tensor([0.0, 0, 1])
MIDDLE = torch.tensor([5.0, 6.0, 7.3])  # of the garden


def ring(angles: list[float], *, outwards: bool = False, wide: float = 60.0) -> list[Camera]:
    """Cameras at some degrees around the garden, that look at it or away from it."""
    K = torch.tensor([[wide, 0, 40], [0, wide, 30], [0, 0, 1]])
    cameras = []
    for angle in map(math.radians, angles):
        away = torch.tensor([4 * math.cos(angle), 4 * math.sin(angle), 1.7])
        target = MIDDLE + 2 * away if outwards else MIDDLE
        cameras.append(Camera(look_at(MIDDLE + away, target, UP), K, 80, 60))
    return cameras


def _away(angle: float) -> np.ndarray:
    return np.array([4 * math.cos(math.radians(angle)), 4 * math.sin(math.radians(angle)), 1.7])


def scene() -> Scene:
    return Scene(garden(), up=UP.double().numpy())


@torch.no_grad()
def test_pixels_are_unseen_where_no_camera_looked() -> None:
    coverage = Coverage(scene(), ring([0, 40]))
    coverage.isolated = False
    own, beside, behind = (
        float(coverage.unseen(camera.resized(24, 18)).float().mean())
        for camera in ring([0, 40, 150])
    )
    assert own < 0.1 and beside < 0.1 < behind < 0.9


@pytest.mark.thorough
def test_the_first_view_holds_the_subject_and_what_was_seen() -> None:
    views = ring(list(range(0, 360, 15)))
    found = find_framing(scene(), views)
    assert found.start is not None and found.portrait is not None and found.limits is not None
    assert all(found.limits.open) and len(found.limits.elevations) == SECTORS
    assert np.linalg.norm(found.limits.pivot[:2] - [5.0, 6.0]) < 0.5
    coverage = Coverage(scene(), views)
    subject = find_subject(coverage)
    assert subject is not None
    for width, height in ((90, 160), (160, 75), (120, 90)):
        start = found.start_for(width, height)
        assert start is not None
        camera = camera_of(Pose.from_start(start, UP.double().numpy()), None, width, height, 0.2)
        local = subject @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]
        x, y, _ = (local @ camera.K.T / local[:, 2:]).T
        inside = (x > 0) & (x < width) & (y > 0) & (y < height)
        assert float(inside.float().mean()) > 0.95
        with torch.no_grad():
            assert float(coverage.unseen(camera).float().mean()) < 0.03


def test_limits_are_where_the_cameras_were() -> None:
    found = find_framing(scene(), ring(list(range(-40, 41, 10))))
    assert found.limits is not None
    up = UP.double().numpy()
    open_sectors = np.flatnonzero(found.limits.open)
    assert 4 <= len(open_sectors) < SECTORS / 2
    for azimuth in open_sectors * 360 / SECTORS + 180 / SECTORS:
        towards = [azimuth_of(unit(_away(angle)), up)[0] for angle in range(-40, 41, 10)]
        assert min(abs(azimuth_between(azimuth, each)) for each in towards) < 32
    cameras = orbit_cameras(
        Scene(garden(50), up=up, notes=found.notes), [], 24, width=64, height=48
    )
    azimuths = [
        azimuth_of(unit((camera.position - MIDDLE).double().numpy()), up)[0] for camera in cameras
    ]
    for azimuth in azimuths:
        nearest, _, _ = found.limits.range_at(azimuth)
        assert abs(azimuth_between(nearest, azimuth)) < 8  # of another pivot
    places = torch.stack([camera.position for camera in cameras])
    assert (places[1:] - places[:-1]).norm(dim=1).max() < 1.5  # it swings, and does not jump


def test_nothing_is_found_without_a_subject() -> None:
    away = ring(list(range(0, 360, 15)), outwards=True, wide=200.0)
    assert find_framing(scene(), away) == Framing()
    assert find_framing(scene(), []) == Framing()
    assert find_framing(Scene(garden()), ring([0, 20, 40])) == Framing()


def test_a_run_notes_its_framing(finished: Path) -> None:
    notes = inspect_mgs(finished / "scene.mgs")["meta"]
    assert {"start", "start_portrait", "limits"} <= notes.keys()
