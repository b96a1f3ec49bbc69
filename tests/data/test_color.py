"""Photos and frames of any colours become sRGB."""

import io
import logging
import os
import shutil
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageCms, PngImagePlugin

from mobilegs.capture.photos import prepare_photos
from mobilegs.capture.video import decoded, find_film, frame_colors, hdr_signal, upright
from mobilegs.data import color, images, load_capture, load_view
from mobilegs.data.color import ADOBE, BT2020, HLG, P3, PQ, Colors, h273_colors, sdr_pixels
from mobilegs.errors import InputError
from tests.support.colmap_capture import write_capture_of_noise

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


# --- photos

SIZE = (32, 24)
RED = (255, 0, 0)
# what a red of sRGB is in other colours, by their specifications
RED_IN_P3, RED_IN_ADOBE, RED_IN_PROPHOTO, RED_IN_BT2020 = (
    (234, 51, 35), (219, 0, 0), (179, 70, 26), (207, 74, 34),
)  # fmt: skip
PROPHOTO = Colors("ProPhoto", (0.3457, 0.3585, 0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001), 1.8)
ADOBE_CHUNKS = ((b"gAMA", (45471,)), (b"cHRM", tuple(round(1e5 * x) for x in ADOBE.xy)))


def icc(colors: Colors | None, *, grey: bool = False) -> bytes:
    assert colors is not None
    return color.icc_profile(colors, grey=grey)


def ink_profile() -> bytes:
    """Return a profile of CMYK in which cyan is a grey of L* 50, and all other inks are black."""
    corners = [255, 128, 0, 0] + [0] * 12  # L* of the inks K, Y, M, C, the last fastest
    grid = [corners[0] if i == 0 else 128 if i == 8 else 0 for i in range(16)]
    curve = bytes(range(256))
    table = b"mft1" + bytes(4) + bytes([4, 3, 2, 0])
    table += struct.pack(">9i", *[65536 * (i % 4 == 0) for i in range(9)])
    table += curve * 4 + b"".join(bytes([level, 128, 128]) for level in grid) + curve * 3
    name = b"desc" + struct.pack(">II", 0, 4) + b"ink\0" + bytes(78)
    tags = {
        b"desc": name,
        b"A2B0": table,
        b"wtpt": b"XYZ " + struct.pack(">4i", 0, 63190, 65536, 54061),
    }
    directory, data, start = struct.pack(">I", len(tags)), b"", 132 + 12 * len(tags)
    for key, value in tags.items():
        directory += struct.pack(">4sII", key, start + len(data), len(value))
        data += value + bytes(-len(value) % 4)
    head = struct.pack(">I4sI", start + len(data), b"", 0x02400000) + b"prtrCMYKLab " + bytes(12)
    head += b"acsp" + bytes(28) + struct.pack(">3i", 63190, 65536, 54061)
    return head.ljust(128, b"\0") + directory + data


def chunks(*given: tuple[bytes, tuple[int, ...]]) -> PngImagePlugin.PngInfo:
    found = PngImagePlugin.PngInfo()
    for name, numbers in given:
        kind = "B" if name == b"cICP" else "I"
        found.add(name, struct.pack(f">{len(numbers)}{kind}", *numbers))
    return found


def exif(**tags: object) -> bytes:
    found = Image.Exif()
    found.get_ifd(0x8769)[0xA001] = tags["space"]
    if "index" in tags:
        found.get_ifd(0x8769)[0xA005] = {1: tags["index"]}
    return found.tobytes()


def flat(value: Any, mode: str = "RGB") -> Image.Image:
    if mode == "I;16":
        return Image.fromarray(np.full((SIZE[1], SIZE[0]), value, np.uint16))
    return Image.new(mode, SIZE, value)


def as_palette(image: Image.Image) -> Image.Image:
    return image.convert("P", palette=Image.Palette.ADAPTIVE)


def chunk(name: bytes, *numbers: int) -> dict[str, object]:
    return {"pnginfo": chunks((name, numbers))}


P3_ICC = {"icc_profile": icc(h273_colors(P3, 13))}
LINEAR_GREY = {"icc_profile": icc(Colors("linear", ADOBE.xy, 1.0), grey=True)}
PHOTO_CASES = {
    "P3 as iPhones write it": ("jpg", flat(RED_IN_P3), P3_ICC, RED),
    "P3 in a TIFF": ("tif", flat(RED_IN_P3), P3_ICC, RED),
    "P3 in a WebP": ("webp", flat(RED_IN_P3), P3_ICC, RED),
    "P3 in an AVIF": ("avif", flat(RED_IN_P3), P3_ICC, RED),
    "P3 with a palette": (
        "png", as_palette(flat(RED_IN_P3)), P3_ICC, RED
    ),
    "grey with a profile of RGB": ("jpg", flat(90, "L"), P3_ICC, (90,) * 3),
    "Adobe RGB by its profile": ("jpg", flat(RED_IN_ADOBE), {"icc_profile": icc(ADOBE)}, RED),
    "Adobe RGB by EXIF": ("jpg", flat(RED_IN_ADOBE), {"exif": exif(space=2)}, RED),
    "Adobe RGB by DCF": ("jpg", flat(RED_IN_ADOBE), {"exif": exif(space=0xFFFF, index="R03")}, RED),
    "sRGB by DCF": ("jpg", flat(RED_IN_ADOBE), {"exif": exif(space=1, index="R98")}, RED_IN_ADOBE),
    "Adobe RGB by chunks": ("png", flat(RED_IN_ADOBE), {"pnginfo": chunks(*ADOBE_CHUNKS)}, RED),
    "sRGB comes before gAMA": (
        "png", flat(RED_IN_ADOBE), {"pnginfo": chunks((b"sRGB", (0,)), *ADOBE_CHUNKS)}, RED_IN_ADOBE
    ),
    "gAMA of sRGB": ("png", flat((9, 80, 200)), chunk(b"gAMA", 45455), (9, 80, 200)),
    "linear by gAMA": ("png", flat((55, 1, 0)), chunk(b"gAMA", 100000), (128, 13, 0)),
    "P3 by cICP": ("png", flat(RED_IN_P3), chunk(b"cICP", 12, 13, 0, 1), RED),
    "cICP comes before iCCP": (
        "png",
        flat(RED_IN_P3),
        P3_ICC | chunk(b"cICP", 1, 13, 0, 1),
        RED_IN_P3,
    ),
    "BT.2020 by cICP": ("png", flat(RED_IN_BT2020), chunk(b"cICP", 9, 13, 0, 1), RED),
    "white of PQ": ("png", flat((148,) * 3), chunk(b"cICP", 9, 16, 0, 1), (255,) * 3),
    "damaged cHRM": ("png", flat((90, 40, 20)), chunk(b"cHRM", *range(9)), (90, 40, 20)),
    "cHRM without colours": ("png", flat((90, 40, 20)), chunk(b"cHRM", *[0] * 8), (90, 40, 20)),
    "ProPhoto": ("png", flat(RED_IN_PROPHOTO), {"icc_profile": icc(PROPHOTO)}, RED),
    "linear grey": (
        "jpg", flat(55, "L"), LINEAR_GREY, (128,) * 3
    ),
    "linear grey with 16 bits": (
        "tif",
        flat(60, "I;16"),
        LINEAR_GREY,
        (3,) * 3,
    ),
    "grey with 16 bits": ("png", flat(257 * 100 + 128, "I;16"), {}, (100,) * 3),
    "grey with 16 bits in a TIFF": ("tif", flat(65535, "I;16"), {}, (255,) * 3),
    "black and white": ("png", flat(1, "1"), {}, (255,) * 3),
    "CMYK": ("jpg", flat((55, 155, 0, 0), "CMYK"), {}, (200, 100, 255)),
    "CMYK with a profile": (
        "tif", flat((255, 0, 0, 0), "CMYK"), {"icc_profile": ink_profile()}, (119,) * 3
    ),
    "CIELAB": (
        "tif",
        ImageCms.applyTransform(
            flat((200, 40, 60)),
            ImageCms.buildTransform(
                ImageCms.createProfile("sRGB"), ImageCms.createProfile("LAB"), "RGB", "LAB"
            ),
        ),
        {},
        (200, 40, 60),
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", PHOTO_CASES)
def test_photos_become_srgb(case: str, tmp_path: Path) -> None:
    suffix, image, options, expected = PHOTO_CASES[case]
    source = tmp_path / f"photo.{suffix}"
    quality = {"quality": 98} if suffix in ("jpg", "webp", "avif") else {}
    quality |= {"subsampling": 0} if suffix == "jpg" and image.mode == "RGB" else {}
    assert image is not None
    image.save(source, **quality, **options)
    posed, opaque = images.read_pixels(source, *SIZE, over=None)
    assert opaque is None
    assert np.abs(posed.astype(int) - expected).max() <= (5 if quality else 2)
    folder = tmp_path / "out"
    [photo] = prepared(source, folder)["photos"]
    with Image.open(folder / photo["name"]) as written:
        assert np.abs(np.asarray(written, int) - expected).max() <= (6 if quality else 2)
        assert not images.colors_name(written)


def prepared(source: Path, folder: Path) -> dict[str, Any]:
    """Return the record of a capture of three copies of a photo, with the first one only."""
    copies = [source, *(source.with_stem(name) for name in ("second", "third"))]
    for copy in copies[1:]:
        shutil.copy(source, copy)
    record = prepare_photos(copies, folder, max_size=200, progress=lambda *_: None)
    return {**record, "photos": record["photos"][:1]}


@pytest.mark.parametrize("suffix", ["avif", "heic"])
def test_code_points_of_avif_and_heic_are_read(suffix: str, tmp_path: Path) -> None:
    if suffix == "avif":
        saved = io.BytesIO()
        flat((200, 40, 60)).save(saved, "AVIF", quality=98)
        data = saved.getvalue()
    else:
        pytest.importorskip("pi_heif", reason="needs the extra capture")
        data = (Path(__file__).parents[1] / "capture" / "photos" / "turned.heic").read_bytes()
    pixels = []
    for name, primaries in (("srgb", 1), ("p3", 12)):
        source = tmp_path / name / f"photo.{suffix}"
        source.parent.mkdir()
        assert data.count(b"colrnclx\0\1") == 1
        source.write_bytes(data.replace(b"colrnclx\0\1", b"colrnclx\0" + bytes([primaries])))
        record = prepared(source, tmp_path / "out" / name)
        assert record["converted"] == ({"Display P3": 3} if primaries == 12 else {})
        with Image.open(tmp_path / "out" / name / record["photos"][0]["name"]) as written:
            pixels.append(np.ptp(np.asarray(written, int), axis=2).mean())
    assert pixels[1] > 1.05 * pixels[0]


def test_a_profile_of_srgb_changes_nothing(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 256, (24, 32, 3)).astype(np.uint8)
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    Image.fromarray(noise).save(tmp_path / "photo.png", icc_profile=srgb)
    found, _ = images.read_pixels(tmp_path / "photo.png", 32, 24, over=None)
    assert (found == noise).all()
    Image.fromarray(noise).save(tmp_path / "photo.jpg", icc_profile=srgb)
    record = prepared(tmp_path / "photo.jpg", tmp_path / "out")
    assert record["converted"] == {}
    assert (tmp_path / "out/photo.jpg").read_bytes() == (tmp_path / "photo.jpg").read_bytes()


def test_transparent_photos_keep_their_alpha(tmp_path: Path) -> None:
    image = flat((*RED_IN_P3, 255), "RGBA")
    image.paste((*RED_IN_P3, 0), (0, 0, 16, 24))
    image.save(tmp_path / "photo.png", icc_profile=icc(h273_colors(P3, 13)))
    pixels, opaque = images.read_pixels(tmp_path / "photo.png", *SIZE, over=None)
    assert opaque is not None and opaque[:, 16:].all() and not opaque[:, :16].any()
    assert np.abs(pixels.astype(int) - RED).max() <= 2


@pytest.mark.parametrize(
    "damaged",
    [b"no profile", icc(ADOBE)[:200], ink_profile(), icc(Colors("one colour", ADOBE.xy, 1e-9))],
    ids=["text", "cut off", "of CMYK", "without contrast"],
)
def test_a_damaged_profile_is_taken_as_srgb_with_a_warning(
    damaged: bytes, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    color.conversion.cache_clear()
    for name in ("a.png", "b.png"):
        flat((90, 40, 20)).save(tmp_path / name, icc_profile=damaged)
        pixels, _ = images.read_pixels(tmp_path / name, *SIZE, over=None)
        assert (pixels == (90, 40, 20)).all()
    assert caplog.text.count("it is taken as sRGB") == 1


def png16(path: Path, *extra: tuple[bytes, bytes]) -> None:
    """Write RGB with 16 bits per channel, which PIL cannot."""
    rows = b"".join(b"\0" + struct.pack(">3H", 900, 600, 300) * SIZE[0] for _ in range(SIZE[1]))
    head = struct.pack(">IIBBBBB", *SIZE, 16, 2, 0, 0, 0)
    found = b"\x89PNG\r\n\x1a\n"
    for name, data in ((b"IHDR", head), *extra, (b"IDAT", zlib.compress(rows)), (b"IEND", b"")):
        crc = zlib.crc32(name + data)
        found += struct.pack(">I", len(data)) + name + data + struct.pack(">I", crc)
    path.write_bytes(found)


def huge_png(path: Path) -> None:
    data = bytearray()
    flat(RED).save(path)
    data = bytearray(path.read_bytes())
    data[16:24] = struct.pack(">II", 16320, 12240)
    data[29:33] = struct.pack(">I", zlib.crc32(data[12:29]))
    path.write_bytes(bytes(data))


@pytest.mark.parametrize(
    ("write", "sentence"),
    [
        (lambda path: Image.new("F", SIZE, 0.5).save(path, "TIFF"), "32 bits per pixel"),
        (lambda path: Image.new("I", SIZE, 5).save(path, "TIFF"), "32 bits per pixel"),
        (lambda path: png16(path, (b"gAMA", struct.pack(">I", 100000))), "is linear with 16 bits"),
        (huge_png, "has 200 megapixels, and at most 180 can be decoded"),
        (lambda path: path.write_bytes(b"no image"), "cannot be read as an image"),
    ],
    ids=["float", "32 bits", "linear with 16 bits", "huge", "text"],
)  # fmt: skip
def test_photos_that_would_lose_are_refused(
    write: Callable[[Path], None], sentence: str, tmp_path: Path
) -> None:
    write(tmp_path / "photo.png")
    with pytest.raises(InputError, match=rf"photo\.png.*{sentence}"):
        images.read_pixels(tmp_path / "photo.png", 8, 6, over=None)
    with pytest.raises(InputError, match=rf"photo\.png.*{sentence}"):
        prepared(tmp_path / "photo.png", tmp_path / "out")


def test_colour_with_16_bits_is_read(tmp_path: Path) -> None:
    png16(tmp_path / "photo.png")
    pixels, _ = images.read_pixels(tmp_path / "photo.png", *SIZE, over=None)
    assert pixels[0, 0].tolist() == [3, 2, 1]


def test_a_huge_jpeg_is_reduced_as_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(images, "REDUCED_FROM", 128 * 96 - 1)
    monkeypatch.setattr(images, "PIXELS_MAX", 80 * 60)
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 1000)  # of PIL, for others
    Image.linear_gradient("L").resize((128, 96)).convert("RGB").save(tmp_path / "photo.jpg")
    pixels, _ = images.read_pixels(tmp_path / "photo.jpg", 30, 22, over=None)
    rows = pixels.astype(float).mean((1, 2))
    assert pixels.shape == (22, 30, 3) and (np.diff(rows) > 5).all()
    with images.open_image(tmp_path / "photo.jpg") as image:
        assert image.size == (128, 96)
        assert images.decode_srgb(image, tmp_path / "photo.jpg", (30, 22)).size == (32, 24)
    with pytest.raises(InputError, match="megapixels"):  # it cannot be reduced to this size
        images.read_pixels(tmp_path / "photo.jpg", 100, 75, over=None)
    assert Image.MAX_IMAGE_PIXELS == 1000


def test_a_capture_with_poses_says_once_what_is_converted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    root = write_capture_of_noise(tmp_path)
    for path in (root / "images").iterdir():
        with Image.open(path) as image:
            Image.new("RGB", image.size, RED_IN_P3).save(path, icc_profile=icc(h273_colors(P3, 13)))
    with caplog.at_level(logging.WARNING):
        dataset = load_capture(root)
    assert caplog.text.count("converted to sRGB: 9 photos in Display P3") == 1
    assert (255 * load_view(dataset.train[0]).image.numpy() - RED).__abs__().max() <= 5
