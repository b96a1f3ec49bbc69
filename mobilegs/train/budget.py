"""A budget of time: a plan for a run of given minutes, and the pace that keeps to it.

The plan is made once, from a few timed steps on this machine: size of the photos, number of
Gaussians, steps. While the run goes on, `Pace` changes the number of steps at a few points, so
that the time comes out right. Every change is kept with the plan, and a run that repeats the plan
repeats the changes: its result does not depend on the speed of its machine.
"""

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol, runtime_checkable

import torch

from mobilegs.data.dataset import Dataset, ViewLoader
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.progress_display import ProgressLines, line_stream
from mobilegs.train.distributed import Team
from mobilegs.train.memory import free_memory, needed_memory
from mobilegs.train.recipes import Recipe, with_length
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.silhouettes import shown_share
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from mobilegs.train.threads import torch_on_one_thread

TEACHER_SHARE = {"cpu": 0.45, "cuda": 0.35}  # of the time
# Fractions of a stage's steps or of its time, whichever comes first, after which the number of
# steps is corrected. Later the student quantises, and the teacher has a tenth of its time left.
CORRECTION_TIMES = {"teacher": (0.5, 0.7, 0.9), "student": (0.05, 0.3, 0.55, 0.8)}
SPLATS_PER_PIXEL = 0.6  # maximum number of Gaussians per pixel that is not transparent
SPLATS_MIN, SPLATS_MAX = 20_000, 500_000  # limits of this maximum; 500,000 are a file of 5 MB
# Bytes per Gaussian of the teacher, of which the student prunes some. More Gaussians in a file of
# the same size have coarser step sizes, and worse pictures (docs/explanation/compression.md).
FILE_BYTES_PER_SPLAT = 12.0
SPLAT_FRACTIONS = (1.0, 0.7, 0.5, 0.35)  # of the maximum, in the order in which they are tried
PIXELS_MIN = 300 * 200  # of a photo
# Steps of the student per square root of a minute. A plan with more of them gives its time to
# pixels and Gaussians instead.
ENOUGH_STEPS = 650
STEPS_MIN = 500  # of each stage
MEMORY_SHARE = 0.8  # of the free memory that a plan uses
MEMORY_MAX = 1 << 50  # bytes
INIT_SHARE = 0.7  # ratio of initial Gaussians to their maximum
# Ratios of times: a teacher's step (mean over the run) to a timed one, a student's step to a
# teacher's, and the evaluation of a held-back photo to a timed step.
TEACHER_STEP_RATIO = {"cpu": 0.7, "cuda": 1.3}
STUDENT_STEP_RATIO = {"cpu": 0.95, "cuda": 3.5}
EVALUATION_RATIO = 2.0
# Finding the first view, sorting into LOD levels and writing take the time of FINISH_STEPS steps
# on images without pixels, of a scene with FINISH_SPLATS more Gaussians.
FINISH_STEPS = {"cpu": 220, "cuda": 1000}
FINISH_SPLATS = 50_000
TIMED_STEPS = 5  # at each of two sizes, after one that warms up
TIMED_SPLATS = 150_000  # at least
SPEED_STEPS = 100  # last steps, whose mean time predicts that of the others
SPEED_STEPS_MIN = 50  # timed steps before the time can cause a correction
LEFT_RATIO_MIN, LEFT_RATIO_MAX = 0.25, 4.0  # of the steps left after a correction to those before


@dataclass(frozen=True)
class Correction:
    """A change of the number of steps of stage `stage` to `steps`, after its step `at`."""

    stage: str
    at: int
    steps: int


@dataclass(frozen=True)
class Plan:
    """The time of a run, and how its steps were fitted to it.

    Attributes:
        minutes: what the person asked for.
        seconds: of them, those of training: without reading the capture, writing and measuring.
        teacher_share: of these seconds, the fraction for the teacher.
        corrections: changes of the numbers of steps so far.
        final: True if no further correction may be added, since the run repeats another.
        free_memory: bytes that were free, if the plan chose less for them or may need more; else 0.
        needed_memory: bytes that the run takes at most.
    """

    minutes: float
    seconds: float
    teacher_share: float = TEACHER_SHARE["cpu"]
    corrections: tuple[Correction, ...] = ()
    final: bool = False
    free_memory: int = 0
    needed_memory: int = 0

    def deadline(self, stage: str) -> float:
        """Return the seconds of training after which a stage should end."""
        return self.seconds * (self.teacher_share if stage == "teacher" else 1.0)

    @property
    def memory_note(self) -> str:
        """A clause about the memory of the run, or nothing if there is enough."""
        free, needed = 1e-9 * self.free_memory, 1e-9 * self.needed_memory
        if not free:
            return ""
        if needed > free:
            return f"; this can take {needed:.1f} GB of memory, and {free:.1f} GB are free"
        return f"; more Gaussians or larger photos would not fit into {free:.1f} GB of free memory"

    def as_json(self) -> dict[str, Any]:
        """Return the plan as JSON data."""
        corrections = [[each.stage, each.at, each.steps] for each in self.corrections]
        return {**vars(self), "corrections": corrections}

    @staticmethod
    def from_json(content: Any) -> "Plan":
        """Return the plan from a result of `as_json`; raises InputError if it is damaged."""
        try:
            corrections = tuple(
                Correction(str(stage), int(at), int(steps))
                for stage, at, steps in content["corrections"]
            )
            minutes, seconds = float(content["minutes"]), float(content["seconds"])
            share = float(content["teacher_share"])
            memory = (int(content[f"{name}_memory"]) for name in ("free", "needed"))
            return Plan(minutes, seconds, share, corrections, bool(content["final"]), *memory)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"its plan is damaged ({error})") from error


class Speed(NamedTuple):
    """Seconds of a teacher's step on this machine: for each Gaussian, each pixel, and always."""

    per_splat: float
    per_pixel: float
    always: float = 0.0

    def step(self, splats: int, pixels: int) -> float:
        """Return the seconds of a step with `splats` Gaussians and a photo of `pixels`."""
        return self.per_splat * splats + self.per_pixel * pixels + self.always


def measured_speed(config: TeacherConfig, dataset: Dataset, team: Team) -> Speed:
    """Time a few steps of a teacher with the photos' size, and with half of it.

    The Gaussians are as many as a scene has after densification, and as small. The result is the
    same in all processes: that of the first one.
    """
    times, views = [], []
    first = Teacher(config, dataset, seed=0, device=torch.device("cpu")).gaussians()
    start = divided(first, TIMED_SPLATS).to(team.device)
    splats = len(start)
    with ViewLoader(dataset.train) as loader:
        for index in view_order(len(loader), 0, TIMED_STEPS + 1, 0):
            views.append((index, loader.get(index, team.device)))
    for divisor in (1, 2):
        timed = replace(config, first_divisor=divisor, views_per_step=1)
        stage = Teacher(timed, dataset, seed=0, device=team.device, start=start)
        stage.advance(views[:1])  # warms up
        started = _now(team.device)
        for view in views[1:]:
            stage.advance([view])
        times.append((_now(team.device) - started) / TIMED_STEPS)
    speed = speed_of(times, splats, pixels_of(dataset), gpu=team.device.type == "cuda")
    [units, *_] = team.all_gather_ints(*(round(1e15 * seconds) for seconds in speed))
    return Speed(*(1e-15 * unit for unit in units))


def speed_of(times: Sequence[float], splats: int, pixels: int, *, gpu: bool) -> Speed:
    """Return the speed that follows from the seconds of a step with all pixels and a quarter.

    A GPU waits for Python most of the time, so a step there does not depend on the Gaussians.
    """
    of_pixels = max((times[0] - times[1]) * 4 / 3, 0.05 * times[0])
    rest = max(times[0] - of_pixels, 0.05 * times[0])
    if gpu:
        return Speed(0.0, of_pixels / pixels, rest)
    return Speed(rest / splats, of_pixels / pixels)


def divided(gaussians: Gaussians, count: int) -> Gaussians:
    """Return at least `count` Gaussians, which cover about what the given ones cover.

    Each becomes several within its ellipsoid, smaller by the square root of their number.
    """
    parts = math.ceil(count / len(gaussians))
    if parts == 1:
        return gaussians
    copies = gaussians.select(torch.arange(len(gaussians)).repeat_interleave(parts))
    offsets = torch.randn(copies.means.shape, generator=torch.Generator().manual_seed(0))
    copies.means += copies.log_scales.exp() * offsets
    copies.log_scales -= 0.5 * math.log(parts)
    return copies


def _now(device: torch.device) -> float:
    if device.type == "cuda":
        torch.cuda.synchronize(device)
    return time.perf_counter()


class _Choice(NamedTuple):
    """A size of photos and a number of Gaussians, with steps of both stages and memory."""

    seconds: float
    downscale: int | None
    splats: int
    teacher: float
    student: float
    bytes: int


@dataclass(frozen=True)
class Planned:
    """A plan and its choices: the recipe, and the divisor of the photos' size."""

    plan: Plan
    recipe: Recipe
    downscale: int | None


def make_plan(
    recipe: Recipe,
    minutes: float,
    load: Callable[[int | None], Dataset],
    *,
    downscale: int | None,
    max_splats: int | None,
    given: int,
    team: Team,
    started: float,
) -> Planned:
    """Choose the size of the photos, the number of Gaussians and the steps of a run.

    Args:
        recipe: all other settings.
        minutes: of the whole run, from `started` on, a value of `time.monotonic()`.
        load: returns the capture with photos of a size divided by n, or of the usual size (None).
        downscale, max_splats: given by the person, or None.
        given: number of Gaussians of a trained teacher, or 0 if there is none.
        team: the processes that train.
    """
    device = team.device.type
    dataset = load(downscale)
    lines = ProgressLines("timing a few steps", line_stream() if team.is_main else None)
    with lines, torch_on_one_thread():  # as a teacher trains
        speed = measured_speed(recipe.teacher, dataset, team)
    seconds = 60 * minutes - (time.monotonic() - started)
    [[seconds], *_] = team.all_gather_ints(round(seconds))
    free = math.inf if device == "cuda" else MEMORY_SHARE * free_memory() / team.on_this_machine
    [[free], *_] = team.all_gather_ints(round(min(free, MEMORY_MAX)))
    target = recipe.student.quantization.target_mb
    limit = min(SPLATS_MAX, 1e6 * target / FILE_BYTES_PER_SPLAT) if target else SPLATS_MAX
    share = 0.0 if given else TEACHER_SHARE[device]
    sizes = [(downscale, pixels_of(dataset))]
    if downscale is None and not given:
        sizes += smaller_sizes(load, sizes[0][1])
    per_pixel = SPLATS_PER_PIXEL * shown_share(dataset.train)
    stages = (recipe.teacher, recipe.student)
    views = [max(1, stage.views_per_step // team.world_size) for stage in stages]
    choices = []
    for n, pixels in sizes:
        most = round(min(max(per_pixel * pixels, SPLATS_MIN), limit))
        fixed = given or max_splats
        counts = [fixed] if fixed else [round(f * most) for f in SPLAT_FRACTIONS]
        for splats in counts:
            reserve = EVALUATION_RATIO * len(dataset.test) * speed.step(splats, pixels)
            reserve += FINISH_STEPS[device] * speed.step(splats + FINISH_SPLATS, 0)
            left = max(seconds - reserve, 0.5 * seconds)
            each = TEACHER_STEP_RATIO[device] * speed.step(splats, pixels)
            teacher = share * left / (each * views[0])
            student = (1 - share) * left / (STUDENT_STEP_RATIO[device] * each * views[1])
            bytes = needed_memory(
                recipe.student, photos=len(dataset.train), pixels=pixels, splats=splats
            )
            choices.append(_Choice(left, n, splats, teacher, student, bytes))
    enough = ENOUGH_STEPS * math.sqrt(minutes)
    fitting = [each for each in choices if each.bytes <= free] or choices[-1:]
    # the first with enough steps, or else the smallest
    best, chosen = (
        next((c for c in some if c.student >= enough), some[-1]) for some in (choices, fitting)
    )
    left, n, splats = chosen.seconds, chosen.downscale, chosen.splats
    teacher, student = (max(STEPS_MIN, round(c)) for c in (chosen.teacher, chosen.student))
    initial = max(1, round(INIT_SHARE * splats))
    sized = replace(recipe.teacher, max_splats=splats, init_splats=initial)
    planned = Recipe(with_length(sized, teacher), replace(recipe.student, steps=student))
    limited = chosen != best or chosen.bytes > free
    plan = Plan(
        minutes,
        left,
        share,
        free_memory=round(free / MEMORY_SHARE) if limited else 0,
        needed_memory=chosen.bytes,
    )
    return Planned(plan, planned, n)


def pixels_of(dataset: Dataset) -> int:
    """Return the number of pixels of the capture's first photo."""
    camera = dataset.train[0].camera
    return camera.width * camera.height


def smaller_sizes(
    load: Callable[[int | None], Dataset], pixels: int
) -> list[tuple[int | None, int]]:
    """Return divisors of the photos' size with numbers of pixels below `pixels`, largest first."""
    original, sizes = load(1).train[0].camera, []
    for n in range(2, 17):
        width, height = original.width // n, original.height // n
        if width * height < PIXELS_MIN:
            break
        if width * height < 0.9 * pixels:
            sizes.append((n, width * height))
    return sizes


@runtime_checkable
class Paced(Protocol):
    """The part of a stage that a pace needs; see `Stage`."""

    name: str
    done: int

    @property
    def steps(self) -> int:
        """Number of steps in total."""
        ...

    def set_steps(self, steps: int, at: int) -> None:
        """Change the number of steps in total, when `at` of them are done."""
        ...


class Pace:
    """Fits the steps of a stage to the time that is left, and repeats earlier fits."""

    def __init__(self, plan: Plan, save: Callable[[Plan], None]) -> None:
        """Begin with `plan`; `save` receives each plan with one more correction."""
        self.plan, self.save = plan, save
        self.times: deque[float] = deque(maxlen=SPEED_STEPS + 1)

    def before(self, stage: Paced) -> None:
        """Begin or resume a stage."""
        self.times.clear()
        self.began: float | None = None
        self.checks = list(CORRECTION_TIMES[stage.name])
        for each in self.plan.corrections:
            if each.stage == stage.name and each.at <= stage.done:
                self._apply(stage, each)

    def after_step(self, stage: Paced, elapsed: float, team: Team) -> None:
        """Change the stage's steps if it is time to; `elapsed` are seconds of training."""
        self.times.append(elapsed)
        for each in self.plan.corrections:
            if each.stage == stage.name and each.at == stage.done:
                self._apply(stage, each)
                return
        if self.began is None:
            self.began = elapsed
        if self.plan.final or not self.checks or len(self.times) < 2:
            return
        if any(c.stage == stage.name and c.at > stage.done for c in self.plan.corrections):
            return  # changes of a run that was killed come first
        deadline = self.plan.deadline(stage.name)
        spent = (elapsed - self.began) / max(deadline - self.began, 1e-9)
        late = spent >= self.checks[0] and len(self.times) > SPEED_STEPS_MIN
        [[late], *_] = team.all_gather_ints(late)
        if stage.done < self.checks[0] * stage.steps:
            if not late:
                return
            self.checks = self.checks[1:]
        each = (self.times[-1] - self.times[0]) / (len(self.times) - 1)
        left = stage.steps - stage.done
        fitting = math.floor((deadline - elapsed) / max(each, 1e-9))
        steps = stage.done + min(
            max(fitting, math.ceil(LEFT_RATIO_MIN * left)), math.floor(LEFT_RATIO_MAX * left)
        )
        [[steps], *_] = team.all_gather_ints(max(steps, stage.done + 1))
        correction = Correction(stage.name, stage.done, steps)
        self.plan = replace(self.plan, corrections=(*self.plan.corrections, correction))
        self.save(self.plan)
        self._apply(stage, correction)

    def _apply(self, stage: Paced, correction: Correction) -> None:
        stage.set_steps(correction.steps, correction.at)
        self.checks = [f for f in self.checks if f * stage.steps > stage.done]
