"""How the student is trained: lengths, rates, and what each part of it is."""

import math
from dataclasses import dataclass, field, fields

from mobilegs.compress.appearance import COLORS, ColorShape
from mobilegs.compress.codebooks import CodebookSizes
from mobilegs.compress.uniform_quantizer import ScalarSteps
from mobilegs.errors import InputError
from mobilegs.mgs.container import STREAMS_MAX
from mobilegs.mgs.quantized_scene import LAYERS_MAX
from mobilegs.render import Weighting
from mobilegs.render.scene import BLENDS
from mobilegs.train.student.mask_pruning import PresenceConfig
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
)

CODINGS = ("nvq", "sq")
# of a file with `sq`: one for each of its decoders, and in every layer positions, three scales,
# three rotations and their finer bits, and the opacity
NETWORK_STREAMS, ATTRIBUTE_STREAMS = 2, 9


@dataclass(frozen=True)
class StudentConfig:
    """How the student is trained. Times are fractions of the run, rates those of Adam."""

    steps: int = 30_000
    """Number of steps."""
    views_per_step: int = 1
    """Photos of a step. Their losses are summed, not averaged (as the release does): Adam, whose
    steps do not depend on the gradients' scale, mostly cancels the factor."""
    blend: str = "sortfree"
    """`sorted` blends in the order of depth, as the teacher does: a quantised 3DGS scene. There is
    no phi then, and the view dependence must be `constant`."""
    weighting: Weighting = field(default_factory=lambda: Weighting(alpha_min=1 / 64))
    """The weights that take the place of the order, and where ellipses end: at 1/64 they are a
    third smaller than at the paper's 1/255. Of `sort_free_gs`, sigma (here in extents of the
    scene) and the background's weight are where learning begins; a weight of 0 stays 0."""
    sh_degree: int = 1
    """Degree of the colour's spherical harmonics, 0 to 3."""
    colors: str = "linear"
    """What makes harmonics of latents: `linear`, two matrices, or the paper's `networks`, which
    know where a Gaussian is."""
    color_latents: int = 6
    """Latents of a colour with colors=linear and coding=sq, as far as there are harmonics that they
    tell apart: three of its constant part, the others of what depends on the direction. All others
    have the paper's six."""
    view: ViewDependence = field(default_factory=ViewDependence)
    """Where opacity and weight come from, seen from a direction."""
    start_opacity: float = 0.0
    """Opacity of all Gaussians at the start (the release: 0.5, and with opacity_rate=0 the network
    alone tells opacities apart, as there); 0 keeps the teacher's."""
    net_fraction: float = 5 / 30
    """When latents and what decodes them replace the harmonics (paper: 5,000 of 30,000)."""
    codes_fraction: float = 0.9
    """When codes replace what they stand for. (The release: 29,000 of 30,000, with codebooks that
    do not learn. Small ones that do profit from time: 0.7 suits `nvq`.)"""
    ssim_weight: float = 0.2
    """Share of D-SSIM in the distance to the photo, the rest is L1."""
    distill_weight: float = 1.0
    """Weight of the L1 distance to the teacher's picture."""
    depth_weight: float = 0.1
    """Weight of the scale-invariant log-depth distance to the teacher."""
    distill_between: int = 2
    """Every how many steps the teacher shows a view from between two training cameras, where no
    photo says what is right; about the photos' views it is not asked then. 0: it shows those, in
    every step (the paper). So it does where no two cameras look at the same things."""
    depth_masked: bool = True
    """Whether that distance leaves out pixels which either does not cover, and compares means.
    (The release compares sums of z, in all pixels.)"""
    fill_price: float = 5e-5
    """What the loss asks for each ellipse that lies over a pixel, in the mean of the picture, since
    that is what a frame costs: scales alone pay. (The paper: nothing.)"""
    moments_kept: bool = True
    """Whether Adam goes on where it is when networks take over the colour (the release: no)."""
    positions_rounded: bool = True
    """Whether networks and codes learn from positions as the file rounds them (the release: no)."""
    position_error: float = 0.05
    """How far rounding may move Gaussians in the training pictures: pixels, root mean square."""
    position_rate: float = 1.6e-6
    """Rate of the centres, in extents of the scene."""
    position_share: float = 0.05
    """Its limit, in sizes of the teacher's median Gaussian (geometric means of the two larger
    scales): where cameras stand far off, an extent says little about what is fine."""
    quat_rate: float = 1e-3
    """Rate of the quaternions."""
    scale_rate: float = 5e-3
    """Rate of the scales' logarithms."""
    opacity_rate: float = 0.01
    """Rate of the base opacities' logits, where lobes are not free."""
    lobe_rate: float = 0.02
    """Rate of the lobes, and of the latents that they become."""
    lobe_basis_rate: float = 2e-3
    """Rate of what turns latents into lobes, if that is linear; a network has network_rate."""
    sh0_rate: float = 2.5e-3
    """Rate of the colour's constant part, while explicit."""
    sh_rest_rate: float = 1.25e-4
    """Rate of its view-dependent part, while explicit."""
    weighting_rate: float = 0.01
    """Rate of the logarithms of what a weighting learns."""
    network_rate: float = 1e-3
    """Rate of the networks that opacity and weight come from."""
    latent_rate: float = 2.5e-3
    """Rate of the colour's latents."""
    decoder_rate: float = 1e-3
    """Rate of what decodes them."""
    codebook_rate: float = 1e-3
    """With `nvq`, rate of the codebooks of scales and opacities."""
    rotation_codebook_rate: float = 5e-4
    """With `nvq`, rate of the codebooks of rotations."""
    appearance_codebook_rate: float = 1e-3
    """With `nvq`, rate of the codebooks of the colour's latents."""
    lobe_codebook_rate: float = 5e-3
    """With `nvq`, rate of the codebooks of the lobes' latents."""
    free_share: float = 0.2
    """With codes, what is left of the rates of what they stand for."""
    reassign_every: int = 25
    """With `nvq`, steps between two choices of the nearest codebook entries. (With `sq` the nearest
    multiples are chosen in every step.)"""
    final_rate: float = 0.1
    """What is left of every rate at the end; it falls geometrically from `decay_from` on."""
    decay_from: float = 0.5
    """Fraction of the run from which the rates fall."""
    regression_steps: int = 400
    """Steps that fit the decoding networks to the harmonics they replace."""
    coding: str = "sq"
    """What codes are: `nvq`, indices into codebooks (the paper), or `sq`, multiples of steps,
    of rotations turned as little as possible and of latents that are not correlated: truer at
    fewer bytes (docs/compression.md)."""
    canonical: bool = False
    """Whether Gaussians are turned as little as possible with `nvq`, too, at the start: of the 24
    ways to name the axes of an ellipsoid the one whose rotation is smallest."""
    codebooks: CodebookSizes = field(default_factory=CodebookSizes)
    """Sizes of the codebooks; with `nvq` alone."""
    scalars: ScalarSteps = field(default_factory=ScalarSteps)
    """Steps, at a fineness of 1; with `sq` alone."""
    fineness: float = 2.0
    """How many times as fine as `scalars` the steps begin; a bit's price falls with its square, as
    what a step costs in the picture does."""
    step_rate: float = 2e-3
    """With `sq`, rate of the steps' logarithms. 0: they stay as they are."""
    bit_price: float = 1e-3
    """With `sq`, what a bit per Gaussian adds to the loss, at a fineness of 1: more makes smaller,
    plainer files."""
    price_fraction: float = 0.4
    """With `sq`, when a price on bits is asked for the first time, at the latest with the codes:
    until these are there, for how far numbers are from their mean, most of them then come near."""
    target_mb: float = 0.0
    """With `sq`, megabytes (10^6) that the file shall have: all steps follow alike, up to eight
    times as large or small as they are at first. 0: whatever price and steps lead to."""
    layers: int = 0
    """Layers of the file, each of which makes four times as many Gaussians: a viewer shows the
    first ones while the others still come. 0: as many as leave 10,000 to the first."""
    votes: VoteConfig = field(default_factory=VoteConfig)
    """Pruning."""
    presence: PresenceConfig = field(default_factory=PresenceConfig)
    """Pruning by learned masks."""
    cache_mib: int = 2048
    """Memory for the teacher's pictures; what does not fit is drawn again."""

    def __post_init__(self) -> None:
        if not 0 <= self.net_fraction <= self.codes_fraction <= 1:
            raise InputError(
                "net_fraction and codes_fraction must rise in this order within 0 to 1, not "
                f"{self.net_fraction} and {self.codes_fraction}"
            )
        if self.view.fraction > self.codes_fraction and self.view.kind not in (
            "network",
            "decoded",
        ):
            raise InputError(
                f"lobes must be settled (view.fraction {self.view.fraction}) before they are coded "
                f"(codes_fraction {self.codes_fraction})"
            )
        if self.coding not in CODINGS:
            raise InputError(f"unknown coding '{self.coding}': use {' or '.join(CODINGS)}")
        if self.colors not in COLORS:
            raise InputError(f"unknown colors '{self.colors}': use {' or '.join(COLORS)}")
        if not 0 <= self.target_mb < math.inf or (self.target_mb and self.coding != "sq"):
            raise InputError(
                f"target_mb {self.target_mb} must be at least 0, and needs coding=sq unless it is 0"
            )
        if self.blend not in BLENDS:
            raise InputError(f"unknown blend '{self.blend}': use {' or '.join(BLENDS)}")
        if self.blend == "sorted" and self.view.kind != "constant":
            raise InputError(
                "sorted blending has no use for a view dependence: set view.kind=constant, too"
            )
        rates = [field.name for field in fields(self) if field.name.endswith("_rate")]
        numbers = (
            "distill_weight",
            "distill_between",
            "depth_weight",
            "position_error",
            "position_share",
            "free_share",
            "bit_price",
            "fill_price",
        )
        check(
            self,
            **dict.fromkeys((*rates, *numbers, "regression_steps"), NOT_NEGATIVE),
            cache_mib=NOT_NEGATIVE,
            **dict.fromkeys(("steps", "views_per_step", "reassign_every"), COUNT),
            **dict.fromkeys(("ssim_weight", "decay_from", "price_fraction"), FRACTION),
            layers=Range(high=float(LAYERS_MAX)),
            sh_degree=DEGREE,
            color_latents=Range(low=float(ColorShape().latents)),
            start_opacity=Range(high=1.0, below=True),
        )
        if self.layers > self.layers_max:
            raise InputError(
                f"{self.layers} layers with {self.color.latents} latents of colours and those of "
                "lobes are more streams than a file may have: at most "
                f"{self.layers_max} layers are possible"
            )
        check(self, fineness=POSITIVE)
        _ = self.steps_of_codes  # refused here if it cannot be
        check(self, final_rate=SHARE)  # a rate of the rates, which must leave something
        check(self.weighting, sigma=POSITIVE, background_weight=NOT_NEGATIVE)

    @property
    def steps_of_codes(self) -> ScalarSteps | None:
        """Where the steps of `sq` begin; `nvq` has none."""
        return self.scalars.finer(self.fineness) if self.coding == "sq" else None

    @property
    def price(self) -> float:
        """What a bit per Gaussian adds to the loss of a photo."""
        return self.bit_price / self.fineness**2

    @property
    def bytes_expected(self) -> tuple[int, float]:
        """What a file has once, and for each Gaussian, by what such files have had so far."""
        if self.target_mb:
            return round(1e6 * self.target_mb), 0.0
        if self.coding == "nvq":
            return 21_000, 15.6
        each = 11.2 if self.price_fraction >= self.codes_fraction else 10.3
        return 6_000, max(each + 3.0 * math.log2(self.fineness), 4.0)

    @property
    def layers_max(self) -> int:
        """Layers that a file has streams for: with `sq` each column is one in every layer."""
        if self.coding != "sq":
            return LAYERS_MAX
        lobes = self.view.shape.latents if self.view.shape else 0
        columns = ATTRIBUTE_STREAMS + self.color.latents + lobes
        return min(LAYERS_MAX, (STREAMS_MAX - NETWORK_STREAMS) // columns)

    @property
    def color(self) -> ColorShape:
        """What colours are made of."""
        shape = ColorShape(self.colors, self.sh_degree)
        if self.coding != "sq":
            return shape
        return shape._replace(latents=min(self.color_latents, shape.latents_max))
