"""Draw a scene from any place: a camera, a picture, its depth.

    python examples/draw.py scene.mgs picture.png --eye 0 -1 -4 --at 0 0 0

Without --eye and --at the camera is the first that the file names, or stands aside of the middle.
"""

import argparse
import math
from pathlib import Path

import torch
from PIL import Image

from mobilegs import Camera, Scene, look_at, open_scene, read_mgs, to_bytes


def camera_at(eye: torch.Tensor, at: torch.Tensor, *, fov: float, size: tuple[int, int]) -> Camera:
    """A camera that looks at something; `fov` is across the picture, in degrees."""
    width, height = size
    focal = width / 2 / math.tan(math.radians(fov) / 2)
    k = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    up = torch.tensor([0.0, -1.0, 0.0])  # y points down in captures of COLMAP's, mostly
    return Camera(look_at(eye, at, up), k, width, height)


def aside(scene: Scene) -> tuple[torch.Tensor, torch.Tensor]:
    """Where to stand, and what to look at, if nobody says."""
    low, middle, high = scene.gaussians.means.quantile(torch.tensor([0.25, 0.5, 0.75]), dim=0)
    return middle + 2 * (high - low).max() * torch.tensor([0.0, -0.3, -1.0]), middle


def main() -> None:
    options = argparse.ArgumentParser(description="Draw a scene.")
    options.add_argument("scene", type=Path)
    options.add_argument("picture", type=Path)
    options.add_argument("--eye", type=float, nargs=3)
    options.add_argument("--at", type=float, nargs=3)
    options.add_argument("--fov", type=float, default=60)
    options.add_argument("--size", type=int, nargs=2, default=(640, 480))
    given = options.parse_args()

    scene = open_scene(given.scene)
    views = read_mgs(given.scene).views if given.scene.suffix == ".mgs" else []
    if given.eye and given.at:
        places = torch.tensor(given.eye), torch.tensor(given.at)
        camera = camera_at(*places, fov=given.fov, size=given.size)
    elif views:
        camera = views[0]
    else:
        camera = camera_at(*aside(scene), fov=given.fov, size=given.size)

    drawn = scene.render(camera, depth=True)
    Image.fromarray(to_bytes(drawn.image).numpy()).save(given.picture)
    covered = drawn.alpha > 0.5
    print(f"{given.picture}: {camera.width}x{camera.height}, {len(scene.gaussians):,} Gaussians")
    print(
        f"{(drawn.radii > 0).sum():,} of them touch the picture, {covered.float().mean():.0%} full"
    )
    if drawn.depth is not None and covered.any():
        depth = drawn.depth[covered] / drawn.alpha[covered]
        print(f"{depth.min():.2f} to {depth.max():.2f} world units away")


if __name__ == "__main__":
    main()
