"""The upward direction in the viewer: from the file, the option and the button."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mobilegs.formats.ply import write_ply
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.scene_file import open_with_views
from mobilegs.up import AXES, Axis, parsed_up, up_of_cameras
from mobilegs.viewpoints.pose import first_pose
from tests.support.browser import Tab
from tests.support.node import javascript
from tests.support.viewer_page import MGS, visit

pytestmark = pytest.mark.thorough

VIEWER = "document.querySelector('mobile-gs').viewer"


def pose(tab: Tab) -> list[float]:
    """Return eye, target and upward direction."""
    return tab.page.evaluate(
        f"(() => {{ const p = {VIEWER}.pose; return [...p.eye, ...p.target, ...p.up]; }})()"
    )


def expected(path: Path, up: Any = None) -> list[float]:
    """Return the same of the first pose in Python."""
    found = first_pose(*open_with_views(path), up)
    return [*found.eye, *found.target, *found.up]


def ply(path: Path, up: list[float] | None = None) -> Path:
    gaussians = decode_mgs(MGS).decode().gaussians
    write_ply(path, gaussians, up=None if up is None else np.array(up, np.float64))
    return path


@pytest.mark.parametrize("up", [None, [0, 0.28, 0.96]])
def test_a_ply_opens_upright(tab: Tab, served: Any, tmp_path: Path, up: list[float] | None) -> None:
    made = ply(tmp_path / "made.ply", up)
    visit(tab, served("scene.ply", made.read_bytes()))
    assert pose(tab) == pytest.approx(expected(made), abs=1e-4)
    assert pose(tab)[6:] == pytest.approx(up or [0, -1, 0], abs=1e-6)


def test_notes_are_read_as_in_python() -> None:
    notes = ["0.6 0 0.8", "-0.000000 -2.000000 0.100000", "upwards", "0 0 0", "1 2", 3]
    program = """
    const { parsedUp } = await import(`${process.argv[1]}/viewer/up.js`);
    console.log(JSON.stringify(JSON.parse(process.argv[2]).map((note) => parsedUp(note) ?? null)));
    """
    for note, theirs in zip(notes, javascript(program, notes), strict=True):
        ours = parsed_up(note)
        assert theirs == (None if ours is None else pytest.approx(ours.tolist())), note


@pytest.mark.parametrize("note", ["0.6 0 0.8", "upwards"])
def test_a_mgs_opens_as_its_note_says_or_else_its_cameras(
    tab: Tab, served: Any, tmp_path: Path, note: Any
) -> None:
    scene = decode_mgs(MGS)
    path = tmp_path / "noted.mgs"
    path.write_bytes(encode_mgs(replace(scene, meta={"up": note})))
    visit(tab, served("scene.mgs", path.read_bytes()))
    assert pose(tab) == pytest.approx(expected(path), abs=1e-4)
    direction = parsed_up(note)
    assert (direction is None) == (note == "upwards")
    own = up_of_cameras(np.stack([view.viewmat.double().numpy() for view in scene.views]))
    named = (own if direction is None else direction).tolist()
    assert pose(tab)[6:] == pytest.approx(named, abs=1e-4)
    tab.page.keyboard.press("v")
    assert pose(tab)[6:] == pytest.approx(named, abs=1e-4)


def test_the_option_replaces_the_direction_of_the_file(
    tab: Tab, served: Any, tmp_path: Path
) -> None:
    up: Axis = "-x"
    made = ply(tmp_path / "made.ply", [0, 1, 0])
    visit(tab, served("scene.ply", made.read_bytes()), f"up={up}")
    assert pose(tab) == pytest.approx(expected(made, up), abs=1e-4)
    (tmp_path / "scene.mgs").write_bytes(MGS)
    visit(tab, served("scene.mgs", MGS), f"up={up}")
    assert pose(tab) == pytest.approx(expected(tmp_path / "scene.mgs", up), abs=1e-4)
    tab.page.evaluate("document.querySelector('mobile-gs').setAttribute('up', 'down')")
    assert pose(tab) == pytest.approx(expected(tmp_path / "scene.mgs"), abs=1e-4)


def test_the_button_and_the_key_turn_one_axis_after_the_other_upwards(
    tab: Tab, served: Any, tmp_path: Path
) -> None:
    made = ply(tmp_path / "made.ply")
    visit(tab, served("scene.ply", made.read_bytes()))
    said = tab.page.get_by_role("status").first
    tab.page.keyboard.press("o")
    button = tab.page.get_by_role("button", name="Turn upright")
    for name in list(AXES)[1:]:
        button.click()
        assert pose(tab) == pytest.approx(expected(made, name), abs=1e-4)
        assert said.text_content() == f"The axis {name} points up."
    tab.page.keyboard.press("Escape")
    tab.page.locator("mobile-gs canvas").focus()
    tab.page.keyboard.press("u")
    assert said.text_content() == "The scene's own direction points up."
    assert pose(tab) == pytest.approx(expected(made), abs=1e-4)


@pytest.mark.quick
def test_the_chosen_axis_holds_for_every_view_of_one_scene(
    tab: Tab, served: Any, tmp_path: Path
) -> None:
    visit(tab, served("scene.mgs", MGS))
    own = pose(tab)
    tab.page.keyboard.press("u")
    chosen = pose(tab)
    up = chosen[6:]
    assert up != pytest.approx(own[6:], abs=0.1)
    for key in ("v", "r"):
        tab.page.keyboard.press(key)
        assert pose(tab)[6:] == up
    assert pose(tab) == pytest.approx(chosen)
    made = ply(tmp_path / "made.ply", [0, 0, 1])
    tab.page.locator("mobile-gs input[type=file]").set_input_files(str(made))
    tab.page.wait_for_function(f"{VIEWER}.pose.up[2] === 1", timeout=20_000)
    assert pose(tab) == pytest.approx(expected(made), abs=1e-4)
