"""The interface over the picture: title, hint, icon bar, dialogs, languages and layouts."""

import itertools
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Route

from mobilegs.mgs.codec import decode_mgs, encode_mgs
from tests.support.browser import Chromium, Tab
from tests.support.viewer_page import MGS, frames, screen, until, visit

pytestmark = pytest.mark.thorough

ROOT = "document.querySelector('mobile-gs').shadowRoot"
TITLED = ("heading=A garden", "credit=Photos: Ada")
TOOLS = ["Back to the first view", "Share", "Settings", "Help", "Full screen"]
DIALOGS = ["settings", "help", "share"]
SIZES = [
    (390, 844),
    (195, 422),
    (844, 390),
    (720, 450),
    (1440, 900),
]  # two are others at 200 % zoom
# the accessible name of what has the focus
FOCUSED = f"""() => {{
  const focused = {ROOT}.activeElement;
  const label = focused?.labels?.[0]?.textContent;
  return focused?.getAttribute("aria-label") ?? label ?? focused?.textContent;
}}"""
# the least contrast of each visible text with what is behind it, over black and over white pictures
CONTRASTS = f"""() => {{
  const parsed = (text) => {{
    const [r, g, b, a = 1] = text.match(/[\\d.]+/g).map(Number);
    return {{ color: [r, g, b], a }};
  }};
  const over = (top, under) => top.color.map((value, i) => value * top.a + under[i] * (1 - top.a));
  const light = (color) => {{
    const [r, g, b] = color.map((value) => value / 255)
      .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  }};
  const found = {{}};
  for (const part of {ROOT}.querySelectorAll("*")) {{
    const texts = [...part.childNodes].filter((node) => node.nodeType === 3 && node.data.trim());
    if (!texts.length && !part.matches("svg, input, select")) continue;
    if (!part.checkVisibility({{ opacityProperty: true }})) continue;
    if (part.closest(".code, [type=color]")) continue;
    const layers = [];
    for (let at = part; at; at = at.parentElement) {{
      layers.unshift(parsed(getComputedStyle(at).backgroundColor));
    }}
    const ratios = [[0, 0, 0], [255, 255, 255]].map((picture) => {{
      const back = layers.reduce((under, layer) => over(layer, under), picture);
      const [a, b] = [light(over(parsed(getComputedStyle(part).color), back)), light(back)];
      return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    }});
    found[`${{part.className}} ${{part.textContent.trim().slice(0, 30)}}`] = Math.min(...ratios);
  }}
  return found;
}}"""
# visible parts that reach over an edge of the page, and how far one can scroll sideways
OVERFLOWS = f"""() => [
  document.documentElement.scrollWidth - innerWidth,
  ...[...{ROOT}.querySelectorAll(".panel, .panel :is(button, select, label, dd, .body)")]
    .filter((part) => part.checkVisibility())
    .filter((part) => {{
      const {{ left, right }} = part.getBoundingClientRect();
      return left < -0.5 || right > innerWidth + 0.5 || part.scrollWidth > part.clientWidth + 1;
    }})
    .map((part) => `${{part.className}} ${{part.textContent.slice(0, 30)}}`),
]"""


# the hint stays, however long the machine takes to look at it
NO_LONG_TIMERS = """{
  const { setTimeout } = window;
  window.setTimeout = (act, time, ...given) => time > 5000 ? 0 : setTimeout(act, time, ...given);
}"""
# the bar fades after half a second of rest
FAST_TIMERS = """{
  const { setTimeout } = window;
  window.setTimeout = (act, time, ...given) =>
    setTimeout(act, time === 4000 ? 500 : time, ...given);
}"""
# the bar of a phone stays, as under a finger that moves
AWAKE = """setInterval(
  () => document.querySelector("mobile-gs").dispatchEvent(new PointerEvent("pointermove")), 500
)"""


def tool(tab: Tab, act: str) -> Any:
    """Return a button of the icon bar."""
    return tab.page.locator(f"mobile-gs .buttons [data-act={act}]")


def open_dialog(tab: Tab, act: str) -> Any:
    """Open a dialog by its button, and return it when it has arrived."""
    tool(tab, act).click()
    dialog = tab.page.locator(f"mobile-gs .sheet.{act}")
    dialog.wait_for()
    dialog.evaluate("(part) => Promise.all(part.getAnimations().map((one) => one.finished))")
    return dialog


def right_of(tab: Tab, part: str) -> bool:
    """Return True if a part lies in the right half of the page."""
    box = tab.page.locator(f"mobile-gs {part}").bounding_box()
    return box["x"] + box["width"] / 2 > tab.page.viewport_size["width"] / 2


def test_all_text_has_contrast_on_any_picture(tab: Tab, served: Any) -> None:
    found = {}

    def read() -> None:
        for scheme in ("light", "dark"):
            tab.page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
            parts = tab.page.evaluate(CONTRASTS)
            found.update({f"{scheme}: {part}": ratio for part, ratio in parts.items()})

    tab.page.emulate_media(reduced_motion="reduce")
    tab.page.add_init_script(NO_LONG_TIMERS)
    visit(tab, served("scene.mgs", MGS), *TITLED)
    tab.page.wait_for_function(  # it comes after the scene
        f"() => {ROOT}.querySelector('.hint').checkVisibility({{ opacityProperty: true }})"
    )
    read()
    for act in DIALOGS:
        open_dialog(tab, act)
        read()
    tab.page.evaluate("document.querySelector('mobile-gs').failed(0, 'a sentence')")
    read()
    assert all(
        any(text in part for part in found) for text in ("A garden", "Drag to", "a sentence")
    )
    print(sorted((round(ratio, 1), part) for part, ratio in found.items())[:5])
    assert len(found) > 80 and not {part: r for part, r in found.items() if r < 4.5}
    # dialogs follow the scheme
    panel = tab.page.locator("mobile-gs .sheet.settings")
    for scheme, light in (("light", True), ("dark", False)):
        tab.page.emulate_media(color_scheme=scheme)
        paper = panel.evaluate("(part) => getComputedStyle(part).backgroundColor")
        assert (float(re.findall(r"\d+", paper)[0]) > 128) == light


def test_every_control_has_a_name_in_each_language(chromium: Chromium, served: Any) -> None:
    tab = chromium.tab(locale="fr-FR")  # which gets English
    visit(tab, served("scene.mgs", MGS))
    names = {"fr": "Settings", "de": "Einstellungen", "zh": "设置", "es": "Ajustes", "ja": "設定"}
    for language, name in names.items():
        if language != "fr":
            tab.page.evaluate(f"document.querySelector('mobile-gs').lang = '{language}'")
        tab.page.wait_for_function(
            f"{ROOT}.querySelector('[data-act=settings]').ariaLabel === '{name}'"
        )
        nameless = tab.page.evaluate(
            f"""() => [...{ROOT}.querySelectorAll(
                "button, select, input:not([type=file]), textarea, [tabindex='0'], [role=dialog]")]
              .filter((part) => !part.matches(".split")) // names its scenes when there are two
              .filter((part) => !part.getAttribute("aria-label") && !part.labels?.[0]?.textContent)
              .filter((part) => !part.textContent.trim())
              .map((part) => part.outerHTML.slice(0, 80))"""
        )
        assert nameless == [], language
    tab.close()


def test_the_language_is_that_of_the_page_or_of_the_visitor(
    chromium: Chromium, served: Any
) -> None:
    tab = chromium.tab(locale="de-AT")
    visit(tab, served("scene.mgs", MGS))
    help_ = f"{ROOT}.querySelector('[data-act=help]').ariaLabel"
    for page, name in (("", "Hilfe"), ("ja", "ヘルプ"), ("fr", "Hilfe")):
        tab.page.evaluate(
            """(language) => {
              document.documentElement.lang = language;
              const other = document.createElement("mobile-gs");
              document.querySelector("mobile-gs").replaceWith(other);
            }""",
            page,
        )
        tab.page.wait_for_function(f"{help_} === '{name}'", timeout=10_000)
    tab.page.evaluate("document.querySelector('mobile-gs').setAttribute('lang', 'zh-Hant-TW')")
    tab.page.wait_for_function(f"{help_} === '帮助'", timeout=10_000)
    tab.close()


def test_a_missing_language_is_replaced_by_english(tab: Tab, served: Any) -> None:
    tab.page.route("**/languages.js?*", lambda route: route.fulfill(status=404))
    visit(tab, served("scene.mgs", MGS), "lang=de")
    assert tool(tab, "help").get_attribute("aria-label") == "Help"
    tab.ignore("status of 404")


@pytest.mark.quick
def test_tab_goes_from_the_scene_to_the_bar_and_into_a_dialog(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS), *TITLED)
    names = []
    for _ in TOOLS:
        tab.page.keyboard.press("Tab")
        names.append(tab.page.evaluate(FOCUSED))
    assert names == TOOLS
    tab.page.keyboard.press("Shift+Tab")  # to Help
    tab.page.keyboard.press("Shift+Tab")
    tab.page.keyboard.press("Enter")
    assert tab.page.evaluate(FOCUSED) == "Settings"
    tab.page.keyboard.press("Tab")
    assert tab.page.evaluate(FOCUSED) == "Close"
    tab.page.keyboard.press("Tab")
    assert tab.page.evaluate(FOCUSED) == "Dragging"


def test_a_dialog_closes_and_gives_the_focus_back(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    for act, way in zip(DIALOGS, ("Escape", "Enter", "Escape"), strict=True):
        button = tool(tab, act)
        button.focus()
        tab.page.keyboard.press("Enter")
        dialog = tab.page.locator(f"mobile-gs .sheet.{act}")
        dialog.wait_for()
        assert button.get_attribute("aria-expanded") == "true"
        if act == "help":
            shown = [one.inner_text() for one in dialog.locator("h3").all() if one.is_visible()]
            assert shown == ["Mouse", "Keys"]
        if way == "Enter":
            dialog.get_by_role("button", name="Close").focus()
        tab.page.keyboard.press(way)
        dialog.wait_for(state="hidden")
        assert button.get_attribute("aria-expanded") == "false"
        assert tab.page.evaluate(FOCUSED) == button.get_attribute("aria-label")
    # so do the keys, from the scene and back to it
    tab.page.locator("mobile-gs canvas").focus()
    for key, act in (("o", "settings"), ("h", "help")):
        dialog = tab.page.locator(f"mobile-gs .sheet.{act}")
        tab.page.keyboard.press(key)
        dialog.wait_for()
        tab.page.keyboard.press(key)
        dialog.wait_for(state="hidden")
        assert tab.page.evaluate(FOCUSED).startswith("3D scene")


def test_the_hint_goes_away_and_comes_once_per_scene(tab: Tab, served: Any) -> None:
    visit(tab, served("scene.mgs", MGS))
    hint = tab.page.locator("mobile-gs .hint")
    hint.wait_for()
    tab.page.mouse.click(300, 150)
    assert hint.is_hidden()
    opened = """(source) => new Promise((done) => {
      const element = document.querySelector("mobile-gs");
      element.addEventListener("load", done, { once: true });
      element.open(source);
    })"""
    tab.page.evaluate(opened, "/scene")
    frames(tab, 10)
    assert hint.is_hidden()
    tab.page.evaluate(opened, "/scene?other")
    hint.wait_for()
    hint.wait_for(state="hidden", timeout=15_000)  # by itself


def test_the_bar_fades_and_comes_back(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(FAST_TIMERS)
    visit(tab, served("scene.mgs", MGS), *TITLED)
    idle = f"{ROOT}.querySelector('.idle') !== null"

    def opacity(part: str) -> float:
        shown = tab.page.locator(f"mobile-gs .{part}")
        return float(shown.evaluate("(part) => getComputedStyle(part).opacity"))

    until(tab, lambda: opacity("buttons") == opacity("title") == 0)

    def awake() -> bool:
        tab.page.mouse.move(*np.random.default_rng().uniform(100, 300, 2))
        return opacity("buttons") == opacity("title") == 1

    until(tab, awake)
    until(tab, lambda: opacity("buttons") == 0)
    tab.page.keyboard.press("Tab")  # to a button, which stays visible
    until(tab, lambda: opacity("buttons") == 1)
    tab.page.wait_for_function(idle)
    tab.page.wait_for_timeout(700)  # longer than the transition
    assert opacity("buttons") == 1
    tab.page.keyboard.press("o")  # so does the bar while a dialog is open
    tab.page.mouse.click(60, 200)
    tab.page.wait_for_function(idle)
    tab.page.wait_for_timeout(700)
    assert opacity("buttons") == 1


def test_nothing_is_wider_than_the_page(tab: Tab, served: Any, subtests: pytest.Subtests) -> None:
    tab.page.emulate_media(reduced_motion="reduce")
    visit(tab, served("scene.mgs", MGS), *TITLED, "scale=0.1", "lang=de")  # long words
    for width, height in SIZES:
        with subtests.test(width=width, height=height):
            tab.page.set_viewport_size({"width": width, "height": height})
            assert tab.page.evaluate(OVERFLOWS) == [0]
            for act in DIALOGS:
                dialog = open_dialog(tab, act)
                assert tab.page.evaluate(OVERFLOWS) == [0], act
                box = dialog.bounding_box()
                assert box["y"] >= 0 and box["y"] + box["height"] <= height + 0.5
                assert (box["width"] == width) == (width < 640)  # at the bottom of phones
                tab.page.keyboard.press("Escape")
            failed = "document.querySelector('mobile-gs').failed(0, 'a sentence '.repeat(9))"
            tab.page.evaluate(failed)
            assert tab.page.evaluate(OVERFLOWS) == [0]
            tab.page.keyboard.press("Escape")


def test_the_layout_follows_the_direction_of_the_page(tab: Tab, served: Any) -> None:
    tab.page.set_viewport_size({"width": 900, "height": 500})
    visit(tab, served("scene.mgs", MGS), *TITLED, "scale=0.1")
    tab.page.keyboard.press("i")
    places = {}
    for direction in ("ltr", "rtl"):
        tab.page.evaluate(f"document.documentElement.dir = '{direction}'")
        open_dialog(tab, "settings")
        places[direction] = [
            right_of(tab, part) for part in (".title", ".stats", ".sheet.settings")
        ]
        assert tab.page.evaluate(OVERFLOWS) == [0]
        tab.page.keyboard.press("Escape")
    assert places == {"ltr": [False, True, True], "rtl": [True, False, False]}


def test_share_falls_back_to_a_link_that_can_be_copied(chromium: Chromium, served: Any) -> None:
    tab = chromium.tab(has_touch=True, is_mobile=True)
    tab.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    visit(tab, served("scene.mgs", MGS), "scale=0.1")
    tab.page.evaluate(AWAKE)
    dialog = tab.page.get_by_role("dialog", name="Share")
    # the device's own menu is missing, is refused, and works
    for answer in (None, "Promise.reject(new Error())", "null"):
        if answer:
            share = f"({{ url }}) => {{ window.shared = url; return {answer}; }}"
            tab.page.evaluate(f"navigator.share = {share}; null")
        tool(tab, "share").click()
        if answer == "null":
            tab.page.wait_for_function("window.shared === location.href")
            assert dialog.is_hidden()
            continue
        dialog.wait_for()
        link = dialog.get_by_label("Link to this view").input_value()
        assert link == tab.page.url
        dialog.get_by_role("button", name="Copy").click()
        dialog.get_by_text("Copied.").wait_for()
        assert tab.page.evaluate("navigator.clipboard.readText()") == link
        dialog.get_by_text("This address works on this device only.").wait_for()
        assert dialog.get_by_role("img", name="QR code of the link").is_hidden()
        assert dialog.get_by_role("button", name="Send").is_visible() == bool(answer)
        tab.page.keyboard.press("Escape")
        tab.page.evaluate("window.shared = null")
    headings = open_dialog(tab, "help").locator("h3")
    assert [one.inner_text() for one in headings.all() if one.is_visible()] == ["Touch"]
    tab.page.keyboard.press("Escape")
    tab.page.keyboard.press("h")  # a keyboard after all
    assert headings.filter(has_text="Keys").is_visible()
    tab.close()


def test_an_address_for_other_devices_has_a_qr_code(tab: Tab, served: Any) -> None:
    server = served("scene.mgs", MGS)
    own, public = server.address("127.0.0.1"), "http://garden.example"

    def answer(route: Route) -> None:
        path = route.request.url.removeprefix(public)
        route.fulfill(response=route.fetch(url=own.partition("/?")[0] + path))

    tab.page.route(f"{public}/**", answer)
    tab.page.goto(f"{public}/?url=/scene&scale=0.1#eye=0,0,-2&at=0,0,0&up=0,-1,0")
    tab.page.wait_for_selector("mobile-gs[data-state=loaded]", timeout=60_000)
    dialog = open_dialog(tab, "share")
    dialog.get_by_role("img", name="QR code of the link").wait_for()
    size = dialog.locator(".code svg").get_attribute("viewBox")
    assert size == "0 0 41 41"  # version 4, and four modules around it
    dialog.get_by_role("button", name="Copy").click()  # there is no clipboard API over plain http
    dialog.get_by_text("Copied.").wait_for()


@pytest.mark.quick
def test_qr_codes_are_those_of_another_encoder(tab: Tab) -> None:
    import segno

    # texts that fill a code: segno pads others by a byte that the standard does not ask for
    full = [17, 32, 53, 78, 106, 134, 154, 192, 230, 271, 321, 367, 425, 458, 520, 586, 644, 718]
    full += [792, 858]
    texts = [("https://a.example/" + "x/3" * 300)[:length] for length in full]
    cases = [(text, mask) for text, mask in zip(texts, itertools.cycle(range(8)), strict=False)]
    found = tab.run(
        """const { qrCode } = await import("/src/viewer/qr.js");
        return [cases.map(([text, mask]) => qrCode(text, mask)), qrCode("x".repeat(859))];""",
        cases=cases,
    )
    assert found[1] is None
    for (text, mask), modules in zip(cases, found[0], strict=True):
        code = segno.make_qr(text, error="l", mask=mask, boost_error=False, mode="byte")
        assert [[bool(dark) for dark in row] for row in code.matrix] == modules, (len(text), mask)


@pytest.mark.parametrize("state", ["parsing", "running"])
def test_the_page_is_dark_from_the_first_paint(tab: Tab, served: Any, state: str) -> None:
    tab.page.emulate_media(color_scheme="light")
    server = served("scene.mgs", MGS)
    if state == "parsing":
        tab.page.route("**/viewer.js?*", lambda route: route.fulfill(body="", status=404))
        tab.ignore("status of 404")
    server.scenes["/scene"].unlink()
    tab.ignore("status of 404")
    tab.page.goto(f"{server.address('127.0.0.1')}&noui")
    frames(tab, 3)
    if state == "running":
        tab.page.get_by_role("alert").wait_for()
        tab.page.keyboard.press("Escape")
    assert screen(tab).max() < 40


def test_title_and_credit_come_from_the_file_or_the_attributes(tab: Tab, served: Any) -> None:
    meta = {"title": "A <b>pond</b>", "credit": "Ada, \u202eCC BY 4.0"}
    meta["annotations"] = '[{"at": [0, 0, 0], "text": "fish \u202e"}]'
    noted = replace(decode_mgs(MGS), meta=meta)
    visit(tab, served("scene.mgs", encode_mgs(noted)))
    title = tab.page.locator("mobile-gs .title")
    assert title.inner_text().split("\n") == ["A <b>pond</b>", r"Ada, \u202eCC BY 4.0"]
    tab.page.locator(r"""mobile-gs .annotations [aria-label="1: fish \\u202e"]""").wait_for(
        state="attached"
    )
    tab.page.evaluate("document.querySelector('mobile-gs').setAttribute('heading', 'Mine')")
    frames(tab, 3)
    assert title.inner_text().split("\n") == ["Mine", r"Ada, \u202eCC BY 4.0"]


def test_a_missing_part_of_the_viewer_shows_an_error(tab: Tab, served: Any) -> None:
    tab.page.route("**/webgl.js?*", lambda route: route.fulfill(status=404))
    assert "own files could not be loaded" in visit(tab, served("scene.mgs", MGS), "renderer=webgl")
    tab.ignore("status of 404")


def test_a_failed_scene_can_be_tried_again(tab: Tab, served: Any) -> None:
    answers = [404]

    def answer(route: Any) -> None:
        if answers:
            route.fulfill(status=answers.pop())
        else:
            route.continue_()

    server = served("scene.mgs", MGS)
    tab.page.route("**/scene", answer)
    assert "could not be loaded: the server says 404" in visit(tab, server)
    tab.page.get_by_role("button", name="Try again").click()
    tab.page.wait_for_selector("mobile-gs[data-state=loaded]", timeout=20_000)
    assert tab.page.get_by_role("alert").is_hidden()
    tab.ignore("status of 404")
