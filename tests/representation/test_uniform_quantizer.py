"""Mode `sq`: canonical rotations, uniform quantisers and their step sizes, decorrelated latents."""

import math
from dataclasses import replace

import pytest
import torch

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.render.project import rotation_matrices
from mobilegs.render.scene import Scene
from mobilegs.render.view_network import STATICS
from mobilegs.representation.appearance import ColorShape, color_decoder
from mobilegs.representation.lobes import LobeDecoder, LobeShape
from mobilegs.representation.rotations import (
    LIMITS,
    RotationQuantizer,
    canonical_pairs,
    decode_rotations,
    encode_rotations,
    quats_of,
    refinement_bits,
    rotation_vectors,
)
from mobilegs.representation.uniform_quantizer import StepSizes, UniformQuantizer
from mobilegs.train.student.decorrelate import decorrelate_appearance, decorrelate_lobes
from mobilegs.train.student.quantization import (
    QUALITY_RANGE,
    UPDATE_MAX,
    add_rate_gradients,
    controlled_quality,
)
from mobilegs.train.student.trainer import Student
from tests.support.scene_cases import Case, make_scene
from tests.support.tiny import STUDENT, blobs, changed, train


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def covariances(quats: torch.Tensor, log_scales: torch.Tensor) -> torch.Tensor:
    axes = rotation_matrices(torch.nn.functional.normalize(quats.double(), dim=1))
    halves = axes * log_scales.double().exp()[:, None, :]
    return halves @ halves.transpose(1, 2)


def relative(found: torch.Tensor, expected: torch.Tensor) -> torch.Tensor:
    return (found - expected).flatten(1).norm(dim=1) / expected.flatten(1).norm(dim=1)


def ellipsoids(count: int, seed: int = 0) -> tuple[torch.Tensor, torch.Tensor]:
    g = seeded(seed)
    quats = torch.randn(count, 4, generator=g)
    return quats, 1.5 * torch.randn(count, 3, generator=g)


def test_canonical_pairs_are_the_same_ellipsoids_rotated_by_at_most_63_degrees() -> None:
    quats, log_scales = ellipsoids(5000)
    turned, renamed = canonical_pairs(quats, log_scales)
    assert relative(covariances(turned, renamed), covariances(quats, log_scales)).max() < 1e-5
    assert rotation_vectors(turned).norm(dim=1).max() < math.radians(62.8)
    assert (turned[:, 0] > 0).all()
    torch.testing.assert_close(turned.norm(dim=1), torch.ones(5000))
    again = canonical_pairs(turned, renamed)
    torch.testing.assert_close(again[0], turned, atol=1e-6, rtol=0)
    assert torch.equal(again[1], renamed)


def test_refinement_bits_grow_with_the_elongation() -> None:
    limits = torch.tensor(LIMITS) / 256
    expected = [math.asinh((2 ** (c - 0.5) - 1) / 2) for c in range(1, 9)]
    assert (limits - torch.tensor(expected)).abs().max() < 1 / 256
    zeros = torch.zeros(8)
    at = torch.stack([zeros, limits, zeros], dim=1)
    below = torch.stack([zeros, torch.nextafter(limits, zeros), zeros], dim=1)
    assert refinement_bits(at)[:, 2].tolist() == list(range(1, 9))
    assert refinement_bits(below)[:, 0].tolist() == list(range(8))
    assert (refinement_bits(at)[:, 1] == 0).all()


@pytest.mark.parametrize("step", [0.3, 0.05])
def test_quantised_rotations_change_all_covariances_by_similar_small_errors(step: float) -> None:
    quats, log_scales = canonical_pairs(*ellipsoids(4000, seed=1))
    codes = encode_rotations(quats, log_scales, step)
    decoded = decode_rotations(codes, refinement_bits(log_scales), step)
    assert torch.equal(encode_rotations(decoded, log_scales, step), codes)
    error = relative(covariances(decoded, log_scales), covariances(quats, log_scales))
    long = (log_scales.amax(1) - log_scales.amin(1)) > 3
    assert error.max() < 1.5 * step
    assert error[long].mean() < 2 * error[~long].mean() and error.mean() < step / 4


def test_codes_are_the_nearest_multiples() -> None:
    values = torch.tensor([[0.24, -1.0], [0.26, 0.0], [-0.26, 7.0]])
    codes = UniformQuantizer.fit(values, step_size=0.5)
    assert codes.indices.tolist() == [[0, -2], [1, 0], [-1, 14]]
    assert codes(torch.tensor([2, 0])).tolist() == [[-0.5, 7.0], [0.0, -1.0]]
    far = UniformQuantizer.fit(torch.tensor([[1e9], [-1e9]]), step_size=0.5).indices
    assert far.tolist() == [[2047], [-2047]]  # the most codes of a column
    codes.select(torch.tensor([True, False, True]))
    assert codes.indices.tolist() == [[0, -2], [-1, 14]]


def test_the_smallest_step_size_still_represents_every_scale_and_opacity() -> None:
    values = torch.linspace(-20, 20, 999)[:, None]  # e^20 is 5e8
    codes = UniformQuantizer.fit(values, step_size=0.01)
    codes.log_step_offset.data -= 5
    codes.reassign(values)
    assert (codes() - values).abs().max() <= codes.step_size / 2 + 1e-6


def test_the_bits_gradient_points_from_rare_codes_to_frequent_ones() -> None:
    values = torch.cat([torch.zeros(90), torch.ones(9), torch.full((1,), 4.0)])[:, None]
    codes = UniformQuantizer.fit(values, step_size=1.0)
    asked = torch.tensor([[0.5], [-0.5], [3.5], [4.5], [1.5], [50.0]])
    slopes = codes.bits_gradient(asked.expand(-1, 1))
    total = 90 + 9 + 1 + 0.1 * 9  # codes -2 to 6
    bits = [math.log2(total / (count + 0.1)) for count in (0, 0, 90, 9, 0, 0, 1, 0, 0)]
    expected = [bits[i + 1] - bits[i] for i in (2, 1, 5, 6, 3, 7)]
    torch.testing.assert_close(slopes[:, 0], torch.tensor(expected))
    assert slopes[0] > 0 > slopes[1]
    finer = UniformQuantizer.fit(values / 2, step_size=0.5).bits_gradient(asked / 2)
    torch.testing.assert_close(finer, 2 * slopes)


@pytest.mark.parametrize(
    ("colors", "degree", "view_latents"),
    [("linear", 0, 3), ("linear", 1, 8), ("networks", 1, 3), ("latent_networks", 3, 3)],
)
def test_decorrelated_appearance_latents_decode_to_the_same_colours(
    colors: str, degree: int, view_latents: int
) -> None:
    g = seeded(3)
    most = view_latents if colors == "linear" else 3
    decoder = color_decoder(ColorShape(colors, degree, 3 + most), g)
    if colors == "linear":
        decoder.init_linear(torch.randn(3 * (degree + 1) ** 2 - 3, most, generator=g))
    places = torch.randn(3000, 3, generator=g)
    static, view = (
        torch.randn(3000, n, generator=g) @ torch.randn(n, n, generator=g) for n in (3, most)
    )
    before = decoder.decode(places, static, view)
    changed = decorrelate_appearance(decoder, places, static, view)
    after = decoder.decode(places, *changed)
    assert (after - before).abs().max() < 4e-3 * before.abs().max()  # weights are float16
    covariance = torch.cov(changed[0].T)
    assert (covariance - covariance.diagonal().diag()).abs().max() < 1e-3 * covariance.max()
    assert covariance[0, 0] >= covariance[1, 1] >= covariance[2, 2]
    nudged = decoder.decode(places, changed[0] + torch.tensor([0, 0.01, 0]), changed[1])
    felt = (nudged - after).flatten(1).square().sum(1).mean().sqrt()
    assert 0.008 < felt < 0.012  # a unit along any axis changes the colour by one


@pytest.mark.parametrize("hidden", [(), (8, 5)])
def test_decorrelated_lobe_latents_decode_to_the_same_lobes(hidden: tuple[int, ...]) -> None:
    g = seeded(4)
    decoder = LobeDecoder(LobeShape(2, 6, hidden), g)
    for parameter in decoder.parameters():
        parameter.data.copy_(0.5 * torch.randn(parameter.shape, generator=g))
    quats, log_scales = ellipsoids(2000)
    rest = torch.randn(2000, 4, 3, generator=g)
    shown = Gaussians(log_scales, quats, log_scales, rest[:, 0, 0], rest)
    latents = torch.randn(2000, 6, generator=g) @ torch.randn(6, 6, generator=g)
    before = decoder.decode(latents, shown, base=True)
    changed = decorrelate_lobes(decoder, latents, shown, base=True)
    after = decoder.decode(changed, shown, base=True)
    assert (after - before).abs().max() < 4e-3 * before.abs().max()
    covariance = torch.cov(changed.T)
    assert (covariance - covariance.diagonal().diag()).abs().max() < 1e-3 * covariance.max()


def test_a_single_gaussian_is_trained_and_quantised(dataset) -> None:
    seen_by = [frame.camera for frame in dataset.train]
    alone = Scene(blobs().select(torch.tensor([3])), near=0.2)
    config = changed(STUDENT, quantization={"method": "sq"})
    student = Student(config, alone, seen_by, extent=dataset.extent, seed=0)
    train(student, dataset, 40)
    assert all(torch.isfinite(value).all() for value in student.quantized_scene().values().values())
    assert len(decode_mgs(encode_mgs(student.quantized_scene())).decode().gaussians) == 1


@pytest.mark.parametrize("library", [True, False])
def test_lobes_whose_squares_approach_the_float32_maximum_are_rendered(
    library: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    coded = make_scene(Case(300, LobeShape(0, 2, (2, 2)), steps=StepSizes()))
    for name, weights in coded.lobe_decoder.items():
        weights.fill_(65504.0 if name.startswith("weights") else 0.0)
    coded.lobe_decoder["weights.0"][:, :STATICS] = 0
    coded.indices["lobes"].fill_(22)  # phi^2 is 2e38
    coded.indices["lobes"][::3] = -22  # ReLUs make zeros of these
    coded = decode_mgs(encode_mgs(replace(coded, step_sizes={**coded.step_sizes, "lobes": 1000.0})))
    if not library:
        monkeypatch.setattr(binding, "supports", lambda *_: False)
    scene = coded.decode()
    assert scene.lobes is not None
    drawn = scene.render(coded.views[0])
    assert drawn.image.isfinite().all() and drawn.alpha.max() > 0.5
    assert scene.lobes.abs().max() == 1e4
    assert scene.lobes[coded.indices["lobes"][:, 0] < 0].abs().max() < 10


def test_codes_that_are_too_large_are_refused() -> None:
    coded = make_scene(Case(50, steps=StepSizes()))
    coded.indices["appearance"][3, 2] = 5000
    with pytest.raises(InputError, match="appearance codes are too large"):
        encode_mgs(coded)
    coded = make_scene(Case(50, steps=StepSizes()))
    coded.indices["scale"][3, 2] = 1000
    with pytest.raises(InputError, match="scale codes hold"):
        encode_mgs(coded)


def test_the_step_size_gradient_follows_the_rounding_errors() -> None:
    """The gradient is that of the dequantised values, with fixed codes and errors in step sizes."""
    values = torch.tensor([[0.31, -0.07], [1.24, 0.52]], dtype=torch.float64)
    codes = UniformQuantizer.fit(values, step_size=0.2).double()
    held = codes(None, values)
    assert torch.equal(held, codes()) and not codes().requires_grad
    weights = torch.tensor([[1.0, -2.0], [0.5, 3.0]], dtype=torch.float64)
    (held * weights).sum().backward()
    expected = (
        weights * (codes() - values)
    ).sum()  # d held / d log_step_offset = step (k - value / step)
    assert codes.log_step_offset.grad == pytest.approx(float(expected))
    quats = torch.nn.functional.normalize(torch.randn(30, 4, generator=seeded()), dim=1)
    scales = UniformQuantizer.fit(torch.randn(30, 3, generator=seeded(1)), step_size=0.1)
    turned = canonical_pairs(quats, scales())[0]
    rotations = RotationQuantizer.fit(turned, scales=scales, step_size=0.3)
    assert torch.equal(rotations(None, turned), rotations())
    assert [name for name, _ in rotations.named_parameters()] == ["log_step_offset"]
    rotations(None, turned).pow(2)[:, 1].sum().backward()
    moved = []
    with torch.no_grad():
        vectors = rotation_vectors(turned)
        errors = rotation_vectors(rotations()) - vectors
        for nudge in (1e-3, -1e-3):  # the same errors in steps, of a step that has grown
            moved.append(quats_of(vectors + errors * math.exp(nudge)).pow(2)[:, 1].sum())
    assert rotations.log_step_offset.grad is not None
    found = float(rotations.log_step_offset.grad)
    assert found == pytest.approx(float(moved[0] - moved[1]) / 2e-3, rel=0.05)


def test_doubling_the_step_size_saves_one_bit_per_column() -> None:
    values = 40 * torch.randn(20_000, 3, generator=seeded())
    codes = UniformQuantizer.fit(values, step_size=1.0)
    assert codes.log_step_gradient(values) == pytest.approx(-3 / math.log(2), rel=0.05)
    shifted = torch.nn.Parameter(values - 300)
    codes.reassign(shifted)
    add_rate_gradients({"scale": codes}, {"scale": shifted}, 2.0)
    assert codes.log_step_offset.grad == pytest.approx(2 * -3 / math.log(2), rel=0.15)
    quats, log_scales = canonical_pairs(*ellipsoids(20_000))
    rotations = RotationQuantizer.fit(
        quats, scales=UniformQuantizer.fit(log_scales, step_size=0.1), step_size=0.02
    )
    assert rotations.log_step_gradient(quats) == pytest.approx(-3 / math.log(2), rel=0.05)


def test_step_sizes_grow_with_the_rate_term_and_shrink_with_the_distortion(
    dataset, make_student
) -> None:
    steps = []
    for price in (0.0, 1.0):
        config = changed(
            STUDENT, quantization={"method": "sq", "rate_weight": price}, lr={"step_sizes": 0.01}
        )
        student = make_student(changed(config, schedule={"quantize_from": 0.3}))
        train(student, dataset, 40)
        steps.append(math.prod(student.quantized_scene().step_sizes.values()))
    assert steps[1] > 1.1 * steps[0]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("target", "quality"), [(0.001, QUALITY_RANGE[0]), (1.0, QUALITY_RANGE[1])]
)
def test_a_student_goes_after_the_size_asked_for(
    dataset, make_student, target: float, quality: float
) -> None:
    """Fifty Gaussians can be neither a kilobyte nor a megabyte: steps go as far as they may."""
    config = changed(
        STUDENT,
        quantization={"method": "sq"},
        schedule={"quantize_from": 0.3},
        lr={"step_sizes": 0.0},
    )
    student = make_student(changed(config, quantization={"target_mb": target}))
    train(student, dataset, 40)
    assert student.quantization.quality == quality
    expected = StepSizes().divided_by(quality).scale
    assert student.quantized_scene().step_sizes["scale"] == pytest.approx(expected)


@pytest.mark.parametrize("power", [0.5, 0.9])
def test_the_quality_reaches_the_size_asked_for(power: float) -> None:
    quality = 2.0
    for _ in range(10):
        quality = controlled_quality(quality, 300.0 * (quality / 2.0) ** power, 210.0, 2.0)
    assert 300.0 * (quality / 2.0) ** power == pytest.approx(210.0, rel=2e-3)
    assert controlled_quality(1.0, 300.0, 1.0, 1.0) == 1 / UPDATE_MAX
    assert controlled_quality(1.0, 1.0, 300.0, 1.0) == UPDATE_MAX
    for target, end in zip((1.0, 1e9), QUALITY_RANGE, strict=True):
        assert controlled_quality(end, 300.0, target, 2.0) == end
        StepSizes().divided_by(end)  # raises InputError if there are none
    assert controlled_quality(0.1, 300.0, 1.0, 0.1) == 0.1


@pytest.mark.parametrize(
    ("target", "end"), [(0.0, 1.0), (0.001, UPDATE_MAX**-5), (1.0, UPDATE_MAX**5)]
)
def test_the_quality_follows_the_size_before_a_student_quantises(
    dataset, make_student, target: float, end: float
) -> None:
    config = changed(STUDENT, quantization={"method": "sq", "target_mb": target})
    student, qualities, values = make_student(config), [], []
    for until in (15, 18, 20, 24):  # the rate term begins at 16, quantisation at 26
        train(student, dataset, until)
        assert student.model.phase == "latents"
        qualities.append(student.quantization.quality)
        values.append(student.quantization.bit_weight * qualities[-1] ** 2)
    assert qualities[0] == config.quantization.quality == 1.0
    assert qualities[-1] == pytest.approx(end)
    assert qualities == sorted(qualities, reverse=end < 1)
    assert values == pytest.approx([config.quantization.rate_weight] * 4)
    before = encode_mgs(student._coded(student.model.quantized_copy()))
    assert student.model.phase == "latents" and student.model.quantizers == {}
    coded = student.quantized_scene()
    assert encode_mgs(replace(coded, views=[], meta={})) == before
    expected = StepSizes().divided_by(qualities[-1])
    assert coded.step_sizes["scale"] == pytest.approx(expected.scale)


def test_a_higher_quality_divides_step_sizes_and_weakens_the_rate_term(
    dataset, make_student
) -> None:
    found = []
    for fineness in (1.0, 4.0):
        config = changed(
            STUDENT,
            quantization={"method": "sq"},
            schedule={"quantize_from": 0.3},
            lr={"step_sizes": 0.0},
        )
        config = changed(config, quantization={"quality": fineness, "rate_weight": 1.0})
        assert config.quantization.bit_weight == 1 / fineness**2
        student = make_student(config)
        train(student, dataset, 40)
        found.append(
            (student.quantized_scene().step_sizes, len(encode_mgs(student.quantized_scene())))
        )
    (coarse, small), (fine, large) = found
    assert set(fine) == {"scale", "rotation", "appearance", "opacity", "lobes"} and large > small
    for name, step in coarse.items():
        assert step == pytest.approx(4 * fine[name])


def test_step_sizes_that_a_quality_makes_too_small_are_refused() -> None:
    with pytest.raises(InputError, match=r"quality of 20 .* scale .* 0\.0075"):
        changed(STUDENT, quantization={"method": "sq", "quality": 20.0})
    changed(STUDENT, quantization={"method": "nvq", "quality": 20.0})  # has no step sizes


@pytest.mark.parametrize(
    "wrong",
    [
        {"quality": 0.0},
        {"quality": math.nan},
        {"method": "sq", "quality": 1e3},
        {"method": "sq", "quality": 1e-6},
        {"rate_weight": -1.0},
        {"rate_weight": math.nan},
        {"target_mb": 1.0},
        {"method": "sq", "target_mb": math.inf},
    ],
)
def test_invalid_quantization_settings_are_refused(wrong: dict) -> None:
    with pytest.raises(InputError):
        changed(STUDENT, quantization=wrong)
