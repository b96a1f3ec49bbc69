"""The viewer's WebGL2 and WebGPU renderers in a page, called from Python."""

from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.render.scene import Scene
from mobilegs.render.sortfree import WEIGHTINGS
from mobilegs.view.wgpu_renderer import WgpuImage, _rows
from tests.support.browser import VIEWER, Chromium, Tab


class Kind(NamedTuple):
    """A renderer class of the viewer."""

    module: str
    name: str
    language: str


KINDS = {
    "webgl": Kind("webgl.js", "WebGlRenderer", "glsl"),
    "webgpu": Kind("webgpu.js", "WebGpuRenderer", "wgsl"),
}
OPEN = """
const texts = await Promise.all(
  names.map(async (name) => (await fetch(`/shaders/${name}.${kind.language}`)).text()),
);
const shaders = Object.fromEntries(names.map((name, i) => [name, texts[i]]));
const Renderer = (await import(`/src/render/${kind.module}`))[kind.name];
window.canvas = document.createElement("canvas");
window.renderer = await Renderer.create(canvas, shaders, { floats: fullPrecision });
"""
SHOW = """
renderer.setScene({ ...facts, shapes, colors, lobes });
window.scene = { ...facts, shapes, colors, lobes };
"""
PAINT = """
renderer.levelSigma = levelSigma;
renderer.supersampling = supersampling;
if (order.length) renderer.setOrder(order);
const painted = await renderer.pixels(camera);
renderer.levelSigma = 0;
renderer.supersampling = 1;
return painted;
"""


class Painter:
    """A renderer in a page."""

    def __init__(self, tab: Tab, kind: Kind, *, full_precision: bool) -> None:
        self.tab = tab
        names = [file.stem for file in (VIEWER / "shaders").glob(f"*.{kind.language}")]
        tab.run(OPEN, kind=kind._asdict(), names=names, fullPrecision=full_precision)

    def paint(
        self,
        view: Camera,
        scene: Scene | None = None,
        *,
        level_sigma: float = 0.0,
        supersampling: int = 1,
    ) -> WgpuImage:
        """Return the image of a scene; without one, of the previous scene."""
        given = {} if scene is None else self._in_javascript(scene)
        order = np.zeros(0, np.uint32)
        if self._sorted:
            depths = self._means @ view.viewmat[2, :3].double().numpy()
            order = np.argsort(depths, kind="stable")[::-1].astype(np.uint32)
        code = PAINT if scene is None else SHOW + PAINT
        given |= {"order": order, "levelSigma": level_sigma, "supersampling": supersampling}
        found = self.tab.run(code, camera=in_javascript(view), **given)
        assert not self.tab.complaints
        pixels = torch.from_numpy(found.reshape(view.height, view.width, 4).copy())
        return WgpuImage(pixels[..., :3], pixels[..., 3])

    def _in_javascript(self, scene: Scene) -> dict[str, Any]:
        """Return the scene as `SceneData` of types.js."""
        count = len(scene.gaussians.means)
        shapes, colors, lobes, _, means = _rows(scene)
        shapes, colors, lobes, self._means = (
            rows[:count] for rows in (shapes, colors, lobes, means)
        )
        self._sorted = scene.blend == "sorted"
        weighting = scene.weighting
        facts = {
            "count": len(shapes),
            "packing": None,
            "shSize": colors.shape[1],
            "lobeSize": lobes.shape[1],
            "sorted": self._sorted,
            "weighting": {
                "index": WEIGHTINGS.index(weighting.name),
                "exponentMax": weighting.exponent_max,
                "sigma": weighting.sigma,
                "backgroundWeight": weighting.background_weight,
                "alphaMin": weighting.alpha_min,
            },
            "footprint": asdict(scene.footprint),
            "background": scene.background.tolist(),
        }
        return {"facts": facts, "shapes": shapes, "colors": colors, "lobes": lobes}


def in_javascript(view: Camera) -> dict[str, Any]:
    """Return a camera as `Camera` of types.js."""
    k = view.K.double()
    return {
        "viewmat": view.viewmat.double().flatten().tolist(),
        "fx": k[0, 0].item(),
        "fy": k[1, 1].item(),
        "cx": k[0, 2].item(),
        "cy": k[1, 2].item(),
        "width": view.width,
        "height": view.height,
        "near": view.near,
    }


Painters = Callable[..., Painter]  # painters("webgl", full_precision=True)


@pytest.fixture(scope="module")
def painters(chromium: Chromium) -> Iterator[Painters]:
    """A function that returns a renderer by name and precision, made once per module."""
    tabs: list[Tab] = []

    @cache
    def painter(name: str, *, full_precision: bool) -> Painter:
        tabs.append(chromium.tab())
        return Painter(tabs[-1], KINDS[name], full_precision=full_precision)

    yield painter
    for tab in tabs:
        tab.close()
