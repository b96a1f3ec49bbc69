"""Rows of the paper's tables: the settings that each row changes. See bench/paper/run.py."""

from dataclasses import dataclass, replace

from bench.paper.student import PAPER_METHOD, Method
from mobilegs.train.recipes import PAPER, RELEASE

ARCHIVED = "f977b68"  # the commit whose bench/paper/run.py makes archived rows

NVQ = ("student.quantization.method=nvq", "student.schedule.quantize_from=0.7")
LATE_RATE_TERM = ("student.schedule.rate_from=1",)
NO_FRONT = ("student.loss.front_weight=0",)
NO_VIRTUAL_VIEWS = ("student.loss.virtual_view_every=0",)
NO_OVERDRAW = ("student.loss.overdraw_weight=0",)
# the default with codebooks and without what this project adds to the loss
CODEBOOKS = (*NVQ, *NO_OVERDRAW, *NO_VIRTUAL_VIEWS, *NO_FRONT, *LATE_RATE_TERM)
CONSTANT = "student.view_dependence.kind=constant"
SORTED = (CONSTANT, "student.blend=sorted")
EXPLICIT = ("student.schedule.quantize_from=1", "student.schedule.latents_from=1")
NO_VOTES = ("student.pruning.quantile=0",)
ONCE = ("student.pruning.interval=0.4", "student.pruning.until=0.4")
ALL_DEGREES = ("student.color.degree=3",)


@dataclass(frozen=True)
class Row:
    """One way to make a scene."""

    table: str
    """The table it belongs to."""
    about: str
    """A description for the tables."""
    settings: tuple[str, ...] = ()
    """Settings that differ from the preset, as for `mobilegs train --set`."""
    teacher: str = "mini-splatting"
    """The method of its teacher, as for `mobilegs train --method`."""
    coded: bool = True
    """True: figures are those of the file. False: of float32 tensors."""
    student: bool = True
    """False for the teacher itself."""
    method: Method = PAPER_METHOD
    """Its weights and votes, where they are not the paper's."""
    fork: str = ""
    """A row whose student it shares until values are quantised; that row must be made first."""
    classic: bool = True
    """True: teacher and student cover pixels as 3DGS does, so that all such rows share a teacher.
    False: as the preset says."""
    archived: bool = False
    """True: its cells are kept, but only the commit ARCHIVED can make it."""


def _thresholds() -> dict[str, Row]:
    return {
        f"vote-{share}": Row(
            "pruning",
            f"votes below the {share} quantile",
            (f"student.pruning.quantile={share}",),
        )
        for share in (0.1, 0.4, 0.6)
    }


def _codebooks() -> dict[str, Row]:
    return {
        f"codebook-{bits}": Row(
            "codebooks",
            f"2^{bits} entries for each pair of colour latents",
            (f"student.quantization.codebooks.appearance={2**bits}",),
        )
        for bits in (6, 8, 12)
    }


OURS: dict[str, Row] = {
    "teacher": Row("main", "Mini-Splatting, the teacher", coded=False, student=False),
    "3dgs": Row("main", "3DGS, not quantised", teacher="3dgs", coded=False, student=False),
    "ours": Row("main", "the default: learned lobes, scalar quantisation"),
    "ours-sorted": Row(
        "main", "the default, blended sorted; one opacity per Gaussian, no phi, no lobes", SORTED
    ),
}
# all rows with codebooks, as in the paper
THEIRS: dict[str, Row] = {
    "codebooks": Row(
        "main",
        "the paper's codebooks, virtual views, overdraw, front and early rate terms off",
    ),
    # ---- the paper's Table 5
    "no-order-independence": Row(
        "ablation", "blended sorted, quantised; one opacity per Gaussian, no phi, no lobes", SORTED
    ),
    "no-view-dependence": Row(
        "ablation",
        "opacity and phi are constant per Gaussian",
        archived=True,
    ),
    "no-codes": Row("ablation", "neither networks nor codebooks", EXPLICIT, coded=False),
    "no-depth-term": Row("ablation", "w without phi / d^2", method=Method("no_depth")),
    "no-scale-term": Row("ablation", "w without exp(s / d)", method=Method("no_scale")),
    "sh-0": Row("ablation", "SH degree 0", ("student.color.degree=0",)),
    "sh-2": Row(
        "ablation",
        "SH degree 2 (24 numbers) from three view latents",
        ("student.color.degree=2",),
    ),
    "sh-3": Row(
        "ablation",
        "SH degree 3 (45 numbers) from three view latents",
        ("student.color.degree=3",),
    ),
    # ---- pruning
    "no-pruning": Row("pruning", "no votes", NO_VOTES),
    "by-opacity-once": Row(
        "pruning",
        "votes by opacity only, one pruning",
        ONCE,
        method=Method(criterion="opacity"),
    ),
    "by-scale-once": Row(
        "pruning",
        "votes by scale only, one pruning",
        ONCE,
        method=Method(criterion="scale"),
    ),
    **_thresholds(),
    "mini-splatting-on": Row(
        "pruning",
        "Mini-Splatting, trained on for as long",
        (*SORTED, *EXPLICIT, *ALL_DEGREES, *NO_VOTES),
        coded=False,
    ),
    "mini-splatting-votes": Row(
        "pruning",
        "the same with the votes",
        (*SORTED, *EXPLICIT, *ALL_DEGREES),
        coded=False,
    ),
    "masks": Row(
        "pruning",
        "the same with learned masks",
        coded=False,
        archived=True,
    ),
    # ---- quantisation
    **_codebooks(),
    # ---- rivals
    "sort-free-gs": Row(
        "rivals",
        "weights of SortFreeGS, linear form, with learned sigma and background weight",
        archived=True,
    ),
    "two-pass": Row(
        "rivals",
        "stand-in for GES: surfaces of the same Gaussians, then everything not behind them",
        archived=True,
    ),
    "quantized-3dgs": Row(
        "rivals",
        "3DGS, quantised",
        (*SORTED, *ALL_DEGREES, *NO_VOTES),
        teacher="3dgs",
    ),
    "quantized-mini-splatting": Row(
        "rivals", "Mini-Splatting, quantised", (*SORTED, *ALL_DEGREES, *NO_VOTES)
    ),
}

# the paper's own model, and every line of its ablations
PAPERS: dict[str, Row] = {
    "paper": Row("paper", "the preset paper's choices"),
    "paper-no-order-independence": Row(
        "paper",
        "blended sorted, the network's opacities kept, without phi",
        ("student.blend=sorted",),
    ),
    "paper-no-view-dependence": Row(
        "paper",
        "opacity and phi are constant per Gaussian",
        archived=True,
    ),
    "paper-no-quantization": Row(
        "paper", "neither networks nor codebooks for colours and shapes", EXPLICIT, coded=False
    ),
    **{
        f"paper-sh-{degree}": Row(
            "paper", f"SH degree {degree}", (f"student.color.degree={degree}",)
        )
        for degree in (0, 2, 3)
    },
    "paper-no-depth-term": Row("paper", "w without phi / d^2", method=Method("no_depth")),
    "paper-no-scale-term": Row("paper", "w without exp(s / d)", method=Method("no_scale")),
    "paper-no-pruning": Row("paper", "no votes", NO_VOTES),
    "paper-by-opacity": Row(
        "paper",
        "votes by opacity only, one pruning",
        ONCE,
        method=Method(criterion="opacity"),
    ),
    "paper-by-scale": Row(
        "paper",
        "votes by scale only, one pruning",
        ONCE,
        method=Method(criterion="scale"),
    ),
    **{
        f"paper-vote-{share}": Row(
            "paper",
            f"votes below the {share} quantile",
            (f"student.pruning.quantile={share}",),
        )
        for share in (0.1, 0.4, 0.6)
    },
    **{
        f"paper-codebook-{bits}": Row(
            "paper",
            f"2^{bits} entries for each pair of colour latents",
            (f"student.quantization.codebooks.appearance={2**bits}",),
        )
        for bits in (6, 8, 12)
    },
}

# the default as it ships, and its sorted twins, for the table at equal bytes
DEFAULTS: dict[str, Row] = {
    "default-teacher": Row(
        "default", "the default's teacher", coded=False, student=False, classic=False
    ),
    "default": Row("default", "the default as it ships, antialiased", classic=False),
    "default-sorted": Row("default", "the same, blended sorted", SORTED, classic=False),
    "default-sorted-lobes": Row(
        "default",
        "blended sorted, with lobes of opacity",
        ("student.blend=sorted",),
        classic=False,
    ),
    "default-sorted-sh-2": Row(
        "default",
        "blended sorted, SH of degree 2 from nine latents",
        (*SORTED, "student.color.degree=2", "student.color.latents=9"),
        classic=False,
    ),
}

# the default with one departure from the paper taken back
_NETWORK = ("student.view_dependence.kind=network",)
_TAKEN_BACK = {
    "no-depth-pass": ("no depth pass", ("student.weighting.depth_pass=false",)),
    "network": ("the paper's network makes opacities and phi in every frame", _NETWORK),
    "network-alone": (
        "the same, without a base opacity per Gaussian",
        (*_NETWORK, "student.view_dependence.start_opacity=0.5", "student.lr.opacities=0"),
    ),
    "full-ellipses": ("ellipses out to alpha = 1/255", ("student.weighting.alpha_min=0.00392157",)),
    "exponent-80": (
        "exp(s / d) with its exponent up to 80",
        ("student.weighting.exponent_max=80",),
    ),
    "no-virtual-views": (
        "distilled at the photos' views in every step",
        NO_VIRTUAL_VIEWS,
    ),
    "no-front": ("without the term of coverage before planes", NO_FRONT),
    "no-overdraw-term": ("without the overdraw term", NO_OVERDRAW),
    "all-depths": ("depths compared at all pixels", ("student.loss.mask_depth=false",)),
    "color-networks": ("networks make the colours", ("student.color.decoder=latent_networks",)),
    "codebooks": ("the paper's codebooks, which learn", NVQ),
    "frozen-codebooks": (
        "the same, and neither codebooks nor indices change",
        (*NVQ, "student.schedule.reassign_every=0", "student.lr.codebook_factor=0"),
    ),
    "late-rate-term": ("no rate term before quantisation", LATE_RATE_TERM),
    "unrounded-means": (
        "means rounded in the file alone",
        ("student.quantization.round_means=false",),
    ),
    "1000-votes": ("1,000 votes per interval", ("student.pruning.votes_per_interval=1000",)),
    "three-photos": ("three photos per step", ("student.views_per_step=3",)),
    "constant-rates": ("learning rates that do not fall", ("student.lr.final_factor=1",)),
}
DEFAULTS |= {
    f"default-{name}": Row("default", about, settings, classic=False)
    for name, (about, settings) in _TAKEN_BACK.items()
}

# the release's model: what a part of it is worth
RELEASES: dict[str, Row] = {
    "release": Row("paper", "the preset release's choices"),
    "release-sorted": Row(
        "paper",
        "`release` blended sorted, the network's opacities kept, without phi",
        ("student.blend=sorted",),
    ),
    "release-no-view-dependence": Row(
        "paper",
        "`release`, opacity and phi of each Gaussian the same in every direction",
        (
            "student.view_dependence.kind=latent",
            "student.view_dependence.degree=0",
            "student.lr.opacities=0.01",
        ),
    ),
    "release-no-votes": Row("paper", "`release` without votes", NO_VOTES),
    "release-network-eps": Row(
        "paper",
        "`release`, 1e-8 as the epsilon of the network's Adam, which is the release's",
        method=Method(network_eps=1e-8),
    ),
    **{
        f"release-codebook-{bits}": Row(
            "paper",
            f"`release`, 2^{bits} entries for each pair of colour latents",
            (f"student.quantization.codebooks.appearance={2**bits}",),
            fork="release",
        )
        for bits in (6, 8)
    },
}

ROWS = (
    OURS
    | DEFAULTS
    | {name: replace(row, settings=(*CODEBOOKS, *row.settings)) for name, row in THEIRS.items()}
    | {name: replace(row, settings=(*PAPER, *row.settings)) for name, row in PAPERS.items()}
    | {name: replace(row, settings=(*RELEASE, *row.settings)) for name, row in RELEASES.items()}
)
BASE = "codebooks"  # the row that the paper's tables start from
