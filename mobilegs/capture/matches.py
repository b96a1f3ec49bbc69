"""Which photos to compare, and what they have in common."""

import warnings
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float, Shaped, UInt8
from scipy.cluster.vq import kmeans2

from mobilegs.atomic import atomic_write
from mobilegs.capture.engine import SEED, Progress, engine, in_background, threads

Pairs = Literal["auto", "all", "alike"]
ALL_UP_TO = 80  # photos: 3,160 pairs
NEIGHBOURS = 10  # next ones by name, and then 16, 32, ... further
LOOK_ALIKES = 20  # a photo, by appearance
AT_ONCE = 100  # pairs between two reports of progress
WORDS = 128
SAMPLES = 400  # features of a photo that the words are learned from
ROUNDS = 10  # of k-means


def match_photos(
    database: Path, names: Sequence[str], *, pairs: Pairs, progress: Progress
) -> dict[str, Any]:
    """Match features between photos, and keep what one camera motion explains.

    `names` are in the order of taking. `all` compares every two photos, `alike` each with its
    neighbours and with those that look like it, `auto` is `all` up to `ALL_UP_TO` photos.
    Pairs that the database holds already are kept. Returns the record
    `{"pairs": which, "compared": number, "verified": number}`.
    """
    chosen = pairs if pairs != "auto" else "all" if len(names) <= ALL_UP_TO else "alike"
    if chosen == "all":
        listed = list(combinations(names, 2))
    else:
        listed = pairs_alike(names, aggregated(descriptors_of(database, names)))
    pycolmap = engine()
    for start in range(0, len(listed), AT_ONCE):
        progress(start, len(listed))
        _match(database, listed[start : start + AT_ONCE])
    progress(len(listed), len(listed))
    with pycolmap.Database.open(database) as content:
        return {
            "pairs": chosen,
            "compared": len(listed),
            "verified": content.num_verified_image_pairs(),
        }


def _match(database: Path, listed: Sequence[tuple[str, str]]) -> None:
    """Match some pairs of photos.

    That is how progress is known: the database must not be looked into meanwhile. Python's SQLite
    and pycolmap's in one process take each other's locks away, which ended in damaged files.
    """
    pycolmap = engine()
    names = database.with_name("pairs.txt")
    atomic_write(names, "".join(f"{one} {other}\n" for one, other in listed))
    matching = pycolmap.FeatureMatchingOptions(num_threads=threads(), use_gpu=False)
    ransac = pycolmap.RANSACOptions(random_seed=SEED)
    in_background(
        lambda token: pycolmap.match_image_pairs(
            database,
            matching_options=matching,
            pairing_options=pycolmap.ImportedPairingOptions(match_list_path=names),
            verification_options=pycolmap.TwoViewGeometryOptions(ransac=ransac),
            device=pycolmap.Device.cpu,
            cancellation_token=token,
        )
    )


def forget_matches(database: Path) -> None:
    """Remove all matches from the database, which keeps cameras and features."""
    if database.exists():
        with engine().Database.open(database) as content:
            content.clear_matches()
            content.clear_two_view_geometries()


def pairs_alike(names: Sequence[str], looks: Float[np.ndarray, "n d"]) -> list[tuple[str, str]]:
    """Each photo with its neighbours in order, nearer and farther, and with its look-alikes."""
    count = len(names)
    steps = [*range(1, NEIGHBOURS + 1)]
    while 2 * steps[-1] < count:
        steps.append(2 * steps[-1])
    chosen = {(i, i + step) for step in steps for i in range(count - step)}
    likeness = looks @ looks.T
    np.fill_diagonal(likeness, -np.inf)
    for i, row in enumerate(likeness):
        nearest = np.argsort(-row, kind="stable")[: min(LOOK_ALIKES, count - 1)]
        chosen |= {(min(i, int(j)), max(i, int(j))) for j in nearest}
    return [(names[i], names[j]) for i, j in sorted(chosen)]


def descriptors_of(database: Path, names: Sequence[str]) -> list[UInt8[np.ndarray, "_ 128"]]:
    """The SIFT descriptors of each photo."""
    with engine().Database.open(database) as content:
        numbers = {image.name: image.image_id for image in content.read_all_images()}
        return [content.read_descriptors(numbers[name]).data for name in names]


def aggregated(descriptors: Sequence[UInt8[np.ndarray, "_ 128"]]) -> Float[np.ndarray, "n d"]:
    """What each photo looks like as one vector of length 1 (VLAD), without any learned file.

    Features are sorted into `WORDS` clusters of this capture's own; a photo is the sum of their
    offsets from the centres, each sum scaled to length 1. COLMAP's vocabulary trees would have to
    be downloaded.
    """
    random = np.random.default_rng(SEED)
    samples = np.concatenate(
        [_unit(photo[random.permutation(len(photo))[:SAMPLES]]) for photo in descriptors]
    )
    words = min(WORDS, len(samples) // 10)
    if not words:
        return np.zeros((len(descriptors), 1), np.float32)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a cluster that lost its members stays
        centres = kmeans2(samples, words, iter=ROUNDS, minit="points", rng=random)[0]
    looks = []
    for photo in map(_unit, descriptors):
        nearest = (photo @ centres.T - 0.5 * (centres * centres).sum(1)).argmax(1)
        sums = np.zeros_like(centres)
        np.add.at(sums, nearest, photo - centres[nearest])
        looks.append(_unit(sums).ravel())
    return _unit(np.stack(looks))


def _unit(rows: Shaped[np.ndarray, "n d"]) -> Float[np.ndarray, "n d"]:
    rows = rows.astype(np.float32)
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-9)
