"""Verdicts on the paper's claims, by one rule.

A claim is tested where rows of the paper's own model, which differ in what the claim changes and in
nothing else, had LONG student steps by one teacher on ENOUGH captures. A difference below NOISE
counts as none. The claim is reproduced if each capture has the paper's sign, or none as the paper;
contradicted if no capture has; mixed otherwise.
"""

from collections.abc import Sequence

from bench.paper.claims import Line
from bench.paper.rows import PAPERS, RELEASES

LONG = 10_000  # student steps from which on a comparison counts
ENOUGH = 2  # captures
NOISE = 0.1  # dB
ORDER = "reproduced", "contradicted", "mixed", "not tested"
Deltas = Sequence[float | None]


def own_rows(line: Line) -> tuple[str, ...]:
    """Return the rows of a line that are the paper's own model with one change."""
    own = {name for name, row in (PAPERS | RELEASES).items() if not row.archived}
    return tuple(name for name in line.rows if name in own)


def sign(difference: float) -> int:
    """Return -1, 0 or 1; 0 below the noise."""
    return 0 if abs(difference) < NOISE else int(difference > 0) - int(difference < 0)


def verdict(paper: float, found: Deltas) -> str:
    """Return the verdict on a line, from the differences on each capture (None: not run)."""
    known = [sign(value) == sign(paper) for value in found if value is not None]
    if len(known) < ENOUGH:
        return "not tested"
    if all(known):
        return "reproduced"
    return "mixed" if any(known) else "contradicted"


def verdict_of(lines: Sequence[tuple[float, Deltas]]) -> str:
    """Return the verdict on a claim; where its lines differ, one for each, in their order."""
    each = [verdict(paper, found) for paper, found in lines] or ["not tested"]
    return each[0] if len({*each}) == 1 else "; ".join(each)


def place(told: str) -> int:
    """Return the place of a verdict in the table, the firm ones first."""
    return min(ORDER.index(part) for part in told.split("; "))
