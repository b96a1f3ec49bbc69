"""Take screenshots of the viewer's page in all its states, at the sizes of four devices.

    python -m bench.screens SCENE.mgs --output FOLDER [--only phone] [--scale 0.3] [--language de]

Somebody has to look at them: tests check names, contrast, focus and overflow, and not whether the
page looks good.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from threading import Thread

from playwright.sync_api import BrowserContext, Page, Route, sync_playwright

from bench.viewers.chromium import FLAGS, installed
from mobilegs.view.serve import Server

# CSS pixels, device pixel ratio, and whether there is a touch screen instead of a mouse
SIZES: dict[str, tuple[int, int, float, bool]] = {
    "phone": (390, 844, 3, True),
    "phone-landscape": (844, 390, 3, True),
    "tablet": (820, 1180, 2, True),
    "desktop": (1440, 900, 1, False),
}
WAIT = 300_000  # ms: a processor draws every pixel
HOST = "garden.example"  # a name that other devices might know: Share has no QR code for this one
TITLE = "heading=The old garden&credit=Photos: Ada Example, CC BY 4.0"


def record(
    scene: Path, output: Path, sizes: list[str], scale: float, language: str, scheme: str
) -> None:
    """Write a screenshot for each size and state to `output`."""
    output.mkdir(parents=True, exist_ok=True)
    server = Server(scene)
    Thread(target=server.serve_forever, daemon=True).start()
    address = f"{server.address(HOST)}&{TITLE}&scale={scale}"
    flags = [*FLAGS, f"--host-resolver-rules=MAP {HOST} 127.0.0.1"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=installed(), args=flags)
        for size in sizes:
            width, height, ratio, touch = SIZES[size]
            context = browser.new_context(
                viewport={"width": width, "height": height},
                device_scale_factor=ratio,
                is_mobile=touch,
                has_touch=touch,
                locale=language,
                color_scheme=scheme,
            )
            for number, (state, show) in enumerate(STATES.items()):
                page = context.new_page()
                held = show(context, page, address)
                page.screenshot(path=output / f"{size}-{number}-{state}.png")
                for route in held or []:
                    route.abort()
                context.set_offline(False)
                page.close()
            context.close()
        browser.close()
    server.shutdown()


def opened(page: Page, address: str) -> None:
    """Open the page and wait until its scene is drawn."""
    page.goto(address)
    page.wait_for_selector("mobile-gs[data-state=loaded]", timeout=WAIT)
    page.wait_for_timeout(1200)


def loading(_: BrowserContext, page: Page, address: str) -> list[Route]:
    """The scene does not arrive; returns its request."""
    held: list[Route] = []
    page.route("**/scene", lambda route: held.append(route))
    page.goto(address)
    page.wait_for_function("document.querySelector('mobile-gs').viewer")
    page.wait_for_timeout(600)
    return held


def first_view(_: BrowserContext, page: Page, address: str) -> None:
    """The first view, with the hint."""
    opened(page, address)


def drag(_: BrowserContext, page: Page, address: str) -> None:
    """After a drag, while the pointer is still down."""
    opened(page, address)
    size = page.viewport_size or {"width": 0, "height": 0}
    page.mouse.move(size["width"] / 2, size["height"] / 2)
    page.mouse.down()
    page.mouse.move(size["width"] / 2 + 60, size["height"] / 2 + 10, steps=4)
    page.wait_for_timeout(600)


def idle(_: BrowserContext, page: Page, address: str) -> None:
    """Some seconds after the last input."""
    opened(page, address)
    page.wait_for_timeout(7500)


def dialog(name: str) -> Callable[[BrowserContext, Page, str], None]:
    """Return a state in which a button of the bar was pressed."""

    def show(_: BrowserContext, page: Page, address: str) -> None:
        opened(page, address)
        page.locator(f"mobile-gs .buttons [data-act={name}]").click()
        page.wait_for_timeout(600)

    return show


def failed(_: BrowserContext, page: Page, address: str) -> None:
    """The scene does not exist."""
    page.goto(address.replace("url=/scene", "url=/missing.mgs"))
    page.locator("mobile-gs .message").wait_for()
    page.wait_for_timeout(600)


def offline(context: BrowserContext, page: Page, address: str) -> None:
    """The network is gone when a scene is opened."""

    def cut(route: Route) -> None:
        context.set_offline(True)
        route.abort()

    page.route("**/scene", cut)
    page.goto(address)
    page.locator("mobile-gs .message").wait_for()
    page.wait_for_timeout(600)


STATES: dict[str, Callable[[BrowserContext, Page, str], list[Route] | None]] = {
    "load": loading,
    "first": first_view,
    "drag": drag,
    "idle": idle,
    "settings": dialog("settings"),
    "help": dialog("help"),
    "share": dialog("share"),
    "error": failed,
    "offline": offline,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scene", type=Path)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--only", choices=SIZES, action="append", help="sizes, all by default")
    parser.add_argument("--scale", type=float, default=0.3, help="share of the resolution")
    parser.add_argument("--language", default="en", help="of the browser")
    parser.add_argument("--scheme", default="dark", choices=("dark", "light"))
    given = parser.parse_args()
    sizes = given.only or list(SIZES)
    record(given.scene, given.output, sizes, given.scale, given.language, given.scheme)


if __name__ == "__main__":
    main()
