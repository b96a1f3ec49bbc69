"""The pose and its input, compared with the web viewer."""

import numpy as np
import pytest

from mobilegs.up import USUAL, Axis, next_axis, turn_from_usual
from mobilegs.view.input import Input, point_under
from mobilegs.viewpoints.pose import Pose, camera_of
from tests.support.node import javascript
from tests.support.window import event, ring

# moves a pose by [name, ...arguments] and prints its state after each
MOVES = """
const [{ Pose, cameraOf }, { pointUnder }] = await Promise.all([
  import(`${process.argv[1]}/viewer/pose.js`), import(`${process.argv[1]}/viewer/pick.js`)]);
const { centers, moves, cases } = JSON.parse(process.argv[2]);
const flat = Float32Array.from(centers.flat());
const logits = new Float32Array(centers.length);
console.log(JSON.stringify(cases.map(({ views, up }) => {
  const pose = views.length ? Pose.fromViews(views, 2) : Pose.around(flat, up ?? undefined);
  const state = () => [...pose.eye, ...pose.target, ...pose.up, pose.reach, ...pose.viewmat()];
  const path = [state()];
  for (const [move, ...given] of moves) { pose[move](...given); path.push(state()); }
  const camera = cameraOf(pose, views[0] ?? null, 900, 500, 0.2);
  const { fx, fy, cx, cy } = camera;
  return { path, lens: [fx, fy, cx, cy], point: pointUnder(flat, logits, camera, 450, 250) };
})));
"""
MOVED = [
    ("orbit", 0.4, 0.2), ("orbit", -1.1, 5.0), ("orbit", 0.0, -0.7), ("dolly", 0.5),
    ("look", 0.3, -0.2), ("move", 0.2, -0.1, 0.4), ("dolly", 1e-9), ("dolly", 700.0),
    ("focus", [0.1, 0.2, 0.3]), ("orbit", 2.0, -9.0), ("look", 0.1, 9.0),
]  # fmt: skip


DIRECTIONS = {
    "z": [0, 0, 1], "y": [0, 1, 0], "-x": [-1, 0, 0], "tilted": [0.0, -0.96, -0.28],
    "about y": [0.0, (1 - 1e-8) ** 0.5, 1e-4],
}  # fmt: skip
# prints the steps of the button from each direction
STEPS = """
const { nextAxis } = await import(`${process.argv[1]}/viewer/up.js`);
console.log(JSON.stringify(JSON.parse(process.argv[2]).map((own) => {
  const steps = [];
  for (let now = null, i = 0; i < 7; i++) steps.push((now = nextAxis(now, own)));
  return [...steps, nextAxis("z", own), nextAxis("-y", own)];
})));
"""


def test_the_axes_that_point_up_in_turn_are_those_of_the_web_viewer() -> None:
    theirs = javascript(STEPS, list(DIRECTIONS.values()))
    for own, steps in zip(DIRECTIONS.values(), theirs, strict=True):
        direction = np.array(own, np.float64)
        now: Axis | None = None
        ours: list[Axis | None] = []
        for _ in range(7):
            ours.append(now := next_axis(now, direction))
        assert [*ours, next_axis("z", direction), next_axis("-y", direction)] == steps
        assert ours.count(None) == 1 and len({*ours}) == 6  # the nearest axis is left out
    assert theirs[0][:6] == ["-y", "y", "-z", "x", "-x", None]


@pytest.mark.parametrize("up", DIRECTIONS)
def test_a_first_pose_is_upright_and_looks_a_little_down(up: str) -> None:
    direction = np.array(DIRECTIONS[up], np.float64)
    turn = turn_from_usual(direction)
    np.testing.assert_allclose(turn @ USUAL, direction, atol=1e-7)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-7)
    assert np.linalg.det(turn) == pytest.approx(1)
    pose = Pose.around(np.random.default_rng(3).normal(size=(400, 3)).astype(np.float32), direction)
    assert -pose.viewmat()[1, :3] @ direction > 0.9
    assert (pose.eye - pose.target) @ direction > 0


def test_a_pose_moves_like_the_web_viewers(subtests: pytest.Subtests) -> None:
    centers = np.random.default_rng(3).normal(size=(400, 3)).astype(np.float32)
    cases = {"ring": (ring(), None), "outwards": (ring(outwards=True), None), "none": ([], None)}
    cases |= {name: ([], up) for name, up in DIRECTIONS.items()}
    given = [
        {
            "up": up,
            "views": [
                {
                    "viewmat": view.viewmat.flatten().tolist(),
                    "K": view.K.flatten().tolist(),
                    "width": view.width,
                    "height": view.height,
                }
                for view in views
            ],
        }
        for views, up in cases.values()
    ]
    found = javascript(MOVES, {"centers": centers.tolist(), "moves": MOVED, "cases": given})
    for (name, (views, up)), theirs in zip(cases.items(), found, strict=True):
        pose = Pose.from_views(views, 2) if views else Pose.around(centers)
        if up is not None:
            pose = Pose.around(centers, np.array(up, np.float64))
        ours = [state(pose)]
        for move, *words in MOVED:
            getattr(pose, move)(*(np.array(a) if isinstance(a, list) else a for a in words))
            ours.append(state(pose))
        seen = camera_of(pose, views[0] if views else None, 900, 500, 0.2)
        lens = [seen.K[0, 0], seen.K[1, 1], seen.K[0, 2], seen.K[1, 2]]
        place = point_under(centers, seen, 450.0, 250.0)
        with subtests.test(name):
            np.testing.assert_allclose(ours, theirs["path"], rtol=1e-6, atol=1e-6)
            np.testing.assert_allclose(lens, theirs["lens"], rtol=1e-6)
            assert (place is None) == (theirs["point"] is None)
            if place is not None:
                np.testing.assert_allclose(place, theirs["point"], rtol=1e-6)


def state(pose: Pose) -> list[float]:
    place = [*pose.eye, *pose.target, *pose.up, pose.reach]
    return [*map(float, place), *pose.viewmat().flatten().tolist()]


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
