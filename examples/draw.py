"""Render a scene and its depth from a camera of your choice.

    python examples/draw.py scene.mgs image.png --eye 0 -1 -4 --at 0 0 0

Without --eye and --at the camera is the first one in the file, or one that looks at the middle.
"""

import argparse
import math
from pathlib import Path

import torch
from PIL import Image

from mobilegs import Camera, Scene, look_at, open_scene, read_mgs, to_bytes


def camera_at(eye: torch.Tensor, at: torch.Tensor, *, fov: float, size: tuple[int, int]) -> Camera:
    """Return a camera at `eye` that looks at `at`; `fov` is horizontal, in degrees."""
    width, height = size
    focal = width / 2 / math.tan(math.radians(fov) / 2)
    k = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    up = torch.tensor([0.0, -1.0, 0.0])  # in most captures y points down
    return Camera(look_at(eye, at, up), k, width, height)


def default_view(scene: Scene) -> tuple[torch.Tensor, torch.Tensor]:
    """Return a camera position and a target in the middle of the scene."""
    low, middle, high = scene.gaussians.means.quantile(torch.tensor([0.25, 0.5, 0.75]), dim=0)
    return middle + 2 * (high - low).max() * torch.tensor([0.0, -0.3, -1.0]), middle


def main() -> None:
    options = argparse.ArgumentParser(description="Render a scene.")
    options.add_argument("scene", type=Path)
    options.add_argument("image", type=Path)
    options.add_argument("--eye", type=float, nargs=3, help="camera position, x y z")
    options.add_argument("--at", type=float, nargs=3, help="target of the camera, x y z")
    options.add_argument("--fov", type=float, default=60, help="horizontal, in degrees")
    options.add_argument("--size", type=int, nargs=2, default=(640, 480), help="width height")
    given = options.parse_args()

    scene = open_scene(given.scene)
    views = read_mgs(given.scene).views if given.scene.suffix == ".mgs" else []
    if given.eye and given.at:
        eye, at = torch.tensor(given.eye), torch.tensor(given.at)
        camera = camera_at(eye, at, fov=given.fov, size=given.size)
    elif views:
        camera = views[0]
    else:
        camera = camera_at(*default_view(scene), fov=given.fov, size=given.size)

    rendered = scene.render(camera, depth=True)
    Image.fromarray(to_bytes(rendered.image).numpy()).save(given.image)
    covered = rendered.alpha > 0.5
    print(f"{given.image}: {camera.width}x{camera.height}, {len(scene.gaussians):,} Gaussians")
    print(f"{(rendered.radii > 0).sum():,} Gaussians in view, {covered.float().mean():.0%} covered")
    if rendered.depth is not None and covered.any():
        depth = rendered.depth[covered] / rendered.alpha[covered]  # depth is weighted by alpha
        print(f"depth {depth.min():.2f} to {depth.max():.2f} world units")


if __name__ == "__main__":
    main()
