"""The matrices and the networks that decode colour."""

import pytest
import torch

from mobilegs.representation.appearance import (
    COLORS,
    AppearanceDecoder,
    ColorShape,
    LatentDecoder,
    color_decoder,
    fit_appearance,
)


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def smooth_harmonics(positions: torch.Tensor) -> torch.Tensor:
    """Colours that depend on three hidden numbers and a little on the place."""
    hidden = torch.randn(len(positions), 3, generator=seeded(7))
    rest = hidden @ torch.randn(3, 9, generator=seeded(8)) * 0.1
    rest = rest + 0.05 * torch.sin(3 * positions[:, :1])
    dc = torch.randn(len(positions), 1, 3, generator=seeded(9))
    return torch.cat([dc, rest.reshape(-1, 3, 3)], dim=1)


@pytest.mark.parametrize("colors", COLORS)
def test_a_linear_start_passes_the_latents_through(colors: str) -> None:
    decoder = color_decoder(ColorShape(colors), seeded())
    directions = torch.randn(9, 3, generator=seeded(1))
    decoder.init_linear(directions)
    positions, static, view = torch.randn(3, 50, 3, generator=seeded(2))
    out = decoder(positions, static, view)
    assert torch.allclose(out[:, 0], static, atol=2e-3)  # 11 binary digits
    assert torch.allclose(out[:, 1:].flatten(1), view @ directions.T, atol=1e-2)


@pytest.mark.parametrize(("degree", "latents_of_view"), [(0, 3), (1, 3), (1, 7), (2, 9)])
def test_matrices_are_fitted_by_principal_directions(degree: int, latents_of_view: int) -> None:
    positions = torch.randn(500, 3, generator=seeded())
    sh = torch.randn(500, (degree + 1) ** 2, 3, generator=seeded(6))
    shape = ColorShape(degree=degree, latents=3 + latents_of_view)
    decoder, draws = color_decoder(shape, seeded()), seeded()
    latents = fit_appearance(decoder, positions, sh, generator=draws)
    found = decoder.decode(positions, *latents)
    assert torch.allclose(found[:, 0], sh[:, 0], atol=1e-6)
    rest = sh[:, 1:].flatten(1)
    assert torch.equal(draws.get_state(), seeded().get_state())
    if degree:
        values = torch.linalg.svdvals(rest.double())
        least = values[latents_of_view:].square().sum()  # what so few directions cannot tell
        error = (found[:, 1:].flatten(1) - rest).double().square().sum()
        assert error == pytest.approx(least.item(), rel=1e-2)


def test_fitting_reproduces_the_colours_and_uses_the_position() -> None:
    positions = torch.randn(3000, 3, generator=seeded())
    sh = smooth_harmonics(positions)
    errors = []
    for steps in (0, 200):
        decoder = AppearanceDecoder(seeded())
        latents = fit_appearance(decoder, positions, sh, generator=seeded(), steps=steps, batch=512)
        errors.append((decoder.decode(positions, *latents) - sh).square().mean().sqrt())
    assert errors[0] < 0.2 * sh[:, 1:].square().mean().sqrt()
    assert errors[1] < 0.7 * errors[0]


def test_one_gaussian_without_view_dependence_is_fitted() -> None:
    decoder = AppearanceDecoder(seeded())
    sh = torch.zeros(1, 4, 3)
    sh[:, 0] = 0.7
    latents = fit_appearance(decoder, torch.zeros(1, 3), sh, generator=seeded(), steps=3)
    assert decoder.decode(torch.zeros(1, 3), *latents) == pytest.approx(sh, abs=0.05)


def test_gradients_reach_the_networks_of_all_latents() -> None:
    decoder = LatentDecoder(seeded()).double()
    static, view = (torch.randn(5, 3, generator=seeded(i)).double() for i in (1, 2))
    static.requires_grad_()
    view.requires_grad_()
    nowhere = torch.full((5, 3), torch.nan).double()
    assert torch.autograd.gradcheck(lambda s, v: decoder(nowhere, s, v), (static, view))
    decoder(nowhere, static, view).square().sum().backward()
    for parameter in decoder.parameters():
        assert parameter.grad is not None and parameter.grad.abs().max() > 0
