"""HDR frames of videos become sRGB."""

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mobilegs.capture.video import decoded, find_film, frame_colors, hdr_signal, upright
from mobilegs.data import color
from mobilegs.data.color import BT2020, HLG, PQ, sdr_pixels

TO_BT709 = np.array(  # from linear BT.2020, as in ITU-R BT.2087
    [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]
)
DATA = os.environ.get("MOBILEGS_DATA")


def frame_of(signal: np.ndarray, trc: int, *, full: bool = False) -> Any:
    """Return a stand-in for a frame of PyAV with the R'G'B' signal `[h, w, 3]` in [0, 1]."""
    luma = signal @ color.LUMINANCE
    blue, red = (signal[..., 2] - luma) / 1.8814, (signal[..., 0] - luma) / 1.4746
    planes = np.stack([luma, blue, red])
    if full:
        planes += np.array([0, 0.5, 0.5])[:, None, None]
    else:
        planes *= np.array([219, 224, 224])[:, None, None] / 256
        planes += np.array([16, 128, 128])[:, None, None] / 256
    whole = np.rint(planes * 65536).clip(0, 65535).astype(np.uint16)
    reformatted = SimpleNamespace(to_ndarray=lambda: whole)
    return SimpleNamespace(
        reformat=lambda format: reformatted,
        color_trc=trc,
        color_primaries=BT2020,
        color_range=2 if full else 1,
    )


def shown(frame: Any) -> np.ndarray:
    colors = frame_colors(frame)
    assert colors is not None
    return sdr_pixels(hdr_signal(frame), colors)


@pytest.mark.parametrize(("trc", "white", "full"), [(HLG, 0.75, False), (PQ, 0.5807, True)])
def test_reference_white_is_white_and_black_is_black(trc: int, white: float, full: bool) -> None:
    signal = np.zeros((2, 3, 3))
    signal[0] = white
    found = shown(frame_of(signal, trc, full=full))
    assert (found[0] >= 253).all() and (found[1] == 0).all()


def test_colours_inside_of_srgb_keep_their_hue() -> None:
    linear = np.array([[[0.5, 0.2, 0.1], [0.1, 0.4, 0.3], [0.2, 0.2, 0.6]]])
    wide = linear @ np.linalg.inv(TO_BT709).T * color.WHITE
    power = (wide / 10_000) ** color.M1
    signal = ((color.C1 + color.C2 * power) / (1 + color.C3 * power)) ** color.M2
    found = shown(frame_of(signal, PQ))
    expected = 255 * color.srgb_signal(linear)
    assert np.abs(found - expected).max() <= 1.5


def test_frames_without_a_transfer_function_of_hdr_stay() -> None:
    for trc in (None, 0, 1, 2, 13):
        assert frame_colors(SimpleNamespace(color_trc=trc, color_primaries=1)) is None
    found = frame_colors(SimpleNamespace(color_trc=HLG, color_primaries=BT2020))
    assert found is not None and found.name == "BT.2020 HLG"


@pytest.mark.skipif(DATA is None, reason="needs real captures (MOBILEGS_DATA)")
def test_a_phone_s_hlg_clip_looks_like_its_twin_without_hdr() -> None:
    pytest.importorskip("av", reason="needs the extra capture")
    folder = Path(DATA or "").parent / "cases" / "video"
    if not folder.exists():
        pytest.skip("needs real captures (MOBILEGS_DATA)")
    one, other = (
        np.asarray(upright(next(decoded(folder / name, find_film(folder / name)))), float)
        for name in ("hlg_iphone.mov", "sdr_same.mov")
    )

    def saturation(image: np.ndarray) -> float:
        return float(np.mean(np.ptp(image, axis=2) / image.max(2).clip(1)))

    assert one.max() == other.max() == 255
    assert np.abs(one - other).mean() < 3
    assert saturation(one) == pytest.approx(saturation(other), rel=0.03)
