"""The built-in capture: photos of a scene that is traced on the spot, with SfM-like points."""

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
from mobilegs.data.demo.scene import SampleScene

POINT_NOISE = 0.008  # world units: standard deviation of a point about its surface
OUTLIERS = 0.03  # share of the points that are anywhere
DISTANT = 0.1  # share of the points that belong to the background, at 10 to 30 world units
_TARGET = (0.0, 0.0, 0.42)
_DISTANCE = 4.2
_RINGS = ((0.40, 12.0), (0.36, 28.0), (0.24, 48.0))  # share of the views, elevation in degrees
_FIELD_OF_VIEW = 54.0  # degrees, horizontally


def sample_capture(
    *,
    views: int = 56,
    width: int = 240,
    height: int = 160,
    points: int = 6000,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Dataset:
    """The built-in capture in memory: `views` photos from three rings around the scene.

    Of the `points`, 87 % lie on surfaces that training views see, with noise of
    `POINT_NOISE`; `DISTANT` and `OUTLIERS` are the rest. The same arguments give the same
    capture on the same machine. World units, z up; the scene fits a ball of radius 1.8.
    `progress` is told how many photos of how many are done.
    """
    with _one_thread_an_operation() as pool:
        scene = SampleScene(seed)
        cameras = sample_cameras(views, width, height)
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
def _one_thread_an_operation() -> Iterator[ThreadPoolExecutor]:
    """A pool with as many threads as torch uses, each of which runs its operations alone.

    The tracer's operations are short. Sharing each among threads gains little, and on cores
    that others use too the barriers between them cost 25 times the work (200 s for 8).
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with ThreadPoolExecutor(threads) as pool:
            yield pool
    finally:
        torch.set_num_threads(threads)


def sample_cameras(views: int, width: int, height: int) -> list[Camera]:
    """Cameras on three rings, from low to high, each looking at the middle of the scene."""
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


def write_sample(path: Path | str, dataset: Dataset | None = None) -> None:
    """Write the built-in capture (or `dataset`, any one with pinhole frames) as COLMAP does.

    `images/` holds PNG files, `sparse/0/` the model as text, with all digits: `load_capture`
    gives back the same split, cameras, pixels and points.
    """
    path = Path(path)
    dataset = sample_capture() if dataset is None else dataset
    frames = sorted([*dataset.train, *dataset.test], key=lambda frame: frame.name)
    for frame in frames:
        pixels = (load_view(frame).image * 255).round().to(torch.uint8)
        with atomic_path(path / "images" / frame.name) as temporary:
            Image.fromarray(pixels.numpy()).save(temporary)
    write_model(path, [(f.name, f.camera) for f in frames], dataset.points, dataset.colors)


def _sparse_points(
    scene: SampleScene, cameras: list[Camera], count: int, seed: int
) -> tuple[Float[Tensor, "m 3"], Float[Tensor, "m 3"]]:
    """Points as structure from motion would leave them, colours rounded to 8 bits."""
    generator = torch.Generator().manual_seed(seed)
    wanted = count - round(count * DISTANT) - round(count * OUTLIERS)
    origins, directions = _random_rays(cameras, 4 * count, generator)
    colors, depth = scene.rays(origins, directions)
    near = depth.isfinite().nonzero()[:wanted, 0]
    far = depth.isinf().nonzero()[: round(count * DISTANT), 0]
    surface = origins[:, near] + depth[near] * directions[:, near]
    surface = surface + POINT_NOISE * torch.randn(surface.shape, generator=generator)
    length = 10 + 20 * torch.rand(len(far), generator=generator)
    distant = origins[:, far] + length * directions[:, far]
    strays = count - len(near) - len(far)
    anywhere = torch.tensor(_TARGET)[:, None] + 4 * torch.rand(3, strays, generator=generator) - 2
    stray_colors = torch.rand(3, strays, generator=generator)
    xyz = torch.cat([surface, distant, anywhere], dim=1).T.contiguous()
    rgb = torch.cat([colors[:, near], colors[:, far], stray_colors], dim=1).T
    return xyz, (rgb * 255).round() / 255


def _random_rays(
    cameras: list[Camera], count: int, generator: torch.Generator
) -> tuple[Float[Tensor, "3 n"], Float[Tensor, "3 n"]]:
    """(origins, unit directions) of rays through random places of random pictures."""
    picked = torch.randint(len(cameras), (count,), generator=generator)
    place = torch.rand(2, count, generator=generator)
    first = cameras[0]
    pixels = torch.stack([place[0] * first.width, place[1] * first.height, torch.ones(count)])
    local = torch.linalg.inv(first.K) @ pixels
    rotations = torch.stack([camera.viewmat[:3, :3] for camera in cameras])[picked]
    origins = torch.stack([camera.position for camera in cameras])[picked].T
    directions = torch.einsum("nji,jn->in", rotations, local)
    return origins.contiguous(), torch.nn.functional.normalize(directions, dim=0)
