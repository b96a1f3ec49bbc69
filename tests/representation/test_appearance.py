"""The matrices and the networks that decode colour."""

import math

import numpy as np
import pytest
import torch

from mobilegs.representation.appearance import (
    COLORS,
    SLOPE,
    AppearanceDecoder,
    ColorShape,
    LatentDecoder,
    LinearDecoder,
    color_decoder,
    contract,
    encode_frequencies,
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


def test_contraction_equals_float32_arithmetic_of_numpy() -> None:
    positions = 3 * torch.randn(500, 3, generator=seeded())
    f = np.float32
    for row, found in zip(positions.numpy(), contract(positions).numpy(), strict=True):
        x, y, z = row
        length = max(f(1), np.sqrt(x * x + y * y + z * z))
        factor = f(2) - f(1) / length
        assert found.tolist() == [float(factor * (c / length) * f(0.25) + f(0.5)) for c in row]


def test_the_highest_octave_is_as_accurate_as_the_lowest() -> None:
    unit = torch.rand(1000, 3, generator=seeded())
    encoded = encode_frequencies(unit)
    angles = unit.double()[:, :, None] * 2.0 ** torch.arange(16) * math.pi
    expected = torch.cat([angles.flatten(1).sin(), angles.flatten(1).cos()], dim=1)
    assert (encoded - expected).abs().max() < 1e-6


def test_the_decoder_has_three_networks() -> None:
    decoder = AppearanceDecoder(seeded())
    assert sum(p.numel() for p in decoder.parameters()) == 9792
    positions = torch.randn(20, 3, generator=seeded(1))
    static, view = torch.randn(2, 20, 3, generator=seeded(2))
    w = {name: p.detach().half().float() for name, p in decoder.named_parameters()}
    hidden = (encode_frequencies(contract(positions)) @ w["context1"].T).relu()
    context = hidden @ w["context2"].T

    def head(name: str, latents: torch.Tensor) -> torch.Tensor:
        hidden = torch.cat([context, latents], 1) @ w[f"{name}1"].T
        return torch.where(hidden > 0, hidden, SLOPE * hidden) @ w[f"{name}2"].T

    out = decoder(positions, static, view)
    assert torch.allclose(out[:, 0], head("static", static), atol=1e-5)
    assert torch.allclose(out[:, 1:].flatten(1), head("view", view), atol=1e-5)
    assert torch.allclose(decoder.decode(positions, static, view), out, atol=1e-6)


@pytest.mark.parametrize("colors", COLORS)
def test_a_linear_start_passes_the_latents_through(colors: str) -> None:
    decoder = color_decoder(ColorShape(colors), seeded())
    directions = torch.randn(9, 3, generator=seeded(1))
    decoder.init_linear(directions)
    positions, static, view = torch.randn(3, 50, 3, generator=seeded(2))
    out = decoder(positions, static, view)
    assert torch.allclose(out[:, 0], static, atol=2e-3)  # 11 binary digits
    assert torch.allclose(out[:, 1:].flatten(1), view @ directions.T, atol=1e-2)


def test_linear_decoding_does_not_depend_on_the_position() -> None:
    decoder = LinearDecoder(2).double()
    for matrix in decoder.parameters():
        matrix.data.copy_(torch.randn(matrix.shape, generator=seeded(matrix.numel())))
    static, view = torch.randn(2, 20, 3, generator=seeded(1)).double()
    nowhere = torch.full((20, 3), torch.nan)
    out = decoder(nowhere, static, view)
    assert out.shape == (20, 9, 3)
    assert torch.allclose(out[:, 0], static @ decoder.static2.half().double().T)
    assert torch.allclose(out[:, 1:].flatten(1), view @ decoder.view2.half().double().T)
    assert torch.equal(decoder.decode(nowhere, static, view), out)
    out.square().sum().backward()
    for matrix in decoder.parameters():
        assert matrix.grad is not None and matrix.grad.abs().max() > 0


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


def test_the_networks_of_all_latents_are_equation_6() -> None:
    """Compare with numpy, written from the paper: both networks see static and view latents."""
    decoder = LatentDecoder(seeded(), degree=2)
    assert sum(p.numel() for p in LatentDecoder(seeded()).parameters()) == 1536
    w = {name: p.detach().half().double().numpy() for name, p in decoder.named_parameters()}
    static, view = torch.randn(2, 20, 3, generator=seeded(2)).double()
    both = np.hstack([static.numpy(), view.numpy()])

    def network(first: np.ndarray, last: np.ndarray) -> np.ndarray:
        hidden = both @ first.T
        return np.where(hidden > 0, hidden, 0.01 * hidden) @ last.T

    nowhere = torch.full((20, 3), torch.nan)
    for found in (decoder.double()(nowhere, static, view), decoder.decode(nowhere, static, view)):
        flat = found.detach().flatten(1).numpy()
        np.testing.assert_allclose(flat[:, :3], network(w["both1"][:64], w["static2"]), rtol=1e-9)
        np.testing.assert_allclose(flat[:, 3:], network(w["both1"][64:], w["view2"]), rtol=1e-9)


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
