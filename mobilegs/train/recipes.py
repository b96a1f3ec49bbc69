"""Recipes: all settings of a training, with presets: demo, short, long, paper and release."""

import json
import math
import typing
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace
from difflib import get_close_matches
from typing import Any, Literal

from mobilegs.errors import InputError, quoted
from mobilegs.representation.codebooks import CodebookSizes
from mobilegs.train.optim import exponential_lr
from mobilegs.train.student.config import (
    QuantizationConfig,
    StudentConfig,
    StudentLearningRates,
)
from mobilegs.train.student.vote_pruning import VoteConfig
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.mini_splatting import MiniSplattingConfig
from mobilegs.train.teacher.trainer import TeacherConfig, TeacherLearningRates

NUMBER_MAX = 1e15  # of a setting in a file
PresetName = Literal["demo", "short", "long", "paper", "release"]
MethodName = Literal["3dgs", "mini-splatting", "mcmc"]
SHORT_STEPS, LONG_STEPS = 5000, 30_000  # steps of a teacher
# For teachers of up to SHORT_STEPS: they reach 30.12 dB on bonsai at 400x267 with 60,000 Gaussians.
# The rates of 3DGS, which are for LONG_STEPS, reach 28.69 dB, and 29.75 dB after 10,000 steps.
SHORT_RATES = TeacherLearningRates(
    means=8e-4,
    quats=6e-3,
    scales=0.02,
    opacities=0.1,
    sh0=0.01,
    sh_rest=2e-3,
    final_factor=0.1,
)
# For teachers of LONG_STEPS and more: those of 3DGS, but for harmonics and the fall. On bonsai at
# 800x533 these two are worth 0.24 dB (docs/guides/training.md).
LONG_RATES = TeacherLearningRates(sh_rest=1e-3, final_factor=0.1)
# Start of densification, later than in 3DGS: the demo's teacher reaches 28.60 dB, not 28.54.
LATE_START = 0.02
# For budgets of some ten thousand Gaussians: fewer before sampling, a full budget after it.
SMALL_BUDGET = MiniSplattingConfig(
    peak_splats=1.8, reinit_splats=1.5, sampled=1.0, trim_keeps=0.999
)


@dataclass(frozen=True)
class Recipe:
    """All settings that a training depends on, except for the capture and the seed."""

    teacher: TeacherConfig = field(default_factory=TeacherConfig)
    """The teacher's training."""
    student: StudentConfig = field(default_factory=StudentConfig)
    """The student's training."""


def long_recipe() -> Recipe:
    """Return the preset `long`: 30,000 + 30,000 steps and Mini-Splatting, as in the paper.

    It is meant for a GPU.
    """
    return Recipe(
        TeacherConfig(densify=DensifyConfig(strategy="mini_splatting")),
        StudentConfig(
            lr=StudentLearningRates(
                final_factor=0.3,
                decay_from=0.65,
                # so that step sizes move as far as in the shorter runs that were measured
                step_sizes=4e-4,
            ),
        ),
    )


def short_recipe() -> Recipe:
    """Return the preset `short`: 5,000 + 5,000 steps and at most 60,000 Gaussians.

    On two cores it takes about 6 minutes for photos of 400x267 (bench/results/captures.json).
    """
    return Recipe(
        TeacherConfig(
            steps=5000,
            first_divisor=4,
            max_splats=60_000,
            init_splats=40_000,
            far_splats=3000,
            far_visibility=0.2,
            sh_every=16,
            lr=rates_for(5000),
            # without large Gaussians, a small budget leaves holes in the background
            densify=DensifyConfig(start=LATE_START, prune_scale=0.0),
            mini_splatting=SMALL_BUDGET,
        ),
        StudentConfig(
            steps=5000,
            lr=StudentLearningRates(
                means=1e-4,
                quats=2e-3,
                sh0=5e-3,
                sh_rest=1e-3,
                color_latents=0.01,
                lobes=0.08,
                network=8e-3,
                quantized_factor=0.5,
            ),
            pruning=VoteConfig(votes_per_interval=8),
        ),
    )


def demo_recipe() -> Recipe:
    """Return the recipe of `mobilegs demo`, for its synthetic capture: 2,000 + 2,200 steps."""
    return Recipe(
        TeacherConfig(
            steps=2000,
            first_divisor=2,
            max_splats=20_000,
            init_splats=15_000,
            far_splats=2000,
            far_visibility=0.2,
            densify=DensifyConfig(start=LATE_START, min_interval=40, prune_scale=0.0),
            mini_splatting=SMALL_BUDGET,
        ),
        StudentConfig(
            steps=2200,
            lr=StudentLearningRates(  # high, since the run is short
                means=3e-4,
                scales=0.01,
                quats=3e-3,
                sh_rest=1e-3,
                color_latents=5e-3,
                lobes=0.05,
                network=7e-3,
                quantized_factor=0.5,
            ),
            quantization=QuantizationConfig(codebooks=CodebookSizes(rotation=256, appearance=512)),
            pruning=VoteConfig(votes_per_interval=4),
        ),
    )


# The footprint of 3DGS, as settings.
CLASSIC_TEACHER = (
    "teacher.footprint.blur=0.3",
    "teacher.footprint.antialiased=false",
    "teacher.least_variance=0",
)
CLASSIC_STUDENT = (
    "student.footprint.blur=0.3",
    "student.footprint.antialiased=false",
    "student.footprint.soft_edge=false",
    "student.least_variance=0",
    "student.level_sigma=0",
    "student.weighting.depth_pass=false",
)
# The paper's student, by its text; where the text is silent, by its release. Learning rates and
# lengths are apart, so that shorter runs can have their own.
PAPER = (
    *CLASSIC_STUDENT,
    "student.weighting.exponent_max=80",
    f"student.weighting.alpha_min={1 / 255}",
    "student.color.decoder=latent_networks",
    "student.view_dependence.kind=network",
    "student.view_dependence.start_opacity=0.5",
    "student.lr.opacities=0",
    "student.loss.depth_weight=0.1",
    "student.loss.virtual_view_every=0",
    "student.loss.front_weight=0",
    "student.loss.overdraw_weight=0",
    "student.exposure.learned=never",
    "student.loss.mask_depth=false",
    "student.quantization.round_means=false",
    "student.pruning.votes_per_interval=1000",
    f"student.pruning.until={25 / 30}",
    "student.views_per_step=3",
    "student.quantization.method=nvq",
    "student.quantization.codebooks.weight_by_size=false",
    "student.quantization.codebooks.scale=64",
    "student.quantization.codebooks.rotation=512",
    "student.quantization.codebooks.appearance=1024",
    "student.quantization.codebooks.opacity=1",
    f"student.schedule.latents_from={5 / 30}",
    f"student.schedule.quantize_from={29 / 30}",
    "student.schedule.rate_from=1",
    "student.schedule.reassign_every=0",
)
# The student of the release, with its errors as far as settings reach.
RELEASE = (
    *PAPER,
    "student.color.decoder=networks",
    "student.weighting.detached=true",
    "student.loss.depth_weight=0.2",
    "student.schedule.keep_moments=false",
    "student.pruning.until=0.8",
    "student.views_per_step=1",
    "student.lr.codebook_factor=0",
    "student.lr.quantized_factor=0",
)
# Learning rates and the teacher of both: the release's constant rates, and Mini-Splatting itself.
LONG = (
    *CLASSIC_TEACHER,
    "teacher.min_views=0",
    "teacher.exposure.learned=never",
    "teacher.init_splats=10000000",
    "student.lr.means_max=1e9",
    "student.lr.final_factor=1",
    "student.lr.network=1e-3",
)


def paper_recipe() -> Recipe:
    """Return the paper's recipe: 30,000 + 30,000 steps, its choices in place of this project's."""
    return with_settings(long_recipe(), (*PAPER, *LONG))


def release_recipe() -> Recipe:
    """Return the recipe of the paper's release, with its errors as far as settings reach."""
    return with_settings(long_recipe(), (*RELEASE, *LONG))


RECIPES: dict[PresetName, Callable[[], Recipe]] = {
    "demo": demo_recipe,
    "short": short_recipe,
    "long": long_recipe,
    "paper": paper_recipe,
    "release": release_recipe,
}


def with_method(recipe: Recipe, method: MethodName) -> Recipe:
    """Return the recipe with the teacher trained by `method`, with its paper's settings.

    Steps and numbers of Gaussians stay. `mcmc` starts from Gaussians of the usual size and opacity:
    with those of its paper, a tenth as large, short runs never fill the background.
    """
    teacher = replace(recipe.teacher, lr=TeacherLearningRates(), first_divisor=1, sh_every=1)
    densify = replace(teacher.densify, start=DensifyConfig().start)
    if method == "3dgs":
        densify = replace(densify, strategy="clone_split", opacity_reset=0.1)
    elif method == "mini-splatting":
        densify = replace(densify, strategy="mini_splatting")
    else:
        densify = replace(densify, strategy="mcmc")
    return replace(recipe, teacher=replace(teacher, densify=densify))


def rates_for(steps: int) -> TeacherLearningRates:
    """Return the learning rates of a teacher of `steps` that clones and splits.

    They lie between SHORT_RATES and LONG_RATES, evenly in the logarithms of steps and rates.
    """
    share = math.log(max(steps, 1) / SHORT_STEPS) / math.log(LONG_STEPS / SHORT_STEPS)
    few, many = SHORT_RATES, LONG_RATES
    if not 0 < share < 1:
        return few if share <= 0 else many
    return TeacherLearningRates(
        **{
            each.name: exponential_lr(getattr(few, each.name), getattr(many, each.name), share)
            for each in fields(few)
        }
    )


def with_length(teacher: TeacherConfig, steps: int) -> TeacherConfig:
    """Return the settings of a teacher of `steps`, with other rates if they follow the steps."""
    follows = teacher.densify.strategy == "clone_split" and teacher.lr == rates_for(teacher.steps)
    lr = rates_for(steps) if follows else teacher.lr
    return replace(teacher, steps=steps, lr=lr)


def with_steps(recipe: Recipe, steps: int) -> Recipe:
    """Return the recipe with `steps` in total, in the same proportion of teacher and student.

    Raises InputError if that leaves a stage without a step.
    """
    if steps < 2:
        raise InputError(f"{steps} steps are too few: teacher and student need one each")
    before = recipe.teacher.steps + recipe.student.steps
    teacher = min(max(1, round(steps * recipe.teacher.steps / before)), steps - 1)
    return Recipe(
        with_length(recipe.teacher, teacher), replace(recipe.student, steps=steps - teacher)
    )


def with_settings(recipe: Recipe, settings: Iterable[str]) -> Recipe:
    """Return the recipe with fields changed by their paths, as in `student.lr.opacities=0.02`.

    All settings are applied at once, so their order does not matter; of two for the same field the
    last one counts. Raises InputError if there is no such field, if the value has another type than
    its default, or if the settings contradict each other.
    """
    changes: dict[str, Any] = {}
    for setting in settings:
        path, equals, text = setting.partition("=")
        if not equals:
            raise InputError(f"'{setting}' sets nothing: write it like student.lr.opacities=0.02")
        try:
            value = json.loads(text)
        except json.JSONDecodeError:
            value = text
        path = path.strip().replace("-", "_")
        *parents, name = path.split(".")
        inner, config = changes, recipe
        for parent in parents:
            config = _field(config, parent, setting, recipe)
            inner = inner.setdefault(parent, {})
        old = _field(config, name, setting, recipe)
        inner[name] = _like(old, value, setting, typing.get_type_hints(type(config))[name])
    return _replaced(recipe, changes)


def _field(config: Any, name: str, setting: str, recipe: Recipe) -> Any:
    """Return the field `name` of `config`, a part of `recipe`, for the path in `setting`."""
    if not is_dataclass(config):
        raise InputError(f"'{setting}' names no setting: there is no '{name}' below a value")
    known = [f.name for f in fields(config)]
    if name not in known:
        near = get_close_matches(name, known)
        near = near or [path for path in _paths(recipe) if path.split(".")[-1] == name]
        hint = f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(known)}"
        raise InputError(f"'{setting}' names no setting, as there is no '{name}': {hint}")
    return getattr(config, name)


def _paths(config: Any, prefix: str = "") -> Iterator[str]:
    """Yield the paths of all settings."""
    for each in fields(config):
        value = getattr(config, each.name)
        if is_dataclass(value):
            yield from _paths(value, f"{prefix}{each.name}.")
        else:
            yield f"{prefix}{each.name}"


def _like(old: Any, value: Any, setting: str, hint: Any) -> Any:
    """Return `value` with the type of `old`; raise InputError if it has another one."""
    names = typing.get_args(hint) if typing.get_origin(hint) is Literal else (value,)
    if value not in names:
        raise InputError(f"'{setting}' is none of {', '.join(names)}")
    right = type(old) is type(value) or (type(old), type(value)) == (float, int)
    if is_dataclass(old) or not right:
        raise InputError(f"'{setting}' does not have the type of its default, {old!r}")
    return type(old)(value)


def _replaced(config: Any, changes: dict[str, Any], path: str = "") -> Any:
    """Return the dataclass with all changes applied at once, those of inner dataclasses first."""
    inner = {
        name: _replaced(getattr(config, name), value, f"{path}{name}.")
        if isinstance(value, dict)
        else value
        for name, value in changes.items()
    }
    try:
        return replace(config, **inner)
    except InputError as error:
        raise InputError(f"in {path.rstrip('.')}, {error}") from None


def from_json(kind: type, content: Any) -> Any:
    """Return a dataclass of type `kind` from the dictionary that `dataclasses.asdict` made of it.

    Raises InputError if fields are missing or unknown: another version wrote it; and if a value has
    another type than its field, or is a number too large to compute with.
    """
    names = {f.name for f in fields(kind)}
    if not isinstance(content, dict) or content.keys() != names:
        raise InputError(
            f"a {kind.__name__} of another version of this program was saved here: "
            "continue the run with the version that started it"
        )
    hints = typing.get_type_hints(kind)
    return kind(
        **{
            name: from_json(hints[name], value)
            if is_dataclass(hints[name])
            else _of_type(hints[name], value, name)
            for name, value in content.items()
        }
    )


def _of_type(hint: Any, value: Any, name: str) -> Any:
    """Return a JSON value for a field of the type `hint`. Raises InputError for another type."""
    if typing.get_origin(hint) is Literal:
        right = value in typing.get_args(hint)
    else:
        right = type(value) is hint or (hint is float and type(value) is int)
    if not right or (isinstance(value, int | float) and not abs(value) < NUMBER_MAX):
        raise InputError(f"{name} cannot be {quoted(value)}")
    return value
