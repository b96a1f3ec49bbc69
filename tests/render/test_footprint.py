"""Footprints: compensated opacity and soft edges, the reference against numpy."""

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render import Footprint, measure_contributions, render_sorted, render_sortfree
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import pair_alphas, project
from tests.support.golden import BACKGROUND, inputs_of
from tests.support.scenes import SORTED, SORTFREE


def _by_numpy(scene: dict, view: Camera, footprint: Footprint, least: float) -> np.ndarray:
    """Return alpha of every Gaussian at every pixel, `[h, w, n]`."""
    means, quats, scales = (scene[name].numpy() for name in SORTED[:3])
    directions = scene["means"] - view.position
    directions = torch.nn.functional.normalize(directions, dim=1)
    opacities = evaluate_lobes(scene["lobes"], directions)[0].numpy()
    rotation, offset = view.viewmat[:3, :3].numpy(), view.viewmat[:3, 3].numpy()
    fx, fy, cx, cy = (view.K[i].item() for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    rows, columns = np.mgrid[: view.height, : view.width] + 0.5
    found = np.zeros((view.height, view.width, len(means)))
    for i, (w, x, y, z) in enumerate(quats / np.linalg.norm(quats, axis=1, keepdims=True)):
        turn = np.array(
            [
                [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
            ]
        )
        a, b, c = rotation @ means[i] + offset
        if c <= view.near:
            continue
        inner = [-0.3 * 0.5 * n / f for n, f in ((view.width, fx), (view.height, fy))]
        u = np.clip(a / c, -cx / fx + inner[0], (view.width - cx) / fx - inner[0])
        v = np.clip(b / c, -cy / fy + inner[1], (view.height - cy) / fy - inner[1])
        jacobian = np.array([[fx / c, 0, -fx / c * u], [0, fy / c, -fy / c * v]]) @ rotation
        before = jacobian @ turn @ np.diag(scales[i] ** 2) @ turn.T @ jacobian.T
        after = before + footprint.blur * np.eye(2)
        offsets = np.stack([columns - fx * a / c - cx, rows - fy * b / c - cy], 2)
        q = np.einsum("hwi,ij,hwj->hw", offsets, np.linalg.inv(after), offsets)
        alpha = opacities[i] * np.exp(-q / 2)
        counts = alpha >= least
        if footprint.soft_edge:
            alpha = alpha - least
        if footprint.antialiased:
            alpha = alpha * np.sqrt(np.linalg.det(before) / np.linalg.det(after))
        found[..., i] = np.where(counts, np.minimum(alpha, 0.99), 0)
    return found


@pytest.mark.parametrize("soft_edge", [False, True])
@pytest.mark.parametrize("antialiased", [False, True])
@pytest.mark.parametrize("blur", [0.3, 0.1, 1.0])
def test_alpha_by_numpy(blur, antialiased, soft_edge):
    footprint = Footprint(blur, antialiased=antialiased, soft_edge=soft_edge)
    for case in ("several tiles", "around the camera"):
        scene, view = inputs_of(case)
        directions = torch.nn.functional.normalize(scene["means"] - view.position, dim=1)
        opacities = evaluate_lobes(scene["lobes"], directions)[0]
        means, quats, scales = (scene[name] for name in SORTED[:3])
        options = {"camera": view, "alpha_min": 1 / 64, "footprint": footprint}
        projected = project(means, quats, scales, opacities, scene["sh"], **options)
        size = (view.height, view.width)
        found = pair_alphas(projected, opacities, size, 1 / 64, soft_edge=soft_edge)
        expected = _by_numpy(scene, view, footprint, 1 / 64)
        np.testing.assert_allclose(found.reshape(expected.shape).numpy(), expected, atol=1e-10)


@pytest.mark.thorough
def test_an_antialiased_scene_keeps_its_coverage_at_every_size():
    scene, view = inputs_of("random, degree 1")
    scene["scales"] = scene["scales"] * 0.3  # most are smaller than a pixel
    inputs = [scene[name] for name in SORTFREE]
    coverages = {}
    for antialiased in (False, True):
        footprint = Footprint(0.1, antialiased=antialiased)
        options = {"background": BACKGROUND.double(), "footprint": footprint}
        coverages[antialiased] = [
            render_sortfree(*inputs, camera=view.resized(*size), **options).alpha.mean().item()
            for size in ((720, 592), (45, 37), (15, 12))
        ]
    exact, *others = coverages[True]
    assert all(abs(other / exact - 1) < 0.06 for other in others), coverages
    assert coverages[False][2] > 1.5 * exact, coverages


@pytest.mark.parametrize("backend", ["reference", "kernel"])
def test_a_gaussian_without_area_is_left_out_where_antialiased(backend):
    scene, view = inputs_of("zero size")
    dtype = torch.float32 if backend == "kernel" else torch.float64
    scene = {name: value.to(dtype) for name, value in scene.items()}
    options = {"camera": view.to(dtype=dtype), "background": BACKGROUND.to(dtype)}
    options |= {"footprint": Footprint(antialiased=True), "backend": backend}
    for render, names in ((render_sorted, SORTED), (render_sortfree, SORTFREE)):
        everything = render(*[scene[name] for name in names], **options)
        rest = render(*[scene[name][20:] for name in names], **options)
        torch.testing.assert_close(everything.image, rest.image)
        assert (everything.radii[:20] == 0).all()


def test_contributions_follow_the_footprint():
    scene, view = inputs_of("several tiles")
    given = [scene[name] for name in SORTED[:4]]
    footprint = Footprint(0.1, antialiased=True)
    exact = measure_contributions(*given, camera=view, footprint=footprint, backend="reference")
    assert not torch.equal(exact.weights, measure_contributions(*given, camera=view).weights)
    given = [value.float() for value in given]
    view = view.to(dtype=torch.float32)
    found = measure_contributions(*given, camera=view, footprint=footprint)
    torch.testing.assert_close(found.weights.double(), exact.weights, rtol=1e-3, atol=1e-3)


def test_impossible_footprints_are_refused():
    for blur in (0.0, -0.1, 5.0, float("nan")):
        with pytest.raises(InputError, match="blur must lie in"):
            Footprint(blur)
    scene, view = inputs_of("one Gaussian")
    with pytest.raises(InputError, match="sorted blending has no soft edge"):
        render_sorted(
            *[scene[name] for name in SORTED], camera=view, footprint=Footprint(soft_edge=True)
        )
