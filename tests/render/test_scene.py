"""Sorted scenes whose opacity depends on the view: two Gaussians on one ray, in numpy."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.gaussians import Gaussians
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.scene import Scene
from mobilegs.render.view_network import ViewNetwork
from tests.support.tiny import grad_of

DOUBLE = torch.float64
C0, C1 = 0.28209479177387814, 0.4886025119029199
BACKGROUND = np.array([0.2, 0.6, 0.9])
COLORS = np.array([[0.9, 0.3, 0.1], [0.2, 0.8, 0.5]])  # the nearer one first
EYES = ([1.0, -2.0, 0.5], [-2.0, 0.3, -1.0])


def through_the_origin(eye: list[float], dtype: torch.dtype) -> Camera:
    """Return a camera whose middle pixel, (8, 8), looks at the origin."""
    K = torch.tensor([[40.0, 0, 8.5], [0, 40, 8.5], [0, 0, 1]], dtype=dtype)
    up = torch.tensor([0.0, 0, 1], dtype=dtype)
    at = torch.tensor(eye, dtype=dtype)
    return Camera(look_at(at, torch.zeros(3, dtype=dtype), up), K, 17, 17)


def on_one_ray(eye: list[float], dtype: torch.dtype) -> Scene:
    """Return two Gaussians on the ray of the middle pixel, the farther one first in memory."""
    axis = np.array(eye) / np.linalg.norm(eye)
    sh = np.zeros((2, 4, 3))
    sh[:, 0] = (COLORS[::-1] - 0.5) / C0
    parts = np.stack([-0.5 * axis, 0.4 * axis]), np.random.default_rng(1).normal(size=(2, 4))
    shapes = *parts, np.log([[0.2, 0.1, 0.3], [0.1, 0.4, 0.2]]), np.array([0.4, -0.3]), sh
    gaussians = Gaussians(*(torch.from_numpy(part).to(dtype) for part in shapes))
    return Scene(gaussians, background=torch.from_numpy(BACKGROUND).to(dtype))


def blended(opacities: np.ndarray) -> np.ndarray:
    """Return the colour of the middle pixel; `opacities` has the farther one first."""
    far, near = opacities
    return near * COLORS[0] + (1 - near) * (far * COLORS[1] + (1 - far) * BACKGROUND)


@pytest.mark.parametrize("dtype", [torch.float32, DOUBLE])  # the kernel, and the reference
def test_lobes_give_the_opacities_of_a_sorted_scene(dtype: torch.dtype) -> None:
    numbers = np.random.default_rng(3).normal(size=(2, 4, 2))
    found = []
    for eye in EYES:
        x, y, z = -np.array(eye) / np.linalg.norm(eye)
        basis = np.array([C0, -C1 * y, C1 * z, -C1 * x])
        opacities = 1 / (1 + np.exp(-(numbers[:, :, 0] @ basis)))
        lobes = torch.from_numpy(numbers).to(dtype).requires_grad_()
        scene = replace(on_one_ray(eye, dtype), lobes=lobes)
        image = scene.render(through_the_origin(eye, dtype)).image
        np.testing.assert_allclose(image[8, 8].detach(), blended(opacities), atol=2e-6)
        image[8, 8, 0].backward()
        far, near = opacities
        behind = far * COLORS[1, 0] + (1 - far) * BACKGROUND[0]
        by_opacity = [(1 - near) * (COLORS[1, 0] - BACKGROUND[0]), COLORS[0, 0] - behind]
        expected = np.array(by_opacity) * opacities * (1 - opacities)
        gradients = grad_of(lobes)
        np.testing.assert_allclose(gradients[:, :, 0], expected[:, None] * basis, atol=2e-6)
        assert not gradients[:, :, 1].any()  # phi is not used
        found.append(opacities)
    assert np.abs(found[0] - found[1]).min() > 0.05


def test_a_network_gives_the_opacities_of_a_sorted_scene() -> None:
    eye, random = EYES[0], np.random.default_rng(4)
    network = ViewNetwork().double()
    weights = {name: random.normal(size=v.shape) / 8 for name, v in network.named_parameters()}
    network.load_state_dict({name: torch.from_numpy(value) for name, value in weights.items()})
    scene = replace(on_one_ray(eye, DOUBLE), network=network)

    g, axis = scene.gaussians, -np.array(eye) / np.linalg.norm(eye)
    parts = [g.sh.flatten(1).numpy(), np.tile(axis, (2, 1)), g.scales.numpy(), g.quats.numpy()]
    h = np.concatenate([p / np.linalg.norm(p, axis=1, keepdims=True) for p in parts], axis=1)
    for layer, least in (("hidden1", 0), ("hidden2", 0), ("hidden3", -np.inf)):
        h = np.maximum(least, h @ weights[f"{layer}.weight"].T + weights[f"{layer}.bias"])
    added = h @ weights["opacity.weight"][0] + weights["opacity.bias"]
    assert np.abs(added).min() > 0.01
    assert sum(value.size for value in weights.values()) == 47_170
    directions = torch.from_numpy(axis).expand(2, 3)
    _, phi = evaluate_lobes(network(g, directions), directions)
    raw = h @ weights["phi.weight"][0] + weights["phi.bias"]
    np.testing.assert_allclose(phi.detach(), np.maximum(0, raw), atol=1e-9)
    logits = g.logit_opacities.numpy() + added
    image = scene.render(through_the_origin(eye, DOUBLE)).image
    np.testing.assert_allclose(image[8, 8].detach(), blended(1 / (1 + np.exp(-logits))), atol=1e-9)
    image.sum().backward()
    assert grad_of(network.hidden1.weight).abs().max() > 0
    assert not grad_of(network.phi.weight).any()  # phi is not used


def test_a_scene_is_plain_only_without_view_dependence() -> None:
    scene = on_one_ray(EYES[0], DOUBLE)
    assert scene.is_plain
    assert not replace(scene, blend="sortfree").is_plain
    assert not replace(scene, lobes=torch.zeros(2, 1, 2)).is_plain
    assert not replace(scene, network=ViewNetwork()).is_plain
