"""The contact sheet of a run: photos next to renders and errors."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float, UInt8
from PIL import Image, ImageDraw, ImageFont
from torch import Tensor

from mobilegs.atomic import atomic_path
from mobilegs.data.dataset import Dataset, Frame, View, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import decibels, displayed_colors, psnr, to_bytes
from mobilegs.render.scene import Scene

CELL = 480  # px, maximum width of an image; those up to half of it are enlarged
GAP = 6
CAPTION = 26
ERROR_GAIN = 4  # an error of a quarter of the range is white
PAPER, INK = 250, (20, 20, 20)


@torch.inference_mode()
def contact_sheet(
    path: Path | str, dataset: Dataset, teacher: Scene, student: Scene, *, views: int = 4
) -> None:
    """Write a PNG with a row for each of up to `views` held-back photos, evenly spaced.

    A row shows the photo, the teacher's render, the student's render and the student's absolute
    error, amplified; the captions give PSNR without masked pixels. If no view is held back,
    training views are shown.

    Raises InputError if the capture has no view.
    """
    frames = pick_frames(dataset.test or dataset.train, views)
    if not frames:
        raise InputError("the capture has no view to show on a contact sheet")
    rows = [row_of(load_view(frame), teacher, student) for frame in frames]
    width = max(row.shape[1] for row in rows)
    padded = [
        np.pad(row, ((0, 0), (0, width - row.shape[1]), (0, 0)), constant_values=PAPER)
        for row in rows
    ]
    with atomic_path(path) as temporary:
        Image.fromarray(np.concatenate(padded)).save(temporary, format="PNG")


def pick_frames(frames: Sequence[Frame], count: int) -> list[Frame]:
    """Return at most `count` frames, evenly spaced from the first to the last."""
    if len(frames) <= count:
        return list(frames)
    return [frames[i * (len(frames) - 1) // max(count - 1, 1)] for i in range(count)]


def row_of(view: View, teacher: Scene, student: Scene) -> UInt8[np.ndarray, "h w 3"]:
    """Return the four captioned cells of one view, side by side."""
    photo = view.image.cpu()
    mask = None if view.mask is None else view.mask.cpu() > 0.5
    cells = [(photo, view.name)]
    for name, scene in (("teacher", teacher), ("student", student)):
        camera = view.camera.to(scene.gaussians.means.device)
        drawn = displayed_colors(scene.render(camera).image).cpu()
        cells.append((drawn, f"{name}  {decibels(psnr(drawn, photo, mask))}"))
    error = ERROR_GAIN * (cells[-1][0] - photo).abs()
    if mask is not None:
        error = error * mask[..., None]
    cells.append((error, f"student's error x {ERROR_GAIN}"))
    return np.concatenate([cell(image, caption) for image, caption in cells], axis=1)


def cell(image: Float[Tensor, "h w 3"], caption: str) -> UInt8[np.ndarray, "H W 3"]:
    """Return an image at a readable size, with a border and its caption below."""
    picture = Image.fromarray(to_bytes(image).numpy())
    width, height = picture.size
    if width > CELL:
        picture = picture.resize((CELL, max(1, round(height * CELL / width))), Image.Resampling.BOX)
    elif width <= CELL // 2:
        factor = CELL // width
        picture = picture.resize((width * factor, height * factor), Image.Resampling.NEAREST)
    width, height = picture.size
    paper = Image.new("RGB", (width + 2 * GAP, height + GAP + CAPTION), (PAPER,) * 3)
    paper.paste(picture, (GAP, GAP))
    font = ImageFont.load_default(size=14)
    ImageDraw.Draw(paper).text((GAP, height + GAP + 4), caption, fill=INK, font=font)
    return np.array(paper)
