"""`MobileGSMesh` in pages with three.js, called from Python."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from tests.support.browser import Chromium, Tab
from tests.support.page_renderers import in_javascript

SCRIPTS = Path(__file__).parents[1] / "web" / "three"
BUILD = "/node_modules/three/build"
MAP = {
    "three": f"{BUILD}/three.module.js",
    "three/webgpu": f"{BUILD}/three.webgpu.js",
    "three/tsl": f"{BUILD}/three.tsl.js",
    "three/addons/": "/node_modules/three/examples/jsm/",
}
# a page's renderer, scene, camera and functions, as the property `three` of the window
OPEN = (SCRIPTS / "open.js").read_text()
CLEAR = """
const { scene, THREE } = three;
for (const child of [...scene.children]) {
  if (child.isMobileGSMesh) child.dispose();
  else scene.remove(child);
}
scene.background = new THREE.Color(0);
"""


class ThreePage:
    """A renderer of three.js in a page; code that it runs finds `three`."""

    def __init__(self, tab: Tab, kind: str, **options: Any) -> None:
        self.tab = tab
        self.kind = kind
        tab.run(OPEN, kind=kind, map_=MAP, options=options)

    def share(self, name: str, content: bytes) -> str:
        """Serve a file; returns its address."""
        self.tab.share(name, content)
        return f"/arrays/{name}"

    def picture(self, view: Camera, code: str = "", **given: Any) -> torch.Tensor:
        """Run code, and return the picture of the scene from a camera, `[h, w, 3]`, 0 to 1.

        The code may return a function that renders in place of `renderer.render`.
        """
        found = self.tab.run(
            f"""const {{ THREE, renderer, scene, camera, look, picture, load }} = three;
            look(view);
            const render = await (async () => {{ {code} }})();
            return picture(render);""",
            view=in_javascript(view),
            **given,
        )
        return pixels_of(found, view)


def pixels_of(found: np.ndarray, view: Camera) -> torch.Tensor:
    """Return RGBA bytes as an image, `[h, w, 3]`, 0 to 1."""
    pixels = found.reshape(view.height, view.width, 4)[..., :3].astype(np.float32) / 255
    return torch.from_numpy(pixels)


Pages = Callable[..., ThreePage]  # pages("webgl", antialias=True)


@pytest.fixture(scope="module")
def pages(chromium: Chromium) -> Iterator[Pages]:
    """A function that returns a page by renderer and options, made once per module.

    Its scene is empty but for the background, and its function `load` opens a scene.
    """
    made: dict[str, ThreePage] = {}

    def page(kind: str, **options: Any) -> ThreePage:
        key = f"{kind} {options}"
        if key not in made:
            made[key] = ThreePage(chromium.tab(), kind, **options)
        made[key].tab.run(CLEAR)
        return made[key]

    yield page
    for one in made.values():
        one.tab.close()
