"""Scripts of a page: camera events, flights, HTML that follows points, elements in step."""

from typing import Any

import numpy as np
import pytest

from tests.support.browser import Tab
from tests.support.viewer_page import MGS, frames

pytestmark = pytest.mark.thorough

FIRST = "eye=1,2,-3&at=0,0.5,0&up=0,-1,0"
THIRD = FIRST.replace("eye=1", "eye=3")
OTHER = "eye=2,1,-4&at=0.5,0,0&up=0,-1,0"
LOADED = """() => [...document.querySelectorAll("mobile-gs")].every(
  ({ viewer, dataset }) => viewer?.count && dataset.state === "loaded")"""
# records the details of all events `camera`
RECORD = """() => {
  window.moves = [];
  document.addEventListener("camera", ({ target, detail: { origin, ...rest } }) =>
    moves.push({ ...rest, id: target.id, origin: origin.id }));
}"""


def show(tab: Tab, html: str) -> None:
    """Show a page with elements, and wait until all have loaded their scene."""
    tab.share("scene.mgs", MGS)
    tab.page.evaluate(RECORD)
    tab.page.evaluate(
        """async (html) => {
          await import("/src/element.js");
          document.body.innerHTML = html;
        }""",
        html,
    )
    tab.page.wait_for_function(LOADED, timeout=60_000)
    frames(tab, 5)


def element(id: str, more: str = "", inside: str = "") -> str:
    style = "display: block; width: 300px; height: 190px"
    words = f'id="{id}" renderer="webgl" variant="floats" noui style="{style}" {more}'
    return f'<mobile-gs src="/arrays/scene.mgs" {words}>{inside}</mobile-gs>'


def camera(tab: Tab, id: str) -> str:
    return tab.page.evaluate("(id) => document.getElementById(id).camera", id)


def place(tab: Tab, id: str, text: str) -> None:
    tab.page.evaluate("([id, text]) => (document.getElementById(id).camera = text)", [id, text])


def moves(tab: Tab) -> list[dict[str, Any]]:
    """Return the recorded events, and forget them."""
    return tab.page.evaluate("moves.splice(0)")


@pytest.mark.quick
def test_the_camera_is_an_attribute_a_property_and_an_event(tab: Tab) -> None:
    show(tab, element("a", f'camera="{FIRST.replace("&", "&amp;")}"'))
    moves(tab)
    place(tab, "a", OTHER)
    frames(tab, 5)
    tab.page.evaluate("document.getElementById('a').viewer.redraw()")
    frames(tab, 5)
    assert moves(tab) == [
        {"camera": OTHER, "eye": [2, 1, -4], "target": [0.5, 0, 0], "up": [0, -1, 0]}
        | {"id": "a", "origin": "a"}
    ]
    place(tab, "a", "nonsense")
    assert camera(tab, "a") == OTHER
    tab.page.evaluate("(text) => document.getElementById('a').setAttribute('camera', text)", THIRD)
    assert camera(tab, "a") == THIRD
    moves(tab)
    tab.page.evaluate("document.getElementById('a').setAttribute('autorotate', '')")
    # a flight arrives
    fly = "(to) => document.getElementById('a').flyTo(to, { seconds: 0.3 })"
    assert tab.page.evaluate(fly, OTHER) is True
    assert camera(tab, "a") == OTHER
    tilted = {"eye": [0, 0, -4], "target": [0, 0, 0], "up": [1, -1, 0]}
    assert tab.page.evaluate(fly, tilted) is True
    assert camera(tab, "a") == "eye=0,0,-4&at=0,0,0&up=0.70711,-0.70711,0"
    assert len(moves(tab)) > 3
    message = tab.page.evaluate(
        "document.getElementById('a').flyTo('north').catch(({ message }) => message)"
    )
    assert message == '"north" is not a camera: write eye=x,y,z&at=x,y,z&up=x,y,z'


def test_a_flight_stops(tab: Tab) -> None:
    show(tab, element("a", f'camera="{FIRST.replace("&", "&amp;")}"'))
    for what in ("input", "signal", "flight"):
        place(tab, "a", FIRST)
        arrived = tab.page.evaluate(
            """async ([to, first, what]) => {
              const one = document.getElementById("a");
              const over = new AbortController();
              const flight = one.flyTo(to, { seconds: 60, signal: over.signal });
              while (one.camera === first) await new Promise(requestAnimationFrame);
              if (what === "input") one.dispatchEvent(new PointerEvent("pointerdown"));
              else if (what === "signal") over.abort();
              else await one.flyTo(first, { seconds: 0 });
              return flight;
            }""",
            [OTHER, FIRST, what],
        )
        assert arrived is False
        stopped = camera(tab, "a")
        assert stopped != OTHER
        frames(tab, 5)
        assert camera(tab, "a") == stopped


def test_slotted_html_follows_its_point(tab: Tab) -> None:
    note = '<b slot="annotation" data-at="{}" style="width: 20px; height: 10px">{}</b>'
    points = {"inside": [0.1, 0.2, 0], "right": [40, 0.5, 0], "behind": [2, 4, -6]}
    texts = {name: " ".join(map(str, at)) for name, at in points.items()}
    notes = "".join(note.format(at, name) for name, at in texts.items())
    show(tab, element("a", f'camera="{FIRST.replace("&", "&amp;")}"', notes))
    tab.page.wait_for_function("document.querySelector('b').style.cssText.includes('--annotation')")
    read = """() => {
      const one = document.getElementById("a");
      const box = one.getBoundingClientRect();
      const camera = one.viewer.camera(box.width, box.height);
      const notes = [...one.children].map((note) => {
        const { x, y, width, height } = note.getBoundingClientRect();
        const { visibility } = getComputedStyle(note);
        return [note.textContent, x - box.x + width / 2, y - box.y + height / 2, visibility];
      });
      return { camera, notes };
    }"""
    for text in (FIRST, OTHER):
        place(tab, "a", text)
        frames(tab, 5)
        found = tab.page.evaluate(read)
        seen = found["camera"]
        matrix = np.array(seen["viewmat"]).reshape(4, 4)
        places = {name: (x, y, visibility) for name, x, y, visibility in found["notes"]}
        x, y, z = (matrix @ [*points["inside"], 1])[:3]
        expected = seen["fx"] * x / z + seen["cx"], seen["fy"] * y / z + seen["cy"]
        assert np.allclose(places["inside"][:2], expected, atol=0.5)
        assert places["inside"][2] == "visible"
        # at the picture's edge, and hidden
        right, top = places["right"][:2]
        assert right == pytest.approx(300, abs=0.5) and 0 <= top <= 190
        assert [places[name][2] for name in ("right", "behind")] == ["hidden", "hidden"]
    # a style of the page dims instead
    tab.page.add_style_tag(content="[data-outside] { visibility: visible; opacity: 0.3 }")
    assert {note[3] for note in tab.page.evaluate(read)["notes"]} == {"visible"}


def test_slotted_html_without_a_point_is_hidden_and_reported_once(tab: Tab) -> None:
    tab.ignore("is not a point")
    said: list[str] = []
    tab.page.on("console", lambda message: said.append(message.text))
    show(tab, element("a", inside='<b slot="annotation" data-at="1 2">x</b>'))
    tab.page.wait_for_function("document.querySelector('b').hasAttribute('data-outside')")
    tab.page.evaluate("document.getElementById('a').viewer.redraw()")
    frames(tab, 5)
    expected = 'mobile-gs: data-at="1 2" of an annotation is not a point: write three numbers, as '
    assert [text for text in said if "annotation" in text] == [expected + '"0 1.5 -2"']
    # it appears once it has a point in the picture
    tab.page.evaluate(
        """() => {
          const { eye, target } = document.getElementById("a").viewer.pose;
          document.querySelector("b").dataset.at = target.join(" ");
        }"""
    )
    tab.page.wait_for_function("!document.querySelector('b').hasAttribute('data-outside')")


def test_elements_in_step(tab: Tab) -> None:
    # each of the first two follows the other; the third follows one that follows
    show(
        tab,
        element("a", 'follow="b"') + element("b", 'follow="a"') + element("c", 'follow="b"'),
    )
    for id, text in (("a", FIRST), ("b", OTHER)):
        moves(tab)
        place(tab, id, text)
        tab.page.wait_for_function(
            """(text) => [...document.querySelectorAll("mobile-gs")].every(
              ({ camera }) => camera === text)""",
            arg=text,
        )
        frames(tab, 10)
        found = moves(tab)
        assert sorted(one["id"] for one in found) == ["a", "b", "c"]  # once each: no echo
        assert {one["origin"] for one in found} == {id}
    # a pose set by a script before the leader's is drawn
    tab.page.evaluate(
        """([first, own]) => {
          const [a, b] = ["a", "b"].map((id) => document.getElementById(id));
          document.addEventListener("camera", () => (b.camera = own), { once: true });
          a.camera = first;
        }""",
        [FIRST, THIRD],
    )
    frames(tab, 10)
    assert [camera(tab, id) for id in "abc"] == [THIRD] * 3
    tab.page.evaluate("document.getElementById('c').removeAttribute('follow')")
    place(tab, "a", FIRST)
    frames(tab, 10)
    assert [camera(tab, id) for id in "abc"] == [FIRST, FIRST, THIRD]


def test_elements_that_are_added_later(tab: Tab) -> None:
    show(tab, element("a", f'camera="{FIRST.replace("&", "&amp;")}"'))
    tab.page.evaluate(
        """([html, text]) => {
          document.body.insertAdjacentHTML("beforeend", html); // follows one that is there
          const one = document.getElementById("a").cloneNode();
          one.id = "c";
          one.camera = text; // before it has a viewer
          document.body.append(one);
        }""",
        [element("b", 'follow="a"'), OTHER],
    )
    tab.page.wait_for_function(LOADED, timeout=60_000)
    frames(tab, 5)
    assert [camera(tab, id) for id in "abc"] == [FIRST, FIRST, OTHER]


def test_the_point_under_a_pixel(tab: Tab) -> None:
    show(tab, element("a"))
    found = tab.page.evaluate(
        """() => {
          const one = document.getElementById("a");
          return [one.pointAt(150, 95), one.viewer.camera(300, 190).viewmat];
        }"""
    )
    x, y, z, _ = np.array(found[1]).reshape(4, 4) @ [*found[0], 1]
    assert z > 0 and abs(x) < 0.1 * z and abs(y) < 0.1 * z
