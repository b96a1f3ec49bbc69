"""Choices of the student: blending, view dependence, colours, quantisation, and the release's."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest
import torch

from bench.paper.rows import ROWS
from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.render import render_sorted
from mobilegs.render.scene import Blend, Scene
from mobilegs.train.recipes import Recipe, with_settings
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.trainer import Student
from mobilegs.validation import check_choice
from tests.support.selection import few
from tests.support.tiny import STUDENT, blobs, cameras, changed, classic, render_student, train

CONSTANT, NETWORK = {"kind": "constant"}, {"kind": "network"}
SQ = {"method": "sq"}
FORMS: dict[str, StudentConfig] = {
    "sorted": changed(STUDENT, blend="sorted", view_dependence=CONSTANT, color={"degree": 3}),
    "sorted, lobes": replace(STUDENT, blend="sorted"),
    "sorted, network": changed(STUDENT, blend="sorted", view_dependence=NETWORK),
    "sh-0": changed(STUDENT, color={"degree": 0}),
    "sq": changed(STUDENT, quantization=SQ),
    "sq, network, sh-2": changed(
        STUDENT, quantization=SQ, view_dependence=NETWORK, color={"degree": 2}
    ),
    "sq, one latent": changed(STUDENT, quantization=SQ, view_dependence={"latents": 1}),
    "sq, sorted": changed(STUDENT, quantization=SQ, blend="sorted", view_dependence=CONSTANT),
    "release": changed(
        STUDENT,
        weighting={"detached": True},
        loss={"mask_depth": False},
        schedule={"keep_moments": False},
        color={"decoder": "networks"},
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


@pytest.mark.parametrize("form", few(FORMS, "sorted", "release"))
def test_the_file_of_every_form_renders_as_in_training(
    form: str, trained: Callable[[str], Student]
) -> None:
    student, camera = trained(form), cameras()[0]
    rendered = render_student(student, depth=True)
    data = encode_mgs(student.quantized_scene())
    opened = decode_mgs(data).decode()
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
    student = make_student(changed(STUDENT, quantization={"round_means": rounded}))
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
        student = make_student(changed(STUDENT, schedule={"keep_moments": kept}))
        train(student, dataset, until)
        return student.model.rows.state()["means"]["step"]

    before = math.ceil(STUDENT.schedule.latents_from * STUDENT.steps)
    assert moments(True, before) == moments(False, before) == before
    assert moments(True, before + 3) == before + 3 and moments(False, before + 3) == 3


@pytest.mark.parametrize("form", few(["sorted", "sorted, network", "release", "sq"], "sq"))
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
    assert encode_mgs(resumed.quantized_scene()) == encode_mgs(trained(form).quantized_scene())


def test_a_sorted_student_starts_as_the_teacher_with_fewer_harmonics(
    dataset: Dataset,
    make_student: MakeStudent,
) -> None:
    given, camera = blobs(), cameras()[0]
    form = changed(FORMS["sorted"], color={"degree": 1})
    rendered = render_student(make_student(form))
    expected = render_sorted(
        given.means,
        given.quats,
        given.scales,
        given.opacities,
        given.sh,
        camera=camera,
        background=torch.zeros(3),
        footprint=form.footprint.drawn("sorted"),
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


@pytest.mark.parametrize(
    ("setting", "known"),
    [
        ("student.blend=alpha", "sortfree, sorted"),
        ("student.color.decoder=mlp", "linear, networks, latent_networks"),
        ("student.quantization.method=vq", "sq, nvq"),
        ("student.view_dependence.kind=decoded", "constant, network, latent"),
        ("student.exposure.learned=maybe", "auto, always, never"),
    ],
)
def test_an_unknown_choice_is_refused_with_the_known_ones(setting: str, known: str) -> None:
    with pytest.raises(InputError, match=f"'{setting}' is none of {known}"):
        with_settings(Recipe(), [setting])


def test_a_choice_of_a_saved_recipe_is_checked() -> None:
    with pytest.raises(InputError, match="unknown blend 'alpha': use sortfree or sorted"):
        check_choice("blend", "alpha", Blend)
    check_choice("blend", "sorted", Blend)


def test_a_degree_out_of_range_is_refused() -> None:
    with pytest.raises(InputError, match="degree must be at least 0 and at most 3, not 4"):
        changed(STUDENT, color={"degree": 4})


@pytest.mark.parametrize(
    "row", few(["no-base-opacity", "near-release", "paper", "release"], "paper")
)
def test_opacities_come_from_the_network_only(
    row: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    recipe = with_settings(Recipe(student=STUDENT), ROWS[row].settings)
    student = make_student(recipe.student)
    train(student, dataset, 40)
    scene = decode_mgs(encode_mgs(student.quantized_scene())).decode()
    assert len(scene.gaussians.logit_opacities.unique()) == 1
    opacities, _ = student.model.opacities_and_scales(cameras()[0])
    assert opacities.std() > 1e-3


def test_start_opacity_sets_all_opacities(make_student: MakeStudent) -> None:
    form = changed(STUDENT, view_dependence={"kind": "network", "start_opacity": 0.5})
    opacities, _ = make_student(form).model.opacities_and_scales(cameras()[0])
    torch.testing.assert_close(opacities, torch.full((50,), 0.5))
