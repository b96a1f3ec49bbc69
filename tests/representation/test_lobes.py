"""Lobes: what they mean, how few numbers they come from, how they stand in for a network."""

import math

import pytest
import torch
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render.lobes import constant_lobes, evaluate_lobes, lobe_degree
from mobilegs.render.view_network import static_inputs
from mobilegs.representation.lobes import LobeDecoder, LobeShape
from mobilegs.spherical_harmonics import C0, sh_basis
from mobilegs.train.student.view_dependence import constant_decoder


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def random_directions(count: int, seed: int = 1) -> Tensor:
    return normalize(torch.randn(count, 3, generator=seeded(seed)), dim=1)


def some_gaussians(count: int = 300) -> Gaussians:
    g = seeded(2)
    return Gaussians(
        means=0.3 * torch.randn(count, 3, generator=g),
        quats=normalize(torch.randn(count, 4, generator=g), dim=1),
        log_scales=0.4 * torch.randn(count, 3, generator=g) - 3,
        logit_opacities=torch.randn(count, generator=g),
        sh=torch.randn(count, 4, 3, generator=g),
    )


def some_lobes(count: int = 300, degree: int = 2, rank: int | None = None) -> Tensor:
    """Random lobes; of `rank`, they are combinations of so few."""
    g, size = seeded(3), 2 * (degree + 1) ** 2
    rank = rank or size
    rows = torch.randn(count, rank, generator=g) @ torch.randn(rank, size, generator=g)
    rows = rows / rank**0.5 + torch.randn(size, generator=g)
    return rows.unflatten(1, (-1, 2))


# --- what they mean


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_opacity_and_phi_are_those_of_the_harmonics(degree: int) -> None:
    lobes, directions = some_lobes(50, degree), random_directions(50)
    opacities, phi = evaluate_lobes(lobes, directions)
    basis = sh_basis(directions, degree)
    for i in range(50):
        logit = sum(float(basis[i, k] * lobes[i, k, 0]) for k in range(len(basis[0])))
        raw_phi = sum(float(basis[i, k] * lobes[i, k, 1]) for k in range(len(basis[0])))
        assert float(opacities[i]) == pytest.approx(1 / (1 + math.exp(-logit)), abs=1e-6)
        assert float(phi[i]) == pytest.approx(max(0.0, raw_phi), abs=1e-5)
    assert lobe_degree(lobes) == degree


# --- the decoder


@pytest.mark.parametrize("hidden", [(), (8,), (7, 5)])
@pytest.mark.parametrize("latents", [0, 4])
def test_a_new_decoder_gives_the_base_from_everywhere(latents: int, hidden: tuple) -> None:
    decoder = LobeDecoder(LobeShape(2, latents, hidden), seeded())
    some = some_gaussians()
    lobes = decoder(torch.zeros(300, latents), some, base=True)
    opacities, phi = evaluate_lobes(lobes, random_directions(300))
    torch.testing.assert_close(opacities, some.opacities)
    torch.testing.assert_close(phi, torch.ones(300), atol=1e-3, rtol=0)


def test_decoding_follows_the_format() -> None:
    shape = LobeShape(1, 3, (6, 5))
    decoder = LobeDecoder(shape, seeded())
    with torch.no_grad():
        for parameter in decoder.parameters():
            parameter.copy_(torch.randn(parameter.shape, generator=seeded(4)).half())
    some, latents = some_gaussians(10), torch.randn(10, 3, generator=seeded(6))
    named = dict(decoder.named_parameters())
    names = ["bias", "basis", "weights.0", "weights.1", "weights.2", "offsets.0", "offsets.1"]
    assert list(named) == names
    hidden = torch.cat([static_inputs(some), latents], dim=1)
    hidden = torch.relu(hidden @ named["weights.0"].T + named["offsets.0"])
    hidden = torch.relu(hidden @ named["weights.1"].T + named["offsets.1"])
    expected = named["bias"] + latents @ named["basis"] + hidden @ named["weights.2"].T
    torch.testing.assert_close(decoder(latents, some, base=False).flatten(1), expected)
    expected = torch.cat([expected[:, :1] + some.logit_opacities[:, None] / C0, expected[:, 1:]], 1)
    torch.testing.assert_close(decoder(latents, some, base=True).flatten(1), expected)


@pytest.mark.parametrize("latents", [0, 4])
def test_gradients_of_decoding_equal_finite_differences(latents: int) -> None:
    decoder = LobeDecoder(LobeShape(2, latents, (8,)), seeded()).double()
    with torch.no_grad():  # halves, so that rounding them changes nothing
        for parameter in decoder.parameters():
            parameter.copy_(torch.randn(parameter.shape, generator=seeded(4)).half())
    some = some_gaussians(6).to(dtype=torch.float64)
    numbers = torch.randn(6, latents, generator=seeded(6), dtype=torch.float64)
    inputs = {"latents": numbers, **some.tensors()}
    for tensor in inputs.values():
        tensor.requires_grad_()

    def decoded(numbers: Tensor, logits: Tensor) -> Tensor:
        given = {**some.detached().tensors(), "logit_opacities": logits}
        return decoder(numbers, Gaussians(**given), base=True)

    assert torch.autograd.gradcheck(decoded, (inputs["latents"], inputs["logit_opacities"]))
    decoder(numbers, some, base=True).square().sum().backward()
    others = ("quats", "log_scales", "sh")
    # with numbers of their own, Gaussians do not bend what else they are made of
    assert all((inputs[name].grad is None) == (latents > 0) for name in others)
    assert all(parameter.grad is not None for parameter in decoder.parameters())


def test_chunks_do_not_change_what_is_decoded(monkeypatch) -> None:
    decoder = LobeDecoder(LobeShape(2, 4, (8,)), seeded())
    some, latents = some_gaussians(), torch.randn(300, 4, generator=seeded(6))
    whole = decoder.decode(latents, some, base=True)
    monkeypatch.setattr("mobilegs.representation.lobes.CHUNK", 7)
    torch.testing.assert_close(decoder.decode(latents, some, base=True), whole)
    torch.testing.assert_close(decoder(latents, some, base=True), whole)


@pytest.mark.parametrize(
    "shape", [(4, 1, ()), (-1, 1, ()), (2, 33, ()), (2, 1, (0,)), (2, 1, (300,)), (2, 1, (1,) * 4)]
)
def test_invalid_shapes_are_refused(shape: tuple) -> None:
    with pytest.raises(InputError, match="cannot have the shape"):
        LobeShape(*shape)


def test_a_constant_decoder_gives_opacities_and_a_random_basis() -> None:
    some = some_gaussians()
    drawn = LobeDecoder(LobeShape(2, 6, (8,)), seeded()).basis
    decoder, logits = constant_decoder(LobeShape(2, 6, (8,)), some.logit_opacities, seeded())
    torch.testing.assert_close(logits, some.logit_opacities)
    assert torch.equal(decoder.basis, drawn) and (drawn[:, 0] == 0).all()
    torch.testing.assert_close(drawn @ drawn.T, torch.eye(6), atol=1e-5, rtol=0)
    lobes = torch.zeros(300, 9, 2)
    lobes[:, :1] = constant_lobes(some.logit_opacities)
    found = decoder(torch.zeros(300, 6), some, base=True)
    torch.testing.assert_close(found, lobes, atol=2e-3, rtol=0)


# --- the choice
