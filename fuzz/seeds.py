"""The valid files of every kind, from which the targets start."""

from collections.abc import Callable
from pathlib import Path

from fuzz import captures
from tests.fuzz.campaign import SEEDS as SCENE_SEEDS
from tests.fuzz.seeds import Seed, mgs_seeds

CONFORMANCE = Path(__file__).parents[1] / "tests" / "mgs" / "conformance"
LONGEST = 6_000  # bytes of a conformance file: longer ones are slow


def with_conformance() -> dict[str, Seed]:
    """Return the `.mgs` of `mgs_seeds`, and the conformance files."""
    files = {path.name: path.read_bytes() for path in sorted(CONFORMANCE.glob("*.mgs"))}
    return mgs_seeds() | {n: Seed(data) for n, data in files.items() if len(data) <= LONGEST}


SEEDS: dict[str, Callable[[], dict[str, Seed]]] = {
    **SCENE_SEEDS,
    "mgs": with_conformance,
    **captures.SEEDS,
}
