"""The ways to move: the same as in the browser."""

import json
import subprocess
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.view.orbit import Input, Pose, camera_of, place_under
from tests.web.test_decoder import node_program

VIEWER = Path(__file__).parents[2] / "mobilegs" / "view" / "web" / "viewer"
# moves a pose by [name, ...arguments], and tells where it is after each
MOVES = """
const [{ Pose, cameraOf }, { placeUnder }] = await Promise.all([
  import(`${process.argv[1]}/pose.js`), import(`${process.argv[1]}/pick.js`)]);
const { views, index, centers, moves } = JSON.parse(process.argv[2]);
const flat = Float32Array.from(centers.flat());
const pose = views.length ? Pose.fromViews(views, index) : Pose.around(flat);
const told = () => [...pose.eye, ...pose.target, ...pose.up, pose.reach, ...pose.viewmat()];
const path = [told()];
for (const [move, ...given] of moves) { pose[move](...given); path.push(told()); }
const camera = cameraOf(pose, views[0] ?? null, 900, 500, 0.2);
const { fx, fy, cx, cy } = camera;
const logits = new Float32Array(centers.length);
const place = placeUnder(flat, logits, camera, 450, 250);
console.log(JSON.stringify({ path, lens: [fx, fy, cx, cy], place }));
"""
MOVED = [
    ("orbit", 0.4, 0.2), ("orbit", -1.1, 5.0), ("orbit", 0.0, -0.7), ("dolly", 0.5),
    ("look", 0.3, -0.2), ("move", 0.2, -0.1, 0.4), ("dolly", 1e-9), ("dolly", 700.0),
    ("focus", [0.1, 0.2, 0.3]), ("orbit", 2.0, -9.0), ("look", 0.1, 9.0),
]  # fmt: skip


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


@pytest.mark.parametrize("case", ["ring", "outwards", "none"])
def test_a_pose_moves_as_in_the_browser(case: str) -> None:
    views = {"ring": ring(), "outwards": ring(outwards=True), "none": []}[case]
    index = 2 if views else 0
    centers = np.random.default_rng(3).normal(size=(400, 3)).astype(np.float32)
    given = {
        "views": [
            {
                "viewmat": view.viewmat.flatten().tolist(),
                "K": view.K.flatten().tolist(),
                "width": view.width,
                "height": view.height,
            }
            for view in views
        ],
        "index": index,
        "centers": centers.tolist(),
        "moves": MOVED,
    }
    words = [node_program(), "--input-type=module", "-e", MOVES, str(VIEWER), json.dumps(given)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    theirs = json.loads(done.stdout)
    pose = Pose.from_views(views, index) if views else Pose.around(centers)

    def told() -> list[float]:
        place = [*pose.eye, *pose.target, *pose.up, pose.reach]
        return [*map(float, place), *pose.viewmat().flatten().tolist()]

    ours = [told()]
    for name, *given in MOVED:
        getattr(pose, name)(*(np.array(a) if isinstance(a, list) else a for a in given))
        ours.append(told())
    np.testing.assert_allclose(ours, theirs["path"], rtol=1e-6, atol=1e-6)
    seen = camera_of(pose, views[0] if views else None, 900, 500, 0.2)
    lens = [seen.K[0, 0], seen.K[1, 1], seen.K[0, 2], seen.K[1, 2]]
    np.testing.assert_allclose(lens, theirs["lens"], rtol=1e-6)
    place = place_under(centers, seen, 450.0, 250.0)
    assert (place is None) == (theirs["place"] is None)
    if place is not None:
        np.testing.assert_allclose(place, theirs["place"], rtol=1e-6)


def test_one_camera_alone_looks_a_step_ahead() -> None:
    (view,) = ring(1)
    pose = Pose.from_views([view])
    np.testing.assert_allclose(pose.eye, view.position, rtol=1e-6)
    np.testing.assert_allclose(pose.target - pose.eye, view.viewmat[2, :3], atol=1e-6)


def test_what_lies_under_the_pointer_is_the_nearest_thing_there() -> None:
    pose = Pose(np.array([0.0, 0, -3]), np.zeros(3), np.array([0.0, -1, 0]))
    seen = camera_of(pose, None, 100, 100, 0.2)
    centers = np.array([[0, 0, 1], [0, 0, 0.5], [1, 0, 0], [0, 0, -2.9], [0, 0, -9]], np.float32)
    np.testing.assert_array_equal(place_under(centers, seen, 50.0, 50.0), centers[1])
    assert place_under(centers, seen, 5.0, 95.0) is None


SECONDS = count(1.0)


def event(kind: str, **more: Any) -> dict:
    """An event as rendercanvas sends it, a second after the one before."""
    given = {"modifiers": (), "buttons": (), "time_stamp": next(SECONDS), **more}
    return {"event_type": kind, **given}


def test_keys_that_are_held_fly_and_a_tap_counts() -> None:
    moved = Input(Pose(np.array([0.0, 0, -3]), np.zeros(3), np.array([0.0, -1, 0])))
    assert moved.key(event("key_down", key="w"), True) and moved.busy
    assert moved.pose.eye[2] == pytest.approx(-3 + 0.9 * 3 * 0.03)
    moved.advance(0.5)
    assert moved.pose.eye[2] == pytest.approx(-3 + 0.9 * 3 * 0.53)
    moved.key(event("key_down", key="Shift", modifiers=("Shift",)), True)
    moved.advance(0.1)
    assert moved.pose.eye[2] == pytest.approx(-3 + 0.9 * 3 * 0.93)
    moved.key(event("key_up", key="W"), False)  # with Shift a letter is a capital
    assert not moved.busy
    assert not moved.key(event("key_down", key="s", modifiers=("Control",)), True)
    assert not moved.key(event("key_down", key="x"), True)
    moved.mode = "fly"
    before = moved.pose.eye
    moved.key(event("key_down", key="ArrowLeft"), True)
    np.testing.assert_array_equal(moved.pose.eye, before)
    assert moved.pose.forward[0] < 0  # looks to the left
