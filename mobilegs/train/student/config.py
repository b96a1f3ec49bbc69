"""Settings of the student's training, in groups. Times are fractions of the run, 0 to 1."""

import math
from dataclasses import dataclass, field, fields
from typing import Literal

from mobilegs.errors import InputError
from mobilegs.mgs.container import STREAMS_MAX
from mobilegs.mgs.quantized_scene import LOD_LEVELS_MAX
from mobilegs.render import Footprint, Weighting
from mobilegs.render.inputs import validate_level_sigma
from mobilegs.render.scene import Blend
from mobilegs.representation.appearance import ColorName, ColorShape
from mobilegs.representation.codebooks import CodebookSizes
from mobilegs.representation.uniform_quantizer import StepSizes
from mobilegs.train.exposure import ExposureConfig
from mobilegs.train.student.view_dependence import ViewDependence
from mobilegs.train.student.vote_pruning import VoteConfig
from mobilegs.validation import (
    COUNT,
    DEGREE,
    FRACTION,
    NOT_NEGATIVE,
    POSITIVE,
    SHARE,
    Range,
    check,
    check_choice,
)

Method = Literal["sq", "nvq"]
# Streams of a file with `sq`: one per decoder; and in every LOD level the positions, three scales,
# three rotations and their finer bits, and the opacity.
NETWORK_STREAMS, ATTRIBUTE_STREAMS = 2, 9


@dataclass(frozen=True)
class StudentLearningRates:
    """Learning rates of Adam, all at least 0, and how they change during the run."""

    means: float = 1.6e-6
    """Learning rate of the means, in extents of the scene; limited by `means_max`."""
    means_max: float = 0.05
    """Upper limit of the means' learning rate, in sizes of the teacher's median Gaussian (the
    geometric mean of its two larger scales). Where cameras stand far away, the extent of the scene
    says little about the size of details."""
    quats: float = 1e-3
    """Learning rate of the quaternions."""
    scales: float = 5e-3
    """Learning rate of the log-scales."""
    opacities: float = 0.01
    """Learning rate of the logits of the base opacities."""
    lobes: float = 0.02
    """Learning rate of the lobe latents."""
    sh0: float = 2.5e-3
    """Learning rate of the constant part of the colour, until `schedule.latents_from`."""
    sh_rest: float = 1.25e-4
    """Learning rate of the view-dependent part of the colour, until `schedule.latents_from`."""
    network: float = 1e-3
    """Learning rate of the network, or of the lobe decoder, that gives opacity and weight."""
    color_latents: float = 2.5e-3
    """Learning rate of the colour latents."""
    codebook_factor: float = 1.0
    """Factor on the learning rates of the codebooks, with `nvq`; 0 keeps them as k-means makes
    them."""
    step_sizes: float = 2e-3
    """Learning rate of the logarithms of the step sizes, with `sq`. 0 keeps the step sizes
    fixed."""
    quantized_factor: float = 0.2
    """Factor on the learning rates of the values that are quantised, from
    `schedule.quantize_from` on (the latent values of quantisation-aware training); at least 0."""
    final_factor: float = 0.1
    """Factor on all learning rates at the end, above 0 and at most 1. The factor falls
    geometrically from 1 at `decay_from`."""
    decay_from: float = 0.5
    """Time from which all learning rates fall, 0 to 1."""

    def __post_init__(self) -> None:
        rates = {field.name: NOT_NEGATIVE for field in fields(self)}
        check(self, **(rates | {"final_factor": SHARE, "decay_from": FRACTION}))


@dataclass(frozen=True)
class LossConfig:
    """Weights of the loss. The weight of the rate term is `quantization.rate_weight`."""

    ssim_weight: float = 0.2
    """Weight of 1 - SSIM in the distance to the photo, 0 to 1; L1 has the rest."""
    distill_weight: float = 1.0
    """Weight of the L1 distance to the teacher's image, at least 0."""
    depth_weight: float = 0.1
    """Weight of the scale-invariant log-depth distance to the teacher, at least 0."""
    mask_depth: bool = True
    """Compare mean depths, in the pixels that student and teacher both cover. False compares sums
    of z in all pixels, as the paper's release does."""
    virtual_view_every: int = 4
    """Steps between two distillations on a virtual view, which lies off the path between two
    training cameras, in the first half of the run: then the photos alone have the details, in which
    the student becomes better than its teacher. 0 distils on the photos' views in every step
    instead, as in the paper; so does any value if no two cameras look at the same things."""
    front_weight: float = 0.1
    """Weight of the L1 distance to the teacher's coverage before planes of random depth, at least
    0; not with `blend=sorted`. It keeps Gaussians of little weight from standing in front of
    surfaces, where no photo shows them, but meshes, other scenes and depths do. The paper has no
    such term."""
    overdraw_weight: float = 5e-5
    """Weight of the mean number of fragments per pixel, which decides the time of a frame; at least
    0. Only scales receive its gradient. It counts what levels paint, if there is a `level_sigma`.
    The paper has no such term."""

    def __post_init__(self) -> None:
        names = ("distill_weight", "depth_weight", "virtual_view_every", "front_weight")
        check(
            self,
            ssim_weight=FRACTION,
            **dict.fromkeys((*names, "overdraw_weight"), NOT_NEGATIVE),
        )


@dataclass(frozen=True)
class ScheduleConfig:
    """Times at which parts of the method begin, and intervals in steps."""

    latents_from: float = 5 / 30
    """Time at which latents and a decoder replace the spherical harmonics, 0 to 1 (paper: 5,000
    of 30,000)."""
    rate_from: float = 0.4
    """Time at which the rate term begins, 0 to 1, with `sq`; at the latest it begins at
    `quantize_from`. Before quantisation the bits are estimated from the distance of each value to
    the mean of its column."""
    quantize_from: float = 0.9
    """Time at which quantised values replace the continuous ones, from `latents_from` to 1. (The
    release: 29,000 of 30,000, with codebooks that do not learn. Small codebooks that learn need
    longer: 0.7 suits `nvq`.)"""
    reassign_every: int = 25
    """Steps between two assignments to the nearest codebook entries, with `nvq`. 0 keeps the first
    assignment, as the release does. (With `sq` every step rounds to the nearest multiples.)"""
    keep_moments: bool = True
    """Keep the moments of Adam when latents replace the harmonics. The release resets them."""

    def __post_init__(self) -> None:
        if not 0 <= self.latents_from <= self.quantize_from <= 1:
            raise InputError(
                "latents_from and quantize_from must rise in this order within 0 to 1, not "
                f"{self.latents_from} and {self.quantize_from}"
            )
        check(self, rate_from=FRACTION, reassign_every=NOT_NEGATIVE)


@dataclass(frozen=True)
class ColorConfig:
    """Representation of the colours."""

    degree: int = 1
    """Degree of the spherical harmonics, 0 to 3."""
    decoder: ColorName = "linear"
    """Decoder from latents to harmonics: `linear`, two matrices; `latent_networks`, the two MLPs of
    the paper's Eq. 6; or `networks`, those of its release, whose input is also the position of the
    Gaussian."""
    latents: int = 6
    """Latents per Gaussian with `decoder=linear` and `sq`, at least 6: three for the constant part,
    the others for the view-dependent part. There are never more than harmonics. In all other cases
    there are the paper's six."""

    def __post_init__(self) -> None:
        check_choice("decoder", self.decoder, ColorName)
        check(self, degree=DEGREE, latents=Range(low=ColorShape().latents))


@dataclass(frozen=True)
class QuantizationConfig:
    """Quantisation of the values in the file, and its size."""

    method: Method = "sq"
    """`sq` quantises uniformly, with step sizes that learn, canonical rotations and decorrelated
    latents; it loses less quality in fewer bytes. `nvq` stores indices into codebooks, as the
    paper does."""
    quality: float = 2.0
    """Divisor of the step sizes (`StepSizes`), above 0, with `sq`. It also divides the weight of
    the rate term by its square, as the error of a step size in the image grows with the square."""
    rate_weight: float = 1e-3
    """Lambda of the rate term at a quality of 1, at least 0, with `sq`: one bit per Gaussian adds
    this much to the loss. Larger values give smaller files."""
    target_mb: float = 0.0
    """Size of the file in megabytes (10^6 bytes), with `sq`. Rate control changes the quality from
    `schedule.rate_from` on, between 0.125 and 12. 0 switches rate control off."""
    lod_levels: int = 0
    """LOD levels of the file, 0 to 8. Each has four times as many Gaussians as the one before, and
    a viewer shows the first ones while it loads the others. 0 chooses the number that leaves
    10,000 Gaussians to the first."""
    position_error: float = 0.05
    """Root mean square error of the stored positions in the training images, in pixels, at least
    0. It decides their number of bits."""
    round_means: bool = True
    """Train with means rounded as in the file, from `schedule.latents_from` on. The paper's release
    rounds them only in the file."""
    codebooks: CodebookSizes = field(default_factory=CodebookSizes)
    """Sizes of the codebooks, with `nvq`."""

    def __post_init__(self) -> None:
        check_choice("method", self.method, Method)
        if not 0 <= self.target_mb < math.inf or (self.target_mb and self.method != "sq"):
            raise InputError(
                f"target_mb {self.target_mb} must be at least 0, and needs method=sq unless it is 0"
            )
        check(
            self,
            quality=POSITIVE,
            rate_weight=NOT_NEGATIVE,
            position_error=NOT_NEGATIVE,
            lod_levels=Range(high=LOD_LEVELS_MAX),
        )
        _ = self.initial_step_sizes  # raises InputError if a file cannot hold them

    @property
    def initial_step_sizes(self) -> StepSizes | None:
        """Step sizes with which `sq` begins; None with `nvq`."""
        return StepSizes().divided_by(self.quality) if self.method == "sq" else None

    @property
    def bit_weight(self) -> float:
        """Lambda of the rate term at this quality: loss per bit per Gaussian."""
        return self.rate_weight / self.quality**2


@dataclass(frozen=True)
class WeightingConfig:
    """The weights of Eq. 3 in the student's training; see `mobilegs.render.Weighting`."""

    exponent_max: float = 4.0
    """Upper limit of `s_max / d` in the exponential, in (0, 80]. It keeps float16 renderers from
    overflow, and a large faint Gaussian from outweighing the whole image when a camera passes close
    to it: 8 shows such flashes between training views, 4 costs no quality."""
    alpha_min: float = 1 / 64
    """Alpha at which an ellipse ends, in [0.0001, 0.1]. The area of the ellipses takes most of a
    frame's time, so a higher limit renders faster: at 1/64 ellipses are a third smaller than at the
    paper's 1/255."""
    detached: bool = False
    """Cut the gradients of depth and scale through w, as in the paper's release."""
    depth_pass: bool = True
    """Multiply the weights at each pixel by what a picture of a quarter of the image's size says of
    the depths there (`mobilegs/render/depth_pass.py`). Solid things hide more of what lies behind
    them; a frame draws all Gaussians a second time, at a sixteenth of the pixels. No effect with
    `blend=sorted`."""

    def __post_init__(self) -> None:
        _ = self.weighting  # raises InputError for values out of range

    @property
    def weighting(self) -> Weighting:
        """The weighting of the scene and its file."""
        return Weighting(
            "depth_pass" if self.depth_pass else "mobile_gs",
            exponent_max=self.exponent_max,
            alpha_min=self.alpha_min,
            detached=self.detached,
        )


@dataclass(frozen=True)
class StudentConfig:
    """All settings of the student's training."""

    steps: int = 30_000
    """Training steps, at least 1."""
    views_per_step: int = 1
    """Photos per step, at least 1. Their losses are summed, not averaged, as in the release: Adam,
    whose steps do not depend on the scale of the gradients, mostly cancels the factor."""
    blend: Blend = "sortfree"
    """`sortfree`, or `sorted`: blend in the order of depth, as the teacher does. `sorted` keeps the
    view-dependent opacity of `view_dependence` but not phi, which then learns nothing; with
    `view_dependence.kind=constant` it gives a quantised 3DGS scene."""
    weighting: WeightingConfig = field(default_factory=WeightingConfig)
    """Weights that replace the order of depth, and the alpha at which ellipses end."""
    footprint: Footprint = field(
        default_factory=lambda: Footprint(0.1, antialiased=True, soft_edge=True)
    )
    """Blur and edge of Gaussians on the image, in training and in the file. `soft_edge` has no
    effect on blend=sorted."""
    least_variance: float = 0.2
    """Lower limit of the squared scales, as `teacher.least_variance`; 0: no limit. Codebooks, in
    which Gaussians share their scales, hold it until they quantise."""
    level_sigma: float = 1.0
    """Train with large Gaussians added up in smaller targets, as viewers do: smallest standard
    deviation in pixels of the target, 0.6 to 100; 0: all at full size. No effect on
    blend=sorted."""
    color: ColorConfig = field(default_factory=ColorConfig)
    """Representation of the colours."""
    view_dependence: ViewDependence = field(default_factory=ViewDependence)
    """Representation of opacity and weight as functions of the viewing direction."""
    schedule: ScheduleConfig = field(default_factory=ScheduleConfig)
    """Times at which parts of the method begin."""
    lr: StudentLearningRates = field(default_factory=StudentLearningRates)
    """Learning rates."""
    exposure: ExposureConfig = field(default_factory=ExposureConfig)
    """Exposure and white balance of each photo."""
    loss: LossConfig = field(default_factory=LossConfig)
    """Weights of the loss."""
    quantization: QuantizationConfig = field(default_factory=QuantizationConfig)
    """Quantisation and size of the file."""
    pruning: VoteConfig = field(default_factory=VoteConfig)
    """Removal of Gaussians by votes."""
    cache_mib: int = 2048
    """Memory for the teacher's images in MiB, at least 0. Images that do not fit are rendered again
    when they are needed."""

    def __post_init__(self) -> None:
        check(self, steps=COUNT, views_per_step=COUNT)
        check(self, cache_mib=NOT_NEGATIVE, least_variance=NOT_NEGATIVE)
        validate_level_sigma(self.level_sigma)
        check_choice("blend", self.blend, Blend)
        levels = self.quantization.lod_levels
        if levels > self.max_lod_levels:
            raise InputError(
                f"{levels} lod_levels with {self.color_shape.latents} latents of colours and those "
                "of lobes need more streams than a file may have: at most "
                f"{self.max_lod_levels} levels are possible"
            )

    @property
    def expected_bytes(self) -> tuple[int, float]:
        """Estimated size of the file: bytes of the whole, and bytes per Gaussian."""
        quantization, schedule = self.quantization, self.schedule
        if quantization.target_mb:
            return round(1e6 * quantization.target_mb), 0.0
        if quantization.method == "nvq":
            return 21_000, 15.6
        each = 11.2 if schedule.rate_from >= schedule.quantize_from else 10.3
        return 6_000, max(each + 3.0 * math.log2(quantization.quality), 4.0)

    @property
    def max_lod_levels(self) -> int:
        """LOD levels for which a file has streams: with `sq`, each column is a stream per level."""
        if self.quantization.method != "sq":
            return LOD_LEVELS_MAX
        shape = self.view_dependence.shape
        columns = ATTRIBUTE_STREAMS + self.color_shape.latents + (shape.latents if shape else 0)
        return min(LOD_LEVELS_MAX, (STREAMS_MAX - NETWORK_STREAMS) // columns)

    @property
    def color_shape(self) -> ColorShape:
        """Shape of the colour decoder."""
        shape = ColorShape(self.color.decoder, self.color.degree)
        if self.quantization.method != "sq":
            return shape
        return shape._replace(latents=min(self.color.latents, shape.latents_max))
