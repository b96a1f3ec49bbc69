"""Record the README's moving picture: the viewer in a browser window of a phone's size.

    python -m bench.readme_picture RUN/scene.mgs [--output docs/images/viewer.webp] [--frames 48]

The camera turns once around the scene, from where the viewer starts. The picture in the repository
shows "PLAYBOT" by Stephane Agullo (https://sa3d.fr, CC-BY-4.0), compressed without its photos:

    mobilegs compress playbot.ply -o RUN --cameras cameras.json --steps 1000 --views 240 --size 512
"""

import argparse
import io
import math
from pathlib import Path
from threading import Thread

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright

from bench.viewers.chromium import launched
from mobilegs.view.serve import Server
from mobilegs.viewpoints.pose import turned

OUTPUT = Path(__file__).parent.parent / "docs/images/viewer.webp"
PHONE = {"width": 390, "height": 844}  # CSS pixels
WAIT = 300_000  # ms: a processor draws every pixel
# the next frame after a change of the camera that shows it at full resolution
DRAWN = """hash => new Promise(resolve => {
  const element = document.querySelector("mobile-gs");
  let timer;
  const settled = () => { clearTimeout(timer); timer = setTimeout(resolve, 700); };
  element.addEventListener("frame", settled);
  settled();
  location.hash = hash;
})"""


def record(scene: Path, frames: int, ratio: float) -> list[Image.Image]:
    """Return screenshots of the viewer's page for one turn around the scene."""
    server = Server(scene)
    Thread(target=server.serve_forever, daemon=True).start()
    with sync_playwright() as playwright:
        browser = launched(playwright)
        page = browser.new_page(viewport=PHONE, device_scale_factor=ratio)
        page.goto(server.address("127.0.0.1"))
        page.wait_for_selector("mobile-gs[data-state=loaded]", timeout=WAIT)
        page.wait_for_timeout(5000)  # the viewer measures the fastest way to draw
        pictures = [screenshot(page, hash) for hash in poses(page, frames)]
        browser.close()
    server.shutdown()
    return pictures


def poses(page: Page, frames: int) -> list[str]:
    """Return the addresses' hashes of cameras on a circle through the viewer's first camera."""
    pose = page.evaluate(
        "(({ eye, target, up }) => ({ eye, target, up }))"
        "(document.querySelector('mobile-gs').viewer.pose)"
    )
    eye, target, up = (np.array(pose[name], float) for name in ("eye", "target", "up"))
    hashes = []
    for number in range(frames):
        place = target + turned(eye - target, up, 2 * math.pi * number / frames)
        fields = {"eye": place, "at": target, "up": up}
        values = {name: ",".join(f"{x:.6f}" for x in vector) for name, vector in fields.items()}
        hashes.append("&".join(f"{name}={text}" for name, text in values.items()))
    return hashes


def screenshot(page: Page, hash: str) -> Image.Image:
    """Return the page as it looks from the camera in `hash`."""
    page.evaluate(DRAWN, hash)
    return Image.open(io.BytesIO(page.screenshot())).convert("RGB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", type=Path)
    parser.add_argument("--output", type=Path, default=OUTPUT)
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--width", type=int, default=300, help="pixels of the moving picture")
    parser.add_argument("--ratio", type=float, default=2, help="screen pixels per CSS pixel")
    parser.add_argument("--milliseconds", type=int, default=100, help="per frame")
    parser.add_argument("--quality", type=int, default=60)
    options = parser.parse_args()
    size = (options.width, round(options.width * PHONE["height"] / PHONE["width"]))
    pictures = [
        picture.resize(size, Image.Resampling.LANCZOS)
        for picture in record(options.scene, options.frames, options.ratio)
    ]
    pictures[0].save(
        options.output,
        save_all=True,
        append_images=pictures[1:],
        duration=options.milliseconds,
        loop=0,
        quality=options.quality,
        method=6,
    )
    print(f"{options.output}: {options.output.stat().st_size:,} bytes, {len(pictures)} frames")


if __name__ == "__main__":
    main()
