"""Crop a 3DGS scene to its middle, and write it in every format.

    python examples/convert.py scene.ply cropped --keep 0.5

A scene is five tensors (means, quats, log_scales, logit_opacities, sh): edit them with torch.
"""

import argparse
from pathlib import Path

from mobilegs import Gaussians, InputError, open_scene, write_gaussians


def middle(gaussians: Gaussians, share: float) -> Gaussians:
    """Return the given share of the Gaussians, those nearest to the median position."""
    distance = (gaussians.means - gaussians.means.median(0).values).norm(dim=1)
    return gaussians.select(distance <= distance.quantile(share))


def main() -> None:
    options = argparse.ArgumentParser(description="Crop a scene, and convert it.")
    options.add_argument("scene", type=Path)
    options.add_argument("folder", type=Path)
    options.add_argument(
        "--keep", type=float, default=0.9, help="share of Gaussians to keep, in (0, 1]"
    )
    given = options.parse_args()

    scene = open_scene(given.scene)
    if not scene.is_plain:  # viewers of these formats sort Gaussians of one opacity each
        raise InputError(f"{given.scene} is not plain 3DGS: give its teacher.ply")
    kept = middle(scene.gaussians, given.keep)
    print(f"{len(kept):,} of {len(scene.gaussians):,} Gaussians, degree {kept.sh_degree}")
    given.folder.mkdir(parents=True, exist_ok=True)
    for kind in ("ply", "spz", "sog", "glb"):
        path = given.folder / f"{given.scene.stem}.{kind}"
        size = write_gaussians(path, kept, kind, footprint=scene.footprint, up=scene.up)
        written = open_scene(path).gaussians
        each = f"{size / len(written):.1f} bytes each"
        print(f"{path.name:20} {size:11,} bytes  {len(written):,} Gaussians, {each}")


if __name__ == "__main__":
    main()
