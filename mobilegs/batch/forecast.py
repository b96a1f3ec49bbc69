"""Forecast of a batch: time left, core-hours, GPU-hours and cost, from the stages that are done."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import mean

from mobilegs.batch.task import Stage

HOUR = 3600.0


@dataclass
class Effort:
    """The time that the stages of a row took and will take.

    Attributes:
        group: of rows whose trainings take time in proportion to their sizes.
        size: of the training: its steps or its minutes, as far as the options tell.
        taken: seconds by stage that is done.
        lost: core-seconds and GPU-seconds of tries that failed.
        open: stages that are to come, the running one included.
        elapsed: seconds of the running stage so far.
    """

    group: str = ""
    size: float = 1.0
    taken: dict[Stage, float] = field(default_factory=dict)
    lost: tuple[float, float] = (0.0, 0.0)
    open: Sequence[Stage] = ()
    elapsed: float = 0.0


@dataclass(frozen=True)
class Share:
    """Cores and GPUs of a stage."""

    cores: int
    gpus: int


@dataclass(frozen=True)
class Forecast:
    """Time left, and the hours of the whole list from its beginning to its end."""

    seconds_left: float
    core_hours: float
    gpu_hours: float


def forecast(
    rows: Sequence[Effort],
    shares: dict[Stage, Share],
    cores: int,
    gpus: int,
) -> Forecast | None:
    """Return the forecast for a list on machines with some cores and GPUs in total.

    A stage takes as long as on average in the rows that are done; a training takes that per step
    or minute, of rows of its group if there are any. Returns None until every kind of stage that is
    to come was seen once.
    """
    taken: dict[Stage, list[float]] = {}
    sized: dict[str, list[float]] = {}  # trainings by group, per step or minute
    for row in rows:
        for stage, seconds in row.taken.items():
            taken.setdefault(stage, []).append(seconds)
        if "train" in row.taken:
            sized.setdefault(row.group, []).append(row.taken["train"] / row.size)
    if any(stage not in taken for row in rows for stage in row.open):
        return None

    def expected(row: Effort, stage: Stage) -> float:
        if stage == "train" and row.group in sized:
            return mean(sized[row.group]) * row.size
        return mean(taken[stage])

    left, begun = [], []  # seconds that rows still take, and those of running stages so far
    for row in rows:
        seconds = {stage: expected(row, stage) for stage in row.open}
        for stage in row.open[:1]:
            seconds[stage] = max(seconds[stage] - row.elapsed, 0.0)
            begun.append({stage: row.elapsed})
        left.append(seconds)
    ahead = _total(left, shares)
    longest = max((sum(seconds.values()) for seconds in left), default=0.0)
    wait = max(ahead[0] / max(cores, 1), ahead[1] / gpus if gpus else 0.0, longest)
    whole = _total([*left, *begun, *(row.taken for row in rows)], shares)
    hours = [(whole[i] + sum(row.lost[i] for row in rows)) / HOUR for i in (0, 1)]
    return Forecast(wait, hours[0], hours[1])


def _total(rows: Sequence[dict[Stage, float]], shares: dict[Stage, Share]) -> tuple[float, float]:
    """Return the core-seconds and GPU-seconds of stages."""
    parts = [(shares[stage], seconds) for row in rows for stage, seconds in row.items()]
    return (
        sum((share.cores * seconds for share, seconds in parts), 0.0),
        sum((share.gpus * seconds for share, seconds in parts), 0.0),
    )
