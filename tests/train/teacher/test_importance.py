"""Importance, sampling and trimming of Gaussians, and surface points."""

import math
from dataclasses import replace

import torch

from mobilegs.camera import Camera, look_at
from mobilegs.data.dataset import Frame
from mobilegs.gaussians import Gaussians
from mobilegs.render import measure_contributions
from mobilegs.render.project import rotation_matrices
from mobilegs.train.teacher import surface_points as module
from mobilegs.train.teacher.importance import importance, importance_mask, sample_rows
from mobilegs.train.teacher.init import gaussians_at
from mobilegs.train.teacher.surface_points import ray_depths, surface_points

K = torch.tensor([[30.0, 0, 15], [0, 28, 11], [0, 0, 1]])
UP = torch.tensor([0.0, -1, 0])


def camera(eye: list[float], **changes) -> Camera:
    position = torch.tensor(eye, dtype=torch.float32)
    return Camera(look_at(position, torch.zeros(3), UP), K, **{"width": 32, "height": 24} | changes)


def wall(opacity: float = 0.95) -> Gaussians:
    """A plane z = 0 of round Gaussians, a small one hidden behind it, and one out of sight."""
    x, y = torch.meshgrid(torch.linspace(-3, 3, 25), torch.linspace(-3, 3, 25), indexing="ij")
    points = torch.stack([x.flatten(), y.flatten(), torch.zeros(625)], dim=1)
    points = torch.cat([points, torch.tensor([[0.1, 0.1, 2.0], [0, 0, -50]])])
    made = gaussians_at(points, torch.rand(len(points), 3), opacity=opacity, sh_degree=0)
    made.log_scales[:, 2] = math.log(1e-3)
    made.log_scales[625:] = math.log(0.01)
    return made


EYES = [camera([0, 0, -3]), camera([0.5, 0.2, -3])]


# --- importance


def test_a_gaussian_that_dominates_no_pixel_has_no_importance() -> None:
    for metric in ("indoor", "outdoor"):
        worth = importance(wall(), EYES, metric)
        assert (worth[625:] == 0).all() and (worth[:625] > 0).any()


def test_the_two_metrics_are_sums_over_the_views() -> None:
    made = wall(opacity=0.4)
    shapes = (made.means, made.quats, made.scales, made.opacities)
    found = [measure_contributions(*shapes, camera=view) for view in EYES]
    wins = [each.largest > 0 for each in found]
    indoor = (found[0].weights + found[1].weights) * (wins[0] | wins[1])
    outdoor = sum(
        won * each.weights / each.touched.clamp_min(1)
        for won, each in zip(wins, found, strict=True)
    )
    assert (wins[0] != wins[1]).any()
    torch.testing.assert_close(importance(made, EYES, "indoor"), indoor)
    torch.testing.assert_close(importance(made, EYES, "outdoor"), outdoor)


def test_sampling_has_no_repetition_and_no_zero_weights(generator: torch.Generator) -> None:
    weights = torch.tensor([0.0, 1, 2, 0, 1e-30, 4])
    for count in (0, 1, 3, 4, 100):
        rows = sample_rows(weights, count, generator)
        assert len(set(rows.tolist())) == len(rows) == min(count, 4)
        assert set(rows.tolist()) <= {1, 2, 4, 5}
    assert len(sample_rows(torch.zeros(3), 2, generator)) == 0


def test_the_smallest_hundredth_is_masked() -> None:
    values = torch.tensor([50.0, 0.5, 0.0, 48.9, 0.4, 0.2])
    assert importance_mask(values, 0.99).tolist() == [True, True, False, True, False, False]
    assert importance_mask(torch.zeros(4), 0.99).all()
    assert importance_mask(torch.zeros(0), 0.99).shape == (0,)


# --- surface points


def test_the_ray_depth_is_midway_between_both_intersections(generator: torch.Generator) -> None:
    """The derivative of the squared distance along the ray, |A^-1 (o + t d - m)|^2, is 0 there."""

    def normal(*shape):
        return torch.randn(*shape, generator=generator, dtype=torch.float64)

    origin = torch.tensor([0.1, 0.2, -3.0], dtype=torch.float64)
    means, quats, log_scales = normal(5, 3), normal(5, 4), 0.5 * normal(5, 3)
    directions = torch.tensor([0.03, -0.02, 1.0], dtype=torch.float64) + 0.01 * normal(5, 3)
    made = Gaussians(means, quats, log_scales, means.new_zeros(5), means.new_zeros(5, 1, 3))
    found = ray_depths(origin, directions, made)
    for i, turn in enumerate(rotation_matrices(quats)):
        local = turn.T / log_scales[i].exp()[:, None]
        offset, along = local @ (origin - means[i]), local @ directions[i]
        torch.testing.assert_close(found[i], -(offset @ along) / (along @ along))


def test_points_lie_on_their_rays_where_the_surface_is(generator: torch.Generator) -> None:
    frames = [
        Frame("a", EYES[0], pixels=torch.zeros(24, 32, 3, dtype=torch.uint8)),
        Frame("b", EYES[1], pixels=torch.full((24, 32, 3), 255, dtype=torch.uint8)),
    ]
    points, colors = surface_points(wall(), frames, count=200, generator=generator)
    assert points.shape == colors.shape == (200, 3)
    assert (points[:, 2].abs() < 2e-2).all()  # of the plane, not of Gaussians' centres
    assert colors[:100].max() == 0 and colors[100:].min() == 1
    for view, part in zip(EYES, (points[:100], points[100:]), strict=True):
        seen = part @ view.viewmat[:3, :3].T + view.viewmat[:3, 3]
        pixels = seen[:, :2] / seen[:, 2:] * K.diagonal()[:2] + K[:2, 2]
        torch.testing.assert_close(pixels, pixels.floor() + 0.5, rtol=0, atol=1e-3)
        assert len({tuple(p) for p in pixels.floor().tolist()}) == 100


def test_a_masked_pixel_gives_no_point(generator: torch.Generator, monkeypatch) -> None:
    frame = Frame("a", EYES[0], pixels=torch.zeros(24, 32, 3, dtype=torch.uint8))
    mask = torch.zeros(24, 32)
    mask[:, :8] = 1
    load = module.load_view
    monkeypatch.setattr(module, "load_view", lambda frame: replace(load(frame), mask=mask))
    points, _ = surface_points(wall(), [frame], count=10_000, generator=generator)
    seen = points @ EYES[0].viewmat[:3, :3].T + EYES[0].viewmat[:3, 3]
    columns = seen[:, 0] / seen[:, 2] * K[0, 0] + K[0, 2]
    assert len(points) == 24 * 8 and (columns < 8).all()


def test_an_empty_view_gives_no_point(generator: torch.Generator) -> None:
    away = Camera(torch.diag(torch.tensor([-1.0, 1, -1, 1])), K, 32, 24)
    frame = Frame("a", away, pixels=torch.zeros(24, 32, 3, dtype=torch.uint8))
    nothing = wall().select(slice(0, 626))
    assert surface_points(nothing, [frame], count=50, generator=generator)[0].shape == (0, 3)


def test_fewer_points_than_photos_come_from_some_of_them(generator: torch.Generator) -> None:
    pixels = torch.zeros(24, 32, 3, dtype=torch.uint8)
    frames = [Frame(str(i), camera([0.1 * i, 0, -3]), pixels=pixels) for i in range(7)]
    for count in (1, 3, 6, 7, 8, 20):
        points, _ = surface_points(wall(), frames, count=count, generator=generator)
        assert 0.5 * count <= len(points) <= count
