"""preload.js: work that a page starts before the viewer's script has arrived."""

import re
from typing import Any

import pytest

from tests.support.browser import Tab
from tests.support.viewer_page import COUNT_WORKERS, MGS, SETTLED, visit

pytestmark = pytest.mark.thorough

LOADED = "document.querySelector('mobile-gs').dataset.state === 'loaded'"


@pytest.mark.quick
def test_the_preloaded_worker_loads_the_scene_once(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(COUNT_WORKERS)
    asked: list[str] = []
    tab.page.on("request", lambda request: asked.append(request.url))
    server = served("scene.mgs", MGS)
    assert visit(tab, server, "renderer=webgpu") == "loaded"
    scene = f"http://127.0.0.1:{server.server_port}/scene"
    assert tab.page.evaluate("begun") == [scene]
    assert asked.count(scene) == 1
    assert tab.page.evaluate("adapters") == 1
    # a scene that is opened later has a thread of its own
    tab.page.evaluate("document.querySelector('mobile-gs').open('/scene?again')")
    tab.page.wait_for_function("begun.length === 2")
    tab.page.wait_for_function(SETTLED)
    assert tab.page.evaluate("begun") == [scene, f"{scene}?again"]


def test_early_messages_of_the_preloaded_worker_are_kept(tab: Tab, served: Any) -> None:
    server = served("scene.mgs", MGS)
    # the viewer's script comes late
    held: list[Any] = []
    tab.page.route("**/viewer.js*", lambda route: held.append(route))
    tab.page.goto(server.address("127.0.0.1"), wait_until="commit")
    tab.page.wait_for_function(
        "window.preloadedWorker?.messages.some(({ data }) => data.kind === 'done')", timeout=20_000
    )
    held[0].continue_()
    tab.page.wait_for_function(LOADED, timeout=60_000)
    assert tab.page.evaluate("document.querySelector('mobile-gs').viewer.count") == 800


def test_a_browser_without_workers_shows_an_error(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(
        "window.Worker = class { constructor() { throw new Error('none'); } };"
    )
    visit(tab, served("scene.mgs", MGS))
    alert = tab.page.get_by_role("alert")
    alert.filter(has_text="own files could not be loaded").wait_for(timeout=20_000)


def test_the_viewer_starts_a_worker_if_a_policy_forbids_preloading(tab: Tab, served: Any) -> None:
    """The policy forbids scripts in the page itself."""

    def strict(route: Any) -> None:
        answer = route.fetch()
        policy = {"Content-Security-Policy": "script-src 'self' 'wasm-unsafe-eval' blob:"}
        route.fulfill(response=answer, headers={**answer.headers, **policy})

    tab.page.route(re.compile(r"/\?url="), strict)
    tab.page.goto(f"{served('scene.mgs', MGS).address('127.0.0.1')}&scale=1")
    tab.page.locator("mobile-gs[data-state=loaded]").wait_for(timeout=60_000)
    assert tab.complaints and all("Content Security Policy" in text for text in tab.complaints)
    tab.complaints.clear()


def test_a_preloaded_worker_that_fails_is_replaced(tab: Tab, served: Any) -> None:
    tab.page.add_init_script(
        """{
          const Own = Worker;
          let failed = false;
          window.Worker = class extends Own {
            constructor(address, options) {
              super(failed ? address : "/missing.js", options);
              failed = true;
            }
          };
        }"""
    )
    assert visit(tab, served("scene.mgs", MGS)) == "loaded"
    tab.ignore("status of 404")
