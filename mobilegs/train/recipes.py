"""Recipes: how long, how many, how fast, for a two-core laptop, a GPU, or a demonstration."""

import json
import typing
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from difflib import get_close_matches
from typing import Any, Literal

from mobilegs.errors import InputError
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.mask_pruning import PresenceConfig
from mobilegs.train.student.vote_pruning import VoteConfig
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.mini_splatting import MiniSplattingConfig
from mobilegs.train.teacher.trainer import TeacherConfig

PresetName = Literal["cpu", "gpu", "demo"]
MethodName = Literal["3dgs", "mini-splatting", "mcmc"]
# densifying a little after 3DGS's own start: 28.60 dB instead of 28.54 for the demo's teacher
LATER = 0.02
# for budgets of some ten thousand Gaussians: less time before the draw, and a budget that is used
FEW = MiniSplattingConfig(peak_splats=1.8, reinit_splats=1.5, sampled=1.0, trim_keeps=0.999)


@dataclass(frozen=True)
class Recipe:
    """Everything that decides what a training does, the capture and the seed aside."""

    teacher: TeacherConfig = field(default_factory=TeacherConfig)
    """The teacher's training."""
    student: StudentConfig = field(default_factory=StudentConfig)
    """The student's training."""


def gpu_recipe() -> Recipe:
    """The paper's lengths, 30,000 + 30,000 steps, and its teacher, for a graphics card."""
    return Recipe(
        TeacherConfig(densify=DensifyConfig(strategy="mini_splatting")),
        StudentConfig(
            net_fraction=5 / 30,
            final_rate=0.3,
            decay_from=0.65,
            # steps and masks then move as far as in the shorter runs that were measured
            step_rate=4e-4,
            presence=PresenceConfig(rate=0.01),
        ),
    )


def cpu_recipe() -> Recipe:
    """Two cores, some 15 minutes for photos of 400x266: 5,000 + 5,000 steps, 60,000 Gaussians."""
    return Recipe(
        TeacherConfig(
            steps=5000,
            max_splats=60_000,
            init_splats=40_000,
            # few Gaussians must cover what is far away: removing the large ones leaves holes
            densify=DensifyConfig(start=LATER, prune_scale=0.0),
            mini_splatting=FEW,
        ),
        StudentConfig(
            steps=5000,
            position_rate=1e-4,
            quat_rate=2e-3,
            sh_rest_rate=5e-4,
            latent_rate=5e-3,
            lobe_rate=0.04,
            lobe_codebook_rate=0.02,
            network_rate=4e-3,
            free_share=0.5,
            votes=VoteConfig(votes_per_interval=8),
        ),
    )


def demo_recipe() -> Recipe:
    """Minutes on two cores, for the small capture that the package renders itself."""
    return Recipe(
        TeacherConfig(
            steps=2000,
            max_splats=20_000,
            init_splats=15_000,
            densify=DensifyConfig(start=LATER, min_interval=40, prune_scale=0.0),
            mini_splatting=FEW,
        ),
        StudentConfig(
            steps=3400,
            # a short run needs a quick student
            position_rate=3e-4,
            scale_rate=0.01,
            quat_rate=3e-3,
            sh_rest_rate=1e-3,
            latent_rate=5e-3,
            lobe_rate=0.05,
            lobe_codebook_rate=0.02,
            network_rate=7e-3,
            free_share=0.5,
            codebooks=replace(StudentConfig().codebooks, rotation=256, appearance=512),
            votes=VoteConfig(votes_per_interval=4),
        ),
    )


RECIPES: dict[PresetName, Callable[[], Recipe]] = {
    "cpu": cpu_recipe,
    "gpu": gpu_recipe,
    "demo": demo_recipe,
}


def with_method(recipe: Recipe, method: MethodName) -> Recipe:
    """The recipe with the teacher trained as a paper has it; lengths and numbers stay."""
    teacher = recipe.teacher
    densify = replace(teacher.densify, start=DensifyConfig().start)
    if method == "3dgs":
        densify = replace(densify, strategy="clone_split", opacity_reset=0.1)
    elif method == "mini-splatting":
        densify = replace(densify, strategy="mini_splatting")
    else:
        densify = replace(densify, strategy="mcmc")
        teacher = replace(teacher, init_opacity=0.5, init_scale=0.1)
    return replace(recipe, teacher=replace(teacher, densify=densify))


def with_steps(recipe: Recipe, steps: int) -> Recipe:
    """The recipe made longer or shorter: `steps` in all, shared out as they were.

    Raises InputError if that leaves a stage without a step.
    """
    if steps < 2:
        raise InputError(f"{steps} steps are too few: teacher and student need one each")
    before = recipe.teacher.steps + recipe.student.steps
    teacher = min(max(1, round(steps * recipe.teacher.steps / before)), steps - 1)
    return Recipe(
        replace(recipe.teacher, steps=teacher), replace(recipe.student, steps=steps - teacher)
    )


def with_settings(recipe: Recipe, settings: Iterable[str]) -> Recipe:
    """The recipe with fields changed by their paths, as in `student.opacity_rate=0.02`.

    Settings count together: what one alone would contradict, another may allow; of two for the
    same field the last one counts. Raises InputError if there is no such field, the value is not
    of its kind, or what comes of it cannot be.
    """
    changes: dict[str, Any] = {}
    for setting in settings:
        path, equals, text = setting.partition("=")
        if not equals:
            raise InputError(f"'{setting}' sets nothing: write it like student.opacity_rate=0.02")
        try:
            value = json.loads(text)
        except json.JSONDecodeError:
            value = text
        *parents, name = path.strip().replace("-", "_").split(".")
        inner, config = changes, recipe
        for parent in parents:
            config = _field(config, parent, setting)
            inner = inner.setdefault(parent, {})
        old = _field(config, name, setting)
        inner[name] = _like(old, value, setting, typing.get_type_hints(type(config))[name])
    return _replaced(recipe, changes)


def _field(config: Any, name: str, setting: str) -> Any:
    """The value of a field that a setting names."""
    if not is_dataclass(config):
        raise InputError(f"'{setting}' names no setting: nothing is called '{name}' there")
    known = [f.name for f in fields(config)]
    if name not in known:
        near = get_close_matches(name, known)
        hint = f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(known)}"
        raise InputError(f"'{setting}' names no setting, as nothing is called '{name}': {hint}")
    return getattr(config, name)


def _like(old: Any, value: Any, setting: str, hint: Any) -> Any:
    """The value, of the kind of the one before."""
    names = typing.get_args(hint) if typing.get_origin(hint) is Literal else (value,)
    if value not in names:
        raise InputError(f"'{setting}' is none of {', '.join(names)}")
    right = type(old) is type(value) or (type(old), type(value)) == (float, int)
    if is_dataclass(old) or not right:
        raise InputError(f"'{setting}' is not of the kind of its default, {old!r}")
    return type(old)(value)


def _replaced(config: Any, changes: dict[str, Any], path: str = "") -> Any:
    """The dataclass with all its changes at once, those of dataclasses within it first."""
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
    """A dataclass from what `dataclasses.asdict` made of it and JSON brought back.

    Raises InputError if fields are missing or unknown: another version wrote it.
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
            name: from_json(hints[name], value) if is_dataclass(hints[name]) else value
            for name, value in content.items()
        }
    )
