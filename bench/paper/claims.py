"""The paper's tables line by line, its claims, and the default's departures from it."""

from typing import NamedTuple

from bench.paper.rows import BASE, ROWS


class Line(NamedTuple):
    """A line of a table of the paper, and the rows here that test it."""

    about: str
    paper: float
    """PSNR against the paper's whole method, dB, mean of Mip-NeRF 360."""
    more: str
    """The paper's other figures of this line."""
    rows: tuple[str, ...]
    """Rows that test it, those of the paper's own model first."""


# the tables of the paper, line by line; figures of a phone are in frames/s
LINES: dict[str, tuple[Line, ...]] = {
    "ablation": (
        Line(
            "without order independence",
            0.14,
            "684 frames/s, not 1125",
            ("release-sorted", "no-order-independence"),
        ),
        Line(
            "without view dependence",
            -0.44,
            "1227 frames/s",
            ("release-no-view-dependence", "paper-no-view-dependence", "no-view-dependence"),
        ),
        Line(
            "without vector quantisation",
            0.21,
            "841 frames/s, 121 MB, not 4.6",
            ("paper-no-quantization", "no-codes"),
        ),
        Line("w without depth term", -0.09, "", ("paper-no-depth-term", "no-depth-term")),
        Line("w without scale term", -0.04, "", ("paper-no-scale-term", "no-scale-term")),
        Line("SH of degree 0", -0.08, "3.6 MB", ("paper-sh-0", "sh-0")),
        Line("SH of degree 2", 0.01, "7.3 MB", ("paper-sh-2", "sh-2")),
        Line("SH of degree 3", 0.03, "9.6 MB", ("paper-sh-3", "sh-3")),
        Line(
            "without order independence, by the text",
            0.14,
            "684 frames/s, not 1125",
            ("paper-no-order-independence",),
        ),
    ),
    "pruning": (
        Line(
            "no pruning",
            0.10,
            "560k Gaussians, not 470k",
            ("release-no-votes", "paper-no-pruning", "no-pruning"),
        ),
        Line(
            "votes by opacity only",
            -0.28,
            "430k Gaussians",
            ("paper-by-opacity", "by-opacity-once"),
        ),
        Line("votes by scale only", -0.25, "450k Gaussians", ("paper-by-scale", "by-scale-once")),
        Line("vote quantile 0.1", 0.03, "550k Gaussians", ("paper-vote-0.1", "vote-0.1")),
        Line("vote quantile 0.4", -0.65, "340k Gaussians", ("paper-vote-0.4", "vote-0.4")),
        Line("vote quantile 0.6", -1.27, "180k Gaussians", ("paper-vote-0.6", "vote-0.6")),
        Line(
            "votes, on Mini-Splatting",
            -0.03,
            "470k Gaussians, not 580k",
            ("mini-splatting-votes",),
        ),
        Line("MaskGaussian, on Mini-Splatting", -0.08, "840k Gaussians, not 1.21M", ("masks",)),
    ),
    "codebooks": (
        Line(
            "2^6 codewords",
            -1.60,
            "3.84 MB",
            ("release-codebook-6", "paper-codebook-6", "codebook-6"),
        ),
        Line(
            "2^8 codewords",
            -0.29,
            "4.2 MB",
            ("release-codebook-8", "paper-codebook-8", "codebook-8"),
        ),
        Line("2^12 codewords", 0.03, "7.9 MB", ("paper-codebook-12", "codebook-12")),
    ),
    "rivals": (
        Line("SortFreeGS", -0.38, "", ("sort-free-gs",)),
        Line("GES", -0.10, "-0.14 in another table", ("two-pass",)),
        Line("Mini-Splatting, coded", -0.10, "", ("quantized-mini-splatting",)),
        Line("3DGS, coded", -0.11, "", ("quantized-3dgs",)),
    ),
}
PAPER_DELTAS = {row: line.paper for lines in LINES.values() for line in lines for row in line.rows}
ON_MINI_SPLATTING = ("mini-splatting-votes", "masks")
LONG = 10_000  # student steps from which on a comparison counts


def base_of(name: str) -> str:
    """Return the row that a row is compared with."""
    if name in ON_MINI_SPLATTING:
        return "mini-splatting-on"
    for base in ("release", "default"):
        if name.startswith(base):
            return base
    return "paper" if ROWS[name].table == "paper" else BASE


class Claim(NamedTuple):
    """A table or figure of the paper, with the lines that test it."""

    about: str
    paper: str
    """The paper's figures, in dB against its whole method unless stated otherwise."""
    lines: tuple[tuple[str, int], ...] = ()
    """Keys of LINES, with the index of the line; none: nothing here tests it."""


CLAIMS = (
    Claim(
        "without order independence (`release`; by the text)",
        "+0.14",
        (("ablation", 0), ("ablation", 8)),
    ),
    Claim("without view dependence", "-0.44", (("ablation", 1),)),
    Claim("without vector quantisation", "+0.21", (("ablation", 2),)),
    Claim(
        "w without depth term; without scale term",
        "-0.09; -0.04",
        (("ablation", 3), ("ablation", 4)),
    ),
    Claim(
        "SH of degree 0; 2; 3",
        "-0.08; +0.01; +0.03",
        (("ablation", 5), ("ablation", 6), ("ablation", 7)),
    ),
    Claim("no pruning", "+0.10", (("pruning", 0),)),
    Claim(
        "votes by opacity only; by scale only",
        "-0.28; -0.25",
        (("pruning", 1), ("pruning", 2)),
    ),
    Claim(
        "vote quantile 0.1; 0.4; 0.6",
        "+0.03; -0.65; -1.27",
        (("pruning", 3), ("pruning", 4), ("pruning", 5)),
    ),
    Claim(
        "votes; MaskGaussian, on Mini-Splatting",
        "-0.03; -0.08",
        (("pruning", 6), ("pruning", 7)),
    ),
    Claim(
        "codebooks of 2^6; 2^8; 2^12 entries",
        "-1.60; -0.29; +0.03",
        (("codebooks", 0), ("codebooks", 1), ("codebooks", 2)),
    ),
    Claim("SortFreeGS; GES", "-0.38; -0.10 or -0.14", (("rivals", 0), ("rivals", 1))),
    Claim("coded Mini-Splatting; coded 3DGS", "-0.10; -0.11", (("rivals", 2), ("rivals", 3))),
    Claim("Mip-NeRF 360, T&T, DB", "27.12, 23.09, 29.93 dB; 4.6, 2.5, 4.6 MB"),
    Claim("figures of each scene", "bicycle 24.91 to bonsai 31.25 dB"),
    Claim("phone (Snapdragon 8 Gen 3)", "127 frames/s cold, 74 steady; 0.83 W"),
    Claim("time by stage, and with and without sorting", "bicycle 134, 857 frames/s"),
)


class Departure(NamedTuple):
    """A choice of the default that is not the paper's."""

    about: str
    settings: str
    why: str
    without: str
    """The row `default-WITHOUT` is the default without the choice."""
    base: str = "default"
    """The row with the choice, which differs in nothing else."""


DEPARTURES = (
    Departure(
        "weights differ from pixel to pixel, by a depth pass",
        "weighting.depth_pass=true",
        "a lobe knows a direction and no pixel",
        "no-depth-pass",
    ),
    Departure(
        "opacity and phi from lobes, decoded once when the file is opened",
        "view_dependence.kind=latent",
        "a dot product per frame instead of 38,000 multiplications",
        "network",
    ),
    Departure(
        "with a network: each Gaussian keeps a base opacity from the teacher",
        "view_dependence.start_opacity=0, lr.opacities=0.01",
        "a shared network has to learn them again otherwise",
        "network-alone",
        "default-network",
    ),
    Departure(
        "ellipses end at 1/64",
        "weighting.alpha_min=0.015625",
        "a third less area, which takes most of a frame",
        "full-ellipses",
    ),
    Departure(
        "the exponent of w is at most 4",
        "weighting.exponent_max=4",
        "sums in float16; no flashes when the camera passes close to a Gaussian",
        "exponent-80",
    ),
    Departure(
        "distillation on virtual views, in the first half",
        "loss.virtual_view_every=4",
        "between the photos there is nothing else to learn from",
        "no-virtual-views",
    ),
    Departure(
        "coverage before planes is compared",
        "loss.front_weight=0.1",
        "light is not lost in front of surfaces, where meshes and other scenes show it",
        "no-front",
    ),
    Departure(
        "overdraw term",
        "loss.overdraw_weight=5e-5",
        "fewer ellipses per pixel, which makes frames faster",
        "no-overdraw-term",
    ),
    Departure(
        "mean depths are compared, where both cover the pixel",
        "loss.mask_depth=true",
        "a pixel covered in one image only says nothing about depth",
        "all-depths",
    ),
    Departure(
        "two matrices make the colours",
        "color.decoder=linear",
        "smaller and faster to decode",
        "color-networks",
    ),
    Departure(
        "scalar quantisation with learned step sizes",
        "quantization.method=sq, schedule.quantize_from=0.9",
        "files a third smaller",
        "codebooks",
    ),
    Departure(
        "with codebooks: they learn, and indices are assigned again",
        "schedule.reassign_every=25, lr.codebook_factor=1",
        "a small codebook is used better",
        "frozen-codebooks",
        "default-codebooks",
    ),
    Departure(
        "a rate term before quantisation",
        "schedule.rate_from=0.4",
        "smaller files",
        "late-rate-term",
    ),
    Departure(
        "means are rounded while training",
        "quantization.round_means=true",
        "the file's positions are those that were trained",
        "unrounded-means",
    ),
    Departure(
        "8 or 12 votes per interval",
        "pruning.votes_per_interval=12",
        "a vote evaluates all Gaussians",
        "1000-votes",
    ),
    Departure(
        "one photo per step", "views_per_step=1", "more steps in the same time", "three-photos"
    ),
    Departure(
        "learning rates fall",
        "lr.final_factor=0.3",
        "a run of any length ends settled",
        "constant-rates",
    ),
)
