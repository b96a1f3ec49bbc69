"""Removes photos with a wrong pose from a reconstruction, by their epipolar errors."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from mobilegs.capture.pycolmap_runtime import load_pycolmap

ERROR_MAX = 4.0  # pixels from the epipolar line, for a match that agrees with both poses
AGREEMENT_MIN = 0.5  # share of a photo's matches that agree with its pose


class Pair(NamedTuple):
    """The moments of two photos, their number of matches, and how many agree with both poses."""

    one: int
    other: int
    matches: int
    agreeing: int


def drop_misplaced(model: Any, database: Path) -> list[str]:
    """Remove photos from a reconstruction if most of their matches disagree with their pose.

    Mapping can place a photo by a few wrong points, far from its true pose and still with a small
    reprojection error. In bonsai this was 1 of 98 photos, at three times the capture's extent: 25 %
    of its matches agreed, of other photos' at least 60 % (96 % in the median). The worst photo is
    removed, with its matches, until all agree; photos that a rig took at one moment are removed
    together. Changes `model`, a pycolmap Reconstruction; returns the removed names.
    """
    pairs = verified_pairs(model, database)
    names: dict[int, list[str]] = {}
    for number in model.reg_image_ids():
        names.setdefault(model.image(number).frame_id, []).append(model.image(number).name)
    dropped = []
    while pairs:
        shares = agreement_shares(pairs)
        worst = min(shares, key=lambda moment: (shares[moment], moment))
        if shares[worst] >= AGREEMENT_MIN:
            break
        dropped += sorted(names[worst])
        model.deregister_frame(worst)
        pairs = [pair for pair in pairs if worst not in (pair.one, pair.other)]
    return dropped


def agreement_shares(pairs: list[Pair]) -> dict[int, float]:
    """Return the share of matches that agree, by moment (COLMAP's frame id)."""
    total: dict[int, int] = {}
    agreeing: dict[int, int] = {}
    for pair in pairs:
        for moment in (pair.one, pair.other):
            total[moment] = total.get(moment, 0) + pair.matches
            agreeing[moment] = agreeing.get(moment, 0) + pair.agreeing
    return {moment: agreeing[moment] / total[moment] for moment in total}


def verified_pairs(model: Any, database: Path) -> list[Pair]:
    """Return all pairs of registered photos of different moments with verified matches."""
    pycolmap = load_pycolmap()
    placed = set(model.reg_image_ids())
    cameras, rays = {}, {}
    pairs = []
    with pycolmap.Database.open(database) as content:
        for number in placed:
            cameras[number] = model.cameras[model.image(number).camera_id]
            keypoints = content.read_keypoints(number)[:, :2].astype(np.float64)
            rays[number] = cameras[number].cam_ray_from_img(keypoints)
        numbers, inliers = content.read_two_view_geometry_num_inliers()
        for pair, count in zip(numbers, inliers, strict=True):
            one, other = pycolmap.pair_id_to_image_pair(pair)
            if not count or one not in placed or other not in placed:
                continue
            moments = model.image(one).frame_id, model.image(other).frame_id
            if moments[0] == moments[1]:
                continue
            matches = content.read_two_view_geometry(one, other).inlier_matches
            motion = (
                model.image(other).cam_from_world() * model.image(one).cam_from_world().inverse()
            )
            focal = (cameras[one].mean_focal_length() + cameras[other].mean_focal_length()) / 2
            errors = focal * epipolar_errors(
                rays[one][matches[:, 0]], rays[other][matches[:, 1]], motion.matrix()
            )
            pairs.append(Pair(*moments, len(matches), int((errors < ERROR_MAX).sum())))
    return pairs


def epipolar_errors(
    one: Float[np.ndarray, "m 3"], other: Float[np.ndarray, "m 3"], motion: Float[np.ndarray, "3 4"]
) -> Float[np.ndarray, "m"]:
    """Return how far the rays `one` and `other` of matches are from epipolar planes, in radians.

    `motion` maps coordinates of the first camera to those of the second. This is the Sampson
    distance (Hartley and Zisserman, Multiple View Geometry, section 11.4.3) on the sphere of
    directions instead of the plane z = 1, so that it holds for fisheye lenses, too.
    """
    x, y, z = motion[:, 3]
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ motion[:, :3]
    one, other = (rays / np.linalg.norm(rays, axis=1, keepdims=True) for rays in (one, other))
    ahead, back = one @ essential.T, other @ essential
    error = (other * ahead).sum(1)
    # slopes along the sphere: without the parts of the gradients along the rays
    slopes = (ahead**2).sum(1) + (back**2).sum(1) - 2 * error**2
    return np.abs(error) / np.sqrt(np.maximum(slopes, 1e-30))
