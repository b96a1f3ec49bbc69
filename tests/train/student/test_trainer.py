"""The student on a tiny capture: its phases, pruning, resuming and files."""

from dataclasses import replace

import pytest
import torch

from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.front import front_coverage
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.scene import Scene
from mobilegs.representation.codebooks import CUTS
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.model import StudentModel
from mobilegs.train.student.shared_decode import SharedDecode
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import KINDS
from tests.support.selection import few
from tests.support.tiny import (
    STUDENT,
    blobs,
    cameras,
    changed,
    train,
    with_kind,
)


@pytest.mark.parametrize("kind", KINDS)
def test_the_student_starts_with_the_teachers_opacities(kind: str, make_student) -> None:
    model = make_student(with_kind(kind)).model
    camera, (some, for_lobes) = cameras()[0], model.gaussians()
    directions = torch.nn.functional.normalize(some.means - camera.position, dim=1)
    opacities, phi = evaluate_lobes(model.lobes(some, for_lobes, camera), directions)
    torch.testing.assert_close(opacities, blobs().opacities, atol=1e-4, rtol=0)
    torch.testing.assert_close(model.opacities_and_scales(camera)[0], opacities)
    torch.testing.assert_close(phi, torch.ones_like(phi), atol=1e-3, rtol=0)


@pytest.mark.parametrize(("kind", "coding"), [("network", "sq"), ("latent", "nvq")])
def test_a_restored_model_is_on_the_device_of_its_gaussians(
    dataset: Dataset, make_student, kind: str, coding: str
) -> None:
    config = changed(with_kind(kind), quantization={"method": coding})
    student = make_student(config)
    for until in (3, 12, 30):  # explicit, latents, quantized
        train(student, dataset, until)
        generator, rates = torch.Generator(), student._lrs()
        options = {
            "color": config.color_shape,
            "step_sizes": config.quantization.initial_step_sizes,
        }
        model = StudentModel(
            blobs().to("meta"), config.view_dependence, rates, generator, **options
        )
        model.restore(student.model.state())
        tensors = [codes.indices for codes in model.quantizers.values()]
        for adam in (model.rows, model.shared):
            tensors += adam.tensors.values()
            states = adam.adam.state.values()
            tensors += [of[key] for of in states for key in ("exp_avg", "exp_avg_sq") if key in of]
        assert len(tensors) > 10 and all(tensor.is_meta for tensor in tensors), until


@pytest.mark.parametrize("kind", few(KINDS, "latent"))
def test_gradients_of_a_step_are_the_sum_over_its_views(
    kind: str, dataset: Dataset, make_student
) -> None:
    student = make_student(with_kind(kind))
    views = [(index, load_view(dataset.train[index])) for index in (4, 0, 2)]
    for until in (5, 20, 30):  # explicit, latents, quantized
        train(student, dataset, until)
        apart = [gradients(student, [view]) for view in views]
        for name, grad in gradients(student, views).items():
            expected = torch.stack([one[name] for one in apart]).sum(0)
            assert grad.isfinite().all() and ((expected != 0).any() or not expected.numel()), name
            distance = (grad - expected).norm() / expected.norm().clamp_min(1e-30)
            assert distance < 1e-5, f"{name} in {student.phase}: {distance:.1e}"


@pytest.mark.parametrize("every", [0, 2])  # virtual views
def test_the_coverage_before_a_plane_moves_what_is_before_it(
    every: int, dataset: Dataset, make_student
) -> None:
    found, students = [], []
    for weight in (0.0, 1.0):
        loss = {"front_weight": weight, "virtual_view_every": every, "distill_weight": 0.0}
        student = make_student(changed(STUDENT, loss=loss | {"depth_weight": 0.0}))
        views = [(0, load_view(dataset.train[0]))]
        student.model.rows.tensors["logit_opacities"].data -= 3  # fainter than the teacher
        found.append(gradients(student, views)["logit_opacities"])
        students.append(student)
    student = students[1]
    student.generator.manual_seed(0)
    index = student._pick_front_view(None)
    assert index is not None
    camera = student.front_cameras[index]
    z = student.teacher_images.front(index, camera).z
    before = camera.depths(blobs().means) < z
    changes = found[1] - found[0]
    assert 0 < before.sum() < 50
    assert (changes[~before] == 0).all()
    assert (changes[before] < 0).sum() > 0.5 * before.sum()  # more opacity, as the teacher has
    assert not students[0]._has_front_term


def gradients(student: Student, views: list[tuple[int, View]]) -> dict[str, torch.Tensor]:
    """Return the gradients of a step on these views, by name."""
    student.generator.manual_seed(0)
    _, decoded = student._add_gradients([student.cameras[index] for index, _ in views], views)
    adams, found = (student.model.rows, student.model.shared), {}
    before = [
        ({n: t.detach().clone() for n, t in adam.tensors.items()}, dict(adam.adam.state))
        for adam in adams
    ]
    for adam in adams:
        adam.reset_all_moments()
    decoded.step()
    for adam, (values, moments) in zip(adams, before, strict=True):
        for name, tensor in adam.tensors.items():
            if tensor in adam.adam.state:  # of a first step: a tenth of the gradient
                found[name] = 10 * adam.adam.state[tensor]["exp_avg"]
            tensor.data.copy_(values[name])
        adam.adam.state.clear()
        adam.adam.state.update(moments)
    student.model.reassign(codebooks=False)
    return found


def test_a_shared_decode_renders_each_camera_as_a_decode_for_it(make_student) -> None:
    student = make_student(changed(STUDENT, level_sigma=0.0))
    near = [replace(camera, near=2.9 + 0.1 * i) for i, camera in enumerate(cameras())]
    shared = SharedDecode(student.model, near)
    assert shared.rows[0] is not None
    assert 0 < len(shared.rows[0]) < len(shared.decoded["means"]) < 50
    for number, camera in enumerate(near):
        options = {"background": student.background}
        together, alone = shared.render(number, **options), SharedDecode(student.model, [camera])
        assert torch.equal(together.image, alone.render(0, **options).image)
        z = camera.near + 0.2
        cut = front_coverage(student.scene(), camera, z)
        assert 0 < cut.mean() < together.alpha.mean()
        torch.testing.assert_close(shared.render(number, before=z, **options).alpha, cut)


def test_votes_remove_faint_and_small_gaussians(dataset: Dataset, make_student) -> None:
    student = make_student(with_kind("constant"))
    with torch.no_grad():
        student.model.rows.tensors["logit_opacities"][:4] = -4
        student.model.rows.tensors["log_scales"][:4] = -5
    train(student, dataset, 4)
    assert student.count < 50
    faint = student.model.rows.tensors["logit_opacities"] < -3
    assert not faint.any()


def test_pruning_keeps_rows_and_indices_together(make_student) -> None:
    student = make_student()
    student._enter("quantized")
    assert set(student.model.quantizers) == {*CUTS, "lobes"}
    before, latents = student.model.gaussians()
    keep = torch.arange(50) % 3 != 0
    student.model.keep_rows(keep)
    after, fewer = student.model.gaussians()
    assert latents.shape == (50, 12)
    torch.testing.assert_close(fewer, latents[keep], atol=1e-6, rtol=0)
    for name, value in before.tensors().items():
        torch.testing.assert_close(after.tensors()[name], value[keep], atol=1e-6, rtol=0)


def test_a_student_of_one_step_is_quantised(dataset: Dataset, make_student) -> None:
    student = make_student(replace(STUDENT, steps=1))
    train(student, dataset, 1)
    assert len(student.quantized_scene()) == student.count


def test_means_max_limits_the_learning_rate_of_the_means(dataset: Dataset) -> None:
    sizes = blobs().scales.topk(2, dim=1).values.prod(1).sqrt()
    for share, rate, expected in ((0.02, 1.0, 0.02 * float(sizes.median())), (9.0, 1e-3, 3e-3)):
        config = changed(STUDENT, lr={"means_max": share, "means": rate})
        student = Student(config, Scene(blobs()), cameras(), extent=3.0, seed=0)
        train(student, dataset, 1)
        after = student.model.rows.tensors["means"].detach()  # some are pruned
        moved = (after[:, None] - blobs().means).abs().amax(2).amin(1)
        assert float(moved.max()) == pytest.approx(expected, rel=1e-3)  # a step of Adam


def test_harmonics_of_another_degree_are_cut_or_padded() -> None:
    for coefficients in (1, 16):
        teacher = replace(blobs(), sh=torch.ones(50, coefficients, 3))
        model = Student(STUDENT, Scene(teacher), cameras(), extent=3.0, seed=0).model
        sh = model.gaussians()[0].sh
        assert sh.shape == (50, 4, 3)
        assert (sh[:, 1:] == (coefficients > 1)).all()


def test_phases_out_of_order_are_refused() -> None:
    with pytest.raises(InputError, match="quantize_from must rise"):
        changed(StudentConfig(), schedule={"latents_from": 0.7, "quantize_from": 0.5})
