"""Cloning, splitting and pruning of Gaussians and of their moments."""

from dataclasses import replace

import torch

from bench.steps import OperationCount
from mobilegs.camera import Camera
from mobilegs.train.optim import NamedAdam
from mobilegs.train.teacher.densify import CloneSplit, DensifyConfig
from mobilegs.train.teacher.init import gaussians_at

CONFIG = DensifyConfig(start=0.0, min_interval=10)
CAMERA = Camera(torch.eye(4), torch.eye(3), width=40, height=20)
COUNT = 6


def gaussians(scale: float = 0.001) -> NamedAdam:
    """Six Gaussians in a row, all momentum 1, opacity 0.5."""
    quats = torch.zeros(COUNT, 4)
    quats[:, 0] = 1
    tensors = {
        "means": torch.arange(3.0 * COUNT).reshape(COUNT, 3),
        "quats": quats,
        "log_scales": torch.full((COUNT, 3), scale).log(),
        "logit_opacities": torch.zeros(COUNT),
        "sh0": torch.zeros(COUNT, 1, 3),
    }
    adam = NamedAdam(tensors, dict.fromkeys(tensors, 0.0))
    for tensor in adam.tensors.values():
        tensor.grad = torch.ones_like(tensor)
    adam.step()
    return adam


def densifier(config: DensifyConfig = CONFIG, *, max_splats: int = 100) -> CloneSplit:
    return CloneSplit(
        config,
        steps=100,
        extent=1.0,
        max_splats=max_splats,
        count=COUNT,
        device=torch.device("cpu"),
    )


def see(densifier: CloneSplit, grads: torch.Tensor, radii: torch.Tensor) -> None:
    """Observe a view with these gradients of the projected means."""
    seen = gaussians_at(torch.zeros(COUNT, 3), torch.zeros(COUNT, 3), opacity=0.5, sh_degree=0)
    densifier.observe(1, seen, CAMERA, screen_grads=grads, radii=radii)


def pull(densifier: CloneSplit, strength: list[float]) -> None:
    """Observe a view with gradients along x, in units of the threshold."""
    grads = torch.zeros(COUNT, 2)
    grads[:, 0] = torch.tensor(strength) * densifier.config.gradient / (CAMERA.width / 2)
    see(densifier, grads, torch.ones(COUNT))


def test_a_small_gaussian_with_a_large_gradient_is_cloned(generator: torch.Generator) -> None:
    adam, grows = gaussians(), densifier()
    pull(grows, [0, 2, 0, 0, 0, 0.9])
    before = adam.tensors["means"].detach().clone()
    grows.after_step(10, adam, generator)
    assert torch.equal(adam.tensors["means"], torch.cat([before, before[1:2]]))


def test_a_large_gaussian_is_split_into_two_smaller_ones(generator: torch.Generator) -> None:
    adam, grows = gaussians(scale=0.05), densifier()
    pull(grows, [0, 2, 0, 0, 0, 0])
    before = adam.tensors["means"].detach().clone()
    grows.after_step(10, adam, generator)
    after = adam.tensors["means"].detach()
    assert torch.equal(after[:5], before[[0, 2, 3, 4, 5]])
    children = after[5:] - before[1]
    assert len(after) == 7 and (children != 0).all() and (children.abs() < 0.25).all()
    torch.testing.assert_close(adam.tensors["log_scales"][5:].exp(), torch.full((2, 3), 0.05 / 1.6))
    for tensor in adam.tensors.values():  # moments stay with their rows
        moments = adam.adam.state[tensor]["exp_avg"]
        assert moments.shape == tensor.shape and tensor.is_leaf
        assert (moments[:5] != 0).all() and (moments[5:] == 0).all()


def test_split_gaussians_are_distributed_like_the_original(generator: torch.Generator) -> None:
    adam, grows = gaussians(), densifier(replace(CONFIG, prune_scale=0.0))
    half = 2**-0.5
    with torch.no_grad():
        adam.tensors["log_scales"][:] = torch.tensor([4.0, 0.02, 0.02]).log()
        adam.tensors["quats"][:] = torch.tensor([half, 0, 0, half])  # x turns to y
        adam.tensors["means"].zero_()
    for _ in range(6):
        grows.gradients = torch.full((len(adam.tensors["means"]),), 1.0)
        grows.views = torch.ones(len(adam.tensors["means"]), dtype=torch.int32)
        grows.max_splats = 1000
        with torch.no_grad():
            adam.tensors["log_scales"][:] = torch.tensor([4.0, 0.02, 0.02]).log()
        grows._grow(adam, generator, torch.zeros(len(grows.views), dtype=torch.bool))
    spread = adam.tensors["means"].detach().std(0)
    assert spread[1] > 4 and spread[0] < 0.2 and spread[2] < 0.2


def test_max_splats_prefers_the_largest_gradients(generator: torch.Generator) -> None:
    adam, grows = gaussians(), densifier(max_splats=8)
    pull(grows, [2, 5, 3, 9, 2, 2])
    grows.after_step(10, adam, generator)
    added = adam.tensors["means"][COUNT:, 0]
    assert added.tolist() == [3, 9]  # of rows 1 and 3, and no more


def test_faint_gaussians_are_removed_and_large_ones_later(generator: torch.Generator) -> None:
    adam, grows = gaussians(), densifier()
    with torch.no_grad():
        adam.tensors["logit_opacities"][0] = -6
        adam.tensors["log_scales"][1] = -2  # 0.135 of the extent
    grows.after_step(10, adam, generator)
    assert len(adam.tensors["means"]) == COUNT - 1
    grows.after_step(20, adam, generator)
    assert adam.tensors["means"][:, 0].tolist() == [6, 9, 12, 15]


def test_pruning_never_removes_everything(generator: torch.Generator) -> None:
    adam, grows = gaussians(), densifier()
    with torch.no_grad():
        adam.tensors["logit_opacities"][:] = -9
    grows.after_step(10, adam, generator)
    assert len(adam.tensors["means"]) == COUNT


def test_a_reset_limits_all_opacities_to_a_hundredth(generator: torch.Generator) -> None:
    adam, grows = gaussians(), densifier(replace(CONFIG, opacity_reset=0.3))
    grows.after_step(29, adam, generator)
    assert adam.tensors["logit_opacities"].sigmoid().max() == 0.5
    grows.after_step(30, adam, generator)
    torch.testing.assert_close(
        adam.tensors["logit_opacities"].sigmoid(), torch.full((COUNT,), 0.01)
    )


def test_nothing_happens_outside_of_the_schedule(generator: torch.Generator) -> None:
    adam, grows = gaussians(), densifier(replace(CONFIG, start=0.2))
    pull(grows, [2] * COUNT)
    for step in (10, 20, 35, 60):
        grows.after_step(step, adam, generator)
    assert len(adam.tensors["means"]) == COUNT
    grows.after_step(30, adam, generator)
    assert len(adam.tensors["means"]) == 2 * COUNT


def test_a_densification_reads_six_sizes_and_no_more(generator: torch.Generator) -> None:
    adam, grows = gaussians(), densifier()
    with torch.no_grad():
        adam.tensors["log_scales"][0] = 0.0  # is split; 1 and 2 are cloned, 5 is removed
        adam.tensors["logit_opacities"][5] = -9.0
    pull(grows, [2, 2, 2, 0, 0, 0])
    with OperationCount() as counted:
        grows.after_step(10, adam, generator)
    assert len(adam.tensors["means"]) == COUNT + 2
    assert counted.host_reads == 6
