"""The pose and its input, compared with the web viewer."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mobilegs.view.orbit import Input, Pose, camera_of, point_under
from tests.support.node import node_program
from tests.support.window import event, ring

VIEWER = Path(__file__).parents[2] / "viewer" / "src" / "viewer"
# moves a pose by [name, ...arguments] and prints its state after each
MOVES = """
const [{ Pose, cameraOf }, { pointUnder }] = await Promise.all([
  import(`${process.argv[1]}/pose.js`), import(`${process.argv[1]}/pick.js`)]);
const { views, index, centers, moves } = JSON.parse(process.argv[2]);
const flat = Float32Array.from(centers.flat());
const pose = views.length ? Pose.fromViews(views, index) : Pose.around(flat);
const state = () => [...pose.eye, ...pose.target, ...pose.up, pose.reach, ...pose.viewmat()];
const path = [state()];
for (const [move, ...given] of moves) { pose[move](...given); path.push(state()); }
const camera = cameraOf(pose, views[0] ?? null, 900, 500, 0.2);
const { fx, fy, cx, cy } = camera;
const logits = new Float32Array(centers.length);
const point = pointUnder(flat, logits, camera, 450, 250);
console.log(JSON.stringify({ path, lens: [fx, fy, cx, cy], point }));
"""
MOVED = [
    ("orbit", 0.4, 0.2), ("orbit", -1.1, 5.0), ("orbit", 0.0, -0.7), ("dolly", 0.5),
    ("look", 0.3, -0.2), ("move", 0.2, -0.1, 0.4), ("dolly", 1e-9), ("dolly", 700.0),
    ("focus", [0.1, 0.2, 0.3]), ("orbit", 2.0, -9.0), ("look", 0.1, 9.0),
]  # fmt: skip


@pytest.mark.parametrize("case", ["ring", "outwards", "none"])
def test_a_pose_moves_like_the_web_viewers(case: str) -> None:
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

    def state() -> list[float]:
        place = [*pose.eye, *pose.target, *pose.up, pose.reach]
        return [*map(float, place), *pose.viewmat().flatten().tolist()]

    ours = [state()]
    for name, *given in MOVED:
        getattr(pose, name)(*(np.array(a) if isinstance(a, list) else a for a in given))
        ours.append(state())
    np.testing.assert_allclose(ours, theirs["path"], rtol=1e-6, atol=1e-6)
    seen = camera_of(pose, views[0] if views else None, 900, 500, 0.2)
    lens = [seen.K[0, 0], seen.K[1, 1], seen.K[0, 2], seen.K[1, 2]]
    np.testing.assert_allclose(lens, theirs["lens"], rtol=1e-6)
    place = point_under(centers, seen, 450.0, 250.0)
    assert (place is None) == (theirs["point"] is None)
    if place is not None:
        np.testing.assert_allclose(place, theirs["point"], rtol=1e-6)


def test_a_single_camera_has_a_target_ahead() -> None:
    (view,) = ring(1)
    pose = Pose.from_views([view])
    np.testing.assert_allclose(pose.eye, view.position, rtol=1e-6)
    np.testing.assert_allclose(pose.target - pose.eye, view.viewmat[2, :3], atol=1e-6)


def test_the_place_under_the_pointer_is_the_nearest_one() -> None:
    pose = Pose(np.array([0.0, 0, -3]), np.zeros(3), np.array([0.0, -1, 0]))
    seen = camera_of(pose, None, 100, 100, 0.2)
    centers = np.array([[0, 0, 1], [0, 0, 0.5], [1, 0, 0], [0, 0, -2.9], [0, 0, -9]], np.float32)
    np.testing.assert_array_equal(point_under(centers, seen, 50.0, 50.0), centers[1])
    assert point_under(centers, seen, 5.0, 95.0) is None


def test_held_keys_fly_and_a_tap_counts() -> None:
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
