"""The editor in a browser: tools, live preview, undo, save; and notes in the viewer itself."""

import json
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.edit.notes import continued_note
from mobilegs.edit.regions import Sphere
from mobilegs.mgs.codec import decode_mgs, encode_mgs, read_mgs
from mobilegs.view.edit_server import EditServer
from tests.support.browser import Tab
from tests.support.viewer_page import MGS, visit

pytestmark = pytest.mark.thorough

VIEWER = "document.querySelector('mobile-gs').viewer"
EDITOR = "document.querySelector('mobile-gs').editor"
COUNT = len(decode_mgs(MGS))
PATH = "0 0 -3 0 0 0;1.5 0 -3 0 0 0"
# a pixel under which there is a point of the scene
POINT = f"""(() => {{
  for (let x = 20; x < 680; x += 4) {{
    for (let y = 20; y < 620; y += 4) if ({VIEWER}.pointAt(x, y)) return [x, y];
  }}
}})()"""
NOTES = {
    "annotations": json.dumps([{"at": [0, 0, 0], "text": "<b>A</b>\ntree", "eye": [0.5, 0, -2]}]),
    "annotations.2": json.dumps([{"at": [0.3, 0, 0], "text": "B"}, {"at": "no"}]),
    "path": PATH,
}


@pytest.fixture
def server(tmp_path: Path) -> Iterator[EditServer]:
    path = tmp_path / "scene.mgs"
    path.write_bytes(MGS)
    with EditServer(path, None, lambda: ([], "")) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.shutdown()


def open_editor(tab: Tab, server: EditServer) -> None:
    tab.page.set_viewport_size({"width": 1000, "height": 640})
    tab.page.goto(f"{server.address('127.0.0.1')}?scale=1&variant=floats")
    tab.page.wait_for_function(f"Boolean({EDITOR})", timeout=60_000)


def saved(tab: Tab, server: EditServer) -> Path:
    before = len(server.saved)
    tab.page.get_by_role("button", name="Save as a new file").click()
    tab.page.wait_for_function(
        "document.querySelector('#edit [role=status]').textContent.startsWith('Saved as')",
        timeout=20_000,
    )
    assert len(server.saved) == before + 1
    return server.saved[-1]


def tool(tab: Tab, title: str) -> Any:
    """Open a section of the panel."""
    summary = tab.page.locator("summary").get_by_text(title, exact=True)
    section = tab.page.locator("#edit details").filter(has=summary)
    if not section.evaluate("it => it.open"):
        section.locator("summary").click()
    return section


def slide(section: Any, name: str, value: float) -> None:
    section.get_by_label(name, exact=True).evaluate(
        "(it, value) => { it.value = value; it.dispatchEvent(new Event('input')); }", value
    )


def picture(tab: Tab) -> np.ndarray:
    """Return the picture that the viewer renders now, `[48, 64, 4]`."""
    found = tab.page.evaluate(
        f"""async () => {{
          await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
          return [...(await {VIEWER}.pixels({VIEWER}.camera(64, 48)))];
        }}"""
    )
    return np.array(found).reshape(48, 64, 4)


def difference(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(a - b).mean())


@pytest.mark.quick
def test_a_sphere_hides_removes_and_is_undone(tab: Tab, server: EditServer) -> None:
    open_editor(tab, server)
    whole = picture(tab)
    section = tool(tab, "Sphere")
    slide(section, "Radius", np.log(1.5))
    preview = picture(tab)
    assert difference(preview, whole) > 0.002
    center = tab.page.evaluate(f"{VIEWER}.pose.target")
    section.get_by_role("button", name="Apply").click()
    inside = Sphere(tuple(center), 1.5).contains(decode_mgs(MGS).decode().gaussians.means)
    told = tab.page.locator("#edit .save p").first
    assert told.text_content() == f"{COUNT - int(inside.sum())} of {COUNT} Gaussians stay."
    section.locator("summary").click()  # the tool is put away, what it removed stays hidden
    assert difference(picture(tab), preview) < 1e-4
    tab.page.get_by_role("button", name="Undo").click()
    assert difference(picture(tab), whole) < 1e-4
    tab.page.get_by_role("button", name="Redo").click()
    edited = read_mgs(saved(tab, server))
    assert len(edited) == COUNT - int(inside.sum())
    kept = decode_mgs(MGS).decode().gaussians.means[~inside]
    assert edited.decode().gaussians.means.equal(kept)
    camera = tab.page.evaluate(
        f"(({{ viewmat, fx, cx, cy }}) => [...viewmat, fx, cx, cy])({VIEWER}.camera(64, 48))"
    )
    viewmat, (fx, cx, cy) = torch.tensor(camera[:16]).reshape(4, 4), camera[16:]
    k = torch.tensor([[fx, 0, cx], [0, fx, cy], [0, 0, 1]])
    rendered = edited.decode().render(Camera(viewmat, k, 64, 48, edited.near)).image.numpy()
    assert difference(preview[..., :3], rendered) < 0.2 * difference(preview, whole)


def test_box_lasso_floor_and_cameras_remove(tab: Tab, server: EditServer) -> None:
    open_editor(tab, server)
    removed = f"{EDITOR}.history.removed"
    section = tool(tab, "Crop box")
    slide(section, "Left", -0.6)
    slide(section, "Turn", 20)
    assert tab.page.locator("#marks path").get_attribute("d").count("M") >= 12
    section.get_by_role("button", name="Apply").click()
    first = tab.page.evaluate(removed)
    assert 0 < first < COUNT
    section = tool(tab, "Lasso")
    section.get_by_role("button", name="Draw a lasso").click()
    mouse = tab.page.mouse
    mouse.move(250, 200)
    mouse.down()
    for x, y in ((400, 200), (400, 400), (250, 400)):
        mouse.move(x, y)
    mouse.up()
    second = tab.page.evaluate(removed)
    assert first < second < COUNT
    section.get_by_role("button", name="Move the camera again").click()
    section = tool(tab, "Floor")
    slide(section, "Height", 0.3)
    section.get_by_role("button", name="Use as the floor").click()
    section.get_by_role("button", name="Remove what is below").click()
    third = tab.page.evaluate(removed)
    assert second < third < COUNT
    section = tool(tab, "Seen by few cameras")
    section.get_by_text("Counted: the 2 cameras of the file (2). Most photos").wait_for()
    slide(section, "Cameras", 1)
    section.get_by_role("button", name="Remove these").click()
    last = tab.page.evaluate(removed)
    assert last >= third
    edited = read_mgs(saved(tab, server))
    assert len(edited) == COUNT - last
    x, y, z, _ = map(float, str(edited.meta["floor"]).split())
    assert np.hypot(np.hypot(x, y), z) == pytest.approx(1, abs=1e-4)


def test_notes_are_set_and_saved(tab: Tab, server: EditServer) -> None:
    open_editor(tab, server)
    page = tab.page
    assert page.get_by_role("button", name="Save as a new file").is_disabled()
    section = tool(tab, "Title and credit")
    section.get_by_label("Title").fill("A garden")
    section.get_by_label("Credit").fill("me")
    page.evaluate(
        f"(() => {{ const p = Object.assign({VIEWER}.pose.copy(), {{ eye: [0.5, 0, -2], "
        f"target: [0, 0, 0] }}); {VIEWER}.place(p); }})()"
    )
    section = tool(tab, "First view")
    section.get_by_role("button", name="This view on wide screens").click()
    section.get_by_role("button", name="This view on high screens").click()
    section.get_by_label("No limits").check()
    tool(tab, "Upright").get_by_role("button", name="z", exact=True).click()
    section = tool(tab, "Annotations")
    section.get_by_role("button", name="Add: click a point").click()
    page.mouse.click(*page.evaluate(POINT))
    section.locator("textarea").fill("A tree\nhere")
    section.locator("summary").focus()
    assert page.locator("mobile-gs .annotations button").count() == 1
    section = tool(tab, "Camera path")
    section.get_by_role("button", name="Add this view").click()
    page.evaluate(f"{VIEWER}.pose.orbit(0.3, 0)")
    section.get_by_role("button", name="Add this view").click()
    notes = read_mgs(saved(tab, server)).meta
    assert (notes["title"], notes["credit"], notes["limits"]) == ("A garden", "me", "none")
    assert notes["up"] == "0.000000 0.000000 1.000000"
    start = [float(word) for word in str(notes["start"]).split()]
    assert start[:6] == pytest.approx([0.5, 0, -2, 0, 0, 0], abs=1e-5)
    portrait = [float(word) for word in str(notes["start_portrait"]).split()]
    assert portrait[6] == portrait[7] == pytest.approx(min(start[6:]))
    (annotation,) = json.loads(continued_note(notes, "annotations")[0])
    assert annotation["text"] == "A tree\nhere" and len(annotation["at"]) == 3
    assert str(notes["path"]).count(";") == 1
    assert server.edited.read_bytes() == MGS


def noted(notes: dict[str, Any]) -> bytes:
    scene = decode_mgs(MGS)
    return encode_mgs(replace(scene, meta=scene.meta | notes))


def test_the_viewer_shows_annotations(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", noted(NOTES)))
    dots = tab.page.locator("mobile-gs .annotations button")
    dots.first.wait_for()
    assert dots.all_text_contents() == ["1", "2"]
    dots.first.click()
    bubble = tab.page.locator("mobile-gs .annotations p")
    assert bubble.text_content() == "<b>A</b>\ntree"
    tab.page.wait_for_function(
        f"Math.hypot({VIEWER}.pose.eye[0] - 0.5, {VIEWER}.pose.eye[2] + 2) < 1e-3", timeout=20_000
    )
    assert dots.first.get_attribute("aria-expanded") == "true"
    dots.first.click()
    assert bubble.is_hidden()
    # attributes replace those of the file
    change = "(text) => document.querySelector('mobile-gs').setAttribute('annotations', text)"
    tab.page.evaluate(change, '[{"at": [0, 0, 0], "text": "C"}]')
    tab.page.locator("mobile-gs .annotations button[aria-label='1: C']").wait_for()
    assert dots.count() == 1
    tab.page.evaluate(change, "[]")
    dots.first.wait_for(state="detached")


def test_the_viewer_follows_a_path_until_the_first_input(tab: Tab, served: Any) -> None:
    server = served("scene.mgs", noted({"path": PATH}))
    visit(tab, server)
    assert tab.page.evaluate(f"{VIEWER}.pose.eye[2]") != -3
    visit(tab, server, "autoplay=")
    moving = f"Math.abs({VIEWER}.pose.eye[2] + 3) < 1e-6 && {VIEWER}.pose.eye[0] > 0.05"
    tab.page.wait_for_function(moving, timeout=20_000)
    tab.page.locator("mobile-gs canvas").click()
    at = tab.page.evaluate(f"{VIEWER}.pose.eye")
    tab.page.wait_for_timeout(200)
    assert tab.page.evaluate(f"{VIEWER}.pose.eye") == at


def test_flights_pass_through_their_keys(tab: Tab) -> None:
    found = tab.run(
        """const { poseAt, parsedPath } = await import("/src/viewer/camera_path.js");
        const keys = parsedPath({ path: "0 0 0 0 0 1;1 0 0 1 0 1", "path.2": "2 1 0 0 0 5" });
        const broken = ["1 2", "0 0 0 0 0 0", "a b c d e f", 3].map((path) => parsedPath({ path }));
        const at = [0, 1, 2, 0.5].map((t) => poseAt(keys, t).eye);
        return { count: keys.length, at, broken };"""
    )
    assert found["count"] == 3 and found["broken"] == [[], [], [], []]
    assert found["at"][:3] == [[0, 0, 0], [1, 0, 0], [2, 1, 0]]
    assert 0.3 < found["at"][3][0] < 0.7
