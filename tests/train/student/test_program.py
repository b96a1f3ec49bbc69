"""The program of a student's step against its reference: every gradient, value and phase."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, load_view
from mobilegs.render import render_sortfree, visible_rows
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import C0
from mobilegs.train.student import trainer
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.model import StudentModel
from mobilegs.train.student.overdraw import overdraw
from mobilegs.train.student.program import ProgramDecode, opacities_and_scales, runs_program
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.init import gaussians_at
from tests.support.tiny import STUDENT, cameras, changed, with_kind

PHASES = {"explicit": 0.1, "latents": 0.4, "quantized": 0.8}
CONFIG: StudentConfig = changed(
    STUDENT,
    steps=400,
    level_sigma=1.0,
    schedule={"latents_from": 0.25, "rate_from": 0.3, "quantize_from": 0.65},
    quantization={"method": "sq", "rate_weight": 0.05},
    loss={"virtual_view_every": 4, "overdraw_weight": 0.05},
    pruning={"quantile": 0.0},
)
COUNT = 1300  # three blocks of the kernels, the last one not full


def teacher(count: int = COUNT) -> Scene:
    generator = torch.Generator().manual_seed(9)
    points = torch.randn(count, 3, generator=generator)
    made = gaussians_at(points, torch.rand(count, 3, generator=generator), opacity=0.6, sh_degree=1)
    made.log_scales += 0.5 * torch.randn(count, 3, generator=generator)
    made.quats[:] = torch.randn(count, 4, generator=generator)
    made.sh[:, 1:] = 0.2 * torch.randn(count, 3, 3, generator=generator)
    return Scene(made, near=0.2)


def student_in(
    phase: str, dataset: Dataset, *, step: int = 0, device: str = "cpu", **changes: Any
) -> Student:
    """Return a student in a phase, with values away from those of the start, without moments."""
    config = changed(CONFIG, **changes)
    photos = [frame.camera for frame in dataset.train]
    scene = teacher()
    scene = replace(
        scene, gaussians=scene.gaussians.to(device), background=scene.background.to(device)
    )
    student = Student(config, scene, photos, extent=dataset.extent, seed=0)
    student.done = 4 * round(PHASES[phase] * config.steps / 4) + step
    student._enter(student.phase)
    generator = torch.Generator().manual_seed(4)
    adams = student.model.rows, student.model.shared
    with torch.no_grad():
        for tensor in [t for adam in adams for t in adam.tensors.values()]:
            tensor += 0.1 * torch.randn(tensor.shape, generator=generator).to(device)
    student.model.reassign(codebooks=False)
    for adam in adams:
        adam.reset_all_moments()
    assert student.model.phase == phase
    return student


def advance(student: Student, dataset: Dataset, device: str = "cpu") -> None:
    student.advance([(index, load_view(dataset.train[index]).to(device)) for index in (0, 3)])


def after(student: Student) -> Iterator[tuple[str, torch.Tensor]]:
    """Return values and moments by name; after one step exp_avg is a tenth of the gradient."""
    for adam in (student.model.rows, student.model.shared):
        for name, state in adam.state().items():
            for key in ("value", "exp_avg", "exp_avg_sq"):
                yield f"{name} {key}", state[key]


# with the rate term, without, and with a depth pass
@pytest.mark.parametrize(("step", "depth_pass"), [(0, False), (1, False), (0, True)])
@pytest.mark.parametrize("phase", PHASES)
def test_a_step_is_that_of_the_reference(
    phase: str, step: int, depth_pass: bool, dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    changes: dict[str, Any] = {"step": step, "weighting": {"depth_pass": depth_pass}}
    program = student_in(phase, dataset, **changes)
    assert (program.model.weighting.name == "depth_pass") == depth_pass
    assert runs_program(program.model)
    advance(program, dataset)
    monkeypatch.setattr(trainer, "runs_program", lambda model: False)
    reference = student_in(phase, dataset, **changes)
    advance(reference, dataset)
    seen = 0
    for (name, ours), (other, theirs) in zip(after(program), after(reference), strict=True):
        assert name == other
        seen += bool(theirs.any())
        # where a gradient is nearly 0, rounding decides the direction of the first step
        limit = (2e-4 if depth_pass else 2e-5) if name.endswith("value") else 5e-4
        error = float((ours - theirs).norm())
        assert error <= limit * float(theirs.norm()) + 1e-12, (name, error, float(theirs.norm()))
    assert seen > 30


def overdraw_case(kind: str, dataset: Dataset) -> StudentModel:
    """Return a model of which the first camera sees few, round, faint or no Gaussians."""
    model = student_in("explicit", dataset).model
    values = model.rows.tensors
    with torch.no_grad():
        values["log_scales"][: COUNT // 8] += 2.5  # some of the size of the image
        if kind == "round":
            values["log_scales"][:] = values["log_scales"][:, :1]
        if kind == "faint":
            values["logit_opacities"][COUNT // 4 :] = -30
        if kind == "behind":
            camera = cameras()[0]
            away = 1 + values["means"].norm(dim=1, keepdim=True)
            values["means"][:] = camera.position - away * camera.viewmat[2, :3]
    return model


def overdraw_gradients(model: StudentModel, weight: float = 3.0) -> torch.Tensor:
    """Return the gradients of log-scales by a step of the kernels that has no other term."""
    decoded = ProgramDecode(model, cameras()[:2])
    for leaf in decoded.leaves:
        leaf.grad = torch.zeros_like(leaf)
    decoded.step(weight)
    return 10 * model.rows.state()["log_scales"]["exp_avg"]


def check_overdraw(kind: str, level_sigma: float, dataset: Dataset) -> None:
    model = overdraw_case(kind, dataset)
    model.level_sigma, camera = level_sigma, cameras()[0].to(dtype=torch.float64)
    with torch.no_grad():
        everything, inputs = model.gaussians()
        lobes = model.lobes(everything, inputs, None).double()
    means, quats = everything.means.detach().double(), everything.quats.detach().double()
    log_scales = everything.log_scales.detach().double().requires_grad_()
    rows = visible_rows(
        *(means, quats, log_scales.detach().exp()), camera=camera, footprint=model.footprint
    )
    found = overdraw(
        *(means[rows], quats[rows], log_scales[rows], torch.sigmoid(C0 * lobes[rows, 0, 0])),
        camera=camera,
        alpha_min=model.weighting.alpha_min,
        level_sigma=level_sigma,
        blur=model.footprint.blur,
    )
    (3 * found).backward()
    assert log_scales.grad is not None
    gradients = overdraw_gradients(model)
    error = float((gradients - log_scales.grad).norm())
    assert error <= 2e-4 * float(log_scales.grad.norm())  # in round ones terms cancel
    assert bool(gradients.any()) == (kind != "behind")


OVERDRAW_CASES = ["random", "round", "behind", "faint"]


@pytest.mark.parametrize("level_sigma", [0.0, 1.0])
@pytest.mark.parametrize("kind", OVERDRAW_CASES)
def test_overdraw_is_that_of_the_reference(kind: str, level_sigma: float, dataset: Dataset) -> None:
    check_overdraw(kind, level_sigma, dataset)


def check_overdraw_of_bad_values(dataset: Dataset) -> None:
    good = overdraw_gradients(overdraw_case("random", dataset))
    model = overdraw_case("random", dataset)
    names = ("means", "quats", "log_scales", "logit_opacities")
    for row, name in enumerate(names, 400):
        model.rows.tensors[name].data[row].view(-1)[0] = math.nan
    found = overdraw_gradients(model)
    assert not found[400:404].any() and good[400:404].any()
    assert torch.equal(found[404:], good[404:]) and torch.equal(found[:400], good[:400])


def test_values_that_are_not_finite_have_no_overdraw(dataset: Dataset) -> None:
    check_overdraw_of_bad_values(dataset)


@pytest.mark.parametrize("degree", [0, 1, 3])
@pytest.mark.parametrize("latents", [2, 9])
def test_other_shapes_of_the_default_kind(
    degree: int, latents: int, dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    view = {"degree": 1, "latents": latents}
    changes: dict[str, Any] = {"color": {"degree": degree}, "view_dependence": view}
    changes["loss"] = {"overdraw_weight": 0.0}  # its gradients cancel where scales are equal
    program = student_in("quantized", dataset, **changes)
    assert runs_program(program.model)
    advance(program, dataset)
    monkeypatch.setattr(trainer, "runs_program", lambda model: False)
    reference = student_in("quantized", dataset, **changes)
    advance(reference, dataset)
    for (name, ours), (_, theirs) in zip(after(program), after(reference), strict=True):
        assert float((ours - theirs).norm()) <= 2e-4 * float(theirs.norm()) + 1e-12, name


@pytest.mark.parametrize("phase", PHASES)
def test_decoded_values_are_those_of_the_reference(phase: str, dataset: Dataset) -> None:
    model = student_in(phase, dataset).model
    decoded = ProgramDecode(model, cameras()[:2])
    everything, inputs = model.gaussians()
    known = everything.tensors() | {"lobes": model.lobes(everything, inputs, None)}
    rows = decoded.shown[: len(decoded.detached["means"])].long()
    for name, values in decoded.detached.items():
        expected = known[name].detach()[rows]
        torch.testing.assert_close(values.detach(), expected, atol=2e-6, rtol=2e-6)


@pytest.mark.parametrize("phase", PHASES)
def test_votes_see_the_opacities_of_the_reference(phase: str, dataset: Dataset) -> None:
    model = student_in(phase, dataset).model
    found = opacities_and_scales(model, cameras()[:3])
    for camera, (opacities, scales) in zip(cameras()[:3], found, strict=True):
        expected = model.opacities_and_scales(camera)
        torch.testing.assert_close(opacities, expected[0], atol=1e-5, rtol=1e-5)
        torch.testing.assert_close(scales, expected[1], atol=1e-6, rtol=1e-5)


def test_no_gaussian_that_a_camera_shows_is_left_out(dataset: Dataset) -> None:
    model = student_in("latents", dataset).model
    near = [camera.reduced(1) for camera in cameras()]
    zoomed = [Camera(c.viewmat, c.K * torch.tensor([[9.0], [9], [1]]), 24, 24) for c in near]
    for camera in (*near, *zoomed):
        decoded = ProgramDecode(model, [camera])
        shown = set(decoded.shown[: len(decoded.detached["means"])].tolist())
        with torch.no_grad():
            everything, inputs = model.gaussians()
            drawn = render_sortfree(
                *(everything.means, everything.quats, everything.scales),
                *(model.lobes(everything, inputs, None), everything.sh),
                camera=camera,
                weighting=model.weighting,
                footprint=model.footprint,
                level_sigma=model.level_sigma,
            )
        needed = set(drawn.radii.nonzero()[:, 0].tolist())
        assert needed <= shown
        assert len(shown) < COUNT or camera not in zoomed


def test_the_bits_do_not_depend_on_the_number_of_threads(dataset: Dataset) -> None:
    results, before = [], torch.get_num_threads()
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        try:
            student = student_in("latents", dataset)
            advance(student, dataset)
        finally:
            torch.set_num_threads(before)
        results.append(dict(after(student)))
    for other in results[1:]:
        assert all(torch.equal(results[0][name], values) for name, values in other.items())


def test_a_view_without_gaussians_moves_them_by_their_moments_only(dataset: Dataset) -> None:
    model = student_in("latents", dataset).model
    away = Camera(torch.diag(torch.tensor([1.0, -1, -1, 1])), cameras()[0].K, 24, 24)
    away.viewmat[2, 3] = -50.0
    decoded = ProgramDecode(model, [away])
    assert len(decoded.detached["means"]) == 0
    drawn = decoded.render(0, background=torch.zeros(3))
    assert not drawn.image.any()
    before = {name: tensor.detach().clone() for name, tensor in model.rows.tensors.items()}
    for leaf in decoded.leaves:
        leaf.grad = torch.zeros_like(leaf)
    decoded.step()
    for name, tensor in model.rows.tensors.items():
        assert torch.equal(tensor.detach(), before[name])


def test_other_students_have_no_program(dataset: Dataset) -> None:
    photos = [frame.camera for frame in dataset.train]
    for config in (
        STUDENT,
        with_kind("network"),
        with_kind("constant"),
        changed(CONFIG, color={"decoder": "networks"}),
    ):
        student = Student(config, teacher(50), photos, extent=dataset.extent, seed=0)
        assert not runs_program(student.model)
