"""Scenes in one picture against the truth: the nearer one hides the farther one."""

import pytest
import torch

from mobilegs.camera import Camera
from mobilegs.evaluate.metrics import psnr
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import read_mgs
from mobilegs.render.layers import composite, layer_of
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.scene import Scene
from mobilegs.train.teacher.init import gaussians_at
from tests.support.golden import TRAINED
from tests.support.three_page import Pages

RED, BLUE = [0.9, 0.2, 0.1], [0.1, 0.3, 0.9]


def front_view() -> Camera:
    K = torch.tensor([[40.0, 0, 24], [0, 40, 16], [0, 0, 1]])
    return Camera(torch.eye(4), K, 48, 32)


def wall(z: float, color: list[float], left: float) -> Gaussians:
    """Return an opaque wall across the view, from `left` (-1 to 1) to its right side."""
    x, y = torch.meshgrid(torch.linspace(left, 1, 40), torch.linspace(-1, 1, 40), indexing="ij")
    points = torch.stack([x * z, y * z, torch.full_like(x, z)], dim=2).reshape(-1, 3)
    colors = torch.tensor(color).expand_as(points)
    return gaussians_at(points, colors, opacity=0.95, sh_degree=0)


@pytest.mark.parametrize("depths", [(2.0, 3.0), (3.0, 2.0)])
def test_the_nearer_wall_hides_the_farther_one(depths: tuple[float, float]) -> None:
    walls = [wall(depths[0], RED, left=-0.2), wall(depths[1], BLUE, left=-1.0)]
    parts = [one.tensors() for one in walls]
    both = Gaussians(**{name: torch.cat([part[name] for part in parts]) for name in parts[0]})
    truth = Scene(both).render(front_view()).image
    scenes = [
        Scene(one, blend="sortfree", lobes=constant_lobes(one.logit_opacities)) for one in walls
    ]
    layers = [layer_of(one, front_view()) for one in scenes]
    found, _ = composite(layers)
    decibels = psnr(found, truth)
    print(f"{decibels:.1f} dB")
    assert decibels > 30
    # both are seen in the sums of one scene
    lobes = constant_lobes(both.logit_opacities)
    assert psnr(Scene(both, blend="sortfree", lobes=lobes).render(front_view()).image, truth) < 25


@pytest.mark.thorough
@pytest.mark.parametrize("factor", [12.0, 1 / 12])
def test_the_nearer_scene_hides_the_farther_one_in_three(factor: float, pages: Pages) -> None:
    page = pages("webgl")
    view = read_mgs(TRAINED).views[0].resized(96, 64)
    # the scene upside down, and all its depths times the factor: it looks equally large
    forward = view.viewmat[2, :3]
    matrix = torch.eye(4)
    matrix[:3, :3] = factor * (2 * torch.outer(forward, forward) - torch.eye(3))
    matrix[:3, 3] = view.position - matrix[:3, :3] @ view.position
    page.tab.run(
        """const { load } = three;
        window.meshes = [await load(url), await load(url, { matrixAutoUpdate: false })];
        meshes[1].matrix.set(...matrix);""",
        url=page.share("trained.mgs", TRAINED.read_bytes()),
        matrix=matrix.flatten().tolist(),
    )
    code = """
    scene.background.setScalar(white);
    meshes.forEach((mesh, i) => (mesh.visible = drawn.includes(i)));
    """
    near, far = (0, 1) if factor > 1 else (1, 0)
    first, over_white, behind, found = (
        page.picture(view, code, drawn=drawn, white=white)
        for drawn, white in (([near], 0), ([near], 1), ([far], 0), ([0, 1], 0))
    )
    truth = first + (over_white - first) * behind
    decibels = psnr(found, truth)
    print(f"{decibels:.1f} dB")
    assert decibels > 38 and psnr(behind, truth) < 20
