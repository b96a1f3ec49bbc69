"""Teacher and student on a tiny capture: they learn, and they go on where they were stopped."""

from copy import deepcopy
from dataclasses import replace

import pytest
import torch
from tiny import CPU, STUDENT, TEACHER, blobs, cameras, draw, train, with_kind

from mobilegs.compress.codebooks import CUTS
from mobilegs.compress.container import pack, unpack
from mobilegs.compress.positions import Frame
from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.errors import InputError
from mobilegs.render.lobes import seen_along
from mobilegs.render.scene import Scene
from mobilegs.train.densify import DensifyConfig
from mobilegs.train.distill import TeacherPictures
from mobilegs.train.seen import Seen
from mobilegs.train.stage import view_order
from mobilegs.train.student import Student
from mobilegs.train.student_config import StudentConfig
from mobilegs.train.teacher import Teacher, TeacherConfig
from mobilegs.train.view_dependence import KINDS, ViewDependence

pytest_plugins = ["tiny"]


def same_state(first: dict, second: dict) -> bool:
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(same_state(first[k], second[k]) for k in first)
    if isinstance(first, torch.Tensor):
        return torch.equal(first, second)
    return first == second


# --- the order of the views


def test_every_pass_shows_every_view_once_in_another_order() -> None:
    order = view_order(5, 0, 15, seed=1)
    passes = [order[:5], order[5:10], order[10:]]
    assert all(sorted(p) == [0, 1, 2, 3, 4] for p in passes)
    assert len({tuple(p) for p in passes}) > 1


@pytest.mark.parametrize("first", [0, 3, 5, 13])
def test_the_order_is_the_same_wherever_one_starts_to_ask(first: int) -> None:
    assert view_order(5, first, 9, seed=1) == view_order(5, 0, 40, seed=1)[first : first + 9]


# --- the teacher


def test_the_teacher_learns(dataset: Dataset) -> None:
    losses = train(Teacher(TEACHER, dataset, seed=0, device=CPU), dataset, 40)
    assert sum(losses[-6:]) < 0.8 * sum(losses[:6])


def test_the_teacher_grows_up_to_its_cap(dataset: Dataset) -> None:
    teacher = Teacher(TEACHER, dataset, seed=0, device=CPU)
    assert teacher.count == 40
    train(teacher, dataset, 20)
    assert 40 < teacher.count <= 60


def test_a_fixed_teacher_keeps_its_number(dataset: Dataset) -> None:
    config = replace(TEACHER, densify=DensifyConfig(strategy="fixed"))
    teacher = Teacher(config, dataset, seed=0, device=CPU)
    train(teacher, dataset, 20)
    assert teacher.count == 40 and teacher.phase == "refine"


def test_a_teacher_follows_the_sum_of_its_views_gradients(dataset: Dataset) -> None:
    apart, together = (
        Teacher(replace(TEACHER, views_per_step=3), dataset, seed=0, device=CPU) for _ in range(2)
    )
    views = [(index, load_view(dataset.train[index])) for index in (4, 0, 2)]
    losses = []
    for _, view in views:
        loss, *_ = apart._look(view)
        loss.backward()
        losses.append(loss)
    expected = {name: t.grad.clone() for name, t in apart.adam.tensors.items()}
    together.adam.step = lambda: None
    assert together.advance(views).loss == torch.stack(losses).mean()
    for name, tensor in together.adam.tensors.items():
        assert torch.equal(tensor.grad, expected[name]), name
        assert (tensor.grad != 0).any() or name == "sh_rest"


def test_densification_observes_every_view_of_a_step(dataset: Dataset) -> None:
    teacher = Teacher(replace(TEACHER, views_per_step=2), dataset, seed=0, device=CPU)
    views = [(index, load_view(dataset.train[index])) for index in (3, 1)]
    observed = []
    drawn = teacher.gaussians()
    teacher.strategy.observe = lambda *seen, **more: observed.append((*seen, *more.values()))
    teacher.advance(views)
    for (step, shown, camera, screen_grads, radii), (_, view) in zip(observed, views, strict=True):
        assert step == 1 and torch.equal(camera.viewmat, view.camera.viewmat)
        assert torch.equal(shown.means, drawn.means)  # before they move
        assert (screen_grads != 0).any() and (radii > 0).any()
    assert not torch.equal(observed[0][3], observed[1][3])


@pytest.mark.parametrize("config", [TeacherConfig, StudentConfig])
def test_a_step_without_views_is_refused(config: type) -> None:
    with pytest.raises(InputError, match="views_per_step must be at least 1, not 0"):
        config(views_per_step=0)


def test_harmonics_rise_with_the_run(dataset: Dataset) -> None:
    teacher = Teacher(replace(TEACHER, sh_interval=0.1), dataset, seed=0, device=CPU)
    degrees = []
    for done in (0, 3, 4, 8, 12, 39):
        teacher.done = done
        degrees.append(teacher.sh_degree)
    assert degrees == [0, 0, 1, 2, 3, 3]


@pytest.mark.parametrize("min_views", [1, 2])
def test_what_too_few_cameras_see_is_gone_in_the_end(dataset: Dataset, min_views: int) -> None:
    config = replace(TEACHER, min_views=min_views, densify=DensifyConfig(strategy="fixed"))
    teacher = Teacher(replace(config, steps=2), dataset, seed=0, device=CPU)
    with torch.no_grad():
        before_one_eye = 0.85 * dataset.train[0].camera.position
        teacher.adam.tensors["means"][0] = before_one_eye
        teacher.adam.tensors["log_scales"][0] = -4
    train(teacher, dataset, 1)
    assert teacher.count == 40
    train(teacher, dataset, 2)
    assert teacher.count == (40 if min_views == 1 else 39)


@pytest.mark.parametrize("stop", [1, 13])
def test_a_teacher_that_was_stopped_ends_the_same(dataset: Dataset, stop: int) -> None:
    whole = Teacher(TEACHER, dataset, seed=0, device=CPU)
    train(whole, dataset, 24)
    first = Teacher(TEACHER, dataset, seed=0, device=CPU)
    train(first, dataset, stop)
    second = Teacher(TEACHER, dataset, seed=9, device=CPU)
    second.restore(first.state())
    train(second, dataset, 24)
    assert same_state(whole.state(), second.state())


# --- the teacher's pictures


def test_what_the_teacher_shows_does_not_depend_on_the_cache() -> None:
    camera = cameras()[0]
    kept = TeacherPictures(Scene(blobs()), cache_bytes=1 << 20)
    drawn = TeacherPictures(Scene(blobs()), cache_bytes=0)
    for _ in range(2):
        for a, b in zip(kept.get(0, camera), drawn.get(0, camera), strict=True):
            assert torch.equal(a, b)
    assert kept.left == (1 << 20) - 24 * 24 * 8 and drawn.left == 0


def test_the_teachers_depth_is_the_mean_where_it_covers() -> None:
    camera = cameras()[0]
    rendered = Scene(blobs()).render(camera, depth=True)
    picture = TeacherPictures(Scene(blobs()), cache_bytes=0).get(0, camera)
    assert rendered.depth is not None
    covered = rendered.alpha > 0.5
    assert covered.any() and not covered.all()
    expected = rendered.depth[covered] / rendered.alpha[covered]
    torch.testing.assert_close(picture.depth[covered], expected, rtol=1e-3, atol=0)
    assert (picture.depth[~covered] == 0).all()


def test_a_raw_depth_is_the_sum_that_the_release_compares() -> None:
    camera = cameras()[0]
    rendered = Scene(blobs()).render(camera, depth=True)
    assert rendered.depth is not None
    for level in (0.0, 1.0):
        scene = Scene(blobs(), background=torch.full((3,), level))
        picture = TeacherPictures(scene, cache_bytes=0, raw=True).get(0, camera)
        expected = rendered.depth + level * (1 - rendered.alpha)
        torch.testing.assert_close(picture.depth, expected, rtol=1e-3, atol=0)


# --- the student


@pytest.mark.parametrize("kind", KINDS)
def test_the_student_starts_with_the_teachers_opacities(kind: str, make_student) -> None:
    model = make_student(with_kind(kind)).model
    camera, (some, for_lobes) = cameras()[0], model.gaussians()
    directions = torch.nn.functional.normalize(some.means - camera.position, dim=1)
    opacities, phi = seen_along(model.lobes(some, for_lobes, camera), directions)
    torch.testing.assert_close(opacities, blobs().opacities, atol=1e-4, rtol=0)
    torch.testing.assert_close(model.seen_from(camera)[0], opacities)
    torch.testing.assert_close(phi, torch.ones_like(phi), atol=1e-3, rtol=0)


@pytest.mark.parametrize("kind", KINDS)
def test_training_draws_what_evaluation_draws(kind: str, dataset: Dataset, make_student) -> None:
    student = make_student(with_kind(kind))
    for until in (5, 20, 40):  # explicit, networks, codes
        train(student, dataset, until)
        drawn = draw(student, depth=True)
        again = student.scene().render(cameras()[0], depth=True)
        torch.testing.assert_close(drawn.image, again.image, atol=1e-5, rtol=0)
    assert student.model.phase == "codes"


@pytest.mark.parametrize(
    ("latents", "streams"), [(0, {}), (1, {"opacity"}), (6, {"opacity", "lobes"})]
)
def test_as_many_numbers_are_stored_as_were_asked_for(
    latents: int, streams: set[str], dataset: Dataset, make_student
) -> None:
    view = ViewDependence("latent", latents=latents, length=3, size=9, hidden=5)
    student = make_student(replace(STUDENT, view=view))
    train(student, dataset, 40)
    coded = student.coded()
    assert set(coded.codebooks) == {"scale", "rotation", "appearance", *streams}
    if "lobes" in streams:
        assert coded.codebooks["lobes"].shape == (2, 9, 3)
    drawn = draw(student)
    opened = unpack(pack(coded)).decode().render(cameras()[0])
    torch.testing.assert_close(drawn.image, opened.image, atol=1e-5, rtol=0)


def test_the_student_learns_in_every_form(dataset: Dataset, make_student) -> None:
    config = replace(with_kind("projected"), net_fraction=0.25, codes_fraction=0.5)
    losses = train(make_student(config), dataset, 40)
    assert sum(losses[18:24]) < sum(losses[:6])
    assert sum(losses[-6:]) < sum(losses[20:26])  # codebooks learn


@pytest.mark.parametrize("kind", KINDS)
def test_a_student_that_was_stopped_ends_in_the_same_bytes(
    dataset: Dataset, make_student, kind: str
) -> None:
    config = with_kind(kind)
    whole, states = make_student(config), {}
    for stop, phase in ((3, "explicit"), (12, "networks"), (20, "networks"), (30, "codes")):
        train(whole, dataset, stop)
        assert whole.model.phase == phase
        states[stop] = deepcopy(whole.state())
    train(whole, dataset, 40)
    expected = pack(whole.coded())
    for stop, state in states.items():
        second = make_student(config, seed=9)
        second.restore(state)
        train(second, dataset, 40)
        assert pack(second.coded()) == expected, stop


def test_the_cache_of_the_teachers_pictures_does_not_change_training(
    dataset: Dataset, make_student
) -> None:
    students = [make_student(replace(STUDENT, cache_mib=size)) for size in (0, 100)]
    for student in students:
        train(student, dataset, 12)
    assert same_state(students[0].state(), students[1].state())


@pytest.mark.parametrize("kind", KINDS)
def test_a_student_follows_the_sum_of_its_views_gradients(
    kind: str, dataset: Dataset, make_student
) -> None:
    student = make_student(with_kind(kind))
    views = [(index, load_view(dataset.train[index])) for index in (4, 0, 2)]
    for until in (5, 20, 30):  # explicit, networks, codes
        train(student, dataset, until)
        apart = [gradients(student, [view]) for view in views]
        for name, grad in gradients(student, views).items():
            expected = sum(one[name] for one in apart)
            assert grad.isfinite().all() and ((expected != 0).any() or not expected.numel()), name
            distance = (grad - expected).norm() / expected.norm().clamp_min(1e-30)
            assert distance < 1e-5, f"{name} in {student.phase}: {distance:.1e}"


def gradients(student: Student, views: list[tuple[int, View]]) -> dict[str, torch.Tensor]:
    """What a step on these views would follow, by name."""
    student._pull([student.cameras[index] for index, _ in views], views)
    found = {}
    for adam in (student.model.rows, student.model.shared):
        found |= {n: t.grad.clone() for n, t in adam.tensors.items() if t.grad is not None}
        adam.adam.zero_grad()
    return found


def test_of_several_cameras_each_sees_its_own(dataset: Dataset, make_student) -> None:
    student = make_student()
    near = [replace(camera, near=2.9 + 0.1 * i) for i, camera in enumerate(cameras())]
    seen = Seen(student.model, near)
    assert 0 < len(seen.rows[0]) < len(seen.decoded["means"]) < 50
    for number, camera in enumerate(near):
        options = {"background": student.background}
        together, alone = seen.draw(number, **options), Seen(student.model, [camera])
        assert torch.equal(together.image, alone.draw(0, **options).image)


def test_moments_survive_the_changes_of_form(dataset: Dataset, make_student) -> None:
    student = make_student(with_kind("network"))
    train(student, dataset, 6)
    model = student.model
    before = {n: model.rows.adam.state[model.rows.tensors[n]] for n in ("means", "quats")}
    student._enter("networks")
    for name, state in before.items():
        assert model.rows.adam.state[model.rows.tensors[name]] is state
    weights = model.shared.tensors["network.hidden1.weight"]
    moments = model.shared.adam.state[weights]
    student._enter("codes")
    assert model.shared.adam.state[weights] is moments
    assert "quats" not in model.rows.tensors and "means" in model.rows.tensors


def test_votes_remove_what_is_faint_and_small(dataset: Dataset, make_student) -> None:
    student = make_student(with_kind("decoded"))
    with torch.no_grad():
        student.model.rows.tensors["logit_opacities"][:4] = -4
        student.model.rows.tensors["log_scales"][:4] = -5
    train(student, dataset, 4)
    assert student.count < 50
    faint = student.model.rows.tensors["logit_opacities"] < -3
    assert not faint.any()


def test_pruning_in_coded_form_keeps_rows_and_indices_together(
    dataset: Dataset, make_student
) -> None:
    student = make_student()
    student._enter("codes")
    assert set(student.model.codebooks) == {*CUTS, "lobes"}
    before, latents = student.model.gaussians()
    keep = torch.arange(50) % 3 != 0
    student.model.keep_rows(keep)
    after, fewer = student.model.gaussians()
    assert latents.shape == (50, 12)
    torch.testing.assert_close(fewer, latents[keep], atol=1e-6, rtol=0)
    for name, value in before.tensors().items():
        torch.testing.assert_close(after.tensors()[name], value[keep], atol=1e-6, rtol=0)


def test_reassigning_follows_what_a_gaussian_has_learned_to_want(make_student) -> None:
    model = make_student(with_kind("network")).model
    generator = torch.Generator().manual_seed(0)
    frame = Frame.around(model.shapes()[0])
    model.use_networks(frame, regression_steps=1, generator=generator)
    model.use_codes(STUDENT.codebooks, generator=torch.Generator().manual_seed(0))
    book = model.codebooks["scale"]
    with torch.no_grad():
        model.rows.tensors["scale"][7] = book.stored_centers[:, 3, 0]
    assert book.indices[7].tolist() != [3, 3, 3]
    model.reassign(all_codes=True)
    assert book.indices[7].tolist() == [3, 3, 3]


def test_a_student_of_one_step_is_coded_in_the_end(dataset: Dataset, make_student) -> None:
    student = make_student(replace(STUDENT, steps=1))
    train(student, dataset, 1)
    assert len(student.coded()) == student.count


def test_a_centre_moves_no_further_than_a_share_of_the_usual_gaussian(dataset: Dataset) -> None:
    sizes = blobs().scales.topk(2, dim=1).values.prod(1).sqrt()
    for share, rate, expected in ((0.02, 1.0, 0.02 * float(sizes.median())), (9.0, 1e-3, 3e-3)):
        config = replace(STUDENT, position_share=share, position_rate=rate)
        student = Student(config, Scene(blobs()), cameras(), extent=3.0, seed=0)
        train(student, dataset, 1)
        after = student.model.rows.tensors["means"].detach()  # some are gone
        moved = (after[:, None] - blobs().means).abs().amax(2).amin(1)
        assert float(moved.max()) == pytest.approx(expected, rel=1e-3)  # a step of Adam


def test_a_teacher_of_another_degree_is_cut_or_filled_up(dataset: Dataset) -> None:
    for coefficients in (1, 16):
        teacher = replace(blobs(), sh=torch.ones(50, coefficients, 3))
        model = Student(STUDENT, Scene(teacher), cameras(), extent=3.0, seed=0).model
        sh = model.gaussians()[0].sh
        assert sh.shape == (50, 4, 3)
        assert (sh[:, 1:] == (coefficients > 1)).all()


@pytest.mark.parametrize("kind", KINDS)
def test_a_scene_with_lobes_says_their_mean_opacity(
    kind: str, dataset: Dataset, make_student
) -> None:
    student = make_student(with_kind(kind))
    for until in (5, 20, 40):
        train(student, dataset, until)
        scene = student.scene()
        none = student.model.network is not None or kind == "constant"
        assert (scene.lobes is None) == none
        if scene.lobes is not None:
            mean = 0.28209479177387814 * scene.lobes[:, 0, 0]
            torch.testing.assert_close(scene.gaussians.logit_opacities, mean)


def test_lobes_must_settle_before_they_are_coded() -> None:
    late = {"fraction": 0.8}
    with pytest.raises(InputError, match="settled"):
        StudentConfig(codes_fraction=0.7, view=ViewDependence("projected", **late))
    for kind in ("network", "decoded"):
        StudentConfig(codes_fraction=0.7, view=ViewDependence(kind, **late))


def test_phases_out_of_order_are_refused() -> None:
    with pytest.raises(InputError, match="codes_fraction must rise"):
        StudentConfig(net_fraction=0.7, codes_fraction=0.5)
