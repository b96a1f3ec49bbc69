"""Students that leave out or replace a part of the method, as the paper's tables do."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
import torch
from paper_rows import ROWS

from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.mgs.codec import inspect, pack, unpack
from mobilegs.render import Weighting, render_sorted, render_sortfree
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.scene import Scene
from mobilegs.train.autograd_ops import telling_weighting
from mobilegs.train.recipes import Recipe, cpu_recipe, with_method, with_settings
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.mask_pruning import PresenceConfig
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
from mobilegs.train.student.vote_pruning import VoteConfig, vote
from tests.support.tiny import STUDENT, blobs, cameras, draw, train

CONSTANT = ViewDependence("constant")
SORT_FREE_GS = Weighting("sort_free_gs", sigma=3.0, background_weight=0.5)
FORMS: dict[str, StudentConfig] = {
    "sorted": replace(STUDENT, blend="sorted", view=CONSTANT),
    "sorted-3": replace(STUDENT, blend="sorted", view=CONSTANT, sh_degree=3),
    "masks": replace(STUDENT, presence=PresenceConfig(weight=0.1)),
    "sorted, masks": replace(
        STUDENT, blend="sorted", view=CONSTANT, presence=PresenceConfig(weight=0.1)
    ),
    "sort_free_gs": replace(STUDENT, weighting=SORT_FREE_GS),
    "no background weight": replace(
        STUDENT, weighting=replace(SORT_FREE_GS, background_weight=0.0)
    ),
    "two_pass": replace(STUDENT, weighting=Weighting("two_pass")),
    **{f"sh-{degree}": replace(STUDENT, sh_degree=degree) for degree in (0, 2, 3)},
    "sq": replace(STUDENT, coding="sq"),
    "sq, free lobes": replace(STUDENT, coding="sq", view=ViewDependence("free", fraction=0.3)),
    "sq, network": replace(STUDENT, coding="sq", view=ViewDependence("network")),
    "sq, decoded": replace(STUDENT, coding="sq", view=ViewDependence("decoded")),
    "sq, no base": replace(STUDENT, coding="sq", view=ViewDependence("latent", latents=0)),
    "sq, sorted": replace(STUDENT, coding="sq", blend="sorted", view=CONSTANT, sh_degree=2),
    "release": replace(
        STUDENT, weighting=Weighting(detached=True), depth_masked=False, moments_kept=False
    ),
    "network-sh-0": replace(STUDENT, sh_degree=0, view=ViewDependence("network")),
    "network-sh-2": replace(STUDENT, sh_degree=2, view=ViewDependence("network")),
}
MakeStudent = Callable[..., Student]


@pytest.mark.parametrize("form", FORMS)
def test_every_form_has_a_file_that_shows_what_training_drew(
    form: str,
    dataset: Dataset,
    make_student: MakeStudent,
) -> None:
    student = make_student(FORMS[form])
    train(student, dataset, 40)
    camera = cameras()[0]
    drawn = draw(student, depth=True)
    data = pack(student.coded())
    opened = unpack(data).decode()
    assert opened.blend == FORMS[form].blend == inspect(data)["blend"]
    assert opened.gaussians.sh_degree == FORMS[form].sh_degree == inspect(data)["sh_degree"]
    again = opened.render(camera, depth=True)
    torch.testing.assert_close(drawn.image, again.image, atol=2e-5, rtol=0)
    truth = Scene(blobs()).render(camera).image
    assert (again.image - truth).abs().mean() < 0.25 * truth.abs().mean()


@pytest.mark.parametrize("rounded", [True, False])
def test_positions_may_learn_without_the_rounding_of_the_file(
    rounded: bool, dataset: Dataset, make_student: MakeStudent
) -> None:
    student = make_student(replace(STUDENT, positions_rounded=rounded))
    train(student, dataset, 20)
    model = student.model
    assert model.phase == "networks"
    with torch.no_grad():
        drawn = model.gaussians()[0].means
    assert torch.equal(drawn, model.rows.tensors["means"]) is not rounded
    assert torch.equal(drawn, model.shapes()[0]) is rounded
    stored = student.coded().decode().gaussians.means
    assert torch.equal(stored.sort(0).values, model.shapes()[0].sort(0).values)


def test_moments_are_lost_if_they_are_to_be(dataset: Dataset, make_student: MakeStudent) -> None:
    def moments(kept: bool, until: int) -> torch.Tensor:
        student = make_student(replace(STUDENT, moments_kept=kept))
        train(student, dataset, until)
        return student.model.rows.state()["means"]["step"]

    before = math.ceil(STUDENT.net_fraction * STUDENT.steps)
    assert moments(True, before) == moments(False, before) == before
    assert moments(True, before + 3) == before + 3 and moments(False, before + 3) == 3


@pytest.mark.parametrize(
    "form", ["sorted", "masks", "sort_free_gs", "sh-0", "sh-3", "release", "sq"]
)
@pytest.mark.parametrize("stop", [3, 20, 30])
def test_every_form_goes_on_where_it_was_stopped(
    form: str,
    stop: int,
    dataset: Dataset,
    make_student: MakeStudent,
) -> None:
    whole, first, second = (make_student(FORMS[form], seed=seed) for seed in (0, 0, 9))
    train(whole, dataset, 40)
    train(first, dataset, stop)
    second.restore(first.state())
    train(second, dataset, 40)
    assert pack(second.coded()) == pack(whole.coded())


def test_a_sorted_student_is_a_teacher_with_fewer_harmonics(
    dataset: Dataset,
    make_student: MakeStudent,
) -> None:
    given, camera = blobs(), cameras()[0]
    drawn = draw(make_student(FORMS["sorted"]))
    expected = render_sorted(
        given.means,
        given.quats,
        given.scales,
        given.opacities,
        given.sh,
        camera=camera,
        background=torch.zeros(3),
    )
    torch.testing.assert_close(drawn.image, expected.image, atol=1e-5, rtol=0)


def test_a_sorted_student_has_no_use_for_a_view_dependence(make_student: MakeStudent) -> None:
    with pytest.raises(InputError, match=r"view\.kind=constant"):
        make_student(replace(STUDENT, blend="sorted"))
    with pytest.raises(InputError, match="unknown blend 'alpha'"):
        replace(STUDENT, blend="alpha")
    with pytest.raises(InputError, match="sh_degree must be at least 0 and at most 3, not 4"):
        replace(STUDENT, sh_degree=4)


# --- what a weighting learns


@pytest.mark.parametrize("background_weight", [0.7, 0.0])
def test_sigma_and_the_backgrounds_weight_get_the_gradients_of_the_picture(
    background_weight: float,
) -> None:
    """Against central differences of the definition, in float64."""
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
        drawn = render_sortfree(
            means, quats, scales, lobes, sh, camera=camera, background=background,
            weighting=weighting,
        )  # fmt: skip
        return (drawn.image * toward).sum()

    depths = means @ camera.viewmat[2, :3] + camera.viewmat[2, 3]
    sigma = float(depths.quantile(0.8))  # some lie beyond
    given = {"sigma": sigma, "background_weight": background_weight}
    learned = {
        name: torch.tensor(value, dtype=torch.float64, requires_grad=True)
        for name, value in given.items()
        if value
    }
    told = telling_weighting(lobes.clone().requires_grad_(), means, camera, **learned)
    loss(told, sigma, background_weight).backward()
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


def test_the_weighting_moves_and_is_what_the_file_says(
    dataset: Dataset,
    make_student: MakeStudent,
) -> None:
    student = make_student(FORMS["sort_free_gs"])
    train(student, dataset, 40)
    learned = unpack(pack(student.coded())).weighting
    assert abs(learned.sigma - 9) < 5 and learned.sigma != 9  # the scene's extent is 3
    assert learned.background_weight != 0.5
    assert learned == student.model.weighting
    plain = make_student(STUDENT)
    assert plain.model.weighting == STUDENT.weighting
    assert not any(name.startswith("weighting") for name in plain.model.shared.tensors)


# --- what the votes look at


def test_votes_can_look_at_one_criterion_alone() -> None:
    opacities = torch.tensor([0.1, 0.9, 0.1, 0.9, 0.5])
    scales = torch.tensor([0.1, 0.1, 0.9, 0.9, 0.5])[:, None].expand(5, 3)
    against = {
        by: vote(opacities, scales, quantile=0.5, by=by) for by in ("both", "opacity", "scale")
    }
    assert against["both"].tolist() == [True, False, False, False, False]
    assert against["opacity"].tolist() == [True, False, True, False, False]
    assert against["scale"].tolist() == [True, True, False, False, False]


def test_one_criterion_removes_more_than_both(
    dataset: Dataset,
    make_student: MakeStudent,
) -> None:
    counts = {}
    for by in ("both", "opacity", "scale"):
        votes = VoteConfig(by=by, quantile=0.5, interval=0.25)
        student = make_student(replace(STUDENT, votes=votes))
        train(student, dataset, 40)
        counts[by] = student.count
    assert counts["both"] < 50
    assert max(counts["opacity"], counts["scale"]) < counts["both"]


# --- the rows of bench/paper.py


def test_every_row_of_the_papers_tables_is_a_recipe() -> None:
    recipes = {}
    for name, row in ROWS.items():
        recipes[name] = with_settings(with_method(cpu_recipe(), row.teacher), row.settings)
    assert recipes["ours"] == recipes["teacher"] == with_method(cpu_recipe(), "mini-splatting")
    several = [recipes[name] for name in ROWS if name not in ("ours", "teacher", "codebook-10")]
    assert all(several.count(recipe) == 1 for recipe in several)
    assert recipes["codebook-10"] == recipes["codebooks"]
    assert recipes["no-order-independence"].student.blend == "sorted"
    assert recipes["vote-0.4"].student.votes.quantile == 0.4
    assert recipes["codebook-12"].student.codebooks.appearance == 4096
    assert recipes["quantised-3dgs"].teacher.densify.strategy == "clone_split"


@pytest.mark.parametrize("row", ["random-opacity", "release"])
def test_the_network_alone_tells_opacities_apart(
    row: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    recipe = with_settings(Recipe(student=STUDENT), ROWS[row].settings)
    student = make_student(recipe.student)
    train(student, dataset, 40)
    scene = unpack(pack(student.coded())).decode()
    assert len(scene.gaussians.logit_opacities.unique()) == 1
    opacities, _ = student.model.seen_from(cameras()[0])
    assert opacities.std() > 1e-3


def test_the_release_has_all_its_errors_at_once() -> None:
    """But one: without the teacher's pictures it would be another method."""
    settings = set(ROWS["release"].settings)
    for name, row in ROWS.items():
        if row.table == "fixes" and name != "no-distillation":
            assert set(row.settings) <= settings, name
    assert set(ROWS["paper"].settings) <= settings


def test_opacities_can_begin_alike(make_student: MakeStudent) -> None:
    network = ViewDependence("network")
    student = make_student(replace(STUDENT, view=network, start_opacity=0.5))
    opacities, _ = student.model.seen_from(cameras()[0])
    torch.testing.assert_close(opacities, torch.full((50,), 0.5))
    with pytest.raises(InputError, match=r"start_opacity must be at least 0 and below 1, not 1\.5"):
        replace(STUDENT, start_opacity=1.5)
