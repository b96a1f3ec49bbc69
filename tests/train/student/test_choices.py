"""Choices of the student: blending, view dependence, colours, quantisation, and the release's."""

import math
from collections.abc import Callable

import pytest
import torch

from bench.paper.rows import ROWS
from mobilegs.data.dataset import Dataset
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.render import Rendered, render_sorted
from mobilegs.render.project import CLASSIC
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import C0
from mobilegs.train.recipes import Recipe, with_settings
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.shared_decode import SharedDecode
from mobilegs.train.student.trainer import Student
from tests.support.selection import few
from tests.support.tiny import STUDENT, blobs, cameras, changed, train

CONSTANT, NETWORK = {"kind": "constant"}, {"kind": "network"}
SQ = {"method": "sq"}
FORMS: dict[str, StudentConfig] = {
    "latent": STUDENT,
    "constant, sh-0": changed(STUDENT, view_dependence=CONSTANT, color={"degree": 0}),
    "sorted": changed(STUDENT, blend="sorted", view_dependence=CONSTANT, color={"degree": 3}),
    "sorted, network": changed(STUDENT, blend="sorted", view_dependence=NETWORK),
    "sq": changed(STUDENT, quantization=SQ),
    "sq, network, sh-2": changed(
        STUDENT, quantization=SQ, view_dependence=NETWORK, color={"degree": 2}
    ),
    "sq, a size": changed(STUDENT, quantization=SQ | {"target_mb": 0.006}),
    "sq, one latent": changed(STUDENT, quantization=SQ, view_dependence={"latents": 1}),
    "sq, depth pass": changed(STUDENT, quantization=SQ, weighting={"depth_pass": True}),
    "sq, sorted, lobes": changed(STUDENT, quantization=SQ, blend="sorted"),
    "release": changed(
        STUDENT,
        weighting={"detached": True},
        loss={"mask_depth": False},
        schedule={"keep_moments": False},
        color={"decoder": "networks"},
    ),
}


def render_student(student: Student) -> Rendered:
    """Render the first camera as training does."""
    return SharedDecode(student.model, cameras()[:1]).render(0, background=student.background)


PHASES = {3: "explicit", 12: "latents", 20: "latents", 30: "quantized"}
MakeStudent = Callable[..., Student]


@pytest.mark.parametrize("form", few(FORMS, "latent", "sorted", "sq"))
def test_every_form_renders_as_in_training_and_resumes_to_the_same_file(
    form: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    config, camera = FORMS[form], cameras()[0]
    whole, resumed = make_student(config), make_student(config)
    train(whole, dataset, 40)
    sigma = whole.model.level_sigma
    for stop, phase in PHASES.items():
        train(resumed, dataset, stop)
        assert resumed.model.phase == phase
        scene = resumed.scene()
        rendered, again = render_student(resumed), scene.render(camera, level_sigma=sigma)
        torch.testing.assert_close(rendered.image, again.image, atol=1e-5, rtol=0)
        if scene.lobes is not None:  # opacities are the constant parts of lobes
            mean = C0 * scene.lobes[:, 0, 0]
            torch.testing.assert_close(scene.gaussians.logit_opacities, mean)
        before, resumed = resumed, make_student(config, seed=9)
        resumed.restore(before.state())
    train(resumed, dataset, 40)
    data = encode_mgs(resumed.quantized_scene())
    assert data == encode_mgs(whole.quantized_scene())
    opened = decode_mgs(data).decode()
    assert opened.blend == config.blend == inspect(data)["blend"]
    assert opened.gaussians.sh_degree == config.color.degree == inspect(data)["sh_degree"]
    again = opened.render(camera, level_sigma=sigma)
    torch.testing.assert_close(render_student(whole).image, again.image, atol=2e-5, rtol=0)
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


def test_a_sorted_student_starts_as_the_teacher_with_fewer_harmonics(
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
    as_teacher = {"footprint": CLASSIC, "least_variance": 0.0, "level_sigma": 0.0}
    student = make_student(changed(FORMS["sorted, network"], **as_teacher))
    train(student, dataset, 40)
    network = student.model.network
    assert network is not None
    assert network.opacity.weight.abs().max() > 1e-3
    assert not network.phi.weight.any() and network.phi.bias == 1  # as at the start
    opacities = [student.model.opacities_and_scales(camera)[0] for camera in cameras()[:2]]
    assert (opacities[0] - opacities[1]).abs().max() > 1e-3


def test_opacities_of_the_paper_come_from_the_network_only(
    dataset: Dataset, make_student: MakeStudent
) -> None:
    recipe = with_settings(Recipe(student=STUDENT), ROWS["paper"].settings)
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
