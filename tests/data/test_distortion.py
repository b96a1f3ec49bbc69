"""Undistortion recovers a known pattern from its distorted image."""

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.data import load_capture, load_view
from mobilegs.data.distortion import Distortion, LensPhoto, undistort
from tests.support.colmap_capture import random_poses, write_capture_of_noise

K = torch.tensor([[150.0, 0, 81.0], [0, 145.0, 59.0], [0, 0, 1]])
SIZE = (120, 160)
LENSES = {
    "pincushion": Distortion((0.2, 0.0, 0.0, 0.0)),
    "opencv": Distortion((-0.2, 0.05, 0.0, 0.0), tangential=(0.01, -0.02)),
    "full": Distortion((0.1, 0.02, -0.01, 0.005), (0.2, 0.03, 0.01), (0.004, 0.006)),
}


def pattern(x, y):
    """Return a smooth colour for each ideal point of the plane z = 1."""
    return torch.stack([0.5 + 0.5 * (9 * x).sin(), 0.5 + 0.5 * (9 * y).cos(), 0.5 + x * y], -1)


def plane():
    rows, columns = torch.meshgrid(torch.arange(SIZE[0]), torch.arange(SIZE[1]), indexing="ij")
    return (columns + 0.5 - K[0, 2]) / K[0, 0], (rows + 0.5 - K[1, 2]) / K[1, 1]


def straightened(image, lens):
    """Undistort an image into a view with the same intrinsics."""
    height, width, _ = image.shape
    intrinsics = (float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2]))
    return undistort(image, LensPhoto(width, height, intrinsics, lens), K=K, size=(width, height))


def distorted(lens):
    """Render the pattern through a lens; iteration finds the ideal point of each pixel."""
    xd, yd = (coordinate.double() for coordinate in plane())
    x, y = xd.clone(), yd.clone()
    for _ in range(100):
        xn, yn = lens.apply(x, y)
        x, y = x + xd - xn, y + yd - yn
    assert (lens.apply(x, y)[0] - xd).abs().max() < 1e-9
    return pattern(x, y).float()


@pytest.mark.parametrize("lens", LENSES.values(), ids=LENSES.keys())
def test_undistortion_recovers_the_pattern(lens):
    straight, known = straightened(distorted(lens), lens)
    error = (straight - pattern(*plane())).abs().amax(-1)
    inner = known.clone()
    inner[:3] = inner[-3:] = False
    inner[:, :3] = inner[:, -3:] = False
    assert inner.float().mean() > 0.8
    assert error[inner].max() < 8e-3
    assert (distorted(lens) - pattern(*plane())).abs().max() > 0.05  # the lens had an effect


def test_no_distortion_changes_nothing():
    image = torch.rand(*SIZE, 3, generator=torch.Generator().manual_seed(0))
    straight, known = straightened(image, Distortion())
    assert known.all() and (straight - image).abs().max() < 1e-4


def test_pixels_outside_of_the_photo_are_unknown():
    _, known = straightened(torch.zeros(*SIZE, 3), LENSES["pincushion"])
    assert not known[0, 0] and known[60, 80]


def test_pixels_beyond_the_fold_of_a_polynomial_are_unknown():
    lens = Distortion((-1.5, 0.0, 0.0, 0.0))  # r (1 - 1.5 r^2) falls from r = 0.471 on
    assert lens.valid_radius(2.0) == pytest.approx((1 / 4.5) ** 0.5, abs=2e-3)
    _, known = straightened(torch.zeros(*SIZE, 3), lens)
    x, y = plane()
    assert not known[(x * x + y * y).sqrt() > 0.475].any()
    assert known[(x * x + y * y).sqrt() < 0.46].all()


def test_photos_of_a_distorted_colmap_model_are_undistorted_on_load(tmp_path):
    lens = LENSES["opencv"]
    values = (150.0, 145.0, 81.0, 59.0, *lens.numerator[:2], *lens.tangential, *[0.0] * 4)
    root = write_capture_of_noise(tmp_path, camera=(1, 6, 160, 120, values), size=(160, 120))
    photo = np.array(Image.open(root / "images" / random_poses(2)[1][0]))
    view = load_view(load_capture(root).train[0])
    expected, known = straightened(torch.from_numpy(photo).float() / 255, lens)
    assert bool(known.all()) if view.mask is None else torch.equal(view.mask.bool(), known)
    assert (view.image - expected).abs().max() < 0.51 / 255
    assert (view.image * 255 - torch.from_numpy(photo)).abs().mean() > 5
