"""Lobes: their decoder, its gradients, and its start from constant opacities."""

import pytest
import torch
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render.lobes import constant_lobes, evaluate_lobes
from mobilegs.representation.lobes import LobeDecoder, LobeShape
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


@pytest.mark.parametrize("hidden", [(), (8,), (7, 5)])
@pytest.mark.parametrize("latents", [0, 4])
def test_a_new_decoder_gives_the_base_from_everywhere(latents: int, hidden: tuple) -> None:
    decoder = LobeDecoder(LobeShape(2, latents, hidden), seeded())
    some = some_gaussians()
    lobes = decoder(torch.zeros(300, latents), some, base=True)
    opacities, phi = evaluate_lobes(lobes, random_directions(300))
    torch.testing.assert_close(opacities, some.opacities)
    torch.testing.assert_close(phi, torch.ones(300), atol=1e-3, rtol=0)


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
