"""First views and limits: the notes, compared with the web viewer, and how they are found."""

import json

import numpy as np
import pytest

from mobilegs.up import USUAL, unit
from mobilegs.viewpoints.framing import (
    FREE,
    SECTORS,
    Framing,
    Limits,
    Start,
    azimuth_of,
    direction_of,
    parsed_framing,
)
from tests.support.node import javascript

ALL = np.tile([-20.0, 50.0], (SECTORS, 1))
SOME = np.tile([90.0, -90.0], (SECTORS, 1))
SOME[22:], SOME[:3], SOME[9] = (-5, 30), [(0, 40), (10, 20), (15, 15)], (0, 60)
READ = """
const m = await import(`${process.argv[1]}/viewer/framing.js`);
const { texts, azimuths, directions, ups } = JSON.parse(process.argv[2]);
console.log(JSON.stringify({
  starts: texts.map(m.parsedStart), limits: texts.map(m.parsedLimits),
  ranges: texts.map(m.parsedLimits).map((one) => one && azimuths.map((a) => m.rangeAt(one, a))),
  angles: ups.map((up) => directions.map((d) => m.anglesOf(d, up))),
  back: ups.map((up) => directions.map((d) => m.directionOf(...m.anglesOf(d, up), up))),
}));
"""
# moves a pose and brings it back
SPRING = """
const [{ Pose }, m] = await Promise.all(
  ["pose", "framing"].map((name) => import(`${process.argv[1]}/viewer/${name}.js`)));
const { text, eye, target, up, mode } = JSON.parse(process.argv[2]);
const limits = m.parsedLimits(text);
const pose = new Pose(eye, target, up);
const pulled = [];
for (let i = 0; i < 60; i++) {
  pose.orbit(0.03, 0.03); pose.dolly(1.05); m.resist(pose, limits, mode);
  pulled.push(m.excessOf(pose, limits));
}
let frames = 0;
while (m.spring(pose, limits, mode, 1 / 60) && frames < 600) frames += 1;
const excess = m.excessOf(pose, limits);
console.log(JSON.stringify({ pulled, frames, excess, eye: pose.eye, target: pose.target }));
"""


def limits_of(elevations: np.ndarray) -> Limits:
    return Limits(np.array([0.5, -1.25, 3.0]), 0.75, 0.25, 4.5, elevations)


def test_notes_are_read_as_written() -> None:
    start = Start(np.array([1.5, -2.0, 1e-5]), np.array([0.0, 0.0, 123456.0]), (0.25, 0.5))
    framing = Framing(start, start, limits_of(SOME))
    found = parsed_framing(framing.notes)
    assert found.start is not None and found.limits is not None and not found.free
    np.testing.assert_array_equal(found.start.eye, start.eye)
    np.testing.assert_array_equal(found.start.target, start.target)
    assert found.start.box == start.box and found.notes == framing.notes
    np.testing.assert_array_equal(found.limits.elevations, SOME)
    assert parsed_framing({"limits": FREE}).free
    assert parsed_framing({"limits": FREE}).notes == {"limits": FREE}
    assert found.start_for(100, 200) is found.portrait
    assert found.start_for(200, 100) is found.start
    assert parsed_framing({}).start_for(1, 2) is None


BAD_STARTS = [
    "", "1 2 3 4 5 6 7", "1 2 3 1 2 3 1 1", "1 2 3 4 5 6 0 1", "1 2 3 4 5 6 1 1e9",
    "a 2 3 4 5 6 1 1",
    "1 2 3 4 5 6 1 nan", "1 2 3 4 5 6 1 1 1", "1 2 3 4 5 6 1 -1", "1 2 3 4 5 6 1 1000",
]  # fmt: skip


def test_readers_agree_on_notes() -> None:
    good = ["1 2 3 4 5 6 0.5 0.25", limits_of(ALL).text, limits_of(SOME).text]
    closed = limits_of(np.tile([90.0, -90.0], (SECTORS, 1))).text
    wrong = [closed, limits_of(2 * ALL).text, good[1] + " 1", good[1].replace("4.5", "0.1")]
    texts = [*good, *BAD_STARTS, *wrong]
    azimuths = np.linspace(0, 359.9, 97).tolist()
    rng = np.random.default_rng(0)
    directions = [unit(each).tolist() for each in rng.normal(size=(20, 3))]
    ups = [USUAL.tolist(), [0, 0, 1], [0, 1, 0], unit(rng.normal(size=3)).tolist()]
    given = {"texts": texts, "azimuths": azimuths, "directions": directions, "ups": ups}
    theirs = javascript(READ, given)
    for index, text in enumerate(texts):
        ours = parsed_framing({"start": text, "limits": text})
        assert (ours.start is None) == (theirs["starts"][index] is None), text
        assert (ours.limits is None) == (theirs["limits"][index] is None), text
        if ours.start is not None:
            assert theirs["starts"][index] == json.loads(
                json.dumps(
                    {
                        "eye": ours.start.eye.tolist(),
                        "target": ours.start.target.tolist(),
                        "box": ours.start.box,
                    }
                )
            )
        if ours.limits is not None:
            expected = [ours.limits.range_at(azimuth) for azimuth in azimuths]
            np.testing.assert_allclose(theirs["ranges"][index], expected, atol=1e-9)
    for i, up in enumerate(ups):
        expected = [azimuth_of(np.array(each), np.array(up, float)) for each in directions]
        np.testing.assert_allclose(theirs["angles"][i], expected, atol=1e-6)
        np.testing.assert_allclose(theirs["back"][i], directions, atol=1e-9)
        for each, angles in zip(directions, expected, strict=True):
            np.testing.assert_allclose(direction_of(*angles, np.array(up, float)), each, atol=1e-9)


@pytest.mark.parametrize("elevations", [ALL, SOME], ids=["all", "some"])
def test_a_pose_gives_way_and_springs_back(elevations: np.ndarray) -> None:
    limits = limits_of(elevations)
    target = limits.pivot
    eye = target + 3 * direction_of(7.5, 20.0, USUAL)
    given = {"text": limits.text, "eye": eye.tolist(), "target": target.tolist()}
    found = javascript(SPRING, given | {"up": USUAL.tolist(), "mode": "orbit"})
    assert 0.1 < max(found["pulled"]) < 1.5  # it gives way, but not without end
    assert 5 < found["frames"] < 120 and found["excess"] < 1e-3
    away = np.array(found["eye"]) - np.array(found["target"])
    assert np.linalg.norm(away) == pytest.approx(4.5, rel=1e-3)
    azimuth, elevation = azimuth_of(unit(away), USUAL)
    edge, low, high = limits.range_at(azimuth)
    assert edge == pytest.approx(azimuth, abs=0.1) and low - 0.1 <= elevation <= high + 0.1


def test_the_ends_of_open_sectors() -> None:
    limits = limits_of(SOME)
    assert limits_of(ALL).ends_around(10.0) is None
    assert limits.ends_around(10.0) == (-30.0, 45.0)
    assert limits.ends_around(340.0) == (330.0, 405.0)
    assert limits.ends_around(140.0) == (135.0, 150.0)
    assert limits.ends_around(60.0) == (45.0, 45.0)
