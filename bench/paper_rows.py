"""The rows of the paper's tables: what each leaves out or replaces. See bench/paper.py."""

from dataclasses import dataclass, replace

# what the presets do otherwise than the paper in all rows: where the teacher is asked, a price on
# bits before there are codes, codes, and a price on what is painted
LATE_PRICE = ("student.price_fraction=1",)
OF_PHOTOS = ("student.distill_between=0", *LATE_PRICE)
CODEBOOKS = (
    "student.coding=nvq",
    "student.codes_fraction=0.7",
    "student.fill_price=0",
    *OF_PHOTOS,
)
CONSTANT = "student.view.kind=constant"
SORTED = (CONSTANT, "student.blend=sorted")
EXPLICIT = ("student.codes_fraction=1", "student.net_fraction=1")
FULL = "student.weighting.alpha_min=0.00392157"
NO_VOTES = ("student.votes.quantile=0",)
ONCE = ("student.votes.interval=0.4", "student.votes.until=0.4")
ALL_DEGREES = ("student.sh_degree=3",)
MASKS = (
    "student.presence.weight=0.1",
    "student.presence.rate=0.01",
    "student.presence.until=0.8",
)
# opacity from the network alone: one base for all, which does not learn
NO_BASE = ("student.view.kind=network", "student.start_opacity=0.5", "student.opacity_rate=0")
# what the release does in the last thirtieth: codebooks that do not learn
FROZEN = (
    "student.codes_fraction=0.9667",
    "student.codebook_rate=1e-8",
    "student.rotation_codebook_rate=1e-8",
    "student.appearance_codebook_rate=1e-8",
    "student.lobe_codebook_rate=1e-8",
    "student.free_share=0",
)


@dataclass(frozen=True)
class Row:
    """One way to make a scene."""

    table: str
    """The table it belongs to."""
    about: str
    """What it is, in words."""
    settings: tuple[str, ...] = ()
    """What differs from the preset, as for `mobilegs train --set`."""
    teacher: str = "mini-splatting"
    """The method of its teacher, as for `mobilegs train --method`."""
    coded: bool = True
    """Whether figures are those of the file; otherwise of the tensors, 4 bytes a number."""
    student: bool = True
    """False for the teacher itself."""


def _thresholds() -> dict[str, Row]:
    return {
        f"vote-{share}": Row(
            "pruning",
            f"votes below the {share} quantile",
            (f"student.votes.quantile={share}",),
        )
        for share in (0.1, 0.3, 0.4, 0.5, 0.6)
    }


def _codebooks() -> dict[str, Row]:
    return {
        f"codebook-{bits}": Row(
            "codebooks",
            f"2^{bits} entries for each pair of the colour's latents",
            (f"student.codebooks.appearance={2**bits}",),
        )
        for bits in (6, 8, 10, 12)
    }


def _scalars() -> dict[str, Row]:
    return {
        f"sq-{price}": Row(
            "codebooks",
            f"multiples of steps of a fineness of 1, {price} a bit per Gaussian",
            ("student.fineness=1", f"student.bit_price={price}"),
        )
        for price in (0.0003, 0.001, 0.003)
    } | {
        f"sq-fine-{fine}": Row(
            "codebooks",
            f"multiples of steps {fine} times as fine, a bit at 1/{fine**2} of its price",
            (f"student.fineness={fine}",),
        )
        for fine in (3, 4)
    }


def _masks() -> dict[str, Row]:
    return {
        f"masked-{weight}": Row(
            "main",
            f"as `of-photos`, with learned masks of weight {weight}",
            (*OF_PHOTOS, f"student.presence.weight={weight}"),
        )
        for weight in (0.0025, 0.005, 0.01, 0.03)
    }


OURS: dict[str, Row] = {
    "teacher": Row("main", "Mini-Splatting: the teacher", coded=False, student=False),
    "3dgs": Row("main", "3DGS, not coded", teacher="3dgs", coded=False, student=False),
    "ours": Row("main", "the default: lobes from latents, codes are multiples of steps"),
    "ours-sorted": Row(
        "main", "the default, blended sorted; one opacity a Gaussian, neither phi nor lobes", SORTED
    ),
    "late-price": Row("main", "the default, no price on bits before there are codes", LATE_PRICE),
    "of-photos": Row(
        "main",
        "as `late-price`, the teacher asked about the photos' views in every step, as in the paper",
        OF_PHOTOS,
    ),
    "photos-alone": Row(
        "main",
        "as `late-price`, neither the teacher's pictures nor its depths",
        (*OF_PHOTOS, "student.distill_weight=0", "student.depth_weight=0"),
    ),
    "unpaid": Row(
        "main",
        "as `of-photos`, nothing asked for what frames paint",
        (*OF_PHOTOS, "student.fill_price=0"),
    ),
    "paid-twice": Row(
        "main",
        "as `of-photos`, twice the price on what frames paint",
        (*OF_PHOTOS, "student.fill_price=1e-4"),
    ),
    **_masks(),
    **_scalars(),
}
# all with codebooks, as the paper has them
THEIRS: dict[str, Row] = {
    "codebooks": Row(
        "main",
        "as `of-photos` with the paper's codebooks, nothing asked for what frames paint",
    ),
    "network": Row(
        "main",
        "the paper's network in every frame, with a base opacity per Gaussian kept",
        ("student.view.kind=network",),
    ),
    "paper": Row(
        "main",
        "the same, the paper's networks for colours, ellipses out to alpha = 1/255",
        ("student.view.kind=network", "student.colors=networks", FULL),
    ),
    "release": Row(
        "main",
        "the published method with all errors of the release that can be put back",
        (
            *NO_BASE,
            *FROZEN,
            "student.colors=networks",
            FULL,
            "student.weighting.exponent_max=80",
            "student.weighting.detached=true",
            "student.depth_masked=false",
            "student.depth_weight=0.2",
            "student.moments_kept=false",
            "student.positions_rounded=false",
        ),
    ),
    # ---- the paper's Table 5
    "no-order-independence": Row(
        "ablation", "blended sorted, coded; one opacity a Gaussian, neither phi nor lobes", SORTED
    ),
    "no-view-dependence": Row(
        "ablation",
        "opacity and phi are constants of the Gaussian",
        ("student.view.kind=free", "student.view.fraction=0.7", "student.view.degree=0"),
    ),
    "no-phi": Row("ablation", "opacity a constant, phi = 1", (CONSTANT,)),
    "no-codes": Row("ablation", "neither networks nor codebooks", EXPLICIT, coded=False),
    "full-ellipses": Row("ablation", "ellipses out to alpha = 1/255", (FULL,)),
    "no-depth-term": Row("ablation", "w without phi / d^2", ("student.weighting.name=no_depth",)),
    "no-scale-term": Row("ablation", "w without exp(s / d)", ("student.weighting.name=no_scale",)),
    "wide-lobes": Row(
        "ablation", "the network of the lobes 64 wide, not 16", ("student.view.hidden=64",)
    ),
    "color-networks": Row(
        "ablation", "the paper's networks make the colours", ("student.colors=networks",)
    ),
    "sh-0": Row("ablation", "colour of degree 0", ("student.sh_degree=0",)),
    "sh-2": Row(
        "ablation",
        "colour of degree 2 (24 numbers), from three view latents",
        ("student.sh_degree=2",),
    ),
    "sh-3": Row(
        "ablation",
        "colour of degree 3 (45 numbers), from three view latents",
        ("student.sh_degree=3",),
    ),
    # ---- pruning
    "no-pruning": Row("pruning", "no votes", NO_VOTES),
    "by-opacity": Row("pruning", "votes on opacity alone", ("student.votes.by=opacity",)),
    "by-scale": Row("pruning", "votes on the scale alone", ("student.votes.by=scale",)),
    "by-opacity-once": Row(
        "pruning", "votes on opacity alone, one pruning", ("student.votes.by=opacity", *ONCE)
    ),
    "by-scale-once": Row(
        "pruning", "votes on the scale alone, one pruning", ("student.votes.by=scale", *ONCE)
    ),
    **_thresholds(),
    "mini-splatting-on": Row(
        "pruning",
        "Mini-Splatting trained on for as long",
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
        (*SORTED, *EXPLICIT, *ALL_DEGREES, *NO_VOTES, *MASKS),
        coded=False,
    ),
    "masks-votes": Row(
        "pruning",
        "the same with both",
        (*SORTED, *EXPLICIT, *ALL_DEGREES, *MASKS),
        coded=False,
    ),
    # ---- codebooks, and what else codes can be
    **_codebooks(),
    # ---- rivals
    "sort-free-gs": Row(
        "rivals",
        "SortFreeGS's weights (Eq. 1), sigma and the background's learned",
        ("student.weighting.name=sort_free_gs", "student.weighting.background_weight=0.1"),
    ),
    "two-pass": Row(
        "rivals",
        "surfaces first, then what is not behind them, in the manner of GES",
        ("student.weighting.name=two_pass",),
    ),
    "quantised-3dgs": Row(
        "rivals",
        "3DGS, coded",
        (*SORTED, *ALL_DEGREES, *NO_VOTES),
        teacher="3dgs",
    ),
    "quantised-mini-splatting": Row(
        "rivals", "Mini-Splatting, coded", (*SORTED, *ALL_DEGREES, *NO_VOTES)
    ),
    # ---- errors of the release, put back one at a time
    "random-opacity": Row(
        "fixes",
        "opacity from the network alone, none kept; compare with `network`",
        NO_BASE,
    ),
    "frozen-codebooks": Row("fixes", "codes at the end, whose books do not learn", FROZEN),
    "depth-weight-0.2": Row("fixes", "the depth loss counted twice", ("student.depth_weight=0.2",)),
    "depth-unmasked": Row(
        "fixes",
        "the depth loss in all pixels, of depths that are not divided by alpha",
        ("student.depth_masked=false",),
    ),
    "moments-lost": Row(
        "fixes", "Adam begins anew when networks take over", ("student.moments_kept=false",)
    ),
    "positions-unrounded": Row(
        "fixes",
        "positions as they are, until the file rounds them",
        ("student.positions_rounded=false",),
    ),
    "weight-detached": Row(
        "fixes",
        "depth and scale learn nothing through w",
        ("student.weighting.detached=true",),
    ),
    "exponent-80": Row(
        "fixes", "exp(s / d) without a ceiling", ("student.weighting.exponent_max=80",)
    ),
    "no-distillation": Row(
        "fixes",
        "photos alone",
        ("student.distill_weight=0", "student.depth_weight=0"),
    ),
}

ROWS = OURS | {
    name: replace(row, settings=(*CODEBOOKS, *row.settings)) for name, row in THEIRS.items()
}
BASE = "codebooks"  # the row that those of the paper's tables change something of
