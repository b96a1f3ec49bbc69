"""Comparison of a kernel's contributions with the reference."""

import torch

from mobilegs.camera import Camera
from mobilegs.render.contributions import Contributions, measure_contributions
from mobilegs.render.inputs import RenderSettings
from mobilegs.render.kernels.kernel_view import KernelView, kernel_view
from mobilegs.render.project import pair_alphas, project
from mobilegs.render.sorted import TRANSMITTANCE_MIN, blend
from tests.support.golden import inputs_of
from tests.support.scenes import SORTED


def kernel_inputs(scene: dict, view: Camera) -> tuple[KernelView, list[torch.Tensor]]:
    """Return the inputs of the kernels: camera struct; means, quats, scales, opacities, sh."""
    flat = [scene[name].float() for name in SORTED[:4]]
    black = torch.zeros_like(flat[0])[:, None]
    return kernel_view(view, torch.zeros(3), RenderSettings(), sh_size=1, lobe_size=0), [
        *flat,
        black,
    ]


def doubtful_pairs(scene: dict, view: Camera) -> torch.Tensor:
    """Return the pairs `[pixels, n]` that rounding may change: alpha near 1/255 or T near 1e-4."""
    o, size = scene["opacities"], (view.height, view.width)
    projected = project(*[scene[name] for name in SORTED], camera=view)
    faint = [pair_alphas(projected, o * (1 + sign * 2e-5), size) > 0 for sign in (1, -1)]
    order = torch.argsort(projected.depths, stable=True)
    alphas = pair_alphas(projected, o, size)
    passed = torch.cumprod(1 - alphas[:, order], dim=1)
    before = torch.cat([torch.ones_like(passed[:, :1]), passed], dim=1)[:, :-1]
    dim = torch.zeros_like(faint[0])
    dim[:, order] = (before / TRANSMITTANCE_MIN - 1).abs() < 0.01
    return (faint[0] != faint[1]) | (dim & (alphas > 0))


def assert_agrees(found: Contributions, scene: dict, view: Camera) -> None:
    """Compare every statistic with the reference in float64."""
    expected = measure_contributions(*[scene[name] for name in SORTED[:4]], camera=view)
    doubtful = doubtful_pairs(scene, view)
    assert doubtful.sum() <= 2e-3 * doubtful.numel() + 2
    pixels = doubtful.any(1).reshape(view.height, view.width)
    error = (found.alpha.cpu() - expected.alpha)[~pixels].abs()
    print(f"alpha    max {error.max() if error.numel() else 0:.2e}")
    assert not error.numel() or error.max() < 1e-4
    slack = doubtful.sum(0)
    assert ((found.touched.cpu() - expected.touched).abs() <= slack).all()
    error = (found.weights.cpu() - expected.weights).abs() - 4e-3 * slack
    print(f"weights  max {error.max() if error.numel() else 0:.2e}")
    assert (error <= 1e-4 * (1 + expected.weights)).all()
    # either of two almost equal shares may have won
    projected = project(*[scene[name] for name in SORTED], camera=view)
    blending = blend(projected, scene["opacities"], view)
    two = torch.cat([blending.weights, torch.zeros(len(pixels.flatten()), 2)], 1).topk(2, 1).values
    close = (two[:, 0] - two[:, 1] < 1e-5) & (two[:, 0] > 0)
    clear = ~(close.reshape(pixels.shape) | pixels)
    assert clear.sum() >= 0.9 * clear.numel() - 2
    assert torch.equal(found.winner.cpu()[clear], expected.winner[clear])
    counts = torch.bincount(found.winner.cpu()[found.winner.cpu() >= 0], minlength=len(slack))
    assert torch.equal(found.largest.cpu(), counts.int())


def compare_case(case: str, measure, *, device: str = "cpu") -> None:
    """Compare the kernel `measure` with the reference on a golden case."""
    scene, view = inputs_of(case)
    struct, inputs = kernel_inputs(scene, view)
    assert_agrees(measure(struct, *[t.to(device) for t in inputs]), scene, view)
