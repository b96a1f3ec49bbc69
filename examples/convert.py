"""Cut the middle out of a plain 3DGS scene, and write it for every tool there is.

    python examples/convert.py scene.ply cut --keep 0.5

Gaussians are five tensors, so whatever torch can do can be done to a scene.
"""

import argparse
from pathlib import Path

from mobilegs import (
    Gaussians,
    InputError,
    open_scene,
    write_glb,
    write_ply,
    write_sog,
    write_spz,
)

WRITERS = {"ply": write_ply, "spz": write_spz, "sog": write_sog, "glb": write_glb}


def middle(gaussians: Gaussians, share: float) -> Gaussians:
    """The share of the Gaussians that is nearest to their median."""
    distance = (gaussians.means - gaussians.means.median(0).values).norm(dim=1)
    return gaussians.select(distance <= distance.quantile(share))


def main() -> None:
    options = argparse.ArgumentParser(description="Cut a scene, and convert it.")
    options.add_argument("scene", type=Path)
    options.add_argument("folder", type=Path)
    options.add_argument("--keep", type=float, default=0.9, help="share of the Gaussians")
    given = options.parse_args()

    scene = open_scene(given.scene)
    if scene.blend != "sorted":  # none of these formats can say that a scene needs no order
        raise InputError(f"{given.scene} is blended without sorting: give its teacher.ply")
    kept = middle(scene.gaussians, given.keep)
    print(f"{len(kept):,} of {len(scene.gaussians):,} Gaussians, degree {kept.sh_degree}")
    given.folder.mkdir(parents=True, exist_ok=True)
    for kind, write in WRITERS.items():
        path = given.folder / f"{given.scene.stem}.{kind}"
        write(path, kept)
        again, size = open_scene(path).gaussians, path.stat().st_size
        each = f"{size / len(again):.1f} each"
        print(f"{path.name:20} {size:11,} bytes  {len(again):,} Gaussians, {each}")


if __name__ == "__main__":
    main()
