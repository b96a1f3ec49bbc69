"""Ablations of the student: forms that leave out or replace a part of the method."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest
import torch

from bench.paper.rows import ROWS
from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.mgs.codec import inspect, pack, unpack
from mobilegs.render import Weighting, render_sorted, render_sortfree
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.scene import Scene
from mobilegs.train.autograd_ops import with_weighting_gradients
from mobilegs.train.recipes import Recipe, cpu_recipe, with_method, with_settings
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.mask_pruning import MaskConfig
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
from mobilegs.train.student.vote_pruning import VoteConfig, vote
from tests.support.selection import few
from tests.support.tiny import STUDENT, blobs, cameras, changed, classic, render_student, train

CONSTANT = ViewDependence("constant")
SORT_FREE_GS = Weighting("sort_free_gs", sigma=3.0, background_weight=0.5)
FORMS: dict[str, StudentConfig] = {
    "sorted": replace(STUDENT, blend="sorted", view_dependence=CONSTANT),
    "sorted-3": changed(STUDENT, blend="sorted", view_dependence=CONSTANT, color={"degree": 3}),
    "sorted, lobes": replace(STUDENT, blend="sorted"),
    "sorted, network": replace(STUDENT, blend="sorted", view_dependence=ViewDependence("network")),
    "masks": changed(STUDENT, pruning={"masks": MaskConfig(weight=0.1)}),
    "sorted, masks": changed(
        STUDENT, blend="sorted", view_dependence=CONSTANT, pruning={"masks": MaskConfig(weight=0.1)}
    ),
    "sort_free_gs": replace(STUDENT, weighting=SORT_FREE_GS),
    "no background weight": replace(
        STUDENT, weighting=replace(SORT_FREE_GS, background_weight=0.0)
    ),
    "two_pass": replace(STUDENT, weighting=Weighting("two_pass")),
    **{f"sh-{degree}": changed(STUDENT, color={"degree": degree}) for degree in (0, 2, 3)},
    "sq": changed(STUDENT, quantization={"method": "sq"}),
    "sq, free lobes": changed(
        STUDENT,
        quantization={"method": "sq"},
        view_dependence=ViewDependence("free", decoder_from=0.3),
    ),
    "sq, network": changed(
        STUDENT, quantization={"method": "sq"}, view_dependence=ViewDependence("network")
    ),
    "sq, decoded": changed(
        STUDENT, quantization={"method": "sq"}, view_dependence=ViewDependence("decoded")
    ),
    "sq, no base": changed(
        STUDENT, quantization={"method": "sq"}, view_dependence=ViewDependence("latent", latents=0)
    ),
    "sq, sorted": changed(
        STUDENT,
        quantization={"method": "sq"},
        blend="sorted",
        view_dependence=CONSTANT,
        color={"degree": 2},
    ),
    "sq, sorted, free lobes": changed(
        STUDENT,
        quantization={"method": "sq"},
        blend="sorted",
        view_dependence=ViewDependence("free", decoder_from=0.3),
    ),
    "release": changed(
        STUDENT,
        weighting=Weighting(detached=True),
        ablation={"mask_depth": False, "keep_moments": False},
    ),
    "network-sh-0": changed(
        STUDENT, color={"degree": 0}, view_dependence=ViewDependence("network")
    ),
    "network-sh-2": changed(
        STUDENT, color={"degree": 2}, view_dependence=ViewDependence("network")
    ),
}
MakeStudent = Callable[..., Student]


@pytest.fixture(scope="module")
def trained(dataset: Dataset, make_student: MakeStudent) -> Callable[[str], Student]:
    """A function that returns a trained student of a form, which nobody changes."""

    @cache
    def student(form: str) -> Student:
        made = make_student(FORMS[form])
        train(made, dataset, 40)
        return made

    return student


@pytest.mark.parametrize("form", few(FORMS, "sorted", "sort_free_gs", "sh-3", "release"))
def test_the_file_of_every_form_renders_as_in_training(
    form: str, trained: Callable[[str], Student]
) -> None:
    student, camera = trained(form), cameras()[0]
    rendered = render_student(student, depth=True)
    data = pack(student.quantized_scene())
    opened = unpack(data).decode()
    assert opened.blend == FORMS[form].blend == inspect(data)["blend"]
    assert opened.gaussians.sh_degree == FORMS[form].color.degree == inspect(data)["sh_degree"]
    again = opened.render(camera, depth=True, level_sigma=student.model.level_sigma)
    torch.testing.assert_close(rendered.image, again.image, atol=2e-5, rtol=0)
    truth = Scene(blobs()).render(camera).image
    assert (again.image - truth).abs().mean() < 0.25 * truth.abs().mean()


@pytest.mark.parametrize("rounded", [True, False])
def test_means_train_with_and_without_rounding(
    rounded: bool, dataset: Dataset, make_student: MakeStudent
) -> None:
    student = make_student(changed(STUDENT, ablation={"round_means": rounded}))
    train(student, dataset, 20)
    model = student.model
    assert model.phase == "latents"
    with torch.no_grad():
        rendered = model.gaussians()[0].means
    assert torch.equal(rendered, model.rows.tensors["means"]) is not rounded
    assert torch.equal(rendered, model.shapes()[0]) is rounded
    stored = student.quantized_scene().decode().gaussians.means
    assert torch.equal(stored.sort(0).values, model.shapes()[0].sort(0).values)


def test_keep_moments_false_resets_adam(dataset: Dataset, make_student: MakeStudent) -> None:
    def moments(kept: bool, until: int) -> torch.Tensor:
        student = make_student(changed(STUDENT, ablation={"keep_moments": kept}))
        train(student, dataset, until)
        return student.model.rows.state()["means"]["step"]

    before = math.ceil(STUDENT.schedule.latents_from * STUDENT.steps)
    assert moments(True, before) == moments(False, before) == before
    assert moments(True, before + 3) == before + 3 and moments(False, before + 3) == 3


@pytest.mark.parametrize(
    "form",
    few(
        ["sorted", "sorted, network", "masks", "sort_free_gs", "sh-0", "sh-3", "release", "sq"],
        "sq",
    ),
)
def test_every_form_resumes_to_the_same_bytes(
    form: str,
    dataset: Dataset,
    make_student: MakeStudent,
    trained: Callable[[str], Student],
) -> None:
    resumed = make_student(FORMS[form])
    for stop in (3, 20, 30):
        train(resumed, dataset, stop)
        before, resumed = resumed, make_student(FORMS[form], seed=9)
        resumed.restore(before.state())
    train(resumed, dataset, 40)
    assert pack(resumed.quantized_scene()) == pack(trained(form).quantized_scene())


def test_a_sorted_student_starts_as_the_teacher_with_fewer_harmonics(
    dataset: Dataset,
    make_student: MakeStudent,
) -> None:
    given, camera = blobs(), cameras()[0]
    rendered = render_student(make_student(FORMS["sorted"]))
    expected = render_sorted(
        given.means,
        given.quats,
        given.scales,
        given.opacities,
        given.sh,
        camera=camera,
        background=torch.zeros(3),
        footprint=FORMS["sorted"].footprint.drawn("sorted"),
    )
    torch.testing.assert_close(rendered.image, expected.image, atol=1e-5, rtol=0)


def test_a_sorted_student_learns_opacities_by_direction_and_no_phi(
    dataset: Dataset, make_student: MakeStudent
) -> None:
    student = make_student(classic(FORMS["sorted, network"]))
    train(student, dataset, 40)
    network = student.model.network
    assert network is not None
    assert network.opacity.weight.abs().max() > 1e-3
    assert not network.phi.weight.any() and network.phi.bias == 1  # as at the start
    opacities = [student.model.opacities_and_scales(camera)[0] for camera in cameras()[:2]]
    assert (opacities[0] - opacities[1]).abs().max() > 1e-3


def test_unknown_blendings_and_degrees_are_refused() -> None:
    with pytest.raises(InputError, match="unknown blend 'alpha'"):
        replace(STUDENT, blend="alpha")
    with pytest.raises(InputError, match="degree must be at least 0 and at most 3, not 4"):
        changed(STUDENT, color={"degree": 4})


# --- learned parameters of a weighting


@pytest.mark.parametrize("background_weight", [0.7, 0.0])
def test_gradients_of_sigma_and_background_weight_match_finite_differences(
    background_weight: float,
) -> None:
    """Compare with central differences of the reference, in float64."""
    given, camera = blobs(), cameras()[0].to(torch.device("cpu"), torch.float64)
    means, quats, scales = (t.double() for t in (given.means, given.quats, given.scales))
    sh, background = given.sh.double(), torch.tensor([0.2, 0.9, 0.4], dtype=torch.float64)
    generator = torch.Generator().manual_seed(3)
    lobes = constant_lobes(given.logit_opacities.double()).repeat(1, 4, 1)
    lobes[:, 1:] = torch.randn(50, 3, 2, generator=generator, dtype=torch.float64)
    lobes[::5, :, 1] *= -1  # some phi are 0
    toward = torch.randn(24, 24, 3, generator=generator, dtype=torch.float64)

    def loss(lobes: torch.Tensor, sigma: float, behind: float) -> torch.Tensor:
        weighting = Weighting("sort_free_gs", sigma=sigma, background_weight=behind)
        rendered = render_sortfree(
            means, quats, scales, lobes, sh, camera=camera, background=background,
            weighting=weighting,
        )  # fmt: skip
        return (rendered.image * toward).sum()

    depths = means @ camera.viewmat[2, :3] + camera.viewmat[2, 3]
    sigma = float(depths.quantile(0.8))  # some lie beyond
    given = {"sigma": sigma, "background_weight": background_weight}
    learned = {
        name: torch.tensor(value, dtype=torch.float64, requires_grad=True)
        for name, value in given.items()
        if value
    }
    same = with_weighting_gradients(lobes.clone().requires_grad_(), means, camera, **learned)
    loss(same, sigma, background_weight).backward()
    step = 1e-5
    by_sigma = loss(lobes, sigma + step, background_weight)
    by_sigma -= loss(lobes, sigma - step, background_weight)
    torch.testing.assert_close(learned["sigma"].grad, by_sigma / (2 * step), rtol=1e-5, atol=1e-7)
    if not background_weight:
        return
    by_weight = loss(lobes, sigma, background_weight + step)
    by_weight -= loss(lobes, sigma, background_weight - step)
    torch.testing.assert_close(
        learned["background_weight"].grad, by_weight / (2 * step), rtol=1e-5, atol=1e-7
    )


def test_the_weighting_learns_and_is_stored_in_the_file(
    trained: Callable[[str], Student], make_student: MakeStudent
) -> None:
    student = trained("sort_free_gs")
    learned = unpack(pack(student.quantized_scene())).weighting
    assert abs(learned.sigma - 9) < 5 and learned.sigma != 9  # the scene's extent is 3
    assert learned.background_weight != 0.5
    assert learned == student.model.weighting
    plain = make_student(STUDENT)
    assert plain.model.weighting == STUDENT.weighting
    assert not any(name.startswith("weighting") for name in plain.model.shared.tensors)


# --- criteria of votes


def test_a_vote_uses_both_criteria_or_one() -> None:
    opacities = torch.tensor([0.1, 0.9, 0.1, 0.9, 0.5])
    scales = torch.tensor([0.1, 0.1, 0.9, 0.9, 0.5])[:, None].expand(5, 3)
    against = {
        by: vote(opacities, scales, quantile=0.5, criterion=by)
        for by in ("both", "opacity", "scale")
    }
    assert against["both"].tolist() == [True, False, False, False, False]
    assert against["opacity"].tolist() == [True, False, True, False, False]
    assert against["scale"].tolist() == [True, True, False, False, False]


@pytest.mark.thorough
def test_one_criterion_removes_more_than_both(
    dataset: Dataset,
    make_student: MakeStudent,
) -> None:
    counts = {}
    for by in ("both", "opacity", "scale"):
        votes = VoteConfig(criterion=by, quantile=0.5, interval=0.25)
        student = make_student(changed(STUDENT, pruning={"votes": votes}))
        train(student, dataset, 40)
        counts[by] = student.count
    assert counts["both"] < 50
    assert max(counts["opacity"], counts["scale"]) < counts["both"]


# --- the rows of bench/paper/run.py


def test_every_row_of_the_papers_tables_is_a_different_recipe() -> None:
    recipes = {}
    for name, row in ROWS.items():
        recipe = with_method(cpu_recipe(), row.teacher)  # pyright: ignore[reportArgumentType]
        recipes[name] = with_settings(recipe, row.settings)
    assert recipes["ours"] == recipes["teacher"] == with_method(cpu_recipe(), "mini-splatting")
    several = [recipes[name] for name in ROWS if name not in ("ours", "teacher", "codebook-10")]
    assert all(several.count(recipe) == 1 for recipe in several)
    assert recipes["codebook-10"] == recipes["codebooks"]
    assert recipes["no-order-independence"].student.blend == "sorted"
    paper, sorts = recipes["paper"].student, recipes["paper-no-order-independence"].student
    assert sorts == replace(paper, blend="sorted") and sorts.view_dependence.kind == "network"
    assert recipes["vote-0.4"].student.pruning.votes.quantile == 0.4
    assert recipes["codebook-12"].student.quantization.codebooks.appearance == 4096
    assert recipes["quantized-3dgs"].teacher.densify.strategy == "clone_split"


@pytest.mark.parametrize(
    "row", few(["no-base-opacity", "near-release", "paper", "release"], "paper")
)
def test_opacities_come_from_the_network_only(
    row: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    recipe = with_settings(Recipe(student=STUDENT), ROWS[row].settings)
    student = make_student(recipe.student)
    train(student, dataset, 40)
    scene = unpack(pack(student.quantized_scene())).decode()
    assert len(scene.gaussians.logit_opacities.unique()) == 1
    opacities, _ = student.model.opacities_and_scales(cameras()[0])
    assert opacities.std() > 1e-3


def test_the_release_row_has_the_settings_of_all_rows_of_fixes() -> None:
    """Row `no-distillation` is an exception: it would be another method."""
    settings = set(ROWS["near-release"].settings)
    for name, row in ROWS.items():
        if row.table == "fixes" and name != "no-distillation":
            assert set(row.settings) <= settings, name
    assert set(ROWS["near-paper"].settings) <= settings


def test_start_opacity_sets_all_opacities(make_student: MakeStudent) -> None:
    network = ViewDependence("network")
    student = make_student(
        changed(STUDENT, view_dependence=network, ablation={"start_opacity": 0.5})
    )
    opacities, _ = student.model.opacities_and_scales(cameras()[0])
    torch.testing.assert_close(opacities, torch.full((50,), 0.5))
    with pytest.raises(InputError, match=r"start_opacity must be at least 0 and below 1, not 1\.5"):
        changed(STUDENT, ablation={"start_opacity": 1.5})
