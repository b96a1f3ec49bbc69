"""Photos that were put in a wrong place: what they have in common with others says so."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mobilegs.capture.engine import engine

OFF = 4.0  # pixels off the epipolar line, up to which a match agrees
LEAST = 0.5  # share of a photo's matches that agree with its pose


class Pair(NamedTuple):
    """Two photos, and how many of their matches there are, and agree with both poses."""

    one: int
    other: int
    matches: int
    agreeing: int


def drop_misplaced(model: Any, database: Path) -> list[str]:
    """Take photos out of a reconstruction with whose pose most of their matches disagree.

    Mapping can place a photo by a few wrong points, far from where it was taken, with a small
    reprojection error: one of 98 of bonsai, at three times the capture's extent. A quarter of its
    matches agreed; of the others 60 % at least, 96 % in the median. The worst is dropped, and its
    matches with it, until none is left. Returns the names.
    """
    pairs = pairs_of(model, database)
    dropped = []
    while pairs:
        shares = agreement(pairs)
        worst = min(shares, key=lambda number: (shares[number], number))
        if shares[worst] >= LEAST:
            break
        image = model.image(worst)
        dropped.append(image.name)
        model.deregister_frame(image.frame_id)
        pairs = [pair for pair in pairs if worst not in (pair.one, pair.other)]
    return dropped


def agreement(pairs: list[Pair]) -> dict[int, float]:
    """The share of each photo's matches that agree, by number."""
    total: dict[int, int] = {}
    agreeing: dict[int, int] = {}
    for pair in pairs:
        for number in (pair.one, pair.other):
            total[number] = total.get(number, 0) + pair.matches
            agreeing[number] = agreeing.get(number, 0) + pair.agreeing
    return {number: agreeing[number] / total[number] for number in total}


def pairs_of(model: Any, database: Path) -> list[Pair]:
    """All verified pairs of placed photos."""
    pycolmap = engine()
    placed = set(model.reg_image_ids())
    cameras, rays = {}, {}
    found = []
    with pycolmap.Database.open(database) as content:
        for number in placed:
            cameras[number] = model.cameras[model.image(number).camera_id]
            keypoints = content.read_keypoints(number)[:, :2].astype(np.float64)
            rays[number] = cameras[number].cam_from_img(keypoints)
        numbers, inliers = content.read_two_view_geometry_num_inliers()
        for pair, count in zip(numbers, inliers, strict=True):
            one, other = pycolmap.pair_id_to_image_pair(pair)
            if not count or one not in placed or other not in placed:
                continue
            matches = content.read_two_view_geometry(one, other).inlier_matches
            motion = (
                model.image(other).cam_from_world() * model.image(one).cam_from_world().inverse()
            )
            focal = (cameras[one].mean_focal_length() + cameras[other].mean_focal_length()) / 2
            errors = focal * epipolar_errors(
                rays[one][matches[:, 0]], rays[other][matches[:, 1]], motion.matrix()
            )
            found.append(Pair(one, other, len(matches), int((errors < OFF).sum())))
    return found


def epipolar_errors(
    one: Float[np.ndarray, "m 2"], other: Float[np.ndarray, "m 2"], motion: Float[np.ndarray, "3 4"]
) -> Float[np.ndarray, "m"]:
    """How far points on the plane z = 1 are from what a motion allows (Sampson), in its units.

    `motion` takes coordinates of the first camera to the second one's.
    """
    x, y, z = motion[:, 3]
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ motion[:, :3]
    one, other = (np.c_[points, np.ones(len(points))] for points in (one, other))
    lines, back = one @ essential.T, other @ essential
    lengths = (lines[:, :2] ** 2).sum(1) + (back[:, :2] ** 2).sum(1)
    return np.abs((other * lines).sum(1)) / np.sqrt(np.maximum(lengths, 1e-30))
