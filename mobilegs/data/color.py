"""Converts photos and frames of videos to sRGB with 8 bits per channel.

littleCMS converts colour profiles. The transfer functions of HDR are those of ITU-R BT.2100; its
reference white, 203 cd/m^2 in BT.2408, becomes the white of sRGB, and light above it is clipped.
"""

import logging
from functools import lru_cache
from io import BytesIO
from struct import pack
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image, ImageCms

PQ, HLG = 16, 18  # transfer characteristics of ITU-T H.273
HDR = {PQ: "PQ", HLG: "HLG"}
BT709, BT2020, P3 = 1, 9, 12  # primaries of H.273
# name, and x, y of white, red, green and blue
PRIMARIES = {
    BT709: ("BT.709", (0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06)),
    4: ("BT.470 M", (0.31, 0.316, 0.67, 0.33, 0.21, 0.71, 0.14, 0.08)),
    5: ("BT.601 with 625 lines", (0.3127, 0.329, 0.64, 0.33, 0.29, 0.6, 0.15, 0.06)),
    6: ("BT.601 with 525 lines", (0.3127, 0.329, 0.63, 0.34, 0.31, 0.595, 0.155, 0.07)),
    7: ("SMPTE 240M", (0.3127, 0.329, 0.63, 0.34, 0.31, 0.595, 0.155, 0.07)),
    BT2020: ("BT.2020", (0.3127, 0.329, 0.708, 0.292, 0.17, 0.797, 0.131, 0.046)),
    11: ("DCI-P3", (0.314, 0.351, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06)),
    P3: ("Display P3", (0.3127, 0.329, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06)),
    22: ("EBU 3213", (0.3127, 0.329, 0.63, 0.34, 0.295, 0.605, 0.155, 0.077)),
}
# of H.273; others, among them that of BT.709, are displayed as sRGB
GAMMAS = {4: 2.2, 5: 2.8, 8: 1.0, 17: 2.6}
SRGB_GAMMA = 0.45455  # in PNG files that approximate the curve of sRGB

WHITE = 203.0  # cd/m^2
HLG_PEAK, HLG_GAMMA = 1000.0, 1.2  # of the display that HLG is graded for
A, B, C = 0.17883277, 0.28466892, 0.55991073  # of HLG
M1, M2, C1, C2, C3 = 0.1593017578125, 78.84375, 0.8359375, 18.8515625, 18.6875  # of PQ
LUMINANCE = np.array([0.2627, 0.6780, 0.0593])  # of BT.2020
HDR_ROWS = 256  # that are converted at once, which bounds the memory

BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
D50 = np.array([0.9642, 1.0, 0.8249])  # white of ICC profiles
SAME = 2  # levels: a profile that changes no colour by more is sRGB
COARSE = 4  # levels: a first step above black that shows in dark areas
CONTRAST_MIN = 64  # levels between the darkest and the lightest colour of a profile

log = logging.getLogger(__name__)


class Colors(NamedTuple):
    """The colours of an image without a profile.

    Attributes:
        name: for messages.
        xy: chromaticities of white, red, green and blue.
        gamma: exponent from signal to light; 0 is the curve of sRGB.
        hdr: `PQ` or `HLG` in place of `gamma`; else 0.
    """

    name: str
    xy: tuple[float, ...]
    gamma: float = 0.0
    hdr: int = 0


class Conversion(NamedTuple):
    """A conversion to sRGB.

    Attributes:
        name: of the colours that it converts.
        mode: of the images that it converts.
        transform: of littleCMS, to RGB with 8 bits per channel.
        coarse: whether 8 bits per channel are too few for its dark colours.
    """

    name: str
    mode: str
    transform: ImageCms.ImageCmsTransform
    coarse: bool


ADOBE = Colors("Adobe RGB", (0.3127, 0.329, 0.64, 0.33, 0.21, 0.71, 0.15, 0.06), 563 / 256)


def h273_colors(primaries: int, transfer: int) -> Colors | None:
    """Return the colours of code points of ITU-T H.273; None for sRGB, and if they are unknown."""
    hdr = transfer if transfer in HDR else 0
    name, xy = PRIMARIES.get(primaries, PRIMARIES[BT2020 if hdr else BT709])
    gamma = GAMMAS.get(transfer, 0.0)
    if xy == PRIMARIES[BT709][1] and not gamma and not hdr:
        return None
    return Colors(f"{name} {HDR[hdr]}" if hdr else _named(name, gamma), xy, gamma, hdr)


def png_colors(gamma: float | None, xy: tuple[float, ...] | None) -> Colors | None:
    """Return the colours of a PNG after its chunks gAMA and cHRM; None for sRGB."""
    name, srgb = PRIMARIES[BT709]
    xy = xy if xy is not None and len(xy) == len(srgb) else None  # of a damaged chunk
    plain = xy is None or bool(np.abs(np.subtract(xy, srgb)).max() < 2e-3)
    if gamma is None or (plain and abs(gamma - SRGB_GAMMA) < 2e-3):
        exponent = 0.0
    else:
        exponent = 1 / max(gamma, 1e-3)
    if plain and not exponent:
        return None
    return Colors(_named(name if plain else "own primaries", exponent), xy or srgb, exponent)


def _named(name: str, gamma: float) -> str:
    return f"{name} with gamma {gamma:.3g}" if gamma else name


def to_srgb(image: Image.Image, colors: bytes | Colors | None) -> Image.Image:
    """Return a decoded image as RGB with 8 bits per channel in sRGB, without transparency.

    `colors` is its ICC profile, or what else it says of its colours; None is sRGB. Raises
    ValueError for images with 32 bits per channel.
    """
    picture = _opaque(image)
    if isinstance(colors, Colors) and colors.hdr:
        return _hdr_image(_as_rgb(picture), colors)
    found = conversion(colors, picture.mode)
    if found is None:
        return _as_rgb(picture)
    return found.transform.apply(picture if picture.mode == found.mode else _as_rgb(picture))


def name_of(mode: str, colors: bytes | Colors | None) -> str:
    """Return the name of the colours of an image of this mode of PIL; empty for sRGB."""
    if isinstance(colors, Colors) and colors.hdr:
        return colors.name
    found = conversion(colors, _mode(mode))
    if found is not None:
        return found.name
    return "CMYK without a profile" if mode == "CMYK" else ""


def validate_depth(mode: str, colors: bytes | Colors | None) -> None:
    """Raise ValueError for linear colours with 16 bits per channel, of which PIL reads 8."""
    found = conversion(colors, _mode(mode))
    if found is not None and found.coarse:
        raise ValueError("it is linear with 16 bits per channel: save it in sRGB")


def _mode(mode: str) -> str:
    """Return the mode of `_opaque` images: L, I;16, RGB, CMYK or LAB."""
    if mode in ("1", "L", "LA"):
        return "L"
    if mode.startswith("I;16"):
        return "I;16"
    return mode if mode in ("CMYK", "LAB") else "RGB"


def _opaque(image: Image.Image) -> Image.Image:
    """Return an image without its transparency, in one of the modes of `_mode`."""
    mode = _mode(image.mode)
    if image.mode in ("I", "F"):
        raise ValueError("it has 32 bits per pixel: save it with 8 or 16 bits per channel")
    if image.mode == mode:
        return image
    if mode == "I;16":  # in the other order of bytes
        return Image.fromarray(np.asarray(image).astype(np.uint16))
    if mode == "L":
        return image.convert("LA").getchannel("L")
    return image.convert("RGBA").convert("RGB")


def _as_rgb(picture: Image.Image) -> Image.Image:
    if picture.mode == "I;16":  # convert() would clip to 8 bits
        picture = Image.fromarray(((np.asarray(picture) + np.uint32(128)) // 257).astype(np.uint8))
    return picture if picture.mode == "RGB" else picture.convert("RGB")


# --- profiles -------------------------------------------------------------------------------------


@lru_cache(maxsize=64)
def conversion(colors: bytes | Colors | None, mode: str) -> Conversion | None:
    """Return the conversion of images of mode L, I;16, RGB, CMYK or LAB to sRGB.

    None if the colours are those of sRGB. A profile that is damaged, or does not fit the mode, is
    taken as sRGB with a warning. A grey image may have a profile of RGB: then the mode of the
    conversion is RGB.
    """
    if mode == "LAB":
        profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("LAB"))
        return Conversion("CIELAB", mode, _transform(profile, mode), coarse=False)
    if colors is None:
        return None
    name = "a colour profile"
    try:
        if isinstance(colors, Colors):
            name, colors = colors.name, icc_profile(colors, grey=mode in ("L", "I;16"))
        profile = ImageCms.getOpenProfile(BytesIO(colors))
        name = _printable(ImageCms.getProfileDescription(profile)) or name
        space = profile.profile.xcolor_space.strip()  # pyright: ignore
        if mode in ("L", "I;16") and space == "RGB":
            mode = "RGB"
        transform = _transform(profile, mode)
        given, plain = _probe(mode)
        found = np.asarray(transform.apply(given)).reshape(-1, 3).astype(int)
        if np.ptp(found) < CONTRAST_MIN:
            raise ValueError("all its colours are alike")
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError, ArithmeticError) as error:
        log.warning("%s is damaged or of another kind (%s): it is taken as sRGB", name, error)
        return None
    if plain is not None and np.abs(found - plain).max() <= SAME:
        return None
    coarse = mode == "RGB" and found[1].max() > COARSE
    return Conversion(name, mode, transform, coarse=bool(coarse))


def _transform(profile: ImageCms.ImageCmsProfile, mode: str) -> ImageCms.ImageCmsTransform:
    flags = ImageCms.Flags.BLACKPOINTCOMPENSATION
    if mode in ("L", "I;16"):  # the tables that littleCMS makes for grey are wrong by 10 levels
        flags |= ImageCms.Flags.NOOPTIMIZE
    intent = ImageCms.Intent.RELATIVE_COLORIMETRIC
    srgb = ImageCms.createProfile("sRGB")
    return ImageCms.buildTransform(profile, srgb, mode, "RGB", renderingIntent=intent, flags=flags)


def _probe(mode: str) -> tuple[Image.Image, UInt8[np.ndarray, "n 3"] | None]:
    """Return an image of test colours, and the same colours in sRGB (None for CMYK)."""
    grey = np.arange(256, dtype=np.uint8)
    if mode == "I;16":
        return Image.fromarray(grey[None].astype(np.uint16) * 257), np.stack([grey] * 3, axis=1)
    if mode == "L":
        return Image.fromarray(grey[None]), np.stack([grey] * 3, axis=1)
    channels = len(mode)
    levels = np.linspace(0, 255, 9 if mode == "RGB" else 4).round().astype(np.uint8)
    cube = np.stack(np.meshgrid(*[levels] * channels, indexing="ij"), axis=-1)
    colors = cube.reshape(-1, channels)
    if mode == "RGB":
        colors = np.concatenate([np.stack([grey] * 3, axis=1), colors])
    return Image.frombytes(mode, (len(colors), 1), colors.tobytes()), (
        colors if mode == "RGB" else None
    )


def _printable(text: str) -> str:
    return "".join(letter for letter in text if letter.isprintable()).strip()[:60]


def icc_profile(colors: Colors, *, grey: bool) -> bytes:
    """Return an ICC profile, version 4, of these colours. Raises ValueError if they span none."""

    def xyz(value: Float[np.ndarray, "3"]) -> bytes:
        if not np.isfinite(value).all() or np.abs(value).max() > 10:
            raise ValueError("its primaries span no colours")
        return b"XYZ \0\0\0\0" + pack(">3i", *np.rint(65536 * value).astype(int).tolist())

    gamma = [colors.gamma] if colors.gamma else [2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045]
    numbers = [round(65536 * number) for number in gamma]
    curve = b"para\0\0\0\0" + pack(f">HH{len(numbers)}i", 3 if len(numbers) > 1 else 0, 0, *numbers)
    name = colors.name.encode("utf-16-be")
    tags = {
        b"desc": b"mluc\0\0\0\0" + pack(">II4sII", 1, 12, b"enUS", len(name), 28) + name,
        b"wtpt": xyz(D50),
    }
    if grey:
        tags[b"kTRC"] = curve
    else:
        red, green, blue = to_xyz(colors.xy, D50).T
        tags |= {b"rXYZ": xyz(red), b"gXYZ": xyz(green), b"bXYZ": xyz(blue)}
        tags |= {b"rTRC": curve, b"gTRC": curve, b"bTRC": curve}
    table, data = pack(">I", len(tags)), b""
    start = 128 + 4 + 12 * len(tags)
    for key, value in tags.items():
        table += pack(">4sII", key, start + len(data), len(value))
        data += value + bytes(-len(value) % 4)
    kind = b"GRAY" if grey else b"RGB "
    head = pack(">I4sI4s4s4s", start + len(data), bytes(4), 0x04300000, b"mntr", kind, b"XYZ ")
    head += bytes(12) + b"acsp" + bytes(28) + xyz(D50)[8:]
    return head.ljust(128, b"\0") + table + data


def to_xyz(
    xy: tuple[float, ...], white: Float[np.ndarray, "3"] | None = None
) -> Float[np.ndarray, "3 3"]:
    """Return the matrix from linear RGB with these chromaticities to XYZ.

    They are those of white, red, green and blue, x and y. With `white`, XYZ is adapted to it by
    Bradford's method. Raises ValueError if the chromaticities span no colours.
    """
    x, y = np.array(xy, float).reshape(4, 2).T
    if not (y > 1e-5).all():
        raise ValueError("its primaries span no colours")
    own, red, green, blue = np.stack([x / y, np.ones(4), (1 - x - y) / y], axis=1)
    primaries = np.stack([red, green, blue], axis=1)
    matrix = primaries * np.linalg.solve(primaries, own)
    if white is None:
        return matrix
    scale = np.diag((BRADFORD @ white) / (BRADFORD @ own))
    return np.linalg.solve(BRADFORD, scale @ BRADFORD) @ matrix


# --- HDR ------------------------------------------------------------------------------------------


def _hdr_image(picture: Image.Image, colors: Colors) -> Image.Image:
    signal = np.asarray(picture)
    found = np.empty_like(signal)
    for row in range(0, len(signal), HDR_ROWS):
        rows = slice(row, row + HDR_ROWS)
        found[rows] = sdr_pixels(signal[rows] / 255, colors)
    return Image.fromarray(found)


def sdr_pixels(signal: Float[np.ndarray, "h w 3"], colors: Colors) -> UInt8[np.ndarray, "h w 3"]:
    """Return an HDR signal, R'G'B' in [0, 1], as sRGB with 8 bits per channel."""
    light = (pq_light if colors.hdr == PQ else hlg_light)(signal)
    to_bt709 = np.linalg.solve(to_xyz(PRIMARIES[BT709][1]), to_xyz(colors.xy))
    return np.rint(255 * srgb_signal((light @ to_bt709.T / WHITE).clip(0, 1))).astype(np.uint8)


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
