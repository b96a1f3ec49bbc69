"""Draws cameras and points of a capture from two sides, and the points that each photo sees."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from PIL import Image, ImageDraw, ImageFont

from mobilegs.atomic import atomic_path
from mobilegs.capture.mapping import Geometry

PANEL = (620, 480)  # px
BARS = 90  # px, height of the panel with one bar per photo
GAP, LINE = 12, 22
PAPER, INK, FAINT, GRID = (250, 250, 250), (20, 20, 20), (120, 120, 120), (225, 225, 225)
CAMERA, MISSING = (30, 80, 200), (210, 40, 40)
SEEN_BY = (  # fewest photos, colour, legend
    (2, (225, 110, 60), "points seen by 2 photos"),
    (3, (215, 175, 40), "3 or 4"),
    (5, (70, 150, 80), "5 or more"),
)
FRAME_PERCENTILES = (5.0, 95.0)  # of the points; cameras are always inside the frame
SMALL_DOTS_FROM = 30_000  # points, from which on each is one pixel instead of 2 x 2
FRUSTUM_LENGTH = 0.035  # of a panel's width: length of a camera's wedge
CAMERAS_FULL_SIZE = 40  # cameras, above which wedges shrink


def draw_coverage(
    path: Path, geometry: Geometry, *, title: str, points_of_photos: Mapping[str, int]
) -> None:
    """Write the drawing as a PNG file.

    The upper panels show cameras (blue wedges, joined in the order of photo names) and points,
    from above and from the front. The lower panel has one bar per photo: the number of points
    that it sees. `points_of_photos` has all photos in order, with 0 for a photo without a pose.
    """
    right, up, forward = axes_of(geometry.viewmats)
    width = 2 * PANEL[0] + 3 * GAP
    height = LINE + PANEL[1] + BARS + 5 * LINE + 2 * GAP
    picture = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(picture)
    text(draw, (GAP, GAP // 2), title, INK)
    top = LINE + GAP
    for column, (caption, axes) in enumerate(
        (("from above", (right, forward)), ("from the front", (right, up)))
    ):
        left = GAP + column * (PANEL[0] + GAP)
        picture.paste(panel(geometry, np.stack(axes)), (left, top))
        text(draw, (left + 8, top + 6), caption, FAINT)
    at, below = GAP, top + PANEL[1] + 6
    for _, color, words in SEEN_BY:
        draw.ellipse((at, below + 4, at + 9, below + 13), fill=color)
        at = text(draw, (at + 14, below), words, FAINT) + 18
    draw.polygon([(at, below + 9), (at + 12, below + 4), (at + 12, below + 14)], fill=CAMERA)
    text(draw, (at + 18, below), "cameras, which open towards their view", FAINT)
    bars(draw, (GAP, below + 2 * LINE), width - 2 * GAP, points_of_photos)
    with atomic_path(path) as temporary:
        picture.save(temporary, format="PNG")


def axes_of(viewmats: Float[np.ndarray, "n 3 4"]) -> Float[np.ndarray, "3 3"]:
    """Return the right, up and forward unit vectors of the mean camera."""
    up = _unit(-viewmats[:, 1, :3].mean(0), np.array([0.0, -1.0, 0.0]))
    forward = viewmats[:, 2, :3].mean(0)
    forward = forward - up * (forward @ up)
    if np.linalg.norm(forward) < 0.1:  # cameras all around have no mean direction
        forward = viewmats[0, 2, :3] - up * (viewmats[0, 2, :3] @ up)
    forward = _unit(forward, np.cross(up, np.eye(3)[np.abs(up).argmin()]))
    return np.stack([np.cross(forward, up), up, forward])


def panel(geometry: Geometry, axes: Float[np.ndarray, "2 3"]) -> Image.Image:
    """Draw points and cameras along two axes, the second one upwards."""
    rotations = geometry.viewmats[:, :, :3]
    eyes = -np.einsum("nji,nj->ni", rotations, geometry.viewmats[:, :, 3]) @ axes.T
    looks = rotations[:, 2] @ axes.T
    points = geometry.points @ axes.T
    low, high = eyes.min(0), eyes.max(0)
    if len(points):
        framed = np.percentile(points, FRAME_PERCENTILES, axis=0)
        low, high = np.minimum(low, framed[0]), np.maximum(high, framed[1])
    size = np.array(PANEL)
    scale = float((0.86 * size / np.maximum(high - low, 1e-9)).min())

    def place(where: Float[np.ndarray, "k 2"]) -> Float[np.ndarray, "k 2"]:
        return (where - (low + high) / 2) * (scale, -scale) + size / 2

    picture = Image.new("RGB", PANEL, (255, 255, 255))
    draw = ImageDraw.Draw(picture)
    pixels, dot = place(points), 1 if len(points) < SMALL_DOTS_FROM else 0
    for least, color, _ in SEEN_BY:  # points that many photos see are drawn last, on top
        for x, y in pixels[geometry.seen >= least].tolist():
            draw.rectangle((x, y, x + dot, y + dot), fill=color)
    places = place(eyes)
    draw.line([tuple(at) for at in places.tolist()], fill=(170, 190, 235), width=1)
    length = FRUSTUM_LENGTH * PANEL[0] * min(1.0, (CAMERAS_FULL_SIZE / max(len(eyes), 1)) ** 0.5)
    for at, look in zip(places, length * looks * (1, -1), strict=True):
        wedge(draw, at, look)
    draw.rectangle((0, 0, PANEL[0] - 1, PANEL[1] - 1), outline=GRID)
    return picture


def wedge(
    draw: ImageDraw.ImageDraw, at: Float[np.ndarray, "2"], ahead: Float[np.ndarray, "2"]
) -> None:
    """Draw a camera at `at` as a triangle that opens along `ahead`, with a dot at its tip."""
    across = 0.45 * np.array([-ahead[1], ahead[0]])
    corners = [tuple(at), tuple(at + ahead + across), tuple(at + ahead - across)]
    draw.polygon(corners, outline=CAMERA)
    x, y = at.tolist()
    draw.ellipse((x - 2, y - 2, x + 2, y + 2), fill=CAMERA)


def bars(
    draw: ImageDraw.ImageDraw, corner: tuple[int, int], width: int, counts: Mapping[str, int]
) -> None:
    """Draw one bar per photo; a photo without a pose has a full red bar."""
    left, top = corner
    text(draw, corner, "points per photo (red: no pose found)", FAINT)
    top += LINE
    highest = max([10, *counts.values()])
    each = width / max(len(counts), 1)
    for index, count in enumerate(counts.values()):
        share = count / highest if count else 1.0
        x0 = left + index * each
        x1 = max(x0 + 1, x0 + each - (2 if each > 4 else 0))
        fill = CAMERA if count else MISSING
        draw.rectangle((x0, top + BARS * (1 - share), x1, top + BARS), fill=fill)
    names: Sequence[str] = list(counts)
    if names:
        text(draw, (left, top + BARS + 4), names[0], FAINT)
        end = draw.textlength(names[-1], font=font())
        text(draw, (left + width - int(end), top + BARS + 4), names[-1], FAINT)
    most = f"{highest:,}"
    text(draw, (left + width - int(draw.textlength(most, font=font())), corner[1]), most, FAINT)


def text(
    draw: ImageDraw.ImageDraw, at: tuple[int, int], words: str, color: tuple[int, int, int]
) -> int:
    """Draw text, and return the x coordinate of its end."""
    draw.text(at, words, fill=color, font=font())
    return at[0] + int(draw.textlength(words, font=font()))


def font() -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(14)


def _unit(
    vector: Float[np.ndarray, "3"], otherwise: Float[np.ndarray, "3"]
) -> Float[np.ndarray, "3"]:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 1e-9 else otherwise / np.linalg.norm(otherwise)
