"""Converts frames of HDR videos, as phones record them, to sRGB.

The transfer functions and BT.2020 are those of ITU-R BT.2100; reference white, 203 cd/m^2, is that
of BT.2408 and becomes the white of sRGB. Light above it is clipped.
"""

from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

PQ, HLG = 16, 18  # transfer characteristics of ITU-T H.273
BT2020 = 9  # primaries and matrix of H.273
WHITE = 203.0  # cd/m^2
HLG_PEAK, HLG_GAMMA = 1000.0, 1.2  # of the display that HLG is graded for
A, B, C = 0.17883277, 0.28466892, 0.55991073  # of HLG
M1, M2, C1, C2, C3 = 0.1593017578125, 78.84375, 0.8359375, 18.8515625, 18.6875  # of PQ
LUMINANCE = np.array([0.2627, 0.6780, 0.0593])  # of BT.2020
TO_BT709 = np.array(
    [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]
)
NAMES = {PQ: "PQ", HLG: "HLG"}


def hdr_kind(frame: Any) -> str:
    """Return `HLG` or `PQ` for a frame with that transfer function, else nothing."""
    return NAMES.get(int(frame.color_trc or 0), "")


def sdr_pixels(frame: Any) -> UInt8[np.ndarray, "h w 3"]:
    """Return an HDR frame of PyAV as sRGB with 8 bits per channel, not rotated."""
    planes = frame.reformat(format="yuv444p16le").to_ndarray().astype(np.float64)
    if planes.shape[0] != 3:
        planes = np.moveaxis(planes, -1, 0)
    luma, blue, red = planes / (1 << 16)
    if int(frame.color_range or 0) == 2:  # full range
        luma, blue, red = luma, blue - 0.5, red - 0.5
    else:
        luma = (luma - 16 / 256) * 256 / 219
        blue, red = ((chroma - 0.5) * 256 / 224 for chroma in (blue, red))
    signal = np.stack(
        [luma + 1.4746 * red, luma - 0.164553 * blue - 0.571353 * red, luma + 1.8814 * blue], axis=2
    ).clip(0, 1)
    light = (pq_light if int(frame.color_trc) == PQ else hlg_light)(signal)
    if int(frame.color_primaries or BT2020) == BT2020:
        light = light @ TO_BT709.T
    return np.rint(255 * srgb_signal((light / WHITE).clip(0, 1))).astype(np.uint8)


def hlg_light(signal: Float[np.ndarray, "h w 3"]) -> Float[np.ndarray, "h w 3"]:
    """Return the light of a display of 1,000 cd/m^2 for an HLG signal in [0, 1], in cd/m^2."""
    scene = np.where(signal <= 0.5, signal**2 / 3, (np.exp((signal - C) / A) + B) / 12)
    luminance = np.maximum(scene @ LUMINANCE, 1e-9)[:, :, None]
    return HLG_PEAK * scene * luminance ** (HLG_GAMMA - 1)


def pq_light(signal: Float[np.ndarray, "h w 3"]) -> Float[np.ndarray, "h w 3"]:
    """Return the light for a PQ signal in [0, 1], in cd/m^2."""
    power = signal ** (1 / M2)
    return 10_000 * (np.maximum(power - C1, 0) / (C2 - C3 * power)) ** (1 / M1)


def srgb_signal(light: Float[np.ndarray, "h w 3"]) -> Float[np.ndarray, "h w 3"]:
    """Return the sRGB signal of linear light in [0, 1]."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
