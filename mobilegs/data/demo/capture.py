"""Makes the demo capture: ray-traced photos of a built-in scene, with SfM-like points."""

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import torch
from jaxtyping import Float
from PIL import Image
from torch import Tensor

from mobilegs.atomic import atomic_path
from mobilegs.camera import Camera, look_at
from mobilegs.data.colmap_write import write_model
from mobilegs.data.dataset import Dataset, Frame, assemble, load_view, split_every_eighth
from mobilegs.data.demo.scene import DemoScene

POINT_NOISE = 0.008  # standard deviation of a point's distance to its surface, world units
OUTLIERS = 0.03  # share of points at random positions
DISTANT = 0.1  # share of points in the background, at 10 to 30 world units
_TARGET = (0.0, 0.0, 0.42)
_DISTANCE = 4.2
_RINGS = ((0.40, 12.0), (0.36, 28.0), (0.24, 48.0))  # (share of the views, elevation in degrees)
_FIELD_OF_VIEW = 54.0  # degrees, horizontal


def demo_capture(
    *,
    views: int = 56,
    width: int = 240,
    height: int = 160,
    points: int = 6000,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Dataset:
    """Make the demo capture in memory: photos of a built-in scene from three rings of cameras.

    The same arguments give the same capture on the same machine. World units, z up; the scene
    fits a ball of radius 1.8.

    Args:
        views: number of photos; every eighth is held back.
        width, height: size of a photo in pixels.
        points: number of sparse points: 87 % on surfaces that training views see, with a noise of
            0.008 world units, 10 % in the background, 3 % outliers.
        seed: decides textures and points.
        progress: takes (photos done, photos in all).
    """
    with _single_threaded_operations() as pool:
        scene = DemoScene(seed)
        cameras = demo_cameras(views, width, height)
        pictures = []
        for picture in pool.map(lambda camera: scene.picture(camera)[0], cameras):
            pictures.append(picture)
            progress(len(pictures), views)
        frames = [
            Frame(f"view_{index:03d}.png", camera, pixels=(image * 255).round().to(torch.uint8))
            for index, (camera, image) in enumerate(zip(cameras, pictures, strict=True))
        ]
        train, test = split_every_eighth(frames)
        xyz, rgb = _sparse_points(scene, [frame.camera for frame in train], points, seed)
    return assemble(
        "sample",
        train,
        test,
        points=xyz.numpy(),
        colors=rgb.numpy(),
        background=(0.0, 0.0, 0.0),
    )


@contextmanager
def _single_threaded_operations() -> Iterator[ThreadPoolExecutor]:
    """Open a pool with as many threads as torch uses, in which each operation uses one thread.

    The ray tracer's operations are short. Parallel operations gain little, and on busy cores the
    barriers between them made a capture take 200 s instead of 8 s.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with ThreadPoolExecutor(threads) as pool:
            yield pool
    finally:
        torch.set_num_threads(threads)


def demo_cameras(views: int, width: int, height: int) -> list[Camera]:
    """Return cameras on three rings, from low to high, that look at the centre of the scene."""
    focal = width / 2 / math.tan(math.radians(_FIELD_OF_VIEW / 2))
    K = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    lower, middle = (round(share * views) for share, _ in _RINGS[:2])
    cameras = []
    for ring, count in enumerate((lower, middle, views - lower - middle)):
        elevation = math.radians(_RINGS[ring][1])
        for step in range(count):
            azimuth = math.tau * (step + 0.4 * ring) / count
            offset = torch.tensor(
                [
                    math.cos(azimuth) * math.cos(elevation),
                    math.sin(azimuth) * math.cos(elevation),
                    math.sin(elevation),
                ]
            )
            target = torch.tensor(_TARGET)
            eye = target + _DISTANCE * offset
            viewmat = look_at(eye, target, torch.tensor([0.0, 0.0, 1.0]))
            cameras.append(Camera(viewmat=viewmat, K=K, width=width, height=height))
    return cameras


def write_capture(path: Path | str, dataset: Dataset | None = None) -> None:
    """Write a dataset of pinhole frames, by default the demo capture, in the layout of COLMAP.

    `images/` holds PNG files and `sparse/0/` the model as text, with all digits: `load_capture`
    returns the same split, cameras, pixels and points.
    """
    path = Path(path)
    dataset = demo_capture() if dataset is None else dataset
    frames = sorted([*dataset.train, *dataset.test], key=lambda frame: frame.name)
    for frame in frames:
        pixels = (load_view(frame).image * 255).round().to(torch.uint8)
        with atomic_path(path / "images" / frame.name) as temporary:
            Image.fromarray(pixels.numpy()).save(temporary)
    write_model(path, [(f.name, f.camera) for f in frames], dataset.points, dataset.colors)


def _sparse_points(
    scene: DemoScene, cameras: list[Camera], count: int, seed: int
) -> tuple[Float[Tensor, "m 3"], Float[Tensor, "m 3"]]:
    """Make points like those of structure from motion, with colours rounded to 8 bits."""
    generator = torch.Generator().manual_seed(seed)
    on_surface = count - round(count * DISTANT) - round(count * OUTLIERS)
    origins, directions = _random_rays(cameras, 4 * count, generator)
    colors, depth = scene.rays(origins, directions)
    near = depth.isfinite().nonzero()[:on_surface, 0]
    far = depth.isinf().nonzero()[: round(count * DISTANT), 0]
    surface = origins[:, near] + depth[near] * directions[:, near]
    surface = surface + POINT_NOISE * torch.randn(surface.shape, generator=generator)
    length = 10 + 20 * torch.rand(len(far), generator=generator)
    distant = origins[:, far] + length * directions[:, far]
    outliers = count - len(near) - len(far)
    anywhere = torch.tensor(_TARGET)[:, None] + 4 * torch.rand(3, outliers, generator=generator) - 2
    outlier_colors = torch.rand(3, outliers, generator=generator)
    xyz = torch.cat([surface, distant, anywhere], dim=1).T.contiguous()
    rgb = torch.cat([colors[:, near], colors[:, far], outlier_colors], dim=1).T
    return xyz, (rgb * 255).round() / 255


def _random_rays(
    cameras: list[Camera], count: int, generator: torch.Generator
) -> tuple[Float[Tensor, "3 n"], Float[Tensor, "3 n"]]:
    """Return (origins, unit directions) of rays through random places of random photos."""
    picked = torch.randint(len(cameras), (count,), generator=generator)
    place = torch.rand(2, count, generator=generator)
    first = cameras[0]
    pixels = torch.stack([place[0] * first.width, place[1] * first.height, torch.ones(count)])
    local = torch.linalg.inv(first.K) @ pixels
    rotations = torch.stack([camera.viewmat[:3, :3] for camera in cameras])[picked]
    origins = torch.stack([camera.position for camera in cameras])[picked].T
    directions = torch.einsum("nji,jn->in", rotations, local)
    return origins.contiguous(), torch.nn.functional.normalize(directions, dim=0)
