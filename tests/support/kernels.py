"""Comparison of a renderer's kernels with its float64 reference."""

from collections.abc import Callable

import torch

from mobilegs.render.kernels import cuda
from tests.support.golden import (
    BASE,
    DETACHED,
    INVALID,
    RENDERERS,
    finite_rows,
    input_names,
    inputs_of,
    settings_of,
    with_rows,
)
from tests.support.scenes import (
    as_float32,
    assert_close,
    camera,
    cotangents,
    near_threshold,
    random_scene,
    render_with_grads,
)

EVERYTHING = [
    "sorted",
    "mobile_gs",
    "depth_pass",
    "all",
]  # renderers that differ most, in all cases
OTHERS = [name for name in (*RENDERERS, *DETACHED) if name not in EVERYTHING]
CASES_OF_OTHERS = ["several tiles", "around the camera", "opaque", "zero size", "phi below zero"]


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


def render_all(scene, view, renderer: str, **more) -> dict[str, torch.Tensor]:
    """Return outputs and gradients of the kernels in float32, by name."""
    render, options = RENDERERS[renderer]
    given = {"cotangents": cotangents(view), "dtype": torch.float32, "backend": "kernel"}
    outputs, grads = render_with_grads(render, scene, view, **(given | options | more))
    return {**outputs, **grads}


def check_lists_without_room(
    renderer: str, forget: Callable[[], None], device: str = "cpu"
) -> None:
    """Check that lists that are longer than was known change no bit; `forget` clears what was."""
    scene, view = as_float32(random_scene(400, seed=18)), camera(56, 50)
    scene["scales"][:3] = 3.0
    kernels = cuda.kernels_for(torch.empty(0, device=device))
    forget()
    expected = render_all(scene, view, renderer, device=device)
    known = list(kernels.lengths.longest)  # of the image, and of a depth pass
    forget()
    for alike in known:
        kernels.lengths.learn(alike, 20)
    for name, value in render_all(scene, view, renderer, device=device).items():
        assert torch.equal(value, expected[name]), name


def check_invalid_values(bad: str, renderer: str, **more) -> None:
    """Check that Gaussians with the values of `INVALID[bad]` are left out, with gradients of 0."""
    view, scene, rows = camera(), as_float32(BASE), finite_rows(bad)
    rest = {name: value[rows] for name, value in scene.items()}
    expected = render_all(rest, view, renderer, **more)
    found = render_all(with_rows(scene, **INVALID[bad]), view, renderer, **more)
    for name, value in expected.items():
        is_input = name in input_names(renderer)
        part = found[name][rows] if is_input else found[name]
        rtol, atol = (1e-4, 1e-4) if name == "viewmat" else (1e-5, 1e-6)
        torch.testing.assert_close(part, value, rtol=rtol, atol=atol)
        assert not is_input or (found[name][~rows] == 0).all(), name
