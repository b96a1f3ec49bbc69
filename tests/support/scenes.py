"""Small random scenes and cameras, and comparisons of tensors and gradients."""

from dataclasses import replace
from typing import Any

import pytest
import torch
from torch import Tensor

from mobilegs.camera import Camera, look_at
from mobilegs.render import sortfree
from mobilegs.render.inputs import RenderSettings
from mobilegs.render.levels import LEVELS, at_level, choose_levels, enlarge, level_sizes
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import ALPHA_MIN, pair_alphas, project
from mobilegs.spherical_harmonics import C0

SORTED = ("means", "quats", "scales", "opacities", "sh")
SORTFREE = ("means", "quats", "scales", "lobes", "sh")


def camera(
    width: int = 45, height: int = 37, *, center: tuple[float, float] = (0.47, 0.55)
) -> Camera:
    """Return a camera 4 units from the origin, with fx != fy and an off-centre principal point."""
    eye = torch.tensor([1.1, -0.7, -3.8], dtype=torch.float64)
    up = torch.tensor([0.1, -1.0, 0.05], dtype=torch.float64)
    k = torch.tensor(
        [[1.1 * width, 0, center[0] * width], [0, 1.3 * width, center[1] * height], [0, 0, 1]],
        dtype=torch.float64,
    )
    viewmat = look_at(eye, torch.zeros(3, dtype=torch.float64), up)
    return Camera(viewmat, k, width, height)


def camera_from_json(row: dict) -> Camera:
    """Return a camera from an entry of a 3DGS cameras.json: its `rotation` is camera to world."""
    viewmat = torch.eye(4)
    viewmat[:3, :3] = torch.tensor(row["rotation"]).T
    viewmat[:3, 3] = -viewmat[:3, :3] @ torch.tensor(row["position"])
    k = torch.tensor(
        [[row["fx"], 0, row["width"] / 2], [0, row["fy"], row["height"] / 2], [0, 0, 1.0]]
    )
    return Camera(viewmat, k, row["width"], row["height"])


def random_scene(
    count: int,
    *,
    degree: int = 1,
    lobe_degree: int = 2,
    seed: int = 0,
    spread: float = 1.0,
    size: float = 1.0,
) -> dict[str, Tensor]:
    """Return the inputs of both renderers for `count` Gaussians around the origin, float64.

    The median scale is 0.11 times `size`.
    """
    generator = torch.Generator().manual_seed(seed)

    def normal(*shape: int) -> Tensor:
        return torch.randn(*shape, generator=generator, dtype=torch.float64)

    means, quats = spread * normal(count, 3), normal(count, 4)
    lobes = 0.8 * normal(count, (lobe_degree + 1) ** 2, 2)
    lobes[:, 0] = torch.stack([1.5 * normal(count), 1 + 0.6 * normal(count)], 1) / C0
    return {
        "means": means,
        "quats": quats,
        "scales": size * torch.exp(0.7 * normal(count, 3) - 2.2),
        "opacities": torch.sigmoid(1.5 * normal(count)),
        "sh": torch.cat([normal(count, 1, 3), 0.3 * normal(count, (degree + 1) ** 2 - 1, 3)], 1),
        "lobes": lobes,
    }


def as_float32(scene: dict[str, Tensor]) -> dict[str, Tensor]:
    """Round a scene to float32 and back, so that both precisions have the same numbers."""
    return {name: value.float().double() for name, value in scene.items()}


def near_threshold(
    scene: dict[str, Tensor],
    view: Camera,
    *,
    names: tuple[str, ...],
    margin: float = 2e-5,
    settings: RenderSettings = RenderSettings(),  # noqa: B008 - immutable
) -> Tensor:
    """Return the pixels `[h, w]` that rounding may change.

    An alpha is close to the lowest one or to that of a surface, a depth close to a surface's limit,
    or a Gaussian of the pixel close to the next level.
    """
    o, phi, least = scene["opacities"], torch.ones_like(scene["opacities"]), ALPHA_MIN
    if names == SORTFREE:
        offsets = torch.nn.functional.normalize(scene["means"] - view.position, dim=1)
        o, phi = evaluate_lobes(scene["lobes"], offsets)
        least = settings.weighting.alpha_min
    shapes = [scene[name] for name in SORTED[:3]]
    projected = project(
        *[*shapes, o, scene["sh"]], camera=view, alpha_min=least, footprint=settings.footprint
    )
    weights = settings.weighting.weights(projected.depths, scene["scales"].amax(1), phi)
    weights = torch.where(projected.visible, weights, 0.0)
    sizes = level_sizes(view.height, view.width)
    low_level, high_level = (
        choose_levels(projected, weights, settings.level_sigma * (1 + m)) for m in (margin, -margin)
    )
    found = torch.zeros(*sizes[-1], 1, dtype=torch.float64)
    for level in reversed(range(LEVELS)):
        doubtful = torch.zeros(sizes[level], dtype=torch.bool)
        same = torch.equal(low_level, high_level)
        for levels in (low_level,) if same else (low_level, high_level):
            if not (levels == level).any():
                continue
            part, faded = at_level(
                projected, o, level, levels == level, size=sizes[level], alpha_min=least
            )
            low, high = (
                pair_alphas(part, faded * (1 + m), sizes[level], least) for m in (-margin, margin)
            )
            unsure = (low > 0) != (high > 0)
            unsure |= (high > 0) & (low_level != high_level)
            doubtful |= unsure.any(1).reshape(sizes[level])
        if level < LEVELS - 1:
            found = enlarge(found, sizes[level], to_image=level == 0)
        found = ((found > 0) | doubtful[..., None]).double()
    return found[..., 0] > 0


def hold_visibility(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the visibility of the next image for all later ones: no gradient flows through it."""
    visibility, held = sortfree.visibility, []

    def once(*given: Any) -> Tensor:
        if not held:
            held.append(visibility(*given))
        return held[0]

    monkeypatch.setattr(sortfree, "visibility", once)


def gradcheck_scene(
    names: tuple[str, ...], *, degree: int = 1, lobe_degree: int = 2
) -> tuple[list[Tensor], Camera]:
    """Return four Gaussians on 9x7 pixels, with no alpha within a finite difference of 1/255."""
    view = camera(9, 7)
    for seed in range(100):
        scene = random_scene(4, degree=degree, lobe_degree=lobe_degree, seed=seed, spread=0.6)
        scene["scales"] = scene["scales"] * 2 + 0.1
        if not near_threshold(scene, view, names=names, margin=1e-3).any():
            return [scene[name].requires_grad_() for name in names], view
    raise AssertionError("every scene has an alpha near the threshold")


def render_with_grads(
    render, scene, view, *, dtype, backend, cotangents, device="cpu", pose=False, **options
):
    """Render on `device`. Returns image, alpha and depth, and the gradient of every input.

    `colors` in the scene take the place of `sh`. `pose` adds the gradient of the camera's pose.
    """
    leaves = {k: v.detach().to(device, dtype, copy=True).requires_grad_() for k, v in scene.items()}
    names = SORTFREE if "weighting" in options else SORTED
    view = view.to(dtype=dtype)
    background = torch.tensor([0.1, 0.2, 0.35], dtype=dtype, device=device)
    if "colors" in scene:
        names = (*names[:-1], "colors")
        channels = scene["colors"].shape[1]
        background = background.repeat(channels)[:channels]
        options["colors"] = leaves["colors"]
    positional = [leaves[name] for name in names if name != "colors"]
    if pose:
        leaves["viewmat"] = view.viewmat.clone().requires_grad_()
        view, names = replace(view, viewmat=leaves["viewmat"]), (*names, "viewmat")
    rendered = render(
        *positional,
        camera=view,
        background=background,
        depth=True,
        backend=backend,
        **options,
    )
    parts = {"image": rendered.image, "alpha": rendered.alpha, "depth": rendered.depth}
    terms = [(parts[name] * cotangents[name].to(device, dtype)).sum() for name in cotangents]
    loss = sum(terms[1:], terms[0])
    if loss.requires_grad:
        loss.backward()
    outputs = {name: value.detach().double().cpu() for name, value in parts.items()}
    zero = {name: torch.zeros_like(leaves[name]) for name in names}
    grads = {
        name: leaves[name].grad if leaves[name].grad is not None else zero[name] for name in names
    }
    return outputs, {name: value.double().cpu() for name, value in grads.items()}


def cotangents(
    view: Camera, *, seed: int = 7, avoid: Tensor | None = None, channels: int = 3
) -> dict[str, Tensor]:
    """Return random dL/d of the outputs, zero at the pixels to avoid."""
    generator = torch.Generator().manual_seed(seed)
    keep = torch.ones(view.height, view.width, dtype=torch.float64)
    if avoid is not None:
        keep[avoid] = 0
    shape = (view.height, view.width)
    colors = torch.randn(*shape, channels, generator=generator, dtype=torch.float64)
    return {
        "image": colors * keep[..., None],
        "alpha": torch.randn(shape, generator=generator, dtype=torch.float64) * keep,
        "depth": 0.1 * torch.randn(shape, generator=generator, dtype=torch.float64) * keep,
    }


def assert_close(
    name: str, reference: Tensor, value: Tensor, *, ratio: float, floor: float
) -> None:
    """Check that the L2 error is at most `ratio` times the reference plus `floor`; print it."""
    assert value.isfinite().all(), f"{name} is not finite"
    size = reference.norm().item()
    error = (value - reference).norm().item()
    print(f"{name:10s} relative L2 {error / max(size, 1e-30):.2e} (norm {size:.2e})")
    assert error <= ratio * size + floor, f"{name}: {error} against {size}"
