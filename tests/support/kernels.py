"""Comparison of a renderer's kernels with its float64 reference."""

import torch

from tests.support.golden import DETACHED, RENDERERS, input_names, inputs_of, settings_of
from tests.support.scenes import assert_close, cotangents, near_threshold, render_with_grads


def compare_with_reference(
    case: str,
    renderer: str,
    *,
    device: str = "cpu",
    channels: int | None = None,
    pose: bool = False,
) -> None:
    """Compare every output and every gradient of a golden case, by name.

    `channels` takes random colours of so many in place of harmonics, `pose` adds the gradient of
    the camera's pose.
    """
    scene, view = inputs_of(case)
    render, options = (RENDERERS | DETACHED)[renderer]
    names, settings = input_names(renderer), settings_of(renderer)
    avoid = near_threshold(scene, view, names=names, settings=settings)
    assert avoid.sum() <= 0.02 * avoid.numel() + 1
    tangents = cotangents(view, avoid=avoid, channels=channels or 3)
    if channels:
        generator = torch.Generator().manual_seed(channels)
        colors = torch.randn(len(scene["means"]), channels, generator=generator)
        scene["colors"] = 2 * colors.double()
    given = {"cotangents": tangents, "pose": pose, **options}
    expected = render_with_grads(
        render, scene, view, dtype=torch.float64, backend="reference", **given
    )
    found = render_with_grads(
        render, scene, view, dtype=torch.float32, backend="kernel", device=device, **given
    )
    for name in ("image", "alpha", "depth"):
        error = (found[0][name] - expected[0][name])[~avoid].abs()
        print(f"{name:10s} max {error.max() if error.numel() else 0:.2e}")
        scale = max(1.0, expected[0][name].abs().max().item())
        assert not error.numel() or error.max() < 1e-4 * scale, name
    # a gradient that cancels to 0 (rotation of a ball) is compared with the size of the others
    floor = 1e-6 * max([1.0, *[value.norm().item() for value in expected[1].values()]])
    for name in found[1]:
        assert_close(name, expected[1][name], found[1][name], ratio=1e-3, floor=floor)
