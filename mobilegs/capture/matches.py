"""Chooses pairs of photos and matches their features."""

import warnings
from collections.abc import Callable, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float, Shaped, UInt8
from scipy.cluster.vq import kmeans2

from mobilegs.atomic import atomic_write
from mobilegs.capture.pycolmap_runtime import SEED, load_pycolmap, threads
from mobilegs.capture.rigs import camera_of, moment_of
from mobilegs.progress_display import Advance

Pairs = Literal["auto", "all", "alike"]
ALL_UP_TO = 80  # photos: 3,160 pairs
NEIGHBOURS = 10  # next photos by name; further neighbours are 20, 40, 80, ... photos away
LOOK_ALIKES = 20  # most similar photos per photo
BATCH = 100  # pairs between two progress updates
WORDS = 128  # visual words of VLAD
SAMPLES = 400  # features per photo from which words are learned
ROUNDS = 10  # of k-means


def match_photos(
    database: Path, names: Sequence[str], *, pairs: Pairs, apart: bool = False, progress: Advance
) -> dict[str, Any]:
    """Match features of photos, and keep matches that agree with one camera motion.

    `names` are in capture order. `pairs` is `all` for every pair, `alike` for each photo
    with its neighbours and its look-alikes, or `auto`, which is `all` up to `ALL_UP_TO` photos.
    `apart` leaves out pairs of one moment, as faces of a panorama share nothing. Pairs in the
    database are kept. Returns the record
    `{"pairs": pairs, "compared": number, "verified": number}`.
    """
    chosen = pairs if pairs != "auto" else "all" if len(names) <= ALL_UP_TO else "alike"
    if chosen == "all":
        listed = list(combinations(names, 2))
    else:
        listed = similar_pairs(names, vlad_vectors(read_descriptors(database, names)))
    if apart:
        listed = [(one, other) for one, other in listed if moment_of(one) != moment_of(other)]
    pycolmap = load_pycolmap()
    for start in range(0, len(listed), BATCH):
        progress(start, len(listed))
        _match(database, listed[start : start + BATCH])
    progress(len(listed), len(listed))
    with pycolmap.Database.open(database) as content:
        return {
            "pairs": chosen,
            "compared": len(listed),
            "verified": content.num_verified_image_pairs(),
        }


def _match(database: Path, listed: Sequence[tuple[str, str]]) -> None:
    """Match a batch of pairs.

    Batches show progress without reading the database meanwhile: Python's SQLite and pycolmap's
    release each other's locks in one process, which has damaged files.
    """
    pycolmap = load_pycolmap()
    names = database.with_name("pairs.txt")
    atomic_write(names, "".join(f"{one} {other}\n" for one, other in listed))
    matching = pycolmap.FeatureMatchingOptions(num_threads=threads(), use_gpu=False)
    ransac = pycolmap.RANSACOptions(random_seed=SEED)
    pycolmap.match_image_pairs(
        database,
        matching_options=matching,
        pairing_options=pycolmap.ImportedPairingOptions(match_list_path=names),
        verification_options=pycolmap.TwoViewGeometryOptions(ransac=ransac),
        device=pycolmap.Device.cpu,
    )


def forget_matches(database: Path) -> None:
    """Remove all matches from the database, which keeps cameras and features."""
    if database.exists():
        with load_pycolmap().Database.open(database) as content:
            content.clear_matches()
            content.clear_two_view_geometries()


def similar_pairs(names: Sequence[str], looks: Float[np.ndarray, "n d"]) -> list[tuple[str, str]]:
    """Pair each photo with near and far neighbours in order, and with its look-alikes.

    Neighbours are those of the same camera of a rig; photos of one moment are pairs, too. `looks`
    are unit vectors `[n, d]`; similarity is their dot product.
    """
    count = len(names)
    chosen: set[tuple[int, int]] = set()
    for photos in grouped(names, camera_of):
        offsets = [*range(1, NEIGHBOURS + 1)]
        while 2 * offsets[-1] < len(photos):
            offsets.append(2 * offsets[-1])
        for offset in offsets:
            chosen |= set(zip(photos, photos[offset:], strict=False))
    for photos in grouped(names, moment_of):
        chosen |= set(combinations(photos, 2))
    similarity = looks @ looks.T
    np.fill_diagonal(similarity, -np.inf)
    for i, row in enumerate(similarity):
        nearest = np.argsort(-row, kind="stable")[: min(LOOK_ALIKES, count - 1)]
        chosen |= {(min(i, int(j)), max(i, int(j))) for j in nearest}
    return [(names[i], names[j]) for i, j in sorted(chosen)]


def grouped(names: Sequence[str], key: Callable[[str], str]) -> list[list[int]]:
    """Return the indices of the names with each key, in order."""
    groups: dict[str, list[int]] = {}
    for index, name in enumerate(names):
        groups.setdefault(key(name), []).append(index)
    return list(groups.values())


def read_descriptors(database: Path, names: Sequence[str]) -> list[UInt8[np.ndarray, "_ 128"]]:
    with load_pycolmap().Database.open(database) as content:
        numbers = {image.name: image.image_id for image in content.read_all_images()}
        return [content.read_descriptors(numbers[name]).data for name in names]


def vlad_vectors(descriptors: Sequence[UInt8[np.ndarray, "_ 128"]]) -> Float[np.ndarray, "n d"]:
    """Describe each photo by one unit vector (VLAD, Jegou et al. 2010).

    k-means finds `WORDS` clusters of this capture's features. A photo's vector has the sum of its
    features' offsets from each cluster centre, every sum scaled to length 1. This needs no
    download, unlike COLMAP's vocabulary trees.
    """
    random = np.random.default_rng(SEED)
    samples = np.concatenate(
        [_unit(photo[random.permutation(len(photo))[:SAMPLES]]) for photo in descriptors]
    )
    words = min(WORDS, len(samples) // 10)
    if not words:
        return np.zeros((len(descriptors), 1), np.float32)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # an empty cluster keeps its centre
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
