"""The page for users of gsplat: our calls run and give the images of numpy."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.special import lpmv

from mobilegs.camera import Camera
from tests.support.golden import turned_around
from tests.support.numpy_render import alphas_and_depths, sorted_shares
from tests.support.scenes import as_float32, camera, random_scene

PAGE = Path(__file__).parents[2] / "docs/guides/from_gsplat.md"
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
OURS = [block for block in BLOCKS if "from mobilegs import" in block]


@pytest.fixture(scope="module")
def given() -> dict:
    """Return the variables that the page's blocks use, in float32."""
    scene = as_float32(random_scene(30, degree=3, seed=3, spread=0.5))
    views = [turned_around(camera(23, 17), 0.2 * i).to(dtype=torch.float32) for i in range(3)]
    generator = torch.Generator().manual_seed(0)
    return {
        **{name: scene[name].float() for name in ("means", "quats", "scales", "opacities", "sh")},
        "features": torch.randn(30, 5, generator=generator),
        "colors": torch.rand(30, 3, generator=generator),
        "viewmats": torch.stack([view.viewmat for view in views]),
        "Ks": torch.stack([view.K for view in views]),
        "width": 23,
        "height": 17,
        "backgrounds": torch.tensor([[0.1, -2.0, 0.5, 3.0, 0.2]]).expand(3, 5),
        "photos": torch.rand(3, 17, 23, 3, generator=generator),
    }


@pytest.fixture(scope="module")
def ran(given) -> list[dict]:
    """Return the variables after each of our blocks, run from top to bottom."""
    names, after = dict(given), []
    for block in OURS:
        exec(compile(block, str(PAGE), "exec"), names)  # as a reader would
        after.append(dict(names))
    return after


def harmonics(sh: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return colours of degree 3 from associated Legendre functions, whose sign 3DGS keeps."""
    x, y, z = directions.T
    around, basis = np.arctan2(y, x), []
    for degree in range(4):
        for order in range(-degree, degree + 1):
            m = abs(order)
            norm = (2 * degree + 1) / (4 * math.pi) * math.factorial(degree - m)
            norm *= (2 if m else 1) / math.factorial(degree + m)
            wave = np.sin(m * around) if order < 0 else np.cos(m * around)
            basis.append(math.sqrt(norm) * lpmv(m, degree, z) * wave)
    return np.maximum(0.5 + np.einsum("kn,nkc->nc", np.array(basis), sh), 0)


def by_numpy(given: dict):
    """Return image, alpha, and depths where alpha is above 0.01, for each camera."""
    scene = {name: given[name].double() for name in ("means", "quats", "scales")}
    for viewmat, K in zip(given["viewmats"], given["Ks"], strict=True):
        view = Camera(viewmat.double(), K.double(), 23, 17)
        alphas, depths = alphas_and_depths(scene, given["opacities"].double(), view)
        shares, passed = sorted_shares(alphas, depths)
        offsets = (scene["means"] - view.position).numpy()
        directions = offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
        image = shares @ harmonics(given["sh"].double().numpy(), directions)
        covered = shares.sum(1) > 0.01
        assert covered.sum() > 100
        mean = np.where(covered, (shares @ depths) / np.maximum(shares.sum(1), 0.01), np.nan)
        yield image.reshape(17, 23, 3), 1 - passed.reshape(17, 23), mean.reshape(17, 23)


def test_the_page_s_calls_give_the_images_of_numpy(given, ran):
    assert len(OURS) == 6
    assert ran[0]["alphas"].shape == (3, 17, 23) and ran[0]["radii"].shape == (3, 30)
    for i, (image, alpha, depth) in enumerate(by_numpy(given)):
        np.testing.assert_allclose(ran[0]["images"][i], image, atol=2e-5)
        np.testing.assert_allclose(ran[0]["alphas"][i], alpha, atol=2e-5)
        found = np.where(np.isnan(depth), np.nan, ran[2]["depths"][i])
        np.testing.assert_allclose(found, depth, rtol=2e-4)
    assert ran[1]["images"].shape == (3, 17, 23, 5) and ran[5]["images"].shape == (3, 17, 23, 3)


def test_screen_gradients_are_written_for_every_camera(ran):
    assert ran[4]["lengths"].shape == (3, 30) and (ran[4]["lengths"] > 0).any(1).all()
