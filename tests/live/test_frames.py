"""Frames of the live view: their budget, cameras, and colours."""

import math
from dataclasses import replace

import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.live.frame_budget import (
    BUDGET_MAX,
    FRAME_SECONDS,
    PIXELS_MIN,
    TIME_SHARE,
    FrameBudget,
)
from mobilegs.live.frames import (
    GREY,
    TrainingCameras,
    apply_colormap,
    error_map,
    letterbox,
    render_depth,
    side_by_side,
    view_psnr,
)
from mobilegs.render.scene import Scene
from tests.support.live import browser_at
from tests.support.tiny import blobs, cameras

# --- budget


class Clock:
    """A clock that tests advance."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.mark.parametrize("urgent", [True, False], ids=["moving", "resting"])
def test_frames_take_at_most_their_share_of_the_time(urgent: bool) -> None:
    clock = Clock()
    budget, spent = FrameBudget(clock), 0.0
    while clock.now < 1100:
        clock.now += 0.01  # a step
        if budget.allows(urgent=urgent):
            clock.now += 0.2
            spent += 0.2
            budget.spend(0.2)
    assert 0.9 * TIME_SHARE < spent / 1000 < TIME_SHARE + (BUDGET_MAX + 0.2) / 1000


def test_an_urgent_frame_may_use_the_reserve() -> None:
    clock = Clock()
    budget = FrameBudget(clock)
    budget.spend(0.7)
    assert budget.allows(urgent=True)
    assert not budget.allows(urgent=False)
    clock.now += 3
    assert budget.allows(urgent=False)


def test_the_resolution_follows_from_the_speed() -> None:
    budget = FrameBudget(Clock())
    budget.record_speed("resting", 100_000, 0.1)
    width, height = budget.size("resting", 3000, 2000)
    assert width * height == pytest.approx(1e6 * FRAME_SECONDS["resting"], rel=0.01)
    assert width / height == pytest.approx(1.5, rel=0.01)
    budget.record_speed("moving", 100_000, 100.0)
    width, height = budget.size("moving", 3000, 2000)
    assert width * height == pytest.approx(PIXELS_MIN["moving"], rel=0.02)
    assert budget.size("paused", 900, 600) == (900, 600)
    assert budget.size("moving", 20, 10) == (20, 10)


# --- images


def test_a_browser_in_the_place_of_a_photo_sees_its_render() -> None:
    scene, camera = Scene(blobs()), cameras()[0]
    seen = scene.render(browser_at(camera).camera(24, 24, camera.near)).image
    assert torch.allclose(seen, scene.render(camera).image, atol=1e-4)


def test_the_nearest_photo_has_a_similar_position_and_direction(dataset: Dataset) -> None:
    views = TrainingCameras(dataset)
    for index, frame in enumerate(dataset.train):
        assert views.nearest(browser_at(frame.camera)) == index
    # the position of one camera with the direction of its neighbour
    place, other = dataset.train[0].camera, dataset.train[1].camera
    turned = other.viewmat.clone()
    turned[:3, 3] = -turned[:3, :3] @ place.position
    near = replace(dataset, extent=100.0)
    assert TrainingCameras(near).nearest(browser_at(replace(place, viewmat=turned))) == 1


def test_up_is_the_direction_in_which_the_photos_are_level(dataset: Dataset) -> None:
    assert float(TrainingCameras(dataset).up[2]) > 0.9


def test_near_pixels_of_a_depth_image_are_bright() -> None:
    up = torch.tensor([0.0, -1, 0])
    K = torch.tensor([[28.0, 0, 12], [0, 28, 12], [0, 0, 1]])
    camera = Camera(look_at(torch.tensor([0.0, 0, -3]), torch.zeros(3), up), K, 24, 24)
    two = blobs().select(torch.tensor([0, 1]))
    two.means[:] = torch.tensor([[-0.6, 0, -1.0], [0.6, 0, 1.0]])
    two.log_scales[:], two.logit_opacities[:] = -1.3, 6.0
    image = render_depth(Scene(two), camera)
    left, right = image[12, 3:8].sum(1).max(), image[12, 14:18].sum(1).max()
    assert left > right + 0.5
    assert image[0, 0].tolist() == [0, 0, 0]  # no depth
    assert torch.equal(render_depth(Scene(two.select(torch.tensor([], dtype=torch.long))), camera),
                       torch.zeros(24, 24, 3))  # fmt: skip


def test_an_error_map_is_bright_only_at_unmasked_errors(dataset: Dataset) -> None:
    view = load_view(dataset.train[0])
    assert error_map(view.image, view).max() < 0.05
    wrong = view.image.clone()
    wrong[:6] = 1 - wrong[:6].round()
    assert error_map(wrong, view)[:6].mean() > 0.5
    assert error_map(wrong, view)[6:].max() < 0.05
    mask = torch.ones(24, 24)
    mask[:6] = 0
    masked = View(view.name, view.camera, view.image, mask)
    assert error_map(wrong, masked).max() < 0.05
    assert view_psnr(wrong, masked) == math.inf
    assert view_psnr(wrong, view) < 15


def test_images_fit_any_canvas() -> None:
    image = torch.ones(20, 30, 3)
    wide = letterbox(image, 900, 300)
    assert wide.shape == (20, 60, 3)
    assert (wide[:, 15:45] == 1).all() and (wide[:, :15] == GREY).all()
    high = letterbox(image, 300, 300)
    assert high.shape == (30, 30, 3) and (high[5:25] == 1).all()
    assert letterbox(image, 15, 10).shape == (10, 15, 3)
    assert side_by_side([image] * 3, 3.0).shape == (20, 102, 3)
    assert side_by_side([image] * 3, 0.5).shape == (72, 30, 3)


def test_the_colormap_gets_lighter_with_the_value() -> None:
    colors = apply_colormap(torch.linspace(0, 1, 50)[None])[0]
    assert (colors.sum(1).diff() > 0).all()
    assert torch.equal(apply_colormap(torch.tensor([[math.nan, -1.0, 2.0]]))[0, 0], colors[0])
