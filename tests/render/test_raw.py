"""Rendering from the values that training optimises, against the same from scales and opacities."""

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.render import Weighting, render_raw, render_sorted, render_sortfree
from mobilegs.render.inputs import MoreHarmonics, RenderInputs, RenderSettings
from mobilegs.render.project import CLASSIC
from tests.support.scenes import camera, cotangents, random_scene

NAMES = ("means", "quats", "log_scales", "logits", "sh0", "rest", "lobes")


@pytest.fixture(params=["cpu", "cuda"])
def kernels(request):
    if request.param == "cuda":
        request.getfixturevalue("on_host")


def leaves_of(degree: int) -> dict[str, torch.Tensor]:
    scene = {k: v.float() for k, v in random_scene(90, degree=3, lobe_degree=1, seed=7).items()}
    columns = (degree + 1) ** 2
    parts = {
        "means": scene["means"],
        "quats": scene["quats"],
        "log_scales": scene["scales"].log(),
        "logits": scene["opacities"].logit(),
        "sh0": scene["sh"][:, :1].clone(),
        "rest": scene["sh"][:, 1:columns].clone(),
        "lobes": scene["lobes"],
    }
    return {name: value.requires_grad_() for name, value in parts.items()}


def gradients(rendered, leaves):
    tangents = cotangents(camera())
    loss = (rendered.image * tangents["image"].float()).sum()
    loss = loss + (rendered.alpha * tangents["alpha"].float()).sum()
    loss.backward()
    return {name: leaf.grad for name, leaf in leaves.items() if leaf.grad is not None}


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize("degree", [0, 1, 3])
@pytest.mark.parametrize("blend", ["sorted", "sortfree"])
def test_values_and_gradients_are_those_of_the_public_function(blend, degree):
    view = camera().to(dtype=torch.float32)
    ours, theirs = leaves_of(degree), leaves_of(degree)
    background = torch.tensor([0.1, 0.2, 0.3])
    ends = {"camera": view, "background": background}
    wide = torch.cat(
        [ours["rest"].detach(), torch.full((90, 16 - ours["rest"].shape[1], 3), 9.0)], 1
    )
    more = MoreHarmonics(wide, torch.ones_like(wide)) if degree else None
    is_sorted = blend == "sorted"
    inputs = RenderInputs(
        *(ours["means"], ours["quats"], ours["log_scales"]),
        *((ours["logits"], ours["sh0"], None) if is_sorted else (None, ours["sh0"], ours["lobes"])),
    )
    settings = RenderSettings(Weighting(), CLASSIC, 0.0 if is_sorted else 1.0)
    found = render_raw(inputs, settings=settings, more=more, sh_degree=degree, **ends)
    sh = torch.cat([theirs["sh0"], theirs["rest"]], dim=1)
    shapes = (theirs["means"], theirs["quats"], theirs["log_scales"].exp())
    if is_sorted:
        expected = render_sorted(*shapes, theirs["logits"].sigmoid(), sh, **ends)
    else:
        expected = render_sortfree(*shapes, theirs["lobes"], sh, level_sigma=1.0, **ends)
    torch.testing.assert_close(found.image, expected.image, rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(found.radii, expected.radii, rtol=1e-4, atol=1e-4)
    grads, wanted = gradients(found, ours), gradients(expected, theirs)
    if more is not None:
        columns = ours["rest"].shape[1]
        grads["rest"] = more.gradients[:, :columns] - 1  # they were added
        assert (more.gradients[:, columns:] == 1).all()
        assert torch.equal(
            more.gradients[found.radii == 0], torch.ones_like(wide)[found.radii == 0]
        )
    wanted = {name: grad for name, grad in wanted.items() if name != "rest" or degree}
    assert grads.keys() == wanted.keys()
    for name, grad in wanted.items():
        assert (grads[name] - grad).norm() <= 2e-4 * grad.norm(), name


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize("name", ["log_scales", "logits"])
def test_a_parameter_that_is_not_finite_leaves_its_gaussian_out(name):
    leaves = {k: v.detach() for k, v in leaves_of(0).items()}
    leaves[name][3] = torch.nan
    leaves[name][5] = torch.inf if name == "log_scales" else torch.nan
    inputs = RenderInputs(
        *(leaves["means"], leaves["quats"], leaves["log_scales"], leaves["logits"]),
        *(leaves["sh0"], None),
    )
    view = camera().to(dtype=torch.float32)
    drawn = render_raw(inputs, view, torch.zeros(3), RenderSettings(), sh_degree=0)
    assert drawn.image.isfinite().all()
    assert drawn.radii[[3, 5]].tolist() == [0, 0] and drawn.radii.any()


def test_harmonics_that_do_not_belong_to_the_view_are_refused():
    leaves = {k: v.detach() for k, v in leaves_of(1).items()}
    inputs = RenderInputs(
        *(leaves["means"], leaves["quats"], leaves["log_scales"], leaves["logits"]),
        *(leaves["sh0"], None),
    )
    view = camera().to(dtype=torch.float32)
    for values, grads in (
        (leaves["rest"][:, :2], leaves["rest"][:, :2]),
        (leaves["rest"], leaves["rest"][:5]),
        (leaves["rest"], leaves["rest"].double()),
        (leaves["rest"].transpose(1, 2).contiguous().transpose(1, 2), leaves["rest"]),
    ):
        with pytest.raises(InputError):
            more = MoreHarmonics(values, grads)
            render_raw(inputs, view, torch.zeros(3), RenderSettings(), more=more, sh_degree=1)
