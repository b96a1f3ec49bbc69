"""Compare two scenes, and meshes in a scene, in three.js with the truth: the teachers, sorted.

    python -m bench.layers --scene RUN --toy RUN [--json OUT] [--pictures FOLDER] [--only ROW ...]

Both runs have scene.mgs and teacher.ply. The held-back cameras of the capture of `--scene` are
used. The toy lies at four places, turned so that the camera sees it as the first camera in its file
does. `MobileGSMesh` draws the students in Chromium, WebGL2, one sample per pixel. The truth is the
union of the teachers' Gaussians, sorted together.

- *in front*, *behind*, *inside*, *standing on it*: PSNR over the picture, and in the toy's
  silhouette. `layers` is the page; `as_one` is the sums over both scenes (Eq. 2 of the paper).
  `alone` is the truth plus the error of each student by itself, over its own background, in its
  share of each pixel.
- *ball 10 %*, ...: an opaque ball at a share of the way from the surface to the camera, at 24
  places. The figure is the share of it that is visible: how far its pixels are from the picture
  without it to its colour. The truth is the teacher's Gaussians whose centre is before it.
- *time*: milliseconds of a frame of the scene, the toy, both, and the scene with a ball, of 640
  pixels' width: the least of several rounds in turn, between two finished queues.
- *turn, ...*: the camera turns around the toy. A pixel counts if it changes between two frames by
  16 of 255 more than in the truth. `alone` is the same for the scene without the toy.

Rows that the JSON has are not repeated. `--pictures` gets truth | as one | layers of each place.
"""

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from PIL import Image
from playwright.sync_api import sync_playwright
from torch import Tensor

from bench.record import RESULTS, Figures, table
from bench.viewers.chromium import launched
from mobilegs import load_capture
from mobilegs.camera import Camera
from mobilegs.evaluate.front import SOLID
from mobilegs.evaluate.metrics import displayed_colors, psnr, to_bytes
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import read_mgs
from mobilegs.render.scene import Scene
from mobilegs.render.transform import transformed
from mobilegs.scene_file import capture_of_run, open_scene
from mobilegs.spherical_harmonics import C0
from tests.support.browser import Chromium, Server
from tests.support.placed_scenes import Placed, ball_depths, sums_of
from tests.support.three_page import ThreePage

WIDTH = 240  # of the pictures
# where the toy is: its distance in that of the scene's middle, and its size in the same unit
PLACES = {
    "in front": (0.45, 0.18),
    "behind": (1.6, 0.5),
    "inside": (0.95, 0.25),
    "standing on it": (0.8, 0.22),
}
COVERED = 0.05  # coverage from which a pixel belongs to the toy's silhouette
BALLS = {"ball 10 %": 0.1, "ball 25 %": 0.25, "ball 50 %": 0.5}
BALL_PLACES, RADIUS = 24, 0.03  # the radius in its depth
MAGENTA = torch.tensor([1.0, 0.0, 1.0])
TURNS = {"turn, inside": "inside", "turn, standing on it": "standing on it"}
FRAMES, DEGREES = 120, 40.0
TIME, TIMED_WIDTH, TIMED_ROUNDS = "time", 640, 6
NOTICED = 16 / 255  # change between frames
BEGIN = """
const { THREE, scene, load } = three;
window.students = [await load(urls[0]), await load(urls[1], { matrixAutoUpdate: false })];
window.ball = new THREE.Mesh(
  new THREE.SphereGeometry(1, 256, 128),
  new THREE.MeshBasicMaterial({ color: new THREE.Color().setRGB(...color, THREE.SRGBColorSpace) }),
);
scene.add(ball);
scene.background = new THREE.Color();
"""
SHOW = """
const [main, toy] = students;
main.visible = whole;
scene.background.setRGB(...background, THREE.SRGBColorSpace);
toy.visible = matrix !== null;
if (matrix) toy.matrix.set(...matrix);
toy.matrixWorldNeedsUpdate = true;
ball.visible = sphere !== null;
if (sphere) {
  ball.position.set(...sphere.center);
  ball.scale.setScalar(sphere.radius);
}
"""
TIMED = """
const gl = renderer.getContext();
return () => {
  const pixel = new Uint8Array(4);
  const finish = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  renderer.render(scene, camera);
  finish();
  const from = performance.now();
  for (let i = 0; i < 4; i++) renderer.render(scene, camera);
  finish();
  window.milliseconds = (performance.now() - from) / 4;
};
"""


@dataclass
class Run:
    """A student, its teacher, and what a training wrote about both."""

    folder: Path

    @cached_property
    def student(self) -> Scene:
        return open_scene(self.folder / "scene.mgs")

    @cached_property
    def teacher(self) -> Scene:
        """With the background and the near plane of the student."""
        scene = open_scene(self.folder / "teacher.ply")
        return replace(scene, background=self.student.background, near=self.student.near)

    @property
    def about(self) -> dict[str, Any]:
        metrics = json.loads((self.folder / "metrics.json").read_text())
        recipe = json.loads((self.folder / "config.json").read_text())["recipe"]
        found: dict[str, Any] = {"capture": metrics["capture"], "image_size": metrics["image_size"]}
        for who in ("teacher", "student"):
            values = {key: metrics[who].get(key) for key in ("gaussians", "psnr", "front")}
            found[who] = {"steps": recipe[who]["steps"], **values}
        return found

    def cameras(self) -> list[Camera]:
        """Return the held-back cameras, as wide as the pictures."""
        capture, downscale = capture_of_run(self.folder / "scene.mgs")
        assert capture is not None, f"the capture of {self.folder} is needed"
        views = [frame.camera for frame in load_capture(capture, downscale=downscale).test]
        near = self.student.near
        return [replace(view.scaled(WIDTH / view.width), near=near) for view in views]


class Place(NamedTuple):
    """The toy in the world.

    Attributes:
        matrix: from its units to the world, `[4, 4]`.
        teacher: its teacher in the world.
    """

    matrix: Tensor
    teacher: Scene

    @classmethod
    def of(cls, name: str, scene: Run, toy: Run, camera: Camera) -> "Place":
        where, size = PLACES[name]
        axes = camera.viewmat[:3, :3]
        distance = float((scene.student.gaussians.means.median(0).values - camera.position).norm())
        means = toy.student.gaussians.means
        center = means.median(0).values
        extent = float((means - center).norm(dim=1).quantile(0.95))
        view = read_mgs(toy.folder / "scene.mgs").views[0]
        matrix = torch.eye(4)
        matrix[:3, :3] = size * distance / extent * axes.T @ view.viewmat[:3, :3]
        matrix[:3, 3] = camera.position + where * distance * axes[2] - matrix[:3, :3] @ center
        linear, offset = (part.double().numpy() for part in (matrix[:3, :3], matrix[:3, 3]))
        gaussians = transformed(toy.teacher.gaussians, linear, offset)
        return cls(matrix, replace(toy.teacher, gaussians=gaussians))


class Page:
    """The students in three.js: a scene, a toy and a ball, each of which may be hidden."""

    def __init__(self, chromium: Chromium, scene: Run, toy: Run) -> None:
        self._page = ThreePage(chromium.tab(), "webgl")
        files = [(run.folder / "scene.mgs").read_bytes() for run in (scene, toy)]
        urls = [self._page.share(f"{i}.mgs", content) for i, content in enumerate(files)]
        self._page.tab.run(BEGIN, urls=urls, color=MAGENTA.tolist())
        self._backgrounds = [run.student.background.tolist() for run in (scene, toy)]

    def show(
        self,
        camera: Camera,
        toy: Place | None = None,
        *,
        whole: bool = True,
        ball: tuple[Tensor, float] | None = None,
        code: str = "",
    ) -> Tensor:
        """Return the picture, `[h, w, 3]`; that of the toy by itself if it is not the whole."""
        return self._page.picture(
            camera,
            SHOW + code,
            whole=whole,
            background=self._backgrounds[0 if whole else 1],
            matrix=None if toy is None else toy.matrix.flatten().tolist(),
            sphere=None if ball is None else {"center": ball[0].tolist(), "radius": ball[1]},
        )

    def time(self, camera: Camera, toy: Place | None = None, **shown: Any) -> float:
        """Return the milliseconds of a frame."""
        self.show(camera, toy, **shown, code=TIMED)
        return float(
            self._page.tab.run("return Float32Array.of(milliseconds);").view(np.float32)[0]
        )


@contextmanager
def opened(scene: Run, toy: Run) -> Iterator[Page]:
    """Open the page in a browser."""
    server = Server()
    with sync_playwright() as playwright:
        browser = launched(playwright)
        yield Page(Chromium(browser, server), scene, toy)
        browser.close()
    server.close()


def union(one: Scene, other: Scene) -> Scene:
    """Return the first scene with the Gaussians of the second one; both are sorted."""
    assert one.footprint == other.footprint, "the teachers have different footprints"
    g, h = one.gaussians.tensors(), other.gaussians.tensors()
    return replace(one, gaussians=Gaussians(**{k: torch.cat([g[k], h[k]]) for k in g}))


def shown(scene: Scene, camera: Camera) -> Tensor:
    """Return the picture of a scene as displayed, `[h, w, 3]`."""
    return displayed_colors(scene.render(camera).image)


def painted(scene: Scene, value: float) -> Scene:
    """Return the scene in one colour, from all directions, over black."""
    sh = torch.zeros_like(scene.gaussians.sh)
    sh[:, 0] = (value - 0.5) / C0
    gaussians = replace(scene.gaussians, sh=sh)
    return replace(scene, gaussians=gaussians, background=torch.zeros(3))


def pair_row(
    page: Page, scene: Run, toy: Run, place: Place, camera: Camera
) -> tuple[dict[str, Any], Tensor]:
    """Return the figures of one place, and its pictures: truth, as one, layers."""
    truth = shown(union(scene.teacher, place.teacher), camera)
    layers = page.show(camera, place)
    students = [Placed(scene.student, torch.eye(4)), Placed(toy.student, place.matrix)]
    as_one = sums_of(students, camera).over(scene.student.background)
    toy_alone = place.teacher.render(camera)
    share = union(painted(scene.teacher, 0), painted(place.teacher, 1)).render(camera).image
    scene_error = page.show(camera) - shown(scene.teacher, camera)
    toy_error = page.show(camera, place, whole=False) - displayed_colors(toy_alone.image)
    alpha = toy_alone.alpha[..., None]
    alone = truth + (1 - share) * scene_error + share / alpha.clamp_min(COVERED) * toy_error
    inside = toy_alone.alpha > COVERED
    pictures = {"layers": layers, "as_one": displayed_colors(as_one)}
    pictures["alone"] = displayed_colors(alone)
    row: dict[str, Any] = {"silhouette": round(float(inside.float().mean()), 4)}
    for name, picture in pictures.items():
        row[name] = [round(psnr(picture, truth, mask), 2) for mask in (None, inside)]
    return row, torch.cat([truth, pictures["as_one"], layers], dim=1)


def ball_places(teacher: Scene, cameras: Sequence[Camera]) -> list[tuple[Camera, Tensor, float]]:
    """Return cameras, rays and depths of the places of balls, the same at every call.

    A ray is in camera space, of length 1 along z.
    """
    generator = torch.Generator().manual_seed(0)
    found = []
    for camera in (cameras[i % len(cameras)] for i in range(BALL_PLACES)):
        seen = teacher.render(camera, depth=True)
        assert seen.depth is not None
        solid = seen.alpha > SOLID
        margin = 1 + math.ceil(RADIUS * float(camera.K[0, 0]))
        edge = torch.ones_like(solid)
        edge[margin:-margin, margin:-margin] = False
        pixels = (solid & ~edge).nonzero()
        y, x = pixels[torch.randint(len(pixels), (), generator=generator)]
        ray = torch.linalg.inv(camera.K) @ torch.tensor([x + 0.5, y + 0.5, 1.0])
        found.append((camera, ray, float(seen.depth[y, x] / seen.alpha[y, x])))
    return found


def ball_row(page: Page, scene: Run, cameras: Sequence[Camera], share: float) -> dict[str, Any]:
    """Return the visible share of balls `share` of the way from the surface to the camera."""
    found: dict[str, list[float]] = {"layers": [], "truth": []}
    for camera, ray, depth in ball_places(scene.teacher, cameras):
        z = (1 - share) * depth
        center = camera.viewmat[:3, :3].T @ (z * ray - camera.viewmat[:3, 3])
        depths = ball_depths(camera, center, RADIUS * z)
        inside = depths.isfinite()
        layers = page.show(camera, ball=(center, RADIUS * z))
        found["layers"].append(visible(layers, page.show(camera), inside))
        g = scene.teacher.gaussians
        before = g.select(camera.depths(g.means) < depths[inside].mean())
        truth = shown(replace(scene.teacher, gaussians=before, background=MAGENTA), camera)
        found["truth"].append(visible(truth, shown(scene.teacher, camera), inside))
    return {
        name: {"median": round(float(np.median(shares)), 3), "least": round(min(shares), 3)}
        for name, shares in found.items()
    }


def visible(picture: Tensor, without: Tensor, inside: Tensor) -> float:
    """Return how far pixels are from the picture without the ball to its colour."""
    moved, whole = (picture - without)[inside], (MAGENTA - without)[inside]
    return float((moved * whole).sum() / whole.square().sum())


def turn_row(page: Page, scene: Run, place: Place, camera: Camera) -> dict[str, Any]:
    """Return the largest and the mean share of pixels that change more than in the truth."""
    middle = place.teacher.gaussians.means.median(0).values
    path = [
        turned(camera, middle, math.radians(a)) for a in np.linspace(-0.5, 0.5, FRAMES) * DEGREES
    ]
    both = union(scene.teacher, place.teacher)
    row: dict[str, Any] = {"frames": FRAMES, "degrees": DEGREES}
    for name, toy, teacher in (("layers", place, both), ("alone", None, scene.teacher)):
        changes = [
            [(b - a).abs().amax(2) for a, b in pairwise(frames)]
            for frames in (
                (page.show(view, toy) for view in path),
                (shown(teacher, view) for view in path),
            )
        ]
        shares = [float((a - b > NOTICED).float().mean()) for a, b in zip(*changes, strict=True)]
        row[name] = {"largest": round(max(shares), 5), "mean": round(float(np.mean(shares)), 5)}
    return row


def time_row(page: Page, scene: Run, place: Place, camera: Camera) -> dict[str, Any]:
    """Return the milliseconds of a frame."""
    view = camera.scaled(TIMED_WIDTH / camera.width)
    middle = camera.position + float(scene.cameras()[0].near) * 10 * camera.viewmat[2, :3]
    shown: dict[str, tuple[Place | None, dict[str, Any]]] = {
        "scene": (None, {}),
        "toy": (place, {"whole": False}),
        "both": (place, {}),
        "scene and ball": (None, {"ball": (middle, float(scene.cameras()[0].near))}),
    }
    rounds = [
        {name: page.time(view, toy, **more) for name, (toy, more) in shown.items()}
        for _ in range(TIMED_ROUNDS)
    ]
    size = [view.width, view.height]
    return {"size": size} | {name: round(min(one[name] for one in rounds), 1) for name in shown}


def turned(camera: Camera, middle: Tensor, angle: float) -> Camera:
    """Return the camera turned around a point, about its own vertical axis, by radians."""
    c, s = math.cos(angle), math.sin(angle)
    turn = torch.tensor([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    seen = camera.viewmat[:3, :3] @ middle + camera.viewmat[:3, 3]
    viewmat = camera.viewmat.clone()
    viewmat[:3] = turn @ viewmat[:3]
    viewmat[:3, 3] += seen - turn @ seen
    return replace(camera, viewmat=viewmat)


def tables(rows: dict[str, Any]) -> str:
    """Return the tables of all rows."""

    def cells(row: dict[str, Any], name: str) -> str:
        return " / ".join(f"{value:.1f}" for value in row[name])

    def percent(values: dict[str, float], digits: int = 0) -> str:
        return " / ".join(f"{100 * value:.{digits}f}" for value in values.values())

    pairs = [
        [name, *(cells(rows[name], key) for key in ("as_one", "layers", "alone"))]
        for name in PLACES
        if name in rows
    ]
    balls = [
        [name, *(percent(rows[name][key]) for key in ("layers", "truth"))]
        for name in BALLS
        if name in rows
    ]
    turns = [
        [name, *(percent(rows[name][key], 2) for key in ("layers", "alone"))]
        for name in TURNS
        if name in rows
    ]
    times = (
        [
            [
                " x ".join(map(str, row["size"])),
                *(f"{row[key]:.0f}" for key in ("scene", "toy", "both", "scene and ball")),
            ]
            for row in (rows[TIME],)
        ]
        if TIME in rows
        else []
    )
    return "\n\n".join(
        [
            table("toy, dB picture / silhouette | as one | layers | students alone", pairs),
            table("visible %, median / least | MobileGSMesh | sorted teacher", balls),
            table("pixels %, largest / mean | layers | scene alone", turns),
            table("ms | scene | toy | both | scene and ball", times),
        ]
    )


@torch.inference_mode()
def main() -> None:
    names = [*PLACES, *BALLS, *TURNS, TIME]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", type=Path, required=True, help="folder of a run")
    parser.add_argument("--toy", type=Path, required=True, help="folder of a run")
    parser.add_argument("--json", type=Path, default=RESULTS / "layers.json")
    parser.add_argument("--pictures", type=Path, help="folder, made if it is missing")
    parser.add_argument("--only", nargs="+", default=names, choices=names)
    options = parser.parse_args()
    scene, toy = Run(options.scene), Run(options.toy)
    cameras = scene.cameras()
    size = [cameras[0].width, cameras[0].height]
    figures = Figures(options.json, scene=scene.about, toy=toy.about, pictures=size)
    with opened(scene, toy) as page:
        for name in (name for name in options.only if name not in figures.rows):
            if name in BALLS:
                figures.add(name, **ball_row(page, scene, cameras, BALLS[name]))
                continue
            where = "standing on it" if name == TIME else TURNS.get(name, name)
            place = Place.of(where, scene, toy, cameras[0])
            if name == TIME:
                figures.add(name, **time_row(page, scene, place, cameras[0]))
                continue
            if name in TURNS:
                figures.add(name, **turn_row(page, scene, place, cameras[0]))
                continue
            row, pictures = pair_row(page, scene, toy, place, cameras[0])
            figures.add(name, **row)
            if options.pictures:
                options.pictures.mkdir(parents=True, exist_ok=True)
                Image.fromarray(to_bytes(pictures).numpy()).save(options.pictures / f"{name}.png")
    print(tables(figures.rows))
    files = [options.pictures / f"{name}.png" for name in PLACES] if options.pictures else []
    if files and all(file.exists() for file in files):
        rows = np.concatenate([np.asarray(Image.open(file)) for file in files])
        Image.fromarray(rows).save(options.pictures / "layers.webp", quality=90, method=6)


if __name__ == "__main__":
    main()
