"""What is drawn of a training, how much of it, and in which colours."""

import math
from dataclasses import replace

import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.data.dataset import Dataset, View, load_view
from mobilegs.live.frame_budget import GOAL, LEAST, SAVED, SHARE, Pace
from mobilegs.live.frames import (
    AROUND,
    Eye,
    Viewpoints,
    decibels,
    drawn_depth,
    error_map,
    fitted,
    in_colors,
    side_by_side,
)
from mobilegs.render.scene import Scene
from tests.support.tiny import blobs, cameras


def eye_of(camera: Camera, *, width: int = 24, height: int = 24) -> Eye:
    """An eye where a camera is."""
    x, y, z = camera.position.tolist()
    turn = tuple(camera.viewmat[:3, :3].T.flatten().tolist())
    return Eye((x, y, z), turn, 2 * math.atan(12 / 28), width, height)


# --- how much is drawn


class Clock:
    """Seconds that pass when told to."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.mark.parametrize("urgent", [True, False], ids=["moving", "resting"])
def test_drawing_takes_no_more_than_its_share(urgent: bool) -> None:
    clock = Clock()
    pace, spent = Pace(clock), 0.0
    while clock.now < 1100:
        clock.now += 0.01  # a step
        if pace.allows(urgent=urgent):
            clock.now += 0.2
            spent += 0.2
            pace.spend(0.2)
    assert 0.9 * SHARE < spent / 1000 < SHARE + (SAVED + 0.2) / 1000


def test_a_picture_that_is_waited_for_goes_before_one_that_follows_the_training() -> None:
    clock = Clock()
    pace = Pace(clock)
    pace.spend(0.7)
    assert pace.allows(urgent=True)
    assert not pace.allows(urgent=False)
    clock.now += 3
    assert pace.allows(urgent=False)


def test_pictures_have_the_pixels_that_their_time_allows() -> None:
    pace = Pace(Clock())
    pace.learn("resting", 100_000, 0.1)
    width, height = pace.size("resting", 3000, 2000)
    assert width * height == pytest.approx(1e6 * GOAL["resting"], rel=0.01)
    assert width / height == pytest.approx(1.5, rel=0.01)
    pace.learn("moving", 100_000, 100.0)
    width, height = pace.size("moving", 3000, 2000)
    assert width * height == pytest.approx(LEAST["moving"], rel=0.02)
    assert pace.size("paused", 900, 600) == (900, 600)
    assert pace.size("moving", 20, 10) == (20, 10)


# --- what is drawn


def test_an_eye_where_a_photo_was_taken_sees_what_training_draws() -> None:
    scene, camera = Scene(blobs()), cameras()[0]
    seen = scene.render(eye_of(camera).camera(24, 24, camera.near)).image
    assert torch.allclose(seen, scene.render(camera).image, atol=1e-4)


def test_the_nearest_photo_is_near_and_looks_the_same_way(dataset: Dataset) -> None:
    views = Viewpoints(dataset)
    for index, frame in enumerate(dataset.train):
        assert views.nearest(eye_of(frame.camera)) == index
    # at the place of one, but turned as another that is not far away
    place, other = dataset.train[0].camera, dataset.train[1].camera
    turned = replace(eye_of(place), rotation=eye_of(other).rotation)
    near = replace(dataset, extent=100.0)
    assert Viewpoints(near).nearest(turned) == 1


def test_who_stands_where_a_photo_was_taken_sees_all_of_it(dataset: Dataset) -> None:
    views, camera = Viewpoints(dataset), dataset.train[2].camera
    position, target = views.stand(2)
    assert torch.allclose(position.float(), camera.position, atol=1e-5)
    assert torch.allclose(target.float(), dataset.center, atol=1e-4)
    assert views.fov(2, 1.0) == pytest.approx(2 * math.atan(12 / 28))
    assert views.fov(2, 2.0) == pytest.approx(2 * math.atan(12 / 28))
    assert math.tan(views.fov(2, 0.5) / 2) == pytest.approx(2 * 12 / 28)


def test_cameras_that_look_away_from_each_other_have_something_to_turn_around(dataset) -> None:
    up = torch.tensor([0.0, 0, 1])
    outward = [
        replace(frame, camera=replace(frame.camera, viewmat=look_at(eye, 2 * eye, up)))
        for frame in dataset.train
        for eye in [frame.camera.position]
    ]
    views = Viewpoints(replace(dataset, train=outward))
    position, target = views.stand(0)
    assert float((target - position).norm()) == pytest.approx(dataset.extent, rel=1e-5)


def test_up_is_where_most_photos_have_it(dataset: Dataset) -> None:
    assert float(Viewpoints(dataset).up[2]) > 0.9  # the cameras were made so


def test_depth_has_the_colour_of_near_where_things_are_near() -> None:
    up = torch.tensor([0.0, -1, 0])
    K = torch.tensor([[28.0, 0, 12], [0, 28, 12], [0, 0, 1]])
    camera = Camera(look_at(torch.tensor([0.0, 0, -3]), torch.zeros(3), up), K, 24, 24)
    two = blobs().select(torch.tensor([0, 1]))
    two.means[:] = torch.tensor([[-0.6, 0, -1.0], [0.6, 0, 1.0]])
    two.log_scales[:], two.logit_opacities[:] = -1.3, 6.0
    picture = drawn_depth(Scene(two), camera)
    left, right = picture[12, 3:8].sum(1).max(), picture[12, 14:18].sum(1).max()
    assert left > right + 0.5
    assert picture[0, 0].tolist() == [0, 0, 0]  # where nothing is
    assert torch.equal(drawn_depth(Scene(two.select(torch.tensor([], dtype=torch.long))), camera),
                       torch.zeros(24, 24, 3))  # fmt: skip


def test_an_error_is_bright_where_it_counts(dataset: Dataset) -> None:
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
    assert decibels(wrong, masked) == math.inf
    assert decibels(wrong, view) < 15


def test_pictures_fit_on_any_canvas() -> None:
    picture = torch.ones(20, 30, 3)
    wide = fitted(picture, 900, 300)
    assert wide.shape == (20, 60, 3)
    assert (wide[:, 15:45] == 1).all() and (wide[:, :15] == AROUND).all()
    high = fitted(picture, 300, 300)
    assert high.shape == (30, 30, 3) and (high[5:25] == 1).all()
    assert fitted(picture, 15, 10).shape == (10, 15, 3)
    assert side_by_side([picture] * 3, 3.0).shape == (20, 102, 3)
    assert side_by_side([picture] * 3, 0.5).shape == (72, 30, 3)


def test_colours_grow_lighter_with_the_value() -> None:
    colors = in_colors(torch.linspace(0, 1, 50)[None])[0]
    assert (colors.sum(1).diff() > 0).all()
    assert torch.equal(in_colors(torch.tensor([[math.nan, -1.0, 2.0]]))[0, 0], colors[0])
