"""Lobes: what they mean, how few numbers they come from, how they stand in for a network."""

import math

import pytest
import torch
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import Camera, look_at
from mobilegs.compress.codebooks import Cut
from mobilegs.compress.lobes import LobeDecoder, LobeShape, fit_lobes
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render.lobes import constant_lobes, evaluate_lobes, lobe_degree
from mobilegs.render.view_network import ViewNetwork, static_inputs
from mobilegs.spherical_harmonics import C0, sh_basis
from mobilegs.train.student.view_dependence import ViewDependence
from mobilegs.train.student.view_dirs import basis_gram, fit_lobes_to_network


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


def cameras(count: int = 40) -> list[Camera]:
    K = torch.tensor([[60.0, 0, 20], [0, 60, 20], [0, 0, 1]])
    eyes = 4 * random_directions(count, seed=5)
    up = torch.tensor([0.0, 0.1, 1])
    return [Camera(look_at(eye, torch.zeros(3), up), K, 40, 40) for eye in eyes]


def even_metric(degree: int) -> Tensor:
    return torch.eye((degree + 1) ** 2)


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


def test_constant_lobes_look_the_same_from_everywhere() -> None:
    logits = torch.linspace(-3, 3, 20)
    lobes = constant_lobes(logits, torch.linspace(-1, 2, 20))
    for seed in (1, 2):
        opacities, phi = evaluate_lobes(lobes, random_directions(20, seed))
        torch.testing.assert_close(opacities, logits.sigmoid())
        torch.testing.assert_close(phi, torch.linspace(-1, 2, 20).clamp_min(0))


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
    monkeypatch.setattr("mobilegs.compress.lobes.CHUNK", 7)
    torch.testing.assert_close(decoder.decode(latents, some, base=True), whole)
    torch.testing.assert_close(decoder(latents, some, base=True), whole)


@pytest.mark.parametrize(
    "shape", [(4, 1, ()), (-1, 1, ()), (2, 33, ()), (2, 1, (0,)), (2, 1, (300,)), (2, 1, (1,) * 4)]
)
def test_invalid_shapes_are_refused(shape: tuple) -> None:
    with pytest.raises(InputError, match="cannot have the shape"):
        LobeShape(*shape)


# --- fitting


def fitted(lobes: Tensor, shape: LobeShape, *, metric: Tensor | None = None, **options) -> Tensor:
    """Return the lobes that a fitted decoder gives."""
    some = some_gaussians(len(lobes))
    some.logit_opacities = C0 * lobes[:, 0, 0]
    decoder = LobeDecoder(shape, seeded())
    options = {"base": True, "rotated": True, "steps": 150, "batch": 256, **options}
    metric = even_metric(shape.degree) if metric is None else metric
    latents = fit_lobes(decoder, lobes, some, metric=metric, generator=seeded(8), **options)
    assert latents.shape == (len(lobes), shape.latents) and not latents.requires_grad
    return decoder.decode(latents, some, base=options["base"])


@pytest.mark.parametrize("rotated", [True, False])
@pytest.mark.parametrize("base", [True, False])
@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_as_many_latents_as_coefficients_lose_nothing(
    degree: int, base: bool, rotated: bool
) -> None:
    lobes = some_lobes(degree=degree)
    shape = LobeShape(degree, 2 * (degree + 1) ** 2 - base)
    back = fitted(lobes, shape, base=base, rotated=rotated)
    torch.testing.assert_close(back, lobes, atol=2e-2, rtol=0)  # the basis is made of halves


def test_as_many_latents_as_principal_directions_are_enough() -> None:
    lobes = some_lobes(rank=5)
    torch.testing.assert_close(fitted(lobes, LobeShape(2, 6)), lobes, atol=2e-2, rtol=0)
    assert (fitted(lobes, LobeShape(2, 2)) - lobes).abs().max() > 0.3


@pytest.mark.parametrize("hidden", [(), (8,)])
def test_equal_lobes_leave_the_basis_unchanged(hidden: tuple) -> None:
    some, lobes = some_gaussians(), torch.zeros(300, 9, 2)
    lobes[:, :1] = constant_lobes(some.logit_opacities)
    decoder = LobeDecoder(LobeShape(2, 6, hidden), seeded())
    drawn = decoder.basis.detach().clone()
    options = {"metric": even_metric(2), "base": True, "rotated": True}
    latents = fit_lobes(decoder, lobes, some, generator=seeded(8), **options)
    assert torch.equal(decoder.basis, drawn) and (latents == 0).all()
    torch.testing.assert_close(drawn @ drawn.T, torch.eye(6), atol=1e-5, rtol=0)
    assert (drawn[:, 0] == 0).all()
    torch.testing.assert_close(decoder(latents, some, base=True), lobes, atol=2e-3, rtol=0)


def test_latents_beyond_the_last_direction_are_zero() -> None:
    lobes = some_lobes(degree=0)
    torch.testing.assert_close(fitted(lobes, LobeShape(0, 4)), lobes, atol=2e-2, rtol=0)


def test_directions_that_no_camera_sees_lose_accuracy_first() -> None:
    lobes, forward = some_lobes(degree=2), random_directions(4000)
    forward = normalize(forward * 0.15 + torch.tensor([0.0, 0, 1]), dim=1)
    basis = sh_basis(forward, 2)
    narrow = basis.T @ basis / len(forward)
    few = LobeShape(2, 6)
    there = sh_basis(forward[:1], 2)
    errors = [
        ((back - lobes) * there[0, :, None]).sum(1).square().mean()
        for back in (fitted(lobes, few, metric=narrow), fitted(lobes, few))
    ]
    assert errors[0] < 0.1 * errors[1]


def test_a_network_uses_the_other_attributes() -> None:
    some = some_gaussians(1000)
    lobes = some_lobes(1000)
    lobes[:, 1:] = (static_inputs(some) @ torch.randn(19, 16, generator=seeded(9))).unflatten(
        1, (8, 2)
    )
    some.logit_opacities = C0 * lobes[:, 0, 0]
    errors = []
    for hidden in ((), (32,)):
        decoder = LobeDecoder(LobeShape(2, 0, hidden), seeded())
        options = {"metric": even_metric(2), "base": True, "rotated": True, "steps": 400}
        latents = fit_lobes(decoder, lobes, some, generator=seeded(8), **options)
        errors.append((decoder.decode(latents, some, base=True) - lobes).square().mean())
    assert errors[1] < 0.5 * errors[0]


# --- in the place of a network


def test_constant_network_outputs_are_fitted_exactly() -> None:
    some = some_gaussians()
    lobes = fit_lobes_to_network(ViewNetwork(seeded()), some, cameras(), 2)
    torch.testing.assert_close(
        lobes[:, :1], constant_lobes(some.logit_opacities), rtol=0, atol=2e-2
    )
    assert lobes[:, 1:].abs().max() < 2e-2


def test_a_network_is_approximated_along_the_directions_of_the_cameras() -> None:
    some, network = some_gaussians(), ViewNetwork(seeded())
    with torch.no_grad():
        network.opacity.weight.normal_(0, 0.5, generator=seeded(1))
        network.phi.weight.normal_(0, 0.5, generator=seeded(2))
    residues, spreads = [], []
    lobes = {degree: fit_lobes_to_network(network, some, cameras(), degree) for degree in (0, 2)}
    for camera in cameras()[:8]:
        directions = normalize(some.means - camera.position, dim=1)
        with torch.no_grad():
            said = C0 * network(some, directions)[:, 0]
        for degree, found in ((2, residues), (0, spreads)):
            heard = (sh_basis(directions, degree)[:, :, None] * lobes[degree]).sum(1)
            found.append((heard - said).square().mean())
    assert sum(residues) < 0.2 * sum(spreads)


def test_a_gaussian_that_no_camera_sees_keeps_its_base() -> None:
    some = some_gaussians()
    some.means[7] = torch.tensor([0.0, 0, 900.0])
    network = ViewNetwork(seeded())
    with torch.no_grad():
        network.opacity.bias.fill_(1.0)
    from_above = [camera for camera in cameras() if camera.position[2] > 1]
    lobes = fit_lobes_to_network(network, some, from_above, 2)
    torch.testing.assert_close(lobes[7, :1], constant_lobes(some.logit_opacities)[7])
    assert lobes[8, 0, 0] * C0 - some.logit_opacities[8] == pytest.approx(1.0, abs=0.05)
    assert (lobes[7, 1:] == 0).all()


def test_the_metric_of_cameras_all_around_is_that_of_uniform_directions() -> None:
    metric = basis_gram(some_gaussians(), cameras(400), 2)
    torch.testing.assert_close(metric.float(), torch.eye(9), atol=0.5, rtol=0)
    assert metric.trace() == pytest.approx(9)
    nobody = basis_gram(some_gaussians(), [], 1)
    assert torch.equal(nobody, torch.eye(4, dtype=torch.float64))


# --- the choice


@pytest.mark.parametrize(
    ("view", "shape", "cut", "base"),
    [
        (ViewDependence("network"), None, None, True),
        (ViewDependence("decoded", 1), LobeShape(1, 0, (256, 128)), None, True),
        (ViewDependence("projected", latents=7), LobeShape(2, 6), Cut(3, 2), True),
        (ViewDependence("projected", latents=1), LobeShape(2, 0), None, True),
        (ViewDependence("projected", latents=30), LobeShape(2, 18), Cut(9, 2), True),
        (
            ViewDependence("fitted", latents=4, subvector_length=3, decoder_from=0.5),
            LobeShape(2, 3),
            Cut(1, 3),
            True,
        ),
        (ViewDependence("latent", latents=0, hidden=9), LobeShape(2, 0, (9,)), None, False),
        (ViewDependence("free", 0, subvector_length=1), LobeShape(0, 1), Cut(1, 1), True),
    ],
)
def test_the_stored_attributes_follow_from_the_view_dependence(view, shape, cut, base) -> None:
    assert (view.shape, view.cut, view.base) == (shape, cut, base)


@pytest.mark.parametrize(
    "wrong",
    [{"kind": "magic"}, {"degree": 4}, {"latents": 40}, {"subvector_length": 0},
     {"codebook_size": 5000}, {"decoder_from": 1.5}, {"hidden": 0},
     {"kind": "fitted", "decoder_from": 0.0}, {"kind": "free", "degree": 3, "subvector_length": 3},
     {"latents": 32, "degree": 3, "subvector_length": 3}],
)  # fmt: skip
def test_invalid_view_dependences_are_refused(wrong: dict) -> None:
    with pytest.raises(InputError):
        ViewDependence(**wrong)
